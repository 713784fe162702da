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
    let p = degree.clamp(1, MAX_DEGREE);
    // The span that holds u: its knots differ, also at the end of the domain.
    let inner = knots.get(p..=points.len()).unwrap_or_default();
    let last = inner.partition_point(|knot| Some(knot) < inner.last()).max(1);
    let span = p + inner.partition_point(|knot| *knot <= u).clamp(1, last) - 1;
    let knot = |i: usize| knots.get(i).copied().unwrap_or(0.0);

    let mut level = [DVec4::ZERO; MAX_DEGREE + 1];
    for (j, slot) in level.iter_mut().enumerate().take(p + 1) {
        let i = span - p + j;
        if let (Some(point), Some(weight)) = (points.get(i), weights.get(i)) {
            *slot = (DVec3::from(*point) * *weight).extend(*weight);
        }
    }
    let (mut first, mut second) = (DVec4::ZERO, DVec4::ZERO);
    let width = knot(span + 1) - knot(span);
    let order = p as f64;
    for r in 1..=p {
        if r + 1 == p {
            let [a, b, c] = [level[p - 2], level[p - 1], level[p]];
            let left = (b - a) / (knot(span + 1) - knot(span - 1));
            let right = (c - b) / (knot(span + 2) - knot(span));
            second = order * (order - 1.0) * (right - left) / width;
        }
        if r == p {
            first = order * (level[p] - level[p - 1]) / width;
        }
        for j in (r..=p).rev() {
            let i = span - p + j;
            let t = (u - knot(i)) / (knot(i + p + 1 - r) - knot(i));
            level[j] = level[j - 1] * (1.0 - t) + level[j] * t;
        }
    }
    let whole = level[p];
    let position = whole.truncate() / whole.w;
    let velocity = (first.truncate() - first.w * position) / whole.w;
    let acceleration = (second.truncate() - 2.0 * first.w * velocity - second.w * position) / whole.w;
    (position, velocity, acceleration)
}
