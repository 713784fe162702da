//! Feet of two points near one another on one span, from one shifted frame.
//!
//! The tip's is found as [`super::super::kernel`] does it. The encoder lies d = tip − encoder from it, and in the same frame
//! x + w d is its homogeneous vector: from the tip's foot a step of the second order, then an exact Newton step.
//!
//! What a Newton step c leaves along the path is, with T the path's derivative and u = g''/2g',
//!
//! ```text
//! τ ≤ |T| c² (|u| + K)        K: what u changes by on the way from the guess
//! ```
//!
//! and the distance e is then off by at most √(e² + τ²) − e, which is below ε exactly where τ² ≤ ε(ε + 2e). K holds where
//! neither the path's second nor its third derivative is much larger than its first, which is tested too: u may be small
//! by chance, at an inflection or in the middle of an arc.

use super::super::ContourError;
use super::super::kernel::{Taylor, homogeneous, shifted_cubic, shifted_quintic, third_order};
use super::super::span::{Form, Span, dot};
use crate::position::Position;
use crate::real::Real;

/// What the distance may be off, mm: 1e-6 nm in doubles, 0.3 nm in single precision.
#[inline(always)]
fn tolerance<R: Real>() -> R {
    if R::EPSILON.to_f64() < 1e-10 { R::of(1e-12) } else { R::of(3e-7) }
}

/// K.
const CHANGE_OF_U: f64 = 4.0;

/// Derivative of the path at the tip's foot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tangent<R> {
    pub(super) tangent: [R; 3],
    /// Its length, and the square of that.
    pub(super) speed: R,
    pub(super) squared: R,
}

impl<R: Real> Tangent<R> {
    pub(super) const NONE: Self = Tangent { tangent: [R::ZERO; 3], speed: R::ZERO, squared: R::ZERO };
}

/// Which of the two feet are exact minima of the distance, wherever on the span or beyond it they lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Converged {
    pub(super) tip: bool,
    pub(super) encoder: bool,
}

/// Feet near `guess` of an encoder position and of the tip `d` (mm) from it: parameter, vector and error are written, if
/// the tip's foot is one.
#[inline(always)]
pub(super) fn feet<R: Real, P: Position>(
    span: &Span<R, P>,
    position: &[P; 3],
    d: &[R; 3],
    guess: R,
    tip: &mut ContourError<R>,
    encoder: &mut ContourError<R>,
    along: &mut Tangent<R>,
) -> Converged {
    match span.form {
        Form::Cubic => cubic::<R, P, false>(span, position, d, guess, tip, encoder, along),
        Form::RationalCubic => cubic::<R, P, true>(span, position, d, guess, tip, encoder, along),
        Form::Quintic => quintic::<R, P, false>(span, position, d, guess, tip, encoder, along),
        Form::RationalQuintic => quintic::<R, P, true>(span, position, d, guess, tip, encoder, along),
    }
}

#[inline(never)]
fn cubic<R: Real, P: Position, const RATIONAL: bool>(
    span: &Span<R, P>,
    position: &[P; 3],
    d: &[R; 3],
    guess: R,
    tip: &mut ContourError<R>,
    encoder: &mut ContourError<R>,
    along: &mut Tangent<R>,
) -> Converged {
    let shifted = shifted_cubic::<R, RATIONAL>(&span.coefficients, guess);
    solve::<R, RATIONAL, 4>(&shifted, &local(span, position, d), d, guess, tip, encoder, along)
}

#[inline(never)]
fn quintic<R: Real, P: Position, const RATIONAL: bool>(
    span: &Span<R, P>,
    position: &[P; 3],
    d: &[R; 3],
    guess: R,
    tip: &mut ContourError<R>,
    encoder: &mut ContourError<R>,
    along: &mut Tangent<R>,
) -> Converged {
    let shifted = shifted_quintic::<R, RATIONAL>(&span.coefficients, guess);
    solve::<R, RATIONAL, 6>(&shifted, &local(span, position, d), d, guess, tip, encoder, along)
}

/// The tip relative to the span's origin: the encoder's distance is exact, and no position is rounded.
#[inline(always)]
pub(super) fn local<R: Real, P: Position>(span: &Span<R, P>, position: &[P; 3], d: &[R; 3]) -> [R; 3] {
    let [x, y, z] = span.relative(position);
    [x + d[0], y + d[1], z + d[2]]
}

