//! Free forms, circles made of chords and finishing passes: found in programs, and predicted.

use super::predict_part;
use std::f64::consts::TAU;
use trueaxis_evaluation::predict::{find, sections};
use trueaxis_sim::program::Program;

const HEAD: &str = "G21 G90 G17 G94 F600\n";

/// Lines of G1 through these points, after a rapid motion above the first and a plunge.
fn pass(points: &[[f64; 3]]) -> String {
    let [x, y, z] = points[0];
    let lines = points[1..].iter().map(|[x, y, z]| format!("G1 X{x:.5} Y{y:.5} Z{z:.5}\n"));
    format!("G0 Z20\nG0 X{x:.5} Y{y:.5}\nG1 Z{z:.5}\n{}G0 Z20\n", lines.collect::<String>())
}

/// Points on a circle about X60 Y40.
fn circle(radius: f64, z: f64, chords: usize, turned: usize) -> Vec<[f64; 3]> {
    let at = |k: usize| (TAU * k as f64 / chords as f64).sin_cos();
    (0..=turned).map(at).map(|(sine, cosine)| [60.0 + radius * cosine, 40.0 + radius * sine, z]).collect()
}

fn parsed(text: &str) -> Program {
    Program::parse("found", text, "found.ngc").unwrap()
}

/// Name and lines of what is found, and what is left out of it.
fn found(text: &str) -> Vec<String> {
    let found = find(&parsed(text));
    let left_out = |index: usize| {
        let own = found.left_out.iter().filter(|of| of.feature == index);
        own.map(|of| format!(", not {}-{}: {}", of.lines[0], of.lines[1], of.why)).collect::<String>()
    };
    let features = found.features.iter().enumerate();
    features.map(|(k, of)| format!("{} {}-{}{}", of.name, of.lines[0], of.lines[1], left_out(k))).collect()
}

#[test]
fn chords_are_a_circle_a_polygon_or_a_free_form() {
    let text = |points: &[[f64; 3]]| format!("{HEAD}{}M2\n", pass(points));
    assert_eq!(found(&text(&circle(20.0, -5.0, 72, 72))), ["circle 1 5-76"]);
    // Tilted by 10 degrees, in no plane of G17 to G19.
    let (sine, cosine) = 10_f64.to_radians().sin_cos();
    let tilted: Vec<_> = circle(20.0, -5.0, 72, 80).iter().map(|[x, y, z]| [*x, y * cosine, z - y * sine]).collect();
    assert_eq!(found(&text(&tilted)), ["circle 1 5-84"]);
    // Off the circle by more than 2 µm in one place.
    let mut dented = circle(20.0, -5.0, 72, 72);
    dented[30][0] += 0.005;
    assert_eq!(found(&text(&dented)), ["profile 1 5-76"]);
    // Not a full turn.
    assert_eq!(found(&text(&circle(20.0, -5.0, 72, 40))), ["profile 1 5-44"]);
    let sides = |count: usize| (0..count).map(|k| format!("line {} {}-{}", k + 1, k + 5, k + 5)).collect::<Vec<_>>();
    assert_eq!(found(&text(&circle(20.0, -5.0, 6, 6))), sides(6));
    // Twelve sides turn by 30°, but are 0.7 mm beside the circle: not found as one.
    assert!(!found(&text(&circle(20.0, -5.0, 12, 12))).concat().contains("circle"));
    // An edge in several moves.
    assert_eq!(found(&text(&[[0.0; 3], [4.0, 3.0, 0.0], [8.0, 6.0, 0.0], [12.0, 9.0, 0.0]])), ["line 1 5-7"]);
}

