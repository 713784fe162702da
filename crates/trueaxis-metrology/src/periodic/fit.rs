//! The fit: bends, harmonics, directions.

use super::design::{Design, Fitted, Side, Wave};
use super::sampling::{Line, Sampling, sampling};
use super::slow::most;
use super::spectrum::{Part, near, spectrum};
use super::{Found, Harmonic, Left, Period, PeriodicRefusal, Reading};
use crate::uncertainty::{chi_squared_quantile, student_factor};
use nalgebra::{DMatrix, DVector};
use std::vec::Vec;

/// Coverage of three standard deviations of a normal distribution.
const THREE_SIGMA: f64 = 0.9973;
/// Factor by which the rest of the error widens a harmonic's standard errors beyond which the points do not separate it.
const LARGEST_INFLATION: f64 = 5.0;
/// A residual below this share of the largest error is rounding.
const ROUNDING: f64 = 1e-13;
/// Chance that noise alone gives a wave of the residual as strong as the one reported.
const BY_CHANCE: f64 = 0.003;

/// Finds the errors of `periods` in a record; `harmonics` of each if stated, otherwise up to six, as many as the points
/// permit.
///
/// Cost: for a scan of a thousand points and two periods, some ten fits of a hundred unknowns: tens of milliseconds.
///
/// # Errors
/// [`PeriodicRefusal`].
pub fn identify(readings: &[Reading], periods: &[f64], harmonics: Option<usize>) -> Result<Found, PeriodicRefusal> {
    let sampled = sampling(readings, periods, harmonics)?;
    let two_sided = [false, true].map(|side| readings.iter().any(|own| own.own.is_negative == side)) == [true; 2];
    let full = bent(readings, &sampled, periods, two_sided)?;
    separated(readings, &full)?;
    let noise = Noise::of(readings, &full, &sampled);
    let kept: Vec<Line> = sampled.lines.iter().copied().filter(|line| noise.exceeds(&full, line)).collect();
    let segments = full.design.slow.segments;
    let apart: Vec<bool> = (0..periods.len()).map(|of| two_sided && noise.differs(&full, &kept, of)).collect();
    let waves = kept.iter().flat_map(|line| waves(*line, apart[line.of]));
    let last = Design::new(readings, segments, waves.collect()).fit(readings);
    let alone = Design::new(readings, segments, Vec::new()).fit(readings);
    Ok(found(readings, periods, (&sampled, &full, &alone), &last))
}

/// Returns the amplitude from which a harmonic is kept that is the same in so many directions of travel, 1 or 2, each of which
/// finds its coefficients with this standard error.
pub fn least_amplitude(standard_error: f64, directions: usize, degrees_of_freedom: usize) -> f64 {
    let directions = directions.max(1) as f64;
    let squares = chi_squared_quantile(THREE_SIGMA, 2.0 * directions) / directions;
    standard_error * squares.sqrt() * Noise::few(degrees_of_freedom.max(1) as f64)
}

/// A harmonic in both directions, together or apart.
fn waves(line: Line, apart: bool) -> impl Iterator<Item = Wave> {
    let sides: &[Side] = if apart { &[Side::Positive, Side::Negative] } else { &[Side::Both] };
    sides.iter().map(move |side| Wave { line, side: *side })
}

/// The fit of all harmonics with the number of segments that the Bayesian information criterion chooses.
fn bent(readings: &[Reading], sampled: &Sampling, periods: &[f64], two_sided: bool) -> Result<Fitted, PeriodicRefusal> {
    let waves = || -> Vec<Wave> { sampled.lines.iter().flat_map(|line| waves(*line, two_sided)).collect() };
    let longest = periods.iter().copied().fold(0.0, f64::max);
    let most = most(readings, longest);
    let largest = readings.iter().map(|own| own.error.abs()).fold(0.0, f64::max);
    let count = readings.len() as f64;
    let mut best: Option<(f64, Fitted)> = None;
    let mut segments = 0;
    while segments <= most {
        let design = Design::new(readings, segments, waves());
        let columns = design.columns();
        if columns + 1 > readings.len() {
            break;
        }
        let fitted = design.fit(readings);
        let squares = (fitted.squares() / count).max((ROUNDING * largest).powi(2)).max(f64::MIN_POSITIVE);
        let criterion = count * squares.ln() + columns as f64 * count.ln();
        if best.as_ref().is_none_or(|(least, _)| criterion < *least) {
            best = Some((criterion, fitted));
        }
        segments = (2 * segments).max(segments + 1);
    }
    let needed = || Design::new(readings, 0, waves()).columns() + 1;
    best.map(|(_, fitted)| fitted).ok_or_else(|| PeriodicRefusal::TooFew { found: readings.len(), needed: needed() })
}

