//! Separation of whole revolutions: profile and motion of the centre from recorded probe readings, by transforms of real
//! series (`realfft`).
//!
//! ```text
//! s = h1 + k2 h2 + k3 h3        r = F⁻¹{ F{s} / G }, harmonics of the band that are not suppressed
//! R_X = [cos β · (h2 − r(θ + φ2)) − cos(φ2 + β) · (h1 − r(θ))] / sin φ2
//! R_Y = [sin(φ2 + β) · (h1 − r(θ)) − sin β · (h2 − r(θ + φ2))] / sin φ2
//! ```
//!
//! r(θ + φ2) is r with harmonic k rotated by e^{jkφ2}: exact for any angle, whole slots or not. Mean and first harmonic of r
//! are zero; they are motion of the centre and appear in R_X and R_Y. θ starts at 0 and advances in steps of 2π/N.
//!
//! Source: Tian Yingzhong and Li Ming, CN1927535; R_Y corrected: the published form does not solve h1 and h2.
//!
//! Four to six probes are separated by least squares over all readings ([`Separator::of_places`]), and [`Agreement`] tells
//! how far they disagree.

mod agreement;
mod least_squares;
mod transforms;

pub use agreement::{Agreement, Mounting};

use crate::probe_places::ProbePlaces;
use least_squares::LeastSquares;
use realfft::num_complex::Complex;
use std::vec::Vec;
use transforms::Transforms;
use trueaxis::error::{ConfigError, Field};
use trueaxis::roundness::{Band, Gain, arm_angle, filter};

/// Default noise gain above which a harmonic is suppressed.
pub const NOISE_GAIN_LIMIT: f64 = 100.0;

/// Why separation is impossible.
#[derive(Clone, Debug, PartialEq)]
pub enum NoSeparation {
    /// The probes do not observe these harmonics of the band.
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

/// Separated revolution, in the unit of the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Separation {
    /// Profile r(θ), positive for high points. It contains the unsuppressed harmonics of the band, without mean and first
    /// harmonic.
    pub profile: Vec<f64>,
    /// Motion R_X(θ) of the centre, across the direction of probe 1.
    pub x: Vec<f64>,
    /// Motion R_Y(θ) of the centre, along the direction of probe 1 with the arm at β = 0.
    pub y: Vec<f64>,
}

/// One harmonic of a profile: r(θ) contains `amplitude · cos(k θ + phase)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// Undulations per revolution k.
    pub k: u16,
    /// Amplitude, at least 0, in the unit of the profile; 0 if suppressed.
    pub amplitude: f64,
    /// Phase in rad, −π to π.
    pub phase: f64,
    /// Amplification of the probes' noise in this harmonic.
    pub noise_gain: f64,
    /// Whether the noise gain exceeds the limit; the harmonic is then omitted.
    pub suppressed: bool,
}

/// Where the probes stand.
#[derive(Clone, Debug, PartialEq)]
pub enum Arrangement {
    /// Three probes, by two angles.
    Three(Gain),
    /// Four to six probes; three, too, are separated by least squares here.
    Places(ProbePlaces),
}

impl Arrangement {
    /// Angles of the probes from probe 1, degrees, in the sense of θ.
    pub fn degrees(&self) -> Vec<f64> {
        match self {
            Arrangement::Three(gain) => {
                [0.0, gain.phi2(), gain.phi2() + gain.phi3()].iter().map(|angle| angle.to_degrees()).collect()
            }
            Arrangement::Places(places) => places.degrees(),
        }
    }

    /// Number of probes.
    pub fn probes(&self) -> usize {
        match self {
            Arrangement::Three(_) => 3,
            Arrangement::Places(places) => places.angles().len(),
        }
    }

    /// Noise of one reading that appears in harmonic `k` of the profile, as a factor; infinite if the probes do not see it.
    pub fn noise_gain(&self, k: usize) -> f64 {
        match self {
            Arrangement::Three(gain) => gain.noise_gain(k),
            Arrangement::Places(places) => places.noise_gain(k),
        }
    }

