//! Advice on parts of several set-ups and on machines with rotary axes, by formulas and places of its own.

use std::path::Path;
use trueaxis_evaluation::calibrate::Task;
use trueaxis_evaluation::predict::{Advice, Elsewhere, Options, Part, PredictDocument, advise, elsewhere, predict};
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;

/// Standard uncertainty of the scale of X, and of that after a laser: its length, 0.7 ppm, and 0.2 µm a reading at eleven
/// positions 20 mm apart, in both directions.
const SCALE: f64 = 25e-6;
fn scale_after() -> f64 {
    let slope = 0.2e-3 / (2.0 * 20f64.powi(2) * 110.0).sqrt();
    1.0 / (1.0 / SCALE.powi(2) + 1.0 / (0.7e-6_f64.powi(2) + slope * slope)).sqrt()
}
const LASER: &str = "[[instrument]]\nkind = \"laser\"\nalong = [\"X\"]\n";

/// A machine, a part and its programs.
struct Asked {
    machine: Machine,
    stated: Uncertainties,
    first: Program,
    part: Part,
}

impl Asked {
    fn of(toml: &str, first: &str, second: &str, part: &str) -> Asked {
        let files = Memory::new([("machine.toml", toml), ("x.csv", "X_mm,EXX_um\n-200,-20\n200,20\n")]);
        let file = Path::new("machine.toml");
        let mut part = Part::read(part, Path::new("part.toml")).unwrap();
        part.read_setups(|file| Program::parse("second", second, file)).unwrap();
        Asked {
            machine: Machine::read_from(&files, file, &mut |_| {}).unwrap(),
            stated: Uncertainties::read_from(&files, file).unwrap(),
            first: Program::parse("first", first, "first.ngc").unwrap(),
            part,
        }
    }

    fn predicted(&self, trials: u64, at_mm: [f64; 3]) -> PredictDocument {
        let part = Part { at_mm, ..self.part.clone() };
        predict(&self.machine, &self.stated, &self.first, &part, Options { trials, seed: 5 }).unwrap()
    }

    fn advice(&self) -> Advice {
        let predicted = self.predicted(4000, self.part.at_mm);
        let none = |_: &str| -> anyhow::Result<Task> { unreachable!() };
        advise(&self.machine, &self.stated, &self.first, &self.part, &predicted, &none).unwrap()
    }

    fn elsewhere(&self) -> Elsewhere {
        let predicted = self.predicted(200, self.part.at_mm);
        elsewhere(&self.machine, &self.stated, &self.first, &self.part, &predicted).unwrap()
    }

    /// Characteristics that conform at a place, and the largest share of a tolerance.
    fn rated(&self, at_mm: [f64; 3]) -> (usize, f64) {
        let of = self.predicted(200, at_mm).features;
        let conforms = of.iter().filter(|of| of.known.as_ref().unwrap().verdict == "conforms").count();
        (conforms, of.iter().map(|of| of.used()).fold(0.0, f64::max))
    }
}

fn linear(chain: &str, x: &str) -> String {
    let axes = ["Y", "Z"].map(|letter| format!("[axis.{letter}]\ntravel_mm = [-200, 200]\n"));
    format!("name = \"asked\"\nchain = \"{chain}\"\n[axis.X]\n{x}{}", axes.concat())
}

fn holes(at: &[[i32; 2]]) -> String {
    let hole = |[x, y]: &[i32; 2]| format!("G0 X{x} Y{y}\nG1 Z-5\nG0 Z5\n");
    format!("G21 G90 G17 G94 F600\nG0 X0 Y0 Z5\n{}M2\n", at.iter().map(hole).collect::<String>())
}

fn hole(name: &str, line: u32, more: &str) -> String {
    format!("[[feature]]\nname = \"{name}\"\nkind = \"hole\"\nlines = [{line}, {line}]\n{more}")
}

fn distance(of: &str, from: &str, limit: f64) -> String {
    format!(
        "[[tolerance]]\nfeature = \"{of}\"\nkind = \"distance\"\nfrom = \"{from}\"\nlimits_um = [-{limit}, {limit}]\n"
    )
}

