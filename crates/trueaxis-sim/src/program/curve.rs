//! The curve of one move, evaluated in plain f64.
//!
//! This is the simulator's ground truth: contour errors are measured against these curves, so nothing here uses the code under
//! test.

use glam::DVec3;

use super::nurbs;

/// Position and derivatives with respect to the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivatives {
    /// C(u), mm.
    pub position: [f64; 3],
    /// C'(u), mm per unit of u.
    pub first: [f64; 3],
    /// C''(u), mm per unit of u squared.
    pub second: [f64; 3],
}

/// A programmed curve, mm.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// C(u) = start + u (end − start), u in 0..1.
    Line {
        /// Start point.
        start: [f64; 3],
        /// End point.
        end: [f64; 3],
    },
    /// Circular arc or helix, counter-clockwise about `normal`, u in 0..1 in proportion to the angle.
    ///
    /// The angle is that from start to end, in (0, 2π], plus `turns` full turns. Radius and height above the plane of the
    /// start vary linearly with u from their values at the start to those at the end.
    Arc {
        /// Start point.
        start: [f64; 3],
        /// End point.
        end: [f64; 3],
        /// A point of the axis.
        center: [f64; 3],
        /// Unit vector of the axis.
        normal: [f64; 3],
        /// Full turns beyond the first turn, which may be partial or full.
        turns: u32,
    },
    /// Rational B-spline Σ N_i(u) w_i P_i / Σ N_i(u) w_i, u in the knot domain knots\[degree\] .. knots\[points\].
    ///
    /// From G5.2/G5.3 as in LinuxCNC: the current point is the first control point (its weight is the P of a first line
    /// without X and Y, else 1), L is the order (degree + 1, default 3), and the knots are uniform and clamped: 0 repeated
    /// order times, then 1, 2, …, then points − order + 1 repeated order times. LinuxCNC approximates this curve by tangent
    /// arcs; here it is run exactly.
    Nurbs {
        /// Degree, 1 to [`MAX_DEGREE`](super::MAX_DEGREE).
        degree: usize,
        /// points + degree + 1 knots, non-decreasing.
        knots: Vec<f64>,
        /// Control points.
        points: Vec<[f64; 3]>,
        /// Positive weights, one per point.
        weights: Vec<f64>,
    },
}

/// Nodes and weights of the 8-point Gauss–Legendre rule on −1..1, positive half (Abramowitz and Stegun, table 25.4).
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Halving ends once one rule and two halves differ by less than this: relative, and absolute in mm, above the rounding of
/// |C'| where it nearly vanishes.
const RELATIVE_TOLERANCE: f64 = 1.0e-13;
const ABSOLUTE_TOLERANCE: f64 = 1.0e-12;
const DEEPEST_HALVING: u32 = 30;

/// A prepared arc: axes in its plane, angle, and the quantities that change along it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polar {
    center: DVec3,
    along: DVec3,
    across: DVec3,
    normal: DVec3,
    angle: f64,
    radius: f64,
    radius_change: f64,
    height: f64,
    height_change: f64,
}

impl Polar {
    fn new(start: [f64; 3], end: [f64; 3], center: [f64; 3], normal: [f64; 3], turns: u32) -> Polar {
        let (center, normal) = (DVec3::from(center), DVec3::from(normal));
        let from = DVec3::from(start) - center;
        let to = DVec3::from(end) - center;
        let (height, end_height) = (from.dot(normal), to.dot(normal));
        let (from, to) = (from - height * normal, to - end_height * normal);
        let radius = from.length();
        let along = from.normalize_or_zero();
        let across = normal.cross(along);
        let mut angle = libm::atan2(to.dot(across), to.dot(along));
        // An angle of zero, within the rounding of coordinates, means a full turn.
        if angle < 1.0e-12 {
            angle += std::f64::consts::TAU;
        }
        Polar {
            center,
            along,
            across,
            normal,
            angle: angle + f64::from(turns) * std::f64::consts::TAU,
            radius,
            radius_change: to.length() - radius,
            height,
            height_change: end_height - height,
        }
    }

    fn at(&self, u: f64) -> (DVec3, DVec3, DVec3) {
        let (sine, cosine) = libm::sincos(u * self.angle);
        let radial = cosine * self.along + sine * self.across;
        let tangent = cosine * self.across - sine * self.along;
        let radius = self.radius + u * self.radius_change;
        let (turn, grow) = (self.angle, self.radius_change);
        (
            self.center + radius * radial + (self.height + u * self.height_change) * self.normal,
            grow * radial + radius * turn * tangent + self.height_change * self.normal,
            2.0 * grow * turn * tangent - radius * turn * turn * radial,
        )
    }
}

impl Curve {
    /// First and last parameter.
    pub fn domain(&self) -> (f64, f64) {
        match self {
            Curve::Nurbs { degree, knots, points, .. } => {
                (knots.get(*degree).copied().unwrap_or(0.0), knots.get(points.len()).copied().unwrap_or(0.0))
            }
            _ => (0.0, 1.0),
        }
    }

    /// Parameters between which the curve is smooth: the ends of the domain and the inner knots, increasing.
    pub fn breaks(&self) -> Vec<f64> {
        let (first, last) = self.domain();
        let mut breaks = vec![first];
        if let Curve::Nurbs { knots, .. } = self {
            for &knot in knots {
                if knot > breaks.last().copied().unwrap_or(first) && knot < last {
                    breaks.push(knot);
                }
            }
        }
        breaks.push(last);
        breaks
    }

