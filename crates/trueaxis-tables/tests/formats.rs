//! Import and export: published examples, golden files, round trips, refusals.

use crate::golden_file::golden;
use crate::small_machine::machine;
use std::f64::consts::PI;
use std::path::Path;

use trueaxis::machine::Axis;
use trueaxis::machine::PeriodicSettings;
use trueaxis_tables::error::FileError;
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::linuxcnc::CompFileType;
use trueaxis_tables::formats::{ExportOptions, Exported, Format, Imported, Loss, export, import};
use trueaxis_tables::{Machine, Table};
use trueaxis_testing::noise::Noise;

const TYPE_0: Format = Format::LinuxCnc(CompFileType::Positions);
const TYPE_1: Format = Format::LinuxCnc(CompFileType::Trims);

fn read(format: Format, text: &str, axis: Option<Axis>) -> Imported {
    import(format, text, Path::new("in"), axis).unwrap()
}

fn refusal(format: Format, text: &str, axis: Option<Axis>) -> FileError {
    import(format, text, Path::new("in"), axis).unwrap_err()
}

fn dropping(axis: Option<Axis>) -> ExportOptions {
    ExportOptions { loss: Loss::Drop, axis, ..ExportOptions::default() }
}

fn write(format: Format, machine: &Machine, options: &ExportOptions) -> Exported {
    export(format, machine, options).unwrap()
}

#[track_caller]
fn micro(table: &Table, row: usize, component: usize, forward: f64, reverse: f64) {
    let scale = if component < 3 { 1e3 } else { 1e6 };
    let row = &table.rows[row];
    assert!((row.forward[component] * scale - forward).abs() < 1e-6, "{:?}", row.forward);
    assert!((row.reverse[component] * scale - reverse).abs() < 1e-6, "{:?}", row.reverse);
}

/// The type 0 example of LinuxCNC's INI documentation, and the same errors as the trims that usrmotLoadComp derives from it.
#[test]
fn linuxcnc_documented_example() {
    let type_0 = "-1.000 -1.005 -0.995\n0.000 0.002 -0.003\n1.000 1.003 0.998\n";
    let type_1 = "-1.000 0.005 -0.005\n0.000 -0.002 0.003\n1.000 -0.003 0.002\n";
    for (format, text) in [(TYPE_0, type_0), (TYPE_1, type_1)] {
        let imported = read(format, text, Some(Axis::Y));
        let (axis, table) = &imported.tables[0];
        assert_eq!(*axis, Axis::Y);
        assert_eq!(table.given, [false, true, false, false, false, false]);
        assert!(table.bidirectional);
        micro(table, 0, 1, -5.0, 5.0);
        micro(table, 1, 1, 2.0, -3.0);
        micro(table, 2, 1, 3.0, -2.0);
    }
}

#[test]
fn linuxcnc_refuses_what_would_be_cut_off() {
    let long = format!("0 0 0\n1 0 0{}\n", " ".repeat(260));
    let many: String = (0..257).map(|i| format!("{i} {i} {i}\n")).collect();
    for (text, line, fragment) in [
        ("# X axis\n0 0 0\n1 1 1\n", Some(1), "three numbers"),
        ("0 0 0\n\n1 1 1\n", Some(2), "blank line"),
        ("0,0,0\n1,1,1\n", Some(1), "three numbers"),
        ("0 0\n1 1\n", Some(1), "three numbers"),
        ("0 0 0 0\n1 1 1 1\n", Some(1), "three numbers"),
        ("0 0 0\n1 1 x\n", Some(2), "a number"),
        ("0 0 0\n1 nan 1\n", Some(2), "finite"),
        ("0 0 0\n1 1 1\n1 1 1\n", Some(3), "increasing"),
        ("\u{feff}0 0 0\n1 1 1\n", Some(1), "byte order mark"),
        ("0 0 0\n", None, "at least two"),
        ("", None, "at least two"),
        (&long, Some(2), "bytes"),
        (&many, Some(257), "256"),
    ] {
        let error = refusal(TYPE_0, text, Some(Axis::X));
        assert_eq!(error.line, line, "{error}");
        assert!(error.to_string().contains(fragment), "{error}");
    }
    assert!(refusal(TYPE_0, "0 0 0\n1 1 1\n", None).found.contains("no axis"));
    // Lines that LinuxCNC reads without loss are accepted: trailing blank lines, a comment after the third number.
    read(TYPE_0, "0 0 0 # home\r\n  1\t1 1\r\n\r\n", Some(Axis::X));
}

