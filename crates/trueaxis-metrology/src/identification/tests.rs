//! True values from rigid transforms of the ball, written independently of the rows that are solved.

use super::*;
use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::string::{String, ToString};
use std::vec::Vec;
use trueaxis::Axis;
use trueaxis::machine::Twist;

const BALLS_C: [(f64, f64); 3] = [(250.0, 60.0), (250.0, 160.0), (350.0, 60.0)];
const BALLS_A: [(f64, f64); 3] = [(250.0, 60.0), (250.0, 160.0), (350.0, 160.0)];

fn balls(points: &[(f64, f64)]) -> Vec<Ball> {
    points.iter().map(|&(vertical_mm, horizontal_mm)| Ball { vertical_mm, horizontal_mm }).collect()
}

fn degrees(count: u32, step: f64) -> Vec<f64> {
    (0..count).map(|i| (f64::from(i) * step).to_radians()).collect()
}

/// Actual − ideal position of the ball: the error motion precedes the axis' rotation.
fn moved(axis: Axis, angle: f64, ball: Ball, errors: &Twist) -> [f64; 3] {
    let [x, y, z, a, b, c] = *errors;
    let turn = match axis {
        Axis::A => Rotation3::from_axis_angle(&Vector3::x_axis(), angle),
        Axis::B => Rotation3::from_axis_angle(&Vector3::y_axis(), angle),
        _ => Rotation3::from_axis_angle(&Vector3::z_axis(), angle),
    };
    let horizontal = if axis == Axis::B { Vector3::x() } else { Vector3::y() };
    let centre = Point3::from(horizontal * ball.horizontal_mm - Vector3::z() * ball.vertical_mm);
    let error =
        Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_scaled_axis(Vector3::new(a, b, c)));
    (error * (turn * centre) - turn * centre).into()
}

/// Errors that vary with the angle, of the order of 10 µm and 20 µrad times `size`, with non-zero means.
fn truth(angle: f64, size: f64) -> Twist {
    std::array::from_fn(|i| {
        let k = i as f64;
        let wave = 0.4 + (angle * (1.0 + (k % 3.0)) + 0.7 * k).sin() + 0.3 * (2.0 * angle - k).cos();
        size * wave * if i < 3 { 10e-3 } else { 20e-6 }
    })
}

fn test_of(axis: Axis, points: &[(f64, f64)], angles: &[f64], size: f64) -> BallTest {
    let balls = balls(points);
    let angles = angles.iter().map(|&angle_rad| AngleReadings {
        angle_rad,
        deviations_mm: balls.iter().map(|&ball| moved(axis, angle_rad, ball, &truth(angle_rad, size))).collect(),
    });
    BallTest { axis, angles: angles.collect(), balls: balls.clone() }
}

/// Largest difference, in µm and µrad.
fn apart(one: &Twist, other: &Twist) -> f64 {
    one.iter()
        .zip(other)
        .enumerate()
        .map(|(i, (a, b))| (a - b).abs() * if i < 3 { 1e3 } else { 1e6 })
        .fold(0.0, f64::max)
}

#[test]
fn the_rows_are_the_published_ones() {
    let (l, h) = (251.0, 61.5);
    let ball = balls(&[(l, h)])[0];
    for angle in degrees(24, 15.0) {
        let (sin, cos) = angle.sin_cos();
        let published = [
            (
                Axis::C,
                [
                    [1.0, 0.0, 0.0, 0.0, -l, -h * cos],
                    [0.0, 1.0, 0.0, l, 0.0, -h * sin],
                    [0.0, 0.0, 1.0, h * cos, h * sin, 0.0],
                ],
            ),
            (
                Axis::A,
                [
                    [1.0, 0.0, 0.0, 0.0, -l * cos + h * sin, -(h * cos + l * sin)],
                    [0.0, 1.0, 0.0, l * cos - h * sin, 0.0, 0.0],
                    [0.0, 0.0, 1.0, h * cos + l * sin, 0.0, 0.0],
                ],
            ),
        ];
        for (axis, expected) in published {
            let found = ball::rows(lever(axis, angle, ball).unwrap());
            for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
                assert!((a - b).abs() < 1e-10, "{axis:?} {angle}: {found:?}");
            }
        }
    }
}

