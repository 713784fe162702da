//! Foot of a point on one span, from a good guess: the fast path of the step.
//!
//! With x(t) = c(t)_xyz − w(t) p the homogeneous vector from the point p to the curve, the squared distance is
//! x·x/w² and its derivative vanishes with
//!
//! ```text
//! g = (x·x') w − (x·x) w'
//! ```
//!
//! The kernel shifts the polynomial to the guess once. There g's series to the second power gives a third-order step
//! h = y − y·uy(1 − 2uy), y = −g/g', u = g''/2g'; one exact Newton correction follows in the same frame. A trust test bounds
//! what remains: g' positive and not halved by the step, the series small, the correction's own remainder below a fraction of
//! a picometre (single precision: of a nanometre), the foot inside the span. Two plain Newton steps would not do: they leave
//! more than a femtometre in some five per cent of queries.

use super::span::{Form, Span, dot, mad};
use crate::position::Position;
use crate::real::Real;

/// A foot point on a span.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot<R> {
    pub(super) t: R,
    /// From the point to the curve, mm.
    pub(super) vector: [R; 3],
    /// Derivative of the curve there, mm.
    pub(super) tangent: [R; 3],
    /// The remaining g is rounding, and the foot is a minimum inside the span.
    pub(super) trusted: bool,
    /// The foot is a minimum, inside the span or not.
    pub(super) converged: bool,
}

/// Reciprocal of the remainder along the path that counts as rounding: 1e-12 mm (single precision: 3e-7 mm).
#[cfg_attr(feature = "fast", inline(always))]
fn per_tolerance<R: Real>() -> R {
    if R::EPSILON.to_f64() < 1e-10 { R::of(1e12) } else { R::of(3.162_277_660_168_379e6) }
}

/// Finds the foot near `guess`; `point` is relative to the span's origin.
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn foot<R: Real, P: Position>(span: &Span<R, P>, point: &[R; 3], guess: R) -> Foot<R> {
    match span.form() {
        Form::Cubic => cubic::<R, false>(&span.coefficients, point, guess),
        Form::RationalCubic => cubic::<R, true>(&span.coefficients, point, guess),
        Form::Quintic => quintic::<R, false>(&span.coefficients, point, guess),
        Form::RationalQuintic => quintic::<R, true>(&span.coefficients, point, guess),
    }
}

impl<R: Real, P: Position> Span<R, P> {
    /// Finds the foot of `point` (mm) near the parameter `guess` with the search kernel alone: returns its parameter, and
    /// actual − foot.
    ///
    /// `None` if the kernel's own test does not trust the result: the guess is too far off, the foot lies beyond an end, or a
    /// maximum is near. [`super::ContourSearch`] brackets in these cases.
    #[cfg_attr(feature = "fast", inline(always))]
    #[doc(hidden)]
    pub fn foot_near(&self, point: &[P; 3], guess: R) -> Option<(R, R::Vec3)> {
        let foot = foot(self, &self.relative(point), guess);
        foot.trusted.then(|| (foot.t, foot.vector.map(|x| -x).into()))
    }
}

/// Not inlined: inlined into a caller's loop it runs slower.
#[inline(never)]
fn cubic<R: Real, const RATIONAL: bool>(c: &[[R; 4]; 6], point: &[R; 3], t: R) -> Foot<R> {
    solve::<R, RATIONAL, 4>(shifted_cubic::<R, RATIONAL>(c, t), point, t)
}

#[inline(never)]
fn quintic<R: Real, const RATIONAL: bool>(c: &[[R; 4]; 6], point: &[R; 3], t: R) -> Foot<R> {
    solve::<R, RATIONAL, 6>(shifted_quintic::<R, RATIONAL>(c, t), point, t)
}

/// Polynomial coefficients about `t`.
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn shifted_cubic<R: Real, const RATIONAL: bool>([c0, c1, c2, c3, ..]: &[[R; 4]; 6], t: R) -> [[R; 4]; 4] {
    let p2 = horner::<R, RATIONAL>(c2, t, c3);
    let p1 = horner::<R, RATIONAL>(c1, t, &p2);
    let p0 = horner::<R, RATIONAL>(c0, t, &p1);
    let q2 = horner::<R, RATIONAL>(&p2, t, c3);
    let q1 = horner::<R, RATIONAL>(&p1, t, &q2);
    let r2 = horner::<R, RATIONAL>(&q2, t, c3);
    [p0, q1, r2, *c3]
}

