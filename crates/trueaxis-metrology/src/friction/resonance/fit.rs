//! Least squares of one or two masses to a record, with prior knowledge as further observations.
//!
//! ```text
//! minimise Σ r² + s² Σ ((p − p₀)/σ_p)²
//! cov = H⁻¹ (Σ_c g_c g_cᵀ + s² Λ) H⁻¹,   H = JᵀJ + s² Λ,   Λ = diag 1/σ_p²,   g_c = Σ_{i in c} r_i J_i
//! ```
//!
//! s² is the variance of a residual, c a block of a record. Source: H. White, 10.2307/1912934.

use super::plant::{Masses, Plant, shifted};
use crate::cores::*;
use crate::friction::parameters::{self, COUNT, FEED_LAG, OFFSET, Problem, READING_LAG, REST, Values};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::vec::Vec;

/// Parameters after those of [`Values`]: t_c, t_s, then those of the two masses.
pub(super) const CURRENT_LOOP: usize = COUNT;
pub(super) const AGE: usize = COUNT + 1;
pub(super) const RESONANCE: usize = COUNT + 2;
pub(super) const DAMPING: usize = COUNT + 3;
pub(super) const SHARE: usize = COUNT + 4;
/// Number of parameters.
pub(super) const ALL: usize = COUNT + 5;

/// Lowest resonance that is sought, Hz.
pub(super) const LOWEST_HZ: f64 = 10.0;
/// Most steps of a fit.
const STEPS: usize = 60;
/// Length of a block of residuals, s: several times the memory of the drive's loops and of an encoder's subdivisional error.
const BLOCK_S: f64 = 0.05;

/// A set of parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) values: Values,
    /// t_c, t_s, ω_r, ζ, σ.
    pub(super) more: [f64; 5],
    /// Whether a scale on the load is read; `None`: one rigid mass.
    pub(super) scale: Option<bool>,
}

impl Point {
    pub(super) fn get(&self, parameter: usize) -> f64 {
        if parameter < COUNT { self.values.0[parameter] } else { self.more[parameter - COUNT] }
    }

    /// Low and high end, whether the logarithm is varied, and the step of the difference quotient.
    fn kind(parameter: usize, highest_hz: f64) -> (bool, [f64; 2], f64) {
        match parameter {
            CURRENT_LOOP => (true, [2e-5, 5e-3], 1e-2),
            AGE => (false, [0.0, 1e-2], 1e-5),
            RESONANCE => (true, [TAU * LOWEST_HZ, TAU * highest_hz], 1e-4),
            DAMPING => (false, [1e-3, 0.9], 1e-4),
            _ => (false, [0.02, 0.98], 1e-3),
        }
    }

    fn is_log(parameter: usize) -> bool {
        if parameter < COUNT { parameters::is_log(parameter) } else { Point::kind(parameter, 1.0).0 }
    }

    /// In the scale in which the parameter is varied.
    fn scaled(&self, parameter: usize) -> f64 {
        let value = self.get(parameter);
        if Point::is_log(parameter) { value.ln() } else { value }
    }

    fn moved(&self, parameter: usize, by: f64, highest_hz: f64) -> Point {
        let mut next = *self;
        if parameter < COUNT {
            next.values = self.values.moved(parameter, by);
            return next;
        }
        let (log, [low, high], _) = Point::kind(parameter, highest_hz);
        let value = &mut next.more[parameter - COUNT];
        *value = if log { *value * by.exp() } else { *value + by }.clamp(low, high);
        next
    }
}

/// Prior knowledge about a parameter, in the scale in which it is varied.
#[derive(Clone, Copy, Debug)]
pub(super) struct Before {
    pub(super) parameter: usize,
    pub(super) value: f64,
    pub(super) uncertainty: f64,
}

/// The record of one axis in stretches, each with a start before the samples that count.
#[derive(Clone, Debug)]
pub(super) struct Data {
    pub(super) problem: Problem,
    /// Samples: first simulated, first that counts, end.
    pub(super) stretches: Vec<[usize; 3]>,
    /// Position and velocity read at the first simulated sample of each; `None`: at rest.
    pub(super) begins: Vec<Option<[f64; 2]>>,
    pub(super) before: Vec<Before>,
    pub(super) highest_hz: f64,
    /// Whether the record begins at rest.
    pub(super) rests: bool,
}

