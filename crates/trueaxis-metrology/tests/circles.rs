//! Reference circles compared with full enumeration, and with reference values of 60 digits.

use serde_json::Value;
use std::f64::consts::{PI, TAU};
use trueaxis_metrology::circles::{
    NoCircle, ReferenceCircle, least_squares, maximum_inscribed, minimum_circumscribed, minimum_zone,
};
use trueaxis_testing::noise::Noise;
use trueaxis_testing::share::share;

type P = [f64; 2];
type Circle = fn(&[P]) -> Result<ReferenceCircle, NoCircle>;

/// Three to twelve points: near-round, lobed, ellipses, part arcs, clouds, and grids with many ties.
fn set(seed: u64) -> Vec<P> {
    let mut random = Noise::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let n = 3 + (random.unit() * 10.0) as usize;
    let around = |random: &mut Noise, turn: f64, radius: &dyn Fn(f64, f64) -> f64| -> Vec<P> {
        (0..n)
            .map(|i| {
                let angle = turn * (i as f64 + 0.6 * random.unit()) / n as f64;
                let r = radius(angle, random.range(-1.0, 1.0));
                [r * angle.cos(), r * angle.sin()]
            })
            .collect()
    };
    match seed % 8 {
        0 => around(&mut random, TAU, &|_, e| 1.0 + 0.1 * e),
        1 => around(&mut random, TAU, &|_, e| 1.0 + 1e-3 * e),
        2 => around(&mut random, TAU, &|_, e| 1.0 + 1e-6 * e),
        3 => around(&mut random, TAU, &|a, e| 1.0 + 0.05 * (3.0 * a).cos() + 0.01 * e),
        4 => around(&mut random, TAU, &|a, _| 1.0 / (1.0 + a.sin().powi(2)).sqrt()),
        5 => {
            let turn = random.range(0.5, 5.0);
            around(&mut random, turn, &|_, e| 1.0 + 0.01 * e)
        }
        6 => (0..n).map(|_| [random.range(-1.0, 1.0), random.range(-1.0, 1.0)]).collect(),
        _ => (0..n).map(|_| [random.range(-2.5, 2.5).round(), random.range(-2.5, 2.5).round()]).collect(),
    }
}

fn distances(points: &[P], c: P) -> (f64, f64) {
    points
        .iter()
        .map(|p| (p[0] - c[0]).hypot(p[1] - c[1]))
        .fold((0.0, f64::INFINITY), |(high, low), d| (d.max(high), d.min(low)))
}

/// The centre that is equally far from a and b, and equally far from c and d.
fn equal(a: P, b: P, c: P, d: P) -> Option<P> {
    let row = |a: P, b: P| {
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        (x, y, 0.5 * (x * (a[0] + b[0]) + y * (a[1] + b[1])))
    };
    let ((x1, y1, h1), (x2, y2, h2)) = (row(a, b), row(c, d));
    let determinant = x1 * y2 - x2 * y1;
    (determinant.abs() > 1e-12).then(|| [(h1 * y2 - h2 * y1) / determinant, (x1 * h2 - x2 * h1) / determinant])
}

fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
}

/// Smallest zone over all centres that two pairs or three points determine.
fn smallest_zone(points: &[P]) -> f64 {
    let mut best = f64::INFINITY;
    for (i, j) in pairs(points.len()) {
        for (k, l) in pairs(points.len()) {
            // Pairs that share a point form the triples.
            if let Some(c) = equal(points[i], points[j], points[k], points[l]) {
                let (high, low) = distances(points, c);
                best = best.min(high - low);
            }
        }
    }
    best
}

/// Smallest extent along any normal of two points: no strip is narrower. 0 if all points coincide.
fn strip(points: &[P]) -> f64 {
    if points.iter().all(|p| p == &points[0]) {
        return 0.0;
    }
    pairs(points.len())
        .filter_map(|(i, j)| {
            let (x, y) = (points[j][0] - points[i][0], points[j][1] - points[i][1]);
            let length = x.hypot(y);
            let across = points.iter().map(|p| (p[0] * y - p[1] * x) / length);
            let (low, high) = across.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            (length > 0.0).then_some(high - low)
        })
        .fold(f64::INFINITY, f64::min)
}

