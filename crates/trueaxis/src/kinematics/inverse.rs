//! From the tool in workpiece coordinates to axis positions.
//!
//! In the frame of n1, n2, n1 × n2 let t0 = (a, b, c), t_w = (u, p, q). The second turn leaves b and has to bring the first
//! component to u; the third is then
//!
//! ```text
//! w = ∓√(p² + q² − b²)                                          − on branch 1, + on branch 2
//! θ2 = atan2(c u − a w, a u + c w),   θ1 = atan2(b q − w p, b p + w q),   q_i = s_i θ_i
//! ```
//!
//! Branch 1 is the pose in which the second axis has turned the tool by 0 … 180 degrees, right-handed, from where it
//! comes nearest to n1. The tip is then linear in X, Y, Z: three equations by Cramer's rule.
//!
//! Where w = 0 both branches meet and the rotary axes lose a freedom (with b = 0 the tool lies along n1, and q1 is
//! anything): the singular pose. An error of 1 µrad in t_w moves q1 by 1 µrad / sin(margin) there.

#![deny(clippy::indexing_slicing)]

use super::chain::Rotary;
use super::{Branch, InverseError, Kinematics, NO_SINGULAR_POSE, Tool, degrees, in_frame, turned};
use crate::compensation::trig::atan2;
use crate::machine::{AXES, Axis};
use crate::real::Real;
use crate::vector::{About, V3};

/// Length of a tool axis may differ from 1 by this; it is normalised.
const UNIT_TOLERANCE: f64 = 1e-3;
/// A direction this far beyond reach is taken for the nearest one within: rounding of the input, 1.7 µm at a metre.
const REACH_TOLERANCE_DEG: f64 = 1e-4;
/// Below this volume of their directions the linear axes no longer span space.
const LEAST_VOLUME: f64 = 1e-3;
/// A position this many units in the last place beyond the travel stands at its end.
const TRAVEL_ROUNDING: f64 = 64.0;
/// Below this many EPSILON a component across an axis is nothing but rounding.
const ALONG: f64 = 8.0;

/// Choice of a branch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Choice {
    /// The one whose larger rotary step is smaller; one outside the travel does not count.
    #[default]
    Nearest,
    /// Branch 1.
    First,
    /// Branch 2.
    Second,
}

/// Axis positions for a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Solution<R> {
    /// X Y Z A B C, mm and degrees; 0 for axes that the machine does not have.
    pub axes: [R; AXES],
    /// The branch; [`Branch::First`] for machines with less than two rotary axes.
    pub branch: Branch,
    /// Angle between the tool and the rotary axis nearest the workpiece, 0 … 90 degrees; where the tool axis has a
    /// component along the other rotary axis at zero, the angle to the plane of both. 90 with less than two rotary axes.
    pub singularity_margin_deg: R,
    /// Largest step of a rotary axis from where it was, degrees.
    pub step_deg: R,
}

/// The two poses of the rotary axes, or why there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Solutions<R> {
    /// Branch 1.
    pub first: Result<Solution<R>, InverseError>,
    /// Branch 2; [`InverseError::OneBranch`] for machines with less than two rotary axes.
    pub second: Result<Solution<R>, InverseError>,
}

impl<R: Real> Solutions<R> {
    /// One of the two.
    ///
    /// # Errors
    /// Why there is none; with [`Choice::Nearest`], why one of them has none, a linear axis named before a rotary one.
    pub fn choose(self, choice: Choice) -> Result<Solution<R>, InverseError> {
        match (choice, self.first, self.second) {
            (Choice::First, first, _) => first,
            (Choice::Second, _, second) => second,
            (Choice::Nearest, Ok(first), Ok(second)) => {
                Ok(if second.step_deg < first.step_deg { second } else { first })
            }
            (Choice::Nearest, Ok(found), Err(_)) | (Choice::Nearest, Err(_), Ok(found)) => Ok(found),
            // The branch that the rotary axes could reach says more.
            (Choice::Nearest, Err(InverseError::OutsideTravel { axis, .. }), Err(second))
                if axis.is_rotary() && second != InverseError::OneBranch =>
            {
                Err(second)
            }
            (Choice::Nearest, first, _) => first,
        }
    }
}

impl<R: Real> Kinematics<R> {
    /// Axis positions for a tool, nearest to `near` (X Y Z A B C, mm and degrees).
    ///
    /// Rotary axes take the nearest angle, by whole turns, in their travel. Error: rounding; forward of the result is
    /// the tool within 1e-12 mm at a metre (f64). Cost: at most ten polynomials for angles, both branches included.
    ///
    /// # Errors
    /// An invalid tool vector, out of reach, in the singular cone, or whose axis positions leave the travel.
    pub fn inverse(&self, tool: &Tool<R>, near: &[R; AXES]) -> Result<Solution<R>, InverseError> {
        self.solutions(tool, near)?.choose(Choice::Nearest)
    }

