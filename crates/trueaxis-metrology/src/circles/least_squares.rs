//! Least-squares circle by orthogonal distances.

use super::local::Local;
use super::{NoCircle, ReferenceCircle, check};
use std::vec::Vec;

/// Most steps of the fit; near-round points need about five, short noisy arcs some twenty.
const STEPS: usize = 200;

/// If a circle's residual exceeds this share of the best straight line's, the points are hardly a circle: there may be better
/// minima.
const HARDLY: f64 = 0.1;

/// A centre farther away than this many times the width of the set means a straight line.
const STRAIGHT: f64 = 1e7;

/// Circle with the smallest sum of squared distances from the points, LSC.
///
/// Minimises Σ (|pᵢ − c| − R)²; at the minimum R is the mean distance, which leaves two unknowns. The algebraic fit of Taubin
/// (1991) on centred and scaled points gives the start; Newton steps with Levenberg's damping follow, and a final step with
/// residuals formed without cancellation about the circle found, so that the centre is accurate to the rounding of the points,
/// also for short arcs. Radius: the mean; zone: largest − smallest distance from the centre.
///
/// Points that are hardly a circle, with more than a tenth of a straight line's residual, have several local minima: the steps
/// then also start from 47 more positions in and around them, and the smallest sum is the result.
///
/// Cost: linear in the points, some ten passes; some hundreds if they are hardly a circle.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`], [`NoCircle::Straight`] (also if the sum decreases towards a straight line).
pub fn least_squares(points: &[[f64; 2]]) -> Result<ReferenceCircle, NoCircle> {
    check(points)?;
    let (local, c) = fit(points)?;
    let mean = local.points.iter().map(|p| residual(&local, p, c)).sum::<f64>() / points.len() as f64;
    Ok(ReferenceCircle { radius: local.radius + mean, ..local.circle(c, Vec::new()) })
}

/// Points about the least-squares centre, to rounding, and the remaining offset of that centre.
pub(super) fn fit(points: &[[f64; 2]]) -> Result<(Local, [f64; 2]), NoCircle> {
    let n = points.len() as f64;
    // Dividing before adding avoids overflow, and the mean of a large set loses no significant digits.
    let mean = [0, 1].map(|k| points.iter().map(|p| p[k] / n).sum::<f64>());
    let centred: Vec<[f64; 2]> = points.iter().map(|p| [p[0] - mean[0], p[1] - mean[1]]).collect();
    let scale = (centred.iter().map(|p| p[0] * p[0] + p[1] * p[1]).sum::<f64>() / n).sqrt();
    let unit: Vec<[f64; 2]> = centred.iter().map(|p| [p[0] / scale, p[1] / scale]).collect();

    let line = Line::new(&unit);
    let mut best = descend(&unit, taubin(&unit));
    if best.is_none_or(|(_, cost)| cost >= HARDLY * line.cost) {
        for start in line.starts() {
            let other = descend(&unit, start);
            best = [best, other].into_iter().flatten().min_by(|a, b| a.1.total_cmp(&b.1));
        }
    }
    let Some((c, _)) = best.filter(|(_, cost)| *cost < line.cost) else { return Err(NoCircle::Straight) };

    let origin = [mean[0] + scale * c[0], mean[1] + scale * c[1]];
    let radius = points.iter().map(|p| (p[0] - origin[0]).hypot(p[1] - origin[1]) / n).sum();
    let local = Local::new(points, origin, radius);
    // About this origin the residuals are exact to their own rounding; two steps, because the first moves the centre.
    let mut c = [0.0; 2];
    for _ in 0..2 {
        let mut normal = Normal::default();
        for p in &local.points {
            normal.add([p.x - c[0], p.y - c[1]], local.distance(p.f(c), c), residual(&local, p, c));
        }
        let step = normal.finish(n).step(0.0);
        if step[0].hypot(step[1]) < 1e-6 * radius {
            c = [c[0] + step[0], c[1] + step[1]];
        }
    }
    Ok((local, c))
}

