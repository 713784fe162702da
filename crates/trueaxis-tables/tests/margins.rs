//! Margins of the contour feedback compared with reference values, and the effect of the servo rate.

use serde_json::Value;
use std::path::Path;
use trueaxis::ServoLoop;
use trueaxis::check::{self, Spread};
use trueaxis::error::{ConfigError, Field};
use trueaxis::machine::{Axis, DriveFigures, FeedbackSettings, FrictionSettings, MachineSettings};
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::{AxisUncertainty, Uncertainties};
use trueaxis_tables::{Machine, build, compile, feedback_margins, feedback_margins_within, feedback_within};

const ASSUMED: Spread = Spread { assumed: true, ..Spread::LEAST };

fn machine(drive: DriveFigures, friction: Option<FrictionSettings>, feedback: FeedbackSettings) -> MachineSettings {
    let plain = trueaxis_testing::machine::Machine::three_axis().each(|axis| {
        axis.servo.drive = Some(drive);
        axis.servo.friction = friction;
    });
    plain.with(|machine| machine.contour.feedback = Some(feedback)).settings()
}

/// Random drives, from weak to stiff: `tests/reference/margins.py` solves the block diagram.
#[test]
fn margins_are_those_of_the_block_diagram() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference/margins.json");
    let cases: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    assert!(cases.len() >= 30);
    let (mut refused, mut rigid) = (0, 0);
    for case in &cases {
        let number = |section: &str, key: &str| case[section][key].as_f64().unwrap();
        let drive = |key| number("drive", key);
        let figures = DriveFigures {
            position_gain_per_s: drive("position_gain_per_s"),
            velocity_gain_per_s: drive("velocity_gain_per_s"),
            reset_time_s: drive("reset_time_s"),
            velocity_feed_forward: drive("velocity_feed_forward"),
            current_loop_s: drive("current_loop_s"),
            dead_time_s: drive("dead_time_s"),
            // As good as rigid.
            lowest_resonance_hz: 10_000.0,
            ..DriveFigures::with_defaults(0.0, 0.0, 0.0)
        };
        let friction = case["friction"].is_object().then(|| FrictionSettings {
            stribeck_share: number("friction", "stribeck_share"),
            ..FrictionSettings::with_defaults(number("friction", "coulomb_per_s"), number("friction", "presliding"))
        });
        let feedback = FeedbackSettings {
            proportional: number("feedback", "proportional"),
            integral_per_s: number("feedback", "integral_per_s"),
            ..FeedbackSettings::default()
        };
        let machine = machine(figures, friction, feedback);
        let period_s = case["delay_s"].as_f64().unwrap() / 1.5;
        let found: Vec<_> = check::feedback_margins(&machine, period_s).collect();
        assert_eq!(found.iter().map(|(axis, _)| *axis).collect::<Vec<_>>(), [Axis::X, Axis::Y, Axis::Z]);
        let (_, margins) = found[0];
        let near = |found: Option<f64>, key: &str, tolerance: f64| {
            let expected = case[key].as_f64();
            let apart = found.zip(expected).map_or(f64::INFINITY, |(found, expected)| (found - expected).abs());
            assert!(apart < tolerance || found == expected, "{key}: found {found:?}, expected {expected:?}\n{case}");
        };
        near(margins.phase.map(|margin| margin.value), "phase_deg", 1e-4);
        near(margins.gain.map(|margin| margin.value), "gain_db", 1e-5);
        let at_resonances = 10.0_f64.powf((margins.resonance.unwrap().value - check::RESONANCE_MARGIN_DB) / 20.0);
        assert!(margins.factor <= at_resonances * (1.0 + 1e-9), "{case}");
        if margins.factor < at_resonances * (1.0 - 1e-9) {
            rigid += 1;
            near(Some(margins.factor), "factor", 1e-6 * margins.factor.min(100.0));
        }
        assert_eq!(check::feedback(&machine, period_s).is_err(), margins.factor < 1.0);
        refused += usize::from(margins.factor < 1.0);
    }
    assert!(rigid >= cases.len() / 2, "{rigid} of {}", cases.len());
    assert!((3..=25).contains(&refused), "both verdicts occur: {refused} of {}", cases.len());
}

