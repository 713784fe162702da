//! Simulated shifts of machines that re-probe balls and update their tables.

use firmware_sim::report::keeping::{page, shown};
use trueaxis_evaluation::simulated::keeping::{FIVE_AXES, MILL, Outcome, Shift};

fn shift(seed: u64, five_axes: bool, parts: u32, hit: Option<u32>) -> Outcome {
    let task = if five_axes { FIVE_AXES } else { MILL }.to_owned();
    Shift { seed, five_axes, task, task_file: "keep.toml".into(), parts, part_s: 480, noise_um: 1.0, hit }
        .run(&|| {})
        .unwrap()
}

/// Every exchange passed the limiter: however much the tables differ, no cycle exceeds slope and acceleration, 5 mm/s in a
/// millisecond.
fn ramped_in(outcome: &Outcome) {
    assert!(outcome.updates > 5 && outcome.of_limits < 1.0 + 1e-6, "{outcome:?}");
    assert!(outcome.largest_difference_um > 10.0 && outcome.largest_step_um < 5.0 + 1e-6, "{outcome:?}");
    for exchanged in outcome.reprobings.iter().filter_map(|reprobing| reprobing.exchanged) {
        assert!(exchanged.ramp_in_s.is_some(), "{exchanged:?}");
    }
}

#[test]
fn a_mill_with_three_balls_stays_true_over_a_shift() {
    let outcome = shift(1, false, 24, None);
    assert!(outcome.rms_um[1] < 0.4 * outcome.rms_um[0], "{:?}", outcome.rms_um);
    ramped_in(&outcome);
    assert!(page(&outcome, &shown(&outcome)).trim_end().ends_with("</html>"));
}

#[test]
fn centre_lines_follow_a_ball_that_is_turned() {
    let outcome = shift(2, true, 24, None);
    assert!(outcome.rms_um[1] < 0.4 * outcome.rms_um[0], "{:?}", outcome.rms_um);
    ramped_in(&outcome);
}

#[test]
fn a_ball_that_was_hit_changes_nothing() {
    let outcome = shift(1, false, 20, Some(11));
    let (before, after) = outcome.reprobings.split_at(5);
    assert!(
        before.iter().all(|reprobing| reprobing.refused.is_empty() && reprobing.log_refused.is_none()),
        "{before:?}"
    );
    assert!(after.len() == 5 && outcome.refusals == 5, "{after:?}");
    assert!(after.iter().all(|reprobing| reprobing.updates == 0 && reprobing.exchanged.is_none()), "{after:?}");
}
