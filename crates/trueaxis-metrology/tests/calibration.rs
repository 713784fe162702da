//! Calibration by touches, against what can be worked out by hand.

use trueaxis_metrology::calibration::{Network, Refused, Surface, Touch, Unknown, fit_ball};

const NEAR: [f64; 3] = [10.2, -5.1, 2.9];

fn on_ball(directions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let point = |direction: &[f64; 3]| {
        let length = direction.iter().map(|part| part * part).sum::<f64>().sqrt();
        std::array::from_fn(|k| [10.0, -5.0, 3.0][k] + 15.5 * direction[k] / length)
    };
    directions.iter().map(point).collect()
}

#[test]
fn a_ball_has_its_centre_radius_and_standard_errors() {
    let axes =
        [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let found = fit_ball(&on_ball(&axes), NEAR, 15.0, false, 1e-3).unwrap();
    for (value, truth) in found.centre_mm.iter().zip([10.0, -5.0, 3.0]) {
        assert!((value - truth).abs() < 1e-9, "{found:?}");
    }
    assert!((found.radius_mm - 15.5).abs() < 1e-9);
    // Two of six touches tell a coordinate, all of them the radius.
    for error in found.standard_errors_mm {
        assert!((error - 1e-3 / 2f64.sqrt()).abs() < 1e-9, "{found:?}");
    }
    assert!((found.radius_standard_error_mm - 1e-3 / 6f64.sqrt()).abs() < 1e-9);
    let known = fit_ball(&on_ball(&axes[..5]), NEAR, 15.5, true, 1e-3).unwrap();
    assert!((known.centre_mm[2] - 3.0).abs() < 1e-9 && (known.standard_errors_mm[2] - 1e-3).abs() < 1e-8, "{known:?}");
}

#[test]
fn touches_that_leave_a_direction_open_are_refused() {
    let around: Vec<[f64; 3]> = (0..8).map(|k| f64::from(k) * 0.7).map(|a| [a.cos(), a.sin(), 0.0]).collect();
    let points = on_ball(&around);
    match fit_ball(&points, [10.0, -5.0, 3.0], 15.5, true, 1e-3) {
        Err(Refused::NotApart { combinations }) => assert_eq!(combinations, [vec![(2, combinations[0][0].1)]]),
        other => panic!("{other:?}"),
    }
    assert!(matches!(fit_ball(&points[..2], NEAR, 15.5, true, 1e-3), Err(Refused::TooFew { found: 2, .. })));
    let far = on_ball(&[[f64::NAN, 0.0, 1.0]; 5]);
    assert!(matches!(fit_ball(&far, NEAR, 15.5, true, 1e-3), Err(Refused::NotFinite { touch: 0 })));
}

/// A bore touched on a machine that is 30 ppm too long in both directions, or with a tip 0.75 µm too large per 50 mm: the same.
#[test]
fn a_bore_alone_does_not_tell_scale_and_tip() {
    let free = |start| Unknown { start, uncertainty: None };
    let unknowns = vec![free(0.0), free(3.0), Unknown { start: 50.0, uncertainty: Some(1e-4) }, free(0.0), free(0.0)];
    let touch = |k: i32| {
        let (sin, cos) = (f64::from(k) * 0.4).sin_cos();
        let tip_mm = [22.0 * cos, 22.0 * sin, 0.0];
        let surface = Surface::Bore { diameter: 2, centre: 3, plane: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
        Touch { tip_mm, surface, response: vec![tip_mm], drift: Vec::new() }
    };
    let network = Network { unknowns, terms: 1, tip: 1, touches: (0..16).map(touch).collect(), repeatability_mm: 1e-3 };
    match network.solve() {
        Err(Refused::NotApart { combinations }) => {
            let mut named: Vec<usize> = combinations[0].iter().map(|(index, _)| *index).collect();
            named.sort_unstable();
            assert_eq!(named, [0, 1]);
        }
        other => panic!("{other:?}"),
    }
    let mut known = network;
    known.unknowns[1].uncertainty = Some(1e-4);
    // Not yet touched: the stated repeatability counts, not how well the touches fit.
    let foreseen = known.foresee().unwrap();
    assert!((foreseen.sigma_mm - 1e-3).abs() < 1e-15, "{foreseen:?}");
    let found = known.solve().unwrap();
    assert!(found.values[0].abs() < 1e-12 && found.standard_errors[0] > 0.0, "{found:?}");
}
