//! The cycle under a closed planner: its own commands are the path.

#![deny(clippy::indexing_slicing)]

use super::{Output, ServoLoop, State, points};
use crate::contour::{Commanded, ContourError};
use crate::error::Fault;
use crate::position::Position;
use crate::real::Real;
use crate::sample::Input;

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// One servo cycle with the commands themselves as the path: [`ServoLoop::step`] for a host that knows no other.
    ///
    /// The command of the first three axes, once the sample stage believes it, is appended to `commanded`, from which the
    /// contour errors are taken ([`Commanded::contour_error`]); what that path leaves of the planner's is said there.
    /// After homing call [`Commanded::restart`].
    #[inline]
    pub fn step_following<const K: usize>(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        commanded: &mut Commanded<R, P, K>,
    ) -> Output<R, P, N> {
        let sample = self.sampler.read(&mut state.sample, input);
        if let ([x, y, z, ..], true) = (&sample.command[..], !sample.verdict.holds()) {
            commanded.append([*x, *y, *z]);
        }
        let modelled = self.model::<false>(state, &sample);
        let contour = match points(&sample, &modelled) {
            Some(points) => points.map(|point| commanded.contour_error(point)),
            None => [ContourError::none(); 2],
        };
        let output = self.finish_measured(state, &sample, &modelled, contour, |_| ());
        if output.record.fault == Fault::JointRange {
            // The command that was not sent is no part of the way.
            commanded.restart();
        }
        output
    }
}

#[cfg(test)]
mod tests;