#[inline(always)]
fn solve<R: Real, const RATIONAL: bool, const C: usize>(
    shifted: &[[R; 4]; C],
    p: &[R; 3],
    d: &[R; 3],
    guess: R,
    tip: &mut ContourError<R>,
    encoder: &mut ContourError<R>,
    along: &mut Tangent<R>,
) -> Converged {
    let neither = Converged { tip: false, encoder: false };
    let (x, w) = homogeneous::<R, RATIONAL, C>(shifted, p);
    let Some(step) = third_order::<R, RATIONAL, C>(&x, &w) else { return neither };
    let ([_, _, bend, twist, ..], [w0, w1, w2, w3, ..]) = (&x[..], &w[..]) else { return neither };
    // Second and third derivative against the first: |d|² + |e|² below a few |b|², and as to the weights the same.
    let mut even = dot(bend, bend) + dot(twist, twist);
    if RATIONAL {
        even = even * *w0 + step.g1 * (*w1 * *w1 + *w2 * *w2 + *w3 * *w3);
    }
    let even = even < R::of(4.0) * step.g1;

    let at = Taylor::at::<RATIONAL, C>(&x, &w, step.h);
    let newton = Newton::from::<RATIONAL>(&at, twist, *w3);
    let (c, weight) = (newton.correction, newton.weight);
    let mut tangent = [R::ZERO; 3];
    for k in 0..3 {
        tangent[k] = at.v[k] + R::TWO * c * at.z[k];
    }
    let rate = at.vw + R::TWO * c * at.zw;
    if RATIONAL {
        for k in 0..3 {
            tangent[k] = (tangent[k] - newton.vector[k] * rate) * weight;
        }
    }
    let squared = dot(&tangent, &tangent);
    let least = R::HALF * step.g1;
    let t = guess + step.h + c;
    tip.t = t;
    newton.write(tip);
    let change = step.u.abs() + R::of(CHANGE_OF_U);
    if !(step.sane && even && newton.slope > least && newton.leaves_nothing(tip.error, change, squared)) {
        return neither;
    }
    *along = Tangent { tangent, speed: squared.sqrt(), squared };

    // The encoder: g there is d·T, its derivative what it is at the tip's foot.
    let off = dot(d, &tangent);
    let mut slope = newton.slope;
    if RATIONAL {
        let weight_rate = rate * weight;
        slope = slope * weight * weight * weight + R::THREE * weight_rate * off;
    }
    let y = -(off / slope);
    let uy = step.u * y;
    let y = y - uy * y;
    let mut at = Taylor::at::<RATIONAL, C>(&x, &w, step.h + c + y);
    for k in 0..3 {
        if RATIONAL {
            at.r[k] += at.rw * d[k];
            at.v[k] += at.vw * d[k];
            at.z[k] += at.zw * d[k];
        } else {
            at.r[k] += d[k];
        }
    }
    let mut third = *twist;
    if RATIONAL {
        for k in 0..3 {
            third[k] += *w3 * d[k];
        }
    }
    let newton = Newton::from::<RATIONAL>(&at, &third, *w3);
    encoder.t = t + y + newton.correction;
    newton.write(encoder);
    let nothing_left = newton.leaves_nothing(encoder.error, change, squared);
    Converged { tip: true, encoder: uy.abs() < R::of(0.2) && newton.slope > least && nothing_left }
}

/// An exact Newton step.
struct Newton<R> {
    correction: R,
    /// g'.
    slope: R,
    /// One over the weight after the step.
    weight: R,
    /// From the point to the curve after the step, mm.
    vector: [R; 3],
}

impl<R: Real> Newton<R> {
    /// `third`, `w3`: third Taylor coefficients, for the vector after the step.
    #[inline(always)]
    fn from<const RATIONAL: bool>(at: &Taylor<R>, third: &[R; 3], w3: R) -> Self {
        let Taylor { r, v, z, rw, vw, zw } = at;
        let rv = dot(r, v);
        let rz = dot(r, z);
        let (mut g, mut slope) = (rv, dot(v, v) + (rz + rz));
        if RATIONAL {
            let rr = dot(r, r);
            g = rv * *rw - rr * *vw;
            slope = slope * *rw - (rv * *vw + R::TWO * (rr * *zw));
        }
        let c = -(g / slope);
        let weight = if RATIONAL { R::ONE / (*rw + c * (*vw + c * (*zw + c * w3))) } else { R::ONE };
        let mut vector = [R::ZERO; 3];
        for k in 0..3 {
            vector[k] = r[k] + c * (v[k] + c * (z[k] + c * third[k]));
            if RATIONAL {
                vector[k] = vector[k] * weight;
            }
        }
        Newton { correction: c, slope, weight, vector }
    }

    #[inline(always)]
    fn write(&self, foot: &mut ContourError<R>) {
        foot.vector = self.vector.map(|x| -x).into();
        foot.error = dot(&self.vector, &self.vector).sqrt();
    }

    /// The trust test: `change` bounds |u| from the guess to here, `squared` is |T|².
    #[inline(always)]
    fn leaves_nothing(&self, error: R, change: R, squared: R) -> bool {
        let left = change * self.correction * self.correction;
        left * left * squared <= tolerance::<R>() * (tolerance::<R>() + error + error)
    }
}