#[test]
fn exact_readings_give_the_errors_back() {
    for (axis, points) in [(Axis::C, BALLS_C), (Axis::A, BALLS_A), (Axis::B, BALLS_A)] {
        let angles = degrees(36, 10.0);
        // At a thousandth of the real size, the second-order terms that the rows neglect are below 1e-7 µm.
        for (size, tolerance) in [(1e-3, 1e-6), (1.0, 5e-3)] {
            let found = identify(&test_of(axis, &points, &angles, size), Offsets::Known).unwrap();
            assert_eq!((found.location, found.degrees_of_freedom), (Location::Inside, 108));
            for angle in &found.angles {
                let error = apart(&angle.errors, &truth(angle.angle_rad, size));
                assert!(error < tolerance, "{axis:?} {}: {error}", angle.angle_rad);
                assert!(angle.rank == 6 && angle.condition < 30.0, "{}", angle.condition);
                assert!(angle.residual_mm < 1e-3 * tolerance);
            }
        }
    }
}

#[test]
fn more_set_ups_agree_too() {
    let points: Vec<(f64, f64)> = (0..7).map(|i| (200.0 + 30.0 * f64::from(i % 3), 40.0 * f64::from(i / 2))).collect();
    let found = identify(&test_of(Axis::A, &points, &degrees(19, 5.0), 1e-3), Offsets::Known).unwrap();
    assert_eq!(found.degrees_of_freedom, 19 * 15);
    for angle in &found.angles {
        assert!(apart(&angle.errors, &truth(angle.angle_rad, 1e-3)) < 1e-6);
    }
}

/// True errors under the convention of free offsets, by Gram's sums over the angles.
fn in_convention(axis: Axis, angles: &[f64]) -> Vec<Twist> {
    let mut truth: Vec<Twist> = angles.iter().map(|&angle| truth(angle, 1e-3)).collect();
    let count = angles.len() as f64;
    for i in 0..3 {
        let mean = truth.iter().map(|errors| errors[i]).sum::<f64>() / count;
        truth.iter_mut().for_each(|errors| errors[i] -= mean);
    }
    if axis == Axis::A {
        // The two patterns are orthogonal, and their squares sum to the number of angles.
        let patterns = |angle: f64| [[-angle.cos(), -angle.sin()], [angle.sin(), -angle.cos()]];
        for which in 0..2 {
            let product = angles.iter().zip(&truth).map(|(&angle, errors)| {
                let [b, c] = patterns(angle)[which];
                b * errors[4] + c * errors[5]
            });
            let k = product.sum::<f64>() / count;
            for (&angle, errors) in angles.iter().zip(&mut truth) {
                let [b, c] = patterns(angle)[which];
                errors[4] -= k * b;
                errors[5] -= k * c;
            }
        }
    }
    truth
}

fn rezero(test: &mut BallTest) {
    for angle in &mut test.angles {
        for (s, deviation) in angle.deviations_mm.iter_mut().enumerate() {
            for (i, value) in deviation.iter_mut().enumerate() {
                *value += 1e-3 * (3.0 * s as f64 - 2.0 * i as f64 + 1.0);
            }
        }
    }
}

