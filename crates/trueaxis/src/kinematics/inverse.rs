//! Transforms the tool in workpiece coordinates to axis positions.
//!
//! In the frame of n1, n2, n1 × n2 let t0 = (a, b, c), t_w = (u, p, q). The second turn leaves b unchanged and must bring the
//! first component to u; the third is then
//!
//! ```text
//! w = ∓√(p² + q² − b²)                                          − on branch 1, + on branch 2
//! θ2 = atan2(c u − a w, a u + c w),   θ1 = atan2(b q − w p, b p + w q),   q_i = s_i θ_i
//! ```
//!
//! As sums, with one angle of each kind for both branches: `θ2 = atan2(c, a) ± atan2(|w|, u)`,
//! `θ1 = atan2(q, p) ± atan2(|w|, b)`, + on branch 1. Their cosines and sines are the arguments above divided by their lengths.
//!
//! Branch 1 is the pose in which the second axis has turned the tool by 0 … 180 degrees, right-handed, from the position where
//! the tool comes nearest to n1. The tip is then linear in X, Y, Z: three equations, solved by Cramer's rule.
//!
//! Where w = 0 both branches meet and the rotary axes lose a degree of freedom (with b = 0 the tool lies along n1, and
//! q1 is arbitrary): the singular pose. Near it an error of 1 µrad in t_w moves q1 by 1 µrad / sin(margin). Within the
//! singular cone κ, the first axis starts from its present position and turns by the smallest angle that keeps the
//! error of the tool within
//!
//! ```text
//! L(m) = κ/2 for m ≤ κ/2,   m sin(180° m/κ) from there to κ      m: the margin; L is 0 at κ and at most 0.58 κ
//! sin(β − L) ≤ h cos(θ1 − atan2(q, p)) ≤ sin(β + L)              h² = p² + q², sin β = b
//! ```
//!
//! The second axis turns the tool as near to t_w as possible. L is continuous, so a path without a jump gives positions
//! without one, at any spacing of its points. If b = 0, the first axis stays still throughout the inner half of the cone, and
//! the angle that it may be off falls in proportion from 90° to 0 through the outer half.

#![deny(clippy::indexing_slicing)]

use super::chain::Rotary;
use super::{Branch, InverseError, Kinematics, NO_SINGULAR_POSE, Tool, degrees, in_frame, turned};
use crate::compensation::trig::{atan2, cos_sin_deg};
use crate::machine::{AXES, Axis};
use crate::real::Real;
use crate::vector::{About, V3};

/// Permitted deviation of a tool axis's length from 1; the axis is then normalised.
const UNIT_TOLERANCE: f64 = 1e-3;
/// A direction this far beyond reach is replaced by the nearest reachable one: rounding of the input, 1.7 µm at a metre.
const REACH_TOLERANCE_DEG: f64 = 1e-4;
/// Volume of their directions below which the linear axes no longer span space.
const LEAST_VOLUME: f64 = 1e-3;
/// A position this many units in the last place beyond the travel counts as at its end.
const TRAVEL_ROUNDING: f64 = 64.0;
/// Below this many EPSILON a component across an axis is only rounding.
const ALONG: f64 = 8.0;

/// Choice of a branch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Choice {
    /// The branch whose largest rotary step is smaller, among those within the travel.
    #[default]
    Nearest,
    /// Branch 1.
    First,
    /// Branch 2.
    Second,
}

/// Axis positions that place a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(not(feature = "bench"), non_exhaustive)]
pub struct Solution<R> {
    /// X Y Z A B C, mm and degrees; 0 for axes that the machine does not have.
    pub axes: [R; AXES],
    /// The branch; [`Branch::First`] for machines with fewer than two rotary axes.
    pub branch: Branch,
    /// Angle between the requested tool and the rotary axis nearest the workpiece, 0 … 90 degrees; if the tool axis has a
    /// component along the other rotary axis at zero, the angle to the plane of both. 90 with fewer than two rotary axes.
    pub singularity_margin_deg: R,
    /// Angle between the reached and the requested tool, degrees: 0 outside the singular cone; inside it at most 0.58 of the
    /// cone or, if an end of a travel is in the way, at most the cone. The tip is exact.
    pub direction_error_deg: R,
    /// Largest step of a rotary axis from its previous position, degrees.
    pub step_deg: R,
}

