//! Both runs of a comparison, one after the other and in slices.

use super::outcome::Outcome;
use super::{Grinding, Revolution, Run, Simulation};
use crate::error::{Result, SimError};
use std::sync::Arc;

/// Grinding without and then with correction, from one seed; it can be paused between any two cycles and resumed.
#[derive(Debug)]
pub struct Comparison {
    grinding: Arc<Grinding>,
    uncorrected: Option<Run>,
    running: Simulation,
    done: bool,
}

impl Comparison {
    /// Sets up both runs before the first cycle.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn new(grinding: impl Into<Arc<Grinding>>) -> Result<Comparison> {
        let grinding = grinding.into();
        let running = Simulation::new(Arc::clone(&grinding), false)?;
        Ok(Comparison { grinding, uncorrected: None, running, done: false })
    }

    /// The pin and its process.
    pub fn grinding(&self) -> &Grinding {
        &self.grinding
    }

    /// Simulates at most `cycles` further cycles; returns `false` once both runs have ended.
    ///
    /// # Errors
    /// As [`Simulation::advance`].
    pub fn advance(&mut self, cycles: u64) -> Result<bool> {
        if self.done || self.running.advance(cycles, &mut |_| {})? {
            return Ok(!self.done);
        }
        if self.uncorrected.is_some() {
            self.done = true;
            return Ok(false);
        }
        let corrected = Simulation::new(Arc::clone(&self.grinding), true)?;
        self.uncorrected = Some(std::mem::replace(&mut self.running, corrected).finish());
        Ok(true)
    }

    /// Completed share of both runs, 0 to 1.
    pub fn share(&self) -> f64 {
        let turns = f64::from(self.grinding.revolutions.max(1));
        let first = if self.uncorrected.is_some() { 1.0 } else { 0.0 };
        0.5 * (first + (self.running.turns() / turns).clamp(0.0, 1.0))
    }

    /// Turns so far, without and with correction.
    pub fn revolutions(&self) -> [&[Revolution]; 2] {
        match &self.uncorrected {
            None => [self.running.revolutions(), &[]],
            Some(before) => [&before.revolutions, self.running.revolutions()],
        }
    }

    /// Results of both runs.
    ///
    /// # Errors
    /// [`Comparison::advance`] has not reached the end.
    pub fn finish(self) -> Result<Outcome> {
        let share = 100.0 * self.share();
        match self.uncorrected.filter(|_| self.done) {
            Some(uncorrected) => Outcome::new(&self.grinding, uncorrected, self.running.finish()),
            None => Err(SimError::unsuited("grinding", format!("{share:.0} % of both runs"), "both to their end")),
        }
    }
}

/// Grinds twice with the same seed. `progress` gets the fraction done, 0 to 1.
///
/// # Errors
/// As [`Comparison::new`] and [`Comparison::advance`].
pub fn simulate(grinding: &Grinding, progress: &mut dyn FnMut(f64)) -> Result<Outcome> {
    let mut both = Comparison::new(grinding.clone())?;
    while both.advance(4096)? {
        progress(both.share());
    }
    both.finish()
}
