//! The servo in a predicted part, by the formulas of a position loop.

use std::ops::{Add, Div, Mul};
use std::path::Path;
use trueaxis_evaluation::predict::{Options, Part, PredictDocument, advise, elsewhere, predict_with_servo};
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;
use trueaxis_testing::noise::Noise;
use trueaxis_testing::scatter::normal;

/// Gain of the position loop, 1/s; radius, mm, and speed, mm/s.
const GAIN: f64 = 60.0;
const RADIUS: f64 = 15.0;
const SPEED: f64 = 30.0;
/// Three turns, of which the second is the feature; far away before it a hole that is none.
const PROGRAM: &str = "G21 G90 G17 G94 F1800\nG0 X90 Y90 Z5\nG1 Z-5\nG0 Z5\nG0 X90 Y0\nG0 X80\nG0 X70\nG0 X15 Y0\nG1 Z0\n\
                       G3 X15 Y0 I-15 J0\nG3 X15 Y0 I-15 J0\nG3 X15 Y0 I-15 J0\nG0 Z5\nM2\n";
const PART: &str = "name = \"ring\"\nat_mm = [0, 0, -50]\n\
                    [[feature]]\nname = \"bore\"\nkind = \"circle\"\nlines = [11, 11]\n\
                    [[tolerance]]\nfeature = \"bore\"\nkind = \"size\"\nlimits_um = [-5, 5]\n\
                    [[tolerance]]\nfeature = \"bore\"\nkind = \"roundness\"\nwidth_um = 5\n";

/// Three equal drives without feed-forward or friction. EXX is 0.1 µm/mm.
fn predicted(servo: &str, temperature: &str) -> anyhow::Result<PredictDocument> {
    with_program(servo, temperature, PROGRAM)
}

fn with_program(servo: &str, temperature: &str, program: &str) -> anyhow::Result<PredictDocument> {
    driven(&small(servo, temperature, program))
}

type Small = (Machine, Uncertainties, Program, Part);

fn small(servo: &str, temperature: &str, program: &str) -> Small {
    let axis = |letter: &str, table: &str| {
        format!("[axis.{letter}]\n{table}travel_mm = [-100, 100]\n{}", servo.replace("AXIS", letter))
    };
    let toml = format!(
        "name = \"small\"\nchain = \"w X' Y' b Z t\"\n{}{}{}[axis.X.uncertainty]\nscale_ppm = 10\n\
         [axis.Y.thermal]\nexpansion_um_per_m_k = 10\n",
        axis("X", "table = \"x.csv\"\n"),
        axis("Y", ""),
        axis("Z", "")
    );
    let files = Memory::new([("machine.toml", toml.as_str()), ("x.csv", "X_mm,EXX_um\n-100,-10\n100,10\n")]);
    let file = Path::new("machine.toml");
    let machine = Machine::read_from(&files, file, &mut |_| {}).unwrap();
    let stated = Uncertainties::read_from(&files, file).unwrap();
    let program = Program::parse("ring", program, "ring.ngc").unwrap();
    let part = Part::read(&format!("{PART}{temperature}"), Path::new("part.toml")).unwrap();
    (machine, stated, program, part)
}

fn driven((machine, stated, program, part): &Small) -> anyhow::Result<PredictDocument> {
    let options = Options { trials: 2000, seed: 3 };
    let (mut all, mut last) = (0, 0);
    let document = predict_with_servo((machine, stated), program, part, options, 10_000.0, &mut |done, of| {
        assert!(done >= last && done <= of);
        (all, last) = (of, done);
    })?;
    assert!(all > 0 && all == last);
    Ok(document)
}

fn drive(more: &str) -> String {
    format!(
        "[axis.AXIS.limits]\nmagnitude_um = 1000\n[axis.AXIS.drive]\nposition_gain_per_s = {GAIN}\n\
         velocity_gain_per_s = 800\nreset_time_s = 0.006\nlowest_resonance_hz = 1000\n{more}"
    )
}

