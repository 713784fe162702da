//! Margins of a loop given by its open-loop transfer function, a ratio of polynomials with a dead time.

use super::notch::Sampled;

/// Number of evaluated frequencies, evenly spaced in their logarithm.
const POINTS: u16 = 512;
/// Bisections of the interval between two evaluated frequencies: accurate to one part in 10⁹.
const HALVINGS: u8 = 40;

/// A margin and its frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// Degrees for a phase margin, decibels for a gain margin.
    pub value: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
}

/// L(s) = N(s)/D(s) · e^(−s T) · F(s), coefficients of N and D from the constant term on, T in s, F a notch if there is
/// one.
#[derive(Clone, Copy, Debug)]
pub(super) struct OpenLoop {
    pub(super) numerator: [f64; 4],
    pub(super) denominator: [f64; 6],
    pub(super) dead_time_s: f64,
    pub(super) notch: Option<Sampled>,
}

/// Present margins of a loop, and the largest permitted factor on its gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    pub(super) phase: Option<Margin>,
    pub(super) gain: Option<Margin>,
    pub(super) factor: f64,
}

/// A polynomial at s = jω, real and imaginary part.
fn at(polynomial: &[f64], omega: f64) -> [f64; 2] {
    polynomial.iter().rev().fold([0.0, 0.0], |[re, im], c| [c - omega * im, omega * re])
}

fn size([re, im]: [f64; 2]) -> f64 {
    libm::hypot(re, im)
}

pub(super) fn decibels(gain: f64) -> f64 {
    20.0 * libm::log10(gain)
}

impl OpenLoop {
    /// L(jω). Not inlined: a controller's image would contain it ten times.
    #[inline(never)]
    pub(super) fn at(&self, omega: f64) -> [f64; 2] {
        let ([a, b], [c, d]) = (at(&self.numerator, omega), at(&self.denominator, omega));
        let square = c * c + d * d;
        let [re, im] = [(a * c + b * d) / square, (b * c - a * d) / square];
        let (cos, sin) = (libm::cos(omega * self.dead_time_s), libm::sin(omega * self.dead_time_s));
        let [re, im] = [re * cos + im * sin, im * cos - re * sin];
        let Some(notch) = &self.notch else { return [re, im] };
        let [a, b] = notch.at(omega);
        [re * a - im * b, re * b + im * a]
    }

    /// The margins between two angular frequencies, 1/s. `least_phase_deg` (up to 90) and `least_gain_db` are the
    /// required ones.
    ///
    /// From the first frequency at which the lag comes within the phase margin of 180°, the gain must stay below 1; from
    /// the first one at which it reaches 180°, below 1 by the gain margin. If the gain falls with the frequency, these
    /// are the usual margins at the first crossings; a loop whose gain rises again beyond them is judged by its peak. A
    /// loop that keeps to them is stable if N/D is (Nyquist).
    ///
    /// Cost: some thousand values of the loop.
    #[inline(never)]
    pub(super) fn margins(&self, [low, high]: [f64; 2], least_phase_deg: f64, least_gain_db: f64) -> Found {
        let ratio = libm::pow(high / low, 1.0 / f64::from(POINTS));
        let cosine = libm::cos(least_phase_deg.to_radians());
        let edges: [&dyn Fn([f64; 2]) -> bool; 2] =
            [&|[re, im]| re < -cosine * size([re, im]), &|[re, im]| re < 0.0 && im >= 0.0];
        let mut largest: [Option<[f64; 2]>; 2] = [None; 2];
        let mut phase: Option<Margin> = None;
        let above = |omega: f64| size(self.at(omega)) >= 1.0;
        // The lag is tracked from frequency to frequency, as it may exceed a full turn.
        let (mut before, mut last) = (low, self.at(low));
        let mut angle = libm::atan2(last[1], last[0]);
        for point in 0..=POINTS {
            let omega = low * libm::pow(ratio, f64::from(point));
            let value = self.at(omega);
            for (lags, largest) in edges.into_iter().zip(&mut largest) {
                if largest.is_none() && lags(value) {
                    let entry = halved([before, omega], |omega| lags(self.at(omega)));
                    *largest = Some([entry, size(self.at(entry))]);
                }
                if largest.is_some_and(|[_, most]| size(value) > most) {
                    *largest = Some(self.peak([before, omega * ratio]));
                }
            }
            if above(before) != above(omega) {
                let was = above(before);
                let omega = halved([before, omega], |omega| above(omega) != was);
                let value = 180.0 + (angle + turned(last, self.at(omega))).to_degrees();
                let margin = Margin { value, frequency_hz: hertz(omega) };
                phase = Some(phase.filter(|least| least.value <= margin.value).unwrap_or(margin));
            }
            angle += turned(last, value);
            (before, last) = (omega, value);
        }
        let [at_margin, at_half] = largest;
        let allowed = libm::exp10(-least_gain_db / 20.0);
        let of = |largest: Option<[f64; 2]>, allowed: f64| largest.map_or(f64::INFINITY, |[_, gain]| allowed / gain);
        let gain = at_half.map(|[omega, gain]| Margin { value: -decibels(gain), frequency_hz: hertz(omega) });
        Found { phase, gain, factor: of(at_margin, 1.0).min(of(at_half, allowed)) }
    }

