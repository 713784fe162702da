//! The fit of all causes.

use super::figures::figures;
use super::{Cause, Evaluation, LEAST, Reading, Refused, Term, WIDEST_GAP_DEG};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use std::f64::consts::{E, FRAC_PI_2, PI, TAU};
use std::vec;
use std::vec::Vec;

/// Widths of spikes that are tried, rad: half a degree to 15°.
const WIDTHS: [f64; 2] = [8.7e-3, 0.26];
const WIDTHS_TRIED: usize = 24;
/// Width of the narrowest spike that is tried, as a share of the distance between readings: of its height the first reading after
/// a reversal shows two fifths or more.
const FINEST: f64 = 1.0 / 3.0;
/// Width of the spikes where none are to be seen, rad. Among the widths that are tried it is one of the most alike to a scale
/// mismatch and a backlash: what a spike within the noise could make of them stays within their bands.
const NOT_SEEN: f64 = 0.15;
/// Spikes are seen from this F of their columns on: without any, the best of all widths exceeds it in 4 of 100 circles (counted).
const SEEN: f64 = 5.0;
/// A spike is one from this many of its standard errors.
const SIGNIFICANT: f64 = 4.0;
/// A width of this likelihood against the best one is none.
const UNLIKELY: f64 = 1e-4;
/// Pitches that are tried for an axis, from some readings to the radius.
const PITCHES_TRIED: usize = 600;
/// A periodic error is one when it takes this share of what all others leave; chance takes some 0.5 % of a hundred readings.
const PERIODIC_SHARE: f64 = 0.15;
/// Rounds in which the centre settles: each squares what is left of its offset over the radius.
const ROUNDS: usize = 3;

/// Evaluates a circular test of nominal radius `radius_mm`.
///
/// `pitches_mm`: pitch of the periodic error of X, of Y, where it is known; else it is searched.
///
/// Cost: some milliseconds for a thousand readings; the exact ring of G in n log n.
///
/// # Errors
/// [`Refused`].
pub fn evaluate(radius_mm: f64, readings: &[Reading], pitches_mm: [Option<f64>; 2]) -> Result<Evaluation, Refused> {
    check(radius_mm, readings)?;
    let both = [true, false].map(|ccw| readings.iter().any(|reading| reading.counterclockwise == ccw)) == [true; 2];
    let mut centre = [0.0; 2];
    let mut fit = Fit { radius: radius_mm, both, width: Some(WIDTHS[0]), unresolved: false, pitches: [None; 2] };
    let mut centred = readings.to_vec();
    for _ in 0..ROUNDS {
        let solved = fit.solve(&centred);
        centre = [centre[0] + solved.of(Cause::Centre(0)), centre[1] + solved.of(Cause::Centre(1))];
        centred = readings.iter().map(|reading| about(radius_mm, centre, reading)).collect();
    }
    let solved = fit.search(&centred, pitches_mm);
    let mut terms = solved.terms();
    for term in &mut terms {
        if let Cause::Centre(axis) = term.cause {
            term.value += centre[usize::from(axis)];
        }
    }
    Ok(Evaluation {
        spike_width_rad: fit.width.unwrap_or(NOT_SEEN),
        spikes_unresolved: fit.unresolved && terms.iter().any(is_spike),
        pitches_mm: fit.pitches,
        sigma_mm: solved.sigma,
        degrees_of_freedom: solved.degrees_of_freedom,
        condition: solved.condition,
        both_directions: both,
        figures: figures(radius_mm, &centred),
        centred: centred.iter().zip(&solved.left).map(|(reading, left)| [reading.deviation_mm, *left]).collect(),
        terms,
    })
}

fn is_spike(term: &Term) -> bool {
    matches!(term.cause, Cause::Reversal(_)) && term.value.abs() > SIGNIFICANT * term.standard_error
}

fn check(radius: f64, readings: &[Reading]) -> Result<(), Refused> {
    if readings.len() < LEAST {
        return Err(Refused::TooFew { found: readings.len() });
    }
    let sound = |r: &Reading| r.angle_rad.is_finite() && r.deviation_mm.abs() < 0.5 * radius;
    if let Some(index) = readings.iter().position(|reading| !sound(reading)) {
        return Err(Refused::NotAReading { index });
    }
    for counterclockwise in [true, false] {
        let own = readings.iter().filter(|reading| reading.counterclockwise == counterclockwise);
        let mut angles: Vec<f64> = own.map(|reading| reading.angle_rad.rem_euclid(TAU)).collect();
        angles.sort_by(f64::total_cmp);
        let Some(first) = angles.first().copied() else { continue };
        let next = angles.iter().skip(1).copied().chain([first + TAU]);
        let gaps = angles.iter().zip(next).map(|(from, to)| (to - from, *from));
        let (width, from) = gaps.fold((0.0, 0.0), |widest, gap| if gap.0 > widest.0 { gap } else { widest });
        if width.to_degrees() > WIDEST_GAP_DEG {
            let (from_deg, width_deg) = (from.to_degrees(), width.to_degrees());
            return Err(Refused::Gap { counterclockwise, from_deg, width_deg });
        }
    }
    Ok(())
}

