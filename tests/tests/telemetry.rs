//! The wire format in docs/telemetry.md, compared with the code.

use trueaxis::Fault;
use trueaxis::roundness::{ErrorMotion, Followed, Gauge, GaugeFlags, GaugeSettings, HARMONICS, ProbeAngles, Probes};
use trueaxis::telemetry::{
    AxisFrame, DynamicFrame, FRAME_BYTES, FRAME_VERSION, Frame, ROUNDNESS_FRAME_BYTES, ROUNDNESS_FRAME_VERSION,
    RoundnessFrame, Status,
};

/// A frame in which the variable-length numbers are longest.
fn longest(axes: usize, dynamic: Option<DynamicFrame>) -> Frame {
    let axis = AxisFrame { command: 1.1, feedback: 1.1, correction: 1.1, dynamic };
    let mut frame = Frame {
        version: FRAME_VERSION,
        sequence: u32::MAX,
        machine_id: u32::MAX,
        tables_crc: u32::MAX,
        status: Status(1),
        orientation: 1.05,
        orientation_flags: 32,
        ..Frame::default()
    };
    for _ in 0..axes {
        frame.axes.push(axis).unwrap();
    }
    frame
}

/// Frame sizes in docs/telemetry.md.
#[test]
fn frames_are_as_long_as_documented() {
    let mut buffer = [0; FRAME_BYTES];
    assert_eq!(longest(3, None).encode(&mut buffer).unwrap().len(), 126);
    assert_eq!(longest(6, None).encode(&mut buffer).unwrap().len(), 189);
    let dynamic = Some(DynamicFrame { sent: 1.1, feed_forward: 1.1, feedback: 1.1, crosstalk: 1.1, learned: 1.1 });
    assert_eq!(longest(3, dynamic).encode(&mut buffer).unwrap().len(), 186);
    // COBS takes one more byte if the first 254 contain no zero.
    assert!((309..=310).contains(&longest(6, dynamic).encode(&mut buffer).unwrap().len()));
}

/// Byte offsets and fault numbers in docs/telemetry.md; COBS is decoded here, independently of the code under test.
#[test]
fn frames_are_laid_out_as_documented() {
    let faults = [
        Fault::None,
        Fault::FeedbackNotFinite,
        Fault::FeedbackJump,
        Fault::EncoderStuck,
        Fault::EncoderAlarm,
        Fault::LateCycle,
        Fault::FeedbackRatio,
        Fault::CommandNotFinite,
        Fault::CommandOutOfTravel,
        Fault::CommandJump,
        Fault::JointRange,
        Fault::ToolUnreachable,
        Fault::SingularPose,
        Fault::BranchChange,
        Fault::PeriodMismatch,
    ];
    let codes = [0, 1, 2, 3, 4, 5, 6, 16, 17, 18, 19, 20, 21, 22, 32];
    for (fault, code) in faults.into_iter().zip(codes) {
        assert_eq!(fault as u8, code);
        let mut frame = longest(3, None);
        (frame.sequence, frame.fault) = (300, fault);
        let mut buffer = [0; FRAME_BYTES];
        let bytes = frame.encode(&mut buffer).unwrap();
        let (closing, body) = bytes.split_last().unwrap();
        assert_eq!(*closing, 0);
        let record = uncobs(body);
        assert_eq!(record[..3], [3, 0xac, 0x02], "version 3, 300 as a varint");
        assert_eq!(record[13..18], [code, 0, 1, 0, 0], "fault, its axis, status, limited, at edge");
        assert_eq!(record[18], 3, "number of axes");
        assert_eq!(record[19..27], 1.1_f64.to_le_bytes());
        assert_eq!(record[35..39], 1.1_f32.to_le_bytes());
        assert_eq!(record[39], 0, "no dynamic correction");
        assert_eq!(Frame::decode(bytes).unwrap(), frame);
        assert_eq!(record[116..121], [0x66, 0x66, 0x86, 0x3f, 32], "orientation, its flags");
        assert_eq!(record.len(), 19 + 3 * 21 + 2 * 17 + 5);
    }
}

