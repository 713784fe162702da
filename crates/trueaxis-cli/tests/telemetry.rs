//! `trueaxis telemetry`.

use trueaxis::Fault;
use trueaxis::telemetry::{AxisFrame, ContourFrame, DynamicFrame, FRAME_BYTES, FRAME_VERSION, Frame, Status};
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

fn frame(sequence: u32, axes: usize, dynamic: bool) -> Frame {
    let contour = |by: f32| ContourFrame { error: 0.5 * by, normal: 0.25 * by, binormal: -by, lag: 3.0, flags: 1 };
    let of = |at: usize| AxisFrame {
        command: 10.0 * at as f64 + 0.1,
        feedback: 10.0 * at as f64,
        correction: 0.125,
        dynamic: dynamic.then_some(DynamicFrame {
            sent: 0.5,
            feed_forward: 1.5,
            feedback: 2.5,
            crosstalk: 3.5,
            learned: 4.5,
        }),
    };
    Frame {
        version: FRAME_VERSION,
        sequence,
        machine_id: 0xfeed_beef,
        tables_crc: 7,
        fault: Fault::None,
        fault_axis: 0,
        status: Status(9),
        limited: 2,
        at_edge: 1,
        axes: (0..axes).map(of).collect(),
        tip: contour(1.0),
        encoder: contour(2.0),
        orientation: 0.0,
        orientation_flags: 32,
    }
}

fn stream(frames: impl IntoIterator<Item = Frame>) -> Vec<u8> {
    let mut bytes = Vec::new();
    for frame in frames {
        let mut buffer = [0; FRAME_BYTES];
        bytes.extend_from_slice(frame.encode(&mut buffer).unwrap());
    }
    bytes
}

#[test]
fn every_field_of_a_record_is_a_column() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("t.bin", stream([frame(4, 3, false), frame(5, 3, false)]));
    folder.good(&["telemetry", "t.bin", "-o", "t.csv"]);
    let row = "4276993775,7,0,0,9,2,1,0.1,0,0.125,10.1,10,0.125,20.1,20,0.125,0.5,0.25,-1,3,1,1,0.5,-2,3,1,0,32\n";
    assert_eq!(
        folder.read("t.csv"),
        format!(
            "sequence,machine_id,tables_crc,fault,fault_axis,status,limited,at_edge,x_command_mm,x_feedback_mm,x_correction_mm,\
             y_command_mm,y_feedback_mm,y_correction_mm,z_command_mm,z_feedback_mm,z_correction_mm,tip_error_mm,tip_normal_mm,\
             tip_binormal_mm,tip_lag_mm,tip_flags,encoder_error_mm,encoder_normal_mm,encoder_binormal_mm,encoder_lag_mm,\
             encoder_flags,orientation_rad,orientation_flags\n4,{row}5,{row}"
        )
    );
}

#[test]
fn rotary_axes_and_dynamic_corrections_have_their_columns() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("t.bin", stream([frame(0, 5, false), frame(1, 5, true)]));
    folder.bad(&["telemetry", "t.bin", "-o", "t.csv"], &["--axes", "5 axes", "XYZAC"]);
    for axes in ["XYZA", "XYZCA", "XYZA1", "XYZAA"] {
        folder.bad(&["telemetry", "t.bin", "-o", "t.csv", "--axes", axes], &["--axes", axes, "5 letters"]);
    }
    folder.good(&["telemetry", "t.bin", "-o", "t.csv", "--axes", "xyzac"]);
    let (header, rows) = trueaxis_testing::command::csv(&folder.read("t.csv"));
    let names: Vec<_> = header.split(',').collect();
    let value = |row: usize, name: &str| rows[row][names.iter().position(|of| *of == name).unwrap()];
    assert_eq!((value(0, "c_command_deg"), value(0, "c_dynamic_deg"), value(1, "c_dynamic_deg")), (40.1, 0.0, 0.5));
    assert_eq!((value(1, "a_contour_feedback_deg"), value(1, "a_learned_deg")), (2.5, 4.5));
}

#[test]
fn lost_records_are_reported_and_the_rest_written() {
    let folder = Folder::new(TRUEAXIS);
    let mut bytes = stream([frame(u32::MAX, 3, false), frame(0, 3, false), frame(4, 3, false)]);
    bytes.splice(0..0, *b"garbage\0");
    folder.write("t.bin", bytes);
    // A controller restart is not a gap.
    folder.write("u.bin", stream([frame(9, 3, false), frame(0, 3, false)]));
    let [_, stderr] = folder.both(&["telemetry", "t.bin", "u.bin", "-o", "t.csv"]);
    assert!(
        stderr.contains("t.bin: 1 damaged frame") && stderr.contains("t.bin: 3 records missing in 1 gap"),
        "{stderr}"
    );
    assert!(!stderr.contains("u.bin:") && stderr.contains("5 cycles"), "{stderr}");
    let text = folder.read("t.csv");
    assert!(text.starts_with("file,sequence,") && text.lines().nth(4).unwrap().starts_with("u.bin,9,"), "{text}");
}

#[test]
fn files_without_telemetry_are_refused_and_nothing_is_written() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("t.bin", stream([frame(0, 3, false)]));
    let mut other = frame(0, 3, false);
    other.machine_id = 1;
    folder.write("other.bin", stream([other]));
    folder.write("none.bin", b"what is this?\0");
    folder.bad(&["telemetry", "none.bin", "-o", "t.csv"], &["none.bin", "no whole record"]);
    folder.bad(&["telemetry", "lost.bin", "-o", "t.csv"], &["lost.bin"]);
    folder.bad(&["telemetry", "t.bin", "other.bin", "-o", "t.csv"], &["other.bin", "machine 00000001", "feedbeef"]);
    folder.bad(&["telemetry", "t.bin", "-o", "t.txt"], &["t.txt", ".parquet or .csv"]);
    folder.bad(&["telemetry", "t.bin", "-o", "t.bin"], &["an input is never written"]);
    folder.bad(&["telemetry", "t.bin", "-o", "t.csv", "--revolutions", "t.bin"], &["an input is never written"]);
    assert!(!folder.has("t.csv") && !folder.has("t.txt"));
}
