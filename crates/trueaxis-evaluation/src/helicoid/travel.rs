//! Travel of the axes, and the travel that a grid needs.

use super::job::{Job, five, number};
use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize};
use trueaxis::Axis;
use trueaxis::machine::MachineSettings;
use trueaxis_metrology::helicoid::Branch;

/// The five axes, in the order of all figures.
pub(super) const AXES: [Axis; 5] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::C];

/// Low and high end of each axis' travel, mm and degrees; `None` means no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields, rename_all = "UPPERCASE")]
pub struct Limits {
    /// Limits of X, mm.
    pub x: Option<[f64; 2]>,
    /// Limits of Y, mm.
    pub y: Option<[f64; 2]>,
    /// Limits of Z, mm.
    pub z: Option<[f64; 2]>,
    /// Limits of A, degrees.
    pub a: Option<[f64; 2]>,
    /// Limits of C, degrees.
    pub c: Option<[f64; 2]>,
}

impl Limits {
    /// Declared travel of a machine's axes X, Y, Z, A and C.
    pub fn of(machine: &MachineSettings) -> Limits {
        let [x, y, z, a, c] = AXES.map(|axis| machine.axis(axis).map(|own| own.travel));
        Limits { x, y, z, a, c }
    }

    pub(super) fn all(&self) -> [Option<[f64; 2]>; 5] {
        [self.x, self.y, self.z, self.a, self.c]
    }

    /// Refuses limits with the high end first.
    ///
    /// # Errors
    /// The axis, found and needed.
    pub fn check(&self) -> Result<()> {
        for (axis, limit) in AXES.into_iter().zip(self.all()) {
            if let Some([low, high]) = limit {
                let needed = "the low end first";
                ensure!(low <= high, "travel of {}: found {low} to {high}, needed {needed}", axis.letter());
            }
        }
        Ok(())
    }

    /// Axes beyond their limits.
    pub(super) fn beyond(&self, positions: &[f64; 5]) -> Vec<Beyond> {
        let limits = AXES.into_iter().zip(self.all()).zip(positions);
        limits
            .filter_map(|((axis, limit), &found)| {
                let [low, high] = limit.filter(|[low, high]| found < *low || found > *high)?;
                Some(Beyond { axis: axis.letter(), found, low, high })
            })
            .collect()
    }
}

/// An axis beyond its travel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Beyond {
    /// Letter of the axis.
    pub axis: char,
    /// Position, mm or degrees.
    pub found: f64,
    /// Low end of its travel.
    pub low: f64,
    /// High end of its travel.
    pub high: f64,
}

/// Travel of one axis over a grid.
#[derive(Clone, Debug, Serialize)]
pub struct AxisReach {
    /// Letter of the axis.
    pub axis: char,
    /// `mm` or `degrees`.
    pub unit: &'static str,
    /// Lowest position.
    pub low: f64,
    /// Highest position.
    pub high: f64,
    /// Low and high end of the axis' travel, if limited.
    pub limit: Option<[f64; 2]>,
    /// Number of grid points at which the axis is beyond its travel.
    pub beyond: usize,
}

/// Travel that a grid needs on one branch.
#[derive(Clone, Debug, Serialize)]
pub struct Reach {
    /// 1 or 2.
    pub branch: u8,
    /// X, Y, Z, A, C.
    pub axes: Vec<AxisReach>,
    /// Number of grid points at which any axis is beyond its travel.
    pub beyond: usize,
}

impl Job {
    /// Travel that the grid needs on each branch, and where it exceeds the limits.
    ///
    /// # Errors
    /// u or θ beyond the flank; limits with the high end first.
    pub fn reach(&self, limits: &Limits) -> Result<[Reach; 2]> {
        limits.check()?;
        Ok([self.reach_on(Branch::First, limits)?, self.reach_on(Branch::Second, limits)?])
    }

    fn reach_on(&self, branch: Branch, limits: &Limits) -> Result<Reach> {
        let mut axes = AXES.map(|axis| (axis, f64::INFINITY, f64::NEG_INFINITY, 0));
        let mut beyond = 0;
        for u in self.u.values() {
            for theta in self.theta.values() {
                let positions = five(&self.place(u, theta, branch)?);
                for ((_, low, high, _), position) in axes.iter_mut().zip(positions) {
                    (*low, *high) = (low.min(position), high.max(position));
                }
                let outside = limits.beyond(&positions);
                for (axis, _, _, beyond) in &mut axes {
                    *beyond += usize::from(outside.iter().any(|one| one.axis == axis.letter()));
                }
                beyond += usize::from(!outside.is_empty());
            }
        }
        let axes = axes.into_iter().zip(limits.all()).map(|((axis, low, high, beyond), limit)| AxisReach {
            axis: axis.letter(),
            unit: if axis.is_rotary() { "degrees" } else { "mm" },
            low,
            high,
            limit,
            beyond,
        });
        Ok(Reach { branch: number(branch), axes: axes.collect(), beyond })
    }
}
