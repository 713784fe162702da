//! When a program reaches a place on its path.

use anyhow::{Result, anyhow};
use trueaxis_sim::motion::{Motion, MotionSettings};
use trueaxis_sim::placement::Placement;
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;

/// Time between two setpoints, s: no temperature changes faster.
const PERIOD_S: f64 = 0.1;
/// Most setpoints that are kept.
const MOST: u64 = 1_000_000;

/// Speed of rapids: that of the slowest of X, Y and Z.
pub(super) fn rapid_mm_per_min(machine: &Machine) -> f64 {
    let slowest = machine.settings.axes.iter().filter(|own| !own.axis.is_rotary()).map(|own| own.max_feed_per_s);
    let rapid = 60.0 * slowest.fold(f64::INFINITY, f64::min);
    if rapid.is_finite() { rapid } else { MotionSettings::default().rapid_mm_per_min }
}

/// Times of a program by the simulator's planner: programmed feeds, rapids as fast as the slowest of X, Y and Z, and the
/// planner's usual accelerations. Dwells, tool changes and spindle starts take no time.
pub(super) struct Times {
    /// Move, parameter on its curve, and time since the program's start, s.
    reached: Vec<(usize, f64, f64)>,
}

impl Times {
    /// `at_mm`: program zero in machine coordinates.
    ///
    /// # Errors
    /// A program that cannot be planned.
    pub(super) fn of(machine: &Machine, program: &Program, at_mm: [f64; 3]) -> Result<Times> {
        if program.moves.is_empty() {
            return Ok(Times { reached: Vec::new() });
        }
        let placement =
            Placement::new(machine, at_mm).map_err(|error| anyhow!("{}: {error}", machine.settings.name))?;
        let rapid_mm_per_min = rapid_mm_per_min(machine);
        let settings = MotionSettings { period_s: PERIOD_S, rapid_mm_per_min, ..MotionSettings::default() };
        let motion =
            Motion::plan_on(program, settings, &placement).map_err(|error| anyhow!("{}: {error}", program.file))?;
        let every = motion.cycles().div_ceil(MOST) as usize;
        let at_rest = trueaxis_sim::motion::DWELL_CYCLES as f64 * PERIOD_S;
        let timed = motion.setpoints(program).enumerate().map(|(cycle, of)| {
            let time = (cycle as f64 * PERIOD_S - at_rest).clamp(0.0, motion.duration());
            (of.move_index, of.u, time)
        });
        Ok(Times { reached: timed.step_by(every).collect() })
    }

    /// Time at the end, s.
    pub(super) fn end_s(&self) -> f64 {
        self.reached.last().map_or(0.0, |(_, _, time)| *time)
    }

    /// Time at a parameter on a move, s.
    pub(super) fn at(&self, step: usize, u: f64) -> f64 {
        let after = self.reached.partition_point(|(own, at, _)| (*own, *at) < (step, u));
        let Some((own, high, late)) = self.reached.get(after) else { return self.end_s() };
        match after.checked_sub(1).and_then(|before| self.reached.get(before)) {
            Some((before, low, early)) if before == own && high > low => {
                early + (late - early) * (u - low) / (high - low)
            }
            // Between two moves: no further than a period away.
            Some((_, _, early)) => 0.5 * (early + late),
            None => *late,
        }
    }
}
