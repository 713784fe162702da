//! A part cut in two set-ups, by tools whose diameter and length are not exactly known.

use super::measured::{circle, hole, line};
use super::plant::{Errors, Known, Place, Step, V, approaches, cut, edge, program, run};
use std::path::Path;
use trueaxis_evaluation::predict::{Options, Part, PredictDocument, predict};
use trueaxis_sim::program::Program;
use trueaxis_testing::noise::Noise;
use trueaxis_testing::scatter::normal;
use trueaxis_testing::share::share;

const AT: [V; 2] = [[-70.0, -50.0, -30.0], [-40.0, -60.0, -10.0]];
/// Zero of the second program on the part, which lies on its back: turned by 180 degrees about X.
const ZERO: V = [0.0, 80.0, -20.0];
const KNOWN: Known =
    Known { shift: 0.2e-3, turn: 1e-6, square: [2e-6; 3], scale: 3e-6, play: 0.3e-3, approach: 0.2e-3 };
/// Of the second set-up along and about X, Y, Z, mm and rad; of the tool's diameter and length, mm.
const HELD: [f64; 6] = [4e-3, 3e-3, 6e-3, 30e-6, 10e-6, 40e-6];
const TOOL: [f64; 2] = [2e-3, 3e-3];
const CENTRE: V = [60.0, 40.0, -10.0];
/// Where the second program drills.
const DRILLED: V = [30.0, 25.0, -6.0];

/// Front, left and back edge, a bore; the second set-up drills a hole and mills a line across.
fn steps() -> [Vec<Step>; 2] {
    let mut first = Vec::new();
    let edges = [([-8.0, -5.0], [128.0, -5.0]), ([-5.0, 88.0], [-5.0, -8.0]), ([128.0, 85.0], [-8.0, 85.0])];
    for (feature, ([x, y], [to_x, to_y])) in edges.into_iter().enumerate() {
        first.extend(edge([x, y, -12.0], [to_x, to_y, -12.0], feature));
    }
    first.extend([Step::Rapid([60.0, 40.0, 20.0]), Step::Line(CENTRE, None), Step::Line([75.0, 40.0, -10.0], None)]);
    first.extend([Step::Turn(CENTRE, 3), Step::Rapid([75.0, 40.0, 20.0])]);
    let [x, y, z] = DRILLED;
    let second = vec![Step::Rapid([x, y, 20.0]), Step::Rapid([x, y, 2.0]), Step::Line([x, y, z], Some(0))];
    [first, second]
}

fn part(with: &str) -> String {
    format!(
        "name = \"turned over\"\nat_mm = {:?}\n\
         [[setup]]\nname = \"back\"\nprogram = \"back.ngc\"\nat_mm = {:?}\nzero_mm = {ZERO:?}\n\
         turned_deg = [180, 0, 0]\nuncertainty_um = [4, 3, 6]\nuncertainty_urad = [30, 10, 40]\n\
         [[tool]]\nname = \"mill\"\ndiameter_uncertainty_um = 2\nlength_uncertainty_um = 3\n\
         [[feature]]\nname = \"front\"\nkind = \"line\"\nlines = [4, 4]\nside = \"left\"\n\
         [[feature]]\nname = \"left\"\nkind = \"line\"\nlines = [8, 8]\nside = \"left\"\n\
         [[feature]]\nname = \"rear\"\nkind = \"line\"\nlines = [12, 12]\nside = \"left\"\n\
         [[feature]]\nname = \"bore\"\nkind = \"circle\"\nlines = [17, 17]\nside = \"inside\"\n\
         [[feature]]\nname = \"hole\"\nkind = \"hole\"\nsetup = \"back\"\nlines = [4, 4]\n\
         [[tolerance]]\nfeature = \"bore\"\nkind = \"size\"\nlimits_um = [-10, 10]\n\
         [[tolerance]]\nfeature = \"rear\"\nkind = \"distance\"\nfrom = \"front\"\nlimits_um = [-10, 10]\n\
         [[tolerance]]\nfeature = \"hole\"\nkind = \"position\"\ndatums = [\"front\", \"left\"]\nwidth_um = 40\n\
         [[tolerance]]\nfeature = \"hole\"\nkind = \"distance\"\nfrom = \"bore\"\nlimits_um = [-40, 40]\n{with}",
        AT[0], AT[1]
    )
}