/// The example of the SINUMERIK 840D sl function manual (K3, 4.4.2.3): X1, −200 to 600 mm in steps of 1 mm, +3, +10, +12 µm …
/// A positive value moves the axis in negative direction, so it compensates a positive error.
#[test]
fn siemens_manual_example() {
    let mut text = String::from("%_N_AX_EEC_INI\nCHANDATA(1)\n");
    for n in 0..=800 {
        let value = [0.003, 0.01, 0.012].get(n).copied().unwrap_or(0.0);
        text.push_str(&format!("$AA_ENC_COMP[0,{n},X1]={value} ; point\n"));
    }
    text.push_str("$AA_ENC_COMP_STEP[0,X1]=1.0\nN20 $AA_ENC_COMP_MIN[0,X1] = -200.0\n");
    text.push_str("$AA_ENC_COMP_MAX[0,X1]=600.0\n$AA_ENC_COMP_IS_MODULO[0,X1]=0\nM17\n");
    let imported = read(Format::Siemens, &text, None);
    let (axis, table) = &imported.tables[0];
    assert_eq!((*axis, table.rows.len(), table.bidirectional), (Axis::X, 801, false));
    assert_eq!((table.rows[0].position, table.rows[2].position, table.rows[800].position), (-200.0, -198.0, 600.0));
    micro(table, 0, 0, 3.0, 3.0);
    micro(table, 1, 0, 10.0, 10.0);
    micro(table, 2, 0, 12.0, 12.0);
}

#[test]
fn siemens_refusals() {
    let head = "$AA_ENC_COMP_STEP[0,C1]=120\n$AA_ENC_COMP_MIN[0,C1]=0\n$AA_ENC_COMP_MAX[0,C1]=360\n";
    let points = "$AA_ENC_COMP[0,0,C1]=0.001\n$AA_ENC_COMP[0,1,C1]=0.002\n$AA_ENC_COMP[0,2,C1]=0\n";
    let whole = format!("{head}{points}$AA_ENC_COMP[0,3,C1]=0.001\n");
    let table = read(Format::Siemens, &format!("{whole}$AA_ENC_COMP_IS_MODULO[0,C1]=1\n"), None).tables.remove(0).1;
    assert!((table.rows[1].forward[5] - 0.002 * PI / 180.0).abs() < 1e-15);
    for (text, fragment) in [
        (format!("{head}{points}"), "no point 3"),
        (format!("{head}{points}$AA_ENC_COMP[0,3,C1]=0.002\n"), "full circle"),
        (format!("{whole}$AA_ENC_COMP[0,4,C1]=0\n"), "at most 3"),
        (format!("{whole}$AA_ENC_COMP[0,3,C1]=0\n"), "already on line 7"),
        (format!("{whole}$AA_ENC_COMP_MAX[1,C1]=0\n"), "second measuring system"),
        (format!("{whole}$AA_ENC_COMP_IS_MODULO[0,C1]=2\n"), "0 or 1"),
        (format!("{whole}G1 X10\n"), "needed $AA_ENC_COMP"),
        (format!("{whole}$AA_ENC_COMP[0,1,Q1]=0\n"), "axis \"Q1\""),
        (format!("{whole}$AA_ENC_COMP[0,-1,C1]=0\n"), "whole number"),
        (whole.replace("STEP[0,C1]=120", "STEP[0,C1]=100"), "steps between"),
        (whole.replace("STEP[0,C1]=120", "STEP[0,C1]=-120"), "more than 0"),
        (whole.replace("$AA_ENC_COMP_MIN[0,C1]=0\n", ""), "_MIN"),
        (whole.replace("C1", "X1") + "$AA_ENC_COMP_IS_MODULO[0,X1]=1\n", "a rotary axis"),
        (String::from("; nothing\n"), "no $AA_ENC_COMP"),
    ] {
        let error = refusal(Format::Siemens, &text, None);
        assert!(error.to_string().contains(fragment), "{fragment}: {error}");
    }
    assert!(refusal(Format::Siemens, &whole, Some(Axis::X)).to_string().contains("axis X"));
}