fn smallest_circle(points: &[P]) -> f64 {
    let mut best = f64::INFINITY;
    for (i, j) in pairs(points.len()) {
        let middle = [0.5 * (points[i][0] + points[j][0]), 0.5 * (points[i][1] + points[j][1])];
        best = best.min(distances(points, middle).0);
        for k in j + 1..points.len() {
            if let Some(c) = equal(points[i], points[j], points[i], points[k]) {
                best = best.min(distances(points, c).0);
            }
        }
    }
    best
}

/// Largest empty circle on three points whose angles all have a cosine above the margin.
fn largest_empty(points: &[P], margin: f64) -> f64 {
    let acute = |a: P, b: P, c: P| {
        let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        u[0] * v[0] + u[1] * v[1] > margin * u[0].hypot(u[1]) * v[0].hypot(v[1])
    };
    let mut best = 0.0;
    for (i, j) in pairs(points.len()) {
        for k in j + 1..points.len() {
            let (a, b, c) = (points[i], points[j], points[k]);
            if let Some(centre) = equal(a, b, a, c)
                && acute(a, b, c)
                && acute(b, c, a)
                && acute(c, a, b)
            {
                let radius = (a[0] - centre[0]).hypot(a[1] - centre[1]);
                if distances(points, centre).1 >= radius * (1.0 - 1e-9) && radius > best {
                    best = radius;
                }
            }
        }
    }
    best
}

/// Largest angular gap between points as seen from c.
fn gap(points: &[P], c: P) -> f64 {
    let mut angles: Vec<f64> = points.iter().map(|p| (p[1] - c[1]).atan2(p[0] - c[0])).collect();
    angles.sort_by(f64::total_cmp);
    let around = angles[0] + TAU - angles[angles.len() - 1];
    angles.windows(2).map(|w| w[1] - w[0]).fold(around, f64::max)
}

#[test]
fn no_centre_of_any_two_pairs_or_three_points_is_better() {
    let (mut zones, mut inscribed, mut strips, mut part) = (0, 0, 0, 0);
    let sets = share(12_000) as u64;
    for seed in 0..sets {
        let points = set(seed);
        let Ok(outer) = minimum_circumscribed(&points) else {
            assert!(strip(&points) < 1e-12, "{seed}");
            continue;
        };
        let truth = smallest_circle(&points);
        assert!((outer.radius - truth).abs() < 1e-12 * truth, "{seed}: {} for {truth}", outer.radius);

        let (truth, limit) = (smallest_zone(&points), strip(&points));
        match minimum_zone(&points) {
            Ok(zone) => {
                assert!(
                    (zone.zone - truth).abs() < 1e-11,
                    "{seed}: {} for {truth}, strip {limit}\n{points:?}",
                    zone.zone
                );
                let (high, low) = distances(&points, zone.centre);
                assert!((high - low - zone.zone).abs() < 1e-11 * (1.0 + high), "{seed}");
                zones += 1;
            }
            Err(error) => {
                assert_eq!(error, NoCircle::Straight);
                assert!(truth >= limit * (1.0 - 1e-3), "{seed}: refused, but {truth} against a strip of {limit}");
                strips += 1;
            }
        }

        let (least, most) = (largest_empty(&points, 1e-7), largest_empty(&points, -1e-7));
        match maximum_inscribed(&points) {
            Ok(inner) => {
                let fits = inner.radius >= least - 1e-9 && inner.radius <= most + 1e-9;
                assert!(fits, "{seed}: {} for {least} to {most}\n{points:?}", inner.radius);
                inscribed += 1;
            }
            Err(error) => {
                assert_eq!(error, NoCircle::PartArc, "{seed}");
                let open = least_squares(&points).is_ok_and(|fit| gap(&points, fit.centre) < PI);
                assert!(!open || least == 0.0, "{seed}: {least}\n{points:?}");
                part += 1;
            }
        }
    }
    println!("{zones} zones, {strips} better strips, {inscribed} inscribed circles, {part} part arcs");
    assert!(4 * zones > 3 * sets && 12 * inscribed > 5 * sets && strips > 0 && 24 * part > sets);
}