/// The two poses of the rotary axes, or the reasons why they do not exist.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Solutions<R> {
    /// Branch 1.
    pub first: Result<Solution<R>, InverseError>,
    /// Branch 2; [`InverseError::OneBranch`] for machines with fewer than two rotary axes.
    pub second: Result<Solution<R>, InverseError>,
}

impl<R: Real> Solutions<R> {
    /// Selects one of the two.
    ///
    /// # Errors
    /// The selected branch's error; with [`Choice::Nearest`] the error of one of them, preferring a linear axis to a rotary
    /// one.
    pub fn choose(self, choice: Choice) -> Result<Solution<R>, InverseError> {
        match (choice, self.first, self.second) {
            (Choice::First, first, _) => first,
            (Choice::Second, _, second) => second,
            (Choice::Nearest, Ok(first), Ok(second)) => {
                Ok(if second.step_deg < first.step_deg { second } else { first })
            }
            (Choice::Nearest, Ok(found), Err(_)) | (Choice::Nearest, Err(_), Ok(found)) => Ok(found),
            // The branch that the rotary axes can reach has the more informative error.
            (Choice::Nearest, Err(InverseError::OutsideTravel { axis, .. }), Err(second))
                if axis.is_rotary() && second != InverseError::OneBranch =>
            {
                Err(second)
            }
            (Choice::Nearest, first, _) => first,
        }
    }
}

/// Quantities common to both branches, for two rotary axes that point the tool.
#[derive(Clone, Copy, Debug)]
struct Aim<R> {
    tip: V3<R>,
    first: Rotary<R>,
    second: Rotary<R>,
    /// a, b, c and u, p, q as in the module documentation, and |w|.
    tool: [R; 3],
    wanted: [R; 3],
    across: R,
    /// Angles midway between the branches, and from there to either branch.
    middle: [R; 2],
    apart: [R; 2],
    /// Reciprocals of the lengths of both axes' cosine and sine.
    inverse: [R; 2],
    margin_deg: R,
    cone_deg: R,
    /// Whether the first axis may have any position.
    free: bool,
}

/// Positions of the rotary axes on one branch.
#[derive(Clone, Copy, Debug)]
struct Turned<R> {
    // Placed before zeros: next to a number, this 0 is merged with it into one vector store, with an instruction that Valgrind
    // 3.19 lacks.
    direction_error_deg: R,
    axes: [R; AXES],
    /// Cosine and sine of both turns relative to the workpiece.
    poses: [(R, R); 2],
    branch: Branch,
    margin_deg: R,
    step_deg: R,
}

impl<R: Real> Kinematics<R> {
    /// Axis positions for a tool, nearest to `near` (X Y Z A B C, mm and degrees).
    ///
    /// Rotary axes take the nearest angle within their travel, by whole turns. Error: rounding; [`Kinematics::forward`]
    /// returns the tool of the result within 1e-12 mm at a metre (f64). Cost: at most three polynomials for angles;
    /// linear axes on the nearer branch only, unless that leaves the travel.
    ///
    /// In the singular cone the axis nearest the workpiece keeps its position in `near`, or turns by the smallest angle
    /// that keeps the tool within [`Solution::direction_error_deg`] of the requested one; the branch follows from that
    /// position.
    ///
    /// # Errors
    /// The tool vector is invalid or out of reach, or its axis positions leave the travel; in the singular cone, the travel
    /// keeps the tool farther off than the cone.
    pub fn inverse(&self, tool: &Tool<R>, near: &[R; AXES]) -> Result<Solution<R>, InverseError> {
        if let [Some(first), Some(second)] = &self.chain.turns
            && let Ok(aim) = self.aim(tool, first, second)
            && !aim.in_cone()
            && let (Ok(one), Ok(other)) = (aim.turned(Branch::First, near), aim.turned(Branch::Second, near))
            && let Ok(solution) = self.with_linear(aim.tip, if other.step_deg < one.step_deg { &other } else { &one })
        {
            return Ok(solution);
        }
        self.nearest(tool, near)
    }

