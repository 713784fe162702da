//! Covariances in documents: their diagonal are the squares of the standard errors that the document prints.

use trueaxis::Axis;
use trueaxis_evaluation::ballbar::{self, Test};
use trueaxis_evaluation::identify::{Readings, identify};
use trueaxis_metrology::ballbar::Reading;
use trueaxis_metrology::identification::{Ball, Offsets};
use trueaxis_testing::covariance::{at, check};
use trueaxis_testing::noise::Noise;
use trueaxis_testing::scatter::normal;

#[test]
fn of_a_circular_test() {
    let mut noise = Noise::new(1);
    let mut readings = Vec::new();
    for counterclockwise in [true, false] {
        for k in 0..180 {
            let angle_rad = (2.0 * f64::from(k) + 1.0).to_radians();
            let deviation_mm = 2e-3 * (2.0 * angle_rad).sin() + 3e-4 * normal(&mut noise);
            readings.push(Reading { angle_rad, deviation_mm, counterclockwise });
        }
    }
    for axes in [[Axis::X, Axis::Y], [Axis::Z, Axis::X]] {
        let options = ballbar::Options::new(100.0, axes, [Some(10.0); 3]).unwrap();
        let document = serde_json::to_value(Test::of(readings.clone(), false, &options).unwrap().document()).unwrap();
        let names =
            check(&document["covariance"], |name| [at(&document, name), at(&document["standard_errors"], name)]);
        let second = axes[1].letter().to_ascii_lowercase();
        assert!(names.contains(&"centre_um[1]".into()) && names.contains(&format!("cyclic_um.{second}")), "{names:?}");
        assert_eq!(names.len(), 16);
    }
}

#[test]
fn of_a_rotary_axis() {
    let mut noise = Noise::new(2);
    let balls = [(250.0, 60.0), (250.0, 160.0), (350.0, 60.0)];
    let balls = balls.map(|(vertical_mm, horizontal_mm)| Ball { vertical_mm, horizontal_mm }).to_vec();
    let angles_deg: Vec<f64> = (0..12).map(|k| 30.0 * f64::from(k)).collect();
    let reading = |_| [0; 3].map(|_| [0; 3].map(|_| 1e-3 * normal(&mut noise))).to_vec();
    let deviations_mm = (0..12).map(reading).collect();
    let readings = Readings { angles_deg, balls, deviations_mm };
    for offsets in [Offsets::Known, Offsets::Free] {
        let found = identify(readings.clone(), "readings", Axis::C, offsets, None).unwrap();
        let document = serde_json::to_value(&found.document).unwrap();
        for angle in document["angles"].as_array().unwrap() {
            let names = check(&angle["covariance"], |name| [at(angle, name), at(&angle["standard_errors"], name)]);
            assert_eq!((names.len(), names[5].as_str()), (6, "ecc_urad"));
        }
    }
}
