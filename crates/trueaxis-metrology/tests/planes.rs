//! Minimum zones of planes and lines compared with full enumeration and analytic cases.

use std::f64::consts::TAU;
use trueaxis_metrology::circles::smallest_width;
use trueaxis_metrology::planes::{NoPlane, minimum_zone};
use trueaxis_testing::noise::Noise;
use trueaxis_testing::share::share;

type V = [f64; 3];

fn sub(a: V, b: V) -> V {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn width(points: &[V], along: V) -> f64 {
    let length = dot(along, along).sqrt();
    let values = points.iter().map(|p| dot(*p, along) / length);
    values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
}

/// The smallest width over all planes through three points and all pairs of parallel planes through two lines of two points.
fn enumerated(points: &[V]) -> f64 {
    let mut best = f64::INFINITY;
    let sides: Vec<V> =
        (0..points.len()).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| sub(points[i], points[j])).collect();
    for (i, one) in sides.iter().enumerate() {
        for other in &sides[..i] {
            let normal = cross(*one, *other);
            if dot(normal, normal) > 1e-20 * dot(*one, *one) * dot(*other, *other) {
                best = best.min(width(points, normal));
            }
        }
    }
    best
}

/// Five to nine points: 0 to 4 near a plane at any inclination and place, 2 on a grid with many on a line, 3 with heights that
/// depend on one coordinate alone, 4 with heights in whole steps.
fn set(seed: u64) -> Vec<V> {
    let mut random = Noise::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let count = 5 + random.below(5);
    let flat = |k: usize, random: &mut Noise| -> V {
        let height = random.signed();
        let [x, y] = [50.0 * random.signed(), 30.0 * random.signed()];
        let grid = [10.0 * (k % 3) as f64, 10.0 * (k / 3) as f64];
        match seed % 5 {
            0 => [x, y, 0.01 * height],
            1 => [x, y, 1e-4 * height],
            2 => [grid[0], grid[1], 1e-3 * height],
            3 => [grid[0], grid[1], 1e-3 * (grid[0] - 7.0).powi(2)],
            _ => [grid[0], grid[1], 1e-3 * (2.5 * height).round()],
        }
    };
    let points: Vec<V> = (0..count).map(|k| flat(k, &mut random)).collect();
    let normal = random.vector(1.0);
    let length = dot(normal, normal).sqrt();
    let w = normal.map(|v| v / length);
    let u = cross(w, [0.3, -0.5, 0.8]);
    let u = u.map(|v| v / dot(u, u).sqrt());
    let (v, shift) = (cross(w, u), random.vector(300.0));
    points.iter().map(|[x, y, z]| std::array::from_fn(|i| x * u[i] + y * v[i] + z * w[i] + shift[i])).collect()
}

#[test]
fn the_zone_of_a_plane_is_that_of_full_enumeration() {
    let mut worst = 0.0_f64;
    for seed in 0..share(4000) as u64 {
        let points = set(seed);
        let (found, wanted) = (minimum_zone(&points).unwrap(), enumerated(&points));
        // Coordinates of some 300 mm round by 6e-14.
        let apart = (found.width - wanted).abs();
        assert!(apart < 1e-12 + 1e-7 * wanted, "{seed}: {} for {wanted} of {points:?}", found.width);
        assert!((width(&points, found.normal) - found.width).abs() < 1e-12, "{seed}");
        worst = worst.max(apart);
        // Its contacts alone have the same zone.
        if found.width > 1e-9 {
            let contacts: Vec<V> = found.contacts.iter().map(|k| points[*k]).collect();
            let own = width(&contacts, found.normal);
            assert!((own - found.width).abs() < 1e-9 + 1e-6 * wanted, "{seed}: {own} of {found:?}");
        }
    }
    println!("{worst} mm");
}

/// Of a saddle z = xy/10⁴ over ±50 mm two opposite corners are on each plane: 0.5 mm apart. A ball of 10 m radius, cut by a
/// square: its middle and its corners, 2 · 50²/2R apart. Least squares would find more of both.
#[test]
fn a_saddle_and_a_cap() {
    let over = |z: &dyn Fn(f64, f64) -> f64| -> Vec<V> {
        let at = |k: usize| -50.0 + 10.0 * k as f64;
        let grid = (0..11).flat_map(|i| (0..11).map(move |j| [at(i), at(j)]));
        grid.map(|[x, y]| [x, y, z(x, y) + 1e-3 * x - 2e-3 * y]).collect()
    };
    let saddle = minimum_zone(&over(&|x, y| 1e-4 * x * y)).unwrap();
    // Seen along the inclined normal.
    let cosine = 1.0 / (1.0 + 1e-6 + 4e-6_f64).sqrt();
    assert!((saddle.width - 0.5 * cosine).abs() < 1e-6, "{saddle:?}");
    assert_eq!(saddle.contacts, [0, 10, 110, 120]);
    let cap = minimum_zone(&over(&|x, y| -(x * x + y * y) / 2e4)).unwrap();
    assert!((cap.width - 0.25 * cosine).abs() < 1e-6, "{cap:?}");
    let flat = minimum_zone(&over(&|_, _| 0.0)).unwrap();
    assert!(flat.width < 1e-13 && flat.contacts.is_empty(), "{flat:?}");
}

/// A line bent like a parabola of 10 µm: its chord and the tangent parallel to it. Points on an arch: its height. Any five
/// points against all directions through two of them.
#[test]
fn the_zone_of_a_line_is_that_of_full_enumeration() {
    let bent: Vec<[f64; 2]> = (0..=100).map(f64::from).map(|x| [x, 3e-4 * x + 4e-6 * x * (100.0 - x)]).collect();
    assert!((smallest_width(&bent) - 0.01 / (1.0 + 9e-8_f64).sqrt()).abs() < 1e-12);
    let arch: Vec<[f64; 2]> = (0..=180).map(|k| (TAU * f64::from(k) / 360.0).sin_cos()).map(|(y, x)| [x, y]).collect();
    assert!((smallest_width(&arch) - 1.0).abs() < 1e-12);
    for seed in 0..share(4000) as u64 {
        let mut random = Noise::new(seed);
        let points: Vec<V> = (0..9).map(|k| [f64::from(k) * 10.0, 1e-3 * random.signed(), 0.0]).collect();
        let pairs = (0..9).flat_map(|i| (0..i).map(move |j| (i, j)));
        let across = |(i, j): (usize, usize)| cross(sub(points[i], points[j]), [0.0, 0.0, 1.0]);
        let wanted = pairs.map(across).map(|normal| width(&points, normal)).fold(f64::INFINITY, f64::min);
        let found = smallest_width(&points.iter().map(|p| [p[0], p[1]]).collect::<Vec<_>>());
        assert!((found - wanted).abs() < 1e-13, "{seed}: {found} for {wanted}");
    }
}

#[test]
fn points_without_a_plane_are_refused() {
    assert_eq!(minimum_zone(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), Err(NoPlane::TooFew { found: 3 }));
    let line: Vec<V> = (0..9).map(f64::from).map(|k| [k, 2.0 * k, 3.0 * k]).collect();
    assert_eq!(minimum_zone(&line), Err(NoPlane::Straight));
    assert_eq!(minimum_zone(&[[1.0; 3]; 5]), Err(NoPlane::Straight));
    let mut wrong = line.clone();
    wrong[2][1] = f64::NAN;
    assert_eq!(minimum_zone(&wrong), Err(NoPlane::NonFinite { index: 2 }));
}