impl Data {
    /// Number of samples that count.
    pub(super) fn count(&self) -> usize {
        self.stretches.iter().map(|[_, from, to]| to - from).sum()
    }

    fn plant(&self, at: &Point) -> Plant {
        let axis = self.problem.axis(&at.values);
        let [current_loop_s, age_s, omega, damping, share] = at.more;
        Plant {
            drive: trueaxis::machine::DriveFigures { current_loop_s, ..axis.drive },
            friction: axis.friction,
            rest: axis.rest,
            feed_lag_s: axis.feed_lag_s,
            age_s,
            masses: at.scale.map(|scale| Masses { omega, damping, share, scale }),
        }
    }

    /// Model − record on all samples that count.
    pub(super) fn residuals(&self, at: &Point) -> Vec<f64> {
        let (plant, problem) = (self.plant(at), &self.problem);
        let mut out = Vec::with_capacity(self.count());
        let lag_s = at.get(READING_LAG);
        for (&[begin, from, to], known) in self.stretches.iter().zip(&self.begins) {
            let known = known.map(|[position, velocity]| [position + lag_s * velocity + at.get(OFFSET), velocity]);
            let command =
                &problem.command[begin * problem.fine..((to - 1) * problem.fine + 1).min(problem.command.len())];
            let read = shifted(&plant.positions(command, problem.step_s, known), lag_s / problem.step_s);
            for k in from..to {
                let place = (k - begin) * problem.fine;
                out.push(command[place] - read[place] + at.get(OFFSET) - problem.error[k]);
            }
        }
        out
    }

    fn derivative(&self, at: &Point, residuals: &[f64], parameter: usize) -> Vec<f64> {
        if parameter == OFFSET {
            return Vec::from_iter(residuals.iter().map(|_| 1.0));
        }
        let step = if parameter < COUNT {
            parameters::step(parameter, &at.values)
        } else {
            let (log, [_, high], step) = Point::kind(parameter, self.highest_hz);
            let near = if log { at.get(parameter) * step.exp() > high } else { at.get(parameter) + step > high };
            if near { -step } else { step }
        };
        let moved = self.residuals(&at.moved(parameter, step, self.highest_hz));
        moved.iter().zip(residuals).map(|(moved, at)| (moved - at) / step).collect()
    }

    /// Sum of the squared deviations from the prior values, over their uncertainties.
    fn penalty(&self, at: &Point) -> f64 {
        self.before.iter().map(|b| ((at.scaled(b.parameter) - b.value) / b.uncertainty).powi(2)).sum()
    }

    /// Parameters that are fitted.
    pub(super) fn free(&self, scale: Option<bool>) -> Vec<usize> {
        let all = (0..ALL).filter(|&p| p < RESONANCE || scale.is_some());
        all.filter(|&p| (p != REST || self.rests) && (p != READING_LAG || self.problem.read_after_s.is_none()))
            .collect()
    }

    /// Blocks of the residuals, by their ends.
    fn blocks(&self) -> Vec<[usize; 2]> {
        let length = ((BLOCK_S / self.problem.sample_s()) as usize).max(1);
        let mut blocks = Vec::new();
        let mut at = 0;
        for [_, from, to] in &self.stretches {
            let end = at + to - from;
            while at < end {
                let next = if end - at < 2 * length { end } else { at + length };
                blocks.push([at, next]);
                at = next;
            }
        }
        blocks
    }
}

/// Model of a record linearised at a point.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    free: Vec<usize>,
    columns: Vec<Vec<f64>>,
    /// H.
    normal: DMatrix<f64>,
    /// s² Λ and s² Λ (p − p₀).
    known: DVector<f64>,
    pull: DVector<f64>,
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

impl Linear {
    fn new(data: &Data, at: &Point, residuals: &[f64], free: &[usize], variance: f64) -> Linear {
        let columns: Vec<Vec<f64>> = free.par_iter().map(|&p| data.derivative(at, residuals, p)).collect();
        let mut normal =
            DMatrix::from_fn(free.len(), free.len(), |i, j| if j <= i { dot(&columns[i], &columns[j]) } else { 0.0 });
        normal.fill_upper_triangle_with_lower_triangle();
        let [mut known, mut pull] = [DVector::zeros(free.len()), DVector::zeros(free.len())];
        for before in &data.before {
            let Some(place) = free.iter().position(|&p| p == before.parameter) else { continue };
            let weight = variance / before.uncertainty.powi(2);
            known[place] += weight;
            pull[place] += weight * (at.scaled(before.parameter) - before.value);
            normal[(place, place)] += weight;
        }
        Linear { free: free.to_vec(), columns, normal, known, pull }
    }

