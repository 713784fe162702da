//! Whole revolutions at once: profile and motion of the centre from recorded probe readings, with `rustfft`.
//!
//! ```text
//! s = h1 + k2 h2 + k3 h3        r = F⁻¹{ F{s} / G }, harmonics of the band that are not suppressed
//! R_X = [cos β · (h2 − r(θ + φ2)) − cos(φ2 + β) · (h1 − r(θ))] / sin φ2
//! R_Y = [sin(φ2 + β) · (h1 − r(θ)) − sin β · (h2 − r(θ + φ2))] / sin φ2
//! ```
//!
//! r(θ + φ2) is r with harmonic k turned by e^{jkφ2}: exact for any angle, whole slots or not. Mean and first harmonic of
//! r are zero; they are motion of the centre and appear in R_X and R_Y. θ counts from 0 in steps of 2π/N.
//!
//! Source: Tian Yingzhong and Li Ming, CN1927535; R_Y corrected: the published form does not solve h1 and h2.

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;
use std::vec::Vec;
use trueaxis::error::{ConfigError, Field};
use trueaxis::roundness::{Band, Gain, arm_angle, filter};

/// Noise gain above which a harmonic is suppressed unless another limit is asked for.
pub const NOISE_GAIN_LIMIT: f64 = 100.0;

const I: Complex<f64> = Complex::new(0.0, 1.0);

/// Why no separation is possible.
#[derive(Clone, Debug, PartialEq)]
pub enum NoSeparation {
    /// The probes cannot see some harmonics of the band: all of them.
    Blind(Vec<u16>),
    /// A setting is wrong.
    Setting(ConfigError),
}

impl core::fmt::Display for NoSeparation {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            NoSeparation::Blind(harmonics) => {
                f.write_str("the probes cannot see harmonics ")?;
                for (index, harmonic) in harmonics.iter().enumerate() {
                    write!(f, "{}{harmonic}", if index == 0 { "" } else { ", " })?;
                }
                f.write_str(": needed other angles or a band without them")
            }
            NoSeparation::Setting(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for NoSeparation {}

impl From<ConfigError> for NoSeparation {
    fn from(error: ConfigError) -> Self {
        NoSeparation::Setting(error)
    }
}

/// One revolution taken apart, in the unit of the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Separation {
    /// Profile r(θ); above zero is high. Contains the band's harmonics that are not suppressed, no mean, no first.
    pub profile: Vec<f64>,
    /// Motion R_X(θ) of the centre, across the direction of probe 1.
    pub x: Vec<f64>,
    /// Motion R_Y(θ) of the centre, along the direction of probe 1 with the arm at β = 0.
    pub y: Vec<f64>,
}

/// One harmonic of a profile: `amplitude · cos(k θ + phase)` is in r(θ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// Undulations per revolution k.
    pub k: u16,
    /// Amplitude, at least 0, in the unit of the profile; 0 where suppressed.
    pub amplitude: f64,
    /// Phase in rad, −π to π.
    pub phase: f64,
    /// Growth of the probes' noise in this harmonic.
    pub noise_gain: f64,
    /// The noise gain is above the limit: the harmonic is left out.
    pub suppressed: bool,
}

/// Separates revolutions of N readings; plans its transforms once.
pub struct Separator {
    gain: Gain,
    band: Band,
    /// By harmonic from 0 to the band's last: 1/G, or nothing.
    inverse: Vec<Option<Complex<f64>>>,
    /// `[cos β, sin β]` at every θ.
    arm: Vec<[f64; 2]>,
    forward: Arc<dyn Fft<f64>>,
    backward: Arc<dyn Fft<f64>>,
}

impl Separator {
    /// Plans a separation. Harmonics with a noise gain above `noise_gain_limit` ([`NOISE_GAIN_LIMIT`]) are suppressed.
    /// `arm_ratio` is [`trueaxis::roundness::Arm::ratio`], 0 for probes that stand still.
    ///
    /// # Errors
    /// Harmonics of the band that the probes cannot see, all of them; a band that does not suit the number of points; a
    /// limit that is not above 0; a ratio outside 0 <= λ < 1.
    pub fn new(gain: Gain, band: Band, noise_gain_limit: f64, arm_ratio: f64) -> Result<Self, NoSeparation> {
        let points = gain.points();
        band.check(points)?;
        if noise_gain_limit.is_nan() || noise_gain_limit <= 0.0 {
            return Err(ConfigError::new(Field::NoiseGain, noise_gain_limit, "a noise gain limit above 0").into());
        }
        if !(0.0..1.0).contains(&arm_ratio) {
            return Err(ConfigError::new(Field::ArmCrank, arm_ratio, "R/(R_S + R_W) from 0 to below 1").into());
        }
        let singular: Vec<u16> = gain.singular(band).collect();
        if !singular.is_empty() {
            return Err(NoSeparation::Blind(singular));
        }
        let inverse = (0..=band.last)
            .map(|k| {
                let kept = band.contains(k) && gain.noise_gain(usize::from(k)) <= noise_gain_limit;
                let [re, im] = gain.of(usize::from(k));
                kept.then(|| Complex::new(re, im).inv())
            })
            .collect();
        let arm = (0..points)
            .map(|i| {
                let theta = core::f64::consts::TAU * i as f64 / points as f64;
                arm_angle(arm_ratio, [libm::cos(theta), libm::sin(theta)])
            })
            .collect();
        let mut planner = FftPlanner::new();
        let (forward, backward) = (planner.plan_fft_forward(points), planner.plan_fft_inverse(points));
        Ok(Separator { gain, band, inverse, arm, forward, backward })
    }

    /// The arrangement of probes.
    pub fn gain(&self) -> &Gain {
        &self.gain
    }