/// The second set-up is turned by a quarter: 80 mm along X are from 150 to 70 mm on the part's Y.
#[test]
fn what_a_laser_leaves_of_a_part_of_two_set_ups() {
    let toml =
        linear("w b X Y Z t", &format!("travel_mm = [-100, 100]\n[axis.X.uncertainty]\nscale_ppm = {}\n", 1e6 * SCALE));
    let part = format!(
        "name = \"two\"\nat_mm = [0, 0, -50]\n[[setup]]\nname = \"s\"\nprogram = \"s.ngc\"\nat_mm = [0, 0, -50]\n\
         zero_mm = [0, 150, 0]\nturned_deg = [0, 0, 90]\nuncertainty_um = [1, 0, 0]\n{}{}{}{}{}{}{LASER}",
        hole("one", 4, ""),
        hole("two", 7, ""),
        hole("three", 4, "setup = \"s\"\n"),
        distance("two", "one", 3.0),
        distance("three", "one", 3.0),
        distance("three", "one", 1.5),
    );
    let advice = Asked::of(&toml, &holes(&[[0, 0], [80, 0]]), &holes(&[[80, 0]]), &part).advice();
    let names: Vec<&str> = advice.measurements.iter().map(|of| of.name.as_str()).collect();
    assert_eq!(names, ["laser along X"]);
    let [before, after] = [SCALE, scale_after()].map(|scale| 80e3 * scale);
    let clamped = 1.0;
    let wanted = [[before, after], [before.hypot(clamped), after.hypot(clamped)]];
    for (of, [before, after]) in advice.features.iter().zip([wanted[0], wanted[1], wanted[1]]) {
        let found = [of.before_um, of.after_um].map(|um| um / 1.96);
        let case = format!("{}: {found:?} for {before} and {after}", of.feature);
        assert!((found[0] / before - 1.0).abs() < 0.05 && (found[1] / after - 1.0).abs() < 0.05, "{case}");
    }
    let verdicts: Vec<&str> = advice.features.iter().map(|of| of.verdict_after).collect();
    assert_eq!(verdicts, ["conforms", "conforms", "undecided"]);
    let left = &advice.features[2].left[0];
    assert!(left.term == "set-up s along X" && !left.is_measured, "{left:?}");
    assert!((left.share - 1.0 / (1.0 + after * after)).abs() < 0.01, "{left:?}");
}

/// X is off by 0.1 µm/mm, and its limit corrects 5 µm of that: within 50 mm of its zero all. Only the first set-up moves there;
/// the hole of the second one stays where 10 µm are left.
#[test]
fn the_best_place_of_the_first_set_up_is_where_its_correction_suffices() {
    let x = "table = \"x.csv\"\ntravel_mm = [-200, 200]\n[axis.X.limits]\nmagnitude_um = 5\n[axis.X.uncertainty]\nscale_ppm = 1\n";
    let part = format!(
        "name = \"two\"\nat_mm = [100, 0, -50]\n[[setup]]\nname = \"s\"\nprogram = \"s.ngc\"\nat_mm = [150, 0, -50]\n{}{}{}{}\
         [[tolerance]]\nfeature = \"three\"\nkind = \"position\"\nwidth_um = 100\n",
        hole("one", 4, ""),
        hole("two", 7, ""),
        hole("three", 4, "setup = \"s\"\n"),
        distance("two", "one", 10.0),
    );
    let asked = Asked::of(&linear("w b X Y Z t", x), &holes(&[[0, 0], [60, 0]]), &holes(&[[0, 0]]), &part);
    let found = asked.elsewhere();
    let place = found.place.unwrap();
    // From −200 mm to 200 − 60 mm, 95 % of the way, and the middle.
    assert_eq!(place.at_mm[0], 100.0 + (0.95 * (-300.0 + 40.0) / 2.0_f64).trunc());
    assert_eq!(found.places_compared, 10);
    assert!((place.here - (6.0 + 1.96 * 0.06) / 10.0).abs() < 0.01, "{place:?}");
    assert!((place.there - (20.0 + 2.0 * 1.96 * 0.15) / 100.0).abs() < 0.01, "{place:?}");
    assert_eq!((place.conform[1], place.there), asked.rated(place.at_mm));
}

const TABLE: &str = "[axis.C]\ntravel_deg = [-720, 720]\n";