    #[cold]
    #[inline(never)]
    fn nearest(&self, tool: &Tool<R>, near: &[R; AXES]) -> Result<Solution<R>, InverseError> {
        if let [Some(first), Some(second)] = &self.chain.turns {
            let aim = self.aim(tool, first, second)?;
            if aim.in_cone() {
                return self.with_linear(aim.tip, &aim.guided_to_nearest(near)?);
            }
        }
        self.solutions(tool, near)?.choose(Choice::Nearest)
    }

    /// In the singular cone, or on the way out of it: turns the first rotary axis from `near` towards `goal` by at most
    /// `most_deg`, with the tool within the cone of the requested one; `None` if the second axis would take a larger step.
    #[cold]
    #[inline(never)]
    pub(super) fn towards(
        &self,
        tool: &Tool<R>,
        near: &[R; AXES],
        goal: &Solution<R>,
        most_deg: R,
    ) -> Option<Solution<R>> {
        let [Some(first), Some(second)] = &self.chain.turns else { return None };
        let aim = self.aim(tool, first, second).ok()?;
        let at = first.position(near);
        let position = at + (first.position(&goal.axes) - at).limit(-most_deg, most_deg);
        let turned = aim.held(goal.branch, near, position).ok()?;
        let step_deg = (second.position(&turned.axes) - second.position(near)).abs();
        if step_deg <= most_deg { self.with_linear(aim.tip, &turned).ok() } else { None }
    }

    /// Axis positions on one branch outside the singular cone, if any; otherwise [`Kinematics::solutions`] gives the
    /// reason.
    #[inline(always)]
    pub(super) fn on_branch(&self, tool: &Tool<R>, near: &[R; AXES], branch: Branch) -> Option<Solution<R>> {
        let [Some(first), Some(second)] = &self.chain.turns else {
            return self.solutions(tool, near).ok()?.choose(Choice::First).ok();
        };
        let aim = self.aim(tool, first, second).ok().filter(|aim| !aim.in_cone())?;
        self.with_linear(aim.tip, &aim.turned(branch, near).ok()?).ok()
    }

    /// Axis positions on both branches.
    ///
    /// At the singular pose itself (singular cone 0) the axis nearest the workpiece keeps its position in `near`. In the
    /// singular cone both solutions are guided out to their branches: they coincide where that axis stays still, and differ by
    /// up to half a turn towards the cone's border.
    ///
    /// # Errors
    /// Errors common to both branches: the tool vector is invalid or out of reach.
    #[doc(hidden)]
    pub fn solutions(&self, tool: &Tool<R>, near: &[R; AXES]) -> Result<Solutions<R>, InverseError> {
        match &self.chain.turns {
            [Some(first), Some(second)] => {
                let aim = self.aim(tool, first, second)?;
                let [first, second] = [Branch::First, Branch::Second].map(|branch| {
                    let turned =
                        if aim.in_cone() { aim.guided(branch, near, true)? } else { aim.turned(branch, near)? };
                    self.with_linear(aim.tip, &turned)
                });
                Ok(Solutions { first, second })
            }
            [Some(turn), None] | [None, Some(turn)] => {
                let (tip, axis) = valid(tool)?;
                self.one_turn(tip, axis, near, turn)
            }
            [None, None] => {
                let (tip, axis) = valid(tool)?;
                self.no_turn(tip, axis)
            }
        }
    }

