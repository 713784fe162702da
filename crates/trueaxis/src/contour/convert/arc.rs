//! Converts circles, helices and spirals to spans.

use super::{DVec3, MOST, Maker, PathError, Piece, REACH, SAME_POINT, TOO_MANY, TURN, finite, refuse};
use crate::contour::span::{Form, Span};
use crate::position::Position;
use crate::real::Real;

/// Largest error of a helix's axial coordinate, mm.
const HELIX_ERROR: f64 = 1e-10;
/// Largest difference between the radii at start and end of an arc, mm (rounded programs have such differences); the radius
/// then changes linearly with the angle.
const RADIUS_TOLERANCE: f64 = 0.02;

impl<R: Real, P: Position, S: FnMut(Span<R, P>) -> Result<(), PathError>> Maker<'_, R, P, S> {
    pub(super) fn arc(
        &mut self,
        start: DVec3,
        end: DVec3,
        center: DVec3,
        normal: DVec3,
        turns: u32,
    ) -> Result<(), PathError> {
        let spiral = Spiral::new(start, end, center, normal, turns)?;
        let count = spiral.count()?;
        if self.counting {
            return self.counted(count as u32);
        }
        let k = libm::tan(0.25 * spiral.angle / count);
        for i in 0..count as u32 {
            self.emit(spiral.piece([f64::from(i) / count, f64::from(i + 1) / count], k))?;
        }
        Ok(())
    }
}

/// A checked arc: a circle, helix or spiral about an axis.
struct Spiral {
    start: DVec3,
    center: DVec3,
    /// Direction of the axis, and two directions across it: towards the start, and 90° further on.
    n: DVec3,
    e1: DVec3,
    e2: DVec3,
    radius: f64,
    /// Total angle, rad; rise over it, mm; rise and growth of the radius per radian.
    angle: f64,
    rise: f64,
    pitch: f64,
    growth: f64,
}

impl Spiral {
    fn new(start: DVec3, end: DVec3, center: DVec3, normal: DVec3, turns: u32) -> Result<Self, PathError> {
        for (field, point) in [("start", start), ("end", end), ("center", center), ("normal", normal)] {
            finite(field, point)?;
        }
        let size = normal.length();
        if size < 1e-6 {
            return refuse("normal", None, size, "a direction");
        }
        if turns > 10_000 {
            return refuse("turns", None, f64::from(turns), "at most 10000");
        }
        let n = normal / size;
        let across = |p: DVec3| p + n * -p.dot(n);
        let (from, to) = (across(start - center), across(end - center));
        let (radius, end_radius) = (from.length(), to.length());
        // Neither a start nor an end on the axis has a direction.
        if radius.min(end_radius) < SAME_POINT {
            return refuse("center", None, radius.min(end_radius), "a radius above 1e-9 mm");
        }
        if (radius - end_radius).abs() > RADIUS_TOLERANCE + 1e-3 * radius.min(1.0) {
            return refuse("end", None, end_radius - radius, "the same radius at start and end, within 0.02 mm");
        }
        let e1 = from / radius;
        let e2 = n.cross(e1);
        let mut angle = libm::atan2(to.dot(e2), to.dot(e1));
        if angle < 1e-9 / radius.max(1e-3) {
            angle += core::f64::consts::TAU;
        }
        let angle = angle + core::f64::consts::TAU * f64::from(turns);
        let rise = (end - start).dot(n);
        let growth = if (end_radius - radius).abs() < SAME_POINT { 0.0 } else { (end_radius - radius) / angle };
        Ok(Spiral { start, center, n, e1, e2, radius, angle, rise, pitch: rise / angle, growth })
    }

    /// Number of spans that satisfies the limits of turn, reach, and the helix's axial polynomial.
    fn count(&self) -> Result<f64, PathError> {
        let Spiral { radius, angle, rise, .. } = *self;
        let mut count =
            libm::ceil((angle / TURN).max(DVec3::new(radius * angle, rise, 0.0).length() / (2.0 * REACH))).max(1.0);
        while axial_error(angle / count, self.pitch) > HELIX_ERROR && count <= f64::from(MOST) {
            count *= 1.25;
        }
        let count = libm::ceil(count);
        if count > f64::from(MOST) {
            let length = DVec3::new(radius * angle, rise, 0.0).length();
            return refuse("length", None, length, TOO_MANY);
        }
        Ok(count)
    }