/// The period adds to the dead time: gains accepted at 10 kHz are refused at 500 Hz, and only there.
#[test]
fn the_servo_rate_counts() {
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis");
    let mut machine = Machine::read(&sample).unwrap();
    machine.settings.contour.feedback.as_mut().unwrap().proportional = 0.8;
    machine.settings.axes.iter_mut().for_each(|axis| axis.servo.drive.as_mut().unwrap().lowest_resonance_hz = 10_000.0);
    build(&machine, 10_000.0).unwrap();
    let error = build(&machine, 500.0).unwrap_err();
    assert_eq!((error.field, error.found), (Field::Proportional, 0.8));
    let bound = error.bound.unwrap();
    assert!(bound > 0.05 && bound < 0.8, "{bound}");
    // The bound itself is accepted, at the same ratio of the gains.
    let feedback = machine.settings.contour.feedback.as_mut().unwrap();
    feedback.integral_per_s *= bound / feedback.proportional;
    feedback.proportional = bound;
    build(&machine, 500.0).unwrap();
    let shown = feedback_margins(&machine, 500.0);
    assert!(shown.iter().all(|axis| axis.gain_margin_db.is_none_or(|db| db >= 12.0)), "{shown:?}");
    assert!(shown.iter().any(|axis| axis.largest_proportional.is_some_and(|most| most < bound * 1.02)), "{shown:?}");
}

/// With velocity feed-forward the loop has the bandwidth of the velocity loop: judged by the gains alone, far more would pass.
#[test]
fn feed_forward_costs_margin() {
    let drive = |velocity_feed_forward| DriveFigures {
        velocity_feed_forward,
        dead_time_s: 1.5e-3,
        lowest_resonance_hz: 10_000.0,
        ..DriveFigures::with_defaults(110.0, 800.0, 0.006)
    };
    let feedback = FeedbackSettings { proportional: 1.0, integral_per_s: 30.0, ..FeedbackSettings::default() };
    let factor = |ahead| check::feedback_margins(&machine(drive(ahead), None, feedback), 0.0).next().unwrap().1.factor;
    assert!(factor(0.0) > 1.0 && factor(0.93) < 0.5, "{} {}", factor(0.0), factor(0.93));
}

/// A machine with these lines in the drive of X and Y.
fn resonant(lines: &str, feedback: &str) -> Result<Machine, String> {
    let drive =
        "position_gain_per_s = 60\nvelocity_gain_per_s = 350\nreset_time_s = 0.012\nvelocity_feed_forward = 0.9\n";
    let mut text = String::from("name = \"r\"\nchain = \"w X' b Y t\"\n");
    for axis in ["X", "Y"] {
        text +=
            &format!("[axis.{axis}]\ntravel_mm = [0, 100]\n[axis.{axis}.drive]\n{drive}{}", lines.replace("{}", axis));
    }
    text += &format!("[contour.feedback]\n{feedback}");
    let files = Memory::new([("machine.toml", text.as_str())]);
    Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).map_err(|error| error.to_string())
}

