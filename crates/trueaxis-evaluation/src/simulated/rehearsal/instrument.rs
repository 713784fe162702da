//! What the instruments share: the machine under them, noise and drift.

use super::{Conditions, Stream, truth_of};
use crate::model::is_declared;
use anyhow::{Result, bail};
use trueaxis::machine::AxisSettings;
use trueaxis_metrology::uncertainty::Draws;
use trueaxis_sim::calibration::Drift;
use trueaxis_sim::measured::{Measured, Walk};
use trueaxis_tables::Machine;

/// Standard deviation of a reading where none is stated, µm.
pub const NOISE_UM: f64 = 0.1;
/// Time between two targets, s.
pub(super) const WALK_S: f64 = 10.0;

/// An instrument on a machine.
#[derive(Clone, Debug)]
pub struct Instrument<'m> {
    /// The machine with its true errors.
    pub truth: &'m Machine,
    /// The machine whose tables correct it; `None` if it is not corrected.
    pub(super) known: Option<&'m Machine>,
    /// Noise, drift, seed.
    pub conditions: Conditions,
}

impl<'m> Instrument<'m> {
    /// An instrument on `truth`, which the tables of `known` correct.
    ///
    /// # Errors
    /// Machines of two structures.
    pub fn new(truth: &'m Machine, known: Option<&'m Machine>, conditions: Conditions) -> Result<Instrument<'m>> {
        if let Some(known) = known {
            truth_of(truth, known)?;
        }
        Ok(Instrument { truth, known, conditions })
    }

    /// The same instrument on another machine.
    pub(super) fn of<'t>(&self, truth: &'t Machine) -> Instrument<'t>
    where
        'm: 't,
    {
        Instrument { truth, known: self.known, conditions: self.conditions }
    }

    /// Walks the machine; the noise is the stated one, or [`NOISE_UM`].
    pub(super) fn walk<T>(&self, user: impl FnOnce(&mut Walk<'_>) -> Result<T>) -> Result<T> {
        let conditions = &self.conditions;
        let measured = Measured {
            machine: self.truth,
            known: self.known,
            drift: Drift { rate: conditions.rate(), ..Drift::default() },
            noise_mm: 1e-3 * conditions.noise_um.unwrap_or(NOISE_UM),
            seed: conditions.seed,
        };
        measured.walk(|walk| Ok(user(walk)))?
    }
}

impl Conditions {
    /// Draws that are the same in every record of a set-up.
    pub(super) fn set_up_draws(&self) -> Draws {
        self.draws(Stream::SetUp)
    }
}

/// Middle of a declared travel; `option` states it otherwise.
pub(super) fn middle(own: &AxisSettings, option: &str) -> Result<f64> {
    if !is_declared(own) {
        let letter = own.axis.letter();
        bail!("found no axis.{letter}.travel_mm, needed it or {option}");
    }
    Ok(0.5 * (own.travel[0] + own.travel[1]))
}
