//! Circles as a program, and what drives and encoders did on them.

use anyhow::{Result, anyhow};
use std::fmt::Write;
use trueaxis_metrology::friction::{Record, Recorded};
use trueaxis_sim::program::Program;
use trueaxis_sim::run::{ErrorSize, Kind, Moment, Run, Sample};
use trueaxis_sim::{Scenario, Settings};
use trueaxis_tables::Machine;

/// Cycles between two looks at the progress.
const STRETCH: u64 = 4096;
/// Angle at which the circles begin and end, rad: no axis turns there.
const START: f64 = 0.5;

/// Circles of one radius at two feeds, each in both directions.
pub(super) struct Circles {
    pub(super) radius_mm: f64,
    pub(super) feeds_mm_per_min: [f64; 2],
    pub(super) turns: u32,
}

impl Circles {
    /// The program. X and Y stand while Z moves a little: at the start and between the circles.
    fn program(&self) -> String {
        let [x, y] = [self.radius_mm * START.cos(), self.radius_mm * START.sin()];
        let mut text = format!("G17 G21 G90 G94\nG0 X{x:.6} Y{y:.6} Z0\n");
        for feed in self.feeds_mm_per_min {
            for code in ["G3", "G2"] {
                let _ = write!(
                    text,
                    "G1 Z0.2 F60\nG1 Z0\n{code} X{x:.6} Y{y:.6} I{:.6} J{:.6} P{} F{feed}\n",
                    -x, -y, self.turns
                );
            }
        }
        text + "G1 Z0.2 F60\nM2\n"
    }
}

/// One pass of the circles, cycle by cycle; X and Y.
pub(super) struct Pass {
    pub(super) period_s: f64,
    /// Sent to the drives, mm.
    drive: [Vec<f64>; 2],
    /// Command and correction of geometry, without the dynamic one: where the axes should be, mm.
    path: [Vec<f64>; 2],
    /// Read at the end of the cycle, mm.
    reading: [Vec<f64>; 2],
    /// Contour error of the true tip.
    pub(super) error: ErrorSize,
    /// Cycles of the run.
    pub(super) cycles: u64,
}

/// Runs the circles on one machine.
pub(super) fn record(
    circles: &Circles,
    machine: Machine,
    settings: Settings,
    kind: Kind,
    progress: &mut dyn FnMut(f64),
) -> Result<Pass> {
    let program = Program::parse("circles", &circles.program(), "circles.ngc")?;
    let period_s = 1.0 / settings.rate_hz;
    let mut run = Run::of(Scenario::new(machine, program, settings)?, &[kind])?;
    let none = || [Vec::new(), Vec::new()];
    let [mut drive, mut path, mut reading] = [none(), none(), none()];
    let mut sink = |_: &Moment, machines: &[Option<&Sample>]| {
        let [Some(sample)] = machines else { return };
        for i in 0..2 {
            drive[i].push(sample.drive[i]);
            path[i].push(sample.command[i] + 1e-3 * f64::from(sample.correction[i]));
            reading[i].push(sample.feedback[i]);
        }
    };
    while run.advance(STRETCH, &mut sink) {
        progress(run.cycle() as f64 / run.cycles() as f64);
    }
    let tallies = run.tallies().pop().ok_or_else(|| anyhow!("found no machine in the run, needed one"))?;
    // A cycle's reading was taken at the end of the one before.
    for i in 0..2 {
        drive[i].pop();
        path[i].pop();
        reading[i] = reading[i].split_off(1.min(reading[i].len()));
    }
    Ok(Pass { period_s, drive, path, reading, error: tallies.error, cycles: run.cycles() })
}

impl Pass {
    /// What the drives were sent and the encoders read.
    pub(super) fn sent(&self) -> Result<Record> {
        self.record(&self.drive)
    }

    /// Where the axes should have been and what the encoders read.
    pub(super) fn path(&self) -> Result<Record> {
        self.record(&self.path)
    }

    fn record(&self, commands: &[Vec<f64>; 2]) -> Result<Record> {
        let times: Vec<f64> = (0..commands[0].len()).map(|k| k as f64 * self.period_s).collect();
        let recorded = |i: usize| Recorded {
            axis: super::AXES[i],
            command: commands[i].clone(),
            reading: self.reading[i].clone(),
        };
        Record::new(&times, [recorded(0), recorded(1)]).map_err(|refused| anyhow!("the recorded circles: {refused}"))
    }

    /// The record as `trueaxis friction` reads it.
    pub(super) fn csv(&self) -> String {
        let mut text = String::from("t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm\n");
        for k in 0..self.drive[0].len() {
            let [time, x, y] = [k as f64 * self.period_s, self.drive[0][k], self.drive[1][k]];
            let _ = writeln!(text, "{time:.6},{x:.7},{:.7},{y:.7},{:.7}", self.reading[0][k], self.reading[1][k]);
        }
        text
    }
}