/// Sag of Z over Y and straightness of X over Y, each in its own steps, and Y's own error separately for each direction: one
/// table of Y, linear between all points, with Z in the chain to correct it.
#[test]
fn siemens_sag_over_another_axis() {
    let table = |number: u32, output: char, direction: i32, step: f64, values: &[f64]| {
        let mut text = String::new();
        for (point, value) in values.iter().enumerate() {
            text.push_str(&format!("$AN_CEC [{number},{point}]={value} ; point\n"));
        }
        text.push_str(&format!("$AN_CEC_INPUT_AXIS[{number}]=(Y1)\n$AN_CEC_OUTPUT_AXIS[{number}] = ({output}1)\n"));
        text.push_str(&format!("$AN_CEC_STEP[{number}]={step}\n$AN_CEC_MIN[{number}]=0\n$AN_CEC_MAX[{number}]=100\n"));
        text.push_str(&format!("$AN_CEC_DIRECTION[{number}]={direction}\n$AN_CEC_IS_MODULO[{number}]=0\n"));
        text + &format!("$AN_CEC_MULT_BY_TABLE[{number}]=0\n")
    };
    let sag = table(0, 'Z', 0, 50.0, &[0.0, -0.010, -0.030]);
    let all = [
        sag.clone(),
        table(1, 'X', 0, 100.0, &[0.0, 0.004]),
        table(2, 'Y', 1, 100.0, &[0.0, 0.002]),
        table(3, 'Y', -1, 100.0, &[0.005, 0.007]),
    ];
    let imported = read(Format::Siemens, &format!("%_N_NC_CEC_INI\nCHANDATA(1)\n{}M17\n", all.concat()), None);
    let [(Axis::Y, y)] = imported.tables.as_slice() else { panic!("{imported:?}") };
    assert_eq!((y.given, y.rows.len(), y.bidirectional), ([true, true, true, false, false, false], 3, true));
    assert_eq!(imported.notes[0], "$AN_CEC table 0, of Z over Y, is EZY");
    for (row, [x, forward, reverse, z]) in
        [[0.0, 0.0, 5.0, 0.0], [2.0, 1.0, 6.0, -10.0], [4.0, 2.0, 7.0, -30.0]].iter().enumerate()
    {
        micro(y, row, 0, *x, *x);
        micro(y, row, 1, *forward, *reverse);
        micro(y, row, 2, *z, *z);
    }
    let toml = &read(Format::Siemens, &sag, None).machine_files("m")[0].1;
    assert!(toml.contains("chain = \"w b Y Z t\""), "{toml}");
    for (text, fragment) in [
        (sag.replace("(Y1)", "(AX2)"), "(Y1), also in place of (AX2)"),
        (sag.replace("MULT_BY_TABLE[0]=0", "MULT_BY_TABLE[0]=2"), "surface over both axes"),
        (sag.replace("IS_MODULO[0]=0", "IS_MODULO[0]=1"), "a cyclic table of axis Y"),
        (sag.replace("DIRECTION[0]=0", "DIRECTION[0]=2"), "0, 1 or -1"),
        (sag.replace("(Z1)", "(C1)"), "rotary axis C over Y"),
        (sag.replace("$AN_CEC_INPUT_AXIS[0]=(Y1)\n", ""), "no $AN_CEC_INPUT_AXIS[0]"),
        (format!("{sag}{}", table(1, 'Z', 1, 50.0, &[0.0; 3])), "which the control adds"),
        (format!("{sag}$AN_CEC_MIN[0]=0\n"), "already on line"),
    ] {
        let error = refusal(Format::Siemens, &text, None);
        assert!(error.to_string().contains(fragment), "{fragment}: {error}");
    }
}

/// Two arguments make a grid: EXX and EYX of X as it sags with Z, with EXZ added to EXX.
#[test]
fn isg_over_two_axes_is_a_grid() {
    let text = "Z X EXX EYX EXZ EAX\n0 0 0.002 0.001 0 0\n0 10 0 -0.01 0 0\n100 10 0.003 -0.009 0.001 0\n100 0 0.001 0.002 0 0\n";
    let imported = read(Format::Isg, text, None);
    let [grid] = imported.grids.as_slice() else { panic!("{imported:?}") };
    let source = grid.source();
    assert_eq!(source.nodes, [vec![0.0, 10.0], vec![], vec![0.0, 100.0]]);
    assert_eq!(source.given, [true, true, false, false, false, false]);
    let values: Vec<[f64; 2]> = source.values.iter().map(|at| [at[0], at[1]]).collect();
    assert_eq!(values, [[0.002, 0.001], [0.001, 0.002], [0.0, -0.01], [0.004, -0.009]]);
    assert!(imported.machine_files("m")[0].1.contains("axes = [\"X\", \"Z\"]"));
}

/// Instrument reports may begin at the far end.
#[test]
fn linuxcnc_lines_in_another_order_are_sorted_and_reported() {
    let down = read(TYPE_0, "300 300.010 300.012\n100 100.002 100.004\n0 0 0.002\n", Some(Axis::X));
    let up = read(TYPE_0, "0 0 0.002\n100 100.002 100.004\n300 300.010 300.012\n", Some(Axis::X));
    assert_eq!(down.tables, up.tables);
    assert!(up.notes.is_empty() && down.notes[0].contains("do not increase"), "{:?}", down.notes);
}

