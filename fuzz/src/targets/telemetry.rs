//! Telemetry as a host receives it: frames on a line that loses, damages and repeats bytes.

use crate::execution::SLOWEST;
use crate::{Target, outcome};
use trueaxis::telemetry::{
    AxisFrame, DynamicFrame, FRAME_BYTES, FRAME_VERSION, Frame, ROUNDNESS_FRAME_BYTES, ROUNDNESS_FRAME_VERSION,
    RoundnessFrame,
};

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "telemetry",
    about: "telemetry frames of cycles and revolutions: damaged, cut, glued, between garbage",
    run,
    seeds,
    repair,
    dictionary: include_str!("../../dictionaries/telemetry.dict"),
    slowest: SLOWEST,
};

fn run(bytes: &[u8]) {
    let mut seen = [0_u8; 3];
    for piece in bytes.split(|byte| *byte == 0) {
        match read(piece) {
            Read::Cycle(frame) => {
                seen[0] |= 1 << frame.axes.len();
                seen[1] |= u8::from(frame.axes.iter().any(|axis| axis.dynamic.is_some()));
                frame_again(&frame);
            }
            Read::Revolution(frame) => {
                seen[2] |= 1 << frame.harmonics.len().min(4);
                roundness_again(&frame);
            }
            Read::Nothing => {}
        }
    }
    if seen != [0; 3] {
        outcome::accepted();
    }
    outcome::saw(seen);
    resynchronises(bytes);
}

enum Read {
    Cycle(Box<Frame>),
    Revolution(Box<RoundnessFrame>),
    Nothing,
}

/// Decodes one piece between zeros. It cannot be a frame of both kinds.
fn read(piece: &[u8]) -> Read {
    // The decoders modify their input.
    let (mut one, mut other) = (piece.to_vec(), piece.to_vec());
    match (Frame::decode(&mut one), RoundnessFrame::decode(&mut other)) {
        (Ok(_), Ok(_)) => panic!("a frame of a cycle and of a revolution"),
        (Ok(frame), Err(_)) => Read::Cycle(Box::new(frame)),
        (Err(_), Ok(frame)) => Read::Revolution(Box::new(frame)),
        (Err(_), Err(_)) => Read::Nothing,
    }
}

/// A decoded frame is encoded as one frame, which decodes to the same.
fn frame_again(frame: &Frame) {
    assert_eq!(frame.version, FRAME_VERSION);
    let (mut buffer, mut again) = ([0xa5; FRAME_BYTES], [0x5a; FRAME_BYTES]);
    let bytes = frame.encode(&mut buffer).expect("a buffer that always does");
    one_frame(bytes);
    let mut scratch = bytes.to_vec();
    let decoded = Frame::decode(&mut scratch).expect("what was encoded");
    // Compare bytes: a NaN differs from itself.
    assert_eq!(decoded.encode(&mut again).expect("the same buffer"), bytes);
    let short = bytes.len() - 1;
    assert!(frame.encode(&mut again[..short]).is_err(), "{} bytes in {short}", bytes.len());
}

/// Like [`frame_again`], for a revolution.
fn roundness_again(frame: &RoundnessFrame) {
    assert_eq!(frame.version, ROUNDNESS_FRAME_VERSION);
    let (mut buffer, mut again) = ([0xa5; ROUNDNESS_FRAME_BYTES], [0x5a; ROUNDNESS_FRAME_BYTES]);
    let bytes = frame.encode(&mut buffer).expect("a buffer that always does");
    one_frame(bytes);
    let mut scratch = bytes.to_vec();
    let decoded = RoundnessFrame::decode(&mut scratch).expect("what was encoded");
    assert_eq!(decoded.encode(&mut again).expect("the same buffer"), bytes);
}

/// Only the last byte is zero.
fn one_frame(bytes: &[u8]) {
    let (last, rest) = bytes.split_last().expect("a frame has bytes");
    assert!(*last == 0 && !rest.contains(&0), "{bytes:?}");
}