    /// C(u) in mm; u outside the domain continues the first or last polynomial.
    pub fn position(&self, u: f64) -> [f64; 3] {
        self.derivatives(u).position
    }

    /// C, C', C'' at u; at an inner knot, those of the polynomial after it.
    pub fn derivatives(&self, u: f64) -> Derivatives {
        let (position, first, second) = self.vectors(u);
        Derivatives { position: position.into(), first: first.into(), second: second.into() }
    }

    pub(crate) fn vectors(&self, u: f64) -> (DVec3, DVec3, DVec3) {
        self.vectors_by(self.polar().as_ref(), u)
    }

    /// Quantities that all points of an arc share, computed once; `None` for other curves.
    pub(crate) fn polar(&self) -> Option<Polar> {
        match self {
            Curve::Arc { start, end, center, normal, turns } => {
                Some(Polar::new(*start, *end, *center, *normal, *turns))
            }
            _ => None,
        }
    }

    /// [`Curve::vectors`] with the curve's own [`Curve::polar`].
    pub(crate) fn vectors_by(&self, polar: Option<&Polar>, u: f64) -> (DVec3, DVec3, DVec3) {
        match (self, polar) {
            (Curve::Line { start, end }, _) => {
                let (start, end) = (DVec3::from(*start), DVec3::from(*end));
                (start.lerp(end, u), end - start, DVec3::ZERO)
            }
            (Curve::Arc { .. }, Some(polar)) => polar.at(u),
            (Curve::Arc { start, end, center, normal, turns }, None) => {
                Polar::new(*start, *end, *center, *normal, *turns).at(u)
            }
            (Curve::Nurbs { degree, knots, points, weights }, _) => {
                nurbs::derivatives(*degree, knots, points, weights, u)
            }
        }
    }

    /// The point alone, equal in every bit to that of [`Curve::vectors_by`].
    pub(crate) fn point_by(&self, polar: Option<&Polar>, u: f64) -> DVec3 {
        match self {
            Curve::Nurbs { degree, knots, points, weights } => nurbs::point(*degree, knots, points, weights, u),
            _ => self.vectors_by(polar, u).0,
        }
    }

    /// κ = |C' × C''| / |C'|³ in 1/mm; infinite where C' vanishes.
    pub fn curvature(&self, u: f64) -> f64 {
        let (_, first, second) = self.vectors(u);
        let speed = first.length();
        if speed > 0.0 { first.cross(second).length() / (speed * speed * speed) } else { f64::INFINITY }
    }

    /// |C'(u)| in mm per unit of u.
    pub fn speed(&self, u: f64) -> f64 {
        self.vectors(u).1.length()
    }

    /// Length of the whole curve in mm; relative error below 1e-12 on regular curves.
    pub fn length(&self) -> f64 {
        self.breaks().windows(2).map(|piece| self.length_between(piece[0], piece[1])).sum()
    }

    /// Length in mm from u = a to b, signed, by Gauss–Legendre rules on halved intervals until they agree.
    ///
    /// Intended for intervals between knots; over several spans it is slower but as exact.
    pub fn length_between(&self, a: f64, b: f64) -> f64 {
        match self {
            Curve::Line { .. } => (b - a) * self.speed(0.0),
            _ => self.halved(a, b, self.gauss(a, b), DEEPEST_HALVING),
        }
    }

    fn gauss(&self, a: f64, b: f64) -> f64 {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        half * GAUSS
            .iter()
            .map(|(node, weight)| weight * (self.speed(middle - half * node) + self.speed(middle + half * node)))
            .sum::<f64>()
    }

    fn halved(&self, a: f64, b: f64, whole: f64, depth: u32) -> f64 {
        let middle = 0.5 * (a + b);
        let (left, right) = (self.gauss(a, middle), self.gauss(middle, b));
        let both = left + right;
        if depth == 0 || (both - whole).abs() <= ABSOLUTE_TOLERANCE + RELATIVE_TOLERANCE * both.abs() {
            return both;
        }
        self.halved(a, middle, left, depth - 1) + self.halved(middle, b, right, depth - 1)
    }

    /// The parameter at arc length s (mm) from the start, by Newton's method kept inside a bracket; s is limited to the
    /// length. Error below 1e-9 mm of arc. Slow: for occasional queries, not for a servo cycle.
    pub fn parameter_at(&self, s: f64) -> f64 {
        let breaks = self.breaks();
        let mut before = 0.0;
        for piece in breaks.windows(2) {
            let length = self.length_between(piece[0], piece[1]);
            if s <= before + length {
                return self.parameter_in(piece[0], piece[1], length, (s - before).max(0.0));
            }
            before += length;
        }
        self.domain().1
    }

    fn parameter_in(&self, a: f64, b: f64, length: f64, s: f64) -> f64 {
        if length <= 0.0 {
            return a;
        }
        let (mut low, mut high) = (a, b);
        let mut u = a + (b - a) * s / length;
        for _ in 0..60 {
            let excess = self.length_between(a, u) - s;
            if excess.abs() <= 1.0e-10 {
                break;
            }
            if excess > 0.0 {
                high = u;
            } else {
                low = u;
            }
            let next = u - excess / self.speed(u);
            u = if next > low && next < high { next } else { 0.5 * (low + high) };
        }
        u
    }
}
