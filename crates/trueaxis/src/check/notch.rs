//! Notch in the contour feedback at a stated resonance.

use crate::machine::DriveFigures;
use core::f64::consts::{FRAC_PI_2, TAU};

/// Lowest servo rate with a notch, in its frequencies. Near half the rate a notch would be too narrow above its frequency.
pub(super) const LOWEST_RATE: f64 = 4.0;

/// A notch: no gain is lost at rest, and `bottom` remains at its frequency.
///
/// ```text
/// F(s) = (s² + 2 b ζ ω s + ω²)/(s² + 2 ζ ω s + ω²) = 1 − 2 (1 − b) ζ ω s/(s² + 2 ζ ω s + ω²)
/// ```
///
/// It is computed from cycle to cycle with s = ω/tan(ω T/2) (z − 1)/(z + 1), which keeps its frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Notch {
    /// Its frequency ω/2π, Hz.
    pub frequency_hz: f64,
    /// Damping ζ, share of critical: its width.
    pub damping: f64,
    /// Gain b at its frequency.
    pub bottom: f64,
}

impl Notch {
    /// A notch as wide as the family of resonances, about 10 % to both sides.
    pub(super) fn at(frequency_hz: f64) -> Notch {
        Notch { frequency_hz, damping: 1.0, bottom: 0.2 }
    }

    /// The notch of a drive at a servo period, s, if its machine was compiled with one and the servo is fast enough for it.
    pub(crate) fn of(drive: &DriveFigures, period_s: f64) -> Option<Notch> {
        let DriveFigures { resonance_hz, gain_without_notch, .. } = *drive;
        let is_used = resonance_hz > 0.0 && gain_without_notch > 0.0;
        (is_used && LOWEST_RATE * resonance_hz * period_s <= 1.0).then(|| Notch::at(resonance_hz))
    }

    /// Coefficients of the part w that the notch takes away from its input x, for a period in s:
    ///
    /// ```text
    /// w_k = g (x_k − x_(k−2)) − a_1 w_(k−1) − a_2 w_(k−2)
    /// ```
    pub(crate) fn coefficients(&self, period_s: f64) -> [f64; 3] {
        let t = libm::tan(0.5 * TAU * self.frequency_hz * period_s);
        let (width, scale) = (2.0 * self.damping * t, 1.0 + 2.0 * self.damping * t + t * t);
        [(1.0 - self.bottom) * width / scale, 2.0 * (t * t - 1.0) / scale, (1.0 - width + t * t) / scale]
    }
}

/// A notch at a servo period, s; 0: continuous.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sampled {
    pub(super) notch: Notch,
    pub(super) period_s: f64,
}

impl Sampled {
    /// Its value at an angular frequency, 1/s.
    pub(super) fn at(&self, omega: f64) -> [f64; 2] {
        let Notch { frequency_hz, damping, bottom } = self.notch;
        let own = TAU * frequency_hz;
        let half = 0.5 * omega * self.period_s;
        let ratio = match self.period_s > 0.0 {
            // No command has frequencies beyond half the servo rate.
            true if half >= FRAC_PI_2 => return [1.0, 0.0],
            true => libm::tan(half) / libm::tan(0.5 * own * self.period_s),
            false => omega / own,
        };
        // 1 − (1 − b) j x/(1 + j x − r²), x = 2 ζ r.
        let (x, rest) = (2.0 * damping * ratio, 1.0 - ratio * ratio);
        let square = rest * rest + x * x;
        [1.0 - (1.0 - bottom) * x * x / square, -(1.0 - bottom) * x * rest / square]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The recurrence, fed with a sine, gives the value at its frequency.
    #[test]
    fn the_recurrence_has_the_stated_response() {
        let notch = Notch { frequency_hz: 120.0, damping: 0.6, bottom: 0.3 };
        for period_s in [1e-4, 1e-3] {
            let [g, a1, a2] = notch.coefficients(period_s);
            for hz in [5.0, 60.0, 108.0, 120.0, 132.0, 300.0] {
                let (mut s1, mut s2, mut sums) = (0.0, 0.0, [0.0; 2]);
                // Whole waves at the end of the run.
                let (cycles, last) = (40_000, 10_000);
                for k in 0..cycles {
                    let angle = TAU * hz * f64::from(k) * period_s;
                    let x = angle.sin();
                    let w = g * x + s1;
                    s1 = s2 - a1 * w;
                    s2 = -g * x - a2 * w;
                    if k >= cycles - last {
                        sums[0] += 2.0 * (x - w) * angle.sin() / f64::from(last);
                        sums[1] += 2.0 * (x - w) * angle.cos() / f64::from(last);
                    }
                }
                let expected = Sampled { notch, period_s }.at(TAU * hz);
                let apart = (sums[0] - expected[0]).hypot(sums[1] - expected[1]);
                assert!(apart < 1e-6, "{hz} Hz at {period_s}: {sums:?}, expected {expected:?}");
            }
            let bottom = Sampled { notch, period_s }.at(TAU * 120.0);
            assert!((bottom[0] - 0.3).abs() < 1e-12 && bottom[1].abs() < 1e-9, "{bottom:?}");
        }
    }
}