/// Two long edges with a rounded corner of chords; a spline with its way in and out; arcs of 3 mm one after the other.
#[test]
fn free_forms_are_found_between_edges() {
    let corner =
        (0..=9).map(|k| (TAU * f64::from(k) / 36.0).sin_cos()).map(|(s, c)| [40.0 + 10.0 * s, 10.0 - 10.0 * c, -2.0]);
    let rounded: Vec<[f64; 3]> = [[0.0, 0.0, -2.0]].into_iter().chain(corner).chain([[50.0, 60.0, -2.0]]).collect();
    let wave: String = (1..=6).map(|k| format!("G{} X{} Y0 R1.6\n", if k % 2 == 0 { 2 } else { 3 }, 3 * k)).collect();
    let text = format!(
        "{HEAD}{}G0 X0 Y0\nG1 Z-2\nG1 X20\nG5.2 X30 Y20 P1\nX60 Y20 P1\nX70 Y0 P1\nG5.3\nG1 X90\nG0 Z20\nG0 X0 Y0\nG1 Z-2\n{wave}G0 Z20\nM2\n",
        pass(&rounded)
    );
    let found = found(&text);
    assert_eq!(found[..3], ["line 1 5-5", "profile 1 6-14", "line 2 15-15"], "{found:?}");
    assert_eq!(found[3..], ["line 3 19-19", "profile 2 23-23", "line 4 24-24", "profile 3 28-33"], "{found:?}");
}

/// Rows z(x, y) to and fro, first 0.3 mm higher.
#[test]
fn rows_in_space_are_one_surface_and_the_one_before_is_left_out() {
    let rows = |above: f64| -> Vec<[f64; 3]> {
        let row = |k: usize| {
            let x = move |along: usize| if k.is_multiple_of(2) { along as f64 } else { 30.0 - along as f64 };
            (0..=30).map(move |along| [x(along), 1.5 * k as f64, above - 2.0 + (x(along) / 5.0).sin()])
        };
        (0..8).flat_map(row).collect()
    };
    let (rough, fine) = (pass(&rows(0.3)), pass(&rows(0.0)));
    let lines = rows(0.0).len() as u32 - 1;
    let [first, second] = [[5, 4 + lines], [9 + lines, 8 + 2 * lines]];
    let of = |name: &str, [from, to]: [u32; 2]| format!("{name} {from}-{to}");
    assert_eq!(found(&format!("{HEAD}{fine}M2\n")), [of("profile 1", first)]);
    let both = found(&format!("{HEAD}{rough}{fine}M2\n"));
    assert_eq!(
        both,
        [format!("{}, not {}-{}: the same path 0.3 mm higher", of("profile 1", second), first[0], first[1])]
    );
}

/// A bore in two depths with stock and finished; a contour in three depths; a face in two layers; a hole centred before it is
/// drilled; the sides of a slot, in opposite directions, are both finished.
#[test]
fn the_last_of_several_passes_is_the_finished_one() {
    let bore = |radius: f64, z: f64| {
        format!("G0 X{} Y40 Z{z}\nG3 X{} I{} J0\nG0 Z20\n", 60.0 + radius, 60.0 + radius, -radius)
    };
    let text = format!("{HEAD}{}{}{}M2\n", bore(19.5, -5.0), bore(19.5, -10.0), bore(20.0, -10.0));
    let wanted =
        "circle 1 9-9, not 3-3: the same path 5 mm higher and 0.5 mm beside, not 6-6: the same path 0.5 mm beside";
    assert_eq!(found(&text), [wanted]);
    let printed = sections(&find(&parsed(&text)));
    assert!(
        printed.contains("# line 6 left out: the same path 0.5 mm beside, cut before circle 1\n[[feature]]\n"),
        "{printed}"
    );
    // Counterbore: another radius at another depth.
    assert_eq!(
        found(&format!("{HEAD}{}{}M2\n", bore(19.5, -5.0), bore(18.5, -10.0))),
        ["circle 1 3-3", "circle 2 6-6"]
    );
    let edge = |y: f64, z: f64| format!("G0 X0 Y{y}\nG0 Z{z}\nG1 X50\nG0 Z20\n");
    let text = format!("{HEAD}{}{}{}M2\n", edge(0.5, -2.0), edge(0.5, -4.0), edge(0.0, -4.0));
    let wanted =
        "line 1 12-12, not 4-4: the same path 2 mm higher and 0.5 mm beside, not 8-8: the same path 0.5 mm beside";
    assert_eq!(found(&text), [wanted]);
    let slot = "G0 X0 Y0\nG1 Z-2\nG1 X50\nG1 Y1.5\nG1 X0\nG0 Z20\n";
    assert_eq!(found(&format!("{HEAD}{slot}M2\n")), ["line 1 4-4", "line 2 5-5", "line 3 6-6"]);
    let face = |z: f64, y: f64| {
        format!("G0 X0 Y{y}\nG0 Z{z}\nG1 X50\nG1 Y{}\nG1 X0\nG1 Y{}\nG1 X50\nG0 Z20\n", y + 9.0, y + 18.0)
    };
    assert_eq!(
        found(&format!("{HEAD}{}{}M2\n", face(0.5, 1.0), face(0.0, 0.0))),
        ["plane 1 12-16, not 4-8: the same face 0.5 mm higher"]
    );
    let drilled = "G81 X5 Y5 Z-1 R2\nX25\nG83 X5 Y5 Z-20 R2 Q5\nX25\nG80\n";
    assert_eq!(
        found(&format!("{HEAD}G0 Z20\n{drilled}M2\n")),
        ["hole 1 5-5, not 3-3: the same hole", "hole 2 6-6, not 4-4: the same hole"]
    );
}