/// Polynomial coefficients about `t`.
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn shifted_quintic<R: Real, const RATIONAL: bool>(c: &[[R; 4]; 6], t: R) -> [[R; 4]; 6] {
    let mut shifted = *c;
    // Taylor shift by synthetic division: fifteen steps in a triangle.
    let [s0, s1, s2, s3, s4, s5] = &mut shifted;
    *s4 = horner::<R, RATIONAL>(s4, t, s5);
    *s3 = horner::<R, RATIONAL>(s3, t, s4);
    *s2 = horner::<R, RATIONAL>(s2, t, s3);
    *s1 = horner::<R, RATIONAL>(s1, t, s2);
    *s0 = horner::<R, RATIONAL>(s0, t, s1);
    *s4 = horner::<R, RATIONAL>(s4, t, s5);
    *s3 = horner::<R, RATIONAL>(s3, t, s4);
    *s2 = horner::<R, RATIONAL>(s2, t, s3);
    *s1 = horner::<R, RATIONAL>(s1, t, s2);
    *s4 = horner::<R, RATIONAL>(s4, t, s5);
    *s3 = horner::<R, RATIONAL>(s3, t, s4);
    *s2 = horner::<R, RATIONAL>(s2, t, s3);
    *s4 = horner::<R, RATIONAL>(s4, t, s5);
    *s3 = horner::<R, RATIONAL>(s3, t, s4);
    *s4 = horner::<R, RATIONAL>(s4, t, s5);
    shifted
}

/// `a + t b`, skipping the weights if they are constant.
#[cfg_attr(feature = "fast", inline(always))]
fn horner<R: Real, const RATIONAL: bool>(a: &[R; 4], t: R, b: &[R; 4]) -> [R; 4] {
    let lane = |k: usize| a[k].add_product(t, b[k]);
    if RATIONAL { mad(a, t, b) } else { [lane(0), lane(1), lane(2), R::ZERO] }
}

/// The step and its correction from the C coefficients about the guess.
#[cfg_attr(feature = "fast", inline(always))]
fn solve<R: Real, const RATIONAL: bool, const C: usize>(s: [[R; 4]; C], p: &[R; 3], t: R) -> Foot<R> {
    let (x, w) = homogeneous::<R, RATIONAL, C>(&s, p);
    let Some(step) = third_order::<R, RATIONAL, C>(&x, &w) else { return unconverged(t) };
    let taylor = Taylor::at::<RATIONAL, C>(&x, &w, step.h);
    taylor.correct::<RATIONAL>(&step, t)
}

/// x = shifted − w p; with weight 1 only the constant term changes.
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn homogeneous<R: Real, const RATIONAL: bool, const C: usize>(
    s: &[[R; 4]; C],
    p: &[R; 3],
) -> ([[R; 3]; C], [R; C]) {
    let mut x = [[R::ZERO; 3]; C];
    let mut w = [R::ZERO; C];
    for (k, ((x, w), s)) in x.iter_mut().zip(&mut w).zip(s).enumerate() {
        if RATIONAL {
            *x = [s[0] - p[0] * s[3], s[1] - p[1] * s[3], s[2] - p[2] * s[3]];
            *w = s[3];
        } else if k == 0 {
            *x = [s[0] - p[0], s[1] - p[1], s[2] - p[2]];
        } else {
            *x = [s[0], s[1], s[2]];
        }
    }
    (x, w)
}

/// The third-order step h from g's series, with the quantities that the trust test needs.
pub(super) struct Step<R> {
    pub(super) h: R,
    pub(super) u: R,
    pub(super) uy: R,
    /// g'.
    pub(super) g1: R,
    /// x·x'' + x'·x' at the guess.
    s2: R,
    w0: R,
    sane: bool,
}

#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn third_order<R: Real, const RATIONAL: bool, const C: usize>(
    x: &[[R; 3]; C],
    w: &[R; C],
) -> Option<Step<R>> {
    let (one, two, three) = (R::ONE, R::TWO, R::THREE);
    let ([a, b, d, e, ..], [w0, w1, w2, w3, ..]) = (&x[..], &w[..]) else { return None };
    let (w0, w1, w2, w3) = (*w0, *w1, *w2, *w3);
    let s1 = dot(a, b);
    let ad = dot(a, d);
    let s2 = dot(b, b) + (ad + ad);
    let s3 = dot(a, e) + dot(b, d);
    let (mut g0, mut g1, mut g2) = (s1, s2, three * s3);
    if RATIONAL {
        let s0 = dot(a, a);
        g0 = s1 * w0 - s0 * w1;
        g1 = s2 * w0 - (s1 * w1 + two * (s0 * w2));
        g2 = three * (s3 * w0 - (s1 * w2 + s0 * w3));
    }
    let inverse = one / g1;
    let y = -(g0 * inverse);
    let u = g2 * inverse;
    let uy = u * y;
    let h = y - y * uy * (one - (uy + uy));
    Some(Step { h, u, uy, g1, s2, w0, sane: g1 > R::ZERO && uy.abs() < R::of(0.2) })
}