fn predicted(known: Option<&Known>, part: &str) -> anyhow::Result<PredictDocument> {
    let (machine, stated) = super::machine(known);
    let [first, second] = steps().map(|steps| program(&steps));
    let first = Program::parse("first", &first, "first.ngc").unwrap();
    let mut part = Part::read(part, Path::new("part.toml"))?;
    part.read_setups(|file| Program::parse("second", &second, file))?;
    predict(&machine, &stated, &first, &part, Options { trials: 4000, seed: 5 })
}

/// On the part: seen from above, what the second program calls Y and Z goes the other way.
fn on_part([x, y, z]: V) -> V {
    [ZERO[0] + x, ZERO[1] - y, ZERO[2] - z]
}

/// The second set-up's error at a point of its program, on the part.
fn misplaced([x, y, z]: V, held: &[f64; 6]) -> V {
    let [tx, ty, tz, wx, wy, wz] = *held;
    let [dx, dy, dz] = [tx + wy * z - wz * y, ty + wz * x - wx * z, tz + wx * y - wy * x];
    [dx, -dy, -dz]
}

/// Measures the tolerances, µm; `wider`: of the tool's diameter, mm.
fn measure(first: &[Vec<[V; 2]>], drilled: &[[V; 2]], held: &[f64; 6], wider: f64) -> [f64; 4] {
    let ([fx, fy], [ux, uy], _) = line(&first[0]);
    let ([lx, ly], _, _) = line(&first[1]);
    let ([rx, ry], _, _) = line(&first[2]);
    let (ux, uy) = if ux < 0.0 { (-ux, -uy) } else { (ux, uy) };
    let (centre, diameter, _) = circle(&first[3], [CENTRE[0], CENTRE[1]]);
    let points: Vec<[V; 2]> = drilled
        .iter()
        .map(|[is, was]| {
            let (is, by) = (on_part(*is), misplaced(*was, held));
            [std::array::from_fn(|i| is[i] + by[i]), on_part(*was)]
        })
        .collect();
    let [hx, hy] = hole(&points);
    let [px, py, _] = on_part(DRILLED);
    // Every edge is cut deeper into the part by half of what the tool is wider.
    let deeper = 0.5 * wider;
    let x = (hx - lx) * ux + (hy - ly) * uy - deeper - 5.0 - px;
    let y = (hy - fy) * ux - (hx - fx) * uy - deeper - 5.0 - py;
    let width = (ry - fy) * ux - (rx - fx) * uy - wider - 90.0;
    let apart = (hx - centre[0]).hypot(hy - centre[1]) - (px - CENTRE[0]).hypot(py - CENTRE[1]);
    [diameter + wider - 30.0, width, 2.0 * x.hypot(y), apart].map(|mm| 1e3 * mm)
}

fn places(is_corrected: bool) -> [Vec<Place>; 2] {
    let [first, second] = steps();
    [run(&first, AT[0], &Errors::stated(), is_corrected), run(&second, AT[1], &Errors::stated(), is_corrected)]
}

#[test]
fn a_part_of_two_set_ups_is_cut_as_predicted() {
    let found = predicted(None, &part("")).unwrap();
    for is_corrected in [false, true] {
        let [first, second] = places(is_corrected);
        let machine = Errors::stated();
        let none = [[0.0; 3]; 4];
        let drilled = cut(&second, AT[1], &machine, &none[..1]).remove(0);
        let wanted = measure(&cut(&first, AT[0], &machine, &none), &drilled, &[0.0; 6], 0.0);
        for (wanted, of) in wanted.into_iter().zip(&found.features) {
            let um = if is_corrected { of.corrected_um } else { of.uncorrected_um };
            assert!(
                (um - wanted).abs() < 0.05,
                "corrected {is_corrected}, {} {}: {um} for {wanted}",
                of.feature,
                of.kind
            );
        }
    }
    assert!(found.features.iter().all(|of| of.known.is_none()), "a set-up's uncertainty is not a machine's");
}