    #[inline(always)]
    fn aim(&self, tool: &Tool<R>, first: &Rotary<R>, second: &Rotary<R>) -> Result<Aim<R>, InverseError> {
        let (tip, axis) = valid(tool)?;
        let tool @ [a, b, c] = in_frame(first.about, second.about, self.tool_axis);
        let wanted @ [u, p, q] = in_frame(first.about, second.about, axis);
        let across_square = p * p + q * q;
        let square = across_square - b * b;
        if square < R::ZERO {
            let most = atan2(b.abs(), (a * a + c * c).sqrt());
            within_reach(most - atan2(across_square.sqrt(), u.abs()), self.cone_deg * R::HALF)?;
        }
        let across = square.sqrt();
        let from_u = atan2(across, u);
        let half_turn = R::of(core::f64::consts::PI);
        let (margin, from_b) = if b == R::ZERO {
            (from_u.min(half_turn - from_u), half_turn * R::HALF)
        } else {
            (atan2(across, (u * u + b * b).sqrt()), atan2(across, b))
        };
        let along = R::of(ALONG) * R::EPSILON;
        let free = across_square <= along * along;
        let across_square_in_reach = across * across;
        let lengths =
            [across_square * (b * b + across_square_in_reach), (a * a + c * c) * (u * u + across_square_in_reach)];
        Ok(Aim {
            tip,
            first: *first,
            second: *second,
            tool,
            wanted,
            across,
            middle: [atan2(q, p), self.chain.tool_turn],
            apart: [from_b, from_u],
            inverse: lengths.map(|square| R::ONE / square.sqrt()),
            margin_deg: degrees(margin),
            cone_deg: self.cone_deg,
            free,
        })
    }

    fn one_turn(
        &self,
        tip: V3<R>,
        axis: V3<R>,
        near: &[R; AXES],
        turn: &Rotary<R>,
    ) -> Result<Solutions<R>, InverseError> {
        let across = match turn.about {
            About::X => About::Y,
            About::Y => About::Z,
            About::Z => About::X,
        };
        let [a, b, c] = in_frame(turn.about, across, self.tool_axis);
        let [u, p, q] = in_frame(turn.about, across, axis);
        let reach = atan2((b * b + c * c).sqrt(), a);
        within_reach((atan2((p * p + q * q).sqrt(), u) - reach).abs(), R::ZERO)?;
        let along = R::of(ALONG) * R::EPSILON;
        let angle = if b * b + c * c <= along * along {
            let [low, high] = turn.travel;
            Ok(turn.position(near).limit(low, high))
        } else {
            turn.settle(atan2(b * q - c * p, b * p + c * q), turn.position(near)).map(|(position, _)| position)
        };
        let solution = angle.and_then(|angle| {
            let mut axes = [R::ZERO; AXES];
            turn.put(&mut axes, angle);
            let poses = [turn.cos_sin(&axes), (R::ONE, R::ZERO)];
            let step_deg = (angle - turn.position(near)).abs();
            let (margin_deg, direction_error_deg) = (R::of(NO_SINGULAR_POSE), R::ZERO);
            self.with_linear(
                tip,
                &Turned { axes, poses, branch: Branch::First, margin_deg, direction_error_deg, step_deg },
            )
        });
        Ok(Solutions { first: solution, second: Err(InverseError::OneBranch) })
    }

    fn no_turn(&self, tip: V3<R>, axis: V3<R>) -> Result<Solutions<R>, InverseError> {
        within_reach(atan2(axis.cross(self.tool_axis).norm(), axis.dot(self.tool_axis)), R::ZERO)?;
        let poses = [(R::ONE, R::ZERO); 2];
        let still = Turned {
            axes: [R::ZERO; AXES],
            poses,
            branch: Branch::First,
            margin_deg: R::of(NO_SINGULAR_POSE),
            direction_error_deg: R::ZERO,
            step_deg: R::ZERO,
        };
        Ok(Solutions { first: self.with_linear(tip, &still), second: Err(InverseError::OneBranch) })
    }

