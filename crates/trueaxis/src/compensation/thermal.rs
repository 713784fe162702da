//! Thermal growth of an axis, writable at run time.

use crate::machine::ThermalGrowth;
use crate::real::Real;

/// `K(q) = offset + slope · (q − q0)`: thermal error added to an axis' own positioning error.
///
/// mm (deg) and 1; positive = the axis goes too far in positive direction. The host sets it between two cycles from its
/// temperature sensors; a change reaches the drives through the limiter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThermalLine<R> {
    offset: R,
    slope: R,
}

impl<R: Real> ThermalLine<R> {
    /// Largest accepted |slope|: 1e-3, some eighty kelvin for steel.
    pub const SLOPE_LIMIT: f64 = 1e-3;

    /// Creates a line from its two numbers; `None` if one is not finite, the slope is beyond [`ThermalLine::SLOPE_LIMIT`]
    /// or the offset beyond 10 mm.
    pub fn new(offset: f64, slope: f64) -> Option<Self> {
        let sane = offset.abs() <= 10.0 && slope.abs() <= Self::SLOPE_LIMIT;
        sane.then_some(ThermalLine { offset: R::of(offset), slope: R::of(slope) })
    }

    /// The line for an axis at a temperature, `kelvin` above the reference.
    #[doc(hidden)]
    pub fn for_axis(growth: &ThermalGrowth, kelvin: f64) -> Option<Self> {
        Self::new(growth.offset_per_k * kelvin, growth.expansion_per_k * kelvin)
    }

    /// Slope of the line.
    #[inline(always)]
    pub(crate) fn slope(&self) -> R {
        self.slope
    }

    /// Growth at a distance from the datum q0.
    #[inline(always)]
    pub fn at(&self, from_datum: R) -> R {
        self.offset + self.slope * from_datum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_offset_and_expansion_times_kelvin() {
        let growth = ThermalGrowth { offset_per_k: 2e-3, expansion_per_k: 11e-6, datum: 40.0 };
        let line = ThermalLine::<f64>::for_axis(&growth, -3.0).unwrap();
        assert!((line.at(0.0) + 6e-3).abs() < 1e-18 && (line.slope() + 33e-6).abs() < 1e-20);
        // 11 µm per metre and kelvin: 3 K lengthen 500 mm by 16.5 µm.
        assert!((line.at(500.0) + 6e-3 + 16.5e-3).abs() < 1e-15);
        assert!(ThermalLine::<f64>::for_axis(&growth, 91.0).is_none());
    }
}
