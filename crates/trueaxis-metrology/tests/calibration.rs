//! Calibration by touches, compared with hand calculations.

use trueaxis_metrology::calibration::{CalibrationRefusal, Centre, Network, Part, Surface, Touch, Unknown, fit_ball};
use trueaxis_testing::noise::Noise;

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
    // Two of six touches determine a coordinate, all of them the radius.
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
        Err(CalibrationRefusal::NotApart { combinations }) => {
            assert_eq!(combinations, [vec![(2, combinations[0][0].1)]])
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(fit_ball(&points[..2], NEAR, 15.5, true, 1e-3), Err(CalibrationRefusal::TooFew { found: 2, .. })));
    let far = on_ball(&[[f64::NAN, 0.0, 1.0]; 5]);
    assert!(matches!(fit_ball(&far, NEAR, 15.5, true, 1e-3), Err(CalibrationRefusal::NotFinite { touch: 0 })));
}

/// A bore touched on a machine that is 30 ppm too long in both directions, or with a tip 0.75 µm too large per 50 mm:
/// indistinguishable.
#[test]
fn a_bore_alone_cannot_separate_scale_and_tip() {
    let free = |start| Unknown { start, uncertainty: None };
    let unknowns = vec![free(0.0), free(3.0), Unknown { start: 50.0, uncertainty: Some(1e-4) }, free(0.0), free(0.0)];
    let touch = |k: i32| {
        let (sin, cos) = (f64::from(k) * 0.4).sin_cos();
        let tip_mm = [22.0 * cos, 22.0 * sin, 0.0];
        let surface = Surface::Bore { diameter: 2, centre: 3, plane: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
        Touch { tip_mm, surface, response: vec![tip_mm], drift: Vec::new(), own_tip: None, weight: 1.0 }
    };
    let network = Network { unknowns, terms: 1, tip: 1, touches: (0..16).map(touch).collect(), repeatability_mm: 1e-3 };
    match network.solve() {
        Err(CalibrationRefusal::NotApart { combinations }) => {
            let mut named: Vec<usize> = combinations[0].iter().map(|(index, _)| *index).collect();
            named.sort_unstable();
            assert_eq!(named, [0, 1]);
        }
        other => panic!("{other:?}"),
    }
    let mut known = network;
    known.unknowns[1].uncertainty = Some(1e-4);
    // Planned touches: the stated repeatability counts, not how well the touches fit.
    let foreseen = known.foresee().unwrap();
    assert!((foreseen.sigma_mm - 1e-3).abs() < 1e-15, "{foreseen:?}");
    let found = known.solve().unwrap();
    assert!(found.values[0].abs() < 1e-12 && found.standard_errors[0] > 0.0, "{found:?}");
}

/// A gauge of 30 faces, each touched twice, on a machine that is too long. With a certificate far worse than the probe (5 µm
/// versus 1 µm), every face costs one degree of freedom. The degrees of freedom are then 60 touches − 31 for the faces and the
/// scale + the information of the certificate on the row as a whole.
#[test]
fn residuals_are_divided_by_the_degrees_of_freedom() {
    let repeats = 400;
    let (mut variance, mut degrees) = (0.0, 0);
    let mut noise = Noise::new(7);
    // Uniform, with standard deviation 1.
    let mut drawn = || 3_f64.sqrt() * noise.signed();
    for _ in 0..repeats {
        let free = |start| Unknown { start, uncertainty: None };
        let mut unknowns = vec![free(0.0), Unknown { start: 3.0, uncertainty: Some(1e-6) }, free(0.0)];
        let mut touches = Vec::new();
        for face in 0..30_u32 {
            let at = 10.0 * f64::from(face);
            let unknown = unknowns.len();
            unknowns.push(Unknown { start: 0.0, uncertainty: Some(5e-3) });
            let off = 5e-3 * drawn();
            for _ in 0..2 {
                // The tip's radius in front of the face; the axis indicates 30 ppm less than its travel.
                let tip_mm = [(at + off - 3.0) * (1.0 - 30e-6) + 1e-3 * drawn(), 0.0, 0.0];
                let part = |unknown| Part { unknown, factor: 1.0, along: None };
                let parts = vec![part(2), part(unknown)];
                let surface = Surface::Face { normal: [1.0, 0.0, 0.0], outward: -1.0, known_mm: at, parts };
                touches.push(Touch {
                    tip_mm,
                    surface,
                    response: vec![[tip_mm[0], 0.0, 0.0]],
                    drift: Vec::new(),
                    own_tip: None,
                    weight: 1.0,
                });
            }
        }
        let found = Network { unknowns, terms: 1, tip: 1, touches, repeatability_mm: 1e-3 }.solve().unwrap();
        variance += found.sigma_mm * found.sigma_mm / f64::from(repeats);
        degrees = found.degrees_of_freedom;
    }
    assert!((29..=32).contains(&degrees), "{degrees}");
    // 400 variances of 30 degrees of freedom each have a standard error of 1.3 %.
    assert!((variance * 1e6 - 1.0).abs() < 0.05, "{variance}");
}

/// A plate of 300 mm tilted by 10 mrad about each direction keeps its length: ½ θ² would be 50 ppm.
#[test]
fn a_tilted_plate_keeps_its_length() {
    let free = |start| Unknown { start, uncertainty: None };
    let mut unknowns = vec![free(0.0), Unknown { start: 3.0, uncertainty: Some(1e-9) }];
    unknowns.extend([0.0; 6].map(free));
    unknowns.push(Unknown { start: 20.0, uncertainty: Some(1e-9) });
    let mut touches = Vec::new();
    // Rotated about Z by 20 mrad, then about the new X by 10 mrad.
    let ((sz, cz), (sx, cx)) = (0.02_f64.sin_cos(), 0.01_f64.sin_cos());
    for [a, b] in [[0.0, 0.0], [300.0, 0.0], [0.0, 300.0], [300.0, 300.0]] {
        let centre = [cz * a - sz * cx * b, sz * a + cz * cx * b, sx * b];
        for [u, v, w] in [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]] {
            let tip_mm = [centre[0] + 13.0 * u, centre[1] + 13.0 * v, centre[2] + 13.0 * w];
            let surface =
                Surface::Ball { diameter: 8, origin: 2, offset: [a, b, 0.0], turn: Some(5), own: None, length: None };
            touches.push(Touch {
                tip_mm,
                surface,
                response: vec![[tip_mm[0], 0.0, 0.0]],
                drift: Vec::new(),
                own_tip: None,
                weight: 1.0,
            });
        }
    }
    let found = Network { unknowns, terms: 1, tip: 1, touches, repeatability_mm: 1e-3 }.foresee().unwrap();
    assert!(found.values[0].abs() < 1e-9, "{:?}", found.values);
    assert!(found.residuals_mm.iter().all(|residual| residual.abs() < 1e-9), "{:?}", found.residuals_mm);
}