#[test]
fn free_offsets_leave_the_errors_but_for_the_convention() {
    for (axis, points, angles, null_space) in
        [(Axis::C, BALLS_C, degrees(36, 10.0), 3), (Axis::A, BALLS_A, degrees(19, 5.0), 5)]
    {
        let mut test = test_of(axis, &points, &angles, 1e-3);
        rezero(&mut test);
        let found = identify(&test, Offsets::Free).unwrap();
        assert_eq!((found.null_space, found.location), (null_space, Location::Removed));
        assert_eq!(found.degrees_of_freedom, 3 * angles.len() - 9 + null_space);
        assert_eq!(found.offsets_mm.len(), 3);
        for (angle, truth) in found.angles.iter().zip(in_convention(axis, &angles)) {
            assert!(apart(&angle.errors, &truth) < 1e-6, "{axis:?} {}", angle.angle_rad);
        }
        // If the offsets were treated as errors, the result would be off by micrometres.
        let known = identify(&test, Offsets::Known).unwrap();
        assert!(known.sigma_mm > 1e3 * found.sigma_mm);
    }
}

/// Root mean square over repeats and angles of (error found − truth) / standard error, for each error.
fn scatter_over_standard_error(axis: Axis, points: &[(f64, f64)], angles: &[f64], offsets: Offsets) -> Twist {
    use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
    use rand_distr::{Distribution, Normal};
    let mut noise = ChaCha8Rng::seed_from_u64(5);
    let gauge = Normal::new(0.0, 0.2e-3).unwrap();
    let clean = test_of(axis, points, angles, 1e-3);
    let exact = identify(&clean, offsets).unwrap();
    let (mut squares, mut sigma) = ([0.0; 6], 0.0);
    let repeats = 200;
    for _ in 0..repeats {
        let mut test = clean.clone();
        for value in test.angles.iter_mut().flat_map(|angle| angle.deviations_mm.iter_mut().flatten()) {
            *value += gauge.sample(&mut noise);
        }
        let found = identify(&test, offsets).unwrap();
        sigma += found.sigma_mm / f64::from(repeats);
        for (angle, truth) in found.angles.iter().zip(&exact.angles) {
            for i in 0..6 {
                squares[i] += ((angle.errors[i] - truth.errors[i]) / angle.standard_errors[i]).powi(2);
            }
        }
    }
    assert!((sigma / 0.2e-3 - 1.0).abs() < 0.03, "{sigma}");
    squares.map(|sum| (sum / (f64::from(repeats) * angles.len() as f64)).sqrt())
}

#[test]
fn standard_errors_are_the_scatter_of_repeats() {
    for (axis, points, angles) in [(Axis::C, BALLS_C, degrees(24, 15.0)), (Axis::A, BALLS_A, degrees(19, 5.0))] {
        for offsets in [Offsets::Known, Offsets::Free] {
            let ratios = scatter_over_standard_error(axis, &points, &angles, offsets);
            assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.2), "{axis:?} {offsets:?}: {ratios:?}");
        }
    }
}

/// The errors of one angle scatter with their covariance, for known and for free offsets.
#[test]
fn the_errors_of_an_angle_scatter_with_their_covariance() {
    use trueaxis_testing::{noise::Noise, scatter};
    let names = ["X", "Y", "Z", "α", "β", "γ"].map(String::from);
    let cases = [(Axis::C, BALLS_C, degrees(24, 15.0)), (Axis::A, BALLS_A, degrees(19, 5.0))];
    for (seed, (axis, points, angles)) in (1..).zip(cases) {
        for offsets in [Offsets::Known, Offsets::Free] {
            let clean = test_of(axis, &points, &angles, 1e-3);
            let (mut noise, mut scattered) = (Noise::new(seed), scatter::Scatter::default());
            for _ in 0..400 {
                let mut test = clean.clone();
                for mm in test.angles.iter_mut().flat_map(|angle| angle.deviations_mm.iter_mut().flatten()) {
                    *mm += 0.2e-3 * scatter::normal(&mut noise);
                }
                let found = identify(&test, offsets).unwrap().angles.swap_remove(5);
                for (i, error) in found.standard_errors.into_iter().enumerate() {
                    assert!((found.covariance[i][i].sqrt() / error - 1.0).abs() < 1e-9, "{i}");
                }
                scattered.add(&found.errors, &found.covariance.map(Vec::from));
            }
            let largest = scattered.check(&names, 0.0);
            assert!(largest > 0.5, "{axis:?} {offsets:?}: nothing to compare: {largest}");
        }
    }
}

