//! Contour feedback: u = −(K_p e + K_i ∫e dt), e the contour error of the estimated tip in machine directions.
//!
//! If the error cannot be acted on (foot not bracketed, a corner or an end, ambiguous, cold, in rapid motion, under a
//! fault), the integral stays constant and K_p e ramps out. While any axis is limited, the integrals of all axes stay
//! constant (anti-windup).

#![deny(clippy::indexing_slicing)]

use crate::machine::FeedbackSettings;
use crate::real::Real;

/// Gains, and the fastest motion with feedback.
#[derive(Clone, Copy, Debug)]
pub(super) struct Feedback<R> {
    proportional: R,
    /// Per period.
    integral: R,
    /// Square of the largest distance per period.
    fastest: R,
}

impl<R: Real> Feedback<R> {
    pub(super) fn new(settings: &FeedbackSettings, period_s: f64) -> Self {
        let fastest = settings.max_feed_per_s * period_s;
        Feedback {
            proportional: R::of(settings.proportional),
            integral: R::of(settings.integral_per_s * period_s),
            fastest: R::of(fastest * fastest),
        }
    }

    /// Whether the motion is slow enough for feedback; `ways`: distances of a cycle.
    #[inline(always)]
    pub(super) fn reaches(&self, ways: impl Iterator<Item = R>) -> bool {
        let mut square = R::ZERO;
        for way in ways {
            square += way * way;
        }
        square <= self.fastest
    }

    /// The wanted offset of an axis; `error` is `None` if it cannot be acted on, `share` that of K_p.
    #[inline(always)]
    pub(super) fn offset(&self, integral: &mut R, error: Option<R>, share: R, limited: bool, most: R) -> R {
        let Some(error) = error else { return -*integral };
        if !limited {
            *integral = (*integral + self.integral * error).limit(-most, most);
        }
        -(self.proportional * share * error + *integral)
    }
}
