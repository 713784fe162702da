//! Feet of two neighbouring points on one span, from one shifted frame.
//!
//! The tip's foot comes from the kernel's method. The encoder lies d = tip − encoder from the tip, so in the same frame
//! its homogeneous vector is x + w d. A second-order step from the tip's foot and an exact Newton step give its foot.
//!
//! With T the path's derivative and u = g''/2g', a Newton step c leaves a remainder along the path of
//!
//! ```text
//! τ ≤ |T| c² (|u| + K)        K: bound of the change of u since the guess
//! ```
//!
//! and the distance e is then off by at most √(e² + τ²) − e, which is below ε exactly where τ² ≤ ε(ε + 2e). K is valid where
//! neither the path's second nor its third derivative is much larger than its first. The code tests that too, since u may be
//! small by chance, at an inflection or in the middle of an arc.

use crate::contour::kernel::{Taylor, homogeneous, shifted_cubic, shifted_quintic, third_order};
use crate::contour::span::{Form, Span, dot};
use crate::contour::way::sight;
use crate::contour::{ContourError, Flags};
use crate::position::Position;
use crate::real::Real;

/// Permitted error of the distance, mm: 1e-6 nm in doubles, 0.3 nm in single precision.
#[cfg_attr(feature = "fast", inline(always))]
fn tolerance<R: Real>() -> R {
    if R::EPSILON.to_f64() < 1e-10 { R::of(1e-12) } else { R::of(3e-7) }
}

/// K: large enough that |c|³ times the third derivative is below ε as well and need not be added to the vectors.
const CHANGE_OF_U: f64 = 16.0;

/// K as a scalar.
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn change_of_u<R: Real>() -> R {
    R::of(CHANGE_OF_U)
}

/// If |b × T|² is below this times |T|², the path runs along the plane's normal and b × T has no useful direction.
const UPRIGHT: f64 = 0.01;

/// Derivative of the path at the tip's foot, and its length.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tangent<R> {
    pub(super) tangent: [R; 3],
    pub(super) speed: R,
}

impl<R: Real> Tangent<R> {
    pub(super) const NONE: Self = Tangent { tangent: [R::ZERO; 3], speed: R::ZERO };
}

/// Which results of a frame are valid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seen(u8);

impl Seen {
    pub(super) const NOTHING: Self = Seen(0);
    const TIP: Self = Seen(1);
    const BOTH: Self = Seen(3);
    const PLAIN: Self = Seen(7);

    /// The tip's foot is an exact minimum of the distance, on the span or beyond it: parameter, vector and error are written,
    /// and the tangent unless all is plain.
    pub(super) const fn tip(self) -> bool {
        self.0 & 1 != 0
    }

    /// The encoder's foot is an exact minimum too, and its parameter, vector and error are written.
    pub(super) const fn encoder(self) -> bool {
        self.0 & 2 != 0
    }

    /// Both feet are clear of the span's borders and every other test passed: both errors are complete except for their spans.
    pub(super) const fn plain(self) -> bool {
        self.0 & 4 != 0
    }
}

/// Start of a cycle's search, and its limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start<R> {
    pub(super) guess: R,
    /// Arc length around the guess in which the tip's foot is expected, mm.
    pub(super) window: R,
    /// Arc length from the start of the span to the reference.
    pub(super) place: R,
    /// A foot farther than this from the reference is not plain.
    pub(super) max_lag: R,
}

impl<R: Real> Start<R> {
    /// A `max_lag` that no lag satisfies: the frame is never plain.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn never_plain() -> R {
        -R::ONE
    }
}

/// Finds the feet of an encoder position and of the tip, `d` (mm) from it.
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn feet<R: Real, P: Position>(
    span: &Span<R, P>,
    position: &[P; 3],
    d: &[R; 3],
    start: &Start<R>,
    tip: &mut ContourError<R>,
    encoder: &mut ContourError<R>,
    along: &mut Tangent<R>,
) -> Seen {
    match span.form() {
        Form::Cubic => cubic::<R, P, false>(span, position, d, start, tip, encoder, along),
        Form::RationalCubic => cubic::<R, P, true>(span, position, d, start, tip, encoder, along),
        Form::Quintic => quintic::<R, P, false>(span, position, d, start, tip, encoder, along),
        Form::RationalQuintic => quintic::<R, P, true>(span, position, d, start, tip, encoder, along),
    }
}