/// One direction of approach gives a table for both, and a circle that lacks its last line stays open: notes report both.
#[test]
fn missing_directions_and_closing_points_are_reported() {
    let imported = read(Format::Iso230_2, "C_deg,+1,+2\n0,1,1.5\n90,10,11\n180,3,3\n270,4,5\n350,1,2\n", None);
    assert!(!imported.tables[0].1.bidirectional);
    let notes = imported.notes.join("\n");
    assert!(notes.contains("one direction of approach") && notes.contains("backlash_urad"), "{notes}");
    assert!(
        notes.contains("ends at 350 degrees and does not wrap") && notes.contains("a line at 360 degrees"),
        "{notes}"
    );
    for quiet in ["C_deg,+1,-1\n0,1,5\n180,3,8\n360,1,5\n", "C_deg,+1,-1\n-30,1,5\n0,3,8\n30,1,5\n"] {
        assert!(read(Format::Iso230_2, quiet, None).notes.is_empty());
    }
}

/// The examples of the ISG and Beckhoff documentation, with a squareness that this crate has.
#[test]
fn isg_documented_example() {
    let text = "// Location errors\nA0Z\tX0X\tX0C\n0.00002\t0\t0.2\n#\n\
        X      EXX    EYX    EZX    EAX    EBX    ECX\n\
        0.0    0.02   0.01   0.07   0.00   0.0042 0.003\n\
        10.0   0.00   -0.1   0.01   0.00   0.0011 0.002 // last\n\
        #\nECC;C\n0.001;0\n0.002;90\n";
    let imported = read(Format::Isg, text, None);
    assert_eq!(imported.location.a0z, 0.00002);
    assert_eq!(imported.location.rotary[2][0], 0.2);
    let [(Axis::X, x), (Axis::C, c)] = imported.tables.as_slice() else { panic!("{imported:?}") };
    assert_eq!((x.given, c.given), ([true; 6], [false, false, false, false, false, true]));
    assert_eq!(x.rows[0].forward, [0.02, 0.01, 0.07, 0.0, 0.0042, 0.003]);
    assert_eq!(x.rows[1].reverse, [0.0, -0.1, 0.01, 0.0, 0.0011, 0.002]);
    assert_eq!((c.rows[1].position, c.rows[1].forward[5]), (90.0, 0.002));
}

/// Values in mm and rad become the doubles that a table in µm and µrad gives for the same decimals.
#[test]
fn isg_values_are_written_as_short_as_they_were() {
    let imported = read(Format::Isg, "X\tEXX\tEBX\n0\t-0.000952\t0.000016312\n1\t0.009578\t-0.000002671\n", None);
    let (_, csv) = imported.machine_files("m").into_iter().find(|(name, _)| name == "x.csv").unwrap();
    assert!(csv.ends_with("\n0,-0.952,16.312\n1,9.578,-2.671\n"), "{csv}");
}

/// Positions of a spacing, means of runs and a mesh's own points end at the sixth decimal.
#[test]
fn sums_and_means_are_written_without_rounding_noise() {
    let csv = |format, text: &str, axis, name: &str| {
        let files = read(format, text, axis).machine_files("m");
        files.into_iter().find(|(own, _)| own == name).unwrap().1
    };
    let spaced = "$AA_ENC_COMP_STEP[0,AX1]=33.3\n$AA_ENC_COMP_MIN[0,AX1]=-0.7\n$AA_ENC_COMP_MAX[0,AX1]=99.2\n\
        $AA_ENC_COMP[0,0,AX1]=0.0011\n$AA_ENC_COMP[0,1,AX1]=0.0013\n$AA_ENC_COMP[0,2,AX1]=-0.0017\n\
        $AA_ENC_COMP[0,3,AX1]=0.0007\n";
    let siemens = csv(Format::Siemens, spaced, Some(Axis::X), "x.csv");
    assert_eq!(siemens, "X_mm,EXX_um\n-0.7,1.1\n32.6,1.3\n65.9,-1.7\n99.2,0.7\n");
    let runs = "X_mm,run,direction,deviation_um\n0,1,+,1.1\n0,1,-,2.3\n0,2,+,1.2\n0,2,-,2.2\n0,3,+,1.2\n0,3,-,2.2\n\
        50,1,+,3.1\n50,1,-,4.3\n50,2,+,3.2\n50,2,-,4.2\n50,3,+,3.2\n50,3,-,4.1\n";
    let means = csv(Format::Iso230_2, runs, None, "x.csv");
    assert_eq!(means, "X_mm,EXX_fwd_um,EXX_rev_um\n0,1.166667,2.233333\n50,3.166667,4.2\n");
    let mesh = "[bed_mesh default]\nversion = 1\npoints =\n  0.0125, 0.0333\n  0.01, 0.07\nx_count = 2\ny_count = 2\n\
        mesh_x_pps = 2\nmesh_y_pps = 0\nalgo = lagrange\ntension = 0.2\nmin_x = 10.0\nmax_x = 190.0\nmin_y = 10.0\n\
        max_y = 190.0\n";
    let mesh = csv(Format::BedMesh, mesh, None, "grid.csv");
    assert!(mesh.lines().skip(1).flat_map(|line| line.split(',')).all(|number| number.len() <= 9), "{mesh}");
}

