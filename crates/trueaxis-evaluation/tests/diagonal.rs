//! Diagonal and step-diagonal tests of machines whose tip moves by exact transforms, read by a simulated laser and mirror.

use std::fmt::Write;
use std::path::Path;
use trueaxis::Axis;
use trueaxis::machine::AXES;
use trueaxis_evaluation::diagonal::{COLUMNS, DiagonalDocument, read};
use trueaxis_evaluation::rows::Rows;
use trueaxis_metrology::diagonal::Test;
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::{Machine, Table};
use trueaxis_testing::machine::{Machine as Settings, rows};
use trueaxis_testing::noise::Noise;

const BOX: [[f64; 2]; 3] = [[-300.0, 300.0], [-200.0, 200.0], [-250.0, 150.0]];
const STEPS: usize = 10;
const SIGNS: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]];

/// A machine with squareness, scales (ppm), a bow of its straightness EYX (µm) and play in every axis (µm).
fn machine(chain: &str, scales: [f64; 3], bow: f64, play: [f64; 3]) -> Machine {
    let settings = Settings::new(chain).with(|machine| {
        (machine.location.a0z, machine.location.b0z, machine.location.c0y) = (31e-6, -22e-6, 45e-6);
    });
    let mut settings = settings.settings();
    let mut tables = Vec::new();
    for own in &mut settings.axes {
        let axis = own.axis.index();
        let [low, high] = BOX[axis];
        own.backlash = 1e-3 * play[axis];
        let at = (0..=20).map(|k| low + (high - low) * f64::from(k) / 20.0);
        let table = rows(at, |q| {
            let mut twist = [0.0; 6];
            twist[axis] = 1e-6 * scales[axis] * q;
            if own.axis == Axis::X {
                twist[1] = 1e-3 * bow * (1.0 - (q / 300.0).powi(2));
            }
            twist
        });
        tables.push(Some(Table { given: [true; 6], bidirectional: false, rows: table }));
    }
    Machine { settings, tables, grids: Vec::new() }
}

/// Positions along a diagonal, stepwise X, Y, Z or together.
fn path(signs: [f64; 3], stepwise: bool) -> Vec<[f64; 3]> {
    let end = |axis: usize, k: usize| {
        let [low, high] = BOX[axis];
        let share = k as f64 / STEPS as f64;
        if signs[axis] > 0.0 { low + (high - low) * share } else { high - (high - low) * share }
    };
    let mut at = [0, 1, 2].map(|axis| end(axis, 0));
    let mut path = vec![at];
    for k in 1..=STEPS {
        for axis in 0..3 {
            at[axis] = end(axis, k);
            if stepwise {
                path.push(at);
            }
        }
        if !stepwise {
            path.push(at);
        }
    }
    path
}

/// The record; `tilts` of the mirror on every diagonal, rad; `noise_um` of a reading, µm.
fn record(machine: &Machine, stepwise: bool, runs: u32, tilts: [[f64; 3]; 4], noise_um: f64) -> String {
    let geometry = Geometry::new(machine, 0.0).unwrap();
    let mut noise = Noise::new(2306);
    let mut text = String::from("diagonal,run,direction,x_mm,y_mm,z_mm,deviation_um\n");
    for (k, signs) in SIGNS.into_iter().enumerate() {
        let way = path(signs, stepwise);
        let (from, to) = (way[0], *way.last().unwrap());
        let length = (0..3).map(|c| (to[c] - from[c]).powi(2)).sum::<f64>().sqrt();
        let unit = [0, 1, 2].map(|c| (to[c] - from[c]) / length);
        let tilt = tilts[k];
        let along: f64 = (0..3).map(|c| tilt[c] * unit[c]).sum();
        let normal = [0, 1, 2].map(|c| unit[c] + tilt[c] - along * unit[c]);
        // A plane mirror on the tip: its distance along the beam.
        let distance = |p: [f64; 3], reverse: f64| {
            let mut at = [0.0; AXES];
            at[..3].copy_from_slice(&p);
            let mut back = [0.0; AXES];
            for c in 0..3 {
                back[c] = if (signs[c] > 0.0) == (reverse > 0.5) { 1.0 } else { 0.0 };
            }
            let e = geometry.tip_error(&at, &back);
            (0..3).map(|c| normal[c] * (p[c] + e[c] - from[c])).sum::<f64>()
        };
        let zero = distance(from, 0.0);
        for run in 1..=runs {
            for direction in [1, -1] {
                let order: Vec<_> = if direction > 0 { way.clone() } else { way.iter().rev().copied().collect() };
                for p in order {
                    let nominal: f64 = (0..3).map(|c| unit[c] * (p[c] - from[c])).sum();
                    let back = if direction > 0 { 0.0 } else { 1.0 };
                    let gauss: f64 = (0..12).map(|_| noise.unit()).sum::<f64>() - 6.0;
                    let deviation = 1e3 * (distance(p, back) - zero - nominal) + noise_um * gauss;
                    let [x, y, z] = p;
                    writeln!(text, "{},{run},{direction},{x},{y},{z},{deviation}", k + 1).unwrap();
                }
            }
        }
    }
    text
}

