//! The step checked by its contract on random sequences, and the contract checked with planted defects.

use std::sync::atomic::AtomicBool;
use trueaxis_tests::walk::{Combination, Events, Leg, Planted, Rule, Soak, Spoilt};

const SEED: u64 = 1;

/// 200,000 cycles, excluding the ways home, over every combination; every rule is checked.
#[test]
fn every_combination_keeps_the_contract() {
    let legs = Combination::all().len() as u64;
    let leg_cycles = 200_000_u64.div_ceil(legs);
    let jobs = std::thread::available_parallelism().map_or(1, usize::from);
    match (Soak { seed: SEED, cycles: 200_000, leg_cycles, jobs }).run(&AtomicBool::new(false), |_| ()) {
        Ok(report) => {
            assert!(report.cycles >= 200_000 && report.combinations.len() as u64 == legs, "{report:?}");
        }
        Err(Spoilt::Broken(failure)) => panic!("{failure}"),
        Err(other) => panic!("{other}"),
    }
}

/// Legs, by seed and number, that once broke a rule: grids that a hold did not forget, and an axis without a table that was
/// reported at its edge.
#[test]
fn legs_that_broke_a_rule_keep_all() {
    for (seed, number) in [(11, 30), (18, 14), (34, 15), (13, 219), (28, 13)] {
        Leg::new(seed, number, 3000).walk().unwrap_or_else(|failure| panic!("{failure}"));
    }
}

/// The rule that forbids a planted defect detects it.
#[test]
fn planted_defects_are_found_by_the_rule_that_forbids_them() {
    for (planted, rules) in Planted::ALL {
        // Tries some combinations until the defect can occur.
        let found = (0..40).find_map(|number| Leg { planted: *planted, ..Leg::new(SEED, number, 2000) }.walk().err());
        let failure = found.unwrap_or_else(|| panic!("{planted:?} was not found"));
        let rule = failure.broken.rule;
        assert!(rules.contains(&rule), "{planted:?} was found as\n{}", Leg::shrink(&failure));
    }
}

/// A failure is reproduced by seed and leg, names the command that reproduces it, and retains only the events that it needs.
#[test]
fn a_failure_is_repeated_and_shrunk() {
    let leg = Leg { planted: Planted::DriveOff, ..Leg::new(SEED, 3, 2000) };
    let (first, again) = (leg.walk().unwrap_err(), leg.walk().unwrap_err());
    assert_eq!((first.cycle, &first.broken), (again.cycle, &again.broken));
    let least = Leg::shrink(&first);
    assert_eq!((least.broken.rule, least.leg.events), (Rule::DriveIsSum, Events::default()));
    let text = least.to_string();
    assert!(text.contains("--seed 1 --leg 3 --leg-cycles 2000") && text.contains("takes: none"), "{text}");
}
