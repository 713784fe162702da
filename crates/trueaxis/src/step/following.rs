//! The cycle under a closed planner: its own commands are the path.

#![deny(clippy::indexing_slicing)]

use super::{Output, ServoLoop, State};
use crate::contour::Commanded;
use crate::position::Position;
use crate::real::Real;
use crate::sample::Input;

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// One servo cycle with the commands themselves as the path: [`ServoLoop::step`] for a host that knows no other.
    ///
    /// The command of the first three axes, once the sample stage believes it, is appended to `commanded`; its path and
    /// its end are then path and reference of the step. What that path leaves of the planner's is said at [`Commanded`].
    /// Before homing, and after a jump, call [`Commanded::restart`] or leave it to the bound there.
    #[inline]
    pub fn step_following<const K: usize>(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        commanded: &mut Commanded<R, P, K>,
    ) -> Output<R, P, N> {
        let sample = self.sampler.read(&mut state.sample, input);
        if let [x, y, z, ..] = sample.command[..] {
            commanded.append([x, y, z]);
        }
        let modelled = self.model::<false>(state, &sample);
        self.finish(state, &sample, &modelled, &commanded.path(), commanded.reference())
    }
}

#[cfg(test)]
mod tests;
