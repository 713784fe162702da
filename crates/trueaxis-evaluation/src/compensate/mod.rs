//! Error and correction of a machine at positions, in the requested model.
//!
//! ```text
//! Machine ─► with_model ─► Model ─► error, correction at a Place
//! ```

mod exact;
mod step;

use crate::by_axes;
use crate::model::takes_rise;
use crate::positions::Travel;
use anyhow::{Result, bail};
use std::fmt;
use trueaxis::compensation::Direction;
use trueaxis::machine::{AXES, Axis};
use trueaxis_tables::Machine;

/// How to look up a machine; its own settings select the nine-term or volumetric model and whether to correct the orientation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Whether to use exact products of rigid transforms in place of the servo step's model.
    pub exact: bool,
    /// Look-ups of the exact inverse, 1 to 8; `None`: as many as the machine needs, of exact transforms until it converges.
    pub passes: Option<u8>,
    /// Kelvin above the reference temperature.
    pub kelvin: f64,
}

/// Commanded positions and directions of travel of the axes; arrays are indexed by axis, X, Y, Z, A, B, C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Command, mm and degrees.
    pub command: [f64; AXES],
    /// Direction of travel of every axis.
    pub directions: [Direction; AXES],
}

/// Error of the tool relative to the workpiece, actual − ideal, machine coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseError {
    /// Error of the tip, mm.
    pub tip: [f64; 3],
    /// Error of the orientation, a small rotation, rad; 0 in the nine-term model.
    pub orientation: [f64; 3],
    /// Whether an axis is beyond the end of its table.
    pub clamped: bool,
}

/// A pose in which no motion of the linear axes removes the error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoCorrection;

impl NoCorrection {
    /// Text after "found" in errors.
    pub const FOUND: &str = "a pose in which the linear axes cannot correct the error";
    /// Text after "needed" in errors.
    pub const NEEDED: &str = "three independent directions of the linear axes";
}

impl fmt::Display for NoCorrection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "found {}, needed {}", Self::FOUND, Self::NEEDED)
    }
}

impl std::error::Error for NoCorrection {}

/// Error and correction of one machine at any place.
pub trait Model: Sync {
    /// Error of the uncorrected command. Cost: one look-up.
    fn error(&self, at: &Place) -> PoseError;

    /// Amount added to the command of every axis, mm and degrees. Cost: as many look-ups as the inverse has passes.
    ///
    /// # Errors
    /// With exact transforms, a pose without a correction.
    fn correction(&self, at: &Place) -> Result<[f64; AXES], NoCorrection>;

    /// As [`Model::correction`], and whether an axis of the command is beyond the end of its table.
    ///
    /// # Errors
    /// As [`Model::correction`].
    fn correction_and_clamped(&self, at: &Place) -> Result<([f64; AXES], bool), NoCorrection> {
        Ok((self.correction(at)?, self.error(at).clamped))
    }

    /// This model at many positions, if it has a form for them.
    fn batch(&self) -> Option<&dyn Many> {
        None
    }
}

/// A model of X, Y, Z alone at many positions, mm: at each, the numbers of [`Model`].
pub trait Many: Sync {
    /// Writes the error of the tip at every position, mm; returns the number of positions beyond a table's end.
    fn errors(&self, positions: &[[f64; 3]], directions: &[Direction; AXES], tips: &mut [[f64; 3]]) -> usize;

    /// Writes the correction at every position, mm; returns the number of positions beyond a table's end.
    fn corrections(
        &self,
        positions: &[[f64; 3]],
        directions: &[Direction; AXES],
        corrections: &mut [[f64; 3]],
    ) -> usize;
}

/// How the axes arrive at successive positions.
#[derive(Clone, Debug)]
pub enum Arrival {
    /// All in positive travel.
    Positive,
    /// All in negative travel, backlash included.
    Negative,
    /// As the drives, position and correction, arrive from the previous positions, starting in positive travel.
    InOrder(Travel),
}

impl Arrival {
    /// Arrival in the order of the positions.
    pub fn in_order(machine: &Machine) -> Arrival {
        Arrival::InOrder(Travel::new(machine, Axis::ALL.into_iter()))
    }

    /// The directions of travel if they are the same at all positions.
    pub(crate) fn directions(&self) -> Option<[Direction; AXES]> {
        match self {
            Arrival::Positive => Some([Direction::POSITIVE; AXES]),
            Arrival::Negative => Some([Direction::of(true); AXES]),
            Arrival::InOrder(_) => None,
        }
    }

    /// Arrives at the next position. Cost: in order, one correction per round in which directions settle, usually one.
    ///
    /// # Errors
    /// In order: a pose without a correction.
    pub fn at(&mut self, model: &dyn Model, command: [f64; AXES]) -> Result<Place, NoCorrection> {
        let directions = match self {
            Arrival::Positive => [Direction::POSITIVE; AXES],
            Arrival::Negative => [Direction::of(true); AXES],
            Arrival::InOrder(travel) => {
                travel.arrive(&command, |&directions| model.correction(&Place { command, directions }))?
            }
        };
        Ok(Place { command, directions })
    }
}

/// Builds the model of a machine and lends it to `user`. The number of axes is then not part of the type, so every user is
/// compiled once.
///
/// # Errors
/// A machine that the model refuses or that needs more than 8 passes, a thermal growth that the step does not accept; errors
/// of `user`.
pub fn with_model<T>(machine: &Machine, settings: &Settings, user: impl FnOnce(&dyn Model) -> Result<T>) -> Result<T> {
    user(&*model(machine, settings, &mut Vec::new())?)
}

fn model<'m>(machine: &'m Machine, settings: &Settings, memory: &'m mut Vec<f64>) -> Result<Box<dyn Model + 'm>> {
    if settings.exact {
        return Ok(Box::new(exact::Exact::new(machine, settings)?));
    }
    if !takes_rise(machine, settings.kelvin) {
        bail!(
            "temperature: found {} K above the reference, needed a growth of at most 10 mm and 1e-3",
            settings.kelvin
        );
    }
    by_axes!(machine.settings.step_axes().count(), step::model(machine, settings, memory))
}