/// A stated resonance bounds the gains and chooses a notch; the bound is accepted; the file carries the figures in version 7,
/// with the gains that are permitted without the notch.
#[test]
fn a_stated_resonance_bounds_the_gains() {
    let known = resonant("resonance_hz = 120\nresonance_damping = 0.02\n", "").unwrap();
    let error = build(&known, 1000.0).unwrap_err();
    assert_eq!((error.field, error.found), (Field::Proportional, 0.3));
    let bound = error.bound.unwrap();
    assert!(error.needed.starts_with("6 dB of margin at the resonances") && (0.05..0.25).contains(&bound), "{error}");
    let gains = format!("proportional = {bound}\nintegral_per_s = {}\n", bound * 10.0 / 0.3);
    let known = resonant("resonance_hz = 120\nresonance_damping = 0.02\n", &gains).unwrap();
    build(&known, 1000.0).unwrap();
    let shown = &feedback_margins(&known, 1000.0)[0];
    assert!(shown.resonance_margin_db.unwrap() >= 6.0 && shown.notch.is_some(), "{shown:?}");
    assert!(shown.to_string().ends_with(" Hz, robust for 108 to 132 Hz"), "{shown}");

    let bytes = compile(&known).unwrap();
    assert_eq!(bytes[8..10], [7, 0]);
    let end: Vec<f64> = bytes[bytes.len() - 100..bytes.len() - 4]
        .as_chunks::<8>()
        .0
        .iter()
        .map(|raw| f64::from_le_bytes(*raw))
        .collect();
    assert_eq!(end[..10], [0.0, 120.0, 0.02, 0.0, 0.0, 0.0, 120.0, 0.02, 0.0, 0.0]);
    assert!(end[10] > 0.0 && end[10] < 1.0 && end[10] == end[11], "{end:?}");
    let file = Tcomp::parse(&bytes).unwrap();
    assert_eq!(Machine::from_tcomp(&file), known);
    // A machine without a notch has no such figures behind.
    let damped = compile(&resonant("resonance_hz = 120\nresonance_damping = 0.9\n", "").unwrap()).unwrap();
    assert_eq!((damped[8], damped.len()), (7, bytes.len() - 16));
    // Without resonances the file is that of an older version.
    let small = "proportional = 0.01\nintegral_per_s = 0.3\n";
    assert_eq!(compile(&resonant("", small).unwrap()).unwrap()[8..10], [4, 0]);
}

/// A controller whose servo is too slow for the notch refuses gains that need it, and says how large they may be without;
/// smaller ones run without the notch.
#[test]
fn a_servo_too_slow_for_the_notch_needs_smaller_gains() {
    let lines = "resonance_hz = 120\nresonance_damping = 0.02\ndead_time_s = 0\n";
    let loaded = |gains: &str, rate_hz: f64| {
        let bytes = compile(&resonant(lines, gains).unwrap()).unwrap();
        let file = Tcomp::parse(&bytes).unwrap();
        let mut memory = vec![0.0; file.requirement()];
        ServoLoop::<f64, f64, 3>::load(&file, (1e9 / rate_hz) as u32, &mut memory).map(|_| ())
    };
    let gains = "proportional = 0.15\nintegral_per_s = 1.5\n";
    loaded(gains, 500.0).unwrap();
    let error = loaded(gains, 450.0).unwrap_err();
    assert!(error.needed.starts_with("a servo at least four times as fast as the resonance"), "{error}");
    let bound = error.bound.unwrap();
    assert!((0.1..0.15).contains(&bound), "{error}");
    let small = format!("proportional = {bound}\nintegral_per_s = {}\n", 10.0 * bound);
    loaded(&small, 450.0).unwrap();
    feedback_within(&resonant(lines, &small).unwrap(), &Uncertainties::default(), 450.0).unwrap();
}

/// Gains that were accepted at 10 kHz, where the machine was compiled, keep all margins at any servo rate at which a controller,
/// which evaluates no resonance, accepts the machine.
#[test]
fn what_a_controller_accepts_keeps_its_margins_at_any_rate() {
    let (mut notched, mut refused) = (0, 0);
    for case in 0..24_u32 {
        let pick = |of: [f64; 3], digit: u32| of[(case / 3_u32.pow(digit) % 3) as usize];
        let kv = pick([25.0, 60.0, 115.0], 0);
        let figures = DriveFigures {
            velocity_feed_forward: if case % 2 == 0 { 0.9 } else { 0.0 },
            resonance_hz: pick([45.0, 120.0, 400.0], 1),
            resonance_damping: pick([0.02, 0.1, 0.5], 2),
            ..DriveFigures::with_defaults(kv, 6.5 * kv, 0.9 / kv)
        };
        let with = |proportional| {
            let feedback = FeedbackSettings { proportional, integral_per_s: 20.0 * proportional, ..Default::default() };
            machine(figures, None, feedback)
        };
        let Err(error) = check::feedback_within(&with(100.0), 1e-4, |_| Spread::LEAST) else { panic!("{case}") };
        for share in [0.3, 0.99] {
            // 0: unstable without the correction.
            let Some(bound) = error.bound.filter(|bound| *bound > 0.0) else { continue };
            let mut compiled = with(share * bound);
            check::decide_notches(&mut compiled);
            for rate_hz in [100.0, 300.0, 500.0, 1000.0, 1600.0, 4000.0, 20_000.0] {
                let controller = check::feedback(&compiled, 1.0 / rate_hz);
                let judged = check::feedback_within(&with(share * bound), 1.0 / rate_hz, |_| Spread::LEAST);
                assert_eq!(controller.is_ok(), judged.is_ok(), "{figures:?} {rate_hz} {controller:?} {judged:?}");
                refused += usize::from(judged.is_err());
            }
            notched += usize::from(compiled.axes[0].servo.drive.unwrap().gain_without_notch > 0.0);
        }
    }
    assert!(notched > 10 && refused > 20, "{notched} {refused}");
}

