//! G-code in, curves out: every element is compared with its golden form, every refusal names its line.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use proptest::prelude::*;
use trueaxis_sim::program::{BUILTIN_NAMES, Curve, Program, ProgramError, ReadOptions};

fn parse(text: &str) -> Result<Program, ProgramError> {
    Program::parse("test", text, "part.ngc")
}

fn curves(text: &str) -> Vec<Curve> {
    parse(text).unwrap().moves.into_iter().map(|m| m.curve).collect()
}

/// The last curve of a program.
fn last(text: &str) -> Curve {
    curves(text).pop().unwrap()
}

fn assert_near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
    let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f64::max);
    assert!(off <= tolerance, "{found:?} instead of {expected:?}");
}

#[test]
fn lines_feeds_units_and_distance_modes() {
    let program = parse("G0 X1 Y2 Z3\nG1 X2 F600\ng91 y-1\nG20\nX1 F10\nG21 G90 Z0").unwrap();
    let expected: [(u32, bool, f64, [f64; 3]); 5] = [
        (1, true, 0.0, [1.0, 2.0, 3.0]),
        (2, false, 600.0, [2.0, 2.0, 3.0]),
        (3, false, 600.0, [2.0, 1.0, 3.0]),
        (5, false, 254.0, [27.4, 1.0, 3.0]),
        (6, false, 254.0, [27.4, 1.0, 0.0]),
    ];
    let mut start = [0.0; 3];
    assert_eq!(program.moves.len(), expected.len());
    for (found, (line, rapid, feed, end)) in program.moves.iter().zip(expected) {
        assert_eq!((found.line, found.rapid, found.feed_per_min), (line, rapid, feed));
        assert_eq!(found.curve, Curve::Line { start, end });
        assert_eq!(found.plane_normal, [0.0, 0.0, 1.0]);
        start = end;
    }
    assert_eq!(program.length(), 14_f64.sqrt() + 1.0 + 1.0 + 25.4 + 3.0);
}

#[test]
fn numbers_keep_double_precision() {
    let Curve::Line { end, .. } = last("G0 X123.456789012 Y-.5 Z + 7.") else { panic!() };
    assert_eq!(end, [123.456789012, -0.5, 7.0]);
}