/// One or two points far away from the others: the same enumeration, to the accuracy that f64 retains at that distance.
#[test]
fn outliers_are_answered_exactly_too() {
    for seed in 0..600 {
        let mut random = Noise::new(seed + 9);
        let mut points: Vec<P> = (0..11)
            .map(|i| (TAU * (f64::from(i) + 0.5 * random.unit()) / 11.0, 10.0 + 0.1 * random.range(-1.0, 1.0)))
            .map(|(a, r)| [r * a.cos(), r * a.sin()])
            .collect();
        let far = 10f64.powf(random.range(2.0, 4.0));
        for _ in 0..1 + seed % 2 {
            let a = random.range(0.0, TAU);
            points.push([far * a.cos(), far * a.sin()]);
        }
        let tolerance = 1e-8;
        let (truth, limit) = (smallest_zone(&points), strip(&points));
        match minimum_zone(&points) {
            // The enumeration knows its far centres only to about a micrometre: its zone may be the wider one.
            Ok(zone) => {
                let (high, low) = distances(&points, zone.centre);
                assert!((high - low - zone.zone).abs() < tolerance * far, "{seed}");
                let fits = zone.zone < truth + tolerance && zone.zone > truth - tolerance * far;
                assert!(fits, "{seed}: {} for {truth}\n{points:?}", zone.zone);
            }
            Err(error) => {
                assert!(error == NoCircle::Straight && truth >= limit * (1.0 - 1e-6), "{seed}: {truth} {limit}")
            }
        }
        if let Ok(inner) = maximum_inscribed(&points) {
            let (least, most) = (largest_empty(&points, 1e-7), largest_empty(&points, -1e-7));
            let fits = inner.radius >= least - tolerance && inner.radius <= most + tolerance;
            assert!(fits, "{seed}: {} for {least} to {most}", inner.radius);
        }
    }
}

/// One point far away due to a slip of the probe, in every decade: all four circles. A test in `minimum_zone` counts the work;
/// here the search only has to end.
#[test]
fn thousands_of_points_with_an_outlier() {
    for decade in 3..=9 {
        let mut random = Noise::new(decade);
        let mut points: Vec<P> = (0..4000)
            .map(|i| (TAU * f64::from(i) / 4000.0, 10.0 + 1e-3 * random.range(-1.0, 1.0)))
            .map(|(a, r)| [r * a.cos(), r * a.sin()])
            .collect();
        points.push([10f64.powi(decade as i32), 0.0]);
        for circle in [least_squares as Circle, minimum_circumscribed, maximum_inscribed] {
            let found = circle(&points);
            assert!(
                found.is_ok() || matches!(found, Err(NoCircle::PartArc | NoCircle::Straight)),
                "{decade}: {found:?}"
            );
        }
        let zone = minimum_zone(&points).unwrap();
        // A circle so large that the other points are on a line: the zone is their diameter, and no point is outside it.
        assert!((zone.zone - 20.0).abs() < 0.2 && zone.outer > 400.0, "{decade}: {zone:?}");
    }
}

#[test]
fn no_point_is_outside_and_none_inside() {
    for seed in 0..300 {
        let mut random = Noise::new(seed + 77);
        let n = 20 + (random.unit() * 500.0) as usize;
        let noise = 10f64.powf(random.range(-8.0, -0.5));
        let place = [random.range(-600.0, 600.0), random.range(-600.0, 600.0)];
        let points: Vec<P> = (0..n)
            .map(|i| (TAU * i as f64 / n as f64, 13.0 * (1.0 + noise * random.range(-1.0, 1.0))))
            .map(|(a, r)| [place[0] + r * a.cos(), place[1] + r * a.sin()])
            .collect();
        let rounding = 1e-12;
        let [fit, zone, inner, outer] =
            [least_squares as Circle, minimum_zone, maximum_inscribed, minimum_circumscribed]
                .map(|f| f(&points).unwrap());
        for circle in [&fit, &zone, &inner, &outer] {
            let (high, low) = distances(&points, circle.centre);
            assert!((high - circle.outer).abs() < rounding && (low - circle.inner).abs() < rounding, "{seed}");
            assert!(zone.zone <= circle.zone && inner.inner >= circle.inner && outer.outer <= circle.outer, "{seed}");
        }
        assert!(outer.radius == outer.outer && inner.radius == inner.inner);
        for (circle, least) in [(&zone, 3), (&inner, 3), (&outer, 2)] {
            assert!(circle.contacts.len() >= least, "{seed}: {circle:?}");
            for &i in &circle.contacts {
                let d = (points[i][0] - circle.centre[0]).hypot(points[i][1] - circle.centre[1]);
                assert!((d - circle.outer).abs().min((d - circle.inner).abs()) < rounding, "{seed}");
            }
        }
    }
}

