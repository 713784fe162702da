//! The wire format of docs/telemetry.md, held against the code.

use trueaxis::Fault;
use trueaxis::telemetry::{AxisFrame, FRAME_BYTES, FRAME_VERSION, Frame, Status};

/// A frame with the longest variable-length numbers.
fn longest(axes: usize) -> Frame {
    let axis = AxisFrame { command: 1.1, feedback: 1.1, correction: 1.1 };
    let mut frame = Frame {
        version: FRAME_VERSION,
        sequence: u32::MAX,
        machine_id: u32::MAX,
        tables_crc: u32::MAX,
        status: Status(1),
        ..Frame::default()
    };
    for _ in 0..axes {
        frame.axes.push(axis).unwrap();
    }
    frame
}

/// Sizes in docs/telemetry.md.
#[test]
fn frames_are_as_long_as_documented() {
    let mut buffer = [0; FRAME_BYTES];
    assert_eq!(longest(3).encode(&mut buffer).unwrap().len(), 118);
    assert_eq!(longest(6).encode(&mut buffer).unwrap().len(), 178);
}

/// Byte offsets and the numbers of the faults in docs/telemetry.md; COBS undone here, not by the code under test.
#[test]
fn frames_are_laid_out_as_documented() {
    let faults = [
        Fault::None,
        Fault::FeedbackNotFinite,
        Fault::FeedbackJump,
        Fault::EncoderStuck,
        Fault::EncoderAlarm,
        Fault::LateCycle,
        Fault::CommandNotFinite,
        Fault::CommandOutOfTravel,
        Fault::CommandJump,
        Fault::JointRange,
        Fault::PeriodMismatch,
    ];
    let codes = [0, 1, 2, 3, 4, 5, 16, 17, 18, 19, 32];
    for (fault, code) in faults.into_iter().zip(codes) {
        assert_eq!(fault as u8, code);
        let mut frame = longest(3);
        (frame.sequence, frame.fault) = (300, fault);
        let mut buffer = [0; FRAME_BYTES];
        let bytes = frame.encode(&mut buffer).unwrap();
        let (closing, body) = bytes.split_last().unwrap();
        assert_eq!(*closing, 0);
        let record = uncobs(body);
        assert_eq!(record[..3], [1, 0xac, 0x02], "version 1, 300 as a varint");
        assert_eq!(record[13..18], [code, 0, 1, 0, 0], "fault, its axis, status, limited, at edge");
        assert_eq!(record[18], 3, "number of axes");
        assert_eq!(record[19..27], 1.1_f64.to_le_bytes());
        assert_eq!(record[35..39], 1.1_f32.to_le_bytes());
        assert_eq!(Frame::decode(bytes).unwrap(), frame);
        assert_eq!(record.len(), 19 + 3 * 20 + 2 * 17);
    }
}

/// Consistent overhead byte stuffing, undone: every code byte says how far off the next zero is.
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