#[test]
fn isg_refusals() {
    for (text, line, fragment) in [
        ("C X EXX\n0 0 0\n0 10 0\n", Some(1), "over X and C"),
        ("Z X EXX\n0 0 0\n0 10 0\n9 0 0\n", None, "none at X 10, Z 9"),
        ("Z X EAX\n0 0 0\n0 10 1e-5\n9 0 0\n9 10 0\n", Some(3), "a table over one axis"),
        ("X EXX EXY\n0 0 0\n1 0 0\n", Some(1), "errors of axis X"),
        ("X EXX\n0 0\n1 0 0\n", Some(3), "3 values"),
        ("X EXX\n0 0,01\n1 0,02\n", Some(2), "3 values"),
        ("X EXX\n0 0\n1 bad\n", Some(3), "a number"),
        ("X EXX\n1 0\n0 0\n", Some(3), "increasing"),
        ("EXX\n0.1\n", Some(1), "without an argument"),
        ("PXC\n100\n", Some(2), "A0Z, B0Z, C0Y"),
        ("X0X\n0.1\n", Some(2), "A0Z, B0Z, C0Y"),
        ("X X\n0 0\n", Some(1), "twice"),
        ("X EXX\n0 0\n1 0\n#\nX EYX\n0 0\n1 0\n", Some(5), "second table"),
        ("A0Z\n1e-5\n", None, "no component errors"),
    ] {
        let error = refusal(Format::Isg, text, None);
        assert_eq!(error.line, line, "{error}");
        assert!(error.to_string().contains(fragment), "{error}");
    }
}

#[test]
fn measurement_refusals() {
    let head = "X_mm,run,direction,deviation_um\n";
    for (text, line, fragment) in [
        ("", None, "no header"),
        (head, None, "no approaches"),
        ("X_mm,run,direction\n", Some(1), "without all"),
        ("X_mm,run,direction,deviation_mm\n", Some(1), "deviation_mm"),
        ("X_mm,run,direction,deviation_urad\n0,1,+,0\n", Some(1), "mm and um"),
        ("position_mm,run,direction,deviation_um\n", Some(1), "no axis"),
        ("X_mm,run,direction,deviation_um\n0,1,+\n", Some(2), "3 values"),
        ("X_mm,run,direction,deviation_um\n0,0,+,1\n", Some(2), "whole number"),
        ("X_mm,run,direction,deviation_um\n# x\n0,1,up,1\n", Some(3), "+ or -"),
        ("X_mm,run,direction,deviation_um\n0,1,+,inf\n", Some(2), "finite"),
        ("X_mm,run,direction,deviation_um\n0,1,+,1\n0,1,+,1\n", Some(3), "again"),
        ("X_mm,run,direction,deviation_um\n0,1,+,1\n1,2,+,1\n", None, "no approach of 0 in run 2"),
    ] {
        let error = refusal(Format::Iso230_2, text, None);
        assert_eq!(error.line, line, "{error}");
        assert!(error.to_string().contains(fragment), "{error}");
    }
    assert!(refusal(Format::Iso230_2, &format!("{head}0,1,+,1\n"), Some(Axis::Y)).to_string().contains("axis Y"));
}

#[test]
fn measurement_becomes_the_table_of_its_means() {
    let text = "deviation_urad,C_deg,direction,run\n-4,90,-,2\n1,0,+,1\n3,0,+,2\n5,0,-,1\n7,0,-,2\n10,90,+,1\n20,90,+,2\n-2,90,-,1\n";
    let (axis, table) = read(Format::Iso230_2, text, None).tables.remove(0);
    assert_eq!(axis, Axis::C);
    micro(&table, 0, 5, 2.0, 6.0);
    micro(&table, 1, 5, 15.0, -3.0);
}