    /// Axis positions on both branches.
    ///
    /// At the singular pose itself (singular cone 0) the axis nearest the workpiece stays where it is in `near`.
    ///
    /// # Errors
    /// Errors of both branches: an invalid tool vector, out of reach or in the singular cone.
    pub fn solutions(&self, tool: &Tool<R>, near: &[R; AXES]) -> Result<Solutions<R>, InverseError> {
        let [tip, axis] = [tool.tip, tool.axis].map(V3::<R>::from_glam);
        if !(tip.x.is_finite() && tip.y.is_finite() && tip.z.is_finite()) {
            return Err(InverseError::TipNotFinite);
        }
        let length = axis.norm();
        let off = (length - R::ONE).abs();
        if off.is_finite() && off <= R::of(UNIT_TOLERANCE) {
            let axis = axis * (R::ONE / length);
            match self.chain.turns {
                [Some(first), Some(second)] => self.two_turns(tip, axis, near, first, second),
                [Some(turn), None] | [None, Some(turn)] => self.one_turn(tip, axis, near, turn),
                [None, None] => self.no_turn(tip, axis),
            }
        } else {
            Err(InverseError::NotADirection { length: length.to_f64() })
        }
    }

    fn two_turns(
        &self,
        tip: V3<R>,
        axis: V3<R>,
        near: &[R; AXES],
        first: Rotary<R>,
        second: Rotary<R>,
    ) -> Result<Solutions<R>, InverseError> {
        let [a, b, c] = in_frame(first.about, second.about, self.tool_axis);
        let [u, p, q] = in_frame(first.about, second.about, axis);
        let across_square = p * p + q * q;
        let square = across_square - b * b;
        if square < R::ZERO {
            let most = atan2(b.abs(), (a * a + c * c).sqrt());
            within_reach(most - atan2(across_square.sqrt(), u.abs()))?;
        }
        let across = square.sqrt();
        let margin_deg = degrees(atan2(across, (u * u + b * b).sqrt()));
        if margin_deg < self.cone_deg {
            let (margin_deg, cone_deg) = (margin_deg.to_f64(), self.cone_deg.to_f64());
            return Err(InverseError::SingularPose { margin_deg, cone_deg });
        }
        let along = R::of(ALONG) * R::EPSILON;
        let free = across_square <= along * along;
        let branch = |branch: Branch, w: R| {
            let q1 = if free {
                let [low, high] = first.travel;
                first.position(near).limit(low, high)
            } else {
                first.settle(atan2(b * q - w * p, b * p + w * q), near)?
            };
            let q2 = second.settle(atan2(c * u - a * w, a * u + c * w), near)?;
            let step = (q1 - first.position(near)).abs().max((q2 - second.position(near)).abs());
            let mut axes = [R::ZERO; AXES];
            first.put(&mut axes, q1);
            second.put(&mut axes, q2);
            self.with_linear(tip, axes, Solution { axes, branch, singularity_margin_deg: margin_deg, step_deg: step })
        };
        Ok(Solutions { first: branch(Branch::First, -across), second: branch(Branch::Second, across) })
    }

    fn one_turn(
        &self,
        tip: V3<R>,
        axis: V3<R>,
        near: &[R; AXES],
        turn: Rotary<R>,
    ) -> Result<Solutions<R>, InverseError> {
        let across = match turn.about {
            About::X => About::Y,
            About::Y => About::Z,
            About::Z => About::X,
        };
        let [a, b, c] = in_frame(turn.about, across, self.tool_axis);
        let [u, p, q] = in_frame(turn.about, across, axis);
        let reach = atan2((b * b + c * c).sqrt(), a);
        within_reach((atan2((p * p + q * q).sqrt(), u) - reach).abs())?;
        let along = R::of(ALONG) * R::EPSILON;
        let angle = if b * b + c * c <= along * along {
            let [low, high] = turn.travel;
            Ok(turn.position(near).limit(low, high))
        } else {
            turn.settle(atan2(b * q - c * p, b * p + c * q), near)
        };
        let solution = angle.and_then(|angle| {
            let mut axes = [R::ZERO; AXES];
            turn.put(&mut axes, angle);
            let step_deg = (angle - turn.position(near)).abs();
            let singularity_margin_deg = R::of(NO_SINGULAR_POSE);
            self.with_linear(tip, axes, Solution { axes, branch: Branch::First, singularity_margin_deg, step_deg })
        });
        Ok(Solutions { first: solution, second: Err(InverseError::OneBranch) })
    }

    fn no_turn(&self, tip: V3<R>, axis: V3<R>) -> Result<Solutions<R>, InverseError> {
        within_reach(atan2(axis.cross(self.tool_axis).norm(), axis.dot(self.tool_axis)))?;
        let axes = [R::ZERO; AXES];
        let singularity_margin_deg = R::of(NO_SINGULAR_POSE);
        let still = Solution { axes, branch: Branch::First, singularity_margin_deg, step_deg: R::ZERO };
        Ok(Solutions { first: self.with_linear(tip, axes, still), second: Err(InverseError::OneBranch) })
    }

