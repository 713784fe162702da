//! No cycle of the step touches the heap, from the first to a fault and back.

use allocation_counter::measure;
use trueaxis::contour::{CommandWindow, Path, Reference, Segment, Span, convert};
use trueaxis::exchange::Exchange;
use trueaxis::glam::DVec3;
use trueaxis::tcomp::Tcomp;
use trueaxis::{Bypass, Fault, HostServo, Input};

const TABLES: &[u8] = include_bytes!("../mill-3axis.tcomp");
const PERIOD_NS: u32 = 100_000;

#[test]
fn the_step_does_not_allocate() {
    let tables = Tcomp::parse(TABLES).unwrap();
    let mut memory = vec![0.0; tables.requirement()];
    let servo = HostServo::<3>::load(&tables, PERIOD_NS, &mut memory).unwrap();
    let mut spans: Vec<Span<f64, f64>> = Vec::new();
    let line = Segment::Line { start: DVec3::new(10.0, -30.0, -200.0), end: DVec3::new(110.0, -30.0, -200.0) };
    convert(&line, 0, [0.0, 0.0, 1.0], |span| {
        spans.push(span);
        Ok(())
    })
    .unwrap();
    let path = Path::new(&spans, 0, false);
    let (mut state, mut following) = (servo.start(), servo.start());
    let mut commanded = CommandWindow::<f64, f64, 32>::new([0.0, 0.0, 1.0], 0.005).unwrap();
    let mut bypass = Bypass::<f64, 3>::new(Fault::TablesRefused);
    let exchange = Exchange::new();
    let mut active = &servo;

    let (mut measured, mut faults) = (0, 0);
    let run = measure(|| {
        for cycle in 0..4000 {
            let along = 0.02 * f64::from(cycle);
            let command = [10.0 + along, -30.0, -200.0];
            let mut input =
                Input { command, feedback: command, homed: true, enable: true, ..Input::at_rest(PERIOD_NS) };
            input.feedback[1] += 1e-3 * f64::from(cycle % 7);
            // An occasional lost reading; at the end a jump of the command.
            if cycle % 100 == 99 {
                input.feedback[0] = f64::NAN;
            }
            if cycle == 3900 {
                input.command[0] += 90.0;
            }
            let place = along / 100.0 * spans.len() as f64;
            let reference = Reference { span: place as u32, t: place.fract() };
            let _ = exchange.offer(&servo);
            exchange.take_into(&mut active);
            let output = active.step(&mut state, &input, path.on(reference), ());
            let followed = active.step(&mut following, &input, &mut commanded, ());
            measured += u32::from(output.record.tip.is_measured()) + u32::from(followed.record.tip.is_measured());
            faults += u32::from(output.record.fault != Fault::None);
            bypass.step::<f64>(&input);
        }
    });
    assert_eq!((run.count_total, run.bytes_total), (0, 0));
    assert!(measured > 7000 && faults > 40, "{measured} {faults}");
}

#[test]
fn an_allocation_would_be_seen() {
    let run = measure(|| {
        std::hint::black_box(vec![0_u8; 16]);
    });
    assert_eq!((run.count_total, run.bytes_total), (1, 16));
}