/// Refuses a harmonic that the points do not separate from the rest.
fn separated(readings: &[Reading], full: &Fitted) -> Result<(), PeriodicRefusal> {
    for (k, wave) in full.design.waves.iter().enumerate() {
        let own = readings.iter().filter(|own| wave.side.has(own.own.is_negative));
        let alone = (0.5 * own.map(|own| own.own.share.powi(2)).sum::<f64>()).sqrt();
        let column = full.column(k);
        for column in [column, column + 1] {
            let inflation = full.solution.error_factors[column] * alone;
            if inflation.is_nan() || inflation > LARGEST_INFLATION || full.solution.unseen.contains(&column) {
                let Line { period, number, .. } = wave.line;
                return Err(PeriodicRefusal::Unseparated { period, number });
            }
        }
    }
    Ok(())
}

/// Standard deviations of the residual, for each harmonic of a fit.
struct Noise {
    /// Of white noise.
    white: f64,
    /// Of a harmonic: the larger of white noise and the power near it.
    of: Vec<f64>,
    freedom: f64,
}

impl Noise {
    fn of(readings: &[Reading], fitted: &Fitted, sampled: &Sampling) -> Noise {
        let largest = readings.iter().map(|own| own.error.abs()).fold(0.0, f64::max);
        let white = fitted.solution.sigma().max(ROUNDING * largest);
        let frequencies: Vec<f64> = fitted.design.waves.iter().map(|wave| wave.line.frequency()).collect();
        let of_wave = |wave: &Wave| {
            let own = readings.iter().zip(&fitted.residual).filter(|(own, _)| wave.side.has(own.own.is_negative));
            let part = |(own, value): (&Reading, &f64)| Part {
                position: own.own.position,
                share: own.own.share,
                value: *value,
            };
            let parts: Vec<Part> = own.map(part).collect();
            let power = near(&parts, wave.line.frequency(), sampled.length, &frequencies);
            power.map_or(white, |power| power.sqrt().max(white))
        };
        let of = fitted.design.waves.iter().map(of_wave).collect();
        Noise { white, of, freedom: fitted.solution.degrees_of_freedom().max(1) as f64 }
    }

    /// Factor by which few readings widen a limit, which know their own scatter badly: Student's instead of the normal one.
    fn few(freedom: f64) -> f64 {
        student_factor(THREE_SIGMA, freedom) / student_factor(THREE_SIGMA, f64::INFINITY)
    }

    /// Whether unknowns exceed their scatter: xᵀ C⁻¹ x against the chance of three standard deviations.
    fn is_significant(&self, values: &DVector<f64>, covariance: DMatrix<f64>) -> bool {
        let squares = covariance.cholesky().map_or(0.0, |factor| values.dot(&factor.solve(values)));
        squares > chi_squared_quantile(THREE_SIGMA, values.len() as f64) * Noise::few(self.freedom).powi(2)
    }

    /// Columns of the waves that `which` accepts, with the standard deviation of each.
    fn columns(&self, fitted: &Fitted, which: impl Fn(&Wave) -> bool) -> Vec<(usize, f64)> {
        let own = fitted.design.waves.iter().enumerate().filter(|(_, wave)| which(wave));
        own.flat_map(|(k, _)| [0, 1].map(|part| (fitted.column(k) + part, self.of[k]))).collect()
    }

    /// Whether a harmonic exceeds its scatter, all its directions together.
    fn exceeds(&self, fitted: &Fitted, line: &Line) -> bool {
        let columns = self.columns(fitted, |wave| wave.line == *line);
        let covariance = DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
            columns[i].1 * columns[j].1 * fitted.solution.covariance_factor(columns[i].0, columns[j].0)
        });
        let values = DVector::from_iterator(columns.len(), columns.iter().map(|own| fitted.solution.values[own.0]));
        self.is_significant(&values, covariance)
    }

    /// Whether the kept harmonics of a period differ between the directions.
    fn differs(&self, fitted: &Fitted, kept: &[Line], of: usize) -> bool {
        let own = |side: Side| {
            self.columns(fitted, |wave| wave.side == side && wave.line.of == of && kept.contains(&wave.line))
        };
        let (forward, reverse) = (own(Side::Positive), own(Side::Negative));
        let factor = |a: (usize, f64), b: (usize, f64)| a.1 * b.1 * fitted.solution.covariance_factor(a.0, b.0);
        let covariance = DMatrix::from_fn(forward.len(), forward.len(), |i, j| {
            let ([f, r], [g, s]) = ([forward[i], reverse[i]], [forward[j], reverse[j]]);
            factor(f, g) + factor(r, s) - factor(f, s) - factor(r, g)
        });
        let value = |column: &(usize, f64)| fitted.solution.values[column.0];
        let differences = forward.iter().zip(&reverse).map(|(f, r)| value(f) - value(r));
        let values = DVector::from_iterator(forward.len(), differences);
        !forward.is_empty() && self.is_significant(&values, covariance)
    }
}

