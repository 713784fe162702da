//! Factors, budgets and decisions compared with tests/reference/uncertainty.py (mpmath, 40 digits) and the examples of the
//! GUM.

use serde_json::Value;
use trueaxis_metrology::uncertainty::{
    Contribution, Correlations, Covariance, Draws, Interval, Verdict, chi_squared_quantile, half_width, quantile,
    student_factor, verdict,
};

fn reference() -> Value {
    serde_json::from_str(include_str!("../../../tests/reference/uncertainty.json")).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().or_else(|| value.as_str().and_then(|text| text.parse().ok())).unwrap_or(f64::INFINITY)
}

#[test]
fn quantiles_are_those_of_another_library() {
    let reference = reference();
    for (name, of) in [("student", student_factor as fn(f64, f64) -> f64), ("chi_squared", chi_squared_quantile)] {
        let rows = reference[name].as_array().unwrap();
        assert!(rows.len() > 20);
        for row in rows {
            let [p, nu, wanted] = [0, 1, 2].map(|column| number(&row[column]));
            let found = of(p, nu);
            assert!((found / wanted - 1.0).abs() < 1e-9, "{name} {p} {nu}: {found} for {wanted}");
        }
    }
    for (p, nu) in [(1.0, 3.0), (-0.1, 3.0), (f64::NAN, 3.0), (0.95, 0.0), (0.95, -1.0), (0.95, f64::NAN)] {
        assert!(student_factor(p, nu).is_nan() && chi_squared_quantile(p, nu).is_nan(), "{p} {nu}");
    }
}

fn along(parts: &[([f64; 3], f64)]) -> Covariance {
    let all: Vec<Contribution> =
        parts.iter().map(|&(vector, degrees_of_freedom)| Contribution { vector, degrees_of_freedom }).collect();
    Covariance::of(&all, &Correlations::default())
}

/// JCGM 100:2008, H.1: the end gauge. Components in nm with their degrees of freedom; u_c = 32, ν_eff = 16.7, U_99 = 93.
#[test]
fn the_end_gauge_of_the_gum() {
    let gauge =
        along(&[([25.0, 0.0, 0.0], 18.0), ([9.7, 0.0, 0.0], 25.6), ([2.9, 0.0, 0.0], 50.0), ([16.6, 0.0, 0.0], 2.0)]);
    assert!((gauge.standard()[0] - 32.0).abs() < 0.5, "{gauge:?}");
    assert!((gauge.degrees_of_freedom[0] - 16.7).abs() < 0.1, "{gauge:?}");
    // Truncated as in G.4.1.
    let expanded = student_factor(0.99, gauge.degrees_of_freedom[0].floor()) * 32.0;
    assert!((expanded - 93.0).abs() < 0.6, "{expanded}");
}

/// JCGM 101:2008, 9.2.2: four normal quantities of variance 1 add up to y = 0, u = 2, 95 % within ±3.92.
#[test]
fn the_additive_model_of_the_supplement() {
    let sum = along(&[([1.0, 0.0, 0.0], f64::INFINITY); 4]);
    assert_eq!(sum.standard()[0], 2.0);
    assert!((sum.factors(0.95)[0] * 2.0 - 3.92).abs() < 5e-3);
    let mut draws = Draws::new(7, 0);
    let drawn: Vec<f64> = (0..100_000).map(|_| (0..4).map(|_| draws.normal()).sum()).collect();
    assert!((half_width(drawn, 0.95) - 3.92).abs() < 0.03);
    // The same stream repeats; another one differs.
    assert_eq!(Draws::new(7, 0).normal(), Draws::new(7, 0).normal());
    assert_ne!(Draws::new(7, 1).normal(), Draws::new(7, 0).normal());
}

