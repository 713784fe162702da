//! Error and correction at a position, without state: for hosts that correct in the planner, and for the bench.

#![deny(clippy::indexing_slicing)]

use super::ServoLoop;
use crate::compensation::Query;
use crate::compensation::{Direction, Errors, PoseError, ThermalLine};
use crate::error::Fault;
use crate::position::Position;
use crate::real::Real;

/// Directions of travel and thermal growth for error lookups, slot by slot.
///
/// The step tracks both in its state. A planner sets the directions itself from one position to the next; an axis that
/// does not move keeps its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions<R, const N: usize> {
    /// Directions of travel.
    pub directions: [Direction; N],
    /// Thermal growth.
    pub thermal: [ThermalLine<R>; N],
}

impl<R: Real, const N: usize> Default for Conditions<R, N> {
    /// Positive travel of every axis, no growth.
    fn default() -> Self {
        Conditions { directions: [Direction::POSITIVE; N], thermal: [ThermalLine::default(); N] }
    }
}

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// Returns the modelled error at a position, actual − ideal: dx, dy, dz of the tip (mm, machine axes), then the
    /// errors of the rotary axes (degrees; zero in the volumetric form, see [`ServoLoop::pose_error_at`]).
    ///
    /// `position`: mm (degrees). Outside a table its edge value applies. Bounded: one lookup.
    ///
    /// # Errors
    /// [`Fault::CommandNotFinite`]: a position that is infinite, NaN or beyond the range of its type.
    ///
    /// ```
    /// # use trueaxis::{Conditions, HostServo, Tcomp};
    /// # let file = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/mill-3axis.tcomp"));
    /// # let tables = Tcomp::parse(file)?;
    /// # let mut memory = vec![0.0; tables.requirement()];
    /// # let servo = HostServo::<3>::load(&tables, 100_000, &mut memory)?;
    /// let command = [12.5, -30.0, -200.0];
    /// let correction = servo.correction_at(&command, &Conditions::default())?;
    /// let corrected = [0, 1, 2].map(|k| command[k] + correction[k]);
    /// let error = servo.error_at(&corrected, &Conditions::default())?;
    /// assert!((0..3).all(|k| (corrected[k] + error[k] - command[k]).abs() < 1e-6)); // within a nanometre
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn error_at(&self, position: &[P; N], conditions: &Conditions<R, N>) -> Result<Errors<R, N>, Fault> {
        usable(position)?;
        let at = self.compensation.coordinates(position);
        Ok(self.compensation.errors(&Query::at(&at, &conditions.directions, &conditions.thermal), &mut 0))
    }

    /// Returns the modelled error of the tool's pose at a position: tip (mm) and small rotation (rad), machine axes.
    ///
    /// # Errors
    /// As [`ServoLoop::error_at`].
    pub fn pose_error_at(&self, position: &[P; N], conditions: &Conditions<R, N>) -> Result<PoseError<R>, Fault> {
        usable(position)?;
        let at = self.compensation.coordinates(position);
        Ok(self.compensation.pose_error(&Query::at(&at, &conditions.directions, &conditions.thermal), &mut 0))
    }

    /// Returns the correction for the error at a command, mm (degrees): the value that the step's correction settles to
    /// at standstill if no limit binds.
    ///
    /// Computed by the exact inverse with the configured number of passes, starting from zero (the step starts from the
    /// correction it sent last), and not limited in magnitude. Axes that look their errors up at the feedback are assumed
    /// to be at the command.
    ///
    /// # Errors
    /// [`Fault::CommandNotFinite`] as above; [`Fault::CommandOutOfTravel`]: outside the declared travel of an axis.
    pub fn correction_at(&self, command: &[P; N], conditions: &Conditions<R, N>) -> Result<[R; N], Fault> {
        usable(command)?;
        if !self.sampler.within_travel(command) {
            return Err(Fault::CommandOutOfTravel);
        }
        let at = self.compensation.coordinates(command);
        Ok(self.compensation.correction(&Query::at(&at, &conditions.directions, &conditions.thermal), &mut 0))
    }
}

fn usable<P: Position>(position: &[P]) -> Result<(), Fault> {
    if position.iter().all(|position| position.is_usable()) { Ok(()) } else { Err(Fault::CommandNotFinite) }
}

#[cfg(test)]
#[allow(clippy::indexing_slicing)]
mod tests;
