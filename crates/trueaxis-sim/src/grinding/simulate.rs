//! A grinding run that can be left between any two cycles and gone on with.

use super::Grinding;
use super::control::{Advance, Control};
use super::result::{Moment, Revolution, Run};
use crate::error::{Result, SimError};
use std::sync::Arc;
use trueaxis::roundness::{Gauge, GaugeSettings};

/// Calls a function that is generic over the points of a revolution.
macro_rules! with_points {
    ($points:expr, $function:ident, ($($argument:expr),*)) => {
        match $points {
            64 => $function::<64>($($argument),*),
            128 => $function::<128>($($argument),*),
            256 => $function::<256>($($argument),*),
            512 => $function::<512>($($argument),*),
            1024 => $function::<1024>($($argument),*),
            2048 => $function::<2048>($($argument),*),
            4096 => $function::<4096>($($argument),*),
            other => {
                let needed = "a power of two from 64 to 4096";
                Err(SimError::unsuited("[roundness] points", other.to_string(), needed))
            }
        }
    };
}

/// Cycles that the work on a revolution takes at most.
pub(super) fn cycles_of_work(gauge: &GaugeSettings, period_ns: u32) -> Result<usize> {
    fn of<const POINTS: usize>(gauge: &GaugeSettings, period_ns: u32) -> Result<usize> {
        Ok(build::<POINTS>(gauge, period_ns)?.cycles_of_work())
    }
    with_points!(gauge.points, of, (gauge, period_ns))
}

fn build<const POINTS: usize>(gauge: &GaugeSettings, period_ns: u32) -> Result<Box<Gauge<f64, POINTS>>> {
    Ok(Box::new(Gauge::build(gauge, period_ns).map_err(SimError::Gauge)?))
}

/// A grinding run under way: servo loop, gauge, machine and workpiece, owned together.
pub struct Simulation(Box<dyn Advance + Send>);

impl Simulation {
    /// With the correction on or off; the gauge measures either way.
    ///
    /// # Errors
    /// The machine has no gauge with infeed correction, or something about it does not build.
    pub fn new(grinding: impl Into<Arc<Grinding>>, corrected: bool) -> Result<Simulation> {
        fn of<const POINTS: usize>(grinding: Arc<Grinding>, corrected: bool) -> Result<Simulation> {
            let mut settings = *grinding.gauge()?;
            if !corrected {
                settings.infeed = None;
            }
            let gauge = build::<POINTS>(&settings, grinding.period_ns())?;
            Ok(Simulation(Box::new(Control::new(grinding, gauge)?)))
        }
        let grinding = grinding.into();
        let points = grinding.gauge()?.points;
        with_points!(points, of, (grinding, corrected))
    }

    /// Simulates at most `cycles` further cycles, each of which `observe` sees; `false` once the spindle has turned as often
    /// as asked for. Before the first cycle the tables' correction is led in.
    ///
    /// # Errors
    /// The step reports a fault, or the spindle does not get on.
    pub fn advance(&mut self, cycles: u64, observe: &mut dyn FnMut(&Moment<'_>)) -> Result<bool> {
        self.0.advance(cycles, observe)
    }

    /// Turns of the spindle since the first index pulse.
    pub fn turns(&self) -> f64 {
        self.0.turns()
    }

    /// The turns that are complete.
    pub fn revolutions(&self) -> &[Revolution] {
        self.0.revolutions()
    }

    /// Figures of the turns so far.
    pub fn finish(self) -> Run {
        self.0.finish()
    }
}

impl std::fmt::Debug for Simulation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Simulation").finish_non_exhaustive()
    }
}

/// Grinds to the end; `observe` sees every cycle.
///
/// # Errors
/// As [`Simulation::new`] and [`Simulation::advance`].
pub fn run(grinding: &Grinding, corrected: bool, observe: &mut dyn FnMut(&Moment<'_>)) -> Result<Run> {
    let mut simulation = Simulation::new(grinding.clone(), corrected)?;
    while simulation.advance(u64::MAX, observe)? {}
    Ok(simulation.finish())
}