    /// The largest gain between two frequencies, with its frequency, by golden-section search.
    #[inline(never)]
    fn peak(&self, [mut low, mut high]: [f64; 2]) -> [f64; 2] {
        const SECTION: f64 = 0.381_966_011_250_105_15;
        for _ in 0..HALVINGS {
            let (left, right) = (low + SECTION * (high - low), high - SECTION * (high - low));
            if size(self.at(left)) < size(self.at(right)) {
                low = left;
            } else {
                high = right;
            }
        }
        let omega = 0.5 * (low + high);
        [omega, size(self.at(omega))]
    }
}

/// Angle from one complex number to another, less than half a turn.
fn turned([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    libm::atan2(a * d - b * c, a * c + b * d)
}

pub(super) fn hertz(omega: f64) -> f64 {
    omega / core::f64::consts::TAU
}

/// Bisection: the frequency before the second one at which a condition becomes true; the first one if it is already true
/// there.
fn halved([mut low, mut high]: [f64; 2], holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::{Found, OpenLoop};

    fn found(numerator: [f64; 4], denominator: [f64; 6], dead_time_s: f64) -> Found {
        OpenLoop { numerator, denominator, dead_time_s, notch: None }.margins([1e-3, 1e5], 60.0, 12.0)
    }

    fn close(found: f64, expected: f64) {
        assert!((found / expected - 1.0).abs() < 1e-6, "{found}, expected {expected}");
    }

    const TURN: f64 = core::f64::consts::TAU;
    /// 12 dB.
    const QUARTER: f64 = 0.251_188_643_150_958;

    /// K/s with a dead time: the gain is 1 at ω = K and the phase there −90° − K T; it reaches −180° at π/(2 T), −120° at
    /// π/(6 T).
    #[test]
    fn an_integrator_with_dead_time() {
        for (gain, dead) in [(10.0, 1e-3), (100.0, 1e-3), (100.0, 5e-3), (400.0, 5e-3)] {
            let found = found([gain, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0], dead);
            let (phase, margin) = (found.phase.unwrap(), found.gain.unwrap());
            close(phase.value, 90.0 - (gain * dead).to_degrees());
            close(phase.frequency_hz, gain / TURN);
            let half = TURN / 4.0 / dead;
            close(margin.value, 20.0 * libm::log10(half / gain));
            close(margin.frequency_hz, half / TURN);
            close(found.factor, (QUARTER * half / gain).min(half / 3.0 / gain));
        }
    }

    /// K/(s (1 + s T)): 45° where ω T = 1, which is K = √2/T; never −180°. −120° at tan 30°.
    #[test]
    fn an_integrator_with_a_lag() {
        let lag = 0.02;
        let found = found([2_f64.sqrt() / lag, 0.0, 0.0, 0.0], [0.0, 1.0, lag, 0.0, 0.0, 0.0], 0.0);
        close(found.phase.unwrap().value, 45.0);
        close(found.phase.unwrap().frequency_hz, 1.0 / lag / TURN);
        assert_eq!(found.gain, None);
        let edge = 1.0 / 3_f64.sqrt();
        close(found.factor, edge * (1.0 + edge * edge).sqrt() / 2_f64.sqrt());
    }

    /// K/(1 + s)³: −180° at ω = √3, where the gain is K/8.
    #[test]
    fn three_lags() {
        let found = found([2.0, 0.0, 0.0, 0.0], [1.0, 3.0, 3.0, 1.0, 0.0, 0.0], 0.0);
        close(found.gain.unwrap().value, 20.0 * libm::log10(4.0));
        close(found.gain.unwrap().frequency_hz, 3_f64.sqrt() / TURN);
        close(found.factor, QUARTER * 4.0);
        // Unstable: both margins are negative.
        let found = self::found([16.0, 0.0, 0.0, 0.0], [1.0, 3.0, 3.0, 1.0, 0.0, 0.0], 0.0);
        assert!(found.phase.unwrap().value < 0.0);
        close(found.gain.unwrap().value, 20.0 * libm::log10(0.5));
    }

    /// A gain below 1 everywhere has no phase margin; a lag that never reaches 120° sets no bound.
    #[test]
    fn loops_without_margins() {
        let lag = found([0.5, 0.0, 0.0, 0.0], [1.0, 0.1, 0.0, 0.0, 0.0, 0.0], 0.0);
        assert_eq!(lag, Found { phase: None, gain: None, factor: f64::INFINITY });
    }

    /// A resonance beyond the first crossings: its peak decides. K/(s (s²/n² + 2 D s/n + 1)) has its phase of −180° and
    /// its peak at n, where the gain is K/(2 D n).
    #[test]
    fn a_peak_behind_the_crossover() {
        let (n, damping, gain) = (200.0, 0.002, 1.0);
        let denominator = [0.0, 1.0, 2.0 * damping / n, 1.0 / (n * n), 0.0, 0.0];
        let found = found([gain, 0.0, 0.0, 0.0], denominator, 0.0);
        assert!((found.gain.unwrap().value - 20.0 * libm::log10(2.0 * damping * n / gain)).abs() < 1e-4);
        assert!((found.factor / (QUARTER * 2.0 * damping * n / gain) - 1.0).abs() < 1e-4, "{}", found.factor);
    }
}