    /// X, Y, Z that bring the tip to its position with the rotary axes as they are.
    #[inline(always)]
    fn with_linear(&self, tip: V3<R>, rotary: &Turned<R>) -> Result<Solution<R>, InverseError> {
        let [first_pose, second_pose] = rotary.poses;
        let [first, second] = &self.chain.turns;
        let turned = |turn: &Option<Rotary<R>>, pose, v: V3<R>| match turn {
            Some(turn) => v.turned(turn.about, pose),
            None => v,
        };
        let back = |turn: &Option<Rotary<R>>, (cos, sin): (R, R), v: V3<R>| turned(turn, (cos, -sin), v);
        let [before, between, behind] = &self.chain.sections;
        let tool = behind.offset + self.tool;
        // The slides of one section are at right angles and turn as a whole.
        let found = match self.chain.together {
            Some(0) => {
                tip - before.offset - turned(first, first_pose, between.offset + turned(second, second_pose, tool))
            }
            Some(1) => {
                back(first, first_pose, tip - before.offset) - between.offset - turned(second, second_pose, tool)
            }
            Some(_) => {
                let inner = back(first, first_pose, tip - before.offset) - between.offset;
                back(second, second_pose, inner) - tool
            }
            None => self.along_slides(tip, rotary)?,
        };
        let [x, y, z] = found.array();
        let [travel_x, travel_y, travel_z] = &self.chain.travel;
        let [_, _, _, a, b, c] = rotary.axes;
        let mut axes = [x, y, z, a, b, c];
        if !(within(x, travel_x) & within(y, travel_y) & within(z, travel_z)) {
            let ends = [Axis::X, Axis::Y, Axis::Z].into_iter().zip(&self.chain.travel);
            for (place, (axis, travel)) in axes.iter_mut().zip(ends) {
                *place = inside(axis, *place, *travel)?;
            }
        }
        let Turned { branch, margin_deg, direction_error_deg, step_deg, .. } = *rotary;
        Ok(Solution { axes, branch, singularity_margin_deg: margin_deg, direction_error_deg, step_deg })
    }

    /// X, Y, Z if rotary axes lie between them: three equations, solved by Cramer's rule.
    #[inline(never)]
    fn along_slides(&self, tip: V3<R>, rotary: &Turned<R>) -> Result<V3<R>, InverseError> {
        let [first_pose, second_pose] = rotary.poses;
        let [first, second] = self.chain.turns;
        let (first, second) = (first.map(|turn| (turn, first_pose)), second.map(|turn| (turn, second_pose)));
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
        let along = V3::new(wanted.dot(ey.cross(ez)), wanted.dot(ez.cross(ex)), wanted.dot(ex.cross(ey)));
        Ok(along * inverse)
    }
}

impl<R: Real> Aim<R> {
    /// Whether the pose is nearer to the singular pose than the singular cone.
    #[inline(always)]
    fn in_cone(&self) -> bool {
        self.margin_deg < self.cone_deg
    }

    /// In the cone: takes the branch to which the first axis is nearer, or the other one if that leaves the travel.
    #[cold]
    #[inline(never)]
    fn guided_to_nearest(&self, near: &[R; AXES]) -> Result<Turned<R>, InverseError> {
        let [_, p, q] = self.wanted;
        let (cos, sin) = self.first.cos_sin(near);
        let (own, other) =
            if q * cos > p * sin { (Branch::Second, Branch::First) } else { (Branch::First, Branch::Second) };
        let only = self.second_alone(other, near).is_err();
        self.guided(own, near, only).or_else(|error| {
            self.guided(other, near, true)
                .map_err(|reached| if matches!(reached, InverseError::SingularPose { .. }) { reached } else { error })
        })
    }

    /// In the cone, on the way to a branch: turns the first axis by the smallest angle that keeps the tool within L
    /// (see the module documentation). From any position (`far`) its permitted deviation doubles: up to half a turn.
    #[cold]
    #[inline(never)]
    fn guided(&self, branch: Branch, near: &[R; AXES], far: bool) -> Result<Turned<R>, InverseError> {
        // The branch must be reachable outside the cone.
        self.second_alone(branch, near)?;
        let ([a, b, c], [_, p, q]) = (self.tool, self.wanted);
        let share = self.margin_deg / self.cone_deg;
        let slack_deg = if share <= R::HALF {
            self.cone_deg * R::HALF
        } else {
            self.margin_deg * cos_sin_deg(share * R::of(180.0)).1
        };
        let (cos, sin) = cos_sin_deg(slack_deg);
        let root = (a * a + c * c).sqrt();
        // Components across the first axis that the second one leaves, sin(β ∓ L); beyond a right angle no bound
        // applies.
        let low = if root * cos + b * sin < R::ZERO { -R::ONE } else { b * cos - root * sin };
        let high = if root * cos - b * sin < R::ZERO { R::ONE } else { b * cos + root * sin };
        let square = p * p + q * q;
        let angle = |across: R| atan2((square - across * across).sqrt(), across);
        // Angles of the first axis from the direction's azimuth, positive towards the branch.
        let sign = if branch == Branch::First { R::ONE } else { -R::ONE };
        let (cos, sin) = self.first.cos_sin(near);
        let current = atan2(sign * (p * sin - q * cos), p * cos + q * sin);
        let exact = self.apart[0];
        let times = if far { R::TWO } else { R::ONE };
        let pi = R::of(core::f64::consts::PI);
        let off = if current - exact < -pi { current - exact + pi * R::TWO } else { current - exact };
        let allowed = off.limit(times * (angle(high) - exact), times * (angle(low) - exact));
        let at = self.first.position(near);
        let position = if allowed == off {
            let [low, high] = self.first.travel;
            at.limit(low, high)
        } else {
            self.first.settle(self.middle[0] + sign * (exact + allowed), at)?.0
        };
        self.held(branch, near, position)
    }