/// Compares the written files byte for byte; their content is calculated by hand in `small_machine`.
#[test]
fn golden_files() {
    let machine = machine();
    for (format, axis) in [
        (TYPE_0, None),
        (TYPE_1, Some(Axis::C)),
        (Format::Siemens, None),
        (Format::Isg, None),
        (Format::Iso230_2, Some(Axis::C)),
    ] {
        let exported = write(format, &machine, &dropping(axis));
        for (name, text) in &exported.files {
            golden(&format!("{}-{name}", format.name()), text);
        }
    }
}

#[test]
fn names() {
    for (name, format) in Format::ALL {
        assert_eq!((Format::from_name(name), format.name()), (Some(format), name));
    }
    assert_eq!(Format::from_name("fanuc"), None);
}

/// The two measured ends of a full circle may differ by up to 0.5 µm and 1 µrad, and then become their mean.
#[test]
fn full_circle() {
    let text = |exc: f64, ecc: f64| format!("C EXC ECC\n0 0.001 1e-5\n90 0 0\n360 {} {}\n", 0.001 + exc, 1e-5 + ecc);
    let closed = read(Format::Isg, &text(0.49e-3, 0.99e-6), None).tables.remove(0).1;
    micro(&closed, 0, 0, 1.245, 1.245);
    assert_eq!(closed.rows[0].forward, closed.rows[2].forward);
    for (wrong, found) in [(text(0.51e-3, 0.0), "1.51 um at the end"), (text(0.0, -1.01e-6), "8.99 urad at the end")] {
        let error = refusal(Format::Isg, &wrong, None);
        assert!(error.line == Some(4) && error.found.contains(found), "{error}");
    }
    let measured = |end: f64| format!("C_deg,run,direction,deviation_urad\n0,1,+,1\n90,1,+,2\n360,1,+,{end}\n");
    micro(&read(Format::Iso230_2, &measured(1.4), None).tables[0].1, 2, 5, 1.2, 1.2);
    assert_eq!(refusal(Format::Iso230_2, &measured(3.0), None).line, None);
}

#[test]
fn losses_are_refused_and_named() {
    let mut machine = machine();
    let harmonics = [[3e-3, 4e-3]].into_iter().collect();
    let period = PeriodicSettings { axis: Axis::X, period: 5.0, harmonics, reverse: Default::default() };
    machine.settings.periodic.push(period).unwrap();
    let named = |format: Format, axis: Option<Axis>| {
        let dropped = write(format, &machine, &dropping(axis)).dropped;
        let options = ExportOptions { axis, ..ExportOptions::default() };
        let error = export(format, &machine, &options).unwrap_err();
        for loss in &dropped {
            assert!(error.found.contains(loss), "{loss} not in {error}");
        }
        dropped.join("\n")
    };
    let linuxcnc = named(TYPE_0, None);
    for loss in [
        "EYX, ECX of axis X",
        "EXC of axis C",
        "wrapping of axis C",
        "thermal growth of axis X",
        "period of 5 mm of axis X (up to 5.00 um)",
        "location errors",
        "backlash of axis Z",
    ] {
        assert!(linuxcnc.contains(loss), "{loss}: {linuxcnc}");
    }
    assert!(named(Format::Siemens, None).contains("between the directions of axis X (up to 4.0000 um"));
    let isg = named(Format::Isg, None);
    assert!(isg.contains("between the directions of axis X") && !isg.contains("location") && !isg.contains("EYX of"));
    // A format that can hold everything refuses nothing.
    let mut plain = machine.clone();
    plain.settings.axes.iter_mut().for_each(|axis| (axis.backlash, axis.thermal) = (0.0, Default::default()));
    plain.settings.periodic.clear();
    for table in plain.tables.iter_mut().flatten() {
        table.rows.iter_mut().for_each(|row| row.reverse = row.forward);
    }
    assert!(write(Format::Isg, &plain, &ExportOptions::default()).dropped.is_empty());
    assert!(export(TYPE_0, &plain, &dropping(Some(Axis::Z))).unwrap_err().found.contains("axis Z"));
}