#[test]
fn collinear_set_ups_are_refused_with_their_figures() {
    let angles = degrees(12, 30.0);
    let refused =
        |points: &[(f64, f64)], offsets| identify(&test_of(Axis::C, points, &angles, 1.0), offsets).unwrap_err();
    for points in [[(200.0, 0.0), (250.0, 50.0), (300.0, 100.0)], [(200.0, 50.0), (300.0, 50.0), (200.0, 50.0)]] {
        for offsets in [Offsets::Known, Offsets::Free] {
            let IdentificationRefusal::Collinear { along_mm, off_mm, rank, .. } = refused(&points, offsets) else {
                panic!("{points:?}");
            };
            let reach = (points[1].0 - points[0].0)
                .hypot(points[1].1 - points[0].1)
                .max((points[2].0 - points[0].0).hypot(points[2].1 - points[0].1));
            assert!((along_mm - reach).abs() < 1e-9 && off_mm < 1e-9 && rank == 5, "{along_mm} {off_mm} {rank}");
        }
    }
    // Almost collinear: a tenth of a millimetre is still sufficient, a hundredth is not.
    let bent = |off: f64| [(200.0, 50.0), (250.0, 50.0 + off), (300.0, 50.0)];
    assert!(identify(&test_of(Axis::C, &bent(0.1), &angles, 1.0), Offsets::Known).is_ok());
    let text = refused(&bent(0.01), Offsets::Known).to_string();
    assert!(text.contains("collinear") && text.contains("100.0000 mm") && text.contains("needed"), "{text}");
}

#[test]
fn missing_and_non_finite_readings_are_refused() {
    let angles = degrees(12, 30.0);
    let test = test_of(Axis::C, &BALLS_C, &angles, 1.0);
    let mut missing = test.clone();
    missing.angles[4].deviations_mm.pop();
    assert_eq!(
        identify(&missing, Offsets::Known),
        Err(IdentificationRefusal::Readings { angle: 4, found: 2, needed: 3 })
    );
    let mut broken = test.clone();
    broken.angles[2].deviations_mm[1][0] = f64::NAN;
    assert_eq!(identify(&broken, Offsets::Free), Err(IdentificationRefusal::NotFinite { set_up: 1 }));
    let few = test_of(Axis::C, &BALLS_C[..2], &angles, 1.0);
    assert_eq!(identify(&few, Offsets::Known), Err(IdentificationRefusal::TooFewSetUps { found: 2 }));
    assert_eq!(
        identify(&BallTest { axis: Axis::X, ..test.clone() }, Offsets::Known),
        Err(IdentificationRefusal::NotRotary(Axis::X))
    );
    assert_eq!(
        identify(&BallTest { angles: Vec::new(), ..test }, Offsets::Known),
        Err(IdentificationRefusal::NoAngles)
    );
    // One angle cannot separate errors from offsets.
    let short = test_of(Axis::A, &BALLS_A, &[0.0, 1e-6, 2e-6], 1.0);
    assert!(matches!(identify(&short, Offsets::Free), Err(IdentificationRefusal::Offsets { needed: 5, .. })));
}

#[test]
fn a_ball_on_the_axis_is_no_reason_to_refuse() {
    let points = [(250.0, 0.0), (250.0, 100.0), (350.0, 0.0)];
    let angles: Vec<f64> = (0..8).map(|i| TAU * f64::from(i) / 8.0).collect();
    let found = identify(&test_of(Axis::C, &points, &angles, 1e-3), Offsets::Known).unwrap();
    for angle in &found.angles {
        assert!(apart(&angle.errors, &truth(angle.angle_rad, 1e-3)) < 1e-6);
    }
}
