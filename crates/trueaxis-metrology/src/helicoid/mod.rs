//! The flank of an involute helical gear, and the axis positions of a five-axis mill-turn that align a tool with its normal.
//!
//! ```text
//! F(u, θ) = [ r_b (cos φ + u sin φ),  r_b (sin φ − u cos φ),  p θ ]       φ = u + θ
//! n(u, θ) = [ p sin φ, −p cos φ, r_b ] / √(p² + r_b²)
//! ```
//!
//! r_b is the radius of the base cylinder in mm, p the lead parameter in mm/rad (lead/2π, positive for a right-hand helix), u
//! the involute's roll angle in rad (0 on the base cylinder, where the surface has its cusp), θ the angle by which the
//! involute has climbed along the helix, in rad. The gear's axis is z. n is ∂F/∂u × ∂F/∂θ normalized, with the factor r_b u
//! removed: n is therefore defined on the base cylinder, too.
//!
//! [`Helicoid`] is the surface, [`Gear`] derives it from a gear's data, [`HeadTable`] is the machine.
//!
//! This module computes in f64 with trigonometric functions. It is for the bench, not for a servo cycle.
//!
//! Source: the parametric coordinates of a five-axis mill-turn (Nanjing Tech patent family), with the angle of the head
//! right-handed about x: A = −θ_A of that publication. Involute helicoid and gear data: ISO 21771:2007.

mod gear;
mod machine;
#[cfg(test)]
mod tests;

pub use gear::{Gear, GearData};
pub use machine::{Branch, Form, HeadTable, MachineSettings, Placement, ToolPose, pivot_length};

use crate::error::{InputError, Quantity};

/// Largest length accepted, mm; keeps every result finite.
const LONGEST_MM: f64 = 1e6;
/// Largest roll or helix angle accepted, rad; keeps an angle's rounding below 1e-11 rad.
const WIDEST_RAD: f64 = 1e4;

/// A side of a tooth, seen from the positive end of the z axis with the tip of the tooth pointing up (ISO 21771).
///
/// The involute with u > 0 leaves the base circle counter-clockwise, so the tooth's material is on its counter-clockwise side:
/// it is the *right* flank. u < 0 is its mirror image, the *left* flank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flank {
    /// u >= 0.
    Right,
    /// u <= 0.
    Left,
}

impl Flank {
    /// Returns the sign of u on the flank: 1 right, −1 left.
    pub const fn sign(self) -> f64 {
        match self {
            Flank::Right => 1.0,
            Flank::Left => -1.0,
        }
    }
}

/// One flank of an external involute helical tooth.
///
/// The outward normal of the material is sgn(u) sgn(p) n, and its z component has that sign. The tool comes from the side of
/// positive z, so a flank is accessible only if u p > 0: the right flank of a right-hand helix (p > 0), the left flank of a
/// left-hand one (p < 0). There n itself points outward. The other flank is cut with the part turned over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Helicoid {
    base_radius: f64,
    lead_parameter: f64,
    flank: Flank,
}

impl Helicoid {
    /// Creates the flank of base radius r_b (mm) and lead parameter p (mm/rad).
    ///
    /// # Errors
    /// r_b outside (0, 1e6] mm; p zero (a spur gear), beyond 1e6 mm/rad or not finite; a flank whose outward normal faces away
    /// from the tool.
    pub fn new(base_radius_mm: f64, lead_parameter_mm_per_rad: f64, flank: Flank) -> Result<Self, InputError> {
        if !(base_radius_mm > 0.0 && base_radius_mm <= LONGEST_MM) {
            return Err(InputError::new(Quantity::BaseRadius, base_radius_mm, "a radius above 0, at most 1e6 mm"));
        }
        let p = lead_parameter_mm_per_rad;
        if !(p != 0.0 && p.abs() <= LONGEST_MM) {
            let needed = "a lead parameter other than 0 (a flank that climbs), at most 1e6 mm/rad";
            return Err(InputError::new(Quantity::LeadParameter, p, needed));
        }
        if p * flank.sign() < 0.0 {
            let needed = match flank {
                Flank::Right => {
                    "p > 0 on the right flank: with p < 0 its outward normal faces away from the tool (left flank)"
                }
                Flank::Left => {
                    "p < 0 on the left flank: with p > 0 its outward normal faces away from the tool (right flank)"
                }
            };
            return Err(InputError::new(Quantity::Flank, p, needed));
        }
        Ok(Helicoid { base_radius: base_radius_mm, lead_parameter: p, flank })
    }

    /// Returns the radius r_b of the base cylinder, mm.
    pub const fn base_radius(&self) -> f64 {
        self.base_radius
    }

    /// Returns the lead parameter p, mm/rad; positive right-hand.
    pub const fn lead_parameter(&self) -> f64 {
        self.lead_parameter
    }

    /// Returns the side of the tooth.
    pub const fn flank(&self) -> Flank {
        self.flank
    }

    /// Returns the angle between the normal and the z axis.
    ///
    /// γ = atan2(p, r_b), rad, in (−π/2, π/2), with the sign of p; |γ| = 90° − β_b, β_b the base helix angle.
    pub fn tilt(&self) -> f64 {
        libm::atan2(self.lead_parameter, self.base_radius)
    }

    /// Refuses parameters outside the flank.
    ///
    /// # Errors
    /// u of the other flank's sign (0, the base cylinder, belongs to both); u or θ not finite or beyond 1e4 rad.
    pub fn contains(&self, u: f64, theta: f64) -> Result<(), InputError> {
        if !(-WIDEST_RAD..=WIDEST_RAD).contains(&u) {
            return Err(InputError::new(Quantity::RollAngle, u, "a finite angle, at most 1e4 rad"));
        }
        if u * self.flank.sign() < 0.0 {
            let needed = match self.flank {
                Flank::Right => "u >= 0 on the right flank",
                Flank::Left => "u <= 0 on the left flank",
            };
            return Err(InputError::new(Quantity::RollAngle, u, needed));
        }
        if !(-WIDEST_RAD..=WIDEST_RAD).contains(&theta) {
            return Err(InputError::new(Quantity::LeadAngle, theta, "a finite angle, at most 1e4 rad"));
        }
        Ok(())
    }

    /// Returns the surface point F(u, θ) in the gear's frame, mm.
    ///
    /// F = [r_b (cos φ + u sin φ), r_b (sin φ − u cos φ), p θ], φ = u + θ, both in rad.
    pub fn point(&self, u: f64, theta: f64) -> [f64; 3] {
        let (sin, cos) = libm::sincos(u + theta);
        let r = self.base_radius;
        [r * (cos + u * sin), r * (sin - u * cos), self.lead_parameter * theta]
    }

    /// Returns the unit normal n(u, θ) in the gear's frame, out of the tooth.
    ///
    /// n = [p sin φ, −p cos φ, r_b]/√(p² + r_b²), φ = u + θ; constant along a generator (u + θ constant).
    pub fn normal(&self, u: f64, theta: f64) -> [f64; 3] {
        let (sin, cos) = libm::sincos(u + theta);
        let (p, r) = (self.lead_parameter, self.base_radius);
        let length = libm::hypot(p, r);
        [p * sin / length, -p * cos / length, r / length]
    }
}
