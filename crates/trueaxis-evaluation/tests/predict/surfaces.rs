//! Surfaces and contours cut on machines with one error or none, and by a tool of uncertain diameter: by formulas of their
//! own.

use std::path::Path;
use trueaxis_evaluation::predict::{Options, Part, PredictDocument, predict};
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;

/// Rows of the surface, 4 mm apart.
const ROWS: usize = 11;
/// 97.5 % of the absolute values of a normal distribution are below.
const WIDEST: f64 = 2.2414;

/// Height of the surface z(x, y) and its slopes.
fn surface(x: f64, y: f64) -> [f64; 3] {
    [5e-4 * x * y - y * y / 120.0, 5e-4 * y, 5e-4 * x - y / 60.0]
}

/// A plane, an edge, a circle, a wave and the surface, with the lines of each; only the rows of the surface begin at different
/// places along X.
fn program() -> (String, [[usize; 2]; 5]) {
    let mut text = String::from("G21 G90 G17 G94 F600\nG0 X0 Y0 Z20\n");
    let mut lines = Vec::new();
    let mut pass = |feature: String| {
        let from = text.lines().count() + 1;
        text += &feature;
        lines.push([from, text.lines().count()]);
        text += "G0 Z20\n";
    };
    let row = |x: f64, [y, to]: [f64; 2], [z, end]: [f64; 2]| {
        format!("G0 X{x} Y{y}\nG0 Z{z:.7}\nG1 X{:.5} Y{to} Z{end:.7}\nG0 Z20\n", x + 80.0)
    };
    pass((0..4).map(|k| row(0.0, [-60.0 + 10.0 * f64::from(k); 2], [5.0; 2])).collect());
    pass(row(0.0, [-25.0; 2], [-5.0; 2]));
    pass("G0 X80 Y80\nG0 Z-5\nG3 X80 Y80 I-20 J0\n".into());
    let wave = (1..=80).map(f64::from).map(|x| format!("G1 X{x} Y{:.7}\n", 6.0 * (0.1 * x).sin() - 10.0));
    pass(format!("G0 X0 Y-10\nG0 Z-5\n{}", wave.collect::<String>()));
    let rows = (0..ROWS).map(|k| {
        let (x, y) = (0.37 * k as f64, 4.0 * k as f64);
        row(x, [y; 2], [x, x + 80.0].map(|x| surface(x, y)[0]))
    });
    pass(rows.collect());
    (text + "M2\n", lines.try_into().unwrap())
}

const KINDS: [&str; 5] = ["plane", "line", "profile", "profile", "profile"];

/// The five features with what else each states, and a profile tolerance of the last three; the first one without datums.
fn part(with: [&str; 5], tool: &str) -> String {
    let (_, lines) = program();
    let mut text = format!("name = \"surfaces\"\nat_mm = [0, 0, -40]\n{tool}");
    for (k, kind) in KINDS.iter().enumerate() {
        let (lines, with) = (lines[k], with[k]);
        text += &format!("[[feature]]\nname = \"f{k}\"\nkind = \"{kind}\"\nlines = {lines:?}\n{with}\n");
    }
    for (k, datums) in [(2, ""), (3, "datums = [\"f0\", \"f1\"]"), (4, "datums = [\"f0\"]")] {
        text += &format!("[[tolerance]]\nfeature = \"f{k}\"\nkind = \"profile\"\n{datums}\nwidth_um = 40\n");
    }
    text
}

/// On a machine whose Y is longer by this share; X has a scale of hardly any uncertainty.
fn predicted(scale: f64, part: &str) -> anyhow::Result<PredictDocument> {
    let toml = "name = \"one\"\nchain = \"w b X Y Z t\"\n[axis.X]\ntravel_mm = [-200, 200]\n[axis.Y]\n\
                table = \"y.csv\"\ntravel_mm = [-200, 200]\n[axis.Z]\ntravel_mm = [-200, 200]\n\
                [axis.X.uncertainty]\nscale_ppm = 0.001\n";
    let end = 1e3 * 200.0 * scale;
    let files = Memory::new([("machine.toml", toml), ("y.csv", &format!("Y_mm,EYY_um\n-200,{}\n200,{end}\n", -end))]);
    let file = Path::new("machine.toml");
    let machine = Machine::read_from(&files, file, &mut |_| {}).unwrap();
    let stated = Uncertainties::read_from(&files, file).unwrap();
    let program = Program::parse("surfaces", &program().0, "surfaces.ngc").unwrap();
    let part = Part::read(part, Path::new("part.toml"))?;
    predict(&machine, &stated, &program, &part, Options { trials: 600, seed: 3 })
}

/// Over the rows of the surface: the largest value at a place with these slopes.
fn most(of: impl Fn(f64, [f64; 2]) -> f64) -> f64 {
    let rows = (0..ROWS).flat_map(|k| (0..=80).map(move |x| (0.37 * k as f64 + f64::from(x), 4.0 * k as f64)));
    rows.map(|(x, y)| of(y, [surface(x, y)[1], surface(x, y)[2]])).fold(0.0, f64::max)
}

fn cosine([a, b]: [f64; 2]) -> f64 {
    1.0 / (1.0 + a * a + b * b).sqrt()
}