fn found(
    readings: &[Reading],
    periods: &[f64],
    (sampled, full, alone): (&Sampling, &Fitted, &Fitted),
    last: &Fitted,
) -> Found {
    let [noise, all] = [last, full].map(|fitted| Noise::of(readings, fitted, sampled));
    let rms = |fitted: &Fitted| (fitted.squares() / readings.len().max(1) as f64).sqrt();
    let (before, left) = (rms(alone), rms(last));
    let period = |(of, period): (usize, &f64)| {
        let apart = last.design.waves.iter().any(|wave| wave.line.of == of && wave.side == Side::Negative);
        let lines: Vec<Line> = sampled.lines.iter().copied().filter(|line| line.of == of).collect();
        let own = |side: Side| {
            let mut own: Vec<Harmonic> = lines
                .iter()
                .map(|line| {
                    let kept = harmonic(last, &noise, line, if apart { side } else { Side::Both });
                    // One that is not kept has the scatter that it was compared with, and no value.
                    let tried = || [side, Side::Both].into_iter().find_map(|side| harmonic(full, &all, line, side));
                    let dropped = || tried().map(|own| Harmonic { value: [0.0; 2], is_kept: false, ..own });
                    kept.or_else(dropped).unwrap_or_default()
                })
                .collect();
            own.sort_by_key(|own| own.number);
            own
        };
        let coincide = sampled.coincide.iter().filter(|(line, _)| line.of == of);
        Period {
            period: *period,
            forward: own(Side::Positive),
            reverse: apart.then(|| own(Side::Negative)),
            coincide: coincide.map(|(line, other)| (line.number, (other.period, other.number))).collect(),
        }
    };
    let widened = noise.of.iter().map(|own| own / noise.white.max(f64::MIN_POSITIVE)).fold(1.0, f64::max);
    Found {
        periods: periods.iter().enumerate().map(period).collect(),
        bends: full.design.slow.segments.saturating_sub(1),
        length: sampled.length,
        spacing: sampled.spacing,
        slow: last.rest.clone(),
        residual: last.residual.clone(),
        before,
        left,
        explained: if before > 0.0 { 1.0 - (left / before).powi(2) } else { 0.0 },
        degrees_of_freedom: last.solution.degrees_of_freedom(),
        widened,
        remains: remains(readings, last, sampled, noise.white),
    }
}

/// A harmonic in one direction; `None` if the fit does not have it.
fn harmonic(fitted: &Fitted, noise: &Noise, line: &Line, side: Side) -> Option<Harmonic> {
    let wave = fitted.design.waves.iter().position(|wave| wave.line == *line && wave.side == side)?;
    let columns = [fitted.column(wave), fitted.column(wave) + 1];
    Some(Harmonic {
        number: line.number,
        value: columns.map(|column| fitted.solution.values[column]),
        standard_error: columns.map(|column| noise.of[wave] * fitted.solution.error_factors[column]),
        is_kept: true,
    })
}

/// The strongest wave of the residual, if it exceeds what noise gives in one of three hundred records. Waves of two of the
/// longest period and more are the slow error's.
fn remains(readings: &[Reading], last: &Fitted, sampled: &Sampling, white: f64) -> Option<Left> {
    let positions: Vec<f64> = readings.iter().map(|own| own.own.position).collect();
    let spectrum = spectrum(&positions, &last.residual, sampled.length, sampled.spacing);
    let longest = sampled.lines.iter().map(|line| line.period).fold(0.0, f64::max);
    let lines = spectrum.frequency.iter().zip(&spectrum.amplitude).filter(|(at, _)| **at * 2.0 * longest > 1.0);
    let (frequency, amplitude) = lines.max_by(|a, b| a.1.total_cmp(b.1))?;
    // A power of white noise is exponential: the largest of N exceeds ln(N/p) times its mean with the chance p.
    let power = amplitude.powi(2) * readings.len() as f64 / 4.0;
    let chance = (spectrum.frequency.len() as f64 / BY_CHANCE).ln();
    (power > chance * white * white).then_some(Left { period: 1.0 / frequency, amplitude: *amplitude })
}