/// A plate of 3 by 3 balls, each off its place, measured as it lies, turned by a quarter and moved by a pitch: the machine's
/// skew is found from places that nobody knows, however much the plate is turned.
#[test]
fn a_turned_plate_of_unknown_places_shows_the_skew_of_a_machine() {
    let free = |start| Unknown { start, uncertainty: None };
    let mut unknowns = vec![free(0.0), Unknown { start: 3.0, uncertainty: Some(1e-9) }];
    // The elongation of the plate, which the distance of the first two balls defines.
    unknowns.push(Unknown { start: 2e-4, uncertainty: Some(1e-9) });
    unknowns.extend([0.0; 14].map(free));
    let mut noise = Noise::new(3);
    let own: Vec<[f64; 2]> =
        (0..9).map(|ball| if ball < 2 { [0.0; 2] } else { [0; 2].map(|_| 0.1 * noise.signed()) }).collect();
    let skew = 40e-6;
    let mut touches = Vec::new();
    for (turn, off, moved) in [(0.0, 0.01, 0.0), (90.0, -0.02, 0.0), (0.0, 0.005, 50.0)] {
        let origin = unknowns.len();
        unknowns.extend([0.0; 3].map(free));
        let ((sin, cos), (quarter, whole)) = ((f64::to_radians(turn) + off).sin_cos(), f64::to_radians(turn).sin_cos());
        for ball in 0..9 {
            let offset = [50.0 * (ball % 3) as f64, 50.0 * (ball / 3) as f64];
            let [a, b] = [0, 1].map(|k| 1.0002 * offset[k] + own[ball][k]);
            let [x, y] = [moved + 2.0 + cos * a - sin * b, -1.0 + sin * a + cos * b];
            // The true X is the indicated one less the skew times Y.
            let tip_mm = [x + skew * y, y, 0.0];
            for along in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
                let surface = Surface::Centre(Centre {
                    plane: [[whole, quarter, 0.0], [-quarter, whole, 0.0]],
                    origin,
                    offset,
                    own: (ball > 1).then(|| 3 + 2 * (ball - 2)),
                    length: 2,
                    along,
                    weight: 2_f64.sqrt(),
                });
                touches.push(Touch {
                    tip_mm,
                    surface,
                    response: vec![[-tip_mm[1], 0.0, 0.0]],
                    drift: Vec::new(),
                    own_tip: None,
                    weight: 1.0,
                });
            }
        }
    }
    let found = Network { unknowns, terms: 1, tip: 1, touches, repeatability_mm: 1e-3 }.foresee().unwrap();
    assert!((found.values[0] - skew).abs() < 1e-9, "{:?}", found.values);
    for (ball, own) in own.iter().enumerate().skip(2) {
        let at = 3 + 2 * (ball - 2);
        assert!((0..2).all(|k| (found.values[at + k] - own[k]).abs() < 1e-6), "{ball}: {:?}", found.values);
    }
}
