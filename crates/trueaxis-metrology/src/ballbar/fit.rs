//! The fit of all causes.

use super::figures::{about, figures};
use super::shape::{HATS, Shaped, fits, hats};
use super::{BallbarRefusal, Cause, Evaluation, LEAST, LEAST_ARC_DEG, Reading, Term, WIDEST_GAP_DEG};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use std::f64::consts::{E, FRAC_PI_2, PI, TAU};
use std::vec;
use std::vec::Vec;

/// Range of spike widths tried, rad: half a degree to 15°.
const WIDTHS: [f64; 2] = [8.7e-3, 0.26];
const WIDTHS_TRIED: usize = 24;
/// Narrowest spike width tried, as a share of the distance between readings: the first reading after a reversal then shows at
/// least two fifths of the spike's height.
const FINEST: f64 = 1.0 / 3.0;
/// Spike width used if no spikes are visible, rad. Among the widths tried it is one of the most similar to a scale mismatch
/// and a backlash: the bias that a spike within the noise could cause in them stays within their bands.
const NOT_SEEN: f64 = 0.15;
/// Spikes count as visible above this F of their columns: without spikes, the best of all widths exceeds it in 4 of 100
/// circles (counted).
const SEEN: f64 = 5.0;
/// A spike is significant above this multiple of its standard error.
const SIGNIFICANT: f64 = 4.0;
/// A width below this likelihood relative to the best one is ignored.
const UNLIKELY: f64 = 1e-4;
/// Likelihood share below which the spikes' shape differs from the fit's own.
const ANOTHER_SHAPE: f64 = 0.05;
/// An axis counts as at its reversal within this angle, rad: recorded angles are rounded to it.
const AT_TURN: f64 = 1e-3;
/// Travel, in lost motions, after which the axis is certain to bear on the other side of its play.
const TAKEN_UP: f64 = 1.3;
/// Widest angle after a reversal left out because of play, rad.
const WIDEST_PLAY: f64 = 0.15;
/// Rounds for settling the set of readings left out because of play.
const PLAY_ROUNDS: usize = 3;
/// Factor by which the other terms widen a term's standard error beyond which the record cannot determine it.
const LARGEST_INFLATION: f64 = 50.0;
/// Number of pitches tried for an axis, from the spacing of a few readings to the radius.
const PITCHES_TRIED: usize = 600;
/// A periodic error counts as found if it explains this share of the residual sum of squares; by chance it explains some 0.5 %
/// for a hundred readings.
const PERIODIC_SHARE: f64 = 0.15;
/// Largest shift of a pitch, in periods over a radius, when it is refined together with all causes.
const POLISHED: f64 = 0.05;
/// A periodic error is superfluous if omitting it raises sigma by less than this factor.
const NOTHING_MORE: f64 = 1.05;
/// Rounds for settling the centre: each squares the remaining offset over the radius.
const ROUNDS: usize = 3;