    fn gradient(&self, residuals: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.columns.len(), self.columns.iter().map(|column| dot(column, residuals)))
            + &self.pull
    }

    fn step(&self, residuals: &[f64], damping: f64) -> Option<DVector<f64>> {
        let mut matrix = self.normal.clone();
        for i in 0..matrix.nrows() {
            matrix[(i, i)] = matrix[(i, i)].max(f64::MIN_POSITIVE) * (1.0 + damping);
        }
        matrix.lu().solve(&-self.gradient(residuals))
    }

    /// The columns, followed by those of the prior knowledge, as orthogonal ones times an upper triangle (Gram and Schmidt,
    /// twice). The normal matrix would lose half of the digits, and gains, lags and times are nearly interchangeable.
    fn orthogonal(&self) -> (Vec<Vec<f64>>, DMatrix<f64>) {
        let size = self.free.len();
        let mut triangle = DMatrix::zeros(size, size);
        let mut done: Vec<Vec<f64>> = Vec::with_capacity(size);
        for (j, column) in self.columns.iter().enumerate() {
            let mut own = column.clone();
            own.extend((0..size).map(|i| if i == j { self.known[i].sqrt() } else { 0.0 }));
            for _ in 0..2 {
                for (i, other) in done.iter().enumerate() {
                    let part = dot(other, &own);
                    triangle[(i, j)] += part;
                    own.iter_mut().zip(other).for_each(|(own, other)| *own -= part * other);
                }
            }
            let length = dot(&own, &own).sqrt().max(f64::MIN_POSITIVE);
            triangle[(j, j)] = length;
            own.iter_mut().for_each(|own| *own /= length);
            done.push(own);
        }
        (done, triangle)
    }

    /// Remaining cost of `residuals` after a step of all parameters of this model.
    pub(super) fn left(&self, residuals: &[f64]) -> f64 {
        let cost = dot(residuals, residuals);
        let gradient = self.gradient(residuals);
        self.step(residuals, 1e-9).map_or(cost, |step| cost + gradient.dot(&step))
    }
}

/// A fit.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub(super) at: Point,
    pub(super) residuals: Vec<f64>,
    /// Sum of the squares of the residuals and of the deviations from the prior values.
    pub(super) cost: f64,
    pub(super) linear: Linear,
    pub(super) settled: bool,
}

/// Fits a model from `start` in at most `steps` steps; `variance`: s².
pub(super) fn fit(
    data: &Data,
    start: Point,
    free: &[usize],
    variance: f64,
    steps: usize,
    on_step: &mut dyn FnMut(),
) -> Fit {
    let cost_of = |at: &Point, residuals: &[f64]| dot(residuals, residuals) + variance * data.penalty(at);
    let mut at = start;
    let mut residuals = data.residuals(&at);
    let mut cost = cost_of(&at, &residuals);
    let mut damping = 1e-3;
    let mut settled = false;
    let mut small = 0;
    let mut linear = Linear::new(data, &at, &residuals, free, variance);
    for _ in 0..steps.min(STEPS) {
        on_step();
        let mut gain = None;
        while gain.is_none() && damping < 1e7 {
            let Some(step) = linear.step(&residuals, damping) else { break };
            let next = free.iter().zip(step.iter()).fold(at, |at, (&p, &by)| at.moved(p, by, data.highest_hz));
            let tried = data.residuals(&next);
            let found = cost_of(&next, &tried);
            if found.is_finite() && found <= cost {
                gain = Some(cost - found);
                (at, residuals, cost) = (next, tried, found);
                damping = (0.1 * damping).max(1e-9);
            } else {
                damping *= 8.0;
            }
        }
        small = if gain.is_some_and(|gain| gain > 0.5 * variance) { 0 } else { small + 1 };
        settled = gain.is_none() || small == 2;
        if gain.is_some() {
            linear = Linear::new(data, &at, &residuals, free, variance);
        }
        if settled {
            break;
        }
    }
    Fit { at, residuals, cost, linear, settled }
}

