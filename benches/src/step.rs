//! The whole three-axis step on the butterfly.

use crate::Random;
use crate::contour::{Shape, Track};
use crate::tables::{Grid, machine, memory, rows};
use trueaxis::contour::{Method, Path, Reference};
use trueaxis::machine::{GridData, MachineSettings};
use trueaxis::{Axis, Config, Input, Output, ServoLoop, State};

/// Servo period, ns.
pub const PERIOD_NS: u32 = 100_000;
/// Number of passes of the exact inverse.
pub const PASSES: u8 = 2;

/// A running servo loop and the input of its next cycle.
#[derive(Clone, Copy, Debug)]
pub struct RunningLoop {
    /// The loop.
    pub servo: &'static ServoLoop<'static, f64, f64, 3>,
    /// State of the loop.
    pub state: State<f64, f64, 3>,
    /// Command and readings.
    pub input: Input<f64, 3>,
    /// The butterfly.
    pub path: Path<'static, f64, f64>,
    /// Reference of the command on the path.
    pub reference: Reference<f64>,
}

impl RunningLoop {
    /// Runs one cycle.
    #[inline(always)]
    pub fn run(&mut self) -> Output<f64, f64, 3> {
        self.servo.step(&mut self.state, &self.input, self.path.on(self.reference), ())
    }
}

/// Cycles at rest before the walk, until the search is warm and the correction is fully applied.
pub const AT_REST: u32 = 2000;

/// Walks the butterfly at 100 mm/s, to its end or for `cycles` cycles, with readings that deviate by ±5 µm; calls `seen` with
/// the number of every cycle, the cycle before it ran, and its output.
pub fn walk(cycles: u32, seen: impl FnMut(u32, &RunningLoop, &Output<f64, f64, 3>)) {
    walk_with(|_| (), cycles, seen);
}

/// Like [`walk`], after a change of the machine.
pub fn walk_with(
    change: impl FnOnce(&mut MachineSettings),
    cycles: u32,
    seen: impl FnMut(u32, &RunningLoop, &Output<f64, f64, 3>),
) {
    walk_on(change, &[], cycles, seen);
}

/// Like [`walk_with`], with grids in addition to the tables.
pub fn walk_on(
    change: impl FnOnce(&mut MachineSettings),
    grids: &'static [GridData<'static>],
    cycles: u32,
    mut seen: impl FnMut(u32, &RunningLoop, &Output<f64, f64, 3>),
) {
    let mut machine = machine();
    change(&mut machine);
    let machine = Box::leak(Box::new(machine));
    let tables = [1, 2, 3].map(|seed| rows(Grid::Equidistant, seed));
    let config = Config {
        machine,
        grids,
        machine_id: 1,
        tables_crc: 2,
        period_ns: PERIOD_NS,
        inverse_passes: PASSES,
        method: Method::Guarded,
    };
    let servo = config.build(|axis: Axis| tables.get(axis.index()).map(Vec::as_slice), memory());
    let servo: &'static ServoLoop<'static, f64, f64, 3> = Box::leak(Box::new(servo.expect("a valid configuration")));
    let track = Track::new(Shape::RationalCubic);
    let mut cycle = RunningLoop {
        servo,
        state: servo.start(),
        input: Input { homed: true, enable: true, ..Input::at_rest(PERIOD_NS) },
        path: track.path(),
        reference: Reference { span: 0, t: 0.0 },
    };
    let mut random = Random(17);
    let mut place = 0.0;
    for number in 0..cycles {
        place += if number < AT_REST { 0.0 } else { 0.01 };
        let Some(mut span) = cycle.path.span(cycle.reference.span) else { break };
        if place > span.length() {
            if cycle.reference.span + 1 >= track.pieces() {
                break;
            }
            place -= span.length();
            cycle.reference.span += 1;
            span = cycle.path.span(cycle.reference.span).unwrap_or(span);
        }
        cycle.reference.t = span.t_at(place);
        cycle.input.command = span.position(cycle.reference.t);
        cycle.input.feedback = cycle.input.command.map(|x| x + 0.005 * random.signed());
        let before = cycle;
        let output = cycle.run();
        seen(number, &before, &output);
    }
}

/// The cycle of the walk with the most evaluations of the path, and the most limited axes among equals.
pub fn worst(cycles: u32) -> RunningLoop {
    let mut found = None;
    walk(cycles, |_, cycle, output| {
        let record = &output.record;
        let evaluations = u32::from(record.tip.evaluations) + u32::from(record.encoder.evaluations);
        let score = 4 * evaluations + record.limited.count_ones();
        if found.as_ref().is_none_or(|(best, _)| score > *best) {
            found = Some((score, *cycle));
        }
    });
    found.expect("at least one cycle").1
}