    /// Harmonics of the band that the probes do not see, ascending.
    pub fn blind(&self, band: Band) -> Vec<u16> {
        match self {
            Arrangement::Three(gain) => gain.singular(band).collect(),
            Arrangement::Places(places) => {
                band.iter().filter(|k| places.noise_gain(usize::from(*k)).is_infinite()).collect()
            }
        }
    }
}

/// Separates revolutions of N readings; plans its transforms once.
pub struct Separator {
    arrangement: Arrangement,
    points: usize,
    band: Band,
    /// By harmonic from 0 to the band's last: whether it is in the profile.
    kept: Vec<bool>,
    method: Method,
    /// `[cos β, sin β]` at every θ.
    arm: Vec<[f64; 2]>,
    transforms: Transforms,
}

/// How readings are combined.
enum Method {
    Three(ClosedForm),
    Places(LeastSquares),
}

/// Factors of a plan for three probes.
struct ClosedForm {
    gain: Gain,
    /// By harmonic from 0 to the band's last: factors from an unscaled spectrum to the profile and to the profile at θ + φ2,
    /// 1/(N G) and e^{jkφ2}/(N G); `None` if suppressed.
    multipliers: Vec<Option<[Complex<f64>; 2]>>,
    /// φ2 in whole points, if it is one: then r(θ + φ2) is a rotation of r.
    whole_points: Option<usize>,
}