#[inline(never)]
fn cubic<R: Real, P: Position, const RATIONAL: bool>(
    span: &Span<R, P>,
    position: &[P; 3],
    d: &[R; 3],
    start: &Start<R>,
    tip: &mut ContourError<R>,
    encoder: &mut ContourError<R>,
    along: &mut Tangent<R>,
) -> Seen {
    let shifted = shifted_cubic::<R, RATIONAL>(&span.coefficients, start.guess);
    solve::<R, P, RATIONAL, 4>(&shifted, span, &local(span, position, d), d, start, tip, encoder, along)
}

#[inline(never)]
fn quintic<R: Real, P: Position, const RATIONAL: bool>(
    span: &Span<R, P>,
    position: &[P; 3],
    d: &[R; 3],
    start: &Start<R>,
    tip: &mut ContourError<R>,
    encoder: &mut ContourError<R>,
    along: &mut Tangent<R>,
) -> Seen {
    let shifted = shifted_quintic::<R, RATIONAL>(&span.coefficients, start.guess);
    solve::<R, P, RATIONAL, 6>(&shifted, span, &local(span, position, d), d, start, tip, encoder, along)
}

/// The tip relative to the span's origin: the encoder's offset is exact, so no position is rounded.
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn local<R: Real, P: Position>(span: &Span<R, P>, position: &[P; 3], d: &[R; 3]) -> [R; 3] {
    let [x, y, z] = span.relative(position);
    [x + d[0], y + d[1], z + d[2]]
}

/// Finds both feet in the frame that is shifted to the guess; writes what is valid.
#[cfg_attr(feature = "fast", inline(always))]
fn solve<R: Real, P: Position, const RATIONAL: bool, const C: usize>(
    shifted: &[[R; 4]; C],
    span: &Span<R, P>,
    p: &[R; 3],
    d: &[R; 3],
    start: &Start<R>,
    tip: &mut ContourError<R>,
    encoder: &mut ContourError<R>,
    along: &mut Tangent<R>,
) -> Seen {
    let (x, w) = homogeneous::<R, RATIONAL, C>(shifted, p);
    let Some(at_tip) = AtTip::find::<RATIONAL, C>(&x, &w, start.guess) else { return Seen::NOTHING };
    at_tip.foot.write(tip);
    let at_encoder = at_tip.step_to_encoder::<RATIONAL, C>(&x, &w, d, &span.plane);
    at_encoder.foot.write(encoder);

    let (found, other, speed) = (&at_tip.foot, &at_encoder.foot, at_tip.speed);
    let length = Length::of(span);
    let room = length.half - sight(start.window, found.error.max(other.error));
    let (lag, behind) = (start.place - length.to(found.t), start.place - length.to(other.t));
    let plain = at_encoder.exact
        && length.off_middle(found.t) < room
        && length.off_middle(other.t) < room
        && found.t.is_in_unit()
        && other.t.is_in_unit()
        && (found.t - start.guess).abs() * speed <= start.window
        && lag.abs() <= start.max_lag
        && at_encoder.across_square > R::of(UPRIGHT) * at_tip.squared;
    // The next cycle needs the speed even if this one is not plain.
    along.speed = speed;
    if !plain {
        along.tangent = at_tip.tangent;
        return if at_encoder.exact { Seen::BOTH } else { Seen::TIP };
    }
    write_components(&at_tip, &at_encoder, &span.plane, tip, encoder);
    (tip.lag, encoder.lag) = (lag, behind);
    for (foot, evaluations) in [(tip, 2), (encoder, 1)] {
        (foot.tangential, foot.width) = (R::ZERO, R::ZERO);
        (foot.evaluations, foot.flags) = (evaluations, Flags::BRACKETED);
    }
    Seen::PLAIN
}