/// Evaluates a circular test of nominal radius `radius_mm`.
///
/// `pitches_mm`: pitch of the periodic error of X and of Y if known; `None` searches it.
///
/// Cost: some ten milliseconds for a thousand readings, a tenth of a second if the spikes have another shape; the exact ring
/// of G takes n log n.
///
/// # Errors
/// [`BallbarRefusal`].
pub fn evaluate(
    radius_mm: f64,
    readings: &[Reading],
    pitches_mm: [Option<f64>; 2],
) -> Result<Evaluation, BallbarRefusal> {
    let whole = check(radius_mm, readings)?;
    let both = [true, false].map(|ccw| readings.iter().any(|reading| reading.counterclockwise == ccw)) == [true; 2];
    let mut centre = [0.0; 2];
    let mut fit =
        Fit { radius: radius_mm, both, width: Some(NOT_SEEN), unresolved: false, pitches: [None; 2], play: [0.0; 2] };
    let mut centred = readings.to_vec();
    for _ in 0..ROUNDS {
        let solved = fit.solve(&fit.clear_of_reversals(&centred)?);
        centre = [centre[0] + solved.of(Cause::Centre(0)), centre[1] + solved.of(Cause::Centre(1))];
        centred = readings.iter().map(|reading| about(radius_mm, centre, reading)).collect();
        fit.play = solved.play();
    }
    let mut clear = fit.clear_of_reversals(&centred)?;
    let mut solved = fit.search(&clear, pitches_mm);
    for _ in 1..PLAY_ROUNDS {
        fit.play = solved.play();
        let anew = fit.clear_of_reversals(&centred)?;
        if anew == clear {
            break;
        }
        clear = anew;
        solved = fit.search(&clear, pitches_mm);
    }
    let (mut terms, covariance) = solved.terms();
    for term in &mut terms {
        if let Cause::Centre(axis) = term.cause {
            term.value += centre[usize::from(axis)];
        }
    }
    Ok(Evaluation {
        spike_width_rad: fit.width.unwrap_or(NOT_SEEN),
        spikes_unresolved: fit.unresolved && terms.iter().any(is_spike),
        spikes_of_another_shape: solved.shape.as_ref().is_some_and(|shape| shape.own < ANOTHER_SHAPE)
            && terms.iter().any(is_spike),
        pitches_mm: fit.pitches,
        sigma_mm: solved.sigma,
        degrees_of_freedom: solved.degrees_of_freedom,
        condition: solved.condition,
        both_directions: both,
        whole_circles: whole,
        left_out: readings.len() - clear.len(),
        figures: figures(radius_mm, readings, whole),
        centred: centred.iter().map(|reading| [reading.deviation_mm, fit.left(&solved, reading)]).collect(),
        terms,
        covariance,
    })
}

fn is_spike(term: &Term) -> bool {
    matches!(term.cause, Cause::Reversal(_)) && term.value.abs() > SIGNIFICANT * term.standard_error
}

/// Whether the circles are whole, not arcs.
fn check(radius: f64, readings: &[Reading]) -> Result<bool, BallbarRefusal> {
    if readings.len() < LEAST {
        return Err(BallbarRefusal::TooFew { found: readings.len() });
    }
    let sound = |r: &Reading| r.angle_rad.is_finite() && r.deviation_mm.abs() < 0.5 * radius;
    if let Some(index) = readings.iter().position(|reading| !sound(reading)) {
        return Err(BallbarRefusal::NotAReading { index });
    }
    let mut whole = true;
    for counterclockwise in [true, false] {
        let own = readings.iter().filter(|reading| reading.counterclockwise == counterclockwise);
        let mut angles: Vec<f64> = own.map(|reading| reading.angle_rad.rem_euclid(TAU)).collect();
        angles.sort_by(f64::total_cmp);
        let Some(first) = angles.first().copied() else { continue };
        let next = angles.iter().skip(1).copied().chain([first + TAU]);
        let gaps = angles.iter().zip(next).map(|(from, to)| (to - from, *from));
        let wide = |(width, _): &(f64, f64)| width.to_degrees() > WIDEST_GAP_DEG;
        let mut wide: Vec<(f64, f64)> = gaps.filter(wide).collect();
        wide.sort_by(|one, other| other.0.total_cmp(&one.0));
        // One gap leaves an arc; a second one, or too short an arc, is refused.
        whole &= wide.is_empty();
        let refused = wide.get(1).or(wide.first().filter(|gap| 360.0 - gap.0.to_degrees() < LEAST_ARC_DEG));
        if let Some((width, from)) = refused {
            let (from_deg, width_deg) = (from.to_degrees(), width.to_degrees());
            return Err(BallbarRefusal::Gap { counterclockwise, from_deg, width_deg });
        }
    }
    Ok(whole)
}

/// Configuration of the fit.
struct Fit {
    radius: f64,
    both: bool,
    /// Width of the spikes; `None` if the fit has no spike columns.
    width: Option<f64>,
    /// The best-fitting width is the narrowest that the spacing of the readings permits.
    unresolved: bool,
    pitches: [Option<f64>; 2],
    /// Lost motion of each axis, as far as it is known, mm.
    play: [f64; 2],
}

/// Contribution of spikes of another shape.
struct Shape {
    best: Shaped,
    /// Height of each axis' spikes, its variance, and the mean square of the deviation that they cause.
    spikes: [[f64; 3]; 2],
    /// Likelihood of the fit's own shape relative to all shapes.
    own: f64,
}