/// Reusable memory for separating successive revolutions.
pub struct Workspace {
    real: Vec<f64>,
    ahead: Vec<f64>,
    sums: Vec<Complex<f64>>,
    spectrum: Vec<Complex<f64>>,
    amplitudes: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl Separator {
    /// Plans a separation. Harmonics with a noise gain above `noise_gain_limit` ([`NOISE_GAIN_LIMIT`]) are suppressed.
    /// `arm_ratio` is [`trueaxis::roundness::Arm::ratio`], 0 for stationary probes.
    ///
    /// # Errors
    /// All harmonics of the band that the probes do not observe; a band that does not suit the number of points; a limit that
    /// is not above 0; a ratio outside 0 <= λ < 1.
    pub fn new(gain: Gain, band: Band, noise_gain_limit: f64, arm_ratio: f64) -> Result<Self, NoSeparation> {
        let points = gain.points();
        Separator::planned(Arrangement::Three(gain), points, band, noise_gain_limit, arm_ratio, |kept| {
            let scale = 1.0 / points as f64;
            let multipliers = (0..).zip(kept).map(|(k, kept)| {
                let ([re, im], [cos, sin]) = (gain.of(k), gain.phase2(k));
                let here = Complex::new(re, im).inv() * scale;
                kept.then(|| [here, here * Complex::new(cos, sin)])
            });
            let whole_points = gain.slots().map(|[p, _]| p);
            Method::Three(ClosedForm { gain, multipliers: multipliers.collect(), whole_points })
        })
    }

    /// Plans a separation of three to six probes by least squares over all readings, with `points` readings of each in a
    /// revolution; otherwise as [`Separator::new`].
    ///
    /// ```text
    /// C = [cos φ_i, sin φ_i]   Nᵀ C = 0, Nᵀ N = 1   s = Nᵀ h   g_l(k) = Σ_i N_il e^{jkφ_i}
    /// F{r} = Σ_l g_l* F{s_l} / Σ_l |g_l|²           noise gain = 1/√(Σ_l |g_l|²)
    /// ```
    ///
    /// R_X and R_Y are the least squares of the readings without the profile at each θ.
    ///
    /// # Errors
    /// As [`Separator::new`].
    pub fn of_places(
        places: &ProbePlaces,
        points: usize,
        band: Band,
        noise_gain_limit: f64,
        arm_ratio: f64,
    ) -> Result<Self, NoSeparation> {
        let arrangement = Arrangement::Places(places.clone());
        Separator::planned(arrangement, points, band, noise_gain_limit, arm_ratio, |kept| {
            Method::Places(LeastSquares::new(places, points, kept))
        })
    }

    fn planned(
        arrangement: Arrangement,
        points: usize,
        band: Band,
        noise_gain_limit: f64,
        arm_ratio: f64,
        method: impl FnOnce(&[bool]) -> Method,
    ) -> Result<Self, NoSeparation> {
        band.check(points)?;
        if noise_gain_limit.is_nan() || noise_gain_limit <= 0.0 {
            return Err(ConfigError::new(Field::NoiseGain, noise_gain_limit, "a noise gain limit above 0").into());
        }
        if !(0.0..1.0).contains(&arm_ratio) {
            return Err(ConfigError::new(Field::ArmCrank, arm_ratio, "R/(R_S + R_W) from 0 to below 1").into());
        }
        let blind = arrangement.blind(band);
        if !blind.is_empty() {
            return Err(NoSeparation::Blind(blind));
        }
        let kept: Vec<bool> = (0..=band.last)
            .map(|k| band.contains(k) && arrangement.noise_gain(usize::from(k)) <= noise_gain_limit)
            .collect();
        let arm = (0..points)
            .map(|i| {
                let theta = core::f64::consts::TAU * i as f64 / points as f64;
                arm_angle(arm_ratio, [libm::cos(theta), libm::sin(theta)])
            })
            .collect();
        let transforms = Transforms::new(points)?;
        let method = method(&kept);
        Ok(Separator { arrangement, points, band, kept, method, arm, transforms })
    }

    /// Allocates the memory for [`Separator::separate_in`].
    pub fn workspace(&self) -> Workspace {
        let points = self.points;
        let complex = |count: usize| std::vec![Complex::default(); count];
        Workspace {
            real: std::vec![0.0; points],
            ahead: std::vec![0.0; points],
            sums: complex(points / 2 + 1),
            spectrum: complex(points / 2 + 1),
            amplitudes: complex(points / 2 + 1),
            scratch: complex(self.transforms.scratch()),
        }
    }

    /// Returns the arrangement of the probes.
    pub fn arrangement(&self) -> &Arrangement {
        &self.arrangement
    }

    /// Returns the number of points in a revolution N.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Returns the harmonics that the noise gain limit suppresses, ascending.
    pub fn suppressed(&self) -> impl Iterator<Item = u16> + '_ {
        self.band.iter().filter(|k| !self.keeps(*k))
    }

    fn keeps(&self, harmonic: u16) -> bool {
        self.kept.get(usize::from(harmonic)).is_some_and(|kept| *kept)
    }

    /// Separates one revolution of N readings of each probe, equidistant in θ from 0. Three probes take two or three transforms
    /// of real series, m probes m + 1; without noise and with a profile inside the band, it is exact to the rounding of the
    /// readings times the noise gain.
    ///
    /// # Errors
    /// Another number of probes, or a probe does not have N readings.
    pub fn separate(&self, probes: &[&[f64]]) -> Result<Separation, ConfigError> {
        self.separate_in(&mut self.workspace(), probes)
    }

    /// Like [`Separator::separate`], but reuses memory, for many revolutions.
    ///
    /// # Errors
    /// As [`Separator::separate`].
    pub fn separate_in(&self, workspace: &mut Workspace, probes: &[&[f64]]) -> Result<Separation, ConfigError> {
        let wrong_count = || ConfigError::new(Field::ProbeAngles, probes.len() as f64, "readings of every probe");
        if probes.len() != self.arrangement.probes() {
            return Err(wrong_count());
        }
        for (index, probe) in probes.iter().enumerate() {
            self.check(probe).map_err(|error| error.at(index))?;
        }
        match (&self.method, probes) {
            (Method::Places(method), _) => Ok(method.separate(self, workspace, probes)),
            (Method::Three(form), [h1, h2, h3]) => Ok(self.separate_three(workspace, [h1, h2, h3], form)),
            (Method::Three(_), _) => Err(wrong_count()),
        }
    }

