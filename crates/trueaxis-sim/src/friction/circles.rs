//! Circles as a program, and a record of drives and encoders on them.

use crate::error::{Result, SimError};
use crate::program::Program;
use crate::run::{ErrorSize, Kind, Moment, Run, Sample};
use crate::{Scenario, Settings};
use std::fmt::Write;
use trueaxis::Axis;
use trueaxis_metrology::friction::{Record, Recorded};
use trueaxis_tables::Machine;

/// Angle at which the circles begin and end, rad: no axis reverses there.
const START: f64 = 0.5;

/// Plane of the circles; the order of its axes gives the sense of rotation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// G17.
    #[default]
    Xy,
    /// G18.
    Zx,
    /// G19.
    Yz,
}

impl Plane {
    /// First and second axis.
    pub fn axes(self) -> [Axis; 2] {
        match self {
            Plane::Xy => [Axis::X, Axis::Y],
            Plane::Zx => [Axis::Z, Axis::X],
            Plane::Yz => [Axis::Y, Axis::Z],
        }
    }

    /// Plane of the two named axes: `XY`, `ZX` or `YZ`.
    pub fn named(name: &str) -> Option<Plane> {
        match name {
            "XY" => Some(Plane::Xy),
            "ZX" => Some(Plane::Zx),
            "YZ" => Some(Plane::Yz),
            _ => None,
        }
    }

    /// G-code, words of the centre, axis normal to the plane.
    fn words(self) -> (&'static str, [char; 2], char) {
        match self {
            Plane::Xy => ("G17", ['I', 'J'], 'Z'),
            Plane::Zx => ("G18", ['K', 'I'], 'Y'),
            Plane::Yz => ("G19", ['J', 'K'], 'X'),
        }
    }
}

/// Circles of one radius at two feeds, each in both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circles {
    plane: Plane,
    pub(super) radius_mm: f64,
    pub(super) feeds_mm_per_min: [f64; 2],
    pub(super) turns: u32,
}

impl Circles {
    /// Circles of 1 to 1000 mm radius at two feeds of 10 to 20000 mm/min, 1 to 20 turns of each.
    ///
    /// # Errors
    /// A figure out of its range: [`SimError::Unsuited`] with the argument's name.
    pub fn new(plane: Plane, radius_mm: f64, feeds_mm_per_min: &[f64], turns: u32) -> Result<Circles> {
        if !(1.0..=1000.0).contains(&radius_mm) {
            return Err(SimError::unsuited("radius_mm", radius_mm.to_string(), "1 to 1000"));
        }
        let Ok(feeds_mm_per_min) = <[f64; 2]>::try_from(feeds_mm_per_min) else {
            return Err(SimError::unsuited("feeds", format!("{} feeds", feeds_mm_per_min.len()), "two"));
        };
        if let Some(feed) = feeds_mm_per_min.into_iter().find(|feed| !(10.0..=20_000.0).contains(feed)) {
            return Err(SimError::unsuited("feeds", feed.to_string(), "10 to 20000 mm/min"));
        }
        if !(1..=20).contains(&turns) {
            return Err(SimError::unsuited("turns", turns.to_string(), "1 to 20"));
        }
        Ok(Circles { plane, radius_mm, feeds_mm_per_min, turns })
    }

    /// The axes of the circles' plane.
    pub fn axes(&self) -> [Axis; 2] {
        self.plane.axes()
    }

    /// The program. While the third axis moves a little, at the start and between the circles, the plane's axes are at rest.
    pub fn program(&self) -> String {
        let (code, [i, j], across) = self.plane.words();
        let [first, second] = self.axes().map(Axis::letter);
        let [x, y] = [self.radius_mm * libm::cos(START), self.radius_mm * libm::sin(START)];
        let mut text = format!("{code} G21 G90 G94\nG0 {first}{x:.6} {second}{y:.6} {across}0\n");
        for feed in self.feeds_mm_per_min {
            for code in ["G3", "G2"] {
                let _ = write!(
                    text,
                    "G1 {across}0.2 F60\nG1 {across}0\n{code} {first}{x:.6} {second}{y:.6} {i}{:.6} {j}{:.6} P{} F{feed}\n",
                    -x, -y, self.turns
                );
            }
        }
        text + &format!("G1 {across}0.2 F60\nM2\n")
    }
}

/// One pass of the circles in progress; it can be paused between any two cycles.
#[derive(Debug)]
pub struct Recorder {
    run: Run,
    log: Log,
}

