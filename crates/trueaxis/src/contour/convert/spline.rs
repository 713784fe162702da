//! Converts splines to spans: Bézier parts, halved until they are short and straight enough.

use super::{DVec3, MOST, Maker, PathError, Piece, REACH, SAME_POINT, TOO_MANY, TURN, finite, refuse};
use crate::contour::span::{Form, Span};
use crate::position::Position;
use crate::real::Real;

/// Largest ratio between weights: beyond it a light point hardly shapes the curve.
const WEIGHTS: f64 = 1e6;
/// Smallest weight: products of smaller ones underflow.
const LEAST_WEIGHT: f64 = 1e-9;
/// Shortest domain: the parameter has too few values to halve a shorter one.
const LEAST_DOMAIN: f64 = 1e-100;
/// Most halvings of a spline because of its turn; at a cusp, halving never reduces the turn.
const HALVINGS: u32 = 24;
/// Most halvings of a spline because of its reach: its parameter has no finer steps.
const FINEST: u32 = 48;
/// Largest ratio between the speed at an end of a spline span and its mean.
const UNEVEN: f64 = 1.5;
/// Number of halvings that enforce [`UNEVEN`]: at a point without speed the ratio always exceeds it. Between very
/// different weights the curve covers most of its length in a sliver of the parameter, which takes more halvings to
/// reach.
const EVENING: u32 = 8;
const EVENING_WEIGHTS: u32 = 28;

impl<R: Real, P: Position, S: FnMut(Span<R, P>) -> Result<(), PathError>> Maker<'_, R, P, S> {
    pub(super) fn nurbs(
        &mut self,
        degree: usize,
        knots: &[f64],
        points: &[DVec3],
        weights: &[f64],
    ) -> Result<(), PathError> {
        if !(1..=5).contains(&degree) {
            return refuse("degree", None, degree as f64, "1 to 5");
        }
        if points.len() <= degree {
            return refuse("points", None, points.len() as f64, "more control points than the degree");
        }
        if knots.len() != points.len() + degree + 1 {
            return refuse("knots", None, knots.len() as f64, "as many knots as control points, degree and one");
        }
        if !weights.is_empty() && weights.len() != points.len() {
            return refuse("weights", None, weights.len() as f64, "as many weights as control points, or none");
        }
        for (i, point) in points.iter().enumerate() {
            finite("points", *point).map_err(|error| PathError { index: Some(i), ..error })?;
        }
        let heaviest = weights.iter().copied().fold(0.0, f64::max);
        for (i, weight) in weights.iter().enumerate() {
            if !(*weight > 0.0 && *weight < 1e9) {
                return refuse("weights", Some(i), *weight, "positive finite weights");
            }
            if *weight < LEAST_WEIGHT {
                return refuse("weights", Some(i), *weight, "weights of at least 1e-9");
            }
            if *weight * WEIGHTS < heaviest {
                return refuse("weights", Some(i), *weight, "weights within a factor of 1e6 of one another");
            }
        }
        for (i, knot) in knots.iter().enumerate() {
            let before = if i == 0 { *knot } else { knots[i - 1] };
            if !knot.is_usable() || *knot < before {
                return refuse("knots", Some(i), *knot, "finite ascending knots");
            }
        }
        if knots[points.len()] - knots[degree] < LEAST_DOMAIN {
            return refuse("knots", Some(points.len()), knots[points.len()], "a domain longer than 1e-100");
        }
        for i in degree..points.len() {
            // A knot within an inner run longer than `degree` breaks the curve.
            if i > degree && knots[i + degree] - knots[i] <= 0.0 && i + degree < knots.len() - 1 {
                return refuse("knots", Some(i), knots[i], "inner knots of at most the degree's multiplicity");
            }
        }
        let rational = weights.iter().any(|w| *w != weights[0]);
        for i in degree..points.len() {
            let u = [knots[i], knots[i + 1]];
            if u[1] <= u[0] {
                continue;
            }
            let origin = points[i - degree / 2];
            let control = |j: usize| {
                let w = if rational { weights[j] } else { 1.0 };
                let p = points[j] - origin;
                [p[0] * w, p[1] * w, p[2] * w, w]
            };
            let mut bezier = [[0.0; 4]; 6];
            for (j, to) in bezier.iter_mut().enumerate().take(degree + 1) {
                *to = blossom(degree, knots, i, control, u, j);
            }
            // The chord over a span's length is a lower bound on the spans: a spline can be refused without splitting it.
            let ends = [bezier[0], bezier[degree]].map(point);
            let chord = ends[1].distance(ends[0]);
            if chord > 2.0 * REACH * f64::from(MOST) {
                return refuse("points", Some(i), chord, TOO_MANY);
            }
            self.split(&Bezier { degree, points: bezier, origin, u, rational }, 0)?;
        }
        Ok(())
    }

    /// Halves a Bézier part until it is short and straight enough; `FINEST` bounds the recursion.
    fn split(&mut self, bezier: &Bezier, depth: u32) -> Result<(), PathError> {
        let Shape { middle, far, turn, uneven } = bezier.shape();
        if far > REACH && depth == FINEST {
            return refuse("points", None, far, "a spline whose speed is not concentrated in a single point");
        }
        let evening = if bezier.rational { EVENING_WEIGHTS } else { EVENING };
        if far > REACH || (turn > TURN && depth < HALVINGS) || (uneven && depth < evening) {
            let [left, right] = bezier.halves();
            self.split(&left, depth + 1)?;
            return self.split(&right, depth + 1);
        }
        self.count += 1;
        if self.count > MOST {
            return refuse("points", None, f64::from(self.count), TOO_MANY);
        }
        if self.counting {
            return Ok(());
        }
        self.emit(bezier.piece(middle))
    }
}

