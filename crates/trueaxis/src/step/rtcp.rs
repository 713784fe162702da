//! Rotation about the tool centre point: the tool is commanded in workpiece coordinates, the axes are found in the cycle.

#![deny(clippy::indexing_slicing)]

use super::{Output, ServoLoop, State};
use crate::contour::{OrientationError, Reference, ToolPath};
use crate::error::Fault;
use crate::kinematics::{Follow, InverseError, Kinematics, Tool};
use crate::machine::{AXES, Axis};
use crate::position::Position;
use crate::real::Real;
use crate::sample::Input;

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// One servo cycle with the tool commanded in workpiece coordinates: the tip (mm) and the direction (unit vector).
    ///
    /// The inverse transformation gives this cycle's positions of the axes on the branch that `follow` is on; they stand
    /// in for `input.command`, which is not looked at. Then [`ServoLoop::step_with_tool`]. `follow` starts from the pose
    /// that the machine stands in, with the largest step that a rotary axis makes in a cycle.
    ///
    /// A tool that has no such positions is a bad command: the output holds, the stop request is latched, `follow` stays
    /// at the held pose, and a reset is heard once the tool is again at one near it (`resume` of every axis, and within
    /// the step of `follow`). The call is for homed axes: positions have no meaning before.
    ///
    /// | refused | fault |
    /// |---|---|
    /// | tip or direction not finite | [`Fault::CommandNotFinite`] |
    /// | no direction, or one out of reach; linear axes that no longer span space | [`Fault::ToolUnreachable`] |
    /// | an axis would leave its travel | [`Fault::CommandOutOfTravel`], with the axis |
    /// | within the singular cone | [`Fault::SingularPose`] |
    /// | goes on only on the other branch | [`Fault::BranchChange`] |
    /// | a rotary axis would step too far | [`Fault::CommandJump`], with the axis |
    ///
    /// In single precision the positions found carry the rounding of absolute coordinates, about 30 nm at 500 mm in every
    /// linear command; doubles nothing. Bounded: one inverse a cycle.
    #[inline]
    pub fn step_rtcp(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        tool: &Tool<R>,
        follow: &mut Follow<R>,
        path: &ToolPath<'_, R, P>,
        reference: Reference<R>,
        kinematics: &Kinematics<R>,
    ) -> (Output<R, P, N>, OrientationError<R>) {
        let before = *follow;
        let (command, refused) = match follow.next_after(kinematics, tool, self.sampler.periods(input.elapsed_ns)) {
            Ok(solution) => (self.positions(&solution.axes), (Fault::None, 0)),
            Err(error) => (state.sample.commanded(), self.refusal(&error, tool)),
        };
        let sample = self.sampler.read_unless(&mut state.sample, &Input { command, ..*input }, refused);
        let done = self.finish_with_tool(state, &sample, path, reference, kinematics);
        if done.0.stop_requested() {
            *follow = before;
        }
        done
    }

    /// Joints as positions of the step's axes.
    #[inline(always)]
    fn positions(&self, joints: &[R; AXES]) -> [P; N] {
        self.axes.map(|axis| joints.get(axis.index()).map_or(P::default(), |joint| P::default().plus(*joint)))
    }

    #[cold]
    fn refusal(&self, error: &InverseError, tool: &Tool<R>) -> (Fault, u8) {
        let finite = tool.axis.array().iter().all(|x| x.is_finite());
        match *error {
            InverseError::TipNotFinite => (Fault::CommandNotFinite, 0),
            InverseError::NotADirection { .. } if !finite => (Fault::CommandNotFinite, 0),
            InverseError::SingularPose { .. } => (Fault::SingularPose, 0),
            InverseError::BranchChange { .. } => (Fault::BranchChange, 0),
            InverseError::TooFast { axis, .. } => (Fault::CommandJump, self.place(axis)),
            InverseError::OutsideTravel { axis, .. } => (Fault::CommandOutOfTravel, self.place(axis)),
            _ => (Fault::ToolUnreachable, 0),
        }
    }

    fn place(&self, axis: Axis) -> u8 {
        self.axes.iter().position(|known| *known == axis).map_or(0, |place| place as u8)
    }
}

#[cfg(test)]
mod tests;
