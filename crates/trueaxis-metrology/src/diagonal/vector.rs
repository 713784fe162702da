//! The vector method: results from single steps of the axes, and their assumptions.

use super::Test;
use super::steps::{Step, steps};
use super::volume::Term;
use crate::linear_fit::LinearFit;
use std::vec;
use std::vec::Vec;

/// An error of an axis along its travel, with the end-to-end slope removed.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Index of the moving axis, 0 … 2.
    pub axis: usize,
    /// Position and the errors along X, Y, Z there, mm.
    pub points: Vec<([f64; 4], [f64; 3])>,
}

/// Results from the steps.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Vector {
    /// Scales of X, Y, Z by the vector method, which assumes an aligned mirror.
    pub scales_if_aligned: [f64; 3],
    /// Scales with the stated uncertainty of the alignment; `None` without it.
    pub scales: Option<[Term; 3]>,
    /// Change of each scale for a mirror tilted by 1 rad on one diagonal, root of the sum of squares over the four.
    pub scale_per_alignment: [f64; 3],
    /// Errors of X, Y, Z by position, slopes removed; per point the position, the three errors, and their standard errors.
    pub shapes: Vec<Shape>,
    /// Standard deviation of a step, from the fourth equation of each step; mm.
    pub sigma_mm: f64,
    /// Number of equations − unknowns of the shapes.
    pub degrees_of_freedom: usize,
    /// Condition number of the four equations of a step.
    pub condition: f64,
    /// Largest distance of a target from its diagonal, mm.
    pub lateral_mm: f64,
}

/// Evaluates the steps; `None` if the test has none, or if an interval is missing on one of the four diagonals.
pub(super) fn vector(test: &Test, alignment_rad: Option<f64>) -> Option<Vector> {
    let steps = steps(test);
    let mut shapes = Vec::new();
    let mut slopes: Vec<Slope> = Vec::new();
    let (mut squares, mut freedom, mut condition) = (0.0, 0_usize, 0.0_f64);
    for axis in 0..3 {
        let intervals = intervals(&steps, axis)?;
        for k in 0..4 {
            slopes.push(slope(test, &intervals, k, axis));
        }
        let own: Vec<&Slope> = slopes.iter().filter(|slope| slope.axis == axis).collect();
        let mut increments = Vec::new();
        for interval in &intervals {
            let width = interval.ends_mm[1] - interval.ends_mm[0];
            let mut fit = LinearFit::new(3);
            for k in 0..4 {
                let left = interval.changes_mm[k] - own[k].value * width;
                fit.add(&test.diagonals[k].unit, left, 1.0);
            }
            let found = fit.solve();
            squares += found.squares;
            freedom += 1;
            condition = condition.max(found.condition);
            increments.push((interval.ends_mm, found));
        }
        // The mean slope of the fourth equation is also removed.
        freedom = freedom.saturating_sub(1);
        shapes.push((axis, increments));
    }
    let sigma_mm = if freedom > 0 { (squares / freedom as f64).sqrt() } else { 0.0 };
    let shapes = shapes.into_iter().map(|(axis, increments)| shape(axis, &increments, sigma_mm)).collect();
    let aligned = linear(test, &slopes, None);
    let scales = alignment_rad.map(|rad| {
        let found = linear(test, &slopes, Some(rad));
        std::array::from_fn(|axis| Term { value: found.0[axis], standard_error: found.1[axis] })
    });
    let lateral = test.diagonals.iter().flat_map(|own| &own.targets).map(|target| target.lateral_mm);
    Some(Vector {
        scales_if_aligned: aligned.0,
        scales,
        scale_per_alignment: sensitivity(test, &slopes, aligned.0),
        shapes,
        sigma_mm,
        degrees_of_freedom: freedom,
        condition,
        lateral_mm: lateral.fold(0.0, f64::max),
    })
}

struct Interval {
    ends_mm: [f64; 2],
    changes_mm: [f64; 4],
}

/// Mean change of the reading per mm of an axis' travel on a diagonal.
struct Slope {
    axis: usize,
    diagonal: usize,
    value: f64,
    standard_error: f64,
}

/// Intervals of an axis, each measured on all diagonals.
fn intervals(steps: &[Step], axis: usize) -> Option<Vec<Interval>> {
    let mut own: Vec<&Step> = steps.iter().filter(|step| step.axis == axis).collect();
    crate::order::sort_by_number(&mut own, |one| one.ends_mm[0]);
    let near = |one: &&Step, other: &&Step| {
        let width = one.ends_mm[1] - one.ends_mm[0];
        (0..2).all(|end| (one.ends_mm[end] - other.ends_mm[end]).abs() < 1e-4 * width)
    };
    let mut found = Vec::new();
    for group in own.chunk_by(|one, other| near(one, other)) {
        let change = |k: usize| group.iter().find(|step| step.diagonal == k).map(|step| step.change_mm);
        let changes_mm = [change(0)?, change(1)?, change(2)?, change(3)?];
        found.push(Interval { ends_mm: group.first()?.ends_mm, changes_mm });
    }
    (found.len() >= 2).then_some(found)
}