    /// X, Y, Z that bring the tip to its position, the rotary axes standing at `axes`.
    #[inline(always)]
    fn with_linear(&self, tip: V3<R>, axes: [R; AXES], solution: Solution<R>) -> Result<Solution<R>, InverseError> {
        let [first, second] = self.chain.turns.map(|turn| turn.map(|turn| (turn, turn.cos_sin(&axes))));
        let [before, between, behind] = self.chain.sections;
        let still = turned(second, behind.offset + self.tool);
        let wanted = tip - before.offset - turned(first, between.offset + still);
        let (k, m, n) = (before.moves, between.moves, behind.moves);
        let direction = |k: V3<R>, m: V3<R>, n: V3<R>| k + turned(first, m + turned(second, n));
        let zero = R::ZERO;
        let ex = direction(V3::new(k.x, zero, zero), V3::new(m.x, zero, zero), V3::new(n.x, zero, zero));
        let ey = direction(V3::new(zero, k.y, zero), V3::new(zero, m.y, zero), V3::new(zero, n.y, zero));
        let ez = direction(V3::new(zero, zero, k.z), V3::new(zero, zero, m.z), V3::new(zero, zero, n.z));
        let volume = ex.dot(ey.cross(ez));
        if volume.abs() < R::of(LEAST_VOLUME) {
            return Err(InverseError::LinearAxes { volume: volume.to_f64() });
        }
        let inverse = R::ONE / volume;
        let [travel_x, travel_y, travel_z] = self.chain.travel;
        let x = inside(Axis::X, wanted.dot(ey.cross(ez)) * inverse, travel_x)?;
        let y = inside(Axis::Y, wanted.dot(ez.cross(ex)) * inverse, travel_y)?;
        let z = inside(Axis::Z, wanted.dot(ex.cross(ey)) * inverse, travel_z)?;
        let [_, _, _, a, b, c] = axes;
        Ok(Solution { axes: [x, y, z, a, b, c], ..solution })
    }
}

impl<R: Real> Rotary<R> {
    /// The command for a turn (rad) that the workpiece sees: nearest to `near`, by whole turns within the travel.
    #[inline(always)]
    fn settle(&self, angle: R, near: &[R; AXES]) -> Result<R, InverseError> {
        let whole = R::of(360.0);
        let base = self.sense * degrees(angle);
        let turns = (self.position(near) - base) * R::of(1.0 / 360.0);
        let half = if turns < R::ZERO { -R::HALF } else { R::HALF };
        let nearest = base + whole * R::of_i32((turns + half).to_i32());
        let [low, high] = self.travel;
        let back = |beyond: R| {
            let turns = R::of_i32((beyond * R::of(1.0 / 360.0)).to_i32());
            whole * if turns * whole < beyond - rounding(beyond) { turns + R::ONE } else { turns }
        };
        let found = if nearest > high + rounding(high) {
            nearest - back(nearest - high)
        } else if nearest < low - rounding(low) {
            nearest + back(low - nearest)
        } else {
            nearest
        };
        // Reported is the position nearest to where the axis was, not the one at the far end.
        inside(self.axis, found, self.travel).or_else(|_| inside(self.axis, nearest, self.travel))
    }

    /// Writes this axis' position.
    #[inline(always)]
    fn put(&self, axes: &mut [R; AXES], position: R) {
        let [_, _, _, a, b, c] = axes;
        match self.axis {
            Axis::A => *a = position,
            Axis::B => *b = position,
            _ => *c = position,
        }
    }
}

/// Rounding error of a position of this size.
#[inline(always)]
fn rounding<R: Real>(position: R) -> R {
    R::of(TRAVEL_ROUNDING) * R::EPSILON * (position.abs() + R::of(360.0))
}

/// The position where it is within the travel (up to rounding).
#[inline(always)]
fn inside<R: Real>(axis: Axis, found: R, [low, high]: [R; 2]) -> Result<R, InverseError> {
    if found >= low - rounding(low) && found <= high + rounding(high) {
        Ok(found.limit(low, high))
    } else {
        let [found, low, high] = [found, low, high].map(R::to_f64);
        Err(InverseError::OutsideTravel { axis, found, low, high })
    }
}

/// Refuses a direction that is `beyond` (rad) what the rotary axes reach.
#[inline(always)]
fn within_reach<R: Real>(beyond: R) -> Result<(), InverseError> {
    let by = degrees(beyond);
    if by > R::of(REACH_TOLERANCE_DEG) { Err(InverseError::Unreachable { by_deg: by.to_f64() }) } else { Ok(()) }
}