/// Splits both errors into their components in the frame of the tip's foot.
#[cfg_attr(feature = "fast", inline(always))]
fn write_components<R: Real>(
    at_tip: &AtTip<R>,
    at_encoder: &AtEncoder<R>,
    plane: &[R; 3],
    tip: &mut ContourError<R>,
    encoder: &mut ContourError<R>,
) {
    let (found, other, n) = (&at_tip.foot, &at_encoder.foot, &at_encoder.n);
    // With e at right angles to T, e·(T × n)/|T||n| = (e·b)|T|/|n|. The vectors here are −e.
    let inverse = R::ONE / at_encoder.across;
    let stretch = at_tip.speed * inverse;
    tip.normal = -(dot(&found.vector, n) * inverse);
    tip.binormal = -(dot(&found.vector, plane) * stretch);
    // The path turns slightly on the way to the encoder's foot: the in-plane component is the remainder of the
    // distance.
    let binormal = -(dot(&other.vector, plane) * stretch);
    let normal = (other.error * other.error - binormal * binormal).sqrt();
    encoder.binormal = binormal;
    encoder.normal = if dot(&other.vector, n) > R::ZERO { -normal } else { normal };
}

/// The tip's foot, and what the step from there to the encoder's foot needs.
struct AtTip<R> {
    foot: Point<R>,
    /// Parameter from the guess.
    h: R,
    /// The path's direction before the last correction, which turns it by less than 1e-4; |T|² and |T|.
    tangent: [R; 3],
    squared: R,
    speed: R,
    /// g', and the least one that is trusted.
    slope: R,
    least: R,
    /// Reciprocal of the weight, and the weight's derivative: of a rational span.
    weight: R,
    rate: R,
    /// u, and the bound of |u| from the guess to here.
    u: R,
    change: R,
}

impl<R: Real> AtTip<R> {
    /// The tip's foot from the C coefficients about the guess; `None` if it is not exact.
    #[cfg_attr(feature = "fast", inline(always))]
    fn find<const RATIONAL: bool, const C: usize>(x: &[[R; 3]; C], w: &[R; C], guess: R) -> Option<Self> {
        let step = third_order::<R, RATIONAL, C>(x, w)?;
        let ([_, _, bend, twist, ..], [w0, w1, w2, w3, ..]) = (&x[..], &w[..]) else { return None };
        // Compares the second and third derivatives with the first: |d|² + |e|² must be below a few |b|², and the weights
        // likewise. This implies that g' is positive.
        let mut uneven = dot(bend, bend) + dot(twist, twist);
        if RATIONAL {
            uneven = uneven * *w0 + step.g1 * (*w1 * *w1 + *w2 * *w2 + *w3 * *w3);
        }
        let at = Taylor::at::<RATIONAL, C>(x, w, step.h);
        let Newton { correction, slope, weight, vector } = Newton::from::<RATIONAL>(&at);
        let (mut tangent, rate) = (at.v, at.vw);
        if RATIONAL {
            for k in 0..3 {
                tangent[k] = (tangent[k] - vector[k] * rate) * weight;
            }
        }
        let squared = dot(&tangent, &tangent);
        let least = R::HALF * step.g1;
        let change = step.u.abs() + change_of_u();
        let t = guess + step.h + correction;
        let [error, speed] = R::roots([dot(&vector, &vector), squared]);
        let exact = uneven < R::of(4.0) * step.g1
            && step.uy.abs() < R::of(0.2)
            && slope > least
            && leaves_nothing(correction, error, change, squared);
        exact.then(|| AtTip {
            foot: Point { t, vector, error },
            h: step.h + correction,
            tangent,
            squared,
            speed,
            slope,
            least,
            weight,
            rate,
            u: step.u,
            change,
        })
    }