struct Solved {
    columns: Vec<Cause>,
    values: DVector<f64>,
    /// Covariance of the values.
    covariance: DMatrix<f64>,
    /// Root mean square of each column.
    rms: Vec<f64>,
    left: Vec<f64>,
    sigma: f64,
    degrees_of_freedom: usize,
    condition: f64,
    /// Factors by which the other columns widen each standard error.
    inflation: Vec<f64>,
    /// Spike widths tried; empty if no spikes are visible.
    tried: Vec<f64>,
    shape: Option<Shape>,
}

impl Fit {
    /// Angles since the reversals of both axes, 0 to π.
    fn since(&self, reading: &Reading) -> [f64; 2] {
        let d = if reading.counterclockwise { 1.0 } else { -1.0 };
        [0.0, FRAC_PI_2].map(|at| (d * (reading.angle_rad - at)).rem_euclid(PI))
    }

    /// Readings at which every axis has moved away from its reversal by more than its play. Closer to the reversal, rounding
    /// of the angle and partly taken-up play would decide on which side the axis bears.
    fn clear_of_reversals(&self, readings: &[Reading]) -> Result<Vec<Reading>, BallbarRefusal> {
        let is_clear = |reading: &&Reading| {
            self.since(reading).into_iter().zip(self.play).all(|(since, play)| {
                // Travel from the reversal: R (1 − cos u).
                let taken_up = (2.0 * TAKEN_UP * play / self.radius).sqrt().min(WIDEST_PLAY);
                since > taken_up + AT_TURN && since < PI - AT_TURN
            })
        };
        let clear: Vec<Reading> = readings.iter().filter(is_clear).copied().collect();
        if clear.len() < LEAST / 2 { Err(BallbarRefusal::TooFew { found: clear.len() }) } else { Ok(clear) }
    }

    /// Residual of a reading.
    fn left(&self, solved: &Solved, reading: &Reading) -> f64 {
        let values = solved.shape.as_ref().map_or(&solved.values, |shape| &shape.best.values);
        let (mut left, mut column) = (reading.deviation_mm, 0);
        self.row(reading, |_, part| {
            left -= part * values[column];
            column += 1;
        });
        if let Some(shape) = &solved.shape {
            hats(self.since(reading), |place, part| left -= part * shape.best.hats[place]);
        }
        left
    }

    /// Searches the spike width and the pitches, and solves with them.
    fn search(&mut self, readings: &[Reading], pitches: [Option<f64>; 2]) -> Solved {
        self.pitches = pitches;
        let mut solved = self.search_width(readings);
        for axis in [0, 1] {
            if self.pitches[axis].is_none()
                && let Some(pitch) = self.pitch(readings, &solved.left, axis)
            {
                self.pitches[axis] = Some(pitch);
                self.polish(readings, axis, pitch);
                solved = self.search_width(readings);
            }
        }
        let Some(shaped) = self.shaped(readings, &solved) else { return solved };
        if self.pitches == pitches {
            return shaped;
        }
        // The residual of spikes of another shape may look periodic. With that shape in the fit, the period explains nothing
        // more.
        let found = (self.width, self.unresolved, self.pitches);
        self.pitches = pitches;
        let solved = self.search_width(readings);
        if let Some(without) = self.shaped(readings, &solved)
            && without.sigma < NOTHING_MORE * shaped.sigma
        {
            return without;
        }
        (self.width, self.unresolved, self.pitches) = found;
        shaped
    }

    /// Refines a pitch to the least residual of all causes together: the other causes had biased the first estimate.
    fn polish(&mut self, readings: &[Reading], axis: usize, pitch: f64) {
        let (mut low, mut high) = (1.0 / pitch - POLISHED / self.radius, 1.0 / pitch + POLISHED / self.radius);
        for _ in 0..30 {
            let inner = [high - 0.618_034 * (high - low), low + 0.618_034 * (high - low)];
            let [a, b] = inner.map(|per_mm| {
                self.pitches[axis] = Some(1.0 / per_mm);
                self.left_with(readings, self.width)
            });
            if a < b { high = inner[1] } else { low = inner[0] }
        }
        self.pitches[axis] = Some(2.0 / (low + high));
    }