    fn separate_three(
        &self,
        workspace: &mut Workspace,
        [h1, h2, h3]: [&[f64]; 3],
        ClosedForm { gain, multipliers, whole_points }: &ClosedForm,
    ) -> Separation {
        let (k2, k3) = (gain.k2(), gain.k3());
        for (sum, ((h1, h2), h3)) in workspace.real.iter_mut().zip(h1.iter().zip(h2).zip(h3)) {
            *sum = h1 + k2 * h2 + k3 * h3;
        }
        self.transform(workspace);
        let mut profile = std::vec![0.0; self.points];
        let factors = |which: usize| multipliers.iter().map(move |of| of.map_or(Complex::default(), |of| of[which]));
        self.synthesis(workspace, &mut profile, factors(0));
        match whole_points {
            Some(points) => {
                let (before, from) = profile.split_at(profile.len().min(*points));
                let (ahead, behind) = workspace.ahead.split_at_mut(from.len());
                ahead.copy_from_slice(from);
                behind.copy_from_slice(before);
            }
            None => {
                let mut ahead = core::mem::take(&mut workspace.ahead);
                self.synthesis(workspace, &mut ahead, factors(1));
                workspace.ahead = ahead;
            }
        }
        // The mean radius relative to the probes' zeros: with an arm it would appear as motion. G(0) is real.
        let [mean_gain, _] = gain.of(0);
        let sees_mean = libm::fabs(mean_gain) > 1e-6 * gain.norm();
        let mean = workspace.spectrum.first().map_or(0.0, |sum| sum.re / self.points as f64);
        let radius = if sees_mean { mean / mean_gain } else { 0.0 };
        let [x, y] = self.motion(gain, [h1, h2], [&profile, &workspace.ahead], radius);
        Separation { profile, x, y }
    }

    /// R_X and R_Y: with t = (h2 − r(θ + φ2) − cos φ2 (h1 − r(θ)))/sin φ2 they are t cos β + (h1 − r) sin β and (h1 − r) cos β
    /// − t sin β.
    fn motion(&self, gain: &Gain, [h1, h2]: [&[f64]; 2], [profile, ahead]: [&[f64]; 2], radius: f64) -> [Vec<f64>; 2] {
        let (per_sin, cot) = (1.0 / libm::sin(gain.phi2()), 1.0 / libm::tan(gain.phi2()));
        let mut motion = [(); 2].map(|()| std::vec![0.0; profile.len()]);
        let [x, y] = &mut motion;
        let readings = h1.iter().zip(h2).zip(profile.iter().zip(ahead));
        for ((x, y), (((h1, h2), (here, ahead)), [cos, sin])) in x.iter_mut().zip(y).zip(readings.zip(&self.arm)) {
            let (one, two) = (h1 - here - radius, h2 - ahead - radius);
            let across = two * per_sin - one * cot;
            *x = cos * across + sin * one;
            *y = cos * one - sin * across;
        }
        motion
    }

    /// Returns the harmonics of a profile over the band, with suppressed ones marked.
    ///
    /// # Errors
    /// The profile does not have N points.
    pub fn harmonics(&self, profile: &[f64]) -> Result<Vec<Harmonic>, ConfigError> {
        let workspace = self.spectrum(profile)?;
        let scale = 2.0 / self.points as f64;
        let harmonics = self.band.iter().map(|k| {
            let suppressed = !self.keeps(k);
            let value = workspace.spectrum.get(usize::from(k)).filter(|_| !suppressed).copied().unwrap_or_default();
            let noise_gain = self.arrangement.noise_gain(usize::from(k));
            Harmonic { k, amplitude: scale * value.norm(), phase: value.arg(), noise_gain, suppressed }
        });
        Ok(harmonics.collect())
    }