/// The reading of a bar in the circle's centre: of |c + (R + Δ) (cos θ, sin θ)| the part along the command's radius.
fn about(radius: f64, [x, y]: [f64; 2], reading: &Reading) -> Reading {
    let (sin, cos) = reading.angle_rad.sin_cos();
    let (along, across) = (x * cos + y * sin, y * cos - x * sin);
    let r = radius + reading.deviation_mm;
    Reading { deviation_mm: (r * r - across * across).max(0.0).sqrt() - along - radius, ..*reading }
}

/// What is fitted.
struct Fit {
    radius: f64,
    both: bool,
    /// Of the spikes; none where no column is theirs.
    width: Option<f64>,
    /// The width that fits best is the narrowest that the readings let be tried.
    unresolved: bool,
    pitches: [Option<f64>; 2],
}

struct Solved {
    columns: Vec<Cause>,
    values: DVector<f64>,
    /// Variance of every value.
    variances: Vec<f64>,
    /// Root mean square of every column.
    rms: Vec<f64>,
    left: Vec<f64>,
    sigma: f64,
    degrees_of_freedom: usize,
    condition: f64,
}

impl Fit {
    /// Finds the spikes' width and the pitches, and solves with them.
    fn search(&mut self, readings: &[Reading], pitches: [Option<f64>; 2]) -> Solved {
        self.pitches = pitches;
        let mut solved = self.search_width(readings);
        for axis in [0, 1] {
            if self.pitches[axis].is_none()
                && let Some(pitch) = self.pitch(readings, &solved.left, axis)
            {
                self.pitches[axis] = Some(pitch);
                solved = self.search_width(readings);
            }
        }
        solved
    }

    /// Finds the spikes' width and solves with it; where no width shows spikes, with [`NOT_SEEN`].
    ///
    /// ```text
    /// F = (S₀ − S)/2 / (S/ν)
    /// ```
    ///
    /// S: sum of squares that the best width leaves, ν its degrees of freedom; S₀: without the two columns of the spikes. A width
    /// searched in noise is the one that fits the noise best, and no fit with it says how well the others are known (a parameter
    /// that is there only under the alternative: Davies, Biometrika 74 (1987)); with one width the fit is linear, and does.
    fn search_width(&mut self, readings: &[Reading]) -> Solved {
        let finest = FINEST * TAU * if self.both { 2.0 } else { 1.0 } / readings.len() as f64;
        let [narrow, wide] = [WIDTHS[0].max(finest), WIDTHS[1].max(2.0 * finest)];
        let mut best = f64::INFINITY;
        let tried: [f64; WIDTHS_TRIED] =
            std::array::from_fn(|k| narrow * (wide / narrow).powf(k as f64 / (WIDTHS_TRIED - 1) as f64));
        let mut found = narrow;
        let lefts = tried.map(|width| self.left_with(readings, Some(width)));
        for (width, left) in tried.into_iter().zip(lefts) {
            if left < best {
                (best, found) = (left, width);
            }
        }
        // Between its neighbours: golden section on the logarithm.
        let step = (wide / narrow).powf(1.0 / (WIDTHS_TRIED - 1) as f64);
        let (mut low, mut high) = (found / step, found * step);
        for _ in 0..20 {
            let inner = [high / (high / low).powf(0.618_034), low * (high / low).powf(0.618_034)];
            let [a, b] = inner.map(|width| self.left_with(readings, Some(width)));
            if a < b { high = inner[1] } else { low = inner[0] }
        }
        let without = self.left_with(readings, None);
        self.width = Some((low * high).sqrt());
        let mut solved = self.solve(readings);
        let left = sum_of_squares(&solved.left);
        if (without - left) / 2.0 <= SEEN * left / solved.degrees_of_freedom as f64 {
            (self.width, self.unresolved) = (Some(NOT_SEEN), false);
            return self.solve(readings);
        }
        self.unresolved = found == narrow && narrow > WIDTHS[0];
        let likely = |left: f64| likelihood(left / best.max(f64::MIN_POSITIVE), solved.degrees_of_freedom) > UNLIKELY;
        let widths = tried.into_iter().zip(lefts).filter(|(_, left)| likely(*left)).map(|(width, _)| width);
        solved.variances = self.variances(readings, &solved, widths.collect());
        solved
    }

