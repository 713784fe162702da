//! Rational B-splines by de Boor's algorithm.

use glam::{DVec3, DVec4};

/// Highest degree of a programmed NURBS.
pub const MAX_DEGREE: usize = 7;

/// C, C' and C'' at u, from the last three levels of de Boor's scheme on homogeneous control points (w P, w).
///
/// With the blossom b of the span \[t_k, t_{k+1}\] and A, B, C its values at (u, …, u; t_{k−1}, t_k), (…; t_k, t_{k+1}),
/// (…; t_{k+1}, t_{k+2}):
/// H' = p (D₁ − D₀) / (t_{k+1} − t_k), D the next to last level;
/// H'' = p (p − 1) [(C − B) / (t_{k+2} − t_k) − (B − A) / (t_{k+1} − t_{k−1})] / (t_{k+1} − t_k);
/// then the quotient rule. Piegl and Tiller, The NURBS Book, 2nd ed., sections 4.3 and 5.4.
pub(super) fn derivatives(
    degree: usize,
    knots: &[f64],
    points: &[[f64; 3]],
    weights: &[f64],
    u: f64,
) -> (DVec3, DVec3, DVec3) {
    let Scheme { p, mut level, knots } = Scheme::new(degree, knots, points, weights, u);
    let knot = |i: usize| knots[i];
    let (mut first, mut second) = (DVec4::ZERO, DVec4::ZERO);
    let width = knot(p) - knot(p - 1);
    let order = p as f64;
    for r in 1..=p {
        if r + 1 == p {
            let [a, b, c] = [level[p - 2], level[p - 1], level[p]];
            let left = (b - a) / (knot(p) - knot(p - 2));
            let right = (c - b) / (knot(p + 1) - knot(p - 1));
            second = order * (order - 1.0) * (right - left) / width;
        }
        if r == p {
            first = order * (level[p] - level[p - 1]) / width;
        }
        raise(&mut level, &knots, p, r, u);
    }
    let whole = level[p];
    let position = whole.truncate() / whole.w;
    let velocity = (first.truncate() - first.w * position) / whole.w;
    let acceleration = (second.truncate() - 2.0 * first.w * velocity - second.w * position) / whole.w;
    (position, velocity, acceleration)
}

/// C alone, equal in every bit to that of [`derivatives`].
pub(super) fn point(degree: usize, knots: &[f64], points: &[[f64; 3]], weights: &[f64], u: f64) -> DVec3 {
    let Scheme { p, mut level, knots } = Scheme::new(degree, knots, points, weights, u);
    for r in 1..=p {
        raise(&mut level, &knots, p, r, u);
    }
    level[p].truncate() / level[p].w
}

/// One level of the scheme.
#[inline(always)]
fn raise(level: &mut [DVec4; MAX_DEGREE + 1], knots: &[f64; 2 * MAX_DEGREE], p: usize, r: usize, u: f64) {
    for j in (r..=p).rev() {
        let t = (u - knots[j - 1]) / (knots[j + p - r] - knots[j - 1]);
        level[j] = level[j - 1] * (1.0 - t) + level[j] * t;
    }
}

/// The start of de Boor's scheme at u.
struct Scheme {
    p: usize,
    /// Homogeneous control points of the span that contains u.
    level: [DVec4; MAX_DEGREE + 1],
    /// Knots of the span: from p − 1 before it to p after it.
    knots: [f64; 2 * MAX_DEGREE],
}

impl Scheme {
    #[inline(always)]
    fn new(degree: usize, knots: &[f64], points: &[[f64; 3]], weights: &[f64], u: f64) -> Scheme {
        let p = degree.clamp(1, MAX_DEGREE);
        // The span that contains u: its knots differ, also at the end of the domain.
        let inner = knots.get(p..=points.len()).unwrap_or_default();
        let end = inner.last().copied().unwrap_or(0.0);
        let mut span = inner.partition_point(|knot| *knot <= u).clamp(1, inner.len().max(1));
        if u >= end {
            span = span.min(inner.partition_point(|knot| *knot < end).max(1));
        }
        let span = p + span - 1;
        let mut level = [DVec4::ZERO; MAX_DEGREE + 1];
        let held = points.iter().zip(weights).skip(span - p);
        for (slot, (point, weight)) in level.iter_mut().zip(held).take(p + 1) {
            *slot = (DVec3::from(*point) * *weight).extend(*weight);
        }
        let mut near = [0.0; 2 * MAX_DEGREE];
        for (to, knot) in near.iter_mut().zip(knots.iter().skip(span + 1 - p)).take(2 * p) {
            *to = *knot;
        }
        Scheme { p, level, knots: near }
    }
}