    /// The part between two parameters; `k` is the tangent of a quarter of its angle.
    fn piece(&self, u: [f64; 2], k: f64) -> Piece {
        let Spiral { start, center, n, e1, e2, angle, rise, pitch, growth, .. } = *self;
        let middle = angle * 0.5 * (u[0] + u[1]);
        let (s, c) = (libm::sin(middle), libm::cos(middle));
        let out = e1 * c + e2 * s;
        let on = e2 * c - e1 * s;
        let height = (start - center).dot(n) + pitch * middle;
        let radius = self.radius + growth * middle;
        let origin = center + out * radius + n * height;
        // In τ = −1..1: w = 1 + k²τ², (xyz) w = r(−2k²τ² out + 2kτ on) + pitch θ w n.
        let axial = axial_polynomial(k).map(|c| c * pitch);
        let mut tau = [[0.0; 4]; 6];
        for j in 0..3 {
            tau[1][j] = 2.0 * k * radius * on[j];
            tau[2][j] = -2.0 * k * k * radius * out[j];
            for (power, axial) in [1, 3, 5].into_iter().zip(axial) {
                tau[power][j] += axial * n[j];
            }
        }
        // A changing radius adds growth θ ((1 − k²τ²) out + 2kτ on); the truncated series omits 0.8 growth k⁶.
        let (k2, k3, k4, k5) = (k * k, k * k * k, k * k * k * k, k * k * k * k * k);
        let spiral = [
            (1, 2.0 * k, 0.0),
            (2, 0.0, 4.0 * k2),
            (3, -8.0 / 3.0 * k3, 0.0),
            (4, 0.0, -4.0 / 3.0 * k4),
            (5, 16.0 / 15.0 * k5, 0.0),
        ];
        for (power, outward, onward) in spiral {
            for j in 0..3 {
                tau[power][j] += growth * (outward * out[j] + onward * on[j]);
            }
        }
        tau[0][3] = 1.0;
        tau[2][3] = k2;
        let form = if rise == 0.0 && growth == 0.0 { Form::RationalCubic } else { Form::RationalQuintic };
        Piece { origin, coefficients: from_tau(tau), form, u, quarter_tangent: k }
    }
}

/// θ w = 2 atan(kτ)(1 + k²τ²) = 2(kτ + ⅔k³τ³ − 2/15 k⁵τ⁵ + 2/35 k⁷τ⁷ − …), with τ⁷ distributed over the lower odd powers by
/// the Chebyshev polynomial T₇ = 64τ⁷ − 112τ⁵ + 56τ³ − 7τ: coefficients of τ, τ³, τ⁵.
fn axial_polynomial(k: f64) -> [f64; 3] {
    let k2 = k * k;
    let (c1, c3, c5, c7) = (2.0 * k, 4.0 / 3.0 * k * k2, -4.0 / 15.0 * k * k2 * k2, 4.0 / 35.0 * k * k2 * k2 * k2);
    [c1 + c7 * 7.0 / 64.0, c3 - c7 * 56.0 / 64.0, c5 + c7 * 112.0 / 64.0]
}

/// Bound of the remaining error, mm: a 64th of the τ⁷ term, and all of the τ⁹ term.
fn axial_error(angle: f64, pitch: f64) -> f64 {
    let k = libm::tan(0.25 * angle);
    let k7 = libm::pow(k, 7.0);
    pitch.abs() * k7 * (4.0 / 35.0 / 64.0 + 4.0 / 63.0 * k * k)
}

/// Converts a polynomial in τ = 2t − 1 to one in t.
fn from_tau(tau: [[f64; 4]; 6]) -> [[f64; 4]; 6] {
    // Horner's scheme with the factor (2t − 1).
    let mut result = [[0.0; 4]; 6];
    for c in tau.iter().rev() {
        let mut next = [[0.0; 4]; 6];
        for power in 0..6 {
            for k in 0..4 {
                let lower = if power == 0 { 0.0 } else { result[power - 1][k] };
                next[power][k] = 2.0 * lower - result[power][k];
            }
        }
        for k in 0..4 {
            next[0][k] += c[k];
        }
        result = next;
    }
    result
}
