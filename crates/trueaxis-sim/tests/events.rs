//! Acts during a run: they give the same bits as the same acts in the scenario, and tables exchanged in motion ramp in.

use crate::common::machine;
use std::collections::BTreeMap;
use std::sync::LazyLock;
use trueaxis_sim::event::Act;
use trueaxis_sim::program::Program;
use trueaxis_sim::run::{Kind, Moment, Run, Sample, Tallies};
use trueaxis_sim::{Scenario, Settings, SimError};
use trueaxis_tables::Machine;

/// A line and an arc: the acts take place on them.
const PROGRAM: &str = "G21 G90 F1500\nG1 X10\nG2 X10 Y-20 J-10\n";

/// All kinds of machines, including those without the plugin.
const KINDS: [Kind; 5] = [Kind::Uncompensated, Kind::Compensated, Kind::ServoOnly, Kind::Full, Kind::Configured];

fn others() -> BTreeMap<String, Machine> {
    let mut warm = machine();
    warm.settings.location.c0y += 40e-6;
    for axis in &mut warm.settings.axes {
        axis.limits.slope_per_s = 1.0;
    }
    let mut turned = machine();
    turned.settings.name = "another".try_into().unwrap();
    let mut wild = machine();
    wild.settings.axes[0].limits.magnitude = -1.0;
    [("warm", warm), ("turned", turned), ("wild", wild)].map(|(name, machine)| (name.into(), machine)).into()
}

fn scenario(faults: &[String], events: &[String]) -> Scenario {
    let mut settings = Settings { rate_hz: 1000.0, seed: 3, ..Settings::default() };
    settings.set("faults", &format!("{faults:?}")).unwrap();
    settings.set("events", &format!("{events:?}")).unwrap();
    // The scenario is run from the written TOML.
    let settings = Settings::parse(&settings.to_toml(), "scenario.toml").unwrap();
    let program = Program::parse("loop", PROGRAM, "loop.ngc").unwrap();
    Scenario::new(machine(), program, settings).unwrap().with_exchanges(others())
}

fn finish(mut run: Run) -> Vec<Tallies> {
    while run.advance(u64::MAX, &mut ()) {}
    run.tallies()
}

/// The run without acts, with which the others are compared.
static PLAIN: LazyLock<Vec<Tallies>> = LazyLock::new(|| finish(Run::of(scenario(&[], &[]), &KINDS).unwrap()));

/// Whether the digest of each machine differs from that without acts.
fn changed(after: &[Tallies]) -> Vec<bool> {
    after.iter().zip(&*PLAIN).map(|(after, plain)| after.digest != plain.digest).collect()
}

/// Acts once the run has reached 0.7 s, 700 cycles, after being paused there and elsewhere before.
fn by_hand(acts: &[&str]) -> (Vec<Tallies>, Vec<String>) {
    let scenario = scenario(&[], &[]);
    let now = scenario.time_s(700);
    let mut run = Run::of(scenario, &KINDS).unwrap();
    assert!(run.advance(300, &mut ()) && run.advance(400, &mut ()));
    let texts: Vec<String> = acts.iter().map(|act| act.replace("NOW", &format!("{now}s"))).collect();
    for text in &texts {
        let act: Act = text.parse().unwrap();
        assert_eq!(act.to_string(), *text);
        run.act(&act, &others()).unwrap();
    }
    (finish(run), texts)
}

