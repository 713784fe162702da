//! Error of the tool at a point, before and after.

use super::Asked;
use crate::model::{thermal, with_compensation};
use anyhow::{Result, anyhow};
use trueaxis::compensation::{Compensation, Direction, Query, ThermalLine};
use trueaxis::machine::{AXES, Axis, AxisOrder, wraps};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::{Commanded, Geometry};

/// Error of the tool's pose, actual − ideal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    /// mm.
    pub(super) tip: [f64; 3],
    /// rad.
    pub(super) orientation: [f64; 3],
}

/// What a correction leaves.
pub(super) struct After {
    pub(super) pose: Pose,
    /// As sent, by [`Axis::index`]: mm, degrees.
    pub(super) correction: [f64; AXES],
    /// The limit of magnitude of an axis was met.
    pub(super) limited: bool,
}

/// A machine's geometry and what all points have in common. Lists of the geometry are in the order of the machine's axes,
/// those of the compensation in the order of the step, all others by [`Axis::index`].
pub(super) struct Sampler<'a, const N: usize> {
    pub(super) asked: &'a Asked,
    pub(super) geometry: Geometry,
    /// Axes in the geometry's order; the rest stay unused.
    own: Vec<Axis>,
    reverse: [f64; AXES],
    axes: [Axis; N],
    directions: [Direction; N],
    thermal: [ThermalLine<f64>; N],
    /// Limits of magnitude; none for a linear axis that the machine does not have: nothing is sent there.
    most: [f64; N],
}

impl<'a, const N: usize> Sampler<'a, N> {
    pub(super) fn new(asked: &'a Asked) -> Result<Self> {
        Sampler::of(asked, &asked.machine)
    }

    /// Of another machine with the same axes.
    pub(super) fn of(asked: &'a Asked, machine: &Machine) -> Result<Self> {
        let settings = &machine.settings;
        let order = AxisOrder::<N>::of(settings).map_err(|error| anyhow!("{error}"))?;
        let axes = order.axes();
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
            axes,
            directions: axes.map(|axis| Direction::of(asked.reverse[axis.index()])),
            thermal: thermal(machine, &axes, asked.kelvin),
            most: order.settings(settings).map(|own| own.map_or(0.0, |own| own.limits.magnitude)),
        })
    }

    /// Lends out the compensation of a machine with the same axes; `passes` of its inverse.
    pub(super) fn compensated<T>(
        &self,
        machine: &Machine,
        passes: u8,
        user: impl FnOnce(&Self, &Compensation<'_, f64, f64, N>) -> Result<T>,
    ) -> Result<T> {
        with_compensation(machine, passes, |compensation| user(self, compensation))
    }

    /// In the geometry's order.
    pub(super) fn slots(&self, letters: &[f64; AXES]) -> [f64; AXES] {
        let mut slots = [0.0; AXES];
        for (slot, axis) in slots.iter_mut().zip(&self.own) {
            *slot = letters[axis.index()];
        }
        slots
    }

    pub(super) fn before(&self, at: &[f64; AXES]) -> (Pose, Commanded) {
        let at = self.slots(at);
        let command = self.geometry.commanded(&at);
        (self.pose(&command, &at), command)
    }

    pub(super) fn after(
        &self,
        compensation: &Compensation<'_, f64, f64, N>,
        at: &[f64; AXES],
        command: &Commanded,
    ) -> After {
        let coordinates = compensation.coordinates(&self.axes.map(|axis| at[axis.index()]));
        let query = Query::at(&coordinates, &self.directions, &self.thermal);
        let wanted = compensation.correction(&query, &mut 0);
        let (mut correction, mut limited) = ([0.0; AXES], false);
        for ((axis, wanted), most) in self.axes.iter().zip(wanted).zip(self.most) {
            let sent = wanted.clamp(-most, most);
            limited |= sent != wanted && most > 0.0;
            correction[axis.index()] = sent;
        }
        let sent = std::array::from_fn(|index| at[index] + correction[index]);
        After { pose: self.pose(command, &self.slots(&sent)), correction, limited }
    }

    fn pose(&self, command: &Commanded, sent: &[f64; AXES]) -> Pose {
        let error = self.geometry.pose_error_of(command, sent, &self.reverse);
        Pose { tip: error.tip_mm, orientation: error.orientation }
    }

    /// Points of the grid at which an axis is beyond the end of its table.
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
