//! Limaçon circles compared with analytic profiles and with full enumeration.

use std::f64::consts::TAU;
use trueaxis_metrology::circles::{NoCircle, ReferenceCircle, limacon};
use trueaxis_testing::noise::Noise;

type Circle = fn(&[f64], &[f64]) -> Result<ReferenceCircle, NoCircle>;

fn residuals<'a>(theta: &'a [f64], r: &'a [f64], c: [f64; 2]) -> impl Iterator<Item = f64> + 'a {
    theta.iter().zip(r).map(move |(t, r)| r - c[0] * t.cos() - c[1] * t.sin())
}

fn range(theta: &[f64], r: &[f64], c: [f64; 2]) -> (f64, f64) {
    residuals(theta, r, c).fold((f64::NEG_INFINITY, f64::INFINITY), |(high, low), v| (high.max(v), low.min(v)))
}

/// Smallest range, smallest maximum and largest minimum over all centres at which two pairs or three readings are level.
fn enumerate(theta: &[f64], r: &[f64]) -> [f64; 3] {
    let row = |i: usize, j: usize| (theta[i].cos() - theta[j].cos(), theta[i].sin() - theta[j].sin(), r[i] - r[j]);
    let n = r.len();
    let pairs: Vec<(usize, usize)> = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).collect();
    let mut best = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY];
    for &(i, j) in &pairs {
        for &(k, l) in &pairs {
            let ((x1, y1, h1), (x2, y2, h2)) = (row(i, j), row(k, l));
            let determinant = x1 * y2 - x2 * y1;
            if determinant.abs() > 1e-9 {
                let c = [(h1 * y2 - h2 * y1) / determinant, (x1 * h2 - x2 * h1) / determinant];
                let (high, low) = range(theta, r, c);
                best = [best[0].min(high - low), best[1].min(high), best[2].max(low)];
            }
        }
    }
    best
}

#[test]
fn no_level_readings_give_a_better_circle() {
    for seed in 0..2_000 {
        let mut random = Noise::new(seed);
        let n = 5 + (seed % 8) as usize;
        // No half turn is open; every third set has readings on a coarse grid, so that many are level.
        let theta: Vec<f64> = (0..n).map(|i| TAU * (i as f64 + 0.45 * random.signed()) / n as f64).collect();
        let r: Vec<f64> = (0..n)
            .map(|_| if seed % 3 == 0 { (3.0 * random.signed()).round() } else { 40.0 + random.signed() })
            .collect();
        let [zone, outer, inner] = enumerate(&theta, &r);
        let found = |circle: Circle| circle(&theta, &r).unwrap();
        let [mzc, mcc, mic] =
            [limacon::minimum_zone_at, limacon::minimum_circumscribed_at, limacon::maximum_inscribed_at]
                .map(|f| found(f));
        assert!((mzc.zone - zone).abs() < 1e-12, "{seed}: {mzc:?} for {zone}");
        assert!((mcc.outer - outer).abs() < 1e-12 && mcc.radius == mcc.outer, "{seed}: {mcc:?} for {outer}");
        assert!((mic.inner - inner).abs() < 1e-12 && mic.radius == mic.inner, "{seed}: {mic:?} for {inner}");
        for circle in [&mzc, &mcc, &mic, &found(limacon::least_squares_at)] {
            let (high, low) = range(&theta, &r, circle.centre);
            assert!((high - circle.outer).abs() < 1e-12 && (low - circle.inner).abs() < 1e-12, "{seed}: {circle:?}");
            assert!((circle.zone - (high - low)).abs() < 1e-12, "{seed}");
        }
        for &i in &mzc.contacts {
            let value = residuals(&theta, &r, mzc.centre).nth(i).unwrap();
            assert!((value - mzc.outer).abs().min((value - mzc.inner).abs()) < 1e-12, "{seed}: {mzc:?}");
        }
    }
}

#[test]
fn no_level_readings_of_an_equidistant_profile_give_a_better_circle() {
    for seed in 0..1_500 {
        let mut random = Noise::new(seed);
        let n = 3 + (seed % 10) as usize;
        let theta: Vec<f64> = (0..n).map(|i| TAU * i as f64 / n as f64).collect();
        // Smooth, rough, and on a coarse grid, so that many readings are level.
        let profile: Vec<f64> = theta
            .iter()
            .map(|theta| match seed % 3 {
                0 => (3.0 * random.signed()).round(),
                1 => 40.0 + random.signed(),
                _ => 7.0 * theta.cos() + (2.0 * theta).sin() + 0.01 * random.signed(),
            })
            .collect();
        let [zone, outer, inner] = enumerate(&theta, &profile);
        let [_, mzc, mic, mcc] = limacon::Turn::new(n).four_circles(&profile).unwrap();
        assert!((mzc.zone - zone).abs() < 1e-12, "{seed}: {mzc:?} for {zone}");
        assert!((mcc.outer - outer).abs() < 1e-12 && mcc.radius == mcc.outer, "{seed}: {mcc:?} for {outer}");
        assert!((mic.inner - inner).abs() < 1e-12 && mic.radius == mic.inner, "{seed}: {mic:?} for {inner}");
        for (circle, levels) in [(&mzc, [mzc.outer, mzc.inner]), (&mcc, [mcc.outer; 2]), (&mic, [mic.inner; 2])] {
            for &i in &circle.contacts {
                let value = residuals(&theta, &profile, circle.centre).nth(i).unwrap();
                assert!(levels.iter().any(|level| (value - level).abs() < 1e-12), "{seed}: {circle:?}");
            }
        }
    }
}

