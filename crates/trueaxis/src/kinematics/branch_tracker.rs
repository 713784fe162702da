//! The inverse along a path, without a jump.

#![deny(clippy::indexing_slicing)]

use super::{Branch, InverseError, Kinematics, Solution, Tool};
use crate::machine::{AXES, Axis};
use crate::real::Real;

/// Follows a path on one branch, each call near the last solution.
///
/// A call that would change the branch, or step a rotary axis by more than the limit, is refused and leaves the last
/// solution as it was: the host stops, slows down, or starts anew on the other branch.
#[derive(Clone, Copy, Debug)]
pub struct BranchTracker<R> {
    last: [R; AXES],
    /// Position before the last call, restored if the pose is not accepted.
    before: [R; AXES],
    branch: Branch,
    max_step_deg: R,
}

impl<R: Real> BranchTracker<R> {
    /// From a pose that the machine stands in; `max_step_deg`: largest step of a rotary axis in one call.
    pub fn new(start: &Solution<R>, max_step_deg: R) -> Self {
        BranchTracker { last: start.axes, before: start.axes, branch: start.branch, max_step_deg }
    }

    /// The last axis positions.
    pub fn axes(&self) -> &[R; AXES] {
        &self.last
    }

    /// The branch that is followed.
    pub fn branch(&self) -> Branch {
        self.branch
    }

    /// The next pose.
    ///
    /// # Errors
    /// As [`Kinematics::inverse`]; [`InverseError::BranchChange`] where only the other branch goes on within the limit;
    /// [`InverseError::TooFast`] where neither does.
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
        match kinematics.on_branch(tool, &self.last, self.branch) {
            Some(solution) if solution.step_deg <= max_step_deg => {
                self.last = solution.axes;
                Ok(solution)
            }
            _ => self.refusal(kinematics, tool, max_step_deg),
        }
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
        let solutions = kinematics.solutions(tool, &self.last)?;
        let (here, other) = match self.branch {
            Branch::First => (solutions.first, solutions.second),
            Branch::Second => (solutions.second, solutions.first),
        };
        let limit_deg = max_step_deg.to_f64();
        let other_goes_on = other.is_ok_and(|solution| solution.step_deg <= max_step_deg);
        match here {
            Ok(Solution { step_deg, .. }) if other_goes_on => {
                Err(InverseError::BranchChange { from: self.branch, step_deg: step_deg.to_f64(), limit_deg })
            }
            Ok(solution) => {
                let axis = self.fastest(&solution);
                Err(InverseError::TooFast { axis, step_deg: solution.step_deg.to_f64(), limit_deg })
            }
            Err(_) if other.is_ok() => {
                Err(InverseError::BranchChange { from: self.branch, step_deg: f64::INFINITY, limit_deg })
            }
            Err(error) => Err(error),
        }
    }

    /// The last pose was not taken up: back to the one before it.
    pub fn take_back(&mut self) {
        self.last = self.before;
    }

    /// The rotary axis of the largest step.
    fn fastest(&self, solution: &Solution<R>) -> Axis {
        let steps = Axis::ALL.into_iter().zip(self.last).zip(solution.axes);
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
