//! Recorded servo cycles, as read by a bare-metal image and the host.

use crate::execution::SLOWEST;
use crate::{Target, outcome, sum};
use trueaxis::Nanometres;
use trueaxis::contour::{Reference, Segment, Span, convert};
use trueaxis::glam::DVec3;
use trueaxis_recording::{Header, MAGIC, Probe, RecordedCycle, Recording, RecordingRefusal, Writer};

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "recording",
    about: "recordings of servo cycles, 3 to 6 axes, with and without a gauge",
    run,
    seeds,
    repair: |bytes| repair(bytes),
    dictionary: include_str!("../../dictionaries/recording.dict"),
    slowest: SLOWEST,
};

/// Bytes before the content: magic, version, length.
const HEAD: usize = 14;

fn run(bytes: &[u8]) {
    let refused = [of::<3>, of::<4>, of::<5>, of::<6>]
        .into_iter()
        .map(|of| of(bytes))
        .find(|r| *r != Some(RecordingRefusal::Axes));
    if let Some(Some(refused)) = refused {
        outcome::refused(refused);
    }
}

/// Reads a recording of `N` axes, which must be complete and survive being written again.
fn of<const N: usize>(bytes: &[u8]) -> Option<RecordingRefusal> {
    let recording = match Recording::<N>::parse(bytes) {
        Ok(recording) => recording,
        Err(refused) => return Some(refused),
    };
    let header = recording.header();
    assert_eq!(usize::from(header.axes), N);
    let path: Vec<Span<f64, f64>> = recording.path().collect();
    assert_eq!(path.len(), header.pieces as usize);
    assert_eq!(recording.path::<f32, Nanometres>().count(), path.len());
    assert!(recording.cycle(header.cycles).is_none() && recording.cycle(u32::MAX).is_none());
    let cycles: Vec<RecordedCycle<N>> = (0..header.cycles).map_while(|number| recording.cycle(number)).collect();
    assert_eq!(cycles.len(), header.cycles as usize);
    for cycle in &cycles {
        let single = cycle.input::<Nanometres>();
        assert_eq!(single.command, cycle.command);
        let double = cycle.input::<f64>();
        assert!(double.command.iter().chain(&double.feedback).all(|q| q.is_nan() || q.abs() < 2148.0));
        assert!(header.gauge || cycle.probe == Probe::default());
    }
    outcome::accepted();
    outcome::saw((N, header.gauge, path.len().min(3), cycles.len().min(3)));
    // Numbers may be written in more than one way; rewriting the writer's form changes nothing.
    let again = written(header, &path, &cycles);
    let read = Recording::<N>::parse(&again).expect("what was written");
    assert_eq!(written(read.header(), &read.path().collect::<Vec<_>>(), &all(&read)), again);
    assert_eq!((read.header().cycles, read.header().pieces), (header.cycles, header.pieces));
    damaged::<N>(&again, bytes);
    None
}

/// A recording with any one bit wrong, or without its end, is refused.
fn damaged<const N: usize>(good: &[u8], choice: &[u8]) {
    let sum = choice.iter().fold(0_usize, |sum, byte| sum.wrapping_mul(31).wrapping_add(usize::from(*byte)));
    let mut bytes = good.to_vec();
    let bit = sum % (8 * bytes.len());
    bytes[bit / 8] ^= 1 << (bit % 8);
    assert!(Recording::<N>::parse(&bytes).is_err(), "bit {bit} wrong");
    assert!(Recording::<N>::parse(&good[..sum % good.len()]).is_err(), "{} bytes", sum % good.len());
}

fn all<const N: usize>(recording: &Recording<'_, N>) -> Vec<RecordedCycle<N>> {
    (0..recording.header().cycles).map_while(|number| recording.cycle(number)).collect()
}

fn written<const N: usize>(header: &Header, path: &[Span<f64, f64>], cycles: &[RecordedCycle<N>]) -> Vec<u8> {
    let mut writer = Writer::<N>::new(header.clone(), path).expect("a path that was read");
    cycles.iter().for_each(|cycle| writer.add(cycle));
    writer.finish().expect("a header that was read")
}

fn seeds() -> Vec<Vec<u8>> {
    vec![seed::<3>(false, 1), seed::<3>(true, 0), seed::<5>(false, 1), seed::<6>(true, 2), seed::<4>(false, 0)]
}

fn seed<const N: usize>(gauge: bool, lines: u32) -> Vec<u8> {
    let mut path: Vec<Span<f64, f64>> = Vec::new();
    for number in 0..lines {
        let x = f64::from(number);
        let line = Segment::Line { start: DVec3::new(x, 0.0, 0.0), end: DVec3::new(x + 1.0, 0.0, 0.0) };
        let pushed = convert(&line, number, [0.0, 0.0, 1.0], |span| {
            path.push(span);
            Ok(())
        });
        pushed.expect("a line is a path");
    }
    let header = Header {
        name: "seed".try_into().expect("a short name"),
        machine_id: 7,
        axes: 0,
        period_ns: 1_000_000,
        cycles: 0,
        pieces: 0,
        gauge,
        exchange_at: gauge.then_some(1),
    };
    let cycles = [0, 1].map(|i| RecordedCycle::<N> {
        command: [Nanometres(1000 * i); N],
        feedback: [Nanometres(i); N],
        elapsed_ns: 1_000_000,
        reference: Reference { span: 0, t: 0.5 },
        homed: true,
        enable: i == 1,
        reset: false,
        encoder_alarm: 0,
        probe: Probe { readings: [0.5; 3], spindle: i, index: gauge.then_some(i) },
    });
    written(&header, &path, &cycles)
}

/// Corrects length and sum.
fn repair(bytes: &mut [u8]) {
    let Some(content) = bytes.len().checked_sub(HEAD + 4).filter(|_| bytes.starts_with(&MAGIC)) else { return };
    bytes[10..HEAD].copy_from_slice(&(content as u32).to_le_bytes());
    sum::seal(bytes);
}