/// Carries whole frames between pieces of the input: no frame behind a zero is lost, whatever came before; only one that
/// garbage runs into without a zero between may be.
fn resynchronises(garbage: &[u8]) {
    let Some(count) = garbage.first().map(|first| 1 + usize::from(*first) % 3) else { return };
    let mut line = Vec::with_capacity(2 * garbage.len() + 3 * FRAME_BYTES);
    let mut expected = Vec::new();
    let pieces = garbage.chunks(garbage.len().div_ceil(count));
    for (number, piece) in pieces.enumerate() {
        line.extend_from_slice(piece);
        let frame = sample(number as u32 | 0x0100_0000, usize::from(piece[0]) % 4 + 3, piece.len() % 2 == 1);
        let clear = line.last().is_none_or(|byte| *byte == 0);
        append(&frame, &mut line);
        // A second frame is safe behind the zero of the first.
        let second = Frame { sequence: number as u32 | 0x0200_0000, ..frame.clone() };
        append(&second, &mut line);
        expected.extend(clear.then_some(frame).into_iter().chain([second]));
    }
    let mut expected = expected.iter().peekable();
    for piece in line.split(|byte| *byte == 0) {
        if let Read::Cycle(frame) = read(piece)
            && expected.peek().is_some_and(|next| **next == *frame)
        {
            expected.next();
        }
    }
    assert!(expected.next().is_none(), "a whole frame was lost in {line:?}");
}

fn append(frame: &Frame, line: &mut Vec<u8>) {
    let mut buffer = [0; FRAME_BYTES];
    line.extend_from_slice(frame.encode(&mut buffer).expect("a buffer that always does"));
}

fn sample(sequence: u32, axes: usize, dynamic: bool) -> Frame {
    let part = DynamicFrame { sent: 1e-3, feed_forward: 1e-3, ..DynamicFrame::default() };
    let axis = |i: usize| AxisFrame {
        command: 10.0 * i as f64,
        feedback: 10.0 * i as f64 + 1e-4,
        correction: 1e-3,
        dynamic: dynamic.then_some(part),
    };
    Frame { version: FRAME_VERSION, sequence, axes: (0..axes).map(axis).collect(), ..Frame::default() }
}

fn revolution(harmonics: usize) -> RoundnessFrame {
    let motion = trueaxis::roundness::ErrorMotion {
        synchronous_um: 1.0,
        asynchronous_um: 0.5,
        once_per_revolution_um: [0.1, 0.2],
        total_um: 1.5,
    };
    RoundnessFrame {
        version: ROUNDNESS_FRAME_VERSION,
        machine_id: 7,
        revolution: 3,
        evaluated: 2,
        skipped: 1,
        discarded: 0,
        flags: Default::default(),
        peak_to_valley_um: 2.0,
        revolutions: 2,
        x: motion,
        y: motion,
        first_harmonic: 2,
        harmonics: (0..harmonics).map(|k| [k as f32, 0.0]).collect(),
    }
}

fn seeds() -> Vec<Vec<u8>> {
    let mut line = Vec::new();
    append(&sample(1, 3, false), &mut line);
    append(&sample(300, 6, true), &mut line);
    let mut buffer = [0; ROUNDNESS_FRAME_BYTES];
    let short = revolution(2).encode(&mut buffer).expect("a buffer that always does").to_vec();
    let long = revolution(80).encode(&mut buffer).expect("a buffer that always does").to_vec();
    vec![line.clone(), short.clone(), [short, line].concat(), long]
}

/// Turns every piece into a frame of the nearest kind: a mutation then changes a frame's content, not whether it is one.
fn repair(bytes: &mut Vec<u8>) {
    let mut line = Vec::with_capacity(bytes.len() + 8);
    for piece in bytes.split(|byte| *byte == 0).filter(|piece| !piece.is_empty()) {
        let mut content = without_zeros_undone(piece);
        if let Some(version) = content.first_mut() {
            *version = if *version >= 128 { ROUNDNESS_FRAME_VERSION } else { FRAME_VERSION };
        }
        with_zeros_taken_out(&content, &mut line);
    }
    *bytes = line;
}

/// COBS: decodes a piece, and supplies its end if it is truncated.
fn without_zeros_undone(piece: &[u8]) -> Vec<u8> {
    let (mut content, mut rest) = (Vec::with_capacity(piece.len()), piece);
    while let Some((code, behind)) = rest.split_first() {
        let (run, after) = behind.split_at(behind.len().min(usize::from(*code) - 1));
        content.extend_from_slice(run);
        if *code < 0xff && !after.is_empty() {
            content.push(0);
        }
        rest = after;
    }
    content
}

/// COBS: writes the content without zeros, then a zero.
fn with_zeros_taken_out(content: &[u8], line: &mut Vec<u8>) {
    let runs: Vec<&[u8]> = content.split(|byte| *byte == 0).collect();
    for run in runs {
        let mut rest = run;
        while rest.len() >= 254 {
            let (full, after) = rest.split_at(254);
            line.push(0xff);
            line.extend_from_slice(full);
            rest = after;
        }
        line.push(rest.len() as u8 + 1);
        line.extend_from_slice(rest);
    }
    line.push(0);
}
