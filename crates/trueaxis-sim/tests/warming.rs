//! A machine that warms up: its growth identified from a record, and corrected in a shift of another kind.

use std::path::Path;
use trueaxis_sim::warming::{Outcome, SENSORS, Warming};
use trueaxis_tables::Machine;

fn run(seed: u64, fails: Option<&str>) -> Outcome {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../compensation-tables/mill-3axis");
    let machine = Machine::read(Path::new(folder)).unwrap();
    let fails = fails.and_then(|name| SENSORS.iter().position(|sensor| *sensor == name));
    let warming = Warming { machine, seed, shifts: 5, noise_um: 0.5, update_s: 60, fails };
    warming.run(&mut |_| ()).unwrap()
}

/// The goal is a tenth of the largest drift.
#[test]
fn of_a_shift_that_was_not_fitted_a_tenth_of_the_largest_drift_is_left() {
    for seed in [1, 2, 3] {
        let outcome = run(seed, None);
        let share = outcome.left_share();
        assert!(outcome.largest_mm[0] > 0.02, "{:?}", outcome.largest_mm);
        assert!(share <= 0.07, "seed {seed}: {share}: {:?}", outcome.axes_mm);
        // The limiter: growth that jumps at every update never makes the correction jump.
        assert!(outcome.of_limits <= 1.0 + 1e-6, "{} of the limits", outcome.of_limits);
        assert!(!outcome.unsettled && !outcome.stopped && !outcome.reported && outcome.moments.len() == 481);
    }
}

#[test]
fn a_missing_sensor_is_reported_and_nothing_jumps() {
    let outcome = run(1, Some("nose"));
    assert!(outcome.reported && outcome.failed == Some("nose"));
    assert!(outcome.of_limits <= 1.0 + 1e-6 && !outcome.stopped, "{} of the limits", outcome.of_limits);
    // The failed sensor's share is frozen: worse than with the sensor, but below twice the drift without any correction.
    assert!(outcome.largest_mm[1] < 2.0 * outcome.largest_mm[0], "{:?}", outcome.largest_mm);
}