/// |1/(1 + iω/K_v)| ≈ 1 − (ω/K_v)²/2. The loop's dead time of a period and a half widens the circle by less than 2 % of that.
#[test]
fn a_circle_shrinks_by_the_second_order_of_the_position_loop() {
    let shrunk = -2e3 * RADIUS * (SPEED / RADIUS / GAIN).powi(2) / 2.0;
    assert!((shrunk + 16.7).abs() < 0.1);
    // A scale of X alone counts half in the diameter.
    let scale = 1e3 * RADIUS * 1e-4;
    let of = predicted(&drive(""), "").unwrap();
    let [size, roundness] = &of.features[..] else { panic!() };
    for (name, found, wanted) in [
        ("uncorrected", size.uncorrected_um, shrunk + scale),
        ("corrected", size.corrected_um, shrunk),
        ("nothing to switch on", size.everything_um.unwrap(), shrunk),
    ] {
        assert!((found - wanted).abs() < 0.03 * shrunk.abs(), "{name}: {found} for {wanted}");
    }
    // Equal drives leave it round; the table's scale makes an ellipse of the uncorrected one.
    assert!(roundness.corrected_um < 0.3, "{}", roundness.corrected_um);
    assert!((roundness.uncorrected_um - scale).abs() < 0.3, "{}", roundness.uncorrected_um);
    // 10 ppm over half of the diameter.
    let known = size.known.as_ref().unwrap();
    assert!((known.expanded_um - 1.96 * 0.15).abs() < 0.02, "{}", known.expanded_um);
    assert_eq!(known.verdict, "does not conform");
    let servo = of.servo.unwrap();
    // The drilling and the way to it are left out.
    assert!(servo.moves[0] < servo.moves[1] && servo.machines.len() == 2, "{servo:?}");
    assert!((9.0..14.0).contains(&servo.simulated_s), "{}", servo.simulated_s);

    let lag = drive("[axis.AXIS.dynamic]\nlag = true\nmagnitude_um = 1000\n");
    let of = predicted(&lag, "[temperature]\nmachine_c = 25\n").unwrap();
    let size = &of.features[0];
    // Growth of Y: 10 µm/(m K) over 5 K and half of the diameter.
    let grown = 1e3 * RADIUS * 50e-6;
    assert!((size.uncorrected_um - shrunk - scale - grown).abs() < 0.5, "{}", size.uncorrected_um);
    assert!((size.corrected_um - shrunk).abs() < 0.5, "{}", size.corrected_um);
    let left = size.everything_um.unwrap();
    assert!(left.abs() < 0.05 * shrunk.abs(), "{left}");
    assert_eq!(size.known.as_ref().unwrap().verdict, "conforms");
}

#[test]
fn a_machine_without_figures_of_its_drives_is_refused() {
    let refused = predicted("", "").unwrap_err().to_string();
    assert!(refused.contains("small: key axis.X.drive: found nothing, needed position_gain_per_s"), "{refused}");
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
    let small = small(&drive(&uncertain), "[[instrument]]\nkind = \"ball\"\n", SHORT);
    let of = driven(&small).unwrap();
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
    println!(
        "held {own:?}, with twice the uncertainty {twice:?}; intervals {:?}",
        known.iter().map(|of| of.interval_um).collect::<Vec<_>>()
    );
    println!(
        "stated {:?}, found {:?}",
        circle(stated),
        of.features.iter().map(|of| of.everything_um).collect::<Vec<_>>()
    );
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
fn a_gain_that_is_hardly_known_is_refused() {
    let uncertain = "[axis.AXIS.drive.uncertainty]\nposition_gain_per_s = 20\n";
    let refused = predicted(&drive(uncertain), "").unwrap_err().to_string();
    let needed = "small: key axis.X.drive.uncertainty.position_gain_per_s: found 20, needed at most 30 % of 60";
    assert!(refused.starts_with(needed), "{refused}");
}
