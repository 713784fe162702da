//! Error of the tool at a point, before and after.

use super::Asked;
use crate::compensate::{Model, Place, Settings, with_model};
use crate::positions::in_order;
use anyhow::{Result, anyhow};
use trueaxis::compensation::Direction;
use trueaxis::machine::{AXES, Axis, wraps};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::{Commanded, Geometry};

/// Error of the tool's pose, actual − ideal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    /// Error of the tip, mm.
    pub(super) tip: [f64; 3],
    /// Error of the orientation, rad.
    pub(super) orientation: [f64; 3],
}

/// The residual after a correction.
pub(super) struct After {
    pub(super) pose: Pose,
    /// Correction as sent, by [`Axis::index`]: mm, degrees.
    pub(super) correction: [f64; AXES],
    /// Whether an axis met its magnitude limit.
    pub(super) limited: bool,
}

/// A machine's geometry and what all points have in common. Arrays of the geometry are in the order of the machine's axes, all
/// others by [`Axis::index`].
pub(super) struct Sampler<'a> {
    pub(super) asked: &'a Asked,
    pub(super) geometry: Geometry,
    /// Axes in the geometry's order; the rest stay unused.
    own: Vec<Axis>,
    reverse: [f64; AXES],
    directions: [Direction; AXES],
    /// Magnitude limits; 0 for an axis that the machine does not have, so that it receives no correction.
    most: [f64; AXES],
}

impl<'a> Sampler<'a> {
    pub(super) fn new(asked: &'a Asked) -> Result<Self> {
        Sampler::of(asked, &asked.machine)
    }

    /// A sampler for another machine with the same axes.
    pub(super) fn of(asked: &'a Asked, machine: &Machine) -> Result<Self> {
        let settings = &machine.settings;
        let geometry = Geometry::new(machine, asked.kelvin).map_err(|error| anyhow!("{error}"))?;
        let own: Vec<Axis> = settings.axes.iter().map(|own| own.axis).collect();
        let mut reverse = [0.0; AXES];
        for (slot, axis) in own.iter().enumerate() {
            reverse[slot] = if asked.reverse[axis.index()] { 1.0 } else { 0.0 };
        }
        Ok(Sampler {
            asked,
            geometry,
            own,
            reverse,
            directions: asked.reverse.map(Direction::of),
            most: Axis::ALL.map(|axis| settings.axis(axis).map_or(0.0, |own| own.limits.magnitude)),
        })
    }

    /// Lends the model of a machine with the same axes to `user`; `passes` of its inverse.
    pub(super) fn compensated<T>(
        &self,
        machine: &Machine,
        passes: u8,
        user: impl FnOnce(&Self, &dyn Model) -> Result<T>,
    ) -> Result<T> {
        let settings = Settings { exact: false, passes: Some(passes), kelvin: self.asked.kelvin };
        with_model(machine, &settings, |model| user(self, model))
    }

    /// `letters` in the geometry's order.
    pub(super) fn slots(&self, letters: &[f64; AXES]) -> [f64; AXES] {
        in_order(self.own.iter().copied(), letters)
    }

    pub(super) fn before(&self, at: &[f64; AXES]) -> (Pose, Commanded) {
        let at = self.slots(at);
        let command = self.geometry.commanded(&at);
        (self.pose(&command, &at), command)
    }

    pub(super) fn after(&self, model: &dyn Model, at: &[f64; AXES], command: &Commanded) -> Result<After> {
        let wanted = model.correction(&Place { command: *at, directions: self.directions })?;
        let (mut correction, mut limited) = ([0.0; AXES], false);
        for ((correction, wanted), most) in correction.iter_mut().zip(wanted).zip(self.most) {
            *correction = wanted.clamp(-most, most);
            limited |= *correction != wanted && most > 0.0;
        }
        let sent = std::array::from_fn(|index| at[index] + correction[index]);
        Ok(After { pose: self.pose(command, &self.slots(&sent)), correction, limited })
    }

    fn pose(&self, command: &Commanded, sent: &[f64; AXES]) -> Pose {
        let error = self.geometry.pose_error_of(command, sent, &self.reverse);
        Pose { tip: error.tip_mm, orientation: error.orientation }
    }

    /// Number of grid points at which an axis is beyond the end of its table.
    pub(super) fn beyond_tables(&self) -> usize {
        let ends = self.asked.machine.axes().filter_map(|(own, table)| {
            let rows = table?.rows.as_slice();
            let ends = [rows.first()?.position, rows.last()?.position];
            (!wraps(own.axis, rows)).then_some((own.axis.index(), ends))
        });
        let ends: Vec<(usize, [f64; 2])> = ends.collect();
        let is_beyond = |index: &usize| {
            let at = self.asked.at(*index);
            ends.iter().any(|&(axis, [low, high])| at[axis] < low || at[axis] > high)
        };
        (0..self.asked.grid.count()).filter(is_beyond).count()
    }
}

/// Euclidean length.
pub(super) fn size([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}