    /// Searches the spike width and solves with it; if no width shows spikes, with [`NOT_SEEN`].
    ///
    /// ```text
    /// F = (S₀ − S)/2 / (S/ν)
    /// ```
    ///
    /// S: residual sum of squares with the best width, ν its degrees of freedom; S₀: without the two spike columns. A search
    /// in noise finds the width that fits the noise best, and the standard errors of that fit are not valid (a parameter
    /// present only under the alternative: Davies, Biometrika 74 (1987)); with one fixed width the fit is linear and its
    /// standard errors are valid.
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
        // Golden section on the logarithm, between the neighbours.
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
        solved.covariance = self.covariance(readings, &solved, widths.collect());
        solved.tried = tried.to_vec();
        solved
    }

    /// The solution with spikes of another shape; `None` if no spikes are visible or their shape needs no such term.
    fn shaped(&mut self, readings: &[Reading], solved: &Solved) -> Option<Solved> {
        if solved.tried.is_empty() {
            return None;
        }
        let mut free = DMatrix::zeros(readings.len(), HATS);
        for (row, reading) in readings.iter().enumerate() {
            hats(self.since(reading), |place, value| free[(row, place)] = value);
        }
        // Spike columns differ from width to width; the other columns start from the solution.
        let mut from = solved.values.clone();
        let spikes = [0, 1].map(|axis| solved.columns.iter().position(|own| *own == Cause::Reversal(axis)));
        let [Some(x), Some(y)] = spikes else { return None };
        (from[x], from[y]) = (0.0, 0.0);
        let found = self.width;
        let free_normal = free.transpose() * &free;
        let fits_of = |fit: &Fit| {
            let (_, matrix, right) = fit.design(readings);
            fits(&matrix, [&free, &free_normal], &(right - &matrix * &from))
        };
        let first = fits_of(self);
        let most = |fits: &[Shaped]| fits.iter().map(|fit| fit.likelihood).fold(f64::NEG_INFINITY, f64::max);
        if most(&first) <= first.first()?.likelihood {
            return None;
        }
        let mut all: Vec<(f64, Shaped)> = first.into_iter().map(|fit| (found.unwrap_or(NOT_SEEN), fit)).collect();
        for &width in solved.tried.iter().step_by(2) {
            self.width = Some(width);
            all.extend(fits_of(self).into_iter().map(|fit| (width, fit)));
        }
        let highest = all.iter().map(|(_, fit)| fit.likelihood).fold(f64::NEG_INFINITY, f64::max);
        let weight = |fit: &Shaped| (fit.likelihood - highest).exp();
        let sum: f64 = all.iter().map(|(_, fit)| weight(fit)).sum();
        let own = all.iter().filter(|(_, fit)| !fit.is_free).map(|(_, fit)| weight(fit)).sum::<f64>() / sum;
        let mean =
            all.iter().fold(DVector::zeros(from.len()), |mean, (_, fit)| mean + &fit.values * (weight(fit) / sum));
        let covariance = all.iter().fold(DMatrix::zeros(from.len(), from.len()), |covariance, (_, fit)| {
            let apart = &fit.values - &mean;
            covariance + (fit.covariance() + &apart * apart.transpose()) * (weight(fit) / sum)
        });
        let (width, mut best) = all.into_iter().max_by(|(_, a), (_, b)| a.likelihood.total_cmp(&b.likelihood))?;
        self.width = Some(width);
        let spike = |since: f64| since / width * E * (-since / width).exp();
        let mut spikes = [x, y].map(|column| (column, [0.0; 3]));
        for (axis, (column, height)) in spikes.iter_mut().enumerate() {
            let [value, variance] = best.height(axis, *column, spike);
            let made = readings.iter().map(|reading| {
                let since = self.since(reading);
                let mut made = best.values[*column] * spike(since[axis]);
                // The other axis contributes nothing: half a turn from a reversal lies outside all of its columns.
                let mut alone = [0.5 * PI; 2];
                alone[axis] = since[axis];
                hats(alone, |place, part| {
                    made += if place / (HATS / 2) == axis { part * best.hats[place] } else { 0.0 }
                });
                made * made
            });
            *height = [value, variance, made.sum::<f64>() / readings.len() as f64];
        }
        best.values += &from;
        let refitted = self.solve(readings);
        let mut shaped = Solved { values: mean + from, covariance, sigma: best.sigma, ..refitted };
        shaped.shape = Some(Shape { best, spikes: spikes.map(|(_, height)| height), own });
        shaped.left = readings.iter().map(|reading| self.left(&shaped, reading)).collect();
        Some(shaped)
    }

    /// Residual sum of squares for a spike width.
    fn left_with(&mut self, readings: &[Reading], width: Option<f64>) -> f64 {
        self.width = width;
        sum_of_squares(&self.solve(readings).left)
    }

    /// Covariance of the values of `best` when the spike width is searched, not known: over all widths, each weighted with the
    /// likelihood of its residual, uniform in the logarithm.
    ///
    /// ```text
    /// U = Σ p_w [U_w + (x_w − x)(x_w − x)ᵀ],   p_w ∝ S_w^(−ν/2)
    /// ```
    ///
    /// U_w: covariance and S_w: residual sum of squares with width w, ν: degrees of freedom. If spikes are high, p is 1 at their
    /// width. Source: JCGM 101:2008, 6 (propagation of distributions), for the nuisance parameter w.
    fn covariance(&mut self, readings: &[Reading], best: &Solved, widths: Vec<f64>) -> DMatrix<f64> {
        let least = sum_of_squares(&best.left).max(f64::MIN_POSITIVE);
        let found = self.width;
        let (mut weights, mut sum) = (1.0, best.covariance.clone());
        for width in widths {
            self.width = Some(width);
            let one = self.solve(readings);
            let weight = likelihood(sum_of_squares(&one.left) / least, best.degrees_of_freedom);
            weights += weight;
            let apart = &one.values - &best.values;
            sum += (one.covariance + &apart * apart.transpose()) * weight;
        }
        self.width = found;
        sum / weights
    }

    /// The pitch that explains most of the residual, if it explains more than chance.
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
        // Equal steps in the number of periods, the quantity that the fit resolves.
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

    /// Effect of one unit of each cause on a reading.
    fn row(&self, reading: &Reading, mut put: impl FnMut(Cause, f64)) {
        let (sin, cos) = reading.angle_rad.sin_cos();
        let (sin_2, cos_2) = (2.0 * sin * cos, cos * cos - sin * sin);
        let d = if reading.counterclockwise { 1.0 } else { -1.0 };
        put(Cause::Radius, 1.0);
        put(Cause::Centre(0), cos);
        put(Cause::Centre(1), sin);
        put(Cause::ScaleMismatch, 0.5 * self.radius * cos_2);
        put(Cause::Squareness, -0.5 * self.radius * sin_2);
        for (axis, at, along) in [(0_u8, 0.0, cos), (1, FRAC_PI_2, sin)] {
            let turned = (d * (reading.angle_rad - at)).rem_euclid(TAU);
            let way = if turned < PI { -1.0 } else { 1.0 };
            // From the side before the reversal to the other, while the axis takes up its play.
            let taken_up = 2.0 * self.radius * (1.0 - turned.rem_euclid(PI).cos()) / self.play[usize::from(axis)];
            let side = if taken_up < 2.0 { way * (taken_up - 1.0) } else { way };
            put(Cause::Backlash(axis), -0.5 * side * along);
        }
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

    /// Causes, the effect of one unit of each on every reading, and the readings.
    fn design(&self, readings: &[Reading]) -> (Vec<Cause>, DMatrix<f64>, DVector<f64>) {
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
        (columns, matrix, right)
    }

    fn solve(&self, readings: &[Reading]) -> Solved {
        let (columns, matrix, right) = self.design(readings);
        let count = columns.len();
        let scale: Vec<f64> = matrix.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
        let mut scaled = matrix.clone();
        for (mut column, scale) in scaled.column_iter_mut().zip(&scale) {
            column /= *scale;
        }
        let normal = scaled.transpose() * &scaled;
        let eigenvalues = normal.symmetric_eigenvalues();
        let condition = (eigenvalues.max() / eigenvalues.min().max(f64::MIN_POSITIVE)).sqrt();
        // Positive definite to rounding: the columns are independent if the circles are closed or the arcs long enough.
        let inverse = match Cholesky::<f64, Dyn>::new(normal) {
            Some(factor) => factor.inverse(),
            None => DMatrix::zeros(count, count),
        };
        let inflation = inverse.diagonal().iter().map(|own| own.max(0.0).sqrt()).collect();
        let inverse = DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] / (scale[i] * scale[j]));
        let values = &inverse * (matrix.transpose() * &right);
        let left = &right - &matrix * &values;
        let degrees_of_freedom = readings.len() - count;
        let root = (readings.len() as f64).sqrt();
        let sigma = (left.norm_squared() / degrees_of_freedom as f64).sqrt();
        Solved {
            columns,
            covariance: inverse * (sigma * sigma),
            values,
            rms: scale.iter().map(|scale| scale / root).collect(),
            sigma,
            left: left.iter().copied().collect(),
            degrees_of_freedom,
            condition,
            inflation,
            tried: Vec::new(),
            shape: None,
        }
    }
}

