//! Contour feedback: u = −(K_p e + K_i ∫e dt), e the contour error of the estimated tip in machine directions.
//!
//! If the error cannot be acted on (foot not bracketed, a corner or an end, ambiguous, cold, in rapid motion, under a
//! fault), the integral stays constant and K_p e ramps out. While any axis is limited, the integrals of all axes stay
//! constant (anti-windup). Where an axis reverses its integral ends: what it corrects, friction and lag, changes sign
//! there, and the old integral would double the error.
//!
//! On an axis with a stated resonance u may pass a notch ([`crate::check::Notch`]).

#![deny(clippy::indexing_slicing)]

use crate::check::Notch;
use crate::machine::FeedbackSettings;
use crate::real::Real;

/// Shortest way back that is a reversal, mm: twice what a program rounded to 1 µm dithers by. Any value to 5 µm serves as well.
pub(super) const REVERSAL: f64 = 2e-3;

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

/// Direction of an axis: the way back until it counts as reversed, with the sign of the direction; 0 before it has moved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heading<R>(R);

impl<R: Real> Heading<R> {
    pub(super) fn new() -> Self {
        Heading(R::ZERO)
    }

    /// Whether the axis reverses in a cycle in which it moves by `way`: it is back by `band` from where it was farthest.
    #[inline(always)]
    pub(super) fn reverses(&mut self, way: R, band: R) -> bool {
        let left = self.0 + way;
        let reverses = self.0 * left <= R::ZERO && self.0 != R::ZERO;
        self.0 = match reverses {
            true if way < R::ZERO => -band,
            true => band,
            false => left.limit(-band, band),
        };
        reverses
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of reversals along these positions, µm; the band is 2 µm.
    fn reversals(positions: &[f64]) -> usize {
        let mut heading = Heading::new();
        positions.iter().zip(positions.iter().skip(1)).filter(|(from, to)| heading.reverses(*to - *from, 2.0)).count()
    }

    #[test]
    fn an_axis_reverses_where_it_is_back_by_the_band_from_where_it_was_farthest() {
        assert_eq!(reversals(&[0.0, 10.0, 8.5, 10.0, 8.5, 12.0, 10.5, 10.1]), 0);
        assert_eq!(reversals(&[0.0, 10.0, 9.0, 8.0, 7.0]), 1);
        assert_eq!(reversals(&[0.0, 10.0, 8.0, 8.0, 9.5, 8.5, 10.0]), 2);
        assert_eq!(reversals(&[0.0, -10.0, -7.0, -7.0, -10.0, -7.0]), 3);
    }

    #[test]
    fn a_narrower_band_turns_nothing_by_itself() {
        for way in [10.0, -10.0] {
            let mut heading = Heading::new();
            assert!(!heading.reverses(way, 5.0));
            assert!(!heading.reverses(0.0, 2.0));
            assert!(!heading.reverses(-0.15 * way, 2.0));
            assert!(heading.reverses(-0.06 * way, 2.0));
        }
    }
}
