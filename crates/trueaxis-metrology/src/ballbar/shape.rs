//! Spikes whose shape differs from the fit's: their contribution, and the uncertainty that they add to the other causes.
//!
//! ```text
//! Δr = h (u/w) exp(1 − u/w) + Σ c_j N_j(u),   c_j ~ N(0, (ρ σ e_j)²),   e_j = 1/(1 + (u_j/ℓ)²)
//! ```
//!
//! N_j: linear between knots u_j, after a reversal and, at half the size, before it (friction that rises as the axis slows
//! down). The friction force fades as 1/(1 + (v/v_s)²), and so does e. Every combination of ρ, ℓ and w is weighted with the
//! likelihood of the readings, all c integrated out:
//!
//! ```text
//! ln p = −(ν/2) ln S − ½ ln |AᵀA + Λ| + ½ ln |Λ|,   Λ_jj = 1/(ρ e_j)²
//! ```
//!
//! If the fit's own shape explains the spikes (ρ = 0), the result of the fit does not change. Source: M. C. Kennedy and A.
//! O'Hagan, 10.1111/1467-9868.00294 (a model's discrepancy as a random function).

use nalgebra::{Cholesky, DMatrix, DMatrixView, DVector, Dyn};
use std::f64::consts::PI;
use std::vec::Vec;

const AFTER: usize = 12;
const BEFORE: usize = 6;
/// Columns of one axis.
const OWN: usize = AFTER + BEFORE;
/// Columns of both axes.
pub(super) const HATS: usize = 2 * OWN;
/// First and last knot, rad.
const KNOTS_AFTER: [f64; 2] = [0.004, 0.5];
const KNOTS_BEFORE: [f64; 2] = [0.01, 0.3];
/// Size before a reversal relative to that after it.
const SHARE_BEFORE: f64 = 0.5;
/// Values of ρ tried, besides 0.
const SIZES: [f64; 5] = [1.0, 4.0, 16.0, 64.0, 256.0];
/// Values of ℓ tried, rad.
const REACHES: [f64; 3] = [0.03, 0.08, 0.2];
/// Number of angles at which the maximum of a spike is searched.
const ANGLES: usize = 400;

/// One fit with random columns.
pub(super) struct Shaped {
    /// Values of the fixed columns.
    pub(super) values: DVector<f64>,
    /// The coefficients c.
    pub(super) hats: DVector<f64>,
    /// Logarithm of the likelihood, up to a constant that depends only on the readings.
    pub(super) likelihood: f64,
    pub(super) sigma: f64,
    /// Covariance of the fixed columns, then of the random ones.
    covariance: DMatrix<f64>,
    /// Whether shapes other than the fit's own were allowed.
    pub(super) is_free: bool,
}

impl Shaped {
    /// Covariance of the values.
    pub(super) fn covariance(&self) -> DMatrixView<'_, f64> {
        let fixed = self.values.len();
        self.covariance.view((0, 0), (fixed, fixed))
    }

    /// Largest height of an axis' spike, and its variance. `column` is the index of h.
    pub(super) fn height(&self, axis: usize, column: usize, spike: impl Fn(f64) -> f64) -> [f64; 2] {
        let mut highest = [0.0; 2];
        let fixed = self.values.len();
        for k in 0..ANGLES {
            let since = KNOTS_AFTER[1] * (k as f64 / ANGLES as f64).powi(2);
            let mut parts = Vec::from([(column, spike(since))]);
            if self.is_free {
                own_hats(since, |own, value| parts.push((fixed + axis * OWN + own, value)));
            }
            let coefficient = |place: usize| if place < fixed { self.values[place] } else { self.hats[place - fixed] };
            let value: f64 = parts.iter().map(|(place, part)| part * coefficient(*place)).sum();
            if value.abs() > f64::abs(highest[0]) {
                let variance = parts
                    .iter()
                    .flat_map(|(i, a)| parts.iter().map(move |(j, b)| a * b * self.covariance[(*i, *j)]))
                    .sum();
                highest = [value, variance];
            }
        }
        highest
    }
}

/// Random columns of a reading, from the angles since both axes' reversals, rad, 0 to π.
pub(super) fn hats(since: [f64; 2], mut put: impl FnMut(usize, f64)) {
    for (axis, since) in since.into_iter().enumerate() {
        own_hats(since, |own, value| put(axis * OWN + own, value));
    }
}