/// An uncertainty beyond the family's ±10 % costs gain, where the uncertainty is known.
#[test]
fn an_uncertain_resonance_costs_gain() {
    let machine = resonant("resonance_hz = 120\nresonance_damping = 0.02\n", "").unwrap();
    let most = |hz: Option<f64>, damping: Option<f64>| {
        let mut known = Uncertainties::default();
        for axis in [Axis::X, Axis::Y] {
            let unstated = AxisUncertainty::unstated(axis);
            known.axes.push(AxisUncertainty { resonance_hz: hz, resonance_damping: damping, ..unstated });
        }
        feedback_margins_within(&machine, &known, 1000.0)[0].largest_proportional.unwrap()
    };
    let stated = most(None, None);
    assert_eq!(most(Some(5.9), None), stated);
    let [frequency, damping] = [most(Some(15.0), None), most(None, Some(0.005))];
    assert!(frequency < 0.6 * stated && damping < 0.99 * stated, "{stated} {frequency} {damping}");
}

/// As where a machine is compiled.
fn accept(machine: &Machine) -> Result<(), ConfigError> {
    feedback_within(machine, &Uncertainties::default(), 1000.0)
}

/// Without figures any resonance above 100 Hz with which the drive alone is sound must be harmless; a controller, which receives
/// no figures either, does not ask.
#[test]
fn an_unknown_resonance_is_assumed() {
    let unknown = accept(&resonant("", "").unwrap()).unwrap_err();
    let bound = unknown.bound.unwrap();
    assert!(unknown.needed.starts_with("6 dB of margin at any resonance above 100 Hz with 2 % damping"), "{unknown}");
    assert!((0.05..0.2).contains(&bound), "{unknown}");
    let gains = format!("proportional = {bound}\nintegral_per_s = {}\n", bound * 10.0 / 0.3);
    let permitted = resonant("", &gains).unwrap();
    accept(&permitted).unwrap();
    build(&resonant("", "").unwrap(), 1000.0).unwrap();
    assert_eq!(compile(&permitted).unwrap()[8..10], [4, 0]);
    let shown = &feedback_margins(&permitted, 1000.0)[0];
    assert!(shown.to_string().contains(" Hz with any resonance above 100 Hz; permitted up to K_p "), "{shown}");
    // Stating the assumption changes nothing but the message.
    let lowest = accept(&resonant("lowest_resonance_hz = 100\n", "").unwrap()).unwrap_err();
    assert_eq!(lowest.bound, Some(bound));
    assert!(lowest.needed.starts_with("6 dB of margin at the resonances of the axis"), "{lowest}");
    // The higher the lowest resonance, the larger the gain.
    let higher = accept(&resonant("lowest_resonance_hz = 180\n", "").unwrap()).unwrap_err();
    assert!(higher.bound.unwrap() > 1.2 * bound, "{higher}");
    accept(&resonant("lowest_resonance_hz = 2000\n", "").unwrap()).unwrap();
}