#[test]
fn every_act_does_by_hand_what_it_does_in_a_scenario() {
    let driven = [false, true, false, true, true];
    let full = [false, false, false, true, true];
    for (acts, expected) in [
        (&["off:correction@NOW"][..], driven),
        (&["off:correction@NOW", "on:correction@0.9s"], driven),
        (&["off:friction@NOW"], full),
        (&["off:lag@NOW", "on:lag@0.8005s"], full),
        (&["off:acceleration@NOW"], full),
        (&["off:feedback@NOW"], full),
        (&["off:take-up@NOW"], full),
        (&["on:trial@NOW"], full),
        (&["on:trial@NOW", "off:trial@0.9s"], full),
        // The friction of the machine does not adapt.
        (&["off:adapt@NOW", "reset:adapt@0.9s", "on:adapt@0.95s"], [false; 5]),
        // The machine has neither, but with every switch the feed-forward of the other parts restarts.
        (&["off:crosstalk@NOW", "off:learned@NOW"], full),
        (&["exchange:warm@NOW"], driven),
        (&["exchange:warm@NOW", "off:friction@NOW", "exchange:warm@0.95s"], driven),
        (&["glitch:Y@NOW+1=5mm"], [true, true, false, true, true]),
        (&["jump-command:X@0.75s+1=3mm", "off:correction@NOW"], [true, true, false, true, true]),
    ] {
        let (hand, texts) = by_hand(acts);
        let is_event =
            |text: &&String| ["on:", "off:", "reset:", "exchange:"].iter().any(|name| text.starts_with(name));
        let (events, faults): (Vec<String>, Vec<String>) = texts.iter().cloned().partition(|text| is_event(&text));
        let again = finish(Run::of(scenario(&faults, &events), &KINDS).unwrap());
        assert_eq!(hand, again, "{acts:?}");
        assert_eq!(changed(&hand), expected, "{acts:?}");
    }
}

#[test]
fn events_act_from_their_cycle_on() {
    let events = ["off:correction@0.7s".to_owned(), "on:correction@0.9s".to_owned()];
    let correction = |events: &[String]| {
        let mut run = Run::of(scenario(&[], events), &[Kind::Compensated]).unwrap();
        let mut corrections = Vec::new();
        let mut sink = |_: &Moment, machines: &[Option<&Sample>]| {
            corrections.extend(machines.iter().flatten().map(|sample| sample.correction));
        };
        while run.advance(97, &mut sink) {}
        corrections
    };
    let (without, with) = (correction(&[]), correction(&events));
    let first = without.iter().zip(&with).position(|(a, b)| a != b);
    assert_eq!(first, Some(700));
    // Ramped to zero within its limits, and in again.
    assert_eq!(with[899], [0.0; 6]);
    assert!(without[899].iter().any(|c| c.abs() > 1.0));
    let last = with.len() - 1;
    assert_eq!(with[last], without[last]);
}

/// A run on the machine whose friction adapts.
struct Turns {
    tallies: Tallies,
    /// Factors on the friction of X and Y, of every cycle.
    factors: Vec<[[f32; 2]; 2]>,
    /// Positions sent, of every cycle, as bits.
    drives: Vec<[u64; 6]>,
}

impl Turns {
    /// Four turns with these events, on the machine whose stated Coulomb friction is 40 % lower and adapts by the share `adapt`.
    fn run(adapt: f64, events: &[&str]) -> Turns {
        let mut own = machine();
        for axis in &mut own.settings.axes {
            let friction = axis.servo.friction.as_mut().unwrap();
            (friction.coulomb_per_s, friction.adapt) = (0.6 * friction.coulomb_per_s, adapt);
        }
        let mut settings = Settings { rate_hz: 1000.0, seed: 3, ..Settings::default() };
        settings.set("events", &format!("{events:?}")).unwrap();
        let text = "G21 G90 F1500\nG2 I10\nG2 I10\nG2 I10\nG2 I10\n";
        let program = Program::parse("turns", text, "turns.ngc").unwrap();
        let mut run = Run::of(Scenario::new(own, program, settings).unwrap(), &[Kind::Full]).unwrap();
        let (mut factors, mut drives) = (Vec::new(), Vec::new());
        let mut sink = |_: &Moment, machines: &[Option<&Sample>]| {
            factors.extend(machines.iter().flatten().map(|sample| [sample.friction[0], sample.friction[1]]));
            drives.extend(machines.iter().flatten().map(|sample| sample.drive.map(f64::to_bits)));
        };
        while run.advance(u64::MAX, &mut sink) {}
        Turns { tallies: run.tallies().remove(0), factors, drives }
    }

