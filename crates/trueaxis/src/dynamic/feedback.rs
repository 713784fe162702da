//! Contour feedback: u = −(K_p e + K_i ∫e dt), e the contour error of the estimated tip in machine directions.
//!
//! If the error cannot be acted on (foot not bracketed, a corner or an end, ambiguous, cold, in rapid motion, under a
//! fault), the integral stays constant and K_p e ramps out. While any axis is limited, the integrals of all axes stay
//! constant (anti-windup).
//!
//! On an axis with a stated resonance u may pass a notch ([`crate::check::Notch`]).

#![deny(clippy::indexing_slicing)]

use crate::check::Notch;
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

/// A notch at the servo period: takes the part w of its input x away.
///
/// ```text
/// w_k = g (x_k − x_(k−2)) − a_1 w_(k−1) − a_2 w_(k−2)
/// ```
///
/// w is exactly zero at rest, also in single precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct NotchFilter<R> {
    gain: R,
    back: [R; 2],
}

/// The sums of earlier cycles that the next w and the one after it get.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NotchState<R>([R; 2]);

impl<R: Real> NotchFilter<R> {
    /// A filter that changes nothing.
    pub(super) fn none() -> Self {
        NotchFilter { gain: R::ZERO, back: [R::ZERO; 2] }
    }

    pub(super) fn new(notch: &Notch, period_s: f64) -> Self {
        let [gain, a1, a2] = notch.coefficients(period_s);
        NotchFilter { gain: R::of(gain), back: [R::of(a1), R::of(a2)] }
    }

    /// The filtered offset; the state moves on if the cycle is `due`.
    #[inline(always)]
    pub(super) fn filtered(&self, state: &mut NotchState<R>, x: R, due: bool) -> R {
        let NotchState([first, second]) = *state;
        let [a1, a2] = self.back;
        let taken = self.gain * x + first;
        if due {
            *state = NotchState([second - a1 * taken, -(self.gain * x) - a2 * taken]);
        }
        x - taken
    }
}