/// A homogeneous control point in space.
fn point(b: [f64; 4]) -> DVec3 {
    DVec3::new(b[0] / b[3], b[1] / b[3], b[2] / b[3])
}

/// Homogeneous control points of a polynomial part of a spline, relative to `origin`.
struct Bezier {
    degree: usize,
    points: [[f64; 4]; 6],
    origin: DVec3,
    u: [f64; 2],
    rational: bool,
}

/// Deviation of a spline part from a single span.
struct Shape {
    middle: DVec3,
    /// Distance of the farthest control point from the middle, mm.
    far: f64,
    /// Turn of the control polygon, rad.
    turn: f64,
    /// Whether the speeds at the ends differ too much from the mean for the cubic of the arc length.
    uneven: bool,
}

impl Bezier {
    /// Control point `j`.
    fn hull(&self, j: usize) -> DVec3 {
        point(self.points[j])
    }

    fn shape(&self) -> Shape {
        let (degree, b) = (self.degree, &self.points);
        let hull = |j: usize| self.hull(j);
        let middle = (hull(0) + hull(degree)) * 0.5;
        let far = (0..=degree).map(|j| hull(j).distance(middle)).fold(0.0, f64::max);
        let mut turn = 0.0;
        let mut last = None::<DVec3>;
        for j in 0..degree {
            let leg = hull(j + 1) - hull(j);
            if leg.length() < SAME_POINT {
                continue;
            }
            if let Some(last) = last {
                turn += libm::atan2(last.cross(leg).length(), last.dot(leg));
            }
            last = Some(leg);
        }
        let ends =
            [(b[1][3] / b[0][3], hull(0), hull(1)), (b[degree - 1][3] / b[degree][3], hull(degree - 1), hull(degree))];
        let mean = hull(degree).distance(hull(0));
        let uneven = ends.into_iter().any(|(w, from, to)| {
            let speed = degree as f64 * w * to.distance(from);
            speed > UNEVEN * mean || mean > UNEVEN * speed
        });
        Shape { middle, far, turn, uneven }
    }

    /// Both halves, by de Casteljau's algorithm.
    fn halves(&self) -> [Bezier; 2] {
        let degree = self.degree;
        let (mut left, mut right, mut row) = ([[0.0; 4]; 6], [[0.0; 4]; 6], self.points);
        for level in 0..=degree {
            left[level] = row[0];
            right[degree - level] = row[degree - level];
            for j in 0..degree - level {
                row[j] = core::array::from_fn(|k| 0.5 * (row[j][k] + row[j + 1][k]));
            }
        }
        let half = 0.5 * (self.u[0] + self.u[1]);
        [
            Bezier { points: left, u: [self.u[0], half], ..*self },
            Bezier { points: right, u: [half, self.u[1]], ..*self },
        ]
    }

    /// Moves the origin to the middle and converts from Bernstein to power basis: c_k = C(n,k) Δ^k b_0; scales the weights to
    /// about 1.
    fn piece(&self, middle: DVec3) -> Piece {
        let Bezier { degree, points: ref b, origin, u, rational } = *self;
        let scale = 1.0 / b[0][3];
        let mut difference = [[0.0; 4]; 6];
        for (to, from) in difference.iter_mut().zip(b).take(degree + 1) {
            *to = core::array::from_fn(|k| scale * if k < 3 { from[k] - middle[k] * from[3] } else { from[3] });
        }
        let mut coefficients = [[0.0; 4]; 6];
        let mut binomial = 1.0;
        for power in 0..=degree {
            coefficients[power] = difference[0].map(|c| c * binomial);
            binomial *= (degree - power) as f64 / (power + 1) as f64;
            for j in 0..degree - power {
                difference[j] = core::array::from_fn(|k| difference[j + 1][k] - difference[j][k]);
            }
        }
        if !rational {
            for (power, c) in coefficients.iter_mut().enumerate() {
                c[3] = if power == 0 { 1.0 } else { 0.0 };
            }
        }
        let form = match (degree <= 3, rational) {
            (true, false) => Form::Cubic,
            (true, true) => Form::RationalCubic,
            (false, false) => Form::Quintic,
            (false, true) => Form::RationalQuintic,
        };
        Piece { origin: origin + middle, coefficients, form, u, quarter_tangent: 0.0 }
    }
}

/// Bézier point `j` of knot span `i`: the blossom at `degree − j` times the span's start and `j` times its end.
fn blossom(
    degree: usize,
    knots: &[f64],
    i: usize,
    control: impl Fn(usize) -> [f64; 4],
    u: [f64; 2],
    j: usize,
) -> [f64; 4] {
    let mut d = [[0.0; 4]; 6];
    for (k, d) in d.iter_mut().enumerate().take(degree + 1) {
        *d = control(i - degree + k);
    }
    for r in 1..=degree {
        let at = if r <= j { u[1] } else { u[0] };
        for k in (r..=degree).rev() {
            let (low, high) = (knots[i - degree + k], knots[i + 1 + k - r]);
            let a = (at - low) / (high - low);
            d[k] = core::array::from_fn(|c| (1.0 - a) * d[k - 1][c] + a * d[k][c]);
        }
    }
    d[degree]
}
