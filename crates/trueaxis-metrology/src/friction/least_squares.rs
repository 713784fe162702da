//! Nonlinear least squares after Levenberg and Marquardt, with covariance and condition number.
//!
//! ```text
//! (JᵀJ + λ diag JᵀJ) δ = −Jᵀr
//! cov = H⁻¹ (Σ_c g_c g_cᵀ) H⁻¹ · C/(C − p),   H = JᵀJ,   g_c = Σ_{i in c} r_i J_i
//! ```
//!
//! Residuals of neighbouring samples are correlated (subdivisional error of the encoder, ripple of the drive): the covariance
//! treats one stretch around a reversal as one observation. C is the number of stretches, p that of parameters. Standard errors
//! are at least those of independent samples; the covariance has them, with the correlations of the formula.
//!
//! Source: K. Madsen, H. B. Nielsen, O. Tingleff, Methods for Non-Linear Least Squares Problems, 2004, section 3.2; H. White,
//! 10.2307/1912934, for the covariance.

use super::parameters::{COUNT, Problem, Values};
use crate::cores::*;
use nalgebra::{DMatrix, DVector};
use std::vec::Vec;

/// Most steps before a fit counts as not converged.
pub(super) const STEPS: usize = 60;
/// Condition number of the scaled columns beyond which a combination counts as not excited.
const CONDITION_LIMIT: f64 = 1e5;

/// A converged fit.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub(super) values: Values,
    /// Standard errors in the parameters' units; 0 for fixed parameters.
    pub(super) errors: [f64; COUNT],
    /// Like `errors`, including the uncertainty of the times within a cycle.
    pub(super) uncertainties: [f64; COUNT],
    /// Covariance with `uncertainties` on its diagonal; 0 for fixed parameters.
    pub(super) covariance: [[f64; COUNT]; COUNT],
    /// Root mean square of the residuals, mm.
    pub(super) rms: f64,
    pub(super) rank: usize,
    pub(super) condition: f64,
}

struct Linear {
    columns: Vec<Vec<f64>>,
    normal: DMatrix<f64>,
    gradient: DVector<f64>,
}

/// Fits the parameters `free`; calls `on_step` before every step. `None` if the fit does not converge.
pub(super) fn fit(problem: &Problem, start: Values, free: &[usize], on_step: &mut dyn FnMut()) -> Option<Fit> {
    let mut values = start;
    let mut residuals = problem.residuals(&values);
    let mut cost = squares(&residuals);
    let mut damping = 1e-2;
    for _ in 0..STEPS {
        on_step();
        let linear = linearised(problem, &values, &residuals, free);
        let mut gain = None;
        while gain.is_none() && damping < 1e9 {
            let step = damped(&linear, damping)?;
            let next = free.iter().zip(step.iter()).fold(values, |at, (&p, &by)| at.moved(p, by));
            let tried = problem.residuals(&next);
            let found = squares(&tried);
            if found.is_finite() && found <= cost {
                gain = Some(cost - found);
                (values, residuals, cost) = (next, tried, found);
                damping = (0.2 * damping).max(1e-9);
            } else {
                damping *= 6.0;
            }
        }
        // No step reduces the cost, or only negligibly.
        if gain.is_none_or(|gain| gain <= 1e-6 * cost) {
            let linear = linearised(problem, &values, &residuals, free);
            return Some(judged(problem, values, &residuals, cost, free, &linear));
        }
    }
    None
}

fn squares(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r).sum()
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

fn linearised(problem: &Problem, values: &Values, residuals: &[f64], free: &[usize]) -> Linear {
    let derivative = |&parameter: &usize| problem.derivative(values, residuals, parameter);
    let columns: Vec<Vec<f64>> = free.par_iter().map(derivative).collect();
    let mut normal = DMatrix::zeros(free.len(), free.len());
    for i in 0..free.len() {
        for j in 0..=i {
            normal[(i, j)] = dot(&columns[i], &columns[j]);
            normal[(j, i)] = normal[(i, j)];
        }
    }
    let gradient = DVector::from_iterator(free.len(), columns.iter().map(|column| dot(column, residuals)));
    Linear { columns, normal, gradient }
}

