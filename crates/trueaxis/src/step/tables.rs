//! Contents of a table file that a host uses beside the servo loop.

#![deny(clippy::indexing_slicing)]

use crate::axis::Axis;
use crate::compensation::ThermalLine;
use crate::error::ConfigError;
use crate::kinematics::Kinematics;
use crate::real::Real;
use crate::roundness::Gauge;
use crate::tcomp::Tcomp;

impl Tcomp<'_> {
    /// Name of the machine.
    pub fn name(&self) -> &str {
        &self.settings().name
    }

    /// Structural code of the machine (ISO 10791-6), for example `w X' b Y Z t`.
    pub fn chain(&self) -> &str {
        &self.settings().chain
    }

    /// The step's axes by slot: X, Y, Z, always all three, then the machine's rotary axes in alphabetical order.
    pub fn slots(&self) -> impl Iterator<Item = Axis> {
        self.settings().step_axes()
    }

    /// Declared travel of an axis, low and high, mm (deg); a command outside it is a fault. `None` if the machine lacks
    /// the axis.
    pub fn travel(&self, axis: Axis) -> Option<[f64; 2]> {
        self.settings().axis(axis).map(|settings| settings.travel)
    }

    /// Thermal growth of an axis at a temperature, `kelvin` above the reference of the tables. `None` if the machine
    /// lacks the axis, or if the growth is not finite, steeper than [`ThermalLine::SLOPE_LIMIT`] or beyond 10 mm.
    pub fn growth<R: Real>(&self, axis: Axis, kelvin: f64) -> Option<ThermalLine<R>> {
        ThermalLine::for_axis(&self.settings().axis(axis)?.thermal, kelvin)
    }

    /// The machine's chain of axes, for a tool commanded or measured in workpiece coordinates.
    ///
    /// # Errors
    /// A chain without X, Y and Z or with three rotary axes; a second rotary axis that cannot turn the tool; a build
    /// without the part `rotary`.
    pub fn kinematics<R: Real>(&self) -> Result<Kinematics<R>, ConfigError> {
        Kinematics::new(self.settings())
    }

    /// The machine's gauge at a servo period, `None` if it has none.
    ///
    /// # Errors
    /// `N` is not the gauge's number of points; the period is outside 1 µs to 0.1 s; a build without the part `gauge`.
    pub fn gauge<R: Real, const N: usize>(&self, period_ns: u32) -> Result<Option<Gauge<R, N>>, ConfigError> {
        self.settings().roundness.as_ref().map(|settings| Gauge::build(settings, period_ns)).transpose()
    }
}