/// Exact value, derivative and half the second derivative of x and w at the step.
pub(super) struct Taylor<R> {
    pub(super) r: [R; 3],
    pub(super) v: [R; 3],
    pub(super) z: [R; 3],
    pub(super) rw: R,
    pub(super) vw: R,
    pub(super) zw: R,
}

/// Value, derivative and half the second derivative of a cubic or quintic at h, without redundant multiplications.
#[cfg_attr(feature = "fast", inline(always))]
fn series<R: Real, const C: usize>(c: &[R; C], h: R) -> [R; 3] {
    match &c[..] {
        [a, b, d, e] => {
            let z = d.add_product(R::THREE * h, *e);
            [a.add_product(h, b.add_product(h, d.add_product(h, *e))), b.add_product(h, *d + z), z]
        }
        [c0, c1, c2, c3, c4, c5] => {
            // Horner's scheme three times, each on the sums of the previous one.
            let p4 = *c4 + h * *c5;
            let p3 = *c3 + h * p4;
            let p2 = *c2 + h * p3;
            let p1 = *c1 + h * p2;
            let q4 = p4 + h * *c5;
            let q3 = p3 + h * q4;
            let q2 = p2 + h * q3;
            [*c0 + h * p1, p1 + h * q2, q2 + h * (q3 + h * (q4 + h * *c5))]
        }
        _ => [R::ZERO; 3],
    }
}

impl<R: Real> Taylor<R> {
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn at<const RATIONAL: bool, const C: usize>(x: &[[R; 3]; C], w: &[R; C], h: R) -> Self {
        let [mut r, mut v, mut z] = [[R::ZERO; 3]; 3];
        for (k, ((r, v), z)) in r.iter_mut().zip(&mut v).zip(&mut z).enumerate() {
            [*r, *v, *z] = series(&x.map(|x| x[k]), h);
        }
        let [rw, vw, zw] = if RATIONAL { series(w, h) } else { [R::ONE, R::ZERO, R::ZERO] };
        Taylor { r, v, z, rw, vw, zw }
    }

    /// Applies one Newton correction after the step from `t` and tests whether the result can be trusted.
    #[cfg_attr(feature = "fast", inline(always))]
    fn correct<const RATIONAL: bool>(&self, step: &Step<R>, t: R) -> Foot<R> {
        let Taylor { r, v, z, rw, vw, zw } = self;
        let (one, two) = (R::ONE, R::TWO);
        let rv = dot(r, v);
        let rz = dot(r, z);
        let (mut g, mut slope) = (rv, dot(v, v) + (rz + rz));
        if RATIONAL {
            let rr = dot(r, r);
            g = rv * *rw - rr * *vw;
            slope = slope * *rw - (rv * *vw + two * (rr * *zw));
        }
        let correction = -g / slope;
        // In units of the tolerance: the square of the remainder itself would be subnormal in single precision, which costs a
        // host some hundred cycles.
        let left = (step.u * per_tolerance::<R>()) * (correction * correction);
        let unit = if RATIONAL { step.w0 * step.w0 } else { one };
        let converged = step.sane && slope > R::HALF * step.g1 && left * left * step.s2.abs() < unit;

        let (mut vector, mut tangent) = ([R::ZERO; 3], [R::ZERO; 3]);
        let weight = if RATIONAL { one / (*rw + correction * (*vw + correction * *zw)) } else { one };
        // Uses the tangent before the correction, which hardly turns it.
        let weight_rate = if RATIONAL { *vw } else { R::ZERO };
        for k in 0..3 {
            vector[k] = r[k].add_product(correction, v[k].add_product(correction, z[k]));
            tangent[k] = v[k];
            if RATIONAL {
                vector[k] = vector[k] * weight;
                // (x/w)' = (x' − x w'/w)/w
                tangent[k] = (tangent[k] - vector[k] * weight_rate) * weight;
            }
        }
        let t = t + step.h + correction;
        let trusted = converged && t.is_in_unit();
        Foot { t, vector, tangent, trusted, converged }
    }
}

fn unconverged<R: Real>(t: R) -> Foot<R> {
    Foot { t, vector: [R::ZERO; 3], tangent: [R::ZERO; 3], trusted: false, converged: false }
}

/// One evaluation for the bracketed search: g, its derivative, and the vectors at that point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evaluation<R> {
    /// Has the sign of the distance's derivative; zero at a foot.
    pub(super) g: R,
    /// Derivative of g.
    pub(super) slope: R,
    /// Derivative of g for a straight tangent: positive, so that its step always goes downhill.
    pub(super) straight: R,
    /// From the point to the curve, mm.
    pub(super) vector: [R; 3],
    /// Derivative of the curve, mm.
    pub(super) tangent: [R; 3],
    /// Half the second derivative, mm.
    pub(super) bend: [R; 3],
}