/// A drive that is unstable with its resonance has no safe gain; sections that do not agree are refused at their lines.
#[test]
fn resonances_that_no_gain_is_safe_for_are_refused() {
    let soft = resonant("resonance_hz = 45\nresonance_damping = 0.02\n", "").unwrap();
    let error = build(&soft, 1000.0).unwrap_err();
    assert_eq!(error.bound, Some(0.0));
    assert!(error.to_string().contains("without [contour.feedback] the feed-forward still works"), "{error}");
    for (lines, expected) in [
        ("resonance_hz = 120\n", "resonance_damping: found nothing, needed the damping of the resonance"),
        ("resonance_damping = 0.02\n", "resonance_hz: found 0, the default, needed the frequency of the resonance"),
        (
            "resonance_hz = 120\nresonance_damping = 0.02\nlowest_resonance_hz = 150\n",
            "lowest_resonance_hz: found 150, needed at most the stated resonance: 120",
        ),
        (
            "resonance_hz = 120\nresonance_damping = 0.02\n[axis.{}.drive.uncertainty]\nresonance_hz = 60\n",
            "drive.uncertainty.resonance_hz: found 60, needed less than half of resonance_hz",
        ),
        (
            "[axis.{}.drive.uncertainty]\nresonance_damping = 0.001\n",
            "drive.uncertainty.resonance_damping: found 0.001, needed less than half of resonance_damping",
        ),
        (
            "resonance_hz = 120\nresonance_damping = 0.02\n[axis.{}.drive.uncertainty]\nresonance_damping = -1\n",
            "drive.uncertainty.resonance_damping: found -1, needed a standard uncertainty",
        ),
    ] {
        let error = resonant(lines, "").unwrap_err();
        assert!(error.contains(expected), "{error}\n{expected}");
    }
}

/// Drives with a resonance, stated or assumed: `tests/reference/resonances.py` solves the equations of motion.
#[test]
fn margins_at_resonances_are_those_of_the_equations_of_motion() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference/resonances.json");
    let cases: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let [mut unstable, mut notched] = [0; 2];
    for case in &cases {
        let number = |section: &str, key: &str| case[section][key].as_f64().unwrap();
        let own = |key: &str| case[key].as_f64().unwrap();
        let drive = |key| number("drive", key);
        let known = case["known"] == true;
        let [resonance_hz, resonance_damping, lowest_resonance_hz] = match known {
            true => [own("resonance_hz"), own("resonance_damping"), 0.0],
            false => [0.0, 0.0, own("resonance_hz")],
        };
        let figures = DriveFigures {
            velocity_feed_forward: drive("velocity_feed_forward"),
            current_loop_s: drive("current_loop_s"),
            dead_time_s: drive("dead_time_s"),
            resonance_hz,
            resonance_damping,
            lowest_resonance_hz,
            ..DriveFigures::with_defaults(
                drive("position_gain_per_s"),
                drive("velocity_gain_per_s"),
                drive("reset_time_s"),
            )
        };
        let coulomb = own("coulomb_per_s");
        let friction = (coulomb > 0.0).then(|| FrictionSettings::with_defaults(coulomb, 0.006));
        let feedback = FeedbackSettings {
            proportional: number("feedback", "proportional"),
            integral_per_s: number("feedback", "integral_per_s"),
            ..FeedbackSettings::default()
        };
        let (_, margins) =
            check::feedback_margins_within(&machine(figures, friction, feedback), own("period_s"), |_| ASSUMED)
                .next()
                .unwrap();
        let Some(expected) = case[if margins.notch.is_some() { "notched_gain" } else { "gain" }].as_f64() else {
            unstable += 1;
            assert_eq!((margins.factor, margins.notch), (0.0, None), "{case}");
            continue;
        };
        notched += usize::from(margins.notch.is_some());
        let found = 10.0_f64.powf(-margins.resonance.unwrap().value / 20.0);
        // Peaks lie between the evaluated frequencies: 0.5 % of a peak of 2 % damping.
        assert!((found / expected - 1.0).abs() < 5e-3, "{found}, expected {expected}\n{case}");
        assert!(margins.factor <= 0.501_188 / found * 1.001, "{case}");
    }
    assert!(unstable > 0 && notched > 1 && cases.len() - unstable - notched > 6, "{unstable} {notched}");
}
