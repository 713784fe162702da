//! A hundred plants of the trial's family; `.ci/campaign trial` runs ten thousand.

use std::sync::atomic::AtomicBool;
use trueaxis::Dynamics;
use trueaxis_tests::trial::{Case, Conditions, PARTS, Resonance, Tally, trial};

const CONDITIONS: Conditions = Conditions { resonance: Resonance::Unknown, quiet: false, rule: Dynamics::NONE };

/// Prints how many plants get worse by which parts. Gates only that the trial means something: drives that are sound without
/// the plugin follow their tracks, and the parts reach them.
#[test]
fn a_hundred_plants_with_resonance_play_and_friction() {
    let (cases, unsound) = trial(1, 100, CONDITIONS, 2, &AtomicBool::new(false), || {});
    assert_eq!(cases.len(), 100);
    println!("{unsound} plants were not sound by themselves\n{}", Tally::of(&cases)[0]);
    for case in &cases {
        let outcomes = || case.with.iter().chain([&case.off]);
        assert!(outcomes().all(|outcome| outcome.error_um.rms.is_finite()), "{case:?}");
        // Without the plugin an axis lags by (1 − k_ff) v/K_v, and by some cycles.
        let stated = case.plant.stated;
        let lag_s = (1.0 - stated.velocity_feed_forward) / stated.position_gain_per_s + stated.dead_time_s;
        let room_um = 1e3 * (lag_s + 0.02) * case.feed_mm_per_s + 100.0;
        assert!(case.off.error_um.p999 < room_um, "{} µm of {room_um} µm: {case:?}", case.off.error_um.p999);
        for (with, (parts, _)) in case.with.iter().zip(PARTS) {
            let acts = parts != "feedback" || case.gains.is_some();
            assert!(!acts || with.error_um.rms != case.off.error_um.rms, "{parts}: {case:?}");
        }
    }
    let again = Case::run(1, 7, CONDITIONS, &mut 0);
    assert_eq!(again.with[0].error_um.rms, cases[7].with[0].error_um.rms);
}
