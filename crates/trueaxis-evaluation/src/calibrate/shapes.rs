//! Piecewise linear curves at knots, by degree.

/// Values at the knots of the polynomial of a degree that is orthogonal over the knots to those of lower degree; the largest
/// is 1.
///
/// Those of degree 2 to n − 1 span all piecewise linear curves over n knots without their least-squares line. Source: Gram's
/// polynomials for equidistant knots; Forsythe, J. SIAM 5 (1957) 74. Orthogonalised twice against every lower one: degree
/// 22 over 23 knots is orthogonal to 1e-12.
pub(super) fn shape(knots: &[f64], degree: usize) -> Vec<f64> {
    let [low, high] = [knots.first(), knots.last()].map(|end| end.copied().unwrap_or_default());
    let t: Vec<f64> = knots.iter().map(|q| (2.0 * q - low - high) / (high - low).max(1e-9)).collect();
    let mut lower: Vec<Vec<f64>> = Vec::with_capacity(degree + 1);
    for k in 0..=degree {
        let mut next = match lower.last() {
            Some(last) => last.iter().zip(&t).map(|(p, t)| p * t).collect(),
            None => vec![1.0; knots.len()],
        };
        for _ in 0..2 {
            for other in &lower {
                let along = dot(&next, other) / dot(other, other).max(f64::MIN_POSITIVE);
                next.iter_mut().zip(other).for_each(|(value, other)| *value -= along * other);
            }
        }
        let largest = next.iter().fold(0.0, |largest: f64, value| largest.max(value.abs())).max(f64::MIN_POSITIVE);
        next.iter_mut().for_each(|value| *value /= largest);
        if k == degree {
            return next;
        }
        lower.push(next);
    }
    Vec::new()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A piecewise linear curve at a position; beyond its ends it keeps their values.
pub(super) fn at(knots: &[f64], values: &[f64], position: f64) -> f64 {
    let right = knots.partition_point(|knot| *knot <= position);
    let end = |index: usize| Some((*knots.get(index)?, *values.get(index)?));
    match (right.checked_sub(1).and_then(end), end(right)) {
        (Some((from, a)), Some((to, b))) => a + (b - a) * (position - from) / (to - from),
        (Some((_, edge)), None) | (None, Some((_, edge))) => edge,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::{at, dot, shape};

    #[test]
    fn shapes_of_five_knots_are_those_of_gram() {
        let knots = [10.0, 20.0, 30.0, 40.0, 50.0];
        // Fisher and Yates, Statistical Tables, orthogonal polynomials: 2 -1 -2 -1 2, then -1 2 0 -2 1, then 1 -4 6 -4 1.
        let table =
            [[1.0, -0.5, -1.0, -0.5, 1.0], [-0.5, 1.0, 0.0, -1.0, 0.5], [1.0, -4.0, 6.0, -4.0, 1.0].map(|p| p / 6.0)];
        for (degree, expected) in (2..).zip(table) {
            let found = shape(&knots, degree);
            let sign = if found[0] * expected[0] < 0.0 { -1.0 } else { 1.0 };
            assert!(found.iter().zip(expected).all(|(a, b)| (sign * a - b).abs() < 1e-12), "{degree}: {found:?}");
        }
    }

    #[test]
    fn shapes_of_many_unequal_knots_are_orthogonal() {
        let knots: Vec<f64> = (0..23).map(|i| f64::from(i) + 0.3 * f64::from(i % 3)).collect();
        let all: Vec<Vec<f64>> = (0..23).map(|degree| shape(&knots, degree)).collect();
        for (i, one) in all.iter().enumerate() {
            for other in &all[..i] {
                let cosine = dot(one, other) / (dot(one, one) * dot(other, other)).sqrt();
                assert!(cosine.abs() < 1e-12, "{i}: {cosine}");
            }
        }
    }

    #[test]
    fn between_knots_a_curve_is_linear_and_beyond_them_constant() {
        let found = [-5.0, 0.0, 2.5, 10.0, 15.0, 99.0].map(|q| at(&[0.0, 10.0, 20.0], &[1.0, 5.0, -1.0], q));
        assert_eq!(found, [1.0, 1.0, 2.0, 5.0, 2.0, -1.0]);
    }
}