    /// Returns the profile after a Gaussian filter (ISO 16610-21) with a cut-off in undulations per revolution, without the
    /// harmonics outside the band.
    ///
    /// # Errors
    /// The profile does not have N points, or the cut-off is not in [`filter::CUT_OFFS`].
    pub fn filtered(&self, profile: &[f64], cut_off: u16) -> Result<Vec<f64>, ConfigError> {
        let mut workspace = self.spectrum(profile)?;
        filter::check(cut_off)?;
        let scale = 1.0 / self.points as f64;
        workspace.amplitudes.fill(Complex::default());
        for k in self.band.iter().map(usize::from) {
            if let (Some(to), Some(from)) = (workspace.amplitudes.get_mut(k), workspace.spectrum.get(k)) {
                *to = from * (scale * filter::transmission(k, cut_off));
            }
        }
        let mut filtered = std::vec![0.0; self.points];
        self.series(&mut workspace, &mut filtered);
        Ok(filtered)
    }

    fn check(&self, values: &[f64]) -> Result<(), ConfigError> {
        if values.len() == self.points {
            return Ok(());
        }
        Err(ConfigError::new(Field::Points, values.len() as f64, "one revolution, N values"))
    }

    /// A workspace with the unscaled spectrum of one revolution: N times the amplitudes of e^{jkθ}.
    fn spectrum(&self, values: &[f64]) -> Result<Workspace, ConfigError> {
        self.check(values)?;
        let mut workspace = self.workspace();
        workspace.real.copy_from_slice(values);
        self.transform(&mut workspace);
        Ok(workspace)
    }

    /// Computes the spectrum of the workspace's real series, which is overwritten.
    fn transform(&self, workspace: &mut Workspace) {
        let Workspace { real, spectrum, scratch, .. } = workspace;
        self.transforms.forward(real, spectrum, scratch);
    }

    /// Computes a real series from the spectrum, multiplied by a factor for each harmonic from 0.
    fn synthesis(&self, workspace: &mut Workspace, series: &mut [f64], factors: impl Iterator<Item = Complex<f64>>) {
        workspace.amplitudes.fill(Complex::default());
        let spectrum = workspace.amplitudes.iter_mut().zip(&workspace.spectrum);
        for ((amplitude, value), factor) in spectrum.zip(factors) {
            *amplitude = value * factor;
        }
        self.series(workspace, series);
    }

    /// Computes a real series from the workspace's amplitudes, which are overwritten.
    fn series(&self, workspace: &mut Workspace, series: &mut [f64]) {
        let Workspace { amplitudes, scratch, .. } = workspace;
        // The Nyquist frequency is zero, because it is outside every band.
        self.transforms.backward(amplitudes, series, scratch);
    }
}

/// Returns a closed profile at equidistant angles after a Gaussian filter (ISO 16610-21) with a cut-off in undulations per
/// revolution: all of its harmonics, with mean and eccentricity.
///
/// # Errors
/// Fewer than three points, or a cut-off that is not in [`filter::CUT_OFFS`].
pub fn filtered(profile: &[f64], cut_off: u16) -> Result<Vec<f64>, ConfigError> {
    filter::check(cut_off)?;
    let points = profile.len();
    if points < 3 {
        return Err(ConfigError::new(Field::Points, points as f64, "at least 3"));
    }
    let transforms = Transforms::new(points)?;
    let (mut series, mut spectrum) = (profile.to_vec(), std::vec![Complex::default(); points / 2 + 1]);
    let mut scratch = std::vec![Complex::default(); transforms.scratch()];
    transforms.forward(&mut series, &mut spectrum, &mut scratch);
    for (k, amplitude) in spectrum.iter_mut().enumerate() {
        *amplitude *= filter::transmission(k, cut_off) / points as f64;
    }
    transforms.backward(&mut spectrum, &mut series, &mut scratch);
    Ok(series)
}

#[cfg(test)]
mod tests;