/// The own error survives every format within its written precision: 1 nm, 1e-7 degrees, 1 nrad.
#[test]
fn round_trips() {
    for seed in 0..50 {
        let mut noise = Noise::new(seed);
        let mut machine = machine();
        for (settings, table) in machine.settings.axes.iter().zip(machine.tables.iter_mut()) {
            let Some(table) = table else { continue };
            let last = table.rows.len() - 1;
            for row in &mut table.rows {
                row.forward = std::array::from_fn(|k| noise.signed() * if k < 3 { 0.05 } else { 2e-4 });
                row.reverse = std::array::from_fn(|k| noise.signed() * if k < 3 { 0.05 } else { 2e-4 });
            }
            if settings.axis == Axis::C {
                (table.rows[last].forward, table.rows[last].reverse) = (table.rows[0].forward, table.rows[0].reverse);
            }
        }
        for (format, both_ways) in
            [(TYPE_0, true), (TYPE_1, true), (Format::Siemens, false), (Format::Isg, false), (Format::Iso230_2, true)]
        {
            for axis in [Axis::X, Axis::C] {
                let (_, text) = write(format, &machine, &dropping(Some(axis))).files.remove(0);
                let (_, back) = read(format, &text, Some(axis)).tables.remove(0);
                let (settings, table) = machine.axes().find(|(settings, _)| settings.axis == axis).unwrap();
                let own = axis.index();
                let backlash = if axis.is_rotary() { settings.backlash * PI / 180.0 } else { settings.backlash };
                let tolerance = if axis.is_rotary() { 1.001e-9 } else { 0.501e-6 };
                for (row, read) in table.unwrap().rows.iter().zip(&back.rows) {
                    let (forward, reverse) = (row.forward[own], row.reverse[own] + backlash);
                    let mean = 0.5 * (forward + reverse);
                    let (forward, reverse) = if both_ways { (forward, reverse) } else { (mean, mean) };
                    assert_eq!(row.position, read.position);
                    assert!((read.forward[own] - forward).abs() < tolerance, "seed {seed} {format:?} {row:?} {read:?}");
                    assert!((read.reverse[own] - reverse).abs() < tolerance, "seed {seed} {format:?} {row:?} {read:?}");
                    for cross in (0..6).filter(|&k| format == Format::Isg && k != own && back.given[k]) {
                        let mean = 0.5 * (row.forward[cross] + row.reverse[cross]);
                        let tolerance = if cross < 3 { 0.501e-6 } else { 0.501e-9 };
                        assert!((read.forward[cross] - mean).abs() < tolerance, "seed {seed} component {cross}");
                    }
                }
            }
        }
    }
}

#[test]
fn isg_carries_the_location_errors() {
    let machine = machine();
    let (_, text) = write(Format::Isg, &machine, &dropping(None)).files.remove(0);
    assert_eq!(read(Format::Isg, &text, None).location, machine.settings.location);
}

/// For Siemens a free grid needs a step; a step that hits every point loses nothing.
#[test]
fn siemens_free_grid() {
    let mut machine = machine();
    machine.tables[0].as_mut().unwrap().rows[1].position = 75.0;
    let mut options = dropping(Some(Axis::X));
    assert!(export(Format::Siemens, &machine, &options).unwrap_err().found.contains("free grid"));
    options.step = Some(30.0);
    assert!(export(Format::Siemens, &machine, &options).unwrap_err().needed.contains("divides"));
    let points = |step: f64| {
        let exported = write(Format::Siemens, &machine, &ExportOptions { step: Some(step), ..dropping(Some(Axis::X)) });
        let table = read(Format::Siemens, &exported.files[0].1, None).tables.remove(0).1;
        (table.rows, exported.dropped.iter().any(|loss| loss.contains("detail")))
    };
    let (rows, lossy) = points(25.0);
    assert!(!lossy);
    let mean = |row: usize| {
        let row = &machine.tables[0].as_ref().unwrap().rows[row];
        0.5 * (row.forward[0] + row.reverse[0] + machine.settings.axes[0].backlash)
    };
    assert!((rows[3].forward[0] - mean(1)).abs() < 0.501e-6);
    assert!((rows[1].forward[0] - (mean(0) * 2.0 + mean(1)) / 3.0).abs() < 0.501e-6);
    assert!(points(50.0).1);
}

/// A `direction` other than the default reverses the sense of a rotary axis' positions relative to its error table.
#[test]
fn rotary_sense() {
    let mut machine = machine();
    let value = |machine: &Machine| {
        let (_, text) = write(TYPE_1, machine, &dropping(Some(Axis::C))).files.remove(0);
        read(TYPE_1, &text, Some(Axis::C)).tables.remove(0).1.rows[1].forward[5]
    };
    let table = machine.tables[2].as_ref().unwrap().rows[1].forward[5];
    assert!((value(&machine) - table).abs() < 1.001e-9);
    machine.settings.axes[2].direction = 1;
    assert!((value(&machine) + table).abs() < 1.001e-9);
    machine.settings.chain = "w X' b Z C t".parse().unwrap();
    assert!((value(&machine) - table).abs() < 1.001e-9);
}

