//! Margins of the contour feedback compared with reference values, and the effect of the servo rate.

use serde_json::Value;
use std::path::Path;
use trueaxis::check;
use trueaxis::error::Field;
use trueaxis::machine::{Axis, DriveFigures, FeedbackSettings, FrictionSettings, MachineSettings};
use trueaxis_tables::{Machine, build, feedback_margins};

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