/// Text; middle point; end; length; normal.
type ArcCase = (&'static str, [f64; 3], [f64; 3], f64, [f64; 3]);

#[test]
fn arcs_of_every_kind() {
    let r = 0.5_f64.sqrt();
    let up = [0.0, 0.0, 1.0];
    let down = [0.0, 0.0, -1.0];
    let cases: [ArcCase; 16] = [
        ("G3 X0 Y10 I-10", [10.0 * r, 10.0 * r, 0.0], [0.0, 10.0, 0.0], 10.0 * FRAC_PI_2, up),
        ("G2 X0 Y10 I-10", [-10.0 * r, -10.0 * r, 0.0], [0.0, 10.0, 0.0], 30.0 * FRAC_PI_2, down),
        ("G3 I-10", [-10.0, 0.0, 0.0], [10.0, 0.0, 0.0], 10.0 * TAU, up),
        ("G2 X10 Y0 I-10 P3", [-10.0, 0.0, 0.0], [10.0, 0.0, 0.0], 30.0 * TAU, down),
        ("G90.1\nG3 X0 Y10 I0 J0", [10.0 * r, 10.0 * r, 0.0], [0.0, 10.0, 0.0], 10.0 * FRAC_PI_2, up),
        ("G3 X0 Y10 R10", [10.0 * r, 10.0 * r, 0.0], [0.0, 10.0, 0.0], 10.0 * FRAC_PI_2, up),
        ("G3 X0 Y10 R-10", [10.0 + 10.0 * r, 10.0 + 10.0 * r, 0.0], [0.0, 10.0, 0.0], 30.0 * FRAC_PI_2, up),
        ("G2 X0 Y10 R10", [10.0 - 10.0 * r, 10.0 - 10.0 * r, 0.0], [0.0, 10.0, 0.0], 10.0 * FRAC_PI_2, down),
        ("G2 X0 Y10 R-10", [-10.0 * r, -10.0 * r, 0.0], [0.0, 10.0, 0.0], 30.0 * FRAC_PI_2, down),
        ("G3 X-10 R10", [0.0, 10.0, 0.0], [-10.0, 0.0, 0.0], 10.0 * PI, up),
        ("G3 X-10 I-10 P2", [0.0, -10.0, 0.0], [-10.0, 0.0, 0.0], 30.0 * PI, up),
        ("G20\nG3 X-0.393700787401574803 R0.393700787401574803", [0.0, 10.0, 0.0], [-10.0, 0.0, 0.0], 10.0 * PI, up),
        ("G91\nG3 X-20 I-10 Z6", [0.0, 10.0, 3.0], [-10.0, 0.0, 6.0], (100.0 * PI * PI + 36.0_f64).sqrt(), up),
        // Z to X: from +X a quarter turn counter-clockwise about Y leads to -Z.
        ("G18\nG3 X0 Z-10 I-10", [10.0 * r, 0.0, -10.0 * r], [0.0, 0.0, -10.0], 10.0 * FRAC_PI_2, [0.0, 1.0, 0.0]),
        ("G18\nG2 X0 Z10 I-10", [10.0 * r, 0.0, 10.0 * r], [0.0, 0.0, 10.0], 10.0 * FRAC_PI_2, [0.0, -1.0, 0.0]),
        ("G19\nG3 Y-4 Z4 J-4", [10.0, 4.0 * r - 4.0, 4.0 * r], [10.0, -4.0, 4.0], 4.0 * FRAC_PI_2, [1.0, 0.0, 0.0]),
    ];
    for (text, middle, end, length, axis) in cases {
        let curve = last(&format!("F100 G0 X10\n{text}"));
        let Curve::Arc { normal, .. } = &curve else { panic!("{text}") };
        assert_eq!(*normal, axis, "{text}");
        assert_near(curve.position(0.0), [10.0, 0.0, 0.0], 1e-14);
        assert_near(curve.position(0.5), middle, 1e-12);
        assert_near(curve.position(1.0), end, 1e-12);
        assert!((curve.length() - length).abs() < 1e-11, "{text}: {} instead of {length}", curve.length());
    }
}

#[test]
fn a_helix_has_its_analytic_curvature() {
    // Radius r, rise h per radian: r / (r² + h²).
    let curve = last("F100 G0 X5\nG3 X-5 Z4 I-5 P2");
    let rise = 4.0 / (3.0 * PI);
    for u in [0.0, 0.3, 0.77, 1.0] {
        assert!((curve.curvature(u) - 5.0 / (25.0 + rise * rise)).abs() < 1e-14);
    }
}

#[test]
fn nurbs_block_is_linuxcnc_s() {
    // The example for G5.2 in LinuxCNC's manual, with order 3: quadratic pieces on the knots 0,0,0,1,2,…
    let curve = last("F10 G0 X0 Y0\nG5.2 X0 Y1 P1 L3\nX2 Y2 P1\nX2 Y0 P1\nX0 Y0 P2\nG5.3");
    let Curve::Nurbs { degree, knots, points, weights } = &curve else { panic!() };
    assert_eq!(*degree, 2);
    assert_eq!(*knots, [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0]);
    assert_eq!(points.len(), 5);
    assert_eq!(*points.last().unwrap(), [0.0, 0.0, 0.0]);
    assert_eq!(*weights, [1.0, 1.0, 1.0, 1.0, 2.0]);
    // A first line with P alone weighs the current point; order 3 is the default; G91 counts from the start.
    let Curve::Nurbs { points, weights, .. } = last("F10 G0 X5 Y5\nG91 G5.2 P4\nX0 Y1 P1\nX2 Y2 P1\nG5.3") else {
        panic!()
    };
    assert_eq!(weights, [4.0, 1.0, 1.0]);
    assert_eq!(points, [[5.0, 5.0, 0.0], [5.0, 6.0, 0.0], [7.0, 7.0, 0.0]]);
}

#[test]
fn a_rational_quadratic_is_an_exact_circle() {
    let weight = 0.5_f64.sqrt();
    let curve = last(&format!("F10 G0 X10\nG5.2 X10 Y10 P{weight:.17} L3\nX0 Y10 P1\nG5.3"));
    for i in 0..=20 {
        let u = f64::from(i) / 20.0;
        let [x, y, _] = curve.position(u);
        assert!((x.hypot(y) - 10.0).abs() < 1e-14);
        assert!((curve.curvature(u) - 0.1).abs() < 1e-13);
    }
    assert!((curve.length() - 10.0 * FRAC_PI_2).abs() < 1e-11);
    assert_near(
        curve.position(curve.parameter_at(2.5 * PI)),
        [10.0 * 0.5_f64.sqrt(), 10.0 * 0.5_f64.sqrt(), 0.0],
        1e-9,
    );
}

/// The curve of Hu et al. 2023 (doi 10.1007/s00170-023-12427-5) with its own knots.
fn published_butterfly() -> Curve {
    let data: serde_json::Value = serde_json::from_str(include_str!("data/butterfly.json")).unwrap();
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    Curve::Nurbs {
        degree: 3,
        knots: numbers(&data["knots"]),
        points: data["points"].as_array().unwrap().iter().map(|p| numbers(p).try_into().unwrap()).collect(),
        weights: numbers(&data["weights"]),
    }
}

/// Cox–de Boor basis function of order k, by its definition.
fn basis(i: usize, k: usize, u: f64, knots: &[f64]) -> f64 {
    if k == 1 {
        return f64::from(u8::from(knots[i] <= u && u < knots[i + 1]));
    }
    let part = |numerator: f64, width: f64| if width > 0.0 { numerator / width } else { 0.0 };
    part(u - knots[i], knots[i + k - 1] - knots[i]) * basis(i, k - 1, u, knots)
        + part(knots[i + k] - u, knots[i + k] - knots[i + 1]) * basis(i + 1, k - 1, u, knots)
}

#[test]
fn nurbs_against_the_definition_and_the_published_length() {
    let curve = published_butterfly();
    let Curve::Nurbs { knots, points, weights, .. } = &curve else { panic!() };
    for j in 0..997 {
        let u = f64::from(j) / 997.0;
        let (mut sum, mut whole) = ([0.0; 3], 0.0);
        for (i, point) in points.iter().enumerate() {
            let n = basis(i, 4, u, knots) * weights[i];
            whole += n;
            (0..3).for_each(|axis| sum[axis] += n * point[axis]);
        }
        assert_near(curve.position(u), sum.map(|s| s / whole), 1e-12);
    }
    assert!((curve.length() - 382.86).abs() < 0.005, "length {}", curve.length());
}

#[test]
fn derivatives_agree_with_differences() {
    let butterfly = published_butterfly();
    let spiral = last("F100 G0 X5\nG3 X-5.001 Z4 I-5 P2");
    let quintic =
        last("F9 G0 X1\nG5.2 X3 Y1 P2 L6\nX5 Y5 P1\nX2 Y8 P.5\nX9 Y9 P1\nX12 Y0 P3\nX14 Y2 P1\nX15 Y4 P1\nG5.3");
    for curve in [&butterfly, &spiral, &quintic] {
        let (first, last) = curve.domain();
        let h = 1e-6 * (last - first);
        for i in 1..200 {
            // Away from knots, where the second derivative of low degrees may jump.
            let u = first + (last - first) * (f64::from(i) + 0.137) / 200.0;
            if curve.breaks().iter().any(|knot| (knot - u).abs() < 2.0 * h) {
                continue;
            }
            let at = curve.derivatives(u);
            let (ahead, behind) = (curve.derivatives(u + h), curve.derivatives(u - h));
            for axis in 0..3 {
                let slope = (ahead.position[axis] - behind.position[axis]) / (2.0 * h);
                let bend = (ahead.first[axis] - behind.first[axis]) / (2.0 * h);
                let scale = at.first.iter().chain(&at.second).fold(1.0, |m: f64, v| m.max(v.abs()));
                assert!((at.first[axis] - slope).abs() < 1e-6 * scale, "first at {u}");
                assert!((at.second[axis] - bend).abs() < 1e-4 * scale, "second at {u}: {} {bend}", at.second[axis]);
            }
        }
    }
}

#[test]
fn moves_connect_and_builtin_programs_are_clean() {
    for name in BUILTIN_NAMES {
        let program = Program::builtin(name).unwrap().unwrap();
        assert!(program.moves.len() > 2, "{name}");
        assert!(program.notes.is_empty(), "{name}: {:?}", program.notes);
        let mut at = [0.0; 3];
        for element in &program.moves {
            let (first, last) = element.curve.domain();
            assert_near(element.curve.position(first), at, 1e-9);
            at = element.curve.position(last);
        }
    }
    assert!(Program::builtin("nothing").is_none());
}

#[test]
fn circle_diamond_square_has_its_length() {
    let program = Program::builtin("circle-diamond-square").unwrap().unwrap();
    let cut: f64 = program.moves.iter().filter(|m| !m.rapid).map(|m| m.curve.length()).sum();
    // Four plunges of 10 mm, eight quarter circles of radius 10 and the four contours.
    let expected = 40.0 + 8.0 * 5.0 * PI + 60.0 * PI + 4.0 * 5_000_f64.sqrt() + 400.0 + 440.0;
    assert!((cut - expected).abs() < 2e-3, "{cut} instead of {expected}");
}

#[test]
fn words_without_effect_leave_a_note() {
    let text = "%\nN10 (start) G21 G40 G49 G54 G64 P0.01 ; modes\nT1 M6\nM3 S1000 M8\nG61 F10 G1 X1 S900 M8\nG80 M5 M9 M0\nM2\n%\n";
    let program = parse(text).unwrap();
    assert_eq!(program.moves.len(), 1);
    let notes: Vec<String> =
        program.notes.iter().map(|note| format!("{} {} {}", note.line, note.word, note.count)).collect();
    assert_eq!(notes, ["2 G64 P 1", "3 T 1", "3 M6 1", "4 S 2", "4 M3 1", "4 M8 2", "6 M5 1", "6 M9 1", "6 M0 1"]);
    assert!(program.moves[0].stop, "M0 stops the axes");
}

#[test]
fn refusals_name_line_and_word() {
    let cases: [(&str, u32, &str, &str); 83] = [
        ("G1 X1", 1, "without feed", "F"),
        ("F0 G1 X1", 1, "without feed", "F"),
        ("F10\nG2 X1 Y1", 2, "without centre", "I J K"),
        ("F10\nG2 X10 I4", 2, "radius 4.0000 mm at its start and 6.0000 mm", "agree within 0.02"),
        ("F10\nG2 X10 I5.0101 Y0.0", 2, "", "agree within"),
        ("F10 G2 X10 R4.9", 1, "R 4.9000 mm", "half"),
        ("F10 G2 I0 J0 X1", 1, "radius", "centre"),
        ("F10 G2 X10 R5 I5", 1, "R together", "either"),
        ("F10 G2 X10 K5", 1, "K in plane G17", "plane"),
        ("F10 G18 G2 X10 J5", 1, "J in plane G18", "plane"),
        ("F10 G90.1 G2 X10 I5", 1, "one centre word", "both"),
        ("F10 G2 X0 R5", 1, "the same", "I J K"),
        ("F10 G2 X10 I5 P0", 1, "P0", "turns"),
        ("F10 G2 X10 I5 P1.5", 1, "P1.5", "turns"),
        ("F10 G2 X10 I5 P9999", 1, "P9999", "1 to 1000"),
        ("F-5", 1, "F-5", "positive"),
        ("X1", 1, "X1", "motion word"),
        ("G80\nX1", 2, "X1", "motion word"),
        ("G1 F1 X1 X2", 1, "`X2`", "once"),
        ("G0 G1 X1 F1", 1, "`G1` and `G0`", "modal group"),
        ("G0 G80 G1 X1 F1", 1, "`G1` and `G0`", "modal group"),
        ("G90 G91", 1, "G91", "modal group"),
        ("M3 M4", 1, "`M4` and `M3`", "modal group"),
        ("N1 N2 G0", 1, "N2", "once"),
        ("G0 X", 1, "X", "number"),
        ("G0 X Y1", 1, "Y1", "number"),
        ("G", 1, "G", "number"),
        ("G0 X1.2.3", 1, "1.2.3", "number"),
        ("G0 X1e3", 1, "E3", "M67"),
        ("G0 X2000000", 1, "X2000000", "within"),
        ("G0 X.", 1, ".", ""),
        ("A10", 1, "A10", "motion word"),
        ("G0 X1 Q3", 1, "Q3", "G83"),
        ("G0 X1 P3", 1, "P3", "G64"),
        ("G0 X1 R3", 1, "R3", "G2, G3"),
        ("G0 X1 L3", 1, "L3", "G5.2"),
        ("G0 X1 H1", 1, "H1", "G43"),
        ("G0 X1 D1", 1, "D1", "dialect"),
        ("G4", 1, "G4", "seconds"),
        ("G4 X1", 1, "G4", "seconds"),
        ("G41 D1", 1, "G41", "--interpreter rs274"),
        ("G42.1 D1", 1, "G42.1", "--interpreter rs274"),
        ("G43 H1.5", 1, "H1.5", "whole"),
        ("G43.1", 1, "without axis words", "Z"),
        ("G95", 1, "G95", "--interpreter rs274"),
        ("G33 K1 Z1", 1, "G33", "--interpreter rs274"),
        ("G68.2", 1, "G68.2", "G54 to G59.3"),
        ("G1.01 X1 F1", 1, "G1.01", "G54"),
        ("G1.55 X1 F1", 1, "G1.55", "G54"),
        ("G4294967297 X1", 1, "G4294967297", "number"),
        ("M98 P100", 1, "M98 P100", "`O100`"),
        ("M98", 1, "without a program", "P"),
        ("M98 P1 G0 X1", 1, "beside", "separate line"),
        ("M66 P0 L0", 1, "M66", "--interpreter rs274"),
        ("M67 E0", 1, "M67 without", "E, the output"),
        ("M72", 1, "M72", "M70"),
        ("M99999", 1, "M99999", "M30"),
        ("O100 SUB", 1, "O100 sub", "O100 endsub"),
        ("N5 O<drill> CALL [1]", 1, "O<drill> call", "O<drill> sub"),
        ("O100 G0 X1", 1, "O100G0X1", "separate line"),
        ("#1", 1, "#1", "="),
        ("G0 X#<a>", 1, "`#<A>`", "assigned"),
        ("G0 X[1+2", 1, "[1+2", "]"),
        ("G0 X1 (open\nG0 X2", 1, "(open", "closed"),
        ("G0 X1 (a (b) c)", 1, "(a", "without ("),
        ("G0 é1", 1, "0xc3", "letters"),
        ("G0 /X1", 1, "/", "beginning"),
        ("% G0", 1, "%", "separate"),
        ("42 G0 X1", 1, "42", "letter"),
        ("G53 X1", 1, "G53 without", "G0 or G1"),
        ("G91 G53 G0 X1", 1, "G91", "G90"),
        ("G92", 1, "G92 alone", "axis words"),
        ("G92 G1 X1 F1", 1, "G92 and G1", "one word"),
        ("G10 P1 X1", 1, "G10", "L2"),
        ("G10 L2 P10 X1", 1, "P10", "P0 to P9"),
        ("G81 X1 Z-1 R1", 1, "without feed", "F"),
        ("F1 G81 X1 R1", 1, "without Z", "depth"),
        ("F1 G81 X1 Z-1", 1, "without R", "height"),
        ("F1 G81 X1 Z1 R-1", 1, "below", "above"),
        ("F1 G82 X1 Z-1 R1", 1, "without P", "dwell"),
        ("F1 G83 X1 Z-1 R1", 1, "Q0", "positive"),
        ("F1 G81 A1 Z-1 R1", 1, "rotary", "rest"),
        ("F1 G93 G81 X1 Z-1 R1 F1", 1, "`F1`", "once"),
    ];
    for (text, line, found, needed) in cases {
        let error = parse(text).expect_err(text);
        assert_eq!((error.line, error.file.as_str()), (line, "part.ngc"), "{text}: {error}");
        assert!(error.found.contains(found), "{text}: {error}");
        assert!(error.needed.contains(needed), "{text}: {error}");
        assert!(error.to_string().starts_with(&format!("part.ngc:{line}: found ")), "{error}");
    }
}

#[test]
fn strokes_of_cycles_count_whether_or_not_they_have_a_length() {
    let read = |text: &str| Program::read_within("part", text.as_bytes(), "part.ngc", &ReadOptions::default(), 1000);
    // Zero-length strokes up and down, 300 per line.
    let zero_length = "F1 G81 X0 Y0 Z0 R0 L300\n";
    assert!(read(&zero_length.repeat(3)).unwrap().moves.is_empty());
    let error = read(&zero_length.repeat(4)).unwrap_err();
    assert_eq!((error.line, error.found.as_str()), (4, "1200 strokes of canned cycles up to here"), "{error}");
    let pecking = "F1 G83 X0 Y0 Z-0.00000001 R0 Q0.000000000001\n";
    assert_eq!(read(pecking).unwrap_err().found, "10000 strokes of canned cycles up to here");
    // 3 pieces each: up, across, down.
    let drilled = "F1 G99 G81 G91 X1 Z-1 R0 L333\n";
    assert!(read(drilled).unwrap().moves.len() > 900);
    assert_eq!(read(&drilled.replace("333", "334")).unwrap_err().found, "a program of 1001 pieces up to here");
}

#[test]
fn nurbs_refusals() {
    let cases = [
        ("G5.2 X1 Y1", 2, "without P"),
        ("G5.2 X1 P1", 2, "half"),
        ("G5.2 X1 Y1 P0", 2, "P0"),
        ("G5.2 X1 Y1 P1 L2", 2, "L2"),
        ("G5.2 X1 Y1 P1 L9", 2, "L9"),
        ("G5.2 X1 Y1 P1 L3.5", 2, "L3.5"),
        ("G5.2 X1 Y1 P1\nX2 Y2 P1 L4", 3, "L4"),
        ("G5.2 X1 Y1 P1\nP1", 3, "half"),
        ("G5.2 X1 Y1 Z1 P1", 2, "Z"),
        ("G5.2 X1 Y1 P1 I1", 2, "I1"),
        ("G5.2 X1 Y1 P1\nG5.3", 3, "2 control points"),
        ("G5.2 X1 Y1 P1\nG1 X1", 3, "motion word"),
        ("G5.2 X1 Y1 P1\nG91", 3, "G91"),
        ("G5.2 X1 Y1 P1\nM2", 3, "end within"),
        ("G5.2 X1 Y1 P1\nX2 Y2 P1", 3, "the end in the NURBS of line 2"),
        ("G5.3", 2, "without G5.2"),
        ("G18 G5.2 X1 Y1 P1", 2, "G18"),
        ("G5.2 X1 Y1 P1\nX2 Y2 P1\nG5.3 X3", 4, "X3"),
        ("G5.2 X1 Y1 P1\nX2 Y2 P1\nG5.3\nX3 Y1 P1", 5, "P1"),
    ];
    for (text, line, found) in cases {
        let error = parse(&format!("F10 G0 X0\n{text}")).expect_err(text);
        assert_eq!(error.line, line, "{text}: {error}");
        assert!(error.found.contains(found), "{text}: {error}");
    }
    let error = parse("G5.2 X1 Y1 P1").unwrap_err();
    assert!(error.found.contains("without feed"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn garbage_never_panics(text in "\\PC{0,80}") {
        let _ = parse(&text);
    }

    #[test]
    fn garbage_of_words_never_panics(text in "([GMTXYZIJKRPLFNS%/();#.+ \\n-]{0,2}[0-9]{0,10}(\\.[0-9]{0,3})?){0,30}") {
        let _ = parse(&text);
    }

    #[test]
    fn random_programs_connect(words in prop::collection::vec((0_usize..8, -50.0..50.0_f64, -50.0..50.0_f64, 0.5..40.0_f64), 1..30)) {
        let mut text = String::from("F1000\n");
        for (kind, x, y, r) in words {
            text += &match kind {
                0 => format!("G0 X{x:.3} Y{y:.3}\n"),
                1 => format!("G1 X{x:.3} Z{y:.3}\n"),
                2 => format!("G17 G2 I{r:.3} J{x:.3} Z{y:.3} P2\n"),
                3 => format!("G18 G3 I{r:.3} K{x:.3}\n"),
                4 => format!("G91 G19 G2 Y{r:.3} Z0 R{r:.3}\nG90\n"),
                5 => format!("G17 G5.2 X{x:.3} Y{y:.3} P{r:.3} L4\nX{y:.3} Y{x:.3} P1\nX{r:.3} Y0 P2\nG5.3\n"),
                6 => format!("G91 G17 G3 X{r:.3} Y0 R-{r:.3}\nG90\n"),
                _ => "G20\nG21\n".to_owned(),
            };
        }
        let program = parse(&text).unwrap();
        let mut at = [0.0; 3];
        for element in &program.moves {
            let (first, last) = element.curve.domain();
            let start = element.curve.position(first);
            prop_assert!((0..3).all(|i| (start[i] - at[i]).abs() < 1e-9), "{start:?} after {at:?} in\n{text}");
            at = element.curve.position(last);
        }
    }
}