/// u² = a² + b² + 2 r a b (JCGM 100:2008, 5.2.2). Of one fit with ν, ν is that of the sum; of two fits 1/ν = Σ c²/(u⁴ ν_k)
/// with c = a² + r a b and b² + r a b. At r = 1 the uncertainties add up, of opposite parts they cancel.
#[test]
fn correlated_contributions_by_hand() {
    let (a, b) = (3.0, -4.0);
    for (r, nu) in [(0.6, [7.0, 7.0]), (0.6, [7.0, 20.0]), (-0.3, [5.0, f64::INFINITY]), (1.0, [7.0, 7.0])] {
        let correlations = Correlations::new(&[([0, 2], r)], &[nu[0], 9.0, nu[1]]).unwrap();
        let parts = [([a, 0.0, 1.0], nu[0]), ([0.0, 2.0, 0.0], 9.0), ([b, 0.0, 1.0], nu[1])];
        let all = parts.map(|(vector, degrees_of_freedom)| Contribution { vector, degrees_of_freedom });
        let found = Covariance::of(&all, &correlations);
        let variance = a * a + b * b + 2.0 * r * a * b;
        assert!((found.matrix[0][0] - variance).abs() < 1e-9, "{r}: {found:?} for {variance}");
        assert!((found.matrix[0][2] - (a + b) * (1.0 + r)).abs() < 1e-9 && found.matrix[1][1] == 4.0, "{r}: {found:?}");
        let [first, other] = [a * a + r * a * b, b * b + r * a * b];
        let of_two = variance * variance / (first * first / nu[0] + other * other / nu[1]);
        let wanted = if nu[0] == nu[1] { nu[0] } else { of_two };
        assert!((found.degrees_of_freedom[0] / wanted - 1.0).abs() < 1e-6, "{r} {nu:?}: {found:?} for {wanted}");
        assert_eq!(found.degrees_of_freedom[1], 9.0);
    }
}

#[test]
fn draws_with_few_degrees_of_freedom_are_students() {
    let mut draws = Draws::new(3, 2);
    let drawn: Vec<f64> = (0..100_000).map(|_| draws.student(4.0)).collect();
    let found = half_width(drawn, 0.95);
    assert!((found - 2.776).abs() < 0.05, "{found}");
}

/// Exact along one direction and in a ball; in between within 2 % of the draws.
#[test]
fn the_radius_is_that_of_the_sphere() {
    let parts = |s: [f64; 3]| {
        [([s[0], 0.0, 0.0], f64::INFINITY), ([0.0, s[1], 0.0], f64::INFINITY), ([0.0, 0.0, s[2]], f64::INFINITY)]
    };
    assert!((along(&[([3.0, 4.0, 0.0], f64::INFINITY)]).radius(0.95) - 5.0 * 1.959_963_985).abs() < 1e-8);
    assert!((along(&parts([1.0; 3])).radius(0.95).powi(2) - chi_squared_quantile(0.95, 3.0)).abs() < 1e-9);
    assert_eq!(along(&[]).radius(0.95), 0.0);
    let mut draws = Draws::new(11, 0);
    for s in [[1.0, 0.5, 0.2], [1.0, 1.0, 0.1], [1.0, 0.05, 0.05], [0.3, 0.3, 1.0]] {
        let drawn: Vec<f64> =
            (0..100_000).map(|_| s.iter().map(|s| (s * draws.normal()).powi(2)).sum::<f64>().sqrt()).collect();
        let (found, wanted) = (along(&parts(s)).radius(0.95), half_width(drawn, 0.95));
        assert!((found / wanted - 1.0).abs() < 0.02, "{s:?}: {found} for {wanted}");
    }
}

#[test]
fn no_verdict_is_given_within_the_band() {
    let band = Interval { low: 9.0, high: 11.0 };
    assert_eq!(verdict(band, 11.0), Verdict::Pass);
    assert_eq!(verdict(band, 8.9), Verdict::Fail);
    for tolerance in [9.0, 10.0, 10.999] {
        assert_eq!(verdict(band, tolerance), Verdict::Undecided);
    }
    assert_eq!(verdict(band, f64::NAN), Verdict::Undecided);
    assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.75), 3.0);
    assert!(quantile(&[], 0.5).is_nan());
}