fn test(text: &str) -> anyhow::Result<Test> {
    read(&mut Rows::new(text.as_bytes(), Path::new("record.csv"), &COLUMNS, |_| {})?)
}

/// For four structural codes, with and without steps.
#[test]
fn squareness_and_scale_are_those_of_the_machine() {
    for chain in ["w b X Y Z t", "w X' Y' b Z t", "w Y' b X Z t", "w X' b Y Z t"] {
        for stepwise in [false, true] {
            let text = record(&machine(chain, [12.0, -20.0, 33.0], 0.0, [0.0; 3]), stepwise, 2, [[0.0; 3]; 4], 0.0);
            let found = DiagonalDocument::new(&test(&text).unwrap(), None);
            let near = |value: f64, truth: f64| assert!((value - truth).abs() < 0.02, "{chain}: {value} for {truth}");
            near(found.a0z.value, 31.0);
            near(found.b0z.value, -22.0);
            near(found.c0y.value, 45.0);
            let u = found.diagonals[0].unit.map(|part| part * part);
            near(found.scale.value, 12.0 * u[0] - 20.0 * u[1] + 33.0 * u[2]);
            assert_eq!(found.rank, 4);
            assert_eq!(found.test, if stepwise { "step-diagonal" } else { "diagonal" });
            assert_eq!(found.steps.is_some(), stepwise);
        }
    }
}

/// E(D) and B(D) of a machine with scale errors only, and of one with play only: computed by hand.
#[test]
fn figures_are_those_of_the_standard() {
    let text = record(&machine("w b X Y Z t", [20.0; 3], 0.0, [0.0; 3]), false, 5, [[0.0; 3]; 4], 0.0);
    let found = DiagonalDocument::new(&test(&text).unwrap(), None);
    // Apart from squareness, 20 ppm of 824.6 mm; with it, the slopes of the four differ.
    for of in &found.diagonals {
        assert!((of.e_um - (of.slope_ppm.value * of.length_mm * 1e-3).abs()).abs() < 1e-3, "{of:?}");
        assert!(of.b_um.unwrap() < 1e-9 && of.r_um.unwrap() < 1e-9, "{of:?}");
    }
    let text = record(&machine("w b X Y Z t", [0.0; 3], 0.0, [4.0, 2.0, 6.0]), false, 5, [[0.0; 3]; 4], 0.0);
    let found = DiagonalDocument::new(&test(&text).unwrap(), None);
    for of in &found.diagonals {
        // Every axis reverses with its play, which projects onto the diagonal: Σ |u_i| b_i, whatever the signs.
        let [x, y, z] = of.unit.map(f64::abs);
        assert!((of.b_um.unwrap() - (4.0 * x + 2.0 * y + 6.0 * z)).abs() < 2e-3, "{of:?}");
    }
}

/// The published vector method gives the scales if the mirror is square, and is wrong by the tilt if it is not; the tilt
/// affects neither squareness nor shapes. With the alignment's uncertainty stated, the scales are within their standard
/// errors.
#[test]
fn a_tilted_mirror_moves_the_scales_and_nothing_else() {
    let machine = machine("w X' Y' b Z t", [12.0, -20.0, 33.0], 8.0, [0.0; 3]);
    let square = DiagonalDocument::new(&test(&record(&machine, true, 1, [[0.0; 3]; 4], 0.0)).unwrap(), None);
    let steps = square.steps.as_ref().unwrap();
    for (found, truth) in steps.scales_if_aligned_ppm.into_iter().zip([12.0, -20.0, 33.0]) {
        assert!((found - truth).abs() < 0.05, "{found} for {truth}");
    }
    let bow = |document: &DiagonalDocument| {
        let shape = document.steps.as_ref().unwrap().shapes.iter().find(|shape| shape.axis == 'X').unwrap();
        shape.points.iter().map(|point| point.error_um[1]).fold(0.0, f64::max)
    };
    assert!((bow(&square) - 8.0).abs() < 0.02, "{}", bow(&square));
    let tilts = [[40e-6, -30e-6, 0.0], [-25e-6, 0.0, 35e-6], [0.0, 45e-6, -20e-6], [30e-6, 30e-6, -10e-6]];
    let text = record(&machine, true, 1, tilts, 0.0);
    let tilted = DiagonalDocument::new(&test(&text).unwrap(), Some(40.0));
    let steps = tilted.steps.as_ref().unwrap();
    let off = steps.scales_if_aligned_ppm[0] - 12.0;
    assert!(off.abs() > 5.0, "a tilt of 40 µrad that does nothing: {off}");
    assert!((tilted.c0y.value - square.c0y.value).abs() < 0.02 && (tilted.a0z.value - square.a0z.value).abs() < 0.02);
    assert!((bow(&tilted) - bow(&square)).abs() < 0.02);
    for (found, truth) in steps.scales_ppm.unwrap().into_iter().zip([12.0, -20.0, 33.0]) {
        assert!(found.standard_error > 5.0 && (found.value - truth).abs() < 3.0 * found.standard_error, "{found:?}");
    }
    assert!(DiagonalDocument::new(&test(&text).unwrap(), None).steps.unwrap().scales_ppm.is_none());
}