#[test]
fn turning_moving_and_scaling_change_nothing() {
    for seed in 0..400 {
        let points = set(8 * seed + seed % 5);
        let mut random = Noise::new(seed + 5);
        let (angle, scale) = (random.range(0.0, TAU), 10f64.powf(random.range(-3.0, 3.0)));
        let place = [random.range(-9.0, 9.0) * scale, random.range(-9.0, 9.0) * scale];
        let moved = |p: &P| {
            let [x, y] = [p[0] * angle.cos() - p[1] * angle.sin(), p[0] * angle.sin() + p[1] * angle.cos()];
            [place[0] + scale * x, place[1] + scale * y]
        };
        let after: Vec<P> = points.iter().map(moved).collect();
        for circle in [least_squares as Circle, minimum_circumscribed, maximum_inscribed, minimum_zone] {
            match (circle(&points), circle(&after)) {
                (Ok(a), Ok(b)) => {
                    let off = (a.zone * scale - b.zone).abs().max((a.radius * scale - b.radius).abs() * 1e-3);
                    assert!(off < 1e-11 * scale * (1.0 + a.radius), "{seed}: {a:?} {b:?}");
                }
                (a, b) => assert_eq!(a.err(), b.err(), "{seed}"),
            }
        }
    }
}

/// A zone of 1e-9 on a radius of 13, 560 away from the origin, with points that f64 represents exactly.
#[test]
fn a_zone_of_a_billionth_keeps_nine_digits() {
    let unit = 2f64.powi(-30);
    // Two far and two near points about (−560, 34), the others in between; Pythagorean: exact distances of 13.
    let on: [(f64, f64); 8] = [
        (12.0, 5.0),
        (5.0, 12.0),
        (-5.0, 12.0),
        (-12.0, 5.0),
        (-12.0, -5.0),
        (-5.0, -12.0),
        (5.0, -12.0),
        (12.0, -5.0),
    ];
    let mut points: Vec<P> = on.iter().map(|(x, y)| [-560.0 + x, 34.0 + y]).collect();
    for (i, outwards) in [(0, 1.0), (4, 1.0), (2, -1.0), (6, -1.0)] {
        points[i][0] += outwards * unit * on[i].0.signum();
        points[i][1] += outwards * unit * on[i].1.signum();
    }
    // d = sqrt((12 + u)² + (5 + u)²) and sqrt((5 − u)² + (12 − u)²): difference (68 u)/(sum), sum = 26 + O(u²).
    let truth = 68.0 * unit / 26.0;
    let zone = minimum_zone(&points).unwrap();
    assert!((zone.zone / truth - 1.0).abs() < 1e-9, "{} for {truth}", zone.zone);
    assert_eq!(zone.contacts, [0, 2, 4, 6]);
}

/// Pythagorean points: all distances are equal, and no point is more extreme than another.
#[test]
fn points_exactly_on_a_circle_have_no_zone() {
    for place in [[0.0, 0.0], [-560.0, 34.0], [0.5, -0.25]] {
        let quarter = [[5.0, 0.0], [4.0, 3.0], [3.0, 4.0], [1.4, 4.8]];
        let points: Vec<P> = quarter
            .iter()
            .flat_map(|&[x, y]| [[x, y], [-y, x], [-x, -y], [y, -x]])
            .map(|[x, y]| [place[0] + x, place[1] + y])
            .collect();
        for points in [&points[..12], &points[..]] {
            for circle in [least_squares as Circle, minimum_circumscribed, maximum_inscribed, minimum_zone] {
                let found = circle(points).unwrap();
                assert!(found.zone < 1e-12 && (found.radius - 5.0).abs() < 1e-12, "{found:?}");
                assert!((found.centre[0] - place[0]).hypot(found.centre[1] - place[1]) < 1e-12, "{found:?}");
            }
        }
    }
}