/// The values of a part with one feature, uncorrected, µm.
fn values(text: &str, kind: &str, lines: [usize; 2], tolerances: &[(&str, &str)]) -> anyhow::Result<Vec<f64>> {
    let mut part = format!("name = \"one\"\nat_mm = [-60, -40, -10]\n[[feature]]\nname = \"f\"\nkind = \"{kind}\"\n");
    part += &format!("lines = {lines:?}\n");
    for (kind, rest) in tolerances {
        let limits = if *kind == "size" { "limits_um = [-20, 20]" } else { "width_um = 20" };
        part += &format!("[[tolerance]]\nfeature = \"f\"\nkind = \"{kind}\"\n{limits}\n{rest}\n");
    }
    Ok(predict_part(None, text, &part)?.features.iter().map(|of| of.uncorrected_um).collect())
}

/// The ends of chords, and the points of the arc, are on the same circle of the machine.
#[test]
fn a_circle_of_chords_has_the_size_and_form_of_the_arc() {
    let tolerances =
        [("size", ""), ("roundness", ""), ("roundness", "association = \"minimum zone\""), ("position", "")];
    let chords = format!("{HEAD}{}M2\n", pass(&circle(20.0, -5.0, 144, 144)));
    let arc = format!("{HEAD}G0 X80 Y40\nG1 Z-5\nG3 X80 I-20 J0\nM2\n");
    let of_chords = values(&chords, "circle", [5, 148], &tolerances).unwrap();
    let of_arc = values(&arc, "circle", [4, 4], &tolerances).unwrap();
    for (one, other) in of_chords.iter().zip(&of_arc) {
        assert!((one - other).abs() < 0.03, "{of_chords:?} {of_arc:?}");
    }
    assert!(of_arc[2] < of_arc[1] - 0.01 && of_arc[2] > 1.0, "{of_arc:?}");
}

/// Two arcs and a spline, and the same as chords of 0.4 mm: in G17, and standing in ZX.
#[test]
fn a_profile_of_arcs_and_a_spline_is_that_of_their_chords() {
    for (plane, standing) in [("G17", false), ("G18", true)] {
        let place = |[u, v]: [f64; 2]| if standing { format!("X{u} Z{v}") } else { format!("X{u} Y{v}") };
        let [first, second] = if standing { ["G2", "G3"] } else { ["G3", "G2"] };
        let spline = "G1 G17 X70\nG5.2 X80 Y20 P1\nX100 Y-20 P1\nX110 Y0 P1\nG5.3\n";
        let arcs = format!("{first} {} R15\n{second} {} R15\n", place([30.0, 0.0]), place([60.0, 0.0]));
        let curves = format!("G21 G90 {plane} G94 F600\nG0 X0 Y0 Z0\n{arcs}{}M2\n", if standing { "" } else { spline });
        let program = parsed(&curves);
        let mut steps = program.moves.iter().filter(|step| !step.rapid);
        let mut points = vec![[0.0; 3]];
        for step in steps.clone() {
            let (from, to) = step.curve.domain();
            let count = (step.curve.length() / 0.4).ceil() as usize;
            points.extend((1..=count).map(|k| step.curve.position(from + (to - from) * k as f64 / count as f64)));
        }
        let chords = format!("{HEAD}G0 X0 Y0 Z0\n{}M2\n", {
            let lines = points[1..].iter().map(|[x, y, z]| format!("G1 X{x:.6} Y{y:.6} Z{z:.6}\n"));
            lines.collect::<String>()
        });
        let last = steps.next_back().unwrap().line as usize;
        let [one, other] = [
            values(&curves, "profile", [3, last], &[("profile", "")]).unwrap()[0],
            values(&chords, "profile", [3, points.len() + 1], &[("profile", "")]).unwrap()[0],
        ];
        assert!((one - other).abs() < 0.02 * one && one > 2.0, "{plane}: {one} {other}");
    }
}

