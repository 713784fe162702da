//! The inverse along a path, without jumps.

#![deny(clippy::indexing_slicing)]

use super::{Branch, InverseError, Kinematics, Solution, Tool};
use crate::machine::{AXES, Axis};
use crate::real::Real;

/// Largest rotary step, degrees, with which a path may pass the singular pose to the other branch.
const PASS_DEG: f64 = 5.0;

/// Follows a path on one branch; each call starts from the last solution.
///
/// In the singular cone the axis nearest the workpiece stays still or is guided ([`Kinematics::inverse`]), and the tool may
/// come out on either branch. If that axis would have to turn faster than the limit, there and on the way out, it turns as
/// fast as the limit permits while the tool stays within the cone's angle of the requested one; the remaining angle is
/// [`BranchTracker::direction_error_deg`].
///
/// A call that would change the branch elsewhere, or step a rotary axis by more than the limit, is refused and leaves the last
/// solution unchanged: the host stops, slows down, or restarts on the other branch. With any cone, including 0, a path that
/// passes the singular pose continues on the other branch if no step there exceeds the limit or 5 degrees.
#[derive(Clone, Copy, Debug)]
pub struct BranchTracker<R> {
    last: Pose<R>,
    /// The pose before the last call, restored if the last one is not accepted.
    before: Pose<R>,
    max_step_deg: R,
}

/// The part of a solution that the next call needs.
#[derive(Clone, Copy, Debug)]
struct Pose<R> {
    axes: [R; AXES],
    branch: Branch,
    direction_error_deg: R,
}

impl<R: Real> Pose<R> {
    #[inline(always)]
    fn of(solution: &Solution<R>) -> Self {
        let Solution { axes, branch, direction_error_deg, .. } = *solution;
        Pose { axes, branch, direction_error_deg }
    }
}

impl<R: Real> BranchTracker<R> {
    /// Starts from the machine's present pose; `max_step_deg`: largest step of a rotary axis in one call.
    pub fn new(start: &Solution<R>, max_step_deg: R) -> Self {
        let last = Pose::of(start);
        BranchTracker { last, before: last, max_step_deg }
    }

    /// The last axis positions.
    pub fn axes(&self) -> &[R; AXES] {
        &self.last.axes
    }

    /// The branch being followed.
    pub fn branch(&self) -> Branch {
        self.last.branch
    }

    /// Angle between the tool of the last solution and the requested one, degrees: at most the singular cone, and 0 outside it
    /// except on the way out ([`Solution::direction_error_deg`]).
    pub fn direction_error_deg(&self) -> R {
        self.last.direction_error_deg
    }

    /// The next pose.
    ///
    /// # Errors
    /// As [`Kinematics::inverse`]; [`InverseError::BranchChange`] if only the other branch continues;
    /// [`InverseError::TooFast`] if neither does within the limit.
    pub fn next(&mut self, kinematics: &Kinematics<R>, tool: &Tool<R>) -> Result<Solution<R>, InverseError> {
        self.next_after(kinematics, tool, R::ONE)
    }

    /// The next pose, `calls` calls after the last one: multiplies the largest step by `calls`.
    ///
    /// # Errors
    /// As [`BranchTracker::next`].
    pub fn next_after(
        &mut self,
        kinematics: &Kinematics<R>,
        tool: &Tool<R>,
        calls: R,
    ) -> Result<Solution<R>, InverseError> {
        self.before = self.last;
        let max_step_deg = self.max_step_deg * calls;
        let solution = match kinematics.on_branch(tool, &self.last.axes, self.last.branch) {
            Some(solution) if solution.step_deg <= max_step_deg => solution,
            _ => self.by_the_singular_pose(kinematics, tool, max_step_deg)?,
        };
        self.last = Pose::of(&solution);
        Ok(solution)
    }

    /// Handles a pose in the singular cone, on the way out of it, or over the singular pose to the other branch; or gives the
    /// reason for a refusal.
    #[cold]
    #[inline(never)]
    fn by_the_singular_pose(
        &self,
        kinematics: &Kinematics<R>,
        tool: &Tool<R>,
        max_step_deg: R,
    ) -> Result<Solution<R>, InverseError> {
        let axes = &self.last.axes;
        let Ok(found) = kinematics.inverse(tool, axes) else { return self.refusal(kinematics, tool, max_step_deg) };
        let cone_deg = kinematics.cone_deg;
        let free = found.singularity_margin_deg < cone_deg
            || self.last.direction_error_deg > R::ZERO
            || kinematics.singularity_margin_deg(axes) < cone_deg;
        let most_deg = if free { max_step_deg } else { max_step_deg.min(R::of(PASS_DEG)) };
        if found.step_deg <= most_deg {
            return Ok(found);
        }
        if !free {
            return self.refusal(kinematics, tool, max_step_deg);
        }
        kinematics.towards(tool, axes, &found, max_step_deg).ok_or_else(|| self.too_fast(&found, max_step_deg))
    }

    /// The reason why the path does not continue on its branch.
    #[cold]
    #[inline(never)]
    fn refusal(
        &self,
        kinematics: &Kinematics<R>,
        tool: &Tool<R>,
        max_step_deg: R,
    ) -> Result<Solution<R>, InverseError> {
        let solutions = kinematics.solutions(tool, &self.last.axes)?;
        let (here, other) = match self.last.branch {
            Branch::First => (solutions.first, solutions.second),
            Branch::Second => (solutions.second, solutions.first),
        };
        let limit_deg = max_step_deg.to_f64();
        let other_continues = other.is_ok_and(|solution| solution.step_deg <= max_step_deg);
        match here {
            Ok(Solution { step_deg, .. }) if other_continues => {
                Err(InverseError::BranchChange { from: self.last.branch, step_deg: step_deg.to_f64(), limit_deg })
            }
            Ok(solution) => Err(self.too_fast(&solution, max_step_deg)),
            Err(_) if other.is_ok() => {
                Err(InverseError::BranchChange { from: self.last.branch, step_deg: f64::INFINITY, limit_deg })
            }
            Err(error) => Err(error),
        }
    }

    /// Restores the pose before the last one, which was not accepted.
    pub fn take_back(&mut self) {
        self.last = self.before;
    }

    fn too_fast(&self, solution: &Solution<R>, max_step_deg: R) -> InverseError {
        let axis = self.fastest(solution);
        InverseError::TooFast { axis, step_deg: solution.step_deg.to_f64(), limit_deg: max_step_deg.to_f64() }
    }

    /// The rotary axis with the largest step.
    fn fastest(&self, solution: &Solution<R>) -> Axis {
        let steps = Axis::ALL.into_iter().zip(self.last.axes).zip(solution.axes);
        let rotary = steps.filter(|((axis, _), _)| axis.is_rotary());
        let mut fastest = (Axis::C, R::ZERO);
        for ((axis, before), after) in rotary {
            let step = (after - before).abs();
            if step > fastest.1 {
                fastest = (axis, step);
            }
        }
        fastest.0
    }
}