/// Newton's method with Levenberg's damping: centre and sum of squares, or `None` if it diverges to a straight line.
fn descend(unit: &[[f64; 2]], start: [f64; 2]) -> Option<([f64; 2], f64)> {
    let mut c = start;
    let mut damping = 0.0;
    let mut now = normal(unit, c);
    for _ in 0..STEPS {
        let step = now.step(damping);
        let next_c = [c[0] + step[0], c[1] + step[1]];
        let next = normal(unit, next_c);
        if next.cost < now.cost {
            (c, now, damping) = (next_c, next, damping * 0.1);
            if damping < 1e-9 * now.trace() {
                damping = 0.0;
            }
        } else if step[0].hypot(step[1]) <= 1e-14 * (1.0 + c[0].hypot(c[1])) {
            break;
        } else {
            damping = (damping * 10.0).max(1e-4 * now.trace());
        }
        let distance = c[0].hypot(c[1]);
        if distance.is_nan() || distance >= STRAIGHT {
            return None;
        }
    }
    Some((c, now.cost))
}

/// Straight line with the smallest sum of squared distances, through the mean of centred points.
struct Line {
    normal: [f64; 2],
    cost: f64,
}

impl Line {
    fn new(unit: &[[f64; 2]]) -> Line {
        let [mut xx, mut xy, mut yy] = [0.0; 3];
        for [x, y] in unit {
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        }
        // Direction of the smaller principal moment; the sum uses the distances, because the moments would cancel.
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy) + core::f64::consts::FRAC_PI_2;
        let normal = [angle.cos(), angle.sin()];
        let cost = unit.iter().map(|[x, y]| (x * normal[0] + y * normal[1]).powi(2)).sum();
        Line { normal, cost }
    }

    /// Starting points for the search for other minima, about points with a mean square distance of 1: a grid over them, rings
    /// around them, and far away on both sides of the line. They avoid every symmetry, because a search stops on a saddle.
    fn starts(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let net = (0..25).map(|k| [0.6 * f64::from(k % 5) - 1.1, 0.6 * f64::from(k / 5) - 1.13]);
        let rings = (0..16).map(|k| {
            let (sin, cos) = (0.2 + core::f64::consts::FRAC_PI_4 * f64::from(k)).sin_cos();
            let out = if k < 8 { 3.0 } else { 10.0 };
            [out * cos, out * sin]
        });
        let aside = [-1e5, -1e3, -10.0, 10.0, 1e3, 1e5];
        net.chain(rings).chain(aside.into_iter().map(|out| [out * self.normal[0], out * self.normal[1]]))
    }
}

/// |p − c| − R₀, without cancellation.
fn residual(local: &Local, p: &super::local::Point, c: [f64; 2]) -> f64 {
    let f = p.f(c);
    (f + c[0] * c[0] + c[1] * c[1]) / (local.distance(f, c) + local.radius)
}

/// Sums for one step: with unit vectors u = (p − c)/d and residuals ρ = d − mean d, half the gradient −Σ uρ and half the
/// Hessian Σ uuᵀ − ΣuΣuᵀ/n + Σ (ρ/d)(uuᵀ − 1)·(−1).
#[derive(Clone, Copy, Debug, Default)]
struct Normal {
    u: [f64; 2],
    uu: [f64; 3],
    ud: [f64; 2],
    d: f64,
    dd: f64,
    // Σ (1, uu)/d and Σ d(1, uu)/d for the curvature of the distances.
    inverse: [f64; 4],
    bent: [f64; 4],
    gradient: [f64; 2],
    gauss: [f64; 3],
    newton: [f64; 3],
    cost: f64,
}

impl Normal {
    fn add(&mut self, from_centre: [f64; 2], distance: f64, value: f64) {
        if distance <= 0.0 {
            return;
        }
        let u = [from_centre[0] / distance, from_centre[1] / distance];
        let uu = [u[0] * u[0], u[0] * u[1], u[1] * u[1]];
        for k in 0..2 {
            self.u[k] += u[k];
            self.ud[k] += u[k] * value;
        }
        for k in 0..3 {
            self.uu[k] += uu[k];
            self.inverse[k] += uu[k] / distance;
            self.bent[k] += uu[k] * value / distance;
        }
        self.inverse[3] += 1.0 / distance;
        self.bent[3] += value / distance;
        self.d += value;
        self.dd += value * value;
    }