/// A circle of 40 mm that the table turns: an error of X at 40 mm counts twice in its diameter.
#[test]
fn what_a_laser_leaves_of_a_circle_turned_by_the_table() {
    let x = format!("travel_mm = [-100, 100]\n[axis.X.uncertainty]\nscale_ppm = {}\n", 1e6 * SCALE);
    let toml = linear("w C' b X Y Z t", &x) + TABLE;
    let program = "G21 G90 G17 G94 F600\nG0 X40 Y0 Z5\nG1 Z0\nG1 C360\nG0 Z5\nM2\n";
    let part = format!(
        "name = \"ring\"\nat_mm = [0, 0, -50]\n[[feature]]\nname = \"ring\"\nkind = \"circle\"\nlines = [4, 4]\n\
         [[tolerance]]\nfeature = \"ring\"\nkind = \"size\"\nlimits_um = [-2.5, 2.5]\n{LASER}"
    );
    let asked = Asked::of(&toml, program, "", &part);
    let advice = asked.advice();
    assert_eq!(advice.measurements[0].name, "laser along X");
    let of = &advice.features[0];
    for (found, scale) in [(of.before_um, SCALE), (of.after_um, scale_after())] {
        let wanted = 80e3 * scale;
        assert!((found / 1.96 / wanted - 1.0).abs() < 0.05, "{found} for {wanted}");
    }
    // The circle is the smaller, the nearer to the table's axis it is cut: of nine places the best one, by hand.
    let found = asked.elsewhere();
    let shift = |low: f64, high: f64| [0.0, 0.5, 1.0].map(|share: f64| (0.95 * (low + (high - low) * share)).trunc());
    let places = shift(-140.0, 60.0).into_iter().flat_map(|x| shift(-200.0, 200.0).map(|y| [x, y, -50.0]));
    let rated: Vec<(usize, f64)> = places.map(|at| asked.rated(at)).collect();
    let best = rated.iter().copied().max_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1))).unwrap();
    let place = found.place.unwrap();
    assert_eq!((place.conform[1], place.there), best, "{place:?} of {rated:?}");
    assert_eq!((place.conform[1], place.there), asked.rated(place.at_mm));
}

/// The table turns back while the rear edge is cut: its lost motion turns the edge about the axis, which the front edge has not
/// seen. Cut from its end, it turns forth.
#[test]
fn an_edge_is_better_cut_while_the_table_turns_forth() {
    let toml =
        linear("w C' b X Y Z t", "travel_mm = [-200, 200]\n") + TABLE + "[axis.C.uncertainty]\nbacklash_urad = 20\n";
    let of = |rear: &str| {
        let program = format!(
            "G21 G90 G17 G94 F600\nG43.4\nG0 X0 Y-30 Z5\nG0 Z0\nG1 X80 Y-30 C10\nG0 Z5\nG0 X0 Y30 C40\nG0 Z0\n{rear}G0 Z5\nM2\n"
        );
        let last = program.lines().position(|line| line.starts_with("G1 X") && line.contains("Y30")).unwrap() + 1;
        let line = |name: &str, line: usize| {
            format!("[[feature]]\nname = \"{name}\"\nkind = \"line\"\nlines = [{line}, {line}]\n")
        };
        let part = format!(
            "name = \"edges\"\nat_mm = [0, 0, -50]\n{}{}{}",
            line("front", 5),
            line("rear", last),
            distance("rear", "front", 5.0)
        );
        Asked::of(&toml, &program, "", &part)
    };
    let asked = of("G1 X80 Y30 C10\n");
    let found = asked.elsewhere();
    let rear = found.directions.iter().find(|of| of.feature == "rear").unwrap();
    // 20 µrad at 40 mm, the middle of the edge.
    assert!((rear.here * 5.0 / 1.96 / 0.8 - 1.0).abs() < 0.2, "{rear:?}");
    let by_hand = of("G0 X80 Y30 C10\nG1 X0 Y30 C40\n").rated([0.0, 0.0, -50.0]).1;
    assert!((rear.there - by_hand).abs() < 1e-6 && by_hand < 0.05 * rear.here, "{rear:?} for {by_hand}");
}
