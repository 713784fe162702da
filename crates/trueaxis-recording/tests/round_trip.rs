//! A recording reads back bit for bit; a damaged one is refused.
#![allow(missing_docs)]

use trueaxis::Nanometres;
use trueaxis::contour::{Reference, Segment, Span, convert};
use trueaxis::glam::DVec3;
use trueaxis_recording::{Header, Probe, RecordedCycle, Recording, RecordingRefusal, Writer};

fn segments() -> [Segment<'static>; 3] {
    [
        Segment::Line { start: DVec3::new(0.1, 0.2, 0.3), end: DVec3::new(30.0, -7.0 / 3.0, 1.0) },
        Segment::Arc {
            start: DVec3::new(30.0, 0.0, 0.0),
            end: DVec3::new(-30.0, 1e-9, 4.0),
            center: DVec3::ZERO,
            normal: DVec3::new(0.0, 0.0, 1.0),
            turns: 1,
        },
        Segment::Nurbs {
            degree: 3,
            knots: &[0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
            points: const { &[DVec3::ZERO, DVec3::new(1.0, 7.0, 0.0), DVec3::new(5.0, 3.0, 1.0), DVec3::splat(9.0)] },
            weights: &[1.0, 0.7, 1.3, 1.0],
        },
    ]
}

fn spans<R: trueaxis::Real, P: trueaxis::Position>() -> Vec<Span<R, P>> {
    let mut spans = Vec::new();
    for (number, segment) in segments().iter().enumerate() {
        convert(segment, number as u32, [0.0, 0.0, 1.0], |span| {
            spans.push(span);
            Ok(())
        })
        .unwrap();
    }
    spans
}

fn cycle(i: i32) -> RecordedCycle<3> {
    RecordedCycle {
        command: [Nanometres(i), Nanometres(-i), Nanometres(i * 1000)],
        feedback: [Nanometres(i + 1), Nanometres(i32::MIN), Nanometres(i32::MAX)],
        elapsed_ns: 1_000_000 + i as u32,
        reference: Reference { span: i as u32 / 7, t: i as f32 / 100.0 },
        homed: i % 2 == 0,
        enable: i % 3 == 0,
        reset: i % 5 == 0,
        encoder_alarm: i as u8,
        probe: Probe { readings: [0.1, -0.2, i as f32], spindle: -i * 65_537, index: (i % 10 == 0).then_some(i * 3) },
    }
}

fn recording(gauge: bool) -> Vec<u8> {
    let header = Header {
        name: "round trip".try_into().unwrap(),
        machine_id: 77,
        axes: 0,
        period_ns: 1_000_000,
        cycles: 0,
        pieces: 0,
        gauge,
        exchange_at: Some(50),
    };
    let mut writer = Writer::<3>::new(header, &spans()).unwrap();
    (0..100).for_each(|i| writer.add(&cycle(i)));
    writer.finish().unwrap()
}

#[test]
fn recordings_are_read_back() {
    for gauge in [false, true] {
        let mut bytes = recording(gauge);
        // A region of flash is longer than its content.
        bytes.extend([0xff; 1000]);
        let read = Recording::<3>::parse(&bytes).unwrap();
        assert_eq!((read.header().cycles, read.header().machine_id), (100, 77));
        for i in 0..100 {
            let written = cycle(i);
            let probe = if gauge { written.probe } else { Probe::default() };
            assert_eq!(read.cycle(i as u32), Some(RecordedCycle { probe, ..written }));
        }
        assert_eq!(read.cycle(100), None);
        let path: Vec<Span<f64, f64>> = read.path().collect();
        assert_eq!(path, spans::<f64, f64>());
        // The rounded path is the result of the conversion in that scalar.
        let rounded: Vec<Span<f32, Nanometres>> = read.path().collect();
        assert_eq!(rounded, spans::<f32, Nanometres>());
    }
}

#[test]
fn nothing_damaged_is_read() {
    let bytes = recording(true);
    for length in 0..bytes.len() {
        assert!(Recording::<3>::parse(&bytes[..length]).is_err(), "cut to {length}");
    }
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        assert!(Recording::<3>::parse(&damaged).is_err(), "bit of byte {at}");
    }
    assert!(matches!(Recording::<4>::parse(&bytes), Err(RecordingRefusal::Axes)));
    assert!(matches!(Recording::<3>::parse(&[0xff; 64]), Err(RecordingRefusal::Magic)));
}
