//! The arm that swings about the grinding wheel's centre and carries the probes along with an orbiting pin.
//!
//! ```text
//! R sin α = (R_S + R_W) sin β      λ = R/(R_S + R_W)
//! θ = α + β                        e^{jβ} = (1 + λ e^{jθ}) / |1 + λ e^{jθ}|
//! ```
//!
//! R crank throw, R_S wheel radius, R_W pin radius; α spindle angle, β arm angle, θ angle over the pin's surface. The
//! second line follows from the triangle of crank centre, pin and wheel; it gives β at any θ in closed form, with one
//! square root and no inverse function. λ = 0 describes a fixed arm, for an ordinary shaft.

use crate::error::{ConfigError, Field};
use crate::range::{CRANK, RADIUS};
use crate::real::Real;

/// Lengths of the linkage, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Arm {
    /// Crank throw R: distance of the pin's centre from the spindle's axis.
    pub crank_mm: f64,
    /// Present radius R_S of the grinding wheel.
    pub wheel_mm: f64,
    /// Radius R_W of the pin.
    pub pin_mm: f64,
}

impl Arm {
    /// Checks that every length is in its range.
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        let Arm { crank_mm, wheel_mm, pin_mm } = *self;
        CRANK.check(crank_mm, Field::ArmCrank, None)?;
        RADIUS.check(wheel_mm, Field::ArmWheel, None)?;
        RADIUS.check(pin_mm, Field::ArmPin, None)
    }

    /// λ = R/(R_S + R_W).
    ///
    /// # Errors
    /// A length outside its range ([`CRANK`], [`RADIUS`]), or a linkage that cannot close (R >= R_S + R_W).
    pub fn ratio(&self) -> Result<f64, ConfigError> {
        self.check()?;
        if self.crank_mm >= self.wheel_mm + self.pin_mm {
            let needed = "a crank throw R below R_S + R_W: the linkage cannot close";
            return Err(ConfigError::new(Field::ArmCrank, self.crank_mm, needed));
        }
        Ok(self.crank_mm / (self.wheel_mm + self.pin_mm))
    }
}

/// `[cos β, sin β]` at `[cos θ, sin θ]`, 0 <= λ < 1.
#[inline(always)]
pub fn arm_angle<R: Real>(ratio: R, [cos, sin]: [R; 2]) -> [R; 2] {
    let (x, y) = (R::ONE + ratio * cos, ratio * sin);
    let scale = R::ONE / (x * x + y * y).sqrt();
    [x * scale, y * scale]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::machine::ARM;

    #[test]
    fn closes_the_triangle() {
        let ratio = ARM.ratio().unwrap();
        for i in 0..1000 {
            let alpha = f64::from(i) * 0.0123 - 6.0;
            let beta = (ratio * alpha.sin()).asin();
            let [cos, sin] = arm_angle(ratio, [(alpha + beta).cos(), (alpha + beta).sin()]);
            assert!((cos - beta.cos()).abs() < 1e-15 && (sin - beta.sin()).abs() < 1e-15, "{alpha}");
        }
        assert_eq!(arm_angle(0.0, [0.3, -0.4]), [1.0, 0.0]);
    }

    #[test]
    fn linkages_that_cannot_close_are_refused() {
        let arm = |crank_mm, wheel_mm, pin_mm| Arm { crank_mm, wheel_mm, pin_mm }.ratio();
        assert!(arm(330.0, 300.0, 30.0).is_err());
        assert!(arm(329.9, 300.0, 30.0).is_ok());
        assert_eq!(arm(0.0, 300.0, 30.0), Ok(0.0));
        assert_eq!(arm(40.0, 0.0, 50.0).unwrap_err().field, Field::ArmWheel);
        assert_eq!(arm(40.0, f64::NAN, 50.0).unwrap_err().field, Field::ArmWheel);
        assert_eq!(arm(-1.0, 300.0, 50.0).unwrap_err().field, Field::ArmCrank);
    }
}
