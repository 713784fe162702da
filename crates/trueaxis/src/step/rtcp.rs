//! Rotation about the tool centre point: the host commands the tool in workpiece coordinates, and each cycle computes the
//! axes.

#![deny(clippy::indexing_slicing)]

use super::{ServoLoop, State};
use crate::axis::AXES;
use crate::error::Fault;
use crate::kinematics::{BranchTracker, InverseError, Kinematics, Tool};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Input, Refusal};

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// Builds the input of a cycle from the tool's tip (mm) and direction (unit vector) in workpiece coordinates.
    ///
    /// The inverse transformation gives this cycle's axis positions on the branch of `tracker`; they replace
    /// `input.command`, which is ignored. `tracker` starts from the machine's current pose, with the largest step of a
    /// rotary axis per cycle. Pass the result to [`ServoLoop::step`].
    ///
    /// In the singular cone the axis nearest the workpiece stays, or turns no faster than that step, and the tool stays
    /// as near to the commanded direction as the other axis allows: the tip is exact, and the remaining angle is
    /// [`BranchTracker::direction_error_deg`], at most the cone, and part of the record's orientation error if a tool
    /// path is measured. A path straight through the pole passes.
    ///
    /// A tool without such positions is a bad command ([`Input::refusal`]): the output holds, the stop request is
    /// latched, `tracker` returns to the held pose at the next call, and a reset is accepted once the tool is back near
    /// that pose (`resume` of every axis, and within the step of `tracker`). Call it only with all axes homed: before
    /// that, positions have no meaning.
    ///
    /// | refused | fault |
    /// |---|---|
    /// | tip or direction not finite | [`Fault::CommandNotFinite`] |
    /// | no direction, or one out of reach; linear axes that no longer span space | [`Fault::ToolUnreachable`] |
    /// | an axis would leave its travel | [`Fault::CommandOutOfTravel`], with the axis |
    /// | within the singular cone, where a travel keeps the tool off by more than the cone | [`Fault::SingularPose`] |
    /// | continues only on the other branch, not through the pole | [`Fault::BranchChange`] |
    /// | a rotary axis would step too far (in the cone: angle left > cone) | [`Fault::CommandJump`], with the axis |
    ///
    /// In single precision the computed positions contain the rounding of absolute coordinates, about 30 nm at 500 mm in
    /// every linear command; doubles contain none. A position beyond its travel by rounding only, 64 units in the last
    /// place of 360 plus its magnitude (3 µm and 3 millidegrees in single precision, 6e-12 in double), is set to the end
    /// of the travel. Bounded: one inverse per cycle; in the singular cone, over the pole and at a refusal at most five.
    #[inline]
    pub fn rtcp(
        &self,
        state: &State<R, P, N>,
        tool: &Tool<R>,
        tracker: &mut BranchTracker<R>,
        kinematics: &Kinematics<R>,
        input: &Input<P, N>,
    ) -> Input<P, N> {
        if state.sample.is_latched() {
            tracker.take_back();
        }
        let (command, refusal) = match tracker.next_after(kinematics, tool, self.sampler.periods(input.elapsed_ns)) {
            Ok(solution) => (self.positions(&solution.axes), Refusal::NONE),
            Err(error) => (state.sample.commanded(), self.refusal(&error, tool)),
        };
        Input { command, refusal, ..*input }
    }

    /// Converts joints to positions of the step's axes.
    #[inline(always)]
    fn positions(&self, joints: &[R; AXES]) -> [P; N] {
        self.order.slots(|axis| joints.get(axis.index()).map_or(P::default(), |joint| P::default().plus(*joint)))
    }

    #[cold]
    fn refusal(&self, error: &InverseError, tool: &Tool<R>) -> Refusal {
        let finite = tool.axis.into().iter().all(|x| x.is_finite());
        let (fault, axis) = match *error {
            InverseError::TipNotFinite => (Fault::CommandNotFinite, None),
            InverseError::NotADirection { .. } if !finite => (Fault::CommandNotFinite, None),
            InverseError::SingularPose { .. } => (Fault::SingularPose, None),
            InverseError::BranchChange { .. } => (Fault::BranchChange, None),
            InverseError::TooFast { axis, .. } => (Fault::CommandJump, Some(axis)),
            InverseError::OutsideTravel { axis, .. } => (Fault::CommandOutOfTravel, Some(axis)),
            _ => (Fault::ToolUnreachable, None),
        };
        let slot = axis.and_then(|axis| self.order.slot(axis));
        Refusal { fault, slot: slot.map_or(0, |slot| slot as u8) }
    }
}
