//! The servo in a predicted part, by the formula of a position loop.

use std::path::Path;
use trueaxis_evaluation::predict::{Options, Part, PredictDocument, predict_with_servo};
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;

/// Gain of the position loop, 1/s; radius, mm, and speed, mm/s.
pub(super) const GAIN: f64 = 60.0;
pub(super) const RADIUS: f64 = 15.0;
pub(super) const SPEED: f64 = 30.0;
/// Three turns, of which the second is the feature; far away before it a hole that is none.
const PROGRAM: &str = "G21 G90 G17 G94 F1800\nG0 X90 Y90 Z5\nG1 Z-5\nG0 Z5\nG0 X90 Y0\nG0 X80\nG0 X70\nG0 X15 Y0\nG1 Z0\n\
                       G3 X15 Y0 I-15 J0\nG3 X15 Y0 I-15 J0\nG3 X15 Y0 I-15 J0\nG0 Z5\nM2\n";
pub(super) const PART: &str = "name = \"ring\"\nat_mm = [0, 0, -50]\n\
                    [[feature]]\nname = \"bore\"\nkind = \"circle\"\nlines = [11, 11]\n\
                    [[tolerance]]\nfeature = \"bore\"\nkind = \"size\"\nlimits_um = [-5, 5]\n\
                    [[tolerance]]\nfeature = \"bore\"\nkind = \"roundness\"\nwidth_um = 5\n";

/// Three equal drives without feed-forward or friction. EXX is 0.1 µm/mm.
pub(super) fn machine(chain: &str, servo: &str) -> String {
    let axis = |letter: &str, table: &str| {
        format!("[axis.{letter}]\n{table}travel_mm = [-100, 100]\n{}", servo.replace("AXIS", letter))
    };
    format!(
        "name = \"small\"\nchain = \"{chain}\"\n{}{}{}[axis.X.uncertainty]\nscale_ppm = 10\n",
        axis("X", "table = \"x.csv\"\n"),
        axis("Y", ""),
        axis("Z", "")
    )
}

fn predicted(servo: &str, temperature: &str) -> anyhow::Result<PredictDocument> {
    let grows = "[axis.Y.thermal]\nexpansion_um_per_m_k = 10\n";
    document(&format!("{}{grows}", machine("w X' Y' b Z t", servo)), PROGRAM, &format!("{PART}{temperature}"), 10_000.0)
}

fn document(toml: &str, program: &str, part: &str, rate_hz: f64) -> anyhow::Result<PredictDocument> {
    driven(&small(toml, program, part), rate_hz)
}

pub(super) type Small = (Machine, Uncertainties, Program, Part);

pub(super) fn small(toml: &str, program: &str, part: &str) -> Small {
    let files = Memory::new([("machine.toml", toml), ("x.csv", "X_mm,EXX_um\n-100,-10\n100,10\n")]);
    let file = Path::new("machine.toml");
    let machine = Machine::read_from(&files, file, &mut |_| {}).unwrap();
    let stated = Uncertainties::read_from(&files, file).unwrap();
    let program = Program::parse("ring", program, "ring.ngc").unwrap();
    let part = Part::read(part, Path::new("part.toml")).unwrap();
    (machine, stated, program, part)
}

pub(super) fn driven((machine, stated, program, part): &Small, rate_hz: f64) -> anyhow::Result<PredictDocument> {
    let options = Options { trials: 2000, seed: 3 };
    let (mut all, mut last) = (0, 0);
    let document = predict_with_servo((machine, stated), program, part, options, rate_hz, &mut |done, of| {
        assert!(done >= last && done <= of);
        (all, last) = (of, done);
    })?;
    assert!(all > 0 && all == last);
    Ok(document)
}