fn damped(linear: &Linear, damping: f64) -> Option<DVector<f64>> {
    let mut matrix = linear.normal.clone();
    for i in 0..matrix.nrows() {
        matrix[(i, i)] = matrix[(i, i)].max(f64::MIN_POSITIVE) * (1.0 + damping);
    }
    matrix.lu().solve(&-&linear.gradient)
}

fn judged(problem: &Problem, values: Values, residuals: &[f64], cost: f64, free: &[usize], linear: &Linear) -> Fit {
    let size = free.len();
    let lengths: Vec<f64> = (0..size).map(|i| linear.normal[(i, i)].sqrt().max(1e-100)).collect();
    let scaled = DMatrix::from_fn(size, size, |i, j| linear.normal[(i, j)] / (lengths[i] * lengths[j]));
    let parts = scaled.symmetric_eigen();
    let top = parts.eigenvalues.max();
    let floor = top / (CONDITION_LIMIT * CONDITION_LIMIT);
    let rank = parts.eigenvalues.iter().filter(|value| **value > floor).count();
    let condition = (top / parts.eigenvalues.min().max(f64::MIN_POSITIVE)).sqrt();
    let inverted = parts.eigenvalues.map(|value| if value > floor { 1.0 / value } else { 0.0 });
    let inverse = &parts.eigenvectors * DMatrix::from_diagonal(&inverted) * parts.eigenvectors.transpose();
    let inverse = DMatrix::from_fn(size, size, |i, j| inverse[(i, j)] / (lengths[i] * lengths[j]));

    let mut stretches: Vec<DVector<f64>> = Vec::new();
    let mut from = problem.skip;
    for &to in problem.borders.iter().chain([&residuals.len()]) {
        if to > from {
            let sum = |column: &Vec<f64>| (from..to).map(|k| residuals[k] * column[k]).sum::<f64>();
            stretches.push(DVector::from_iterator(size, linear.columns.iter().map(sum)));
            from = to;
        }
    }
    let count = stretches.len() as f64;
    let share = count / (count - size as f64).max(1.0);
    let spread = stretches.iter().fold(DMatrix::zeros(size, size), |sum, g| sum + g * g.transpose());
    let robust = &inverse * spread * &inverse * share;
    let samples = (0..residuals.len()).filter(|k| problem.counts(*k)).count().max(1) as f64;
    let plain = &inverse * (cost / (samples - size as f64).max(1.0));
    let bent = |(time, uncertainty): (usize, f64)| {
        let column = problem.derivative(&values, residuals, time);
        let dots = linear.columns.iter().map(|own| dot(own, &column));
        &inverse * DVector::from_iterator(size, dots) * uncertainty
    };
    let bent: Vec<_> = problem.open_times(free).into_iter().map(bent).collect();
    let [mut errors, mut uncertainties] = [[0.0; COUNT]; 2];
    let mut covariance = [[0.0; COUNT]; COUNT];
    let variance = |i: usize| robust[(i, i)].max(plain[(i, i)]).max(0.0);
    let wider = |i: usize| if robust[(i, i)] > 0.0 { (variance(i) / robust[(i, i)]).sqrt() } else { 0.0 };
    for (i, &parameter) in free.iter().enumerate() {
        let of_times = |j: usize| bent.iter().map(|bent| bent[i] * bent[j]).sum::<f64>();
        errors[parameter] = values.unscaled(parameter, variance(i).sqrt());
        uncertainties[parameter] = values.unscaled(parameter, (variance(i) + of_times(i)).sqrt());
        for (j, &other) in free.iter().enumerate() {
            let own = if i == j { variance(i) } else { wider(i) * wider(j) * robust[(i, j)] };
            covariance[parameter][other] = values.unscaled(parameter, values.unscaled(other, own + of_times(j)));
        }
    }
    Fit { values, errors, uncertainties, covariance, rms: (cost / samples).sqrt(), rank, condition }
}
