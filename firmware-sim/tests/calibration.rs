//! Simulated calibrations from probe to table.

use trueaxis_evaluation::simulated::calibration::{Conditions, FIVE_AXES, MILL, all, five_axes, summary, three_axes};
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
    // Over twenty machines the median is 0.6 µm and the worst 1.3 µm; 3.4 and 8.8 µrad.
    assert!(outcome.place_um < 2.0 && outcome.tilt_urad < 10.0, "{outcome:?}");
    assert!(outcome.true_um_urad[0] > 10.0 && outcome.true_um_urad[1] > 20.0, "{outcome:?}");
}

#[test]
fn a_refused_machine_is_named_and_the_run_continues() {
    // Some 10 µm between two visits to the reference, too much for some of the machines.
    let warm = Conditions { drift_um: [45.0, 0.0], ..Conditions::SHOP };
    let found = all(6, 1, [MILL, FIVE_AXES], &Class::MILL, &warm, &|| {}).unwrap();
    let figures = summary(&found);
    assert_eq!(found.three_axes.len() + found.five_axes.len() + found.refused.len(), 7);
    assert_eq!((figures.machines, figures.refused), (found.three_axes.len(), found.refused.len()));
    assert!(!found.refused.is_empty() && !found.three_axes.is_empty(), "{found:?}");
    for refused in &found.refused {
        assert!(refused.reason.contains("drift of"), "{refused}");
        assert!(found.three_axes.iter().all(|one| refused.axes == 5 || one.seed != refused.seed));
    }
    // An invalid task is invalid for all machines.
    assert!(all(2, 1, ["machine = 3", FIVE_AXES], &Class::MILL, &warm, &|| {}).is_err());
}
