//! A position encoder: subdivisional error, noise, whole counts.

use crate::range::Range;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use trueaxis::machine::Axis;

/// Errors of an encoder. For a rotary axis, read degree for mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EncoderSettings {
    /// Travel per count, mm.
    pub resolution_mm: f64,
    /// Period of the scanning signal, mm.
    pub signal_period_mm: f64,
    /// Amplitude of the subdivisional error, once per signal period, mm.
    pub sde_first_mm: f64,
    /// Amplitude of the subdivisional error, twice per signal period, mm.
    pub sde_second_mm: f64,
    /// Standard deviation of white noise, mm.
    pub noise_rms_mm: f64,
}

impl EncoderSettings {
    /// A sealed linear encoder: 10 nm per count, 20 µm signal period, 30 and 15 nm subdivisional error, 5 nm noise.
    pub const LINEAR: EncoderSettings = EncoderSettings {
        resolution_mm: 10e-6,
        signal_period_mm: 20e-3,
        sde_first_mm: 30e-6,
        sde_second_mm: 15e-6,
        noise_rms_mm: 5e-6,
    };

    /// A rotary encoder of 16384 lines: 5e-6° per count, 30e-6° and 15e-6° (0.1″ and 0.05″) subdivisional error, 2e-6° noise.
    pub const ROTARY: EncoderSettings = EncoderSettings {
        resolution_mm: 5e-6,
        signal_period_mm: 360.0 / 16384.0,
        sde_first_mm: 30e-6,
        sde_second_mm: 15e-6,
        noise_rms_mm: 2e-6,
    };

    /// The default encoder of an axis.
    pub fn of(axis: Axis) -> EncoderSettings {
        if axis.is_rotary() { EncoderSettings::ROTARY } else { EncoderSettings::LINEAR }
    }

    /// Name, value and range of every setting.
    pub(crate) fn ranges(&self) -> [Range<'static>; 5] {
        let range = |key, found, low, high| Range { key, found, low, high, unit: "mm" };
        [
            range("resolution_mm", self.resolution_mm, 1e-9, 1.0),
            range("signal_period_mm", self.signal_period_mm, 1e-6, 1000.0),
            range("sde_first_mm", self.sde_first_mm, 0.0, 1.0),
            range("sde_second_mm", self.sde_second_mm, 0.0, 1.0),
            range("noise_rms_mm", self.noise_rms_mm, 0.0, 1.0),
        ]
    }
}

/// The encoders of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Encoders {
    /// Encoders of linear axes.
    pub linear: EncoderSettings,
    /// Encoders of rotary axes; read degree for mm.
    pub rotary: EncoderSettings,
}

impl Default for Encoders {
    fn default() -> Encoders {
        Encoders { linear: EncoderSettings::LINEAR, rotary: EncoderSettings::ROTARY }
    }
}

/// An encoder with a separate stream of noise.
#[derive(Clone, Debug)]
pub struct Encoder {
    settings: EncoderSettings,
    noise: ChaCha8Rng,
}

impl Encoder {
    /// The encoder of `axis`. A seed gives it the same noise on every machine, whichever other axes that has.
    pub fn new(settings: EncoderSettings, axis: Axis, seed: u64) -> Encoder {
        let mut noise = ChaCha8Rng::seed_from_u64(seed);
        noise.set_stream(axis.index() as u64);
        Encoder { settings, noise }
    }

    /// Travel per count, mm (deg).
    pub fn resolution(&self) -> f64 {
        self.settings.resolution_mm
    }

    /// Reading at the true position x (mm, deg), in counts:
    ///
    /// ```text
    /// round( (x + a1 sin φ + a2 sin 2φ + noise) / resolution ),   φ = 2π x / signal period
    /// ```
    pub fn read(&mut self, position: f64) -> i64 {
        let s = &self.settings;
        let (sin, cos) = libm::sincos(TAU * (position / s.signal_period_mm).fract());
        let sde = s.sde_first_mm * sin + s.sde_second_mm * 2.0 * sin * cos;
        let normal: f64 = StandardNormal.sample(&mut self.noise);
        ((position + sde + s.noise_rms_mm * normal) / s.resolution_mm).round() as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quiet() -> EncoderSettings {
        EncoderSettings { sde_first_mm: 0.0, sde_second_mm: 0.0, noise_rms_mm: 0.0, ..EncoderSettings::of(Axis::X) }
    }

    #[test]
    fn quantisation_stays_within_half_a_count() {
        let mut encoder = Encoder::new(quiet(), Axis::X, 1);
        let mut worst: f64 = 0.0;
        for k in -5000..5000 {
            let x = f64::from(k) * 0.037_123_4;
            let read = encoder.read(x) as f64 * encoder.resolution();
            worst = worst.max((read - x).abs());
        }
        assert!(worst <= 5e-6 * (1.0 + 1e-6) && worst > 4.9e-6, "{worst}");
    }

    #[test]
    fn subdivisional_error_has_its_two_harmonics() {
        let settings = EncoderSettings { resolution_mm: 1e-9, noise_rms_mm: 0.0, ..EncoderSettings::of(Axis::X) };
        let mut encoder = Encoder::new(settings, Axis::X, 1);
        let n = 4096;
        let mut amplitude = [0.0; 4];
        for k in 0..n {
            let turn = f64::from(k) / f64::from(n);
            let x = 17.0 + turn * settings.signal_period_mm;
            let error = encoder.read(x) as f64 * settings.resolution_mm - x;
            for (harmonic, sum) in amplitude.iter_mut().enumerate() {
                *sum += 2.0 / f64::from(n) * error * (TAU * harmonic as f64 * turn).sin();
            }
        }
        assert!((amplitude[1] - 30e-6).abs() < 1e-8, "{amplitude:?}");
        assert!((amplitude[2] - 15e-6).abs() < 1e-8, "{amplitude:?}");
        assert!(amplitude[3].abs() < 1e-8, "{amplitude:?}");
    }

    #[test]
    fn noise_has_its_deviation_and_repeats_with_its_seed() {
        let settings = EncoderSettings { resolution_mm: 1e-9, noise_rms_mm: 5e-6, ..quiet() };
        let run = |axis, seed| {
            let mut encoder = Encoder::new(settings, axis, seed);
            (0..20_000).map(|_| encoder.read(0.0)).collect::<Vec<i64>>()
        };
        let readings = run(Axis::X, 7);
        let rms = (readings.iter().map(|&c| (c as f64 * 1e-9).powi(2)).sum::<f64>() / 20_000.0).sqrt();
        // Standard error of the deviation: 5 nm / sqrt(2 · 20000) = 0.025 nm.
        assert!((rms - 5e-6).abs() < 0.1e-6, "{rms}");
        assert_eq!(readings, run(Axis::X, 7));
        assert_ne!(readings, run(Axis::X, 8));
        assert_ne!(readings, run(Axis::Y, 7));
    }
}
