//! Features cut in the other direction: the material stays where it is.

use std::path::Path;
use trueaxis_evaluation::predict::{Options, Part, PredictDocument, elsewhere, predict};
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;

/// Standard uncertainties of the lost motion of X and Y and of the tool's diameter, µm; the limit of the distance.
const PLAY: f64 = 3.0;
const WIDER: f64 = 2.0;
const LIMIT: f64 = 12.0;
/// As for the comparison of directions.
const OPTIONS: Options = Options { trials: 200, seed: 3 };

/// Two parallel edges on the slope 3 : 10, the material between them; the second one from `from` to `to`.
fn program([from, to]: [[i32; 2]; 2]) -> Program {
    let [[x, y], [to_x, to_y]] = [from, to];
    let text = format!(
        "G21 G90 G17 G94 F600\nG0 X-10 Y-3 Z5\nG0 Z-2\nG1 X110 Y33\nG0 Z5\nG0 X{x} Y{y}\nG0 Z-2\nG1 X{to_x} Y{to_y}\n\
         G0 Z5\nM2\n"
    );
    Program::parse("edges", &text, "edges.ngc").unwrap()
}

const FORTH: [[i32; 2]; 2] = [[110, 93], [-10, 57]];
const BACK: [[i32; 2]; 2] = [[-10, 57], [110, 93]];

fn part(side: &str) -> Part {
    let text = format!(
        "name = \"edges\"\nat_mm = [0, 0, -20]\n[[tool]]\nname = \"mill\"\ndiameter_uncertainty_um = {WIDER}\n\
         [[feature]]\nname = \"front\"\nkind = \"line\"\nlines = [4, 4]\nside = \"left\"\n\
         [[feature]]\nname = \"rear\"\nkind = \"line\"\nlines = [8, 8]\nside = \"{side}\"\n\
         [[tolerance]]\nfeature = \"rear\"\nkind = \"distance\"\nfrom = \"front\"\nlimits_um = [-{LIMIT}, {LIMIT}]\n"
    );
    Part::read(&text, Path::new("part.toml")).unwrap()
}

fn machine() -> (Machine, Uncertainties) {
    let play = |letter: &str| {
        format!("[axis.{letter}]\ntravel_mm = [-200, 200]\n[axis.{letter}.uncertainty]\nbacklash_um = {PLAY}\n")
    };
    let toml = format!(
        "name = \"loose\"\nchain = \"w b X Y Z t\"\n{}{}[axis.Z]\ntravel_mm = [-200, 200]\n",
        play("X"),
        play("Y")
    );
    let (files, file) = (Memory::new([("machine.toml", toml.as_str())]), Path::new("machine.toml"));
    (Machine::read_from(&files, file, &mut |_| {}).unwrap(), Uncertainties::read_from(&files, file).unwrap())
}

/// Cut forth, the two edges have the lost motion of both axes between them; cut back, none of it. The diameter of the tool
/// counts in full both times: with the material on the other side it would not count at all.
#[test]
fn an_edge_cut_backwards_keeps_its_material_on_the_same_side() {
    let (machine, stated) = machine();
    let predicted = |moves, side: &str| -> PredictDocument {
        predict(&machine, &stated, &program(moves), &part(side), OPTIONS).unwrap()
    };
    let forth = predicted(FORTH, "left");
    let found = elsewhere(&machine, &stated, &program(FORTH), &part("left"), &forth).unwrap();
    let rear = found.directions.iter().find(|of| of.feature == "rear").unwrap();
    let used = |of: PredictDocument| of.features[0].used();
    let [right, left] = ["right", "left"].map(|side| used(predicted(BACK, side)));
    assert!((rear.here - used(forth)).abs() < 1e-6, "{} for {}", rear.here, rear.there);
    assert!((rear.there - right).abs() < 1e-6 && left < 0.1 * right, "{} for {right}, not {left}", rear.there);
    // Across the slope: n = (−3, 10)/√109.
    let play = PLAY * f64::hypot(3.0, 10.0) / 109f64.sqrt();
    for (share, u) in [(rear.here, WIDER.hypot(play)), (rear.there, WIDER)] {
        assert!((share * LIMIT / (1.96 * u) - 1.0).abs() < 0.2, "{} for {u}", share * LIMIT / 1.96);
    }
}