/// Standard errors are realistic: over 200 records with noise the squarenesses scatter as stated.
#[test]
fn standard_errors_are_those_of_repeated_records() {
    let machine = machine("w b X Y Z t", [0.0; 3], 0.0, [0.0; 3]);
    let clean = record(&machine, false, 3, [[0.0; 3]; 4], 0.0);
    let mut inside = 0;
    let mut noise = Noise::new(6);
    for _ in 0..200 {
        let mut text = String::new();
        for line in clean.lines() {
            match line.rsplit_once(',').and_then(|(rest, value)| Some((rest, value.parse::<f64>().ok()?))) {
                Some((rest, value)) => {
                    let gauss: f64 = (0..12).map(|_| noise.unit()).sum::<f64>() - 6.0;
                    writeln!(text, "{rest},{}", value + 0.5 * gauss).unwrap();
                }
                None => writeln!(text, "{line}").unwrap(),
            }
        }
        let found = DiagonalDocument::new(&test(&text).unwrap(), None);
        inside += usize::from((found.c0y.value - 45.0).abs() <= 2.0 * found.c0y.standard_error);
    }
    assert!((180..=199).contains(&inside), "{inside} of 200 within two standard errors");
}

#[test]
fn unreadable_records_are_refused_with_their_line() {
    let good = record(&machine("w b X Y Z t", [12.0, -20.0, 33.0], 0.0, [1.0; 3]), false, 2, [[0.0; 3]; 4], 0.3);
    let refused = |text: &str, message: &str| {
        let error = format!("{:#}", test(text).unwrap_err());
        assert!(error.contains(message), "{error} without {message}");
    };
    let without: String = good.lines().filter(|line| !line.starts_with("3,")).map(|line| format!("{line}\n")).collect();
    refused(&without, "record.csv: found no reading of diagonal 3, needed diagonals 1 to 4");
    let lines: Vec<&str> = good.lines().collect();
    refused(
        &format!("{good}{}\n", lines[5]),
        ":178: column deviation_um: found this target a second time in this run and direction, first in line 6",
    );
    // One reading of 176 missing: the first of all, the first of another diagonal, one in the middle, the last of a run.
    for (line, message) in [
        (
            1,
            "diagonal 1, run 1, away: found 10 of 11 readings, none at X -300, Y -200, Z -250 mm, needed the same targets",
        ),
        (
            45,
            "diagonal 2, run 1, away: found 10 of 11 readings, none at X 300, Y -200, Z -250 mm, needed the same targets",
        ),
        (94, "diagonal 3, run 1, away: found 10 of 11 readings, none at X 0, Y 0, Z -50 mm, needed the same targets"),
        (
            176,
            "diagonal 4, run 2, back: found 10 of 11 readings, none at X -300, Y -200, Z 150 mm, needed the same targets",
        ),
    ] {
        let left: Vec<&str> = lines.iter().enumerate().filter(|(k, _)| *k != line).map(|(_, line)| *line).collect();
        refused(&left.join("\n"), message);
    }
    let run: Vec<&str> = lines.iter().filter(|line| !line.starts_with("2,2,-1,")).copied().collect();
    refused(&run.join("\n"), "diagonal 2: found 1 run back, needed 2 as on diagonal 1");
    refused(&good.replacen(lines[7].rsplit_once(',').unwrap().1, "16000", 1), ":8: column deviation_um: found 16000");
    refused(&good.replacen("\n2,", "\n5,", 1), "column diagonal: found 5, needed 1, 2, 3 or 4");
    refused(&good.replacen("\n1,1,1,", "\n1,1,0,", 1), ":2: column direction: found 0");
    // The laser reading freezes from the second diagonal on.
    let mut dead = String::new();
    for (i, line) in lines.iter().enumerate() {
        let (rest, _) = line.rsplit_once(',').unwrap();
        if i > 60 { writeln!(dead, "{rest},-3.25").unwrap() } else { writeln!(dead, "{line}").unwrap() }
    }
    refused(&dead, ":62: column deviation_um: found -3.25 for 116 readings in a row");
    // The same diagonal twice.
    let twice: String = good
        .lines()
        .map(|line| match line.strip_prefix("1,") {
            Some(rest) => format!("1,{rest}\n2,{rest}\n"),
            None if line.starts_with("2,") => String::new(),
            None => format!("{line}\n"),
        })
        .collect();
    refused(&twice, "diagonal 2: found another box, or a diagonal that is there already");
}