#[test]
fn set_ups_and_tools_are_within_the_predicted_intervals() {
    let found = predicted(Some(&KNOWN), &part("")).unwrap();
    let [first, second] = places(true);
    let parts = share(4000);
    let mut held = [0; 4];
    for number in 0..parts {
        let mut noise = Noise::new(9000 + number as u64);
        let drawn = Errors::stated().drawn(&KNOWN, &mut noise);
        let off = approaches(5, &KNOWN, &mut noise);
        let clamped = HELD.map(|u| u * normal(&mut noise));
        let wider = TOOL[0] * normal(&mut noise);
        let drilled = cut(&second, AT[1], &drawn, &off[4..]).remove(0);
        let values = measure(&cut(&first, AT[0], &drawn, &off[..4]), &drilled, &clamped, wider);
        for ((held, value), of) in held.iter_mut().zip(values).zip(&found.features) {
            *held += usize::from(of.known.as_ref().unwrap().interval_um.contains(value));
        }
    }
    let most = 0.01 + 3.5 * (0.95_f64 * 0.05 / parts as f64).sqrt();
    for (held, of) in held.into_iter().zip(&found.features) {
        let (share, known) = (held as f64 / parts as f64, of.known.as_ref().unwrap());
        let first = &known.budget[0].term;
        println!("{} {}: {:.1} %, ± {:.2} µm, {first}", of.feature, of.kind, 100.0 * share, known.expanded_um);
        assert!((share - 0.95).abs() < most, "{} {}: {held} of {parts}", of.feature, of.kind);
    }
    let first = |index: usize| found.features[index].known.as_ref().unwrap().budget[0].term.as_str();
    assert_eq!([first(0), first(1), first(3)], ["diameter of mill", "diameter of mill", "set-up back along X"]);
}

#[test]
fn set_ups_and_tools_that_cannot_be_are_refused() {
    let text = part("");
    for (from, to, found) in [
        ("setup = \"back\"", "setup = \"side\"", "needed the name of a set-up: back"),
        ("side = \"inside\"\n", "", "side: found nothing, needed \"inside\" or \"outside\""),
        ("side = \"inside\"", "side = \"left\"", "\"inside\""),
        ("turned_deg = [180, 0, 0]", "turned_deg = [180, 0]", "turned_deg"),
        ("uncertainty_um = [4, 3, 6]", "uncertainty_um = [4, -3, 6]", "three standard uncertainties, 0 to 10000 um"),
        ("datums = [\"front\", \"left\"]", "datums = [\"front\", \"front\"]", "none of them twice"),
        ("kind = \"hole\"\n", "kind = \"hole\"\nside = \"inside\"\n", "side"),
    ] {
        let wrong = text.replacen(from, to, 1);
        assert_ne!(wrong, text, "{from}");
        let error = predicted(None, &wrong).unwrap_err().to_string();
        assert!(error.contains("part.toml:") && error.contains(found), "{error}");
    }
    let again = "[[tool]]\nname = \"mill\"\n";
    let error = predicted(None, &part(again)).unwrap_err().to_string();
    assert!(error.contains("tool.name: found \"mill\"") || error.contains("a name that no other tool has"), "{error}");
    let other = "[[tool]]\nname = \"other\"\n";
    let error = predicted(None, &part(other)).unwrap_err().to_string();
    assert!(error.contains("tool: found nothing, needed the name of its tool: mill, other"), "{error}");
    // A datum made in a later set-up.
    let late = "[[tolerance]]\nfeature = \"bore\"\nkind = \"position\"\ndatums = [\"hole\"]\nwidth_um = 9\n";
    let error = predicted(None, &part(late)).unwrap_err().to_string();
    assert!(error.contains("the datum hole") && error.contains("made before bore"), "{error}");
}

