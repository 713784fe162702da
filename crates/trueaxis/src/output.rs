//! Last stage: the wanted correction becomes what the drives get, and what the host sees of its feedback.

#![deny(clippy::indexing_slicing)]

use crate::error::{ConfigError, Fault};
use crate::limiter::{Limited, Limiter};
use crate::machine::{Limits, MachineSettings};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Sample, SampleState, Verdict};

/// Limiters and joint ranges: immutable.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Release<R, P, const N: usize> {
    limiters: [Limiter<R>; N],
    joint: [[P; 2]; N],
}

/// What was sent last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReleaseState<R, P, const N: usize> {
    limited: [Limited<R>; N],
    drive: [P; N],
}

impl<R: Real, P: Position, const N: usize> ReleaseState<R, P, N> {
    pub(crate) fn new() -> Self {
        ReleaseState { limited: [Limited::default(); N], drive: [P::default(); N] }
    }

    /// The drive positions sent last.
    pub(crate) fn drive(&self) -> &[P; N] {
        &self.drive
    }

    /// Where a command and the corrections sent last put the drives.
    pub(crate) fn drive_at(&self, command: &[P; N]) -> [P; N] {
        let mut drive = *command;
        for (drive, limited) in drive.iter_mut().zip(&self.limited) {
            *drive = plus(*drive, limited.sent());
        }
        drive
    }
}

/// What goes out in a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Released<R, P, const N: usize> {
    pub(crate) drive: [P; N],
    pub(crate) feedback: [P; N],
    pub(crate) correction: [R; N],
    /// A bit for every axis whose correction differs from the wanted one.
    pub(crate) limited: u8,
    /// A place outside its joint's range, which holds the output.
    pub(crate) outside: Option<u8>,
}

/// Limits of an axis that the machine does not have: it is never corrected, any positive numbers do.
const ABSENT: Limits = Limits { magnitude: 1.0, slope_per_s: 1.0, acceleration_per_s2: 1e3 };

impl<R: Real, P: Position, const N: usize> Release<R, P, N> {
    pub(crate) fn new(machine: &MachineSettings, period_s: f64) -> Result<Self, ConfigError> {
        let axes = crate::compensation::step_axes::<N>(machine)?;
        let idle = Limiter::new(&ABSENT, 1e-3)?;
        let mut release = Release { limiters: [idle; N], joint: [[P::of(f64::MIN), P::of(f64::MAX)]; N] };
        for ((axis, limiter), joint) in axes.into_iter().zip(&mut release.limiters).zip(&mut release.joint) {
            if let Some(settings) = machine.axes.iter().find(|a| a.axis == axis) {
                *limiter = Limiter::new(&settings.limits, period_s).map_err(|error| error.on(axis))?;
                *joint = settings.joint.map(P::of);
            }
        }
        Ok(release)
    }

    /// Command plus limited correction, held where it must be; feedback without the correction.
    #[inline(always)]
    pub(crate) fn release(
        &self,
        state: &mut ReleaseState<R, P, N>,
        sample_state: &mut SampleState<R, P, N>,
        sample: &Sample<P, N>,
        wanted: &[R; N],
    ) -> Released<R, P, N> {
        // The reading of this cycle answers the correction sent before it.
        let mut feedback = sample.feedback;
        for (feedback, limited) in feedback.iter_mut().zip(&state.limited) {
            *feedback = plus(*feedback, -limited.sent());
        }

        let mut flags = 0u8;
        let mut bit = 1u8;
        for ((limiter, limited), wanted) in self.limiters.iter().zip(&mut state.limited).zip(wanted) {
            let differs = match sample.verdict {
                _ if sample.first => false,
                Verdict::Active => limiter.follow(limited, *wanted),
                Verdict::Inactive => limiter.follow(limited, R::ZERO),
                Verdict::Freeze | Verdict::Hold => {
                    limiter.freeze(limited);
                    false
                }
            };
            if differs {
                flags |= bit;
            }
            bit = bit.wrapping_shl(1);
        }

        let mut drive = sample.command;
        let mut correction = [R::ZERO; N];
        for ((drive, limited), correction) in drive.iter_mut().zip(&state.limited).zip(&mut correction) {
            *correction = limited.sent();
            *drive = plus(*drive, limited.sent());
        }
        let mut outside = None;
        match sample.verdict {
            Verdict::Hold if sample.first => {}
            Verdict::Hold => drive = state.drive,
            Verdict::Active | Verdict::Freeze if !sample.first => {
                outside = self.outside(&drive);
                if let Some(place) = outside {
                    sample_state.latch(Fault::JointRange, place);
                    drive = state.drive;
                }
            }
            _ => {}
        }
        state.drive = drive;
        Released { drive, feedback, correction, limited: flags, outside }
    }

    #[inline(always)]
    fn outside(&self, drive: &[P; N]) -> Option<u8> {
        let mut place = 0u8;
        for (drive, [low, high]) in drive.iter().zip(&self.joint) {
            if *drive < *low || *drive > *high {
                return Some(place);
            }
            place = place.wrapping_add(1);
        }
        None
    }
}

/// A zero correction passes a position bit for bit, negative zero included.
#[inline(always)]
fn plus<R: Real, P: Position>(position: P, correction: R) -> P {
    if correction == R::ZERO { position } else { position.plus(correction) }
}