    fn finish(mut self, n: f64) -> Self {
        let mean = self.d / n;
        self.gradient = [0, 1].map(|k| self.ud[k] - mean * self.u[k]);
        let product = [self.u[0] * self.u[0], self.u[0] * self.u[1], self.u[1] * self.u[1]];
        self.gauss = [0, 1, 2].map(|k| self.uu[k] - product[k] / n);
        let bent = [0, 1, 2, 3].map(|k| self.bent[k] - mean * self.inverse[k]);
        let ones = [1.0, 0.0, 1.0];
        self.newton = [0, 1, 2].map(|k| self.gauss[k] + ones[k] * bent[3] - bent[k]);
        self.cost = self.dd - self.d * mean;
        self
    }

    fn trace(&self) -> f64 {
        self.gauss[0] + self.gauss[2]
    }

    /// Newton's step if the Hessian is positive definite, otherwise the Gauss-Newton step.
    fn step(&self, damping: f64) -> [f64; 2] {
        let solve = |h: [f64; 3]| {
            let (a, b, d) = (h[0] + damping, h[1], h[2] + damping);
            let determinant = a * d - b * b;
            let [g, k] = self.gradient;
            (determinant > 0.0 && a > 0.0).then(|| [(d * g - b * k) / determinant, (a * k - b * g) / determinant])
        };
        solve(self.newton).or_else(|| solve(self.gauss)).unwrap_or([0.0; 2])
    }
}

fn normal(points: &[[f64; 2]], c: [f64; 2]) -> Normal {
    let mut sums = Normal::default();
    // Relative to a typical distance, to avoid cancellation in the cost.
    let typical = points.iter().map(|p| (p[0] - c[0]).hypot(p[1] - c[1])).sum::<f64>() / points.len() as f64;
    for p in points {
        let from_centre = [p[0] - c[0], p[1] - c[1]];
        let distance = from_centre[0].hypot(from_centre[1]);
        sums.add(from_centre, distance, distance - typical);
    }
    sums.finish(points.len() as f64)
}

/// Algebraic fit of centred points with mean square distance 1: the smallest root of Taubin's characteristic polynomial,
/// by Newton's method from 0, which approaches it from below (Chernov 2010, section 5.9).
fn taubin(points: &[[f64; 2]]) -> [f64; 2] {
    let n = points.len() as f64;
    let [mut xx, mut xy, mut yy, mut xz, mut yz, mut zz] = [0.0; 6];
    for p in points {
        let z = p[0] * p[0] + p[1] * p[1];
        xx += p[0] * p[0] / n;
        xy += p[0] * p[1] / n;
        yy += p[1] * p[1] / n;
        xz += p[0] * z / n;
        yz += p[1] * z / n;
        zz += z * z / n;
    }
    let z = xx + yy;
    let covariance = xx * yy - xy * xy;
    let variance = zz - z * z;
    let a3 = 4.0 * z;
    let a2 = -3.0 * z * z - zz;
    let a1 = variance * z + 4.0 * covariance * z - xz * xz - yz * yz;
    let a0 = xz * (xz * yy - yz * xy) + yz * (yz * xx - xz * xy) - variance * covariance;
    let (mut root, mut value) = (0.0, a0);
    for _ in 0..50 {
        let slope = a1 + root * (2.0 * a2 + root * 3.0 * a3);
        let next = root - value / slope;
        if !next.is_finite() || next == root {
            break;
        }
        let next_value = a0 + next * (a1 + next * (a2 + next * a3));
        if next_value.abs() >= value.abs() {
            break;
        }
        (root, value) = (next, next_value);
    }
    let determinant = root * root - root * z + covariance;
    let c = [(xz * (yy - root) - yz * xy) / determinant / 2.0, (yz * (xx - root) - xz * xy) / determinant / 2.0];
    if c[0].hypot(c[1]) < STRAIGHT { c } else { [0.0; 2] }
}
