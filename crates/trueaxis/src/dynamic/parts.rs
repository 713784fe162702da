//! The parts of the dynamic correction: switched by the host, listed separately in the record.

use crate::real::Real;

/// Parts of the dynamic correction that the host wants in a cycle, as bits. Parts that are not configured stay off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Dynamics(pub u8);

impl Dynamics {
    /// No part.
    pub const NONE: Dynamics = Dynamics(0);
    /// Friction at reversals.
    pub const FRICTION: Dynamics = Dynamics(1);
    /// Velocity that the drive does not feed forward.
    pub const LAG: Dynamics = Dynamics(2);
    /// Velocity error that an acceleration requires of the velocity loop.
    pub const ACCELERATION: Dynamics = Dynamics(4);
    /// Contour feedback.
    pub const FEEDBACK: Dynamics = Dynamics(8);
    /// Acceleration cross-talk.
    pub const CROSSTALK: Dynamics = Dynamics(16);
    /// Learned correction.
    pub const LEARNED: Dynamics = Dynamics(32);
    /// Lost motion, taken up from the reversal of the command.
    pub const TAKE_UP: Dynamics = Dynamics(64);
    /// Every configured part.
    pub const ALL: Dynamics = Dynamics(127);
    /// No part but a rule: friction, lag and acceleration act only as far as the contour error shows that they help, from
    /// no share on; the contour feedback acts on no error at rest.
    pub const ON_TRIAL: Dynamics = Dynamics(128);

    /// Whether all bits of `other` are set.
    #[inline(always)]
    pub const fn has(self, other: Dynamics) -> bool {
        self.0 & other.0 == other.0
    }

    /// Without the bits of `other`.
    #[must_use]
    pub const fn without(self, other: Dynamics) -> Dynamics {
        Dynamics(self.0 & !other.0)
    }
}

impl Default for Dynamics {
    /// Every configured part.
    fn default() -> Self {
        Dynamics::ALL
    }
}

/// The dynamic correction of a cycle and the parts that requested it, mm (deg), by slot.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(not(feature = "bench"), non_exhaustive)]
pub struct DynamicParts<R, const N: usize> {
    /// d, after its limiter: the drive gets `command + correction + sent`.
    pub sent: [R; N],
    /// Wanted for friction, lag and acceleration.
    pub feed_forward: [R; N],
    /// Wanted by the contour feedback.
    pub feedback: [R; N],
    /// Wanted against cross-talk.
    pub crosstalk: [R; N],
    /// Wanted by the learned correction.
    pub learned: [R; N],
}

impl<R: Real, const N: usize> DynamicParts<R, N> {
    /// Nothing wanted, nothing sent.
    #[inline(always)]
    pub(crate) fn none() -> Self {
        let none = [R::ZERO; N];
        DynamicParts { sent: none, feed_forward: none, feedback: none, crosstalk: none, learned: none }
    }
}
