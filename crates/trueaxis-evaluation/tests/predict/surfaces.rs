//! Surfaces cut on a machine with one error, by formulas of their own.

use std::path::Path;
use trueaxis_evaluation::predict::{Options, Part, PredictDocument, predict};
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;

/// Rows of the surface, 4 mm apart.
const ROWS: usize = 11;

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