    /// Sum of squares that is left with a width of the spikes.
    fn left_with(&mut self, readings: &[Reading], width: Option<f64>) -> f64 {
        self.width = width;
        sum_of_squares(&self.solve(readings).left)
    }

    /// Variances of the values of `best` where the spikes' width is not known but searched: over all widths, each with the
    /// likelihood of what it leaves, even on the logarithm.
    ///
    /// ```text
    /// u² = Σ p_w [s_w² + (x_w − x)²],   p_w ∝ S_w^(−ν/2)
    /// ```
    ///
    /// S_w: sum of squares that the width leaves, ν: degrees of freedom. Where spikes are high, p is 1 at their width. Source: JCGM
    /// 101:2008, 6 (propagation of distributions), for the nuisance w.
    fn variances(&mut self, readings: &[Reading], best: &Solved, widths: Vec<f64>) -> Vec<f64> {
        let least = sum_of_squares(&best.left).max(f64::MIN_POSITIVE);
        let found = self.width;
        let (mut weights, mut sums) = (1.0, best.variances.clone());
        for width in widths {
            self.width = Some(width);
            let one = self.solve(readings);
            let weight = likelihood(sum_of_squares(&one.left) / least, best.degrees_of_freedom);
            weights += weight;
            for (column, sum) in sums.iter_mut().enumerate() {
                *sum += weight * (one.variances[column] + (one.values[column] - best.values[column]).powi(2));
            }
        }
        self.width = found;
        sums.into_iter().map(|sum| sum / weights).collect()
    }

    /// The pitch that takes most of what is left, where that is more than chance.
    fn pitch(&self, readings: &[Reading], left: &[f64], axis: usize) -> Option<f64> {
        let shortest = 8.0 * PI * self.radius * if self.both { 2.0 } else { 1.0 } / readings.len() as f64;
        let total = sum_of_squares(left);
        let taken = |pitch: f64| {
            let (mut normal, mut right) = ([0.0; 3], [0.0; 2]);
            for (reading, left) in readings.iter().zip(left) {
                let [a, b] = self.cyclic(reading, axis, pitch);
                normal = [normal[0] + a * a, normal[1] + a * b, normal[2] + b * b];
                right = [right[0] + a * left, right[1] + b * left];
            }
            let determinant = (normal[0] * normal[2] - normal[1] * normal[1]).max(f64::MIN_POSITIVE);
            let a = (normal[2] * right[0] - normal[1] * right[1]) / determinant;
            let b = (normal[0] * right[1] - normal[1] * right[0]) / determinant;
            a * right[0] + b * right[1]
        };
        if shortest >= self.radius || total <= 0.0 {
            return None;
        }
        // Even in the number of periods, which is what the fit resolves.
        let [few, many] = [1.0 / self.radius, 1.0 / shortest];
        let step = (many - few) / PITCHES_TRIED as f64;
        let tried = (0..=PITCHES_TRIED).map(|k| few + step * k as f64);
        let (share, per_mm) = tried
            .map(|per_mm| (taken(1.0 / per_mm) / total, per_mm))
            .fold((0.0, few), |best, one| if one.0 > best.0 { one } else { best });
        if share < PERIODIC_SHARE {
            return None;
        }
        let (mut low, mut high) = (per_mm - step, per_mm + step);
        for _ in 0..40 {
            let third = (high - low) / 3.0;
            if taken(1.0 / (low + third)) > taken(1.0 / (high - third)) { high -= third } else { low += third }
        }
        Some(2.0 / (low + high))
    }

    fn cyclic(&self, reading: &Reading, axis: usize, pitch: f64) -> [f64; 2] {
        let (sin, cos) = reading.angle_rad.sin_cos();
        let along = if axis == 0 { cos } else { sin };
        let (s, c) = (TAU * self.radius * along / pitch).sin_cos();
        [along * c, along * s]
    }

