//! A simulation's scenario: settings with faults and events, and manual acts on a run.

use crate::choice::one_in;
use crate::execution::SLOWEST;
use crate::{Target, no_repair, outcome, refusal, small};
use std::collections::BTreeMap;
use std::sync::OnceLock;
use trueaxis_sim::event::Act;
use trueaxis_sim::program::Program;
use trueaxis_sim::run::{Kind, Run};
use trueaxis_sim::{Scenario, Settings};
use trueaxis_tables::Machine;

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "scenario",
    about: "scenarios of the simulation (TOML) with faults and events, some of them run",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/scenario.dict"),
    slowest: SLOWEST,
};

const FILE: &str = "scenario.toml";
/// One in so many accepted scenarios is run.
const RUN_ONE_IN: u64 = 128;
/// Cycles of a run.
const CYCLES: u64 = 120;

fn run(bytes: &[u8]) {
    // The caller has read the file as text.
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    for (number, line) in text.lines().take(6).enumerate() {
        act(line, number);
    }
    match Settings::parse(text, FILE) {
        Ok(settings) => accepted(&settings, bytes),
        Err(error) => refusal::of_file(&error.to_string(), FILE, bytes),
    }
}

/// Parses a line as an act, like the desk and `--fault`: an accepted act is written back as the same.
fn act(line: &str, number: usize) {
    match line.parse::<Act>() {
        Ok(act) => {
            let written = act.to_string();
            assert_eq!(written.parse(), Ok(act), "{line:?} is written as {written:?}");
            outcome::accepted();
        }
        Err(error) if number == 0 => refusal::in_words(&error.to_string()),
        Err(_) => {}
    }
}

/// Settings that are written and read again are identical.
fn accepted(settings: &Settings, bytes: &[u8]) {
    let written = settings.to_toml();
    assert_eq!(Settings::parse(&written, FILE).as_ref(), Ok(settings), "{written}");
    assert_eq!(settings.check(), Ok(()));
    let period_s = 1.0 / settings.rate_hz;
    for fault in &settings.faults.items {
        assert!((0.0..=1e6).contains(&fault.at_s) && fault.cycles > 0);
        assert!(!fault.acts_in(0, period_s) || fault.at_s <= period_s);
    }
    let changed = settings.changes();
    assert!(changed.iter().all(|(key, value, default)| !key.is_empty() && value != default), "{changed:?}");
    outcome::accepted();
    outcome::saw((changed.len().min(8), settings.faults.items.len().min(3), settings.events.items.len().min(3)));
    if one_in(RUN_ONE_IN, bytes) {
        simulated(settings);
    }
}

fn machine() -> &'static Machine {
    static MACHINE: OnceLock<Machine> = OnceLock::new();
    MACHINE.get_or_init(|| small::machine("w b X Y Z t"))
}

/// The first cycles of a run, in one part and in two, are the same, with finite figures.
fn simulated(settings: &Settings) {
    static PROGRAM: OnceLock<Program> = OnceLock::new();
    let program = PROGRAM.get_or_init(|| {
        Program::parse("short", "G21 G90 F3000\nG1 X1\nG2 X2 Y-1 J-1\nG0 Z1\n", "short.ngc").expect("a good program")
    });
    let scenario = Scenario::new(machine().clone(), program.clone(), settings.clone());
    let others: BTreeMap<String, Machine> = [("warm".to_owned(), machine().clone())].into();
    let run = scenario.and_then(|scenario| {
        let scenario = scenario.with_exchanges(others);
        Ok((Run::of(scenario.clone(), &[Kind::Compensated])?, Run::of(scenario, &[Kind::Compensated])?))
    });
    let (mut whole, mut parts) = match run {
        Ok(runs) => runs,
        Err(error) => return refusal::in_words(&error.to_string()),
    };
    let more = whole.advance(CYCLES, &mut ());
    parts.advance(CYCLES / 3, &mut ());
    assert_eq!(parts.advance(CYCLES - CYCLES / 3, &mut ()), more);
    assert_eq!(whole.cycle(), parts.cycle());
    let digests = |run: &Run| run.tallies().iter().map(|tally| tally.digest).collect::<Vec<_>>();
    assert_eq!(digests(&whole), digests(&parts));
    for tally in whole.tallies() {
        assert!(tally.error.max_um.is_finite(), "{tally:?}");
    }
    outcome::saw(("run", more));
}

fn seeds() -> Vec<Vec<u8>> {
    [
        "rate_hz = 1000\nfaults = [\"dropout:X@0.01s+3\", \"late@0.02s+1=2.5\"]\nevents = [\"off:correction@0.015s\"]\n",
        "seed = 3\nfaults = [\"glitch:Y@0.005s+1=5.0mm\", \"stuck:Z@0.001s+20\"]\n[motion]\nfeed_percent = 80\n",
        "temperature_c = 30\norigin_mm = [1, 2.5, -3]\n[drive]\nposition_gain_per_s = 90\n[axis.Y]\nlost_motion_mm = 0.002\n",
        "events = [\"exchange:warm@0.001s\", \"on:take-up@0s\"]\n[encoder.linear]\nnoise_rms_mm = 1e-5\n",
        "faults = [\"nan-command:X@0.002s+1\", \"jump-command:Z@0s+1=-3mm\"]\n",
        "dropout:X@1.25s+3",
        "late@3s+1=2.5\noff:lag @ 3s\nexchange:a@b/mine@0.1s\n jump-command:C@2s+1=-3deg",
    ]
    .map(|text| text.as_bytes().to_vec())
    .into()
}
