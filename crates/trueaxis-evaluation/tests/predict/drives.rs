//! Uncertain drives of a predicted part, by the frequency response of their loops.

use super::servo::{GAIN, PART, RADIUS, SPEED, Small, drive, driven, machine, small};
use std::ops::{Add, Div, Mul};
use trueaxis_evaluation::predict::{PredictDocument, advise, elsewhere};
use trueaxis_testing::noise::Noise;
use trueaxis_testing::scatter::normal;

const RATE_HZ: f64 = 10_000.0;

/// Three axes with these drives, and a part with its instruments.
fn with(servo: &str, instruments: &str, program: &str) -> Small {
    small(&machine("w X' Y' b Z t", servo), program, &format!("{PART}{instruments}"))
}

/// A complex number.
#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Add for Complex {
    type Output = Complex;
    fn add(self, b: Complex) -> Complex {
        Complex(self.0 + b.0, self.1 + b.1)
    }
}

impl Mul for Complex {
    type Output = Complex;
    fn mul(self, b: Complex) -> Complex {
        Complex(self.0 * b.0 - self.1 * b.1, self.0 * b.1 + self.1 * b.0)
    }
}

impl Div for Complex {
    type Output = Complex;
    fn div(self, b: Complex) -> Complex {
        let square = b.0 * b.0 + b.1 * b.1;
        self * Complex(b.0 / square, -b.1 / square)
    }
}

/// Amplitude and phase of an axis over its command at the circle's frequency: a position loop sampled every 0.1 ms about a
/// velocity loop with PI controller and a mass.
fn response(position_gain: f64, velocity_gain: f64) -> [f64; 2] {
    let (real, period, omega) = (|x: f64| Complex(x, 0.0), 1e-4, SPEED / RADIUS);
    let s = Complex(0.0, omega);
    let (sin, cos) = (omega * period).sin_cos();
    let held = Complex(1.0 - cos, sin) / (s * real(period));
    let velocity = real(velocity_gain) * (real(1.0) + real(1.0) / (real(0.006) * s)) / (real(1.0) + real(2.5e-4) * s);
    let mass = real(1.0) / (s * s);
    let forward = velocity * held * real(position_gain) * mass;
    let Complex(re, im) = forward / (real(1.0) + velocity * s * mass + forward);
    [re.hypot(im), im.atan2(re)]
}

/// Diameter beyond that of the program, and distance of the two circles about the middle that enclose an ellipse, µm: it has
/// the first order of what X and Y differ by in amplitude and phase.
fn circle([x, y]: [[f64; 2]; 2]) -> [f64; 2] {
    let size = RADIUS * (x[0] + y[0] - 2.0);
    let roundness = RADIUS * (x[0] - y[0]).hypot(x[1] - y[1]);
    [1e3 * size, 1e3 * roundness]
}

/// Standard uncertainties of the gains, 1/s.
const KNOWN: [f64; 2] = [1.0, 40.0];
const MACHINES: u32 = 4000;
/// One turn before that of the feature and one after it.
const SHORT: &str = "G21 G90 G17 G94 F1800\nG0 X15 Y0 Z5\nG0 Z4\nG0 Z3\nG0 Z2\nG0 Z1\nG0 Z0.5\nG0 Z0.2\nG1 Z0\n\
                     G3 X15 Y0 I-15 J0\nG3 X15 Y0 I-15 J0\nG3 X15 Y0 I-15 J0\nG0 Z5\nM2\n";

