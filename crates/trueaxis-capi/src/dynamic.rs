//! The dynamic correction of a cycle: its switches, and its parts in the record.

use crate::Real;
use crate::axes::{AXES_MAX, padded_numbers};
use trueaxis::{DynamicParts, Dynamics};

/// Bit of `dynamics_off`: friction at reversals.
pub const DYNAMICS_FRICTION: u8 = 1;
/// Bit of `dynamics_off`: velocity that the drive does not feed forward itself.
pub const DYNAMICS_LAG: u8 = 2;
/// Bit of `dynamics_off`: velocity error that an acceleration requires of the velocity loop.
pub const DYNAMICS_ACCELERATION: u8 = 4;
/// Bit of `dynamics_off`: contour feedback. It acts only in a step with a measure.
pub const DYNAMICS_FEEDBACK: u8 = 8;
/// Bit of `dynamics_off`: acceleration cross-talk.
pub const DYNAMICS_CROSSTALK: u8 = 16;
/// Bit of `dynamics_off`: learned correction.
pub const DYNAMICS_LEARNED: u8 = 32;
/// Bit of `dynamics_off`: lost motion taken up from the reversal of the command.
pub const DYNAMICS_TAKE_UP: u8 = 64;
/// All parts of the dynamic correction: bits of `dynamics_off`.
pub const DYNAMICS_ALL: u8 = 127;
/// Bit of `dynamics_off`: no part but a rule. Friction, lag and acceleration are off until the contour error shows that
/// they help, then act as far as it shows that, and are led out where they harm; the contour feedback acts on no error
/// at rest. Without a measure nothing is shown, and the three stay off. For drives whose figures are uncertain: 8 %
/// instead of 22 % of simulated plants get more than 5 % worse than without dynamic correction, at the price of little
/// gain on tracks of one or two seconds.
pub const DYNAMICS_ON_TRIAL: u8 = 128;

const _: () = assert!(
    DYNAMICS_FRICTION == Dynamics::FRICTION.0
        && DYNAMICS_LAG == Dynamics::LAG.0
        && DYNAMICS_ACCELERATION == Dynamics::ACCELERATION.0
        && DYNAMICS_FEEDBACK == Dynamics::FEEDBACK.0
        && DYNAMICS_CROSSTALK == Dynamics::CROSSTALK.0
        && DYNAMICS_LEARNED == Dynamics::LEARNED.0
        && DYNAMICS_TAKE_UP == Dynamics::TAKE_UP.0
        && DYNAMICS_ALL == Dynamics::ALL.0
        && DYNAMICS_ON_TRIAL == Dynamics::ON_TRIAL.0
);

/// The dynamic correction of a cycle by axis, mm (rotary axes: degrees). `sent` is the limited sum of the other
/// members.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Dynamic {
    /// Sent: `drive = command + correction + sent`.
    pub sent: [Real; AXES_MAX],
    /// Requested for friction, lag and acceleration.
    pub feed_forward: [Real; AXES_MAX],
    /// Requested by the contour feedback.
    pub feedback: [Real; AXES_MAX],
    /// Requested against cross-talk.
    pub crosstalk: [Real; AXES_MAX],
    /// Requested by the learned correction.
    pub learned: [Real; AXES_MAX],
}

impl Dynamic {
    const ZERO: [Real; AXES_MAX] = [0.0; AXES_MAX];
    pub(crate) const NONE: Dynamic = Dynamic {
        sent: Self::ZERO,
        feed_forward: Self::ZERO,
        feedback: Self::ZERO,
        crosstalk: Self::ZERO,
        learned: Self::ZERO,
    };

    #[inline(always)]
    pub(crate) fn of<const N: usize>(parts: &DynamicParts<Real, N>) -> Self {
        Dynamic {
            sent: padded_numbers(&parts.sent),
            feed_forward: padded_numbers(&parts.feed_forward),
            feedback: padded_numbers(&parts.feedback),
            crosstalk: padded_numbers(&parts.crosstalk),
            learned: padded_numbers(&parts.learned),
        }
    }
}