/// A point at y is cut farther by a share of y: by n_y of that along the normal. It is largest on the last row, whose normal a
/// difference to the row before would have 5 % too small.
#[test]
fn normals_at_the_end_of_a_surface_are_those_of_its_curve() {
    let scale = 3e-4;
    let of = predicted(scale, &part([""; 5], "")).unwrap();
    let wanted = 2e3 * most(|y, slopes| (slopes[1] * cosine(slopes) * scale * y).abs());
    let found = of.features[2].uncorrected_um;
    assert!(wanted > 10.0 && (found / wanted - 1.0).abs() < 0.004, "{found} for {wanted}");
}

/// A larger radius moves the wall of a circle by itself, that of the wave by what its direction differs from the edge's, and
/// the surface by 1 − cos of its inclination: the tip of a ball stays.
#[test]
fn the_diameter_of_a_tool_counts_for_profiles() {
    let tool = "[[tool]]\nname = \"ball\"\ndiameter_uncertainty_um = 2\n";
    let highs = |wave: &str, surface: &str| {
        let part = part(["", "side = \"left\"", "side = \"left\"", wave, surface], tool);
        let of = predicted(0.0, &part).unwrap();
        let known = |k: usize| of.features[k].known.as_ref().unwrap();
        assert!((0..3).all(|k| known(k).budget[0].term == "diameter of ball"));
        [0, 1, 2].map(|k| known(k).interval_um.high)
    };
    // Where the wave is steepest.
    let aside = 1.0 / f64::hypot(1.0, 0.6);
    let below = most(|_, slopes| 1.0 - cosine(slopes));
    let above = most(|_, slopes| 1.0 + cosine(slopes));
    for (wave, surface, share) in [
        ("left", "below", [1.0 - aside, below]),
        ("right", "below", [2.0, below]),
        ("left", "above", [1.0 - aside, above]),
    ] {
        let [circle, found @ ..] = highs(&format!("side = \"{wave}\""), &format!("side = \"{surface}\""));
        assert!((circle / (WIDEST * 2.0) - 1.0).abs() < 0.1, "{circle}");
        for (found, share) in found.into_iter().zip(share) {
            // The points of the wave are a millimetre apart.
            assert!((found / circle / share - 1.0).abs() < 0.02, "{wave}, {surface}: {} for {share}", found / circle);
        }
    }
    // Exactly known: no side is needed, and none changes anything.
    let [with, without] = ["side = \"below\"", ""]
        .map(|side| predicted(1e-4, &part(["", "", "", "", side], "")).unwrap().features[2].corrected_um);
    assert_eq!(with, without);
}

#[test]
fn sides_that_a_profile_does_not_have_are_refused() {
    let tool = "[[tool]]\nname = \"ball\"\ndiameter_uncertainty_um = 2\n";
    let refused = |circle: &str, wave: &str, surface: &str| {
        predicted(0.0, &part(["", "side = \"left\"", circle, wave, surface], tool)).unwrap_err().to_string()
    };
    let [left, below] = ["left", "below"].map(|side| format!("side = \"{side}\""));
    for (found, wanted) in [
        (
            refused("", &left, &below),
            &["part.toml:", "side: found nothing, needed \"left\" or \"right\" along the path"][..],
        ),
        (refused("side = \"inside\"", &left, &below), &["part.toml:", "side", "inside", "\"below\""]),
        (refused(&below, &left, &below), &["surfaces.ngc:", "a wall along the tool", "in the lines of f2", "\"left\""]),
        (refused(&left, &left, &left), &["surfaces.ngc:", "both sides of the path, in the lines of f4", "\"above\""]),
    ] {
        assert!(wanted.iter().all(|part| found.contains(part)), "{wanted:?}: {found}");
    }
}

/// There and back along one path the material would change sides; round a rib 4 mm wide it does not.
#[test]
fn a_profile_that_goes_back_along_itself_has_no_side() {
    let back = |aside: f64| {
        let text = format!(
            "G21 G90 G17 G94 F600\nG0 X0 Y0 Z5\nG1 Z-5\nG1 X20\nG2 X40 Y-20 I0 J-20\nG1 Y-40\nG1 X{}\nG1 Y-20\n\
             G3 X20 Y{} I-{} J0\nG1 X0\nM2\n",
            40.0 - aside,
            -aside,
            20.0 - aside
        );
        let part = "name = \"back\"\nat_mm = [0, 0, -40]\n[[tool]]\nname = \"mill\"\ndiameter_uncertainty_um = 2\n\
                    [[feature]]\nname = \"f\"\nkind = \"profile\"\nlines = [4, 10]\nside = \"right\"\n\
                    [[tolerance]]\nfeature = \"f\"\nkind = \"profile\"\nwidth_um = 40\n";
        super::predict_part(Some(&super::KNOWN), &text, part)
    };
    let refused = back(0.0).unwrap_err().to_string();
    for part in ["plate.ngc:4", "a pass in the other direction, in the lines of f", "one direction"] {
        assert!(refused.contains(part), "{refused}");
    }
    assert!(back(4.0).is_ok());
}