/// Evaluates a span of any form at `t`.
#[inline(never)]
pub(super) fn evaluate<R: Real, P: Position>(span: &Span<R, P>, point: &[R; 3], t: R) -> Evaluation<R> {
    evaluated(span, point, t)
}

/// Inlined version of [`evaluate`].
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn evaluated<R: Real, P: Position>(span: &Span<R, P>, point: &[R; 3], t: R) -> Evaluation<R> {
    let [c0, c1, c2, c3, c4, c5] = &span.coefficients;
    // Horner's scheme for value (p), first (q) and half second derivative (r), from the third power down.
    let (p3, q3, r2) = match span.form() {
        Form::Cubic | Form::RationalCubic => (*c3, *c3, *c3),
        Form::Quintic | Form::RationalQuintic => {
            let p4 = mad(c4, t, c5);
            let p3 = mad(c3, t, &p4);
            let q4 = mad(&p4, t, c5);
            let q3 = mad(&p3, t, &q4);
            (p3, q3, mad(&q3, t, &mad(&q4, t, c5)))
        }
    };
    let p2 = mad(c2, t, &p3);
    let p1 = mad(c1, t, &p2);
    let q2 = mad(&p2, t, &q3);
    projected(&mad(c0, t, &p1), &mad(&p1, t, &q2), &mad(&q2, t, &r2), point)
}

/// [`evaluate`] at an end of a span, bit for bit, without its products: at t = 0 the coefficients, at t = 1 sums of them.
#[inline(never)]
pub(super) fn evaluate_end<R: Real, P: Position>(span: &Span<R, P>, point: &[R; 3], at_start: bool) -> Evaluation<R> {
    let [c0, c1, c2, c3, c4, c5] = &span.coefficients;
    let (x, v, z);
    if at_start {
        (x, v, z) = (*c0, *c1, *c2);
    } else {
        // `evaluated` with t = 1.
        let (p3, q3, r2) = match span.form() {
            Form::Cubic | Form::RationalCubic => (*c3, *c3, *c3),
            Form::Quintic | Form::RationalQuintic => {
                let p4 = sum(c4, c5);
                let p3 = sum(c3, &p4);
                let q4 = sum(&p4, c5);
                let q3 = sum(&p3, &q4);
                (p3, q3, sum(&q3, &sum(&q4, c5)))
            }
        };
        let p2 = sum(c2, &p3);
        let p1 = sum(c1, &p2);
        let q2 = sum(&p2, &q3);
        (x, v, z) = (sum(c0, &p1), sum(&p1, &q2), sum(&q2, &r2));
    }
    match span.form() {
        // With weight 1 the projection changes nothing.
        Form::Cubic | Form::Quintic => {
            let [[x, y, z, _], [vx, vy, vz, _], [zx, zy, zz, _]] = [x, v, z];
            Evaluation::of([x - point[0], y - point[1], z - point[2]], [vx, vy, vz], [zx, zy, zz])
        }
        Form::RationalCubic | Form::RationalQuintic => projected(&x, &v, &z, point),
    }
}

#[cfg_attr(feature = "fast", inline(always))]
fn sum<R: Real>(a: &[R; 4], b: &[R; 4]) -> [R; 4] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}

/// Evaluation from the homogeneous position, first and half second derivative of the curve.
#[cfg_attr(feature = "fast", inline(always))]
fn projected<R: Real>(x: &[R; 4], v: &[R; 4], z: &[R; 4], point: &[R; 3]) -> Evaluation<R> {
    // Projected: position, first and half second derivative of x/w.
    let i = R::ONE / x[3];
    let (mut vector, mut tangent, mut bend) = ([R::ZERO; 3], [R::ZERO; 3], [R::ZERO; 3]);
    for k in 0..3 {
        let place = x[k] * i;
        vector[k] = place - point[k];
        tangent[k] = (v[k] - place * v[3]) * i;
        bend[k] = (z[k] - place * z[3] - tangent[k] * v[3]) * i;
    }
    Evaluation::of(vector, tangent, bend)
}

impl<R: Real> Evaluation<R> {
    #[cfg_attr(feature = "fast", inline(always))]
    fn of(vector: [R; 3], tangent: [R; 3], bend: [R; 3]) -> Self {
        let straight = dot(&tangent, &tangent);
        let curved = dot(&vector, &bend);
        Evaluation { g: dot(&vector, &tangent), slope: straight + (curved + curved), straight, vector, tangent, bend }
    }
}
