//! The whole five-axis step with tool direction, on a machine with a swivelling head and a rotary table.

use crate::Random;
use crate::step::{PASSES, PERIOD_NS};
use crate::tables::{Grid, POINTS, rows};
use trueaxis::contour::{Method, OrientationError, Path, Reference, Segment, Span, ToolPath, Turn, convert};
use trueaxis::glam::DVec3;
use trueaxis::kinematics::{BranchTracker, Kinematics, Tool};
use trueaxis::machine::MachineSettings;
use trueaxis::{Axis, Config, Input, OnToolPath, Output, Row, ServoLoop, State};
use trueaxis_testing::machine::Machine;

/// A running five-axis loop and the input of its next cycle.
#[derive(Clone, Copy, Debug)]
pub struct ToolCycle {
    servo: &'static ServoLoop<'static, f64, f64, 5>,
    kinematics: &'static Kinematics<f64>,
    state: State<f64, f64, 5>,
    follow: BranchTracker<f64>,
    input: Input<f64, 5>,
    tool: Tool<f64>,
    path: ToolPath<'static, f64, f64>,
    reference: Reference<f64>,
}

impl ToolCycle {
    /// Runs one cycle with commanded joints.
    #[inline(always)]
    pub fn run(&mut self) -> (Output<f64, f64, 5>, OrientationError<f64>) {
        let mut on = OnToolPath::new(&self.path, self.reference, self.kinematics);
        let output = self.servo.step(&mut self.state, &self.input, &mut on, ());
        (output, *on.orientation())
    }

    /// Runs one cycle with a commanded tool.
    #[inline(always)]
    pub fn run_rtcp(&mut self) -> (Output<f64, f64, 5>, OrientationError<f64>) {
        let input = self.servo.rtcp(&self.state, &self.tool, &mut self.follow, self.kinematics, &self.input);
        let mut on = OnToolPath::new(&self.path, self.reference, self.kinematics);
        let output = self.servo.step(&mut self.state, &input, &mut on, ());
        (output, *on.orientation())
    }
}

fn machine() -> MachineSettings {
    Machine::new("w C' b X Y Z A t").travel([-290.0, 325.0], 0.1).tool([0.0, 0.0, -150.0]).settings()
}

/// Equal numbers of points on all axes; a rotary table spans a closed full turn.
fn table(axis: Axis, seed: u64) -> Vec<Row> {
    let mut rows = rows(Grid::Equidistant, seed);
    if axis.is_rotary() {
        let cell = 360.0 / f64::from(POINTS - 1);
        let closing = rows[0];
        for (row, i) in rows.iter_mut().zip(0..) {
            row.position = cell * f64::from(i);
            if i == POINTS - 1 {
                *row = Row { position: row.position, ..closing };
            }
        }
    }
    rows
}

/// A straight line of 80 mm with both rotary axes turning.
fn path() -> (Vec<Span<f64, f64>>, Vec<Turn<f64>>) {
    let (mut spans, mut turns) = (Vec::new(), Vec::new());
    let line = Segment::Line { start: DVec3::new(10.0, 20.0, 0.0), end: DVec3::new(70.0, 70.0, 15.0) };
    convert(&line, 0, [0.0, 0.0, 1.0], |span| {
        turns.push(Turn::axes(&span, [0.0, 1.0], [15.0, 0.0, -20.0], [40.0, 0.0, 30.0]));
        spans.push(span);
        Ok(())
    })
    .expect("a line");
    (spans, turns)
}

/// A cycle of a walk at 50 mm/s with readings that deviate by ±2 µm, in which both searches end in the kernel and no limit
/// binds: nine terms, tables of 128 points, linear.
pub fn typical() -> ToolCycle {
    let machine: &'static MachineSettings = Box::leak(Box::new(machine()));
    let tables: Vec<Vec<Row>> = machine.axes.iter().zip(1..).map(|(axis, seed)| table(axis.axis, seed)).collect();
    let config = Config {
        machine,
        grids: &[],
        machine_id: 1,
        tables_crc: 2,
        period_ns: PERIOD_NS,
        inverse_passes: PASSES,
        method: Method::Guarded,
    };
    let rows = |axis: Axis| {
        let place = machine.axes.iter().position(|known| known.axis == axis)?;
        tables.get(place).map(Vec::as_slice)
    };
    let memory = vec![0.0; config.requirement(rows)].leak();
    let servo: ServoLoop<'static, f64, f64, 5> = config.build(rows, memory).expect("a valid configuration");
    let servo: &'static ServoLoop<'static, f64, f64, 5> = Box::leak(Box::new(servo));
    let kinematics: &'static Kinematics<f64> = Box::leak(Box::new(Kinematics::new(machine).expect("a valid chain")));
    let (spans, turns) = path();
    let (spans, turns): (&'static [_], &'static [_]) = (spans.leak(), turns.leak());
    let path = ToolPath::new(Path::new(spans, 0, false), turns);
    let tool_at = |number: usize, t: f64| {
        let axis = turns[number].direction(t, |[a, b, c]| kinematics.direction(&[0.0, 0.0, 0.0, a, b, c]));
        Tool { tip: spans[number].position(t).into(), axis }
    };
    let start = kinematics.inverse(&tool_at(0, 0.0), &[0.0, 0.0, 0.0, 15.0, 0.0, -20.0]).expect("within reach");
    let mut joints = BranchTracker::new(&start, 0.2);
    let mut cycle = ToolCycle {
        servo,
        kinematics,
        state: servo.start(),
        follow: joints,
        input: Input { homed: true, enable: true, ..Input::at_rest(PERIOD_NS) },
        tool: tool_at(0, 0.0),
        path,
        reference: Reference { span: 0, t: 0.0 },
    };
    let mut random = Random(23);
    let mut found = None;
    for number in 0..8000 {
        let place = (f64::from(number) - 4000.0).max(0.0) * 0.005 / spans[0].length();
        let (span, t) = ((place as usize).min(spans.len() - 1), place.fract());
        cycle.reference = Reference { span: span as u32, t };
        cycle.tool = tool_at(span, t);
        cycle.follow = joints;
        let [x, y, z, a, _, c] = joints.next(kinematics, &cycle.tool).expect("within reach").axes;
        cycle.input.command = [x, y, z, a, c];
        cycle.input.feedback = [x, y, z, a, c].map(|q| q + 0.002 * random.signed());
        let before = cycle;
        let (output, orientation) = cycle.run();
        let record = &output.record;
        let searched = [record.tip.evaluations, record.encoder.evaluations, orientation.evaluations];
        if searched == [2, 1, 1] && record.limited == 0 && number > 5000 {
            found = Some(before);
        }
    }
    found.expect("such a cycle")
}