impl Solved {
    fn of(&self, cause: Cause) -> f64 {
        self.columns.iter().position(|own| *own == cause).map_or(0.0, |column| self.values[column])
    }

    /// Lost motion of both axes plus one standard error.
    fn play(&self) -> [f64; 2] {
        [0, 1].map(|axis| {
            let column = self.columns.iter().position(|own| *own == Cause::Backlash(axis));
            column.map_or(0.0, |column| self.values[column].abs() + self.covariance[(column, column)].max(0.0).sqrt())
        })
    }

    /// Terms, and their covariance: each is a sum of columns, apart from the height of spikes of another shape, whose row and
    /// column are zero.
    fn terms(&self) -> (Vec<Term>, Vec<Vec<f64>>) {
        let mut terms: Vec<Term> = vec![];
        let mut shares: Vec<Vec<(usize, f64)>> = vec![];
        for (column, &cause) in self.columns.iter().enumerate() {
            if self.inflation[column] > LARGEST_INFLATION && !matches!(cause, Cause::Radius | Cause::Centre(_)) {
                continue;
            }
            let value = self.values[column];
            let rms_mm = value.abs() * self.rms[column];
            if let (Cause::Reversal(axis), Some(shape)) = (cause, &self.shape) {
                let [value, variance, mean_square] = shape.spikes[usize::from(axis != 0)];
                terms.push(Term { cause, value, standard_error: variance.sqrt(), rms_mm: mean_square.sqrt() });
                shares.push(vec![]);
                continue;
            }
            match (cause, terms.last_mut(), shares.last_mut()) {
                // The sine part follows the cosine part of one periodic error: combine them into its amplitude.
                (Cause::Cyclic(_), Some(before), Some(shares)) if before.cause == cause => {
                    let amplitude = before.value.hypot(value);
                    let along = [before.value, value].map(|part| part / amplitude.max(f64::MIN_POSITIVE));
                    shares.iter_mut().for_each(|(_, share)| *share = along[0]);
                    shares.push((column, along[1]));
                    before.rms_mm = before.rms_mm.hypot(rms_mm);
                    before.value = amplitude;
                }
                _ => {
                    terms.push(Term { cause, value, standard_error: 0.0, rms_mm });
                    shares.push(vec![(column, 1.0)]);
                }
            }
        }
        let entry = |one: &[(usize, f64)], other: &[(usize, f64)]| {
            let products =
                one.iter().flat_map(|(i, a)| other.iter().map(move |(j, b)| a * b * self.covariance[(*i, *j)]));
            products.sum::<f64>()
        };
        for (term, shares) in terms.iter_mut().zip(&shares).filter(|(_, shares)| !shares.is_empty()) {
            term.standard_error = entry(shares, shares).sqrt();
        }
        let covariance = shares.iter().map(|one| shares.iter().map(|other| entry(one, other)).collect()).collect();
        (terms, covariance)
    }
}

/// Likelihood of a fit relative to the best one; `share`: its sum of squares over that of the best.
fn likelihood(share: f64, degrees_of_freedom: usize) -> f64 {
    (-0.5 * degrees_of_freedom as f64 * share.ln()).exp().min(1.0)
}

fn sum_of_squares(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}