/// Log of the two axes of the plane, cycle by cycle.
#[derive(Clone, Debug)]
struct Log {
    axes: [Axis; 2],
    period_s: f64,
    /// Sent to the drives, mm.
    drive: [Vec<f64>; 2],
    /// Command and geometric correction, without the dynamic one: the required positions of the axes, mm.
    path: [Vec<f64>; 2],
    /// Readings at the end of the cycle, mm.
    reading: [Vec<f64>; 2],
}

/// One pass of the circles.
#[derive(Clone, Debug)]
pub struct Pass {
    log: Log,
    /// Contour error of the true tip.
    pub error: ErrorSize,
    /// Cycles of the run.
    pub cycles: u64,
}

impl Recorder {
    /// Sets up the circles on one machine.
    ///
    /// # Errors
    /// As [`Scenario::new`] and [`Run::of`].
    ///
    /// Memory: 48 bytes per cycle.
    pub fn new(circles: &Circles, machine: Machine, settings: Settings, kind: Kind) -> Result<Recorder> {
        let program = Program::parse("circles", &circles.program(), "circles.ngc")?;
        let period_s = 1.0 / settings.rate_hz;
        let run = Run::of(Scenario::new(machine, program, settings)?, &[kind])?;
        let none = || [Vec::new(), Vec::new()];
        let log = Log { axes: circles.axes(), period_s, drive: none(), path: none(), reading: none() };
        Ok(Recorder { run, log })
    }

    /// Simulates at most `cycles` further cycles; returns `false` at the end of the program.
    pub fn advance(&mut self, cycles: u64) -> bool {
        let log = &mut self.log;
        let mut sink = |_: &Moment, machines: &[Option<&Sample>]| {
            let [Some(sample)] = machines else { return };
            for (i, axis) in log.axes.map(Axis::index).into_iter().enumerate() {
                log.drive[i].push(sample.drive[axis]);
                log.path[i].push(sample.command[axis] + 1e-3 * f64::from(sample.correction[axis]));
                log.reading[i].push(sample.feedback[axis]);
            }
        };
        self.run.advance(cycles, &mut sink)
    }

    /// Simulated share of the program, 0 to 1.
    pub fn progress(&self) -> f64 {
        self.run.cycle() as f64 / self.run.cycles().max(1) as f64
    }

    /// The pass, once [`Recorder::advance`] has ended.
    pub fn finish(self) -> Pass {
        let Recorder { run, mut log } = self;
        // The reading of a cycle belongs to the end of the previous one.
        for i in 0..2 {
            log.drive[i].pop();
            log.path[i].pop();
            log.reading[i] = log.reading[i].split_off(1.min(log.reading[i].len()));
        }
        let error = run.tallies().pop().map(|tallies| tallies.error).unwrap_or_default();
        Pass { log, error, cycles: run.cycles() }
    }
}

impl Pass {
    /// Record of the commands sent to the drives and the encoder readings.
    ///
    /// # Errors
    /// As [`Record::new`].
    pub fn sent(&self) -> Result<Record> {
        self.record(&self.log.drive)
    }

    /// Record of the required axis positions and the encoder readings.
    ///
    /// # Errors
    /// As [`Record::new`].
    pub fn path(&self) -> Result<Record> {
        self.record(&self.log.path)
    }

    fn record(&self, commands: &[Vec<f64>; 2]) -> Result<Record> {
        let times: Vec<f64> = (0..commands[0].len()).map(|k| k as f64 * self.log.period_s).collect();
        let recorded = |i: usize| Recorded {
            axis: self.log.axes[i],
            command: commands[i].clone(),
            reading: self.log.reading[i].clone(),
        };
        Record::new(&times, [recorded(0), recorded(1)]).map_err(SimError::friction("the recorded circles"))
    }

    /// The record in the format that `trueaxis friction` reads.
    pub fn csv(&self) -> String {
        joined([self, self])
    }
}

/// The record of two passes of the same circles: the first axis as in the one, the second as in the other.
pub fn joined(passes: [&Pass; 2]) -> String {
    let logs = passes.map(|pass| &pass.log);
    let [first, second] = [0, 1].map(|i| logs[i].axes[i].letter().to_ascii_lowercase());
    let mut text = format!("t_s,{first}_cmd_mm,{first}_mm,{second}_cmd_mm,{second}_mm\n");
    for k in 0..logs[0].drive[0].len().min(logs[1].drive[1].len()) {
        let time = k as f64 * logs[0].period_s;
        let [[x, at_x], [y, at_y]] = [0, 1].map(|i| [logs[i].drive[i][k], logs[i].reading[i][k]]);
        let _ = writeln!(text, "{time:.6},{x:.7},{at_x:.7},{y:.7},{at_y:.7}");
    }
    text
}
