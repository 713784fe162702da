//! A grinding run that can be paused between any two cycles and resumed.

use super::Grinding;
use super::control::Control;
use super::gauging::gauging;
use super::result::{Moment, Revolution, Run};
use crate::error::Result;
use std::sync::Arc;
use trueaxis::roundness::GaugeSettings;

/// Most cycles that the work on a revolution takes.
pub(super) fn cycles_of_work(gauge: &GaugeSettings, period_ns: u32) -> Result<usize> {
    Ok(gauging(gauge, period_ns)?.cycles_of_work())
}

/// A grinding run in progress: servo loop, gauge, machine and workpiece, owned together.
pub struct Simulation(Box<Control>);

impl Simulation {
    /// Starts a run with the correction on or off; the gauge measures either way.
    ///
    /// # Errors
    /// The machine has no gauge with infeed correction, or its settings or tables do not build.
    pub fn new(grinding: impl Into<Arc<Grinding>>, corrected: bool) -> Result<Simulation> {
        let grinding = grinding.into();
        let mut settings = *grinding.gauge()?;
        if !corrected {
            settings.infeed = None;
        }
        let gauge = gauging(&settings, grinding.period_ns())?;
        Ok(Simulation(Box::new(Control::new(grinding, gauge)?)))
    }

    /// Simulates at most `cycles` further cycles and passes each to `observe`; returns `false` once the spindle has made the
    /// requested turns. Before the first cycle the tables' correction ramps in.
    ///
    /// # Errors
    /// The step reports a fault, or the spindle does not complete its turns.
    pub fn advance(&mut self, cycles: u64, observe: &mut dyn FnMut(&Moment<'_>)) -> Result<bool> {
        self.0.advance(cycles, observe)
    }

    /// Turns of the spindle since the first index pulse.
    pub fn turns(&self) -> f64 {
        self.0.turns()
    }

    /// The completed turns.
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

/// Grinds to the end; `observe` receives every cycle.
///
/// # Errors
/// As [`Simulation::new`] and [`Simulation::advance`].
pub fn run(grinding: &Grinding, corrected: bool, observe: &mut dyn FnMut(&Moment<'_>)) -> Result<Run> {
    let mut simulation = Simulation::new(grinding.clone(), corrected)?;
    while simulation.advance(u64::MAX, observe)? {}
    Ok(simulation.finish())
}