    /// Factors on the Coulomb friction of X and Y.
    fn levels(&self, cycles: std::ops::Range<usize>) -> impl Iterator<Item = [f32; 2]> {
        self.factors[cycles].iter().map(|factors| factors.map(|[level, _]| level))
    }

    fn last(&self) -> [f32; 2] {
        self.factors.last().unwrap().map(|[level, _]| level)
    }
}

#[test]
fn adapting_friction_is_frozen_and_reset() {
    let plain = Turns::run(0.0, &[]);
    assert!(plain.factors.iter().all(|factors| *factors == [[0.0; 2]; 2]));
    let adapted = Turns::run(0.5, &[]);
    assert!(adapted.last().iter().all(|level| *level > 1.1), "{:?}", adapted.last());
    assert_eq!(adapted.tallies.friction[..2], adapted.factors.last().unwrap()[..]);
    assert!(adapted.drives != plain.drives);
    // Frozen from the start: the friction as identified, in every bit that the drives receive.
    let frozen = Turns::run(0.5, &["off:adapt@0s"]);
    assert!(frozen.factors.iter().all(|factors| *factors == [[1.0; 2]; 2]));
    assert!(frozen.drives == plain.drives);
    // Frozen in motion, then reset, then free again.
    let switched = Turns::run(0.5, &["off:adapt@4s", "reset:adapt@6s", "on:adapt@7s"]);
    let held = switched.levels(3_999..4_000).next().unwrap();
    assert!(held.iter().all(|level| *level > 1.04), "{held:?}");
    assert!(switched.levels(4_000..6_000).all(|levels| levels == held));
    assert!(switched.levels(6_000..7_000).all(|levels| levels == [1.0; 2]));
    assert!(switched.last().iter().all(|level| *level > 1.04), "{:?}", switched.last());
}

#[test]
fn an_exchange_ramps_over_and_ends_at_the_correction_of_the_other_tables() {
    let corrections = |scenario: Scenario| {
        let mut run = Run::of(scenario, &[Kind::Compensated]).unwrap();
        let mut corrections = Vec::new();
        let mut sink = |_: &Moment, machines: &[Option<&Sample>]| {
            corrections.extend(machines.iter().flatten().map(|sample| sample.correction));
        };
        while run.advance(u64::MAX, &mut sink) {}
        corrections
    };
    let exchanged = corrections(scenario(&[], &["exchange:warm@0.7s".to_owned()]));
    let mut warm = scenario(&[], &[]);
    warm.machine = others().remove("warm").unwrap();
    let own = corrections(warm);
    let last = own.len() - 1;
    assert_eq!(exchanged[last], own[last]);
    let step = |at: usize| (0..3).map(|k| (exchanged[at][k] - exchanged[at - 1][k]).abs()).fold(0.0, f32::max);
    // 1 mm/s, in µm per cycle of 1 ms, plus the rounding of a difference of two values.
    let worst = (700..=last).map(step).fold(0.0, f32::max);
    assert!(worst <= 1.0 + 1e-4 && worst > 0.5, "{worst}");
}

#[test]
fn refused_acts_change_nothing() {
    let mut run = Run::of(scenario(&[], &[]), &KINDS).unwrap();
    run.advance(700, &mut ());
    for (act, expected) in [
        ("off:correction@0.699s", "off:correction@0.699s: found 0.699 s, needed a time from 0.7 s on"),
        ("stuck:B@1s+3", "fault script: found axis B, needed one of the machine's axes"),
        ("exchange:cold@1s", "exchange:cold: found no machine of that name, needed one given with the scenario"),
        ("exchange:turned@1s", "exchange:turned: found name another, needed mill-3axis, those of the machine"),
        ("exchange:wild@1s", "exchange:wild: "),
    ] {
        let error = run.act(&act.parse().unwrap(), &others()).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
    assert_eq!(finish(run), *PLAIN);
    let refused = |event: &str| Run::of(scenario(&[], &[event.to_owned()]), &KINDS).unwrap_err();
    assert!(matches!(refused("exchange:wild@1s"), SimError::Exchange { .. }));
    assert!(matches!(refused("exchange:cold@1s"), SimError::Unsuited { .. }));
}
