//! The cycle of a machine whose tool turns: forward kinematics before the contour stage.

#![deny(clippy::indexing_slicing)]

use super::{Modelled, Output, ServoLoop, State};
use crate::contour::{ContourError, ContourState, OrientationError, Reference, ToolPath};
use crate::kinematics::{Kinematics, Tool};
use crate::machine::AXES;
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Input, Sample, Verdict};
use crate::vector::V3;

/// Tip and direction as the model has them, tip by the encoders alone.
struct Seen<R> {
    estimated: Tool<R>,
    encoder: V3<R>,
}

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// One servo cycle with the path in workpiece coordinates: the tip's contour error and the direction's.
    ///
    /// With q the raw feedback, F the forward transformation, e and w the modelled errors of tip and direction there (bed
    /// axes; B turns them into the workpiece's), the estimated tool is
    ///
    /// ```text
    /// tip = F(q) + B e        direction = t + B w × t,   t = F(q)'s
    /// ```
    ///
    /// where in the nine-term form a rotary axis' own error belongs to q. The plain encoder position is the tip of F(q).
    /// Everything else is [`ServoLoop::step`]. The orientation error is returned whole; its angle is in the record.
    ///
    /// In single precision the absolute coordinates of F cost about 30 nm at 500 mm (half a unit in the last place of each
    /// of its sums), and a rotary position up to 0.13 µrad; doubles nothing. One forward transformation (two in the
    /// nine-term form) and one reference direction a cycle; beside a turn on the spot up to 26 more of the latter.
    #[inline]
    pub fn step_with_tool(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        path: &ToolPath<'_, R, P>,
        reference: Reference<R>,
        kinematics: &Kinematics<R>,
    ) -> (Output<R, P, N>, OrientationError<R>) {
        let sample = self.sampler.read(&mut state.sample, input);
        self.finish_with_tool(state, &sample, path, reference, kinematics)
    }

    /// The stages after the sample.
    #[inline(always)]
    pub(super) fn finish_with_tool(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        path: &ToolPath<'_, R, P>,
        reference: Reference<R>,
        kinematics: &Kinematics<R>,
    ) -> (Output<R, P, N>, OrientationError<R>) {
        let modelled = self.model::<true>(state, sample);
        let (contour, orientation) = self.tool_contour(state, sample, &modelled, path, reference, kinematics);
        let released = self.release.release(&mut state.release, &mut state.sample, sample, &modelled.wanted);
        state.limited = released.limited;
        (self.record(state, sample, modelled.at_edge, contour, &orientation, released), orientation)
    }

    #[inline(always)]
    fn tool_contour(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        modelled: &Modelled<R, N>,
        path: &ToolPath<'_, R, P>,
        reference: Reference<R>,
        kinematics: &Kinematics<R>,
    ) -> ([ContourError<R>; 2], OrientationError<R>) {
        if !matches!(sample.verdict, Verdict::Active | Verdict::Inactive) {
            // After a fault the last foot says nothing about the next one.
            (state.tip, state.encoder) = (ContourState::default(), ContourState::default());
            return ([ContourError::none(); 2], OrientationError::none());
        }
        let seen = self.seen(&sample.feedback, modelled, kinematics);
        let (tip, encoder) = (position(seen.estimated.tip), position(seen.encoder));
        let [at_tip, at_encoder] = self.search_both(state, &path.path, reference, tip, encoder);
        let of_axes = |[a, b, c]: [R; 3]| kinematics.direction(&[R::ZERO, R::ZERO, R::ZERO, a, b, c]);
        let orientation = path.orientation(reference, &at_tip, seen.estimated.axis, of_axes);
        ([at_tip, at_encoder], orientation)
    }

    #[inline(always)]
    fn seen(&self, feedback: &[P; N], modelled: &Modelled<R, N>, kinematics: &Kinematics<R>) -> Seen<R> {
        let read = self.joints(feedback);
        let mut actual = read;
        let mut moved = false;
        for (axis, error) in self.axes.iter().zip(&modelled.tip_error) {
            if let (true, Some(joint)) = (axis.is_rotary(), actual.get_mut(axis.index())) {
                *joint += *error;
                moved |= *error != R::ZERO;
            }
        }
        let plain = kinematics.forward(&read);
        let Tool { tip, axis } = if moved { kinematics.forward(&actual) } else { plain };
        let error = match &modelled.tip_error[..] {
            [x, y, z, ..] => V3::new(*x, *y, *z),
            _ => V3::ZERO,
        };
        let tilt = kinematics.to_workpiece(&read, modelled.tilt);
        let estimated = Tool { tip: tip + kinematics.to_workpiece(&read, error), axis: axis + tilt.cross(axis) };
        Seen { estimated, encoder: plain.tip }
    }

    /// Positions of the step's axes in the order of the kinematics, rotary ones within ±180 degrees.
    #[inline(always)]
    pub(super) fn joints(&self, positions: &[P; N]) -> [R; AXES] {
        let mut joints = [R::ZERO; AXES];
        let zero = P::default();
        for (axis, position) in self.axes.iter().zip(positions) {
            let Some(joint) = joints.get_mut(axis.index()) else { continue };
            *joint = if axis.is_rotary() {
                let turn: R = position.turn_since(zero);
                // From the other side: an angle near 360 degrees would be rounded as that.
                if turn > R::of(180.0) { -zero.turn_since::<R>(*position) } else { turn }
            } else {
                position.since(zero)
            };
        }
        joints
    }
}

/// Of workpiece coordinates.
#[inline(always)]
fn position<R: Real, P: Position>(tip: V3<R>) -> [P; 3] {
    let zero = P::default();
    [zero.plus(tip.x), zero.plus(tip.y), zero.plus(tip.z)]
}

#[cfg(test)]
pub(super) mod tests;