pub(super) fn drive(more: &str) -> String {
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

/// X is off by 0.1 µm/mm and grows by 0.25 µm/mm: together up to 5.25 µm, of which the limit lets 2 µm be corrected.
#[test]
fn growth_beyond_the_limit_of_an_axis_is_left_beside_the_servo() {
    let drive = drive("").replace("magnitude_um = 1000", "magnitude_um = 2");
    let grows = "[axis.X.thermal]\nexpansion_um_per_m_k = 10\n";
    let size = |temperature: &str| {
        let toml = format!("{}{grows}", machine("w X' Y' b Z t", &drive));
        let of = document(&toml, PROGRAM, &format!("{PART}{temperature}"), 10_000.0).unwrap();
        let noted = of.warnings.iter().any(|note| note.contains("magnitude_um is 2"));
        ([of.features[0].uncorrected_um, of.features[0].corrected_um], noted)
    };
    let (cold, is_cold_noted) = size("");
    let (warm, is_warm_noted) = size("[temperature]\nmachine_c = 45\n");
    assert!(!is_cold_noted && is_warm_noted);
    let left = |cosine: f64| cosine.abs() * (5.25 * cosine.abs() - 2.0).max(0.0);
    let mean = (0..720).map(|k| left(f64::from(k).to_radians().cos())).sum::<f64>() / 720.0;
    // Of growth alone half of 0.25 µm/mm counts in the diameter of 30 mm.
    for (state, wanted) in [(0, 0.25 * RADIUS), (1, 2.0 * mean)] {
        let found = warm[state] - cold[state];
        assert!((found - wanted).abs() < 0.03 && wanted > 1.0, "{state}: {found} for {wanted}");
    }
}

/// Servo rate of runs that turn the table, Hz: its dead time widens a circle by less than 5 % of what the loop takes.
const TABLE_RATE_HZ: f64 = 4000.0;
/// Gain of the table's position loop, 1/s; distance of the circle from the table's axis, mm.
const TABLE_GAIN: f64 = 40.0;
const ASIDE: f64 = 10.0;

/// Uncorrected diameter and position of a circle on a table under the tool centre point, µm: a quarter, and the turn that
/// is the feature; `turns`: of the table for each of the circle.
fn on_table(turns: i32, aside: f64) -> [f64; 2] {
    let table = drive("").replace("AXIS", "C").replace(&format!("= {GAIN}"), &format!("= {TABLE_GAIN}"));
    let table = table.replace("[axis.C.limits]\nmagnitude_um = 1000\n", "");
    let toml = machine("w C' b X Y Z t", &drive(""))
        + "[axis.C]\ntravel_deg = [-2000, 2000]\nmax_feed_deg_per_min = 20000\n"
        + &table;
    let start = aside + RADIUS;
    let quarter = format!("G3 X{aside} Y{RADIUS} I-{RADIUS} J0 C{}\n", 90 * turns);
    let whole = format!("G3 X{aside} Y{RADIUS} I0 J-{RADIUS} C{}\n", 450 * turns);
    let program = format!("G21 G90 G17 G94 F1800\nG43.4\nG0 X{start} Y0 Z1\nG1 Z0\n{quarter}{whole}G0 Z1\nM2\n");
    let part = "name = \"ring\"\nat_mm = [0, 0, -50]\n\
                [[feature]]\nname = \"bore\"\nkind = \"circle\"\nlines = [6, 6]\n\
                [[tolerance]]\nfeature = \"bore\"\nkind = \"size\"\nlimits_um = [-5, 5]\n\
                [[tolerance]]\nfeature = \"bore\"\nkind = \"position\"\nwidth_um = 5\n";
    let of = document(&toml, &program, part, TABLE_RATE_HZ).unwrap();
    [0, 1].map(|k| of.features[k].corrected_um)
}

/// The workpiece is at e^(iφ) times the axes: the table at rest leaves the circle to X and Y; turning with it, to nothing but
/// itself; turning against it, X and Y go round twice as fast and shrink four times as much.
#[test]
fn a_circle_on_a_table_shrinks_by_what_is_left_to_x_and_y() {
    let shrunk = -2e3 * RADIUS * (SPEED / RADIUS / GAIN).powi(2) / 2.0;
    let toml = machine("w b X Y Z t", &drive(""));
    let three_axes = document(&toml, PROGRAM, PART, TABLE_RATE_HZ).unwrap().features[0].corrected_um;
    let at_rest = on_table(0, 0.0)[0];
    assert!((at_rest - three_axes).abs() < 0.02, "{at_rest} for {three_axes}");
    let turned = [1, -1].map(|turns| on_table(turns, 0.0)[0]);
    assert!(turned[0].abs() < 0.1, "{turned:?}");
    assert!((turned[1] / shrunk - 4.0).abs() < 0.2, "{turned:?} for {shrunk}");
}

/// Beside the table's axis by e, X and Y go round by e against the table: they lag by ω/K_v, the table by ω/K_C, and the
/// circle is turned about the axis by the difference. Its size is the table's alone.
#[test]
fn a_table_that_lags_more_than_x_and_y_misplaces_a_circle() {
    let turn = SPEED / RADIUS * (1.0 / TABLE_GAIN - 1.0 / GAIN);
    let [size, position] = on_table(1, ASIDE);
    let wanted = 2e3 * ASIDE * turn;
    assert!((position / wanted - 1.0).abs() < 0.02, "{position} for {wanted}");
    assert!(size.abs() < 1.0, "{size}");
}