/// The machines have gains of their own; their circles follow from the closed loops alone. The prediction must contain 95 % of
/// them, and must not where the gains are twice as uncertain.
#[test]
fn circles_of_drawn_drives_are_within_their_intervals() {
    let uncertain = format!(
        "[axis.AXIS.drive.uncertainty]\nposition_gain_per_s = {}\nvelocity_gain_per_s = {}\n",
        KNOWN[0], KNOWN[1]
    );
    let small = with(&drive(&uncertain), "[[instrument]]\nkind = \"ball\"\n", SHORT);
    let of = driven(&small, RATE_HZ).unwrap();
    let servo = of.servo.as_ref().unwrap();
    // Z rests.
    let figures = ["position gain of X", "velocity gain of X", "position gain of Y", "velocity gain of Y"];
    assert_eq!(servo.figures, figures);
    // Second order of a gain: 3/2 u/K z² beside z, u/K = 1/60.
    assert!((0.01..0.08).contains(&servo.departure.unwrap()), "{:?} {:?}", servo.departure, of.warnings);
    let known: Vec<_> = of.features.iter().map(|of| of.known.as_ref().unwrap()).collect();
    check_advice(&small, &of);

    // One axis alone, one standard uncertainty off.
    let stated = [response(GAIN, 800.0); 2];
    let off = circle([response(GAIN + KNOWN[0], 800.0), stated[1]])[0] - circle(stated)[0];
    for name in ["position gain of X", "position gain of Y"] {
        let found = known[0].budget.iter().find(|one| one.term == name).unwrap().standard_um;
        assert!((found - off).abs() < 0.06 * off, "{name}: {found} for {off}");
    }

    // The plant moves in steps of 0.1 ms, the formula does not.
    let off = of.features[0].everything_um.unwrap() - circle(stated)[0];
    assert!(off.abs() < 0.4 && of.features[1].everything_um.unwrap() < 0.3, "{off}");
    let mut noise = Noise::new(7);
    let mut held = |wider: f64| -> [f64; 2] {
        let mut inside = [0; 2];
        for _ in 0..MACHINES {
            let mut gains =
                || [GAIN + wider * KNOWN[0] * normal(&mut noise), 800.0 + wider * KNOWN[1] * normal(&mut noise)];
            let mut axes = [gains(), gains()].map(|[position, velocity]| response(position, velocity));
            // The scale of X.
            axes[0][0] += 1e-5 * normal(&mut noise);
            let [size, roundness] = circle(axes);
            for ((inside, value), known) in inside.iter_mut().zip([size + off, roundness]).zip(&known) {
                let interval = known.interval_um;
                *inside += u32::from((interval.low..=interval.high).contains(&value));
            }
        }
        inside.map(|count| f64::from(count) / f64::from(MACHINES))
    };
    let (own, twice) = (held(1.0), held(2.0));
    println!("held {own:?}, with twice the uncertainty {twice:?}");
    for (own, twice) in own.into_iter().zip(twice) {
        assert!((own - 0.95).abs() < 0.02 && twice < 0.85, "{own} {twice}");
    }
}

/// What no ball shows stays: the advice has the drives as the prediction has them.
fn check_advice((machine, stated, program, part): &Small, of: &PredictDocument) {
    let advice = advise(machine, stated, program, part, of, &|_| unreachable!()).unwrap();
    let roundness = &advice.features[1];
    assert_eq!([roundness.verdict_before, roundness.verdict_after], ["undecided"; 2]);
    let left: Vec<(&str, bool)> = roundness.left.iter().map(|of| (of.term.as_str(), of.is_measured)).collect();
    assert!(left.contains(&("position gain of X", false)) && left.contains(&("position gain of Y", false)), "{left:?}");
    assert!((roundness.after_um / roundness.before_um - 1.0).abs() < 0.1, "{roundness:?}");
    let elsewhere = elsewhere(machine, stated, program, part, of).unwrap();
    assert!(elsewhere.without_servo && elsewhere.places_compared > 1, "{elsewhere:?}");
}

#[test]
fn drives_taken_as_exact_have_no_runs_of_their_own() {
    let uncertain = "[axis.AXIS.drive.uncertainty]\nposition_gain_per_s = 1\n";
    let (machine, stated, program, part) = with(&drive(uncertain), "", SHORT);
    let of = driven(&(machine, stated.with_exact_drives(), program, part), RATE_HZ).unwrap();
    let servo = of.servo.as_ref().unwrap();
    assert!(servo.figures.is_empty() && servo.plants == 0 && servo.departure.is_none(), "{servo:?}");
    assert!(
        of.features[0].known.is_some() && !of.not_stated.iter().any(|key| key.contains("drive")),
        "{:?}",
        of.not_stated
    );
}

#[test]
fn a_gain_that_is_hardly_known_is_refused() {
    let uncertain = "[axis.AXIS.drive.uncertainty]\nposition_gain_per_s = 20\n";
    let refused = driven(&with(&drive(uncertain), "", SHORT), RATE_HZ).unwrap_err().to_string();
    let needed = "small: key axis.X.drive.uncertainty.position_gain_per_s: found 20, needed at most 30 % of 60";
    assert!(refused.starts_with(needed), "{refused}");
}