/// A plate's bore as other lines: outlines and arcs that are no circle, and an edge that is cut forth and back.
#[test]
fn what_is_no_circle_and_no_edge_of_one_side_is_refused() {
    let (machine, stated) = super::machine(None);
    let refusal = |program: &str, feature: &str, tolerance: &str| {
        let program = Program::parse("one", &format!("G21 G90 G17 G94 F600\n{program}M2\n"), "one.ngc").unwrap();
        let text = format!(
            "name = \"one\"\nat_mm = [0, 0, 0]\n[[tool]]\nname = \"mill\"\ndiameter_uncertainty_um = 2\n\
             [[feature]]\nname = \"f\"\n{feature}\n[[tolerance]]\nfeature = \"f\"\n{tolerance}\n"
        );
        let part = Part::read(&text, Path::new("part.toml")).unwrap();
        predict(&machine, &stated, &program, &part, Options { trials: 200, seed: 1 }).unwrap_err().to_string()
    };
    let round = "kind = \"roundness\"\nwidth_um = 9";
    let circle = |lines: &str| format!("kind = \"circle\"\nside = \"inside\"\nlines = {lines}");
    let rectangle = "G0 X0 Y0\nG1 X100\nY60\nX0\nY0\n";
    let quarter = "a quarter of a circle or more";
    assert!(refusal(rectangle, &circle("[3, 6]"), round).contains(quarter));
    // 60 degrees of a circle.
    let arc = "G0 X30 Y0\nG3 X15 Y25.980762 I-30 J0\n";
    assert!(refusal(arc, &circle("[3, 3]"), round).contains(quarter));
    let edge = "kind = \"line\"\nside = \"left\"\nlines = [3, 4]";
    let error = refusal("G0 X0 Y0\nG1 X100\nX0\n", edge, "kind = \"straightness\"\nwidth_um = 9");
    assert!(error.contains("one.ngc:4") && error.contains("a pass in the other direction"), "{error}");
}

/// How the part lies in its second set-up does not change what the program cuts there.
#[test]
fn a_profile_is_the_same_however_its_set_up_is_turned() {
    let (machine, stated) = super::machine(None);
    let none = Program::parse("none", "G21 G90 G17 G94 F600\nG0 X0 Y0 Z0\nX1\nM2\n", "none.ngc").unwrap();
    let curve = "G21 G90 G17 G94 F600\nG0 X0 Y0 Z0\nG3 X30 Y30 I0 J30\nG2 X60 Y60 I30 J0\nM2\n";
    let value = |turned: [i32; 3]| {
        let text = format!(
            "name = \"one\"\nat_mm = [0, 0, 0]\n[[setup]]\nname = \"s\"\nprogram = \"s.ngc\"\nat_mm = [-30, -30, 0]\n\
             turned_deg = {turned:?}\n[[feature]]\nname = \"f\"\nkind = \"profile\"\nsetup = \"s\"\nlines = [3, 4]\n\
             [[tolerance]]\nfeature = \"f\"\nkind = \"profile\"\nwidth_um = 9\n"
        );
        let mut part = Part::read(&text, Path::new("part.toml")).unwrap();
        part.read_setups(|file| Program::parse("s", curve, file)).unwrap();
        let found = predict(&machine, &stated, &none, &part, Options { trials: 200, seed: 1 }).unwrap();
        found.features[0].uncorrected_um
    };
    let level = value([0, 0, 0]);
    assert!(level > 0.3, "{level}");
    for turned in [[0, 0, 30], [0, 0, 90], [90, 0, 0], [20, 40, 60]] {
        assert!((value(turned) - level).abs() < 1e-6, "{turned:?}: {} for {level}", value(turned));
    }
}