#[test]
fn profiles_and_circles_that_their_lines_do_not_cut_are_refused() {
    let line = "G0 X0 Y0 Z0\nG1 X20\nG1 X50\n";
    // A turn and a half that rises by 6 mm, with nothing beside it.
    let spiral: Vec<[f64; 3]> = (0..=50)
        .map(|k| (TAU * f64::from(k) / 100.0, k))
        .map(|(a, k)| [20.0 * a.cos(), 20.0 * a.sin(), 0.2 * f64::from(k)])
        .collect();
    for (kind, text, lines, error) in [
        ("profile", line.to_owned(), [2, 4], "plate.ngc:3: found a straight line, in the lines of f; needed: a curve"),
        ("profile", pass(&spiral), [5, 54], "one pass that is in no plane, in the lines of f"),
        ("circle", line.to_owned(), [3, 4], "arcs of one circle, or chords with their ends on one"),
    ] {
        let tolerance = if kind == "profile" { "profile" } else { "size" };
        let found = values(&format!("{HEAD}{text}M2\n"), kind, lines, &[(tolerance, "")]).unwrap_err().to_string();
        assert!(found.contains(error), "{found}");
    }
    let arc = format!("{HEAD}G0 X80 Y40\nG3 X80 I-20 J0\nM2\n");
    for (tolerance, rest, error) in [
        (
            "size",
            "association = \"minimum zone\"",
            "part.toml:11: key tolerance.association: found minimum zone of a size",
        ),
        ("roundness", "association = \"gauss\"", "part.toml:11"),
        ("profile", "", "profile of a circle, needed profile"),
    ] {
        let found = values(&arc, "circle", [3, 3], &[(tolerance, rest)]).unwrap_err().to_string();
        assert!(found.contains(error), "{found}");
    }
    let part = "name = \"two\"\nat_mm = [0, 0, 0]\n[[feature]]\nname = \"f\"\nkind = \"profile\"\nlines = [3, 3]\n\
                [[feature]]\nname = \"g\"\nkind = \"circle\"\nlines = [3, 3]\n[[tolerance]]\nfeature = \"g\"\n";
    for (rest, error) in [
        (
            "kind = \"position\"\ndatums = [\"f\"]\nwidth_um = 5\n",
            "part.toml:12: key tolerance.datums: found f, a profile",
        ),
        (
            "kind = \"distance\"\nfrom = \"f\"\nlimits_um = [-5, 5]\n",
            "part.toml:12: key tolerance.from: found f, a profile",
        ),
    ] {
        let found = predict_part(None, &arc, &format!("{part}{rest}")).unwrap_err().to_string();
        assert!(found.contains(error), "{found}");
    }
}

/// At other angles of the table the same coordinates are other holes.
#[test]
fn holes_at_other_angles_of_the_table_are_other_holes() {
    let at = |c: i32| format!("G0 C{c}\nG81 X0 Y30 Z-5 R2\nG80\nG0 Z50\n");
    let text = format!("G21 G90 G17 G94 F200\nG0 Z50\n{}{}{}{}M2\n", at(0), at(90), at(180), at(180));
    let found = find(&Program::parse("indexed", &text, "indexed.ngc").unwrap());
    assert_eq!(found.features.iter().map(|of| of.lines[0]).collect::<Vec<_>>(), [4, 8, 16]);
    assert_eq!(found.left_out.iter().map(|of| of.lines[0]).collect::<Vec<_>>(), [12]);
}