    /// The encoder's foot: g at the tip's foot is d·T, with the same derivative as for the tip.
    #[cfg_attr(feature = "fast", inline(always))]
    fn step_to_encoder<const RATIONAL: bool, const C: usize>(
        &self,
        x: &[[R; 3]; C],
        w: &[R; C],
        d: &[R; 3],
        plane: &[R; 3],
    ) -> AtEncoder<R> {
        let off = dot(d, &self.tangent);
        let mut slope = self.slope;
        if RATIONAL {
            let weight_rate = self.rate * self.weight;
            slope = slope * self.weight * self.weight * self.weight + R::THREE * weight_rate * off;
        }
        let y = -(off / slope);
        let y = y - self.u * y * y;
        let mut at = Taylor::at::<RATIONAL, C>(x, w, self.h + y);
        for k in 0..3 {
            if RATIONAL {
                at.r[k] += at.rw * d[k];
                at.v[k] += at.vw * d[k];
                at.z[k] += at.zw * d[k];
            } else {
                at.r[k] += d[k];
            }
        }
        let Newton { correction, slope, vector, .. } = Newton::from::<RATIONAL>(&at);
        let n = cross(plane, &self.tangent);
        let across_square = dot(&n, &n);
        let [error, across] = R::roots([dot(&vector, &vector), across_square]);
        let exact = slope > self.least && leaves_nothing(correction, error, self.change, self.squared);
        AtEncoder { foot: Point { t: self.foot.t + y + correction, vector, error }, exact, n, across_square, across }
    }
}

/// The encoder's foot.
struct AtEncoder<R> {
    foot: Point<R>,
    /// Whether it is an exact minimum.
    exact: bool,
    /// b × T at the tip's foot; its squared length and length.
    n: [R; 3],
    across_square: R,
    across: R,
}

#[cfg_attr(feature = "fast", inline(always))]
fn cross<R: Real>(a: &[R; 3], b: &[R; 3]) -> [R; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Arc lengths on a span.
struct Length<'a, R> {
    arc: &'a [R; 3],
    half: R,
}

impl<'a, R: Real> Length<'a, R> {
    #[cfg_attr(feature = "fast", inline(always))]
    fn of<P: Position>(span: &'a Span<R, P>) -> Self {
        Length { arc: &span.arc, half: R::HALF * span.length() }
    }

    /// From the start to t.
    #[cfg_attr(feature = "fast", inline(always))]
    fn to(&self, t: R) -> R {
        let [a, b, c] = *self.arc;
        t * (a + t * (b + t * c))
    }

    #[cfg_attr(feature = "fast", inline(always))]
    fn off_middle(&self, t: R) -> R {
        (self.to(t) - self.half).abs()
    }
}

/// A foot: its parameter, the vector from the point to the curve, and the distance.
struct Point<R> {
    t: R,
    vector: [R; 3],
    error: R,
}

impl<R: Real> Point<R> {
    #[cfg_attr(feature = "fast", inline(always))]
    fn write(&self, foot: &mut ContourError<R>) {
        foot.t = self.t;
        foot.vector = self.vector.map(|x| -x).into();
        foot.error = self.error;
    }
}

/// An exact Newton step.
struct Newton<R> {
    correction: R,
    /// g'.
    slope: R,
    /// Reciprocal of the weight after the step.
    weight: R,
    /// From the point to the curve after the step, mm.
    vector: [R; 3],
}

impl<R: Real> Newton<R> {
    #[cfg_attr(feature = "fast", inline(always))]
    fn from<const RATIONAL: bool>(at: &Taylor<R>) -> Self {
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
        let weight = if RATIONAL { R::ONE / (*rw + c * (*vw + c * *zw)) } else { R::ONE };
        let mut vector = [R::ZERO; 3];
        for k in 0..3 {
            vector[k] = r[k].add_product(c, v[k].add_product(c, z[k]));
            if RATIONAL {
                vector[k] = vector[k] * weight;
            }
        }
        Newton { correction: c, slope, weight, vector }
    }
}

/// The trust test of a Newton step: `change` bounds |u| from the guess to here, `squared` is |T|².
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn leaves_nothing<R: Real>(correction: R, error: R, change: R, squared: R) -> bool {
    // Both sides are scaled by millions so that neither is subnormal in single precision, which costs a host some hundred
    // cycles.
    let left = change * R::of(1e6) * (correction * correction);
    left * left * squared <= tolerance::<R>() * R::of(1e12) * (tolerance::<R>() + error + error)
}