#[test]
fn points_without_a_circle_are_refused() {
    let circles = [least_squares as Circle, minimum_circumscribed, maximum_inscribed, minimum_zone];
    for circle in circles {
        assert_eq!(circle(&[]), Err(NoCircle::TooFew { found: 0 }));
        assert_eq!(circle(&[[0.0, 0.0], [1.0, 0.0]]), Err(NoCircle::TooFew { found: 2 }));
        assert_eq!(circle(&[[1.0, 2.0]; 5]), Err(NoCircle::Straight));
        assert_eq!(circle(&[[0.1, 0.1], [0.2, 0.2], [0.3, 0.3], [0.7, 0.7]]), Err(NoCircle::Straight));
        assert_eq!(circle(&[[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]]), Err(NoCircle::NonFinite { index: 1 }));
        assert_eq!(circle(&[[0.0, 0.0], [1.0, 0.0], [0.0, f64::INFINITY]]), Err(NoCircle::NonFinite { index: 2 }));
    }
    let arc: Vec<P> = (0..40)
        .map(|i| f64::from(i) * 0.07)
        .map(|a| [10.0 * a.cos(), 10.0 * a.sin() + 0.01 * (9.0 * a).cos()])
        .collect();
    assert_eq!(maximum_inscribed(&arc), Err(NoCircle::PartArc));
    assert!(minimum_zone(&arc).is_ok_and(|zone| zone.zone < 0.02), "a part arc has a zone");
    assert_eq!(NoCircle::TooFew { found: 2 }.to_string(), "points: found 2, needed at least 3");
}

/// Values from `tests/reference/circles.py`: full enumeration with 60 digits.
#[test]
fn reference_values() {
    let text = include_str!("../../../tests/reference/circles.json");
    let cases: Vec<Value> = serde_json::from_str(text).unwrap();
    assert!(cases.len() >= 40);
    let mut worst: f64 = 0.0;
    for case in &cases {
        let name = case["name"].as_str().unwrap();
        let points: Vec<P> = case["points"]
            .as_array()
            .unwrap()
            .iter()
            .map(|p| [0, 1].map(|k| p[k].as_str().unwrap().parse().unwrap()))
            .collect();
        let value = |circle: &str, key: &str| case[circle][key].as_str().map(|text| text.parse::<f64>().unwrap());
        for (key, circle) in [
            ("lsc", least_squares as Circle),
            ("mcc", minimum_circumscribed),
            ("mic", maximum_inscribed),
            ("mzc", minimum_zone),
        ] {
            let found = circle(&points);
            let (Some(zone), Some(x), Some(y), Some(radius)) =
                (value(key, "zone"), value(key, "cx"), value(key, "cy"), value(key, "r"))
            else {
                assert!(found.is_err(), "{name} {key}: {found:?}");
                continue;
            };
            let found = found.unwrap_or_else(|error| panic!("{name} {key}: {error}"));
            let error = (found.zone - zone).abs() / zone.max(1e-12 * radius);
            assert!(error < 1e-9, "{name} {key}: {} for {zone}", found.zone);
            worst = worst.max(error);
            // The centre of a flat optimum is less certain than its value.
            let off = (found.centre[0] - x).hypot(found.centre[1] - y).max((found.radius - radius).abs());
            assert!(off < 1e-9 * radius, "{name} {key}: {found:?} for {x} {y} {radius}");
        }
    }
    println!("{} sets: zones within {worst:.1e}", cases.len());
}

/// Nearly straight points have a small circle through their middle that is not a minimum: the fit is never worse than a
/// straight line.
#[test]
fn nearly_straight_points_are_fitted_by_a_large_circle_or_refused() {
    let zigzag = [[0.0, 0.0], [1.0, 0.001], [2.0, 0.0], [3.0, 0.001]];
    match least_squares(&zigzag) {
        Ok(circle) => {
            let sum: f64 = zigzag
                .iter()
                .map(|p| ((p[0] - circle.centre[0]).hypot(p[1] - circle.centre[1]) - circle.radius).powi(2))
                .sum();
            // The sum of squares of the straight line is 8e-7.
            assert!(sum < 8.0e-7, "{sum:e} {circle:?}");
        }
        Err(error) => assert!(matches!(error, NoCircle::Straight), "{error}"),
    }
}

/// Sum of squares about a centre, with the mean distance as the radius.
fn squares(points: &[P], c: P) -> f64 {
    let distances: Vec<f64> = points.iter().map(|p| (p[0] - c[0]).hypot(p[1] - c[1])).collect();
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    distances.iter().map(|d| (d - mean) * (d - mean)).sum()
}

