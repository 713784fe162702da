//! The Rust side of `examples/c/combinations.c`: writes the machine's table file and prints the sums.
//!
//! `cargo run -p trueaxis-capi --example combinations -- FIVE_AXES_WITH_GAUGE.tcomp`
use std::error::Error;
use trueaxis::contour::{CommandWindow, Path, PathBuilder, Reference, Segment, ToolPath, Turn};
use trueaxis::kinematics::{BranchTracker, Kinematics, Tool};
use trueaxis::roundness::{Gauge as CoreGauge, Probes};
use trueaxis::tcomp::Tcomp;
use trueaxis::{GaugeRide, HostServo, Input, OnToolPath};

#[allow(unsafe_code)]
#[path = "../tests/machines/mod.rs"]
mod machines;

const CYCLES: i32 = 8000;
const LAG: usize = 10;
const FROM: [f64; 5] = [10.0, 20.0, -100.0, 20.0, 5.0];
const TO: [f64; 5] = [50.0, 35.0, -90.0, 35.0, 25.0];

struct Sum(u64);

impl Sum {
    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        }
    }

    fn numbers(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|x| self.add(&x.to_ne_bytes()));
    }
}

/// Arranges the axes X Y Z A C as X Y Z A B C.
fn joints([x, y, z, a, c]: [f64; 5]) -> [f64; 6] {
    [x, y, z, a, 0.0, c]
}

fn main() -> Result<(), Box<dyn Error>> {
    let file = machines::gauge::with_gauge(machines::small_five(), 512);
    std::fs::write(std::env::args().nth(1).ok_or("a file name is needed")?, &file)?;
    let tables = Tcomp::parse(&file)?;
    let mut memory = vec![0.0; tables.requirement()];
    let servo = HostServo::<5>::load(&tables, machines::PERIOD_NS, &mut memory)?;
    let kinematics = Kinematics::<f64>::new(tables.settings())?;
    let settings = tables.settings().roundness.as_ref().ok_or("a gauge is needed")?;
    let gauge = Box::new(CoreGauge::<f64, 512>::build(settings, machines::PERIOD_NS)?);
    let [start, end] = [FROM, TO].map(|axes| kinematics.forward(&joints(axes)));
    let (mut spans, mut turns) = (Vec::new(), Vec::new());
    let line = Segment::Line { start: start.tip, end: end.tip };
    let [turn_from, turn_to] = [FROM, TO].map(|[_, _, _, a, c]| [a, 0.0, c]);
    PathBuilder::<f64>::new().append::<f64>(&line, |span| {
        turns.push(Turn::axes(&span, [0.0, 1.0], turn_from, turn_to));
        spans.push(span);
        Ok(())
    })?;
    let path = Path::new(&spans, 0, false);
    let tool_path = ToolPath::new(path, &turns);

    for kind in 0..4 {
        for with_gauge in [false, true] {
            let mut sum = Sum(0xcbf2_9ce4_8422_2325);
            let mut state = servo.start();
            let mut tracker = BranchTracker::new(&kinematics.inverse(&start, &joints(FROM))?, 0.1);
            let mut window = Box::new(CommandWindow::<f64, f64, 64>::new([0.0, 0.0, 1.0], 0.005)?);
            let mut gauge_state = Box::new(gauge.start());
            let mut drives = [FROM; LAG];
            for cycle in 0..CYCLES {
                let u = f64::from(cycle) / 8192.0;
                let mut at = FROM;
                for (at, to) in at.iter_mut().zip(TO) {
                    *at += (to - *at) * u;
                }
                let lagging = drives[cycle as usize % LAG];
                let mut input = servo.input(at, lagging);
                if kind == 3 {
                    let tip = start.tip + (end.tip - start.tip) * u;
                    let tool = Tool { tip, ..kinematics.forward(&joints(at)) };
                    input = servo.rtcp(&state, &tool, &mut tracker, &kinematics, &input);
                }
                let probes = Probes {
                    readings: [0, 1, 2].map(|probe| f64::from((cycle * (7 + 2 * probe)) % 512 - 256) / 256.0),
                    spindle: cycle * 1024,
                    index: (cycle > 0 && cycle % 1024 == 0).then_some(cycle * 1024),
                    ..Probes::default()
                };
                let input: &Input<f64, 5> = &input;
                let on: Reference<f64> = path.at(0, u).reference;
                let mut ride = GaugeRide::new(&gauge, &mut gauge_state, &probes);
                let mut tool = OnToolPath::new(&tool_path, on, &kinematics);
                let output = match (kind, with_gauge) {
                    (0, false) => servo.step(&mut state, input, (), ()),
                    (0, true) => servo.step(&mut state, input, (), &mut ride),
                    (1, false) => servo.step(&mut state, input, path.on(on), ()),
                    (1, true) => servo.step(&mut state, input, path.on(on), &mut ride),
                    (2, false) => servo.step(&mut state, input, &mut *window, ()),
                    (2, true) => servo.step(&mut state, input, &mut *window, &mut ride),
                    (_, false) => servo.step(&mut state, input, &mut tool, ()),
                    (_, true) => servo.step(&mut state, input, &mut tool, &mut ride),
                };
                drives[cycle as usize % LAG] = output.drive;
                sum.numbers(&output.drive);
                for contour in [&output.record.tip, &output.record.encoder] {
                    sum.numbers(&[contour.error, contour.lag]);
                    sum.numbers(&contour.vector.to_array());
                    sum.add(&[contour.flags.bits()]);
                }
                sum.numbers(&[output.record.orientation, ride.cycle().infeed]);
                sum.add(&ride.cycle().flags.0.to_ne_bytes());
                sum.add(&[u8::from(ride.cycle().finished)]);
                sum.numbers(&tool.orientation().vector.to_array());
            }
            println!("measure {kind}, gauge {}: {:016x}", u8::from(with_gauge), sum.0);
        }
    }
    Ok(())
}