/// A new axis has its table's range as travel, and a cubic where its points allow one: between the points it is nearer to a
/// smooth error than straight lines.
#[test]
fn a_new_axis_is_cubic_through_four_points() {
    let error = |x: f64| 20.0 * (x / 60.0).sin();
    let toml = |count: u32| {
        let rows = (0..count).map(|k| format!("{},{:.4}\n", 40 * k, error(40.0 * f64::from(k))));
        let text = format!("Position (mm),Forward (um)\n{}", rows.collect::<String>());
        let files = read(Format::Columns, &text, Some(Axis::X)).machine_files("m");
        let machine = Machine::read_from(&Memory::new(files.clone()), Path::new("machine.toml"), &mut |_| {}).unwrap();
        (files[0].1.clone(), machine)
    };
    let (three, _) = toml(3);
    assert!(three.contains("interpolation = \"linear\"\ntravel_mm = [0.0, 80.0]"), "{three}");
    let (text, machine) = toml(9);
    assert!(text.contains("interpolation = \"cubic\"\ntravel_mm = [0.0, 320.0]"), "{text}");
    let straight = |x: f64| {
        let low = 40.0 * (x / 40.0).floor();
        error(low) + (x - low) / 40.0 * (error(low + 40.0) - error(low))
    };
    let exact = Geometry::new(&machine, 0.0).unwrap();
    let mut squares = [0.0_f64; 2];
    for x in (0..320).map(f64::from) {
        let found = 1e3 * exact.tip_error(&[x, 0.0, 0.0, 0.0, 0.0, 0.0], &[0.0; 6])[0];
        squares[0] += (found - error(x)).powi(2);
        squares[1] += (straight(x) - error(x)).powi(2);
    }
    assert!(squares[0] < 0.25 * squares[1], "{squares:?}");
}

fn is_written(format: Format) -> bool {
    matches!(format, Format::LinuxCnc(_) | Format::Siemens | Format::Isg | Format::Iso230_2)
}

/// Damaged files are refused or read, without a panic.
#[test]
fn damaged_files_do_not_panic() {
    let machine = machine();
    for (_, format) in Format::ALL.into_iter().filter(|(_, format)| is_written(*format)) {
        for (_, text) in write(format, &machine, &dropping(Some(Axis::X))).files {
            for end in 0..text.len() {
                let _ = import(format, &text[..end], Path::new("in"), Some(Axis::X));
            }
            for place in 0..text.len() {
                for damage in [b' ', b'-', b'e', b',', b'\n', b'#', b'9', b'[', 0] {
                    let mut bytes = text.clone().into_bytes();
                    bytes[place] = damage;
                    let _ = import(format, &String::from_utf8_lossy(&bytes), Path::new("in"), None);
                }
            }
        }
    }
}

/// Random lines of the words of each format are refused or read, without a panic.
#[test]
fn random_files_do_not_panic() {
    const WORDS: [&str; 40] = [
        "0",
        "1",
        "-1",
        "3",
        "0.050",
        "-0.010",
        "+0.1",
        "NAN",
        ".",
        "1e308",
        "nan",
        ",",
        ", ",
        ";",
        "\t",
        " ",
        "\n",
        "\n",
        "\n",
        ":",
        "|",
        "[",
        "]",
        "(20,20)  (220,120)\n",
        "(20,120) (220,120)\n",
        "Bilinear Leveling Grid:\n0 1\n0 ",
        "0 | ",
        "1 | ",
        "Subdivided with CATMULL ROM Leveling Grid:\n0 1 2\n",
        "Bed X: 20.000 Y: 20.000 Z: 0.1\n",
        "Fade Height ",
        "Bed Topography Report for CSV:\n",
        "RepRapFirmware height map file v2\n",
        "X,Y,0,10,0,10,-1,10,10,2,2\n",
        "axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1\n",
        "HEADER::\nFile type : rtl\n",
        "TARGET DATA::\nTargets :\n0 10 20\n",
        "DEVIATIONS::\nRun Target Data:\n1 1 1\n1 2 2\n",
        "Position (mm),",
        "Forward (um)\n",
    ];
    let mut noise = Noise::new(41);
    for (_, format) in Format::ALL {
        for _ in 0..2_000 {
            let count = 1 + noise.below(40);
            let words: Vec<&str> = (0..count).map(|_| WORDS[noise.below(WORDS.len())]).collect();
            let text = words.concat();
            let axis = (noise.unit() < 0.5).then_some(Axis::X);
            let _ = import(format, &text, Path::new("in"), axis);
        }
    }
}
