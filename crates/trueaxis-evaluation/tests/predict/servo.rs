//! The servo in a predicted part, by the formula of a position loop.

use std::path::Path;
use trueaxis_evaluation::predict::{Options, Part, PredictDocument, predict_with_servo};
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;

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
    let program = Program::parse("ring", PROGRAM, "ring.ngc").unwrap();
    let part = Part::read(&format!("{PART}{temperature}"), Path::new("part.toml")).unwrap();
    let options = Options { trials: 2000, seed: 3 };
    let (mut all, mut last) = (0, 0);
    let document = predict_with_servo((&machine, &stated), &program, &part, options, 10_000.0, &mut |done, of| {
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
    // The picture shows the same, half of it at the radius; the lag is along the circle.
    let shape = &of.shapes[0];
    let turns = shape.points_mm.iter().zip(&shape.corrected_um).zip(shape.everything_um.as_ref().unwrap());
    for (([x, y, _], corrected), everything) in turns {
        let radius_um = |um: &[f64; 3]| 1e3 * ((x + 1e-3 * um[0]).hypot(y + 1e-3 * um[1]) - RADIUS);
        let [corrected, everything] = [corrected, everything].map(radius_um);
        assert!((corrected - 0.5 * shrunk).abs() < 0.5 && everything == corrected, "{corrected} and {everything}");
    }
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