/// Points that are hardly a circle have several minima: no descent from a fine grid of starting points finds a better centre.
#[test]
fn no_centre_has_a_smaller_sum_than_the_least_squares_circle() {
    // The algebraic fit of these points is near the wrong minimum.
    let known = [[23.0, 25.0], [22.0, 15.0], [10.0, 28.0], [26.0, 14.0], [39.0, 26.0], [15.0, 11.0], [10.0, 22.0]];
    let mut random = Noise::new(17);
    let drawn = (0..150).map(|k| -> Vec<P> {
        let n = 4 + random.below(17);
        (0..n)
            .map(|_| match k % 3 {
                0 => [random.range(-1.0, 1.0), random.range(-1.0, 1.0)],
                1 => [random.range(0.0, 30.0).round(), random.range(0.0, 30.0).round()],
                _ => [random.range(-1.0, 1.0) + random.signed(), 0.3 * (random.signed() + random.signed())],
            })
            .collect()
    });
    for points in std::iter::once(known.to_vec()).chain(drawn) {
        let Ok(found) = least_squares(&points) else { continue };
        let sum = squares(&points, found.centre);
        let middle = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64);
        let size = points.iter().map(|p| (p[0] - middle[0]).hypot(p[1] - middle[1])).fold(0.0, f64::max);
        // Descent by halved steps, from positions up to ten sizes away.
        for (turn, ring) in (0..16).flat_map(|turn| (0..12).map(move |ring| (turn, ring))) {
            let (sin, cos) = (TAU * (f64::from(turn) + 0.1 * f64::from(ring)) / 16.0).sin_cos();
            let out = size * 0.05 * 1.62f64.powi(ring);
            let mut at = [middle[0] + out * cos, middle[1] + out * sin];
            let (mut step, mut best) = (0.2 * out, squares(&points, at));
            for _ in 0..100 {
                let around =
                    [[step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]].map(|by| [at[0] + by[0], at[1] + by[1]]);
                match around.into_iter().find(|place| squares(&points, *place) < best) {
                    Some(place) => (at, best) = (place, squares(&points, place)),
                    None => step *= 0.5,
                }
            }
            assert!(sum <= best * (1.0 + 1e-9), "{sum} about {:?}, {best} about {at:?}: {points:?}", found.centre);
        }
    }
}

/// Rounding at 10⁹ mm hides the inscribed circle: its search ends and reports that; the other circles exist.
#[test]
fn outliers_at_several_distances_end() {
    let points = [
        [3.0, 0.0],
        [0.0, 1.0],
        [-6.0, 999_999_999.998],
        [0.0, -3.003],
        [53.0, 0.0],
        [0.0, 2.0],
        [-3.0, 0.0],
        [0.0, -3.002],
        [1e6, 2.0],
    ];
    assert_eq!(maximum_inscribed(&points), Err(NoCircle::Unresolved));
    assert!(minimum_circumscribed(&points).is_ok() && least_squares(&points).is_ok());
}

/// Points within a micrometre of a line: the narrowest ring is 200 m away, and no wider than that of least squares.
#[test]
fn the_narrowest_ring_of_nearly_straight_points_is_far_away() {
    let points = [[10.0, 0.001], [25.0, 0.001], [0.1, 0.001], [0.1, 0.001], [0.2, 0.001], [31.0, 0.0]];
    let (lsc, mzc) = (least_squares(&points).unwrap(), minimum_zone(&points).unwrap());
    assert!(mzc.zone < lsc.zone * (1.0 + 1e-9) && mzc.zone < 5.27e-4, "{mzc:?} {lsc:?}");
}

/// Two points 10⁸ mm away on either side of a few in the middle: a valley of centres narrower than rounding.
#[test]
fn a_search_for_the_minimum_zone_ends() {
    let points = [
        [3.0, 0.0],
        [0.0, 3.0],
        [-3.0, 97_418_473.998],
        [0.0, -0.01],
        [63.0, 0.0],
        [0.0, 0.0],
        [0.0, -99_999_999.999],
        [0.0, -3.002],
        [23.0, 0.0],
        [1e6, 2.0],
    ];
    assert_eq!(minimum_zone(&points), Err(NoCircle::Unresolved));
    assert!(minimum_circumscribed(&points).is_ok() && least_squares(&points).is_ok());
}
