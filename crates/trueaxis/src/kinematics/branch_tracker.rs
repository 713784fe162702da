//! The inverse along a path, without a jump.

#![deny(clippy::indexing_slicing)]

use super::{Branch, InverseError, Kinematics, Solution, Tool};
use crate::machine::{AXES, Axis};
use crate::real::Real;

/// Largest rotary step, degrees, in which a path passes the singular pose on to the other branch.
const PASS_DEG: f64 = 5.0;

/// Follows a path on one branch, each call near the last solution.
///
/// In the singular cone the axis nearest the workpiece stands or is led ([`Kinematics::inverse`]), and the tool may come out
/// on either branch. Where that axis would have to turn faster than the limit, there and on the way out, it turns as fast as
/// the limit lets it while the tool stays within the cone's angle of the one asked for; the angle that is left is
/// [`BranchTracker::direction_error_deg`].
///
/// A call that would change the branch elsewhere, or step a rotary axis by more than the limit, is refused and leaves the
/// last solution as it was: the host stops, slows down, or starts anew on the other branch. With any cone, also 0, a path
/// that passes the singular pose goes on on the other branch where that takes no step above the limit and 5 degrees.
#[derive(Clone, Copy, Debug)]
pub struct BranchTracker<R> {
    last: Pose<R>,
    /// The one before the last call, restored if the pose is not accepted.
    before: Pose<R>,
    max_step_deg: R,
}

/// What is known of a solution at the next call.
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
    /// From a pose that the machine stands in; `max_step_deg`: largest step of a rotary axis in one call.
    pub fn new(start: &Solution<R>, max_step_deg: R) -> Self {
        let last = Pose::of(start);
        BranchTracker { last, before: last, max_step_deg }
    }

    /// The last axis positions.
    pub fn axes(&self) -> &[R; AXES] {
        &self.last.axes
    }

    /// The branch that is followed.
    pub fn branch(&self) -> Branch {
        self.last.branch
    }

    /// Angle that the last solution leaves between the tool and the one asked for, degrees: at most the singular cone, 0
    /// outside it but for the way out ([`Solution::direction_error_deg`]).
    pub fn direction_error_deg(&self) -> R {
        self.last.direction_error_deg
    }

    /// The next pose.
    ///
    /// # Errors
    /// As [`Kinematics::inverse`]; [`InverseError::BranchChange`] where only the other branch goes on;
    /// [`InverseError::TooFast`] where neither does within the limit.
    pub fn next(&mut self, kinematics: &Kinematics<R>, tool: &Tool<R>) -> Result<Solution<R>, InverseError> {
        self.next_after(kinematics, tool, R::ONE)
    }

    /// The next pose, so many calls after the last one: the largest step counts as many times.
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

    /// In the singular cone, on the way out of it, or over the singular pose to the other branch; or why not.
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

    /// Why the path does not go on on its branch.
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
        let other_goes_on = other.is_ok_and(|solution| solution.step_deg <= max_step_deg);
        match here {
            Ok(Solution { step_deg, .. }) if other_goes_on => {
                Err(InverseError::BranchChange { from: self.last.branch, step_deg: step_deg.to_f64(), limit_deg })
            }
            Ok(solution) => Err(self.too_fast(&solution, max_step_deg)),
            Err(_) if other.is_ok() => {
                Err(InverseError::BranchChange { from: self.last.branch, step_deg: f64::INFINITY, limit_deg })
            }
            Err(error) => Err(error),
        }
    }

    /// The last pose was not taken up: back to the one before it.
    pub fn take_back(&mut self) {
        self.last = self.before;
    }

    fn too_fast(&self, solution: &Solution<R>, max_step_deg: R) -> InverseError {
        let axis = self.fastest(solution);
        InverseError::TooFast { axis, step_deg: solution.step_deg.to_f64(), limit_deg: max_step_deg.to_f64() }
    }

    /// The rotary axis of the largest step.
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