    /// The second axis's position on a branch, whatever the first axis's position.
    fn second_alone(&self, branch: Branch, near: &[R; AXES]) -> Result<(R, bool), InverseError> {
        let [middle, apart] = [self.middle[1], self.apart[1]];
        let angle = if branch == Branch::First { middle + apart } else { middle - apart };
        self.second.settle(angle, self.second.position(near))
    }

    /// Puts the first axis at a position, and the second one where it brings the tool nearest to the requested one.
    #[cold]
    #[inline(never)]
    fn held(&self, branch: Branch, near: &[R; AXES], position: R) -> Result<Turned<R>, InverseError> {
        let ([a, b, c], [u, p, q]) = (self.tool, self.wanted);
        let (first, second) = (&self.first, &self.second);
        let mut axes = [R::ZERO; AXES];
        first.put(&mut axes, position);
        let first_pose @ (cos, sin) = first.cos_sin(&axes);
        let wanted = V3::new(u, p * cos + q * sin, q * cos - p * sin);
        let (first_at, second_at) = (first.position(near), second.position(near));
        let second_position = match second.settle(atan2(c * u - a * wanted.z, a * u + c * wanted.z), second_at) {
            Ok((position, _)) => position,
            Err(InverseError::OutsideTravel { found, low, high, .. }) => R::of(found).limit(R::of(low), R::of(high)),
            Err(error) => return Err(error),
        };
        second.put(&mut axes, second_position);
        let second_pose @ (cos, sin) = second.cos_sin(&axes);
        let reached = V3::new(a * cos + c * sin, b, c * cos - a * sin);
        let direction_error_deg = degrees(atan2(wanted.cross(reached).norm(), wanted.dot(reached)));
        if direction_error_deg <= self.cone_deg {
            let step_deg = (position - first_at).abs().max((second_position - second_at).abs());
            let (poses, margin_deg) = ([first_pose, second_pose], self.margin_deg);
            Ok(Turned { axes, poses, branch, margin_deg, direction_error_deg, step_deg })
        } else {
            let (margin_deg, cone_deg) = (self.margin_deg.to_f64(), self.cone_deg.to_f64());
            Err(InverseError::SingularPose { margin_deg, cone_deg })
        }
    }

    /// Positions of the rotary axes on a branch.
    #[inline(always)]
    fn turned(&self, branch: Branch, near: &[R; AXES]) -> Result<Turned<R>, InverseError> {
        let ([a, b, c], [u, p, q]) = (self.tool, self.wanted);
        let ([first_middle, second_middle], [first_apart, second_apart]) = (self.middle, self.apart);
        let (w, first_angle, second_angle) = match branch {
            Branch::First => (-self.across, first_middle + first_apart, second_middle + second_apart),
            Branch::Second => (self.across, first_middle - first_apart, second_middle - second_apart),
        };
        let [first_inverse, second_inverse] = self.inverse;
        let (first, second) = (&self.first, &self.second);
        let mut axes = [R::ZERO; AXES];
        let mut poses = [
            ((b * p + w * q) * first_inverse, (b * q - w * p) * first_inverse),
            ((a * u + c * w) * second_inverse, (c * u - a * w) * second_inverse),
        ];
        let (first_at, second_at) = (first.position(near), second.position(near));
        let (q1, first_moved) = if self.free {
            let [low, high] = first.travel;
            (first_at.limit(low, high), true)
        } else {
            first.settle(first_angle, first_at)?
        };
        let (q2, second_moved) = second.settle(second_angle, second_at)?;
        first.put(&mut axes, q1);
        second.put(&mut axes, q2);
        if first_moved | second_moved {
            poses = [first.cos_sin(&axes), second.cos_sin(&axes)];
        }
        let step_deg = (q1 - first_at).abs().max((q2 - second_at).abs());
        let (margin_deg, direction_error_deg) = (self.margin_deg, R::ZERO);
        Ok(Turned { axes, poses, branch, margin_deg, direction_error_deg, step_deg })
    }
}

