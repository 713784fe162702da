//! Margins of the contour feedback compared with reference values, and the effect of the servo rate.

use serde_json::Value;
use std::path::Path;
use trueaxis::check;
use trueaxis::error::Field;
use trueaxis::machine::{Axis, DriveFigures, FeedbackSettings, FrictionSettings, MachineSettings};
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::{AxisUncertainty, Uncertainties};
use trueaxis_tables::{Machine, build, check as warnings_of, compile, feedback_margins, feedback_margins_within};

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
    let mut refused = 0;
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
        let factor = Some(margins.factor).filter(|factor| factor.is_finite());
        near(factor, "factor", 1e-6 * margins.factor.min(100.0));
        assert_eq!(check::feedback(&machine, period_s).is_err(), margins.factor < 1.0);
        refused += usize::from(margins.factor < 1.0);
    }
    assert!((3..=25).contains(&refused), "both verdicts occur: {refused} of {}", cases.len());
}

/// The period adds to the dead time: gains accepted at 10 kHz are refused at 500 Hz, and only there.
#[test]
fn the_servo_rate_counts() {
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis");
    let mut machine = Machine::read(&sample).unwrap();
    machine.settings.contour.feedback.as_mut().unwrap().proportional = 0.8;
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
        text += &format!("[axis.{axis}]\ntravel_mm = [0, 100]\n[axis.{axis}.drive]\n{drive}{lines}");
    }
    text += &format!("[contour.feedback]\n{feedback}");
    let files = Memory::new([("machine.toml", text.as_str())]);
    Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).map_err(|error| error.to_string())
}

/// A stated resonance bounds the gains and chooses a notch; the bound is accepted; the file carries the figures in version 7.
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
    let end: Vec<f64> = bytes[bytes.len() - 68..bytes.len() - 4]
        .as_chunks::<8>()
        .0
        .iter()
        .map(|raw| f64::from_le_bytes(*raw))
        .collect();
    assert_eq!(end, [0.0, 120.0, 0.02, 0.0, 0.0, 120.0, 0.02, 0.0]);
    let file = Tcomp::parse(&bytes).unwrap();
    assert_eq!(Machine::from_tcomp(&file), known);
    // Without them the file is that of an older version.
    assert_eq!(compile(&resonant("", &gains).unwrap()).unwrap()[8..10], [4, 0]);
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
    assert!(most(Some(9.0), None) < 0.95 * stated, "{}", most(Some(9.0), None));
    assert!(most(None, Some(0.005)) < 0.97 * stated, "{}", most(None, Some(0.005)));
}

/// Without figures nothing is refused, and the safe gain is named; with a lowest resonance it is required.
#[test]
fn an_unknown_resonance_is_a_warning() {
    let unknown = resonant("", "").unwrap();
    build(&unknown, 1000.0).unwrap();
    let warnings: Vec<String> = warnings_of(&unknown, 1000.0).iter().map(ToString::to_string).collect();
    let found = warnings.iter().find(|text| text.contains("nothing is stated about resonances")).unwrap();
    assert!(found.contains("above 100 Hz of 2 % damping up to K_p 0.1"), "{found}");
    assert!(found.contains("lowest_resonance_hz"), "{found}");
    let lowest = resonant("lowest_resonance_hz = 100\n", "").unwrap();
    let error = build(&lowest, 1000.0).unwrap_err();
    let bound = error.bound.unwrap();
    assert!(found.contains(&format!("up to K_p {bound};")), "{found} {bound}");
    assert!(!warnings_of(&lowest, 1000.0).iter().any(|warning| warning.to_string().contains("nothing is stated")));
    // The higher the lowest resonance, the larger the gain.
    let higher = build(&resonant("lowest_resonance_hz = 180\n", "").unwrap(), 1000.0).unwrap_err();
    assert!(higher.bound.unwrap() > 1.2 * bound, "{higher}");
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
            "resonance_hz = 120\nresonance_damping = 0.02\nresonance_u_hz = 60\n",
            "resonance_u_hz: found 60, needed less than half of resonance_hz",
        ),
        ("resonance_u_hz = 1\n", "resonance_u_hz: found 1, needed less than half of resonance_hz"),
        (
            "resonance_hz = 120\nresonance_damping = 0.02\nresonance_damping_u = -1\n",
            "resonance_damping_u: found -1, needed a standard uncertainty",
        ),
    ] {
        let error = resonant(lines, "").unwrap_err();
        assert!(error.contains(expected), "{error}\n{expected}");
    }
}