fn knot(own: usize) -> f64 {
    let ([first, last], place, count) = match own.checked_sub(AFTER) {
        None => (KNOTS_AFTER, own, AFTER),
        Some(place) => (KNOTS_BEFORE, place, BEFORE),
    };
    first * (last / first).powf(place as f64 / (count - 1) as f64)
}

fn own_hats(since: f64, mut put: impl FnMut(usize, f64)) {
    for (at, from, count) in [(since, 0, AFTER), (PI - since, AFTER, BEFORE)] {
        for own in from..from + count {
            let here = knot(own);
            let ratio = knot(from + 1) / knot(from);
            let [low, high] = [if own == from { f64::NEG_INFINITY } else { here / ratio }, here * ratio];
            let value = if at >= high || at <= low {
                0.0
            } else if at >= here {
                (high - at) / (high - here)
            } else if own == from {
                1.0
            } else {
                (at - low) / (here - low)
            };
            if value != 0.0 {
                put(own, value);
            }
        }
    }
}

/// Fits the fixed columns `matrix` and the random ones `free`, given with their normal matrix, to `right`; the first fit has
/// no random columns.
pub(super) fn fits(
    matrix: &DMatrix<f64>,
    [free, free_normal]: [&DMatrix<f64>; 2],
    right: &DVector<f64>,
) -> Vec<Shaped> {
    let fixed = matrix.ncols();
    let norms: Vec<f64> = matrix.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
    let mut scaled = matrix.clone();
    for (mut column, norm) in scaled.column_iter_mut().zip(&norms) {
        column /= *norm;
    }
    let (own, across) = (scaled.transpose() * &scaled, scaled.transpose() * free);
    let normal =
        DMatrix::from_fn(fixed + HATS, fixed + HATS, |i, j| match (i.checked_sub(fixed), j.checked_sub(fixed)) {
            (None, None) => own[(i, j)],
            (None, Some(j)) => across[(i, j)],
            (Some(i), None) => across[(j, i)],
            (Some(i), Some(j)) => free_normal[(i, j)],
        });
    let (own, random) = (scaled.transpose() * right, free.transpose() * right);
    let product = DVector::from_fn(fixed + HATS, |i, _| if i < fixed { own[i] } else { random[i - fixed] });
    let squares = right.norm_squared();
    let freedom = (matrix.nrows() - fixed) as f64;
    let scale = |column: usize| norms.get(column).copied().unwrap_or(1.0);
    let one = |priors: &[f64]| -> Option<Shaped> {
        let count = fixed + priors.len();
        let mut own = normal.view((0, 0), (count, count)).into_owned();
        for (place, prior) in priors.iter().enumerate() {
            own[(fixed + place, fixed + place)] += prior;
        }
        let right = product.rows(0, count).into_owned();
        let factor = Cholesky::<f64, Dyn>::new(own)?;
        let solved = factor.solve(&right);
        let left = (squares - right.dot(&solved)).max(1e-15 * squares).max(f64::MIN_POSITIVE);
        let variance = left / freedom;
        let inverse = factor.inverse();
        let half_determinant: f64 = factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum();
        let prior: f64 = priors.iter().map(|prior| 0.5 * prior.ln()).sum();
        Some(Shaped {
            values: DVector::from_fn(fixed, |column, _| solved[column] / scale(column)),
            hats: DVector::from_fn(HATS, |place, _| solved.get(fixed + place).copied().unwrap_or(0.0)),
            likelihood: prior - 0.5 * freedom * left.ln() - half_determinant,
            sigma: variance.sqrt(),
            covariance: DMatrix::from_fn(count, count, |i, j| variance * inverse[(i, j)] / (scale(i) * scale(j))),
            is_free: !priors.is_empty(),
        })
    };
    let mut fits: Vec<Shaped> = one(&[]).into_iter().collect();
    for reach in REACHES {
        for size in SIZES {
            let prior = |place: usize| {
                let own = place % OWN;
                let share = if own < AFTER { 1.0 } else { SHARE_BEFORE };
                (size * share / (1.0 + (knot(own) / reach).powi(2))).powi(-2)
            };
            fits.extend(one(&(0..HATS).map(prior).collect::<Vec<f64>>()));
        }
    }
    fits
}