impl<R: Real> Rotary<R> {
    /// Command for a turn (rad) relative to the workpiece: nearest to the position `near`, by whole turns within the travel;
    /// also returns whether it was moved to the travel's end.
    #[inline(always)]
    fn settle(&self, angle: R, near: R) -> Result<(R, bool), InverseError> {
        let whole = R::of(360.0);
        let base = self.sense * degrees(angle);
        let turns = (near - base) * R::of(1.0 / 360.0);
        let half = if turns < R::ZERO { -R::HALF } else { R::HALF };
        let nearest = base + whole * R::of_i32((turns + half).to_i32());
        if within(nearest, &self.travel) { Ok((nearest, false)) } else { self.settle_within(nearest) }
    }

    #[cold]
    #[inline(never)]
    fn settle_within(&self, nearest: R) -> Result<(R, bool), InverseError> {
        let whole = R::of(360.0);
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
        // Reports the position nearest to where the axis was, not the one at the far end.
        let position = inside(self.axis, found, self.travel).or_else(|_| inside(self.axis, nearest, self.travel))?;
        Ok((position, true))
    }

    /// Stores this axis's position.
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

/// Whether the position lies within the travel; false for NaN.
#[inline(always)]
fn within<R: Real>(position: R, [low, high]: &[R; 2]) -> bool {
    (position >= *low) & (position <= *high)
}

/// Tip and normalised direction, if both are valid.
#[inline(always)]
fn valid<R: Real>(tool: &Tool<R>) -> Result<(V3<R>, V3<R>), InverseError> {
    let [tip, axis] = [tool.tip, tool.axis].map(V3::<R>::from_glam);
    if !(tip.x.is_finite() & tip.y.is_finite() & tip.z.is_finite()) {
        return Err(InverseError::TipNotFinite);
    }
    let length = axis.norm();
    let off = (length - R::ONE).abs();
    if off <= R::of(UNIT_TOLERANCE) {
        Ok((tip, axis * (R::ONE / length)))
    } else {
        Err(InverseError::NotADirection { length: length.to_f64() })
    }
}

/// Rounding error of a position of this magnitude.
#[inline(always)]
fn rounding<R: Real>(position: R) -> R {
    R::of(TRAVEL_ROUNDING) * R::EPSILON * (position.abs() + R::of(360.0))
}

/// Returns the position if it is within the travel (up to rounding).
#[cold]
fn inside<R: Real>(axis: Axis, found: R, [low, high]: [R; 2]) -> Result<R, InverseError> {
    if found >= low - rounding(low) && found <= high + rounding(high) {
        Ok(found.limit(low, high))
    } else {
        let [found, low, high] = [found, low, high].map(R::to_f64);
        Err(InverseError::OutsideTravel { axis, found, low, high })
    }
}

/// Refuses a direction that is `beyond` (rad) the reach of the rotary axes by more than rounding and `slack_deg`.
#[inline(always)]
fn within_reach<R: Real>(beyond: R, slack_deg: R) -> Result<(), InverseError> {
    let by = degrees(beyond);
    if by > R::of(REACH_TOLERANCE_DEG).max(slack_deg) {
        Err(InverseError::Unreachable { by_deg: by.to_f64() })
    } else {
        Ok(())
    }
}
