//! Short legs that turn by almost 180°, with stops, on axes with unequal lag: the foot must be on the leg on which the tip is.

use crate::common::machine;
use std::f64::consts::PI;
use std::fmt::Write;
use trueaxis::contour::Flags;
use trueaxis_sim::program::Program;
use trueaxis_sim::run::{Kind, Moment, Run, Sample};
use trueaxis_sim::{Scenario, Settings};
use trueaxis_testing::noise::Noise;

/// Bound on the error of the estimate, µm: the estimated tip changes the side of its play where the command turns, up to 3.2
/// µm, before the axis does.
const MOST_OFF: f32 = 3.5;
const RATES: [f64; 4] = [1e3, 2e3, 4e3, 8e3];

/// A program of legs, each given by its length in mm and the turn after it.
fn program(feed: f64, mut angle: f64, legs: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut text = format!("G21 G90 G17 G61.1 F{feed:.0}\nG0 X0 Y0 Z0\n");
    let (mut x, mut y) = (0.0, 0.0);
    for (length, turn) in legs {
        (x, y) = (x + length * f64::cos(angle), y + length * f64::sin(angle));
        writeln!(text, "G1 X{x:.6} Y{y:.6}").unwrap();
        angle += turn;
    }
    text + "M2\n"
}

/// Largest error of the estimate in cycles that do not hold the feedback; largest true error with geometric compensation alone
/// and with full compensation; µm.
fn follow(text: &str, gains: [f64; 2], rate_hz: f64) -> (f32, [f32; 2]) {
    let mut settings = Settings { rate_hz, ..Settings::default() };
    for (axis, gain) in ["X", "Y"].iter().zip(gains) {
        settings.set(&format!("axis.{axis}.gain_factor"), &format!("{gain:.6}")).unwrap();
    }
    let program = Program::parse("legs", text, "legs.ngc").unwrap();
    let kinds = [Kind::Compensated, Kind::Full];
    let mut run = Run::of(Scenario::new(machine(), program, settings).unwrap(), &kinds).unwrap();
    let (mut most_off, mut largest) = (0.0_f32, [0.0_f32; 2]);
    let mut sink = |moment: &Moment, machines: &[Option<&Sample>]| {
        if !moment.cutting {
            return;
        }
        for (largest, sample) in largest.iter_mut().zip(machines) {
            let sample = sample.expect("no machine stops");
            *largest = largest.max(sample.error_um());
            let flags = sample.contour_flags;
            let held = [Flags::SECOND_MINIMUM, Flags::AT_CORNER, Flags::AT_END, Flags::COLD];
            let holds = !flags.has(Flags::BRACKETED) || held.iter().any(|flag| flags.has(*flag));
            let off = (sample.estimated_um - sample.error_um()).abs();
            if !holds {
                most_off = most_off.max(off);
            }
        }
    };
    while run.advance(u64::MAX, &mut sink) {}
    (most_off, largest)
}

/// A foot that stays on the previous leg is off by hundreds of micrometres here, and the feedback pulls the tool there.
#[test]
fn on_stitches_that_turn_back_the_estimate_is_true_or_flagged_and_feedback_does_no_harm() {
    let stitches = |turn: f64| {
        (0..24).map(move |k| {
            if k % 5 == 3 {
                turn
            } else if k % 5 == 4 {
                -turn
            } else {
                0.0
            }
        })
    };
    for (length, turn, feed, gains) in
        [(0.376, 3.1, 106.0, [0.9, 1.1]), (1.0, 3.0, 200.0, [0.9, 1.1]), (1.0, 3.0, 200.0, [0.75, 1.3])]
    {
        let text = program(feed, 0.99, stitches(turn).map(|turn| (length, turn)));
        for rate_hz in RATES {
            let (off, [geometry, all]) = follow(&text, gains, rate_hz);
            assert!(off < MOST_OFF, "{rate_hz} Hz, {length} mm: estimate off by {off} µm");
            assert!(all < geometry, "{rate_hz} Hz, {length} mm: {all} µm, {geometry} µm without the dynamic part");
        }
    }
}

#[test]
fn on_random_legs_that_turn_back_the_estimate_is_true_or_flagged_and_feedback_does_no_harm() {
    let mut random = Noise::new(5);
    for rate_hz in RATES {
        for number in 0..6 {
            let gains = [random.range(0.7, 1.0), random.range(1.0, 1.3)];
            let (feed, angle) = (random.range(100.0, 400.0), random.range(-PI, PI));
            let legs: Vec<_> =
                (0..8).map(|_| (random.range(0.3, 1.0), random.range(2.5, PI) * random.signed().signum())).collect();
            let (off, [geometry, all]) = follow(&program(feed, angle, legs), gains, rate_hz);
            assert!(off < MOST_OFF, "{rate_hz} Hz, path {number}: estimate off by {off} µm");
            assert!(
                all < geometry + 0.5,
                "{rate_hz} Hz, path {number}: {all} µm, {geometry} µm without the dynamic part"
            );
        }
    }
}