    /// Harmonics that the noise gain limit suppresses, ascending.
    pub fn suppressed(&self) -> impl Iterator<Item = u16> + '_ {
        self.band.iter().filter(|k| self.inverse(*k).is_none())
    }

    fn inverse(&self, harmonic: u16) -> Option<Complex<f64>> {
        self.inverse.get(usize::from(harmonic)).copied().flatten()
    }

    /// Takes apart one revolution of N readings of the three probes, equidistant in θ from 0. Two transforms; noise free
    /// and with a profile inside the band, exact to the rounding of the readings times the noise gain.
    ///
    /// # Errors
    /// Not N readings of every probe.
    pub fn separate(&self, probes: [&[f64]; 3]) -> Result<Separation, ConfigError> {
        for (index, probe) in probes.into_iter().enumerate() {
            self.check(probe).map_err(|error| error.at(index))?;
        }
        let [h1, h2, h3] = probes;
        let (k2, k3) = (self.gain.k2(), self.gain.k3());
        let sum = h1.iter().zip(h2).zip(h3).map(|((h1, h2), h3)| h1 + k2 * h2 + k3 * h3);
        let spectrum = self.spectrum(sum);
        // The profile as real part and the profile seen by probe 2 as imaginary part, in one transform.
        let both = self.synthesis(|k| {
            let here = self.inverse(k)? * spectrum.get(usize::from(k))?;
            let [cos, sin] = self.gain.phase2(usize::from(k));
            Some([here, here * Complex::new(cos, sin)])
        });
        // The mean radius, against the probes' zeros: with an arm it would look like motion. G(0) is real.
        let [mean_gain, _] = self.gain.of(0);
        let sees_mean = libm::fabs(mean_gain) > 1e-6 * self.gain.norm();
        let radius = spectrum.first().filter(|_| sees_mean).map_or(0.0, |mean| mean.re / mean_gain);
        let (cos2, sin2) = (libm::cos(self.gain.phi2()), libm::sin(self.gain.phi2()));
        let points = self.gain.points();
        let mut parts =
            Separation { profile: Vec::with_capacity(points), x: Vec::with_capacity(points), y: Vec::new() };
        for (((h1, h2), profile), [cos, sin]) in h1.iter().zip(h2).zip(&both).zip(&self.arm) {
            let (one, two) = (h1 - profile.re - radius, h2 - profile.im - radius);
            // cos and sin of φ2 + β.
            let (cos_two, sin_two) = (cos2 * cos - sin2 * sin, sin2 * cos + cos2 * sin);
            parts.profile.push(profile.re);
            parts.x.push((cos * two - cos_two * one) / sin2);
            parts.y.push((sin_two * one - sin * two) / sin2);
        }
        Ok(parts)
    }

    /// The harmonics of a profile over the band, suppressed ones marked.
    ///
    /// # Errors
    /// Not N points.
    pub fn harmonics(&self, profile: &[f64]) -> Result<Vec<Harmonic>, ConfigError> {
        self.check(profile)?;
        let spectrum = self.spectrum(profile.iter().copied());
        let harmonics = self.band.iter().map(|k| {
            let suppressed = self.inverse(k).is_none();
            let value = spectrum.get(usize::from(k)).filter(|_| !suppressed).copied().unwrap_or_default();
            let noise_gain = self.gain.noise_gain(usize::from(k));
            Harmonic { k, amplitude: 2.0 * value.norm(), phase: value.arg(), noise_gain, suppressed }
        });
        Ok(harmonics.collect())
    }

    /// The profile behind a Gaussian filter (ISO 16610-21) with a cut-off in undulations per revolution; what lies
    /// outside the band is left out.
    ///
    /// # Errors
    /// Not N points, a cut-off that is not in [`filter::CUT_OFFS`].
    pub fn filtered(&self, profile: &[f64], cut_off: u16) -> Result<Vec<f64>, ConfigError> {
        self.check(profile)?;
        filter::check(cut_off)?;
        let spectrum = self.spectrum(profile.iter().copied());
        let filtered = self.synthesis(|k| {
            let here = spectrum.get(usize::from(k))? * filter::transmission(usize::from(k), cut_off);
            Some([here, Complex::default()])
        });
        Ok(filtered.iter().map(|value| value.re).collect())
    }

    fn check(&self, values: &[f64]) -> Result<(), ConfigError> {
        if values.len() == self.gain.points() {
            return Ok(());
        }
        Err(ConfigError::new(Field::Points, values.len() as f64, "one revolution, N values"))
    }

    /// Complex amplitudes c(k) of e^{jkθ}.
    fn spectrum(&self, values: impl Iterator<Item = f64>) -> Vec<Complex<f64>> {
        let scale = 1.0 / self.gain.points() as f64;
        let mut buffer: Vec<Complex<f64>> = values.map(|value| Complex::new(value * scale, 0.0)).collect();
        self.forward.process(&mut buffer);
        buffer
    }

    /// Two real series from their amplitudes over the band, the second as imaginary part.
    fn synthesis(&self, amplitudes: impl Fn(u16) -> Option<[Complex<f64>; 2]>) -> Vec<Complex<f64>> {
        let points = self.gain.points();
        let mut buffer = std::vec![Complex::default(); points];
        for k in self.band.iter() {
            let [first, second] = amplitudes(k).unwrap_or_default();
            if let Some(slot) = buffer.get_mut(usize::from(k)) {
                *slot = first + I * second;
            }
            if let Some(slot) = buffer.get_mut(points - usize::from(k)) {
                *slot = first.conj() + I * second.conj();
            }
        }
        self.backward.process(&mut buffer);
        buffer
    }
}

#[cfg(test)]
mod tests;
