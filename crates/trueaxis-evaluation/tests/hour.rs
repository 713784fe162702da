//! The whole machine in an hour: placements chosen by `calibrate plan --minutes`, probed on random machines with angular errors
//! and solved. The error that remains is that of exact transforms.

use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use trueaxis_evaluation::calibrate::{Chosen, Task, chosen, perfect};
use trueaxis_evaluation::simulated::calibration::{Conditions, TaskText, run};
use trueaxis_sim::calibration::{Class, random_machine, volumetric};
use trueaxis_tables::Machine;
use trueaxis_testing::share::share;

const HOUR: &str = include_str!("../src/simulated/hour.toml");

/// Angular errors of 10 µrad beside those of a mill in use.
const CLASS: Class = Class { angle: 10e-6, ..Class::MILL };

fn edited() -> String {
    let edits = std::env::var("HOUR_EDIT").unwrap_or_default();
    edits.split(';').filter_map(|edit| edit.split_once("=>")).fold(HOUR.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

/// A machine that works with a tool of 120 mm.
fn machine(seed: u64) -> Machine {
    let mut machine = random_machine(seed, &CLASS);
    machine.settings.tool_mm = [0.0, 0.0, -120.0];
    machine
}

fn planned(text: &str, nominal: &Machine, minutes: f64) -> Result<Chosen, String> {
    chosen(text, Path::new("hour.toml"), nominal, minutes, &mut |_| {}).map_err(|error| format!("{error:#}"))
}

/// Plans of the structures of these seeds.
fn plans(seeds: std::ops::RangeInclusive<u64>) -> BTreeMap<String, Chosen> {
    let mut plans = BTreeMap::new();
    for seed in seeds {
        let nominal = perfect(&machine(seed));
        let chain = nominal.settings.chain.to_string();
        plans
            .entry(chain)
            .or_insert_with(|| planned(&edited(), &nominal, 60.0).unwrap_or_else(|error| panic!("{error}")));
    }
    plans
}

#[test]
fn an_hour_removes_most_of_the_error() {
    let count = share(20) as u64;
    let plans = plans(1..=count);
    for (chain, plan) in &plans {
        let d = &plan.document;
        println!(
            "{chain}: {} of {}, {:.1} min, {:.1} to {:.2} µm, unseen {:?}",
            d.choices.len(),
            d.compared,
            d.minutes,
            d.before_um,
            d.after_um,
            d.unseen
        );
        for c in &d.choices {
            println!("   {} {} {:?} {:?} {:.1}", c.artefact, c.facing, c.at_mm, c.stylus_mm, c.minutes);
        }
        assert!(plan.document.minutes <= 60.0);
    }
    let removed = |seed: u64| {
        let truth = machine(seed);
        let plan = &plans[truth.settings.chain.as_str()];
        let text = TaskText { file: Path::new("hour.toml"), text: &plan.task };
        let done = run(text, &truth, seed, &Conditions::SHOP).unwrap_or_else(|error| panic!("{error:#}"));
        let [before, after] = volumetric(&truth, &done.known).unwrap();
        println!(
            "{seed}: {:.1} to {:.1} µm, {:.1} %; sigma {:.2}",
            before.rms,
            after.rms,
            100.0 * (1.0 - after.rms / before.rms),
            1e3 * done.found.solution.sigma_mm
        );
        1.0 - after.rms / before.rms
    };
    let mut all: Vec<f64> = (1..=count).into_par_iter().map(removed).collect();
    all.sort_by(f64::total_cmp);
    println!("median {:.3}, least {:.3} of {count}", all[all.len() / 2], all[0]);
    assert!(all[0] > 0.0, "made worse");
    assert!(all[all.len() / 2] > 0.8, "median {}", all[all.len() / 2]);
    let _ = Task::read;
}