#[test]
fn eccentricity_comes_off_lobes_exactly() {
    for (n, lobes) in [(360, 3), (1024, 2), (1000, 60), (4000, 5), (720, 7)] {
        let profile: Vec<f64> = (0..n)
            .map(|i| TAU * f64::from(i) / f64::from(n))
            .map(|t| -7.0 + 30.0 * t.cos() - 40.0 * t.sin() + 1.5 * (f64::from(lobes) * t).cos())
            .collect();
        // The crests are on samples; the troughs are between samples if n/lobes is odd or not an integer.
        let trough = (0..n).map(|i| (f64::from(lobes) * TAU * f64::from(i) / f64::from(n)).cos()).fold(0.0, f64::min);
        for circle in
            [limacon::least_squares, limacon::minimum_zone, limacon::minimum_circumscribed, limacon::maximum_inscribed]
        {
            let found = circle(&profile).unwrap();
            assert!(found.zone >= 1.5 * (1.0 - trough) - 1e-3, "{n} {lobes}: {found:?}");
            assert!(found.zone <= 1.5 * (1.0 - trough) + 1e-2, "{n} {lobes}: {found:?}");
            assert!((found.centre[0] - 30.0).abs() < 1e-2 && (found.centre[1] + 40.0).abs() < 1e-2, "{found:?}");
        }
        let fit = limacon::least_squares(&profile).unwrap();
        assert!((fit.centre[0] - 30.0).abs() < 1e-12 && (fit.centre[1] + 40.0).abs() < 1e-12);
        assert!((fit.radius + 7.0).abs() < 1e-12);
    }
}

#[test]
fn a_perfect_circle_has_no_zone() {
    for circle in
        [limacon::least_squares, limacon::minimum_zone, limacon::minimum_circumscribed, limacon::maximum_inscribed]
    {
        let constant = circle(&[2.5; 100]).unwrap();
        assert_eq!((constant.zone, constant.radius, constant.centre), (0.0, 2.5, [0.0, 0.0]));
        assert_eq!(circle(&[1.0, 2.0]), Err(NoCircle::TooFew { found: 2 }));
        assert_eq!(circle(&[1.0, 2.0, f64::NAN, 1.0]), Err(NoCircle::NonFinite { index: 2 }));
    }
}

#[test]
fn readings_of_half_a_turn_have_a_zone_only() {
    let theta: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.06).collect();
    let r: Vec<f64> = theta.iter().map(|t| 3.0 + 0.5 * t.cos() + 0.01 * (11.0 * t).sin()).collect();
    assert!(limacon::minimum_zone_at(&theta, &r).is_ok_and(|circle| circle.zone < 0.02));
    assert!(limacon::least_squares_at(&theta, &r).is_ok());
    assert_eq!(limacon::minimum_circumscribed_at(&theta, &r), Err(NoCircle::PartArc));
    assert_eq!(limacon::maximum_inscribed_at(&theta, &r), Err(NoCircle::PartArc));
    assert_eq!(limacon::minimum_zone_at(&theta, &r[..49]), Err(NoCircle::Lengths { angles: 50, readings: 49 }));
    assert_eq!(limacon::least_squares_at(&[1.0; 4], &[1.0, 2.0, 3.0, 4.0]), Err(NoCircle::Straight));
}

#[test]
fn large_profiles_are_quick_enough_to_search() {
    let mut random = Noise::new(3);
    let profile: Vec<f64> = (0..100_000).map(|_| random.signed()).collect();
    let zone = limacon::minimum_zone(&profile).unwrap();
    let fit = limacon::least_squares(&profile).unwrap();
    assert!(zone.zone <= fit.zone && zone.zone > 1.99, "{zone:?}");
    assert!(zone.contacts.len() >= 3, "{zone:?}");
}

#[test]
fn four_circles_at_once_are_those_one_by_one() {
    let mut noise = Noise::new(11);
    for n in [3, 4, 17, 256, 511] {
        for lobes in [0.0, 3.0] {
            let profile: Vec<f64> = (0..n)
                .map(|i| TAU * f64::from(i) / f64::from(n))
                .map(|theta| 40.0 + 2.0 * theta.cos() + (lobes * theta).sin() + 0.3 * noise.signed())
                .collect();
            let apart = [
                limacon::least_squares(&profile),
                limacon::minimum_zone(&profile),
                limacon::maximum_inscribed(&profile),
                limacon::minimum_circumscribed(&profile),
            ];
            assert_eq!(
                limacon::Turn::new(profile.len()).four_circles(&profile),
                Ok(apart.map(|circle| circle.expect("enough readings"))),
                "{n}"
            );
        }
    }
}