/// A revolution in which the numbers are longest.
fn longest_revolution() -> RoundnessFrame {
    let motion = ErrorMotion {
        synchronous_um: 1.1_f32,
        asynchronous_um: 2.2,
        once_per_revolution_um: [3.3, 4.4],
        total_um: 5.5,
    };
    RoundnessFrame {
        version: ROUNDNESS_FRAME_VERSION,
        machine_id: u32::MAX,
        revolution: u32::MAX,
        evaluated: u32::MAX,
        skipped: u32::MAX,
        discarded: u32::MAX,
        flags: GaugeFlags(u16::MAX),
        peak_to_valley_um: 1.1,
        revolutions: u16::MAX,
        x: motion,
        y: motion,
        first_harmonic: u16::MAX,
        harmonics: (0..HARMONICS).map(|_| [1.1, 2.2]).collect(),
    }
}

#[test]
fn revolutions_are_laid_out_as_documented() {
    let mut buffer = [0; ROUNDNESS_FRAME_BYTES];
    let frame = longest_revolution();
    let bytes = frame.encode(&mut buffer).unwrap();
    assert_eq!(bytes.len(), 1 + 25 + 3 + 4 + 3 + 2 * 20 + 3 + 2 + 8 * HARMONICS + 2 + bytes.len() / 255);
    let (closing, body) = bytes.split_last().unwrap();
    assert_eq!(*closing, 0);
    let record = uncobs(body);
    assert_eq!(record[0], 129, "a byte that no record of a cycle begins with");
    assert_eq!(record[29..33], 1.1_f32.to_le_bytes(), "peak to valley");
    assert_eq!(record[36..40], 1.1_f32.to_le_bytes(), "synchronous, X");
    assert_eq!(record[44..52], [3.3_f32.to_le_bytes(), 4.4_f32.to_le_bytes()].concat(), "once per revolution, X");
    assert_eq!(record[79..81], [0x80, 0x01], "128 harmonics");
    assert_eq!(RoundnessFrame::decode(bytes).unwrap(), frame);
    let mut buffer = [0; ROUNDNESS_FRAME_BYTES];
    let bytes = frame.encode(&mut buffer).unwrap();
    assert!(Frame::decode(bytes).is_err(), "not taken for a cycle");
    assert!(frame.encode(&mut [0; 100]).is_err());
}

/// The results of a revolution are transmitted.
#[test]
fn a_revolution_of_the_gauge_arrives() {
    let settings = GaugeSettings::with_defaults(64, ProbeAngles::Slots { p: 11, q: 15 }, 1 << 20);
    let gauge = Gauge::<f32, 64>::build(&settings, 100_000).unwrap();
    let mut state = gauge.start();
    assert_eq!(RoundnessFrame::of(7, &gauge, &state), None);
    let phi = [0.0, gauge.gain().phi2(), gauge.gain().phi2() + gauge.gain().phi3()];
    for cycle in 0..4_000 {
        let (now, before) = (cycle * 1000, (cycle - 1) * 1000);
        let theta = f64::from(now) / f64::from(1 << 20) * std::f64::consts::TAU;
        let probes = Probes {
            readings: phi.map(|phi| (2.0 * (3.0 * (theta + phi)).cos()) as f32),
            spindle: now,
            index: ((now >> 20) != (before >> 20)).then_some((now >> 20) << 20),
            arm: 0,
            new_part: false,
            idle: false,
        };
        gauge.update(&mut state, &probes, Followed::Whole);
    }
    let frame = RoundnessFrame::of(7, &gauge, &state).unwrap();
    assert_eq!((frame.machine_id, frame.revolution, frame.evaluated, frame.flags), (7, 2, 2, GaugeFlags::default()));
    assert_eq!((frame.first_harmonic, frame.harmonics.len()), (2, 30));
    assert!((frame.harmonics[1][0] - 2.0).abs() < 1e-4 && frame.harmonics[1][1].abs() < 1e-4, "{frame:?}");
    assert!((frame.peak_to_valley_um - 4.0).abs() < 0.05);
    let mut buffer = [0; ROUNDNESS_FRAME_BYTES];
    assert_eq!(RoundnessFrame::decode(frame.encode(&mut buffer).unwrap()).unwrap(), frame);
}

/// Decodes consistent overhead byte stuffing: every code byte gives the distance to the next zero.
fn uncobs(mut bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    while let Some((&code, rest)) = bytes.split_first() {
        let (block, next) = rest.split_at(usize::from(code) - 1);
        out.extend_from_slice(block);
        if code < 0xff && !next.is_empty() {
            out.push(0);
        }
        bytes = next;
    }
    out
}