impl Fit {
    /// Variance of a residual, and how much more the sum of neighbouring residuals varies than that of independent ones, at
    /// least 1.
    pub(super) fn variance(&self, data: &Data) -> [f64; 2] {
        let count = self.residuals.len().max(1) as f64;
        let freedom = (count - self.linear.free.len() as f64).max(1.0);
        let variance = dot(&self.residuals, &self.residuals) / freedom;
        let lags = ((0.5 * BLOCK_S / data.problem.sample_s()) as usize).max(1);
        let mut sum = 1.0;
        for lag in 1..lags {
            let product = dot(&self.residuals[lag.min(self.residuals.len())..], &self.residuals) / count;
            sum += 2.0 * (1.0 - lag as f64 / lags as f64) * product / variance.max(f64::MIN_POSITIVE);
        }
        [variance, sum.max(1.0)]
    }

    /// Standard errors in the parameters' units, 0 for those not fitted.
    pub(super) fn errors(&self, data: &Data) -> [f64; ALL] {
        let size = self.linear.free.len();
        let mut errors = [0.0; ALL];
        let (orthogonal, triangle) = self.linear.orthogonal();
        let count = self.residuals.len();
        let blocks = data.blocks();
        // What was known before varies as stated, the record as its blocks do.
        let variance = self.variance(data)[0];
        let mut meat =
            DMatrix::from_fn(size, size, |i, j| variance * dot(&orthogonal[i][count..], &orthogonal[j][count..]));
        let share = blocks.len() as f64 / (blocks.len() as f64 - size as f64).max(1.0);
        for &[from, to] in &blocks {
            let own = |column: &Vec<f64>| dot(&column[from..to], &self.residuals[from..to]);
            let g = DVector::from_iterator(size, orthogonal.iter().map(own));
            meat += &g * g.transpose() * share;
        }
        let Some(inverse) = triangle.clone().try_inverse() else { return [f64::INFINITY; ALL] };
        let robust = &inverse * meat * inverse.transpose();
        let plain = &inverse * inverse.transpose() * variance;
        for (i, &parameter) in self.linear.free.iter().enumerate() {
            let error = robust[(i, i)].max(plain[(i, i)]).max(0.0).sqrt();
            errors[parameter] = if Point::is_log(parameter) { error * self.at.get(parameter) } else { error };
        }
        errors
    }

    /// Number of blocks less that of parameters.
    pub(super) fn degrees_of_freedom(&self, data: &Data) -> f64 {
        data.blocks().len().saturating_sub(self.linear.free.len()).max(1) as f64
    }

    /// Sums of squares over the odd and over the even blocks.
    pub(super) fn halves(&self, data: &Data) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for (k, [from, to]) in data.blocks().into_iter().enumerate() {
            sums[k / 2 % 2] += dot(&self.residuals[from..to], &self.residuals[from..to]);
        }
        sums
    }
}

/// Prior knowledge about the parameters that a record may not determine, about `start`.
pub(super) fn known(start: &Point, period_s: f64, lag_s: f64) -> Vec<Before> {
    use parameters::{
        FEED_FORWARD, POSITION_GAIN, RESET_TIME, STRIBECK_SHARE, STRIBECK_VELOCITY, VELOCITY_GAIN, VISCOUS,
    };
    let about = |parameter, uncertainty| Before { parameter, value: start.scaled(parameter), uncertainty };
    let at = |parameter, value, uncertainty| Before { parameter, value, uncertainty };
    Vec::from([
        about(POSITION_GAIN, 0.7),
        about(RESET_TIME, 0.7),
        about(VELOCITY_GAIN, 0.7),
        about(FEED_FORWARD, 0.5),
        about(STRIBECK_SHARE, 0.5),
        about(STRIBECK_VELOCITY, 1.0),
        about(VISCOUS, 0.05),
        at(READING_LAG, 0.0, lag_s),
        // Commands that act evenly, held ones, and a loop closed once per cycle.
        at(FEED_LAG, 0.5, 0.4),
        about(CURRENT_LOOP, 0.5),
        at(AGE, 0.5 * period_s, 0.4 * period_s),
        at(REST, 0.0, 1.0),
        at(SHARE, 0.5, 0.29),
    ])
}