    /// What one unit of every cause makes of a reading.
    fn row(&self, reading: &Reading, mut put: impl FnMut(Cause, f64)) {
        let (sin, cos) = reading.angle_rad.sin_cos();
        let (sin_2, cos_2) = (2.0 * sin * cos, cos * cos - sin * sin);
        let d = if reading.counterclockwise { 1.0 } else { -1.0 };
        put(Cause::Radius, 1.0);
        put(Cause::Centre(0), cos);
        put(Cause::Centre(1), sin);
        put(Cause::ScaleMismatch, 0.5 * self.radius * cos_2);
        put(Cause::Squareness, -0.5 * self.radius * sin_2);
        put(Cause::Backlash(0), 0.5 * d * sin.signum() * cos);
        put(Cause::Backlash(1), -0.5 * d * cos.signum() * sin);
        put(Cause::Straightness(0), cos * cos * sin);
        put(Cause::Straightness(1), sin * sin * cos);
        for (axis, at) in [(0, 0.0), (1, FRAC_PI_2)] {
            let Some(width) = self.width else { break };
            let since = (d * (reading.angle_rad - at)).rem_euclid(PI) / width;
            put(Cause::Reversal(axis), since * E * (-since).exp());
        }
        if self.both {
            put(Cause::ServoMismatch, 0.5 * d * sin_2);
            put(Cause::LateralPlay(0), 0.5 * d * sin.abs());
            put(Cause::LateralPlay(1), -0.5 * d * cos.abs());
        }
        for axis in [0_u8, 1] {
            if let Some(pitch) = self.pitches[usize::from(axis)] {
                self.cyclic(reading, axis.into(), pitch).into_iter().for_each(|value| put(Cause::Cyclic(axis), value));
            }
        }
    }

    fn solve(&self, readings: &[Reading]) -> Solved {
        let mut columns = Vec::new();
        if let Some(first) = readings.first() {
            self.row(first, |cause, _| columns.push(cause));
        }
        let count = columns.len();
        let mut matrix = Vec::with_capacity(count * readings.len());
        for reading in readings {
            self.row(reading, |_, value| matrix.push(value));
        }
        let matrix = DMatrix::from_row_slice(readings.len(), count, &matrix);
        let right = DVector::from_iterator(readings.len(), readings.iter().map(|reading| reading.deviation_mm));
        let scale: Vec<f64> = matrix.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
        let mut scaled = matrix.clone();
        for (mut column, scale) in scaled.column_iter_mut().zip(&scale) {
            column /= *scale;
        }
        let normal = scaled.transpose() * &scaled;
        let eigenvalues = normal.symmetric_eigenvalues();
        let condition = (eigenvalues.max() / eigenvalues.min().max(f64::MIN_POSITIVE)).sqrt();
        // Positive definite to rounding: the columns differ wherever circles are closed.
        let inverse = match Cholesky::<f64, Dyn>::new(normal) {
            Some(factor) => factor.inverse(),
            None => DMatrix::zeros(count, count),
        };
        let inverse = DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] / (scale[i] * scale[j]));
        let values = &inverse * (matrix.transpose() * &right);
        let left = &right - &matrix * &values;
        let degrees_of_freedom = readings.len() - count;
        let root = (readings.len() as f64).sqrt();
        let sigma = (left.norm_squared() / degrees_of_freedom as f64).sqrt();
        Solved {
            columns,
            variances: inverse.diagonal().iter().map(|own| sigma * sigma * own).collect(),
            values,
            rms: scale.iter().map(|scale| scale / root).collect(),
            sigma,
            left: left.iter().copied().collect(),
            degrees_of_freedom,
            condition,
        }
    }
}

impl Solved {
    fn of(&self, cause: Cause) -> f64 {
        self.columns.iter().position(|own| *own == cause).map_or(0.0, |column| self.values[column])
    }

    fn terms(&self) -> Vec<Term> {
        let mut terms: Vec<Term> = vec![];
        for (column, &cause) in self.columns.iter().enumerate() {
            let (value, variance) = (self.values[column], self.variances[column]);
            let rms_mm = value.abs() * self.rms[column];
            match (cause, terms.last_mut()) {
                // Sine after cosine of one periodic error: its amplitude.
                (Cause::Cyclic(_), Some(before)) if before.cause == cause => {
                    let amplitude = before.value.hypot(value);
                    let along = [before.value, value].map(|part| part / amplitude.max(f64::MIN_POSITIVE));
                    let spread = before.standard_error.powi(2) * along[0] * along[0] + variance * along[1] * along[1];
                    before.rms_mm = before.rms_mm.hypot(rms_mm);
                    (before.value, before.standard_error) = (amplitude, spread.sqrt());
                }
                _ => terms.push(Term { cause, value, standard_error: variance.sqrt(), rms_mm }),
            }
        }
        terms
    }
}

/// Likelihood of a fit that leaves `share` times the squares of the best one, against it.
fn likelihood(share: f64, degrees_of_freedom: usize) -> f64 {
    (-0.5 * degrees_of_freedom as f64 * share.ln()).exp().min(1.0)
}

fn sum_of_squares(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}