fn slope(test: &Test, intervals: &[Interval], diagonal: usize, axis: usize) -> Slope {
    let travel: f64 = intervals.iter().map(|interval| interval.ends_mm[1] - interval.ends_mm[0]).sum();
    let change: f64 = intervals.iter().map(|interval| interval.changes_mm[diagonal]).sum();
    // A sum of differences: two independent readings per step.
    let scatter = test.sigma_mm.unwrap_or(0.0) * (2.0 * intervals.len() as f64).sqrt();
    Slope { axis, diagonal, value: change / travel, standard_error: scatter / travel }
}

/// Two unit vectors across a diagonal.
fn across(u: [f64; 3]) -> [[f64; 3]; 2] {
    let flat = u[0].hypot(u[1]);
    let one = [-u[1] / flat, u[0] / flat, 0.0];
    let other = [-u[2] * one[1], u[2] * one[0], u[0] * one[1] - u[1] * one[0]];
    [one, other]
}

/// Scales of X, Y, Z and their standard errors from twelve slopes; the eight tilts of the mirror are zero, or zero within
/// `alignment_rad`. The other unknowns are six slopes across the axes.
fn linear(test: &Test, slopes: &[Slope], alignment_rad: Option<f64>) -> ([f64; 3], [f64; 3]) {
    let unknowns = if alignment_rad.is_some() { 17 } else { 9 };
    let mut fit = LinearFit::new(unknowns);
    let aligned = alignment_rad.unwrap_or(1.0).max(1e-12);
    let noise = slopes.iter().map(|slope| slope.standard_error).fold(1e-3 * aligned, f64::max);
    for slope in slopes {
        let u = test.diagonals[slope.diagonal].unit;
        let mut row = [0.0; 17];
        for c in 0..3 {
            row[unknown(slope.axis, c)] = u[c];
        }
        for (i, direction) in across(u).into_iter().enumerate() {
            row[9 + 2 * slope.diagonal + i] = direction[slope.axis];
        }
        fit.add(&row[..unknowns], slope.value, 1.0 / noise);
    }
    for tilt in 9..unknowns {
        let mut row = [0.0; 17];
        row[tilt] = 1.0;
        fit.add(&row, 0.0, 1.0 / aligned);
    }
    let found = fit.solve();
    (std::array::from_fn(|axis| found.values[axis]), std::array::from_fn(|axis| found.error_factors[axis]))
}

/// Index of the slope of an axis along X, Y or Z: 0 … 2 for scales, then the slopes across.
fn unknown(axis: usize, component: usize) -> usize {
    match (axis, component) {
        (a, c) if a == c => a,
        (a, c) => 3 + 2 * a + c - usize::from(c > a),
    }
}

/// Change of the scales when each diagonal's mirror in turn is tilted by 1 rad, in the worst sense.
fn sensitivity(test: &Test, slopes: &[Slope], scales: [f64; 3]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for k in 0..4 {
        for direction in across(test.diagonals[k].unit) {
            let tilted: Vec<Slope> = slopes
                .iter()
                .map(|slope| Slope {
                    value: slope.value + if slope.diagonal == k { direction[slope.axis] } else { 0.0 },
                    ..*slope
                })
                .collect();
            let moved = linear(test, &tilted, None).0;
            for axis in 0..3 {
                sums[axis] += (moved[axis] - scales[axis]).powi(2);
            }
        }
    }
    sums.map(f64::sqrt)
}

/// Sums of the increments, starting from zero at the low end.
fn shape(axis: usize, increments: &[([f64; 2], crate::linear_fit::Solution)], sigma_mm: f64) -> Shape {
    let first = increments.first().map_or(0.0, |(ends, _)| ends[0]);
    let mut points = vec![([first, 0.0, 0.0, 0.0], [0.0; 3])];
    let (mut at, mut variance) = ([0.0; 3], [0.0; 3]);
    let count = increments.len() as f64;
    for (i, (ends, found)) in increments.iter().enumerate() {
        for c in 0..3 {
            at[c] += found.values[c];
            variance[c] += (sigma_mm * found.error_factors[c]).powi(2);
        }
        // The sum is tied to zero at both ends, like a bridge.
        let free = 1.0 - (i + 1) as f64 / count;
        points.push(([ends[1], at[0], at[1], at[2]], variance.map(|v| (v * free).max(0.0).sqrt())));
    }
    Shape { axis, points }
}
