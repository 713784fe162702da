//! `trueaxis helicoid` as called.

use serde_json::Value;
use std::fs;
use std::path::Path;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

const BASE: [&str; 4] = ["--base-radius-mm", "36", "--lead-parameter-mm-per-rad", "130"];
const GEAR: [&str; 8] = ["--module-mm", "3", "--teeth", "24", "--pressure-angle-deg", "20", "--helix-angle-deg", "15"];
const GRID: [&str; 4] = ["--u-rad", "0.2:0.6:3", "--theta-rad", "-0.1:0.1:5"];
const PIVOT: [&str; 2] = ["--pivot-mm", "150"];

fn with<'a>(parts: &[&[&'a str]], more: &[&'a str]) -> Vec<&'a str> {
    [&["helicoid"], &parts.concat()[..], more].concat()
}

fn text(parts: &[&[&str]]) -> String {
    Folder::new(TRUEAXIS).good(&with(parts, &[]))
}

fn rows(csv: &str) -> Vec<[f64; 7]> {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("u_rad,theta_rad,x_mm,y_mm,z_mm,a_deg,c_deg"));
    let numbers = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>();
    lines.map(|line| numbers(line).try_into().unwrap()).collect()
}

/// Equal except for the last bit, which this test's JSON reader may round.
fn same(one: &[f64; 7], other: &[f64; 7]) {
    assert!(one.iter().zip(other).all(|(a, b)| (a - b).abs() <= 1e-12), "{one:?} for {other:?}");
}

fn refused(parts: &[&[&str]], said: &[&str]) {
    Folder::new(TRUEAXIS).bad(&with(parts, &["-o", "o.csv", "--gcode", "o.ngc"]), said);
}

/// Values of `tests/reference/helicoid.py`: rotation matrices and difference quotients with 50 digits.
#[test]
fn five_axes_as_from_rotation_matrices_with_fifty_digits() {
    let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference/helicoid.json");
    let reference: Value = serde_json::from_str(&fs::read_to_string(reference).unwrap()).unwrap();
    let cases = reference["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 13);
    for case in cases {
        let arguments: Vec<&str> = case["arguments"].as_array().unwrap().iter().map(|a| a.as_str().unwrap()).collect();
        let document: Value = serde_json::from_str(&text(&[&arguments, &["--json"]])).unwrap();
        for name in ["base_radius_mm", "lead_parameter_mm_per_rad"] {
            let (value, truth) = (document["surface"][name].as_f64().unwrap(), case[name].as_f64().unwrap());
            assert!((value / truth - 1.0).abs() < 1e-14, "{name}: {value} for {truth}");
        }
        let found = rows(&text(&[&arguments]));
        let truth = case["rows"].as_array().unwrap();
        assert_eq!(found.len(), truth.len());
        let mut before: Option<f64> = None;
        for (row, truth) in found.iter().zip(truth) {
            for (i, value) in row.iter().enumerate() {
                let mut gap = value - truth[i].as_f64().unwrap();
                if i == 6 {
                    gap -= 360.0 * (gap / 360.0).round();
                }
                assert!(gap.abs() < 1e-11, "{arguments:?}: {row:?} for {truth}");
            }
            assert!(before.is_none_or(|before| (row[6] - before).abs() < 180.0), "{arguments:?}: C jumps at {row:?}");
            before = Some(row[6]);
        }
    }
}

#[test]
fn c_counts_on_over_full_turns() {
    let degrees = |x: f64| x.to_degrees();
    let turns = ["--u-rad", "1:1:1", "--theta-rad", "7:20:27"];
    let found = rows(&text(&[&BASE, &turns, &PIVOT]));
    for row in &found {
        assert!((row[6] + degrees(row[0] + row[1])).abs() < 1e-9, "{row:?}");
    }
    // Also if C turns by more than half a turn between rows.
    let found = rows(&text(&[&BASE, &["--u-rad", "0:0:1", "--theta-rad", "0:8:3"], &PIVOT]));
    let c: Vec<f64> = found.iter().map(|row| row[6]).collect();
    let truth = [0.0, -degrees(4.0), -degrees(8.0)];
    assert!(c.iter().zip(truth).all(|(c, truth)| (c - truth).abs() < 1e-9), "{c:?}");
    // With one value only START counts, whatever STOP is.
    let one = text(&[&BASE, &["--u-rad", "0.5:3:1", "--theta-rad", "-1:-1:1"], &PIVOT]);
    assert_eq!(rows(&one).iter().map(|row| [row[0], row[1]]).collect::<Vec<_>>(), [[0.5, -1.0]]);
}

#[test]
fn json_holds_inputs_gear_and_points() {
    let document: Value = serde_json::from_str(&text(&[&GEAR, &GRID, &PIVOT, &["--json"]])).unwrap();
    let points = document["points"].as_array().unwrap();
    let names = ["u_rad", "theta_rad", "x_mm", "y_mm", "z_mm", "a_deg", "c_deg"];
    let csv = rows(&text(&[&GEAR, &GRID, &PIVOT]));
    assert_eq!(points.len(), 15);
    for (point, row) in points.iter().zip(csv) {
        same(&names.map(|name| point[name].as_f64().unwrap()), &row);
    }
    let gear = &document["gear"];
    let near = |name: &str, truth: f64| {
        assert!((gear[name].as_f64().unwrap() - truth).abs() < 1e-9, "{name}: {}", gear[name]);
    };
    // d = m_n z/cos β, p_z = π d/tan β; cos β = (√6 + √2)/4, sin β = (√6 − √2)/4.
    let (cos, sin) = ((6f64.sqrt() + 2f64.sqrt()) / 4.0, (6f64.sqrt() - 2f64.sqrt()) / 4.0);
    near("reference_radius_mm", 36.0 / cos);
    near("transverse_module_mm", 3.0 / cos);
    near("lead_mm", std::f64::consts::PI * 72.0 / sin);
    near("lead_parameter_mm_per_rad", 36.0 / sin);
    assert_eq!(document["inputs"]["form"], "horizontal");
    assert_eq!(document["inputs"]["u_rad"]["count"], 3);
    assert_eq!(document["inputs"]["teeth"], 24);
    let of_base: Value = serde_json::from_str(&text(&[&BASE, &GRID, &PIVOT, &["--json"]])).unwrap();
    assert!(of_base["gear"].is_null() && of_base["inputs"]["module_mm"].is_null());
}

#[test]
fn an_edge_finder_gives_the_pivot_length() {
    let finder = ["--edge-finder-mm", "145.5", "--edge-finder-radius-mm", "4.5"];
    let [out, error] = Folder::new(TRUEAXIS).both(&with(&[&BASE, &GRID, &finder], &[]));
    assert_eq!(out, text(&[&BASE, &GRID, &PIVOT]));
    assert!(error.contains("pivot length 150 mm"));
}

fn program(parts: &[&[&str]]) -> Vec<String> {
    let directory = Folder::new(TRUEAXIS);
    assert_eq!(directory.good(&with(parts, &["--gcode", "flank.ngc", "-o", "flank.csv"])), "");
    let text = directory.read("flank.ngc");
    assert!(text.is_ascii());
    text.lines().map(str::to_owned).collect()
}

/// X, Y, Z, A, C after a line of the program.
fn follow(at: [f64; 5], line: &str) -> [f64; 5] {
    let mut at = at;
    for word in line.split_whitespace().skip(1) {
        if let Some(axis) = "XYZAC".find(&word[..1]) {
            at[axis] = word[1..].parse().unwrap();
        }
    }
    at
}

#[test]
fn the_program_goes_through_the_points_back_and_forth() {
    let csv = rows(&text(&[&GEAR, &GRID, &PIVOT]));
    for along in ["theta", "u"] {
        let lines = program(&[&GEAR, &GRID, &PIVOT, &["--passes", along, "--feed-mm-per-min", "250"]]);
        let mut order: Vec<[f64; 7]> = Vec::new();
        let (slow, fast) = if along == "theta" { (3, 5) } else { (5, 3) };
        for i in 0..slow {
            for k in 0..fast {
                let k = if i % 2 == 0 { k } else { fast - 1 - k };
                order.push(csv[if along == "theta" { i * 5 + k } else { k * 5 + i }]);
            }
        }
        assert!(lines.iter().any(|line| line == "G21 G90 G94"));
        assert_eq!(lines.last().unwrap(), "M2");
        let cuts: Vec<&String> = lines.iter().filter(|line| line.starts_with("G1 ")).collect();
        assert!(cuts[0].ends_with(" F250") && cuts.len() == order.len());
        for (line, row) in cuts.iter().zip(&order) {
            let at = follow([f64::NAN; 5], line);
            assert!((0..5).all(|i| (at[i] - row[2 + i]).abs() <= 5.1e-10), "{line} for {row:?}");
        }
        for comment in lines.iter().filter(|line| line.starts_with('(')) {
            assert!(comment.ends_with(')') && comment.matches(['(', ';']).count() == 1, "{comment}");
        }
    }
}

/// Before the first cut the head turns only where no tool of that length can touch, and then descends onto the normal.
#[test]
fn the_program_turns_the_head_above_the_part_only() {
    for (form, rest) in [("vertical", [0.0, 1.0]), ("horizontal", [1.0, 0.0])] {
        for branch in ["1", "2"] {
            let set_up = ["--form", form, "--branch", branch, "--work-offset-mm", "5,-7,20", "--clearance-mm", "30"];
            let lines = program(&[&GEAR, &GRID, &PIVOT, &set_up]);
            let mut at = [0.0; 5];
            let mut before_cut = None;
            for line in lines.iter().filter(|line| line.starts_with("G0 ") || line.starts_with("G1 ")) {
                let to = follow(at, line);
                // The pivot is L above the tip along the spindle's direction at A = 0.
                let pivot_height = at[2] + 150.0 * rest[1];
                let top = 36.0 / ((6f64.sqrt() - 2f64.sqrt()) / 4.0) * 0.1 + 20.0;
                if line.starts_with("G0 ") && to[3..] != at[3..] {
                    assert!(pivot_height >= top + 150.0 + 30.0 - 1e-6, "{form} {branch}: {line}");
                }
                if line.starts_with("G1 ") && before_cut.is_none() {
                    // 30 mm straight back along the spindle, A and C already there.
                    before_cut = Some(());
                    let a = to[3].to_radians();
                    let spindle = [0.0, rest[0] * a.cos() - rest[1] * a.sin(), rest[0] * a.sin() + rest[1] * a.cos()];
                    assert!((0..3).all(|i| (at[i] - to[i] - 30.0 * spindle[i]).abs() < 1e-8), "{form} {branch}");
                    assert_eq!(at[3..], to[3..]);
                }
                at = to;
            }
            assert!(before_cut.is_some());
        }
    }
}

/// Six decimals as printed on a page: groups of three with narrow spaces, a true minus sign.
fn as_on_a_page(value: f64) -> String {
    let text = format!("{value:.6}");
    if text.trim_start_matches(['-', '0', '.']).is_empty() { text.replace('-', "") } else { text.replace('-', "−") }
}

/// Rows of the tables whose first column has this heading, as cells, without the spaces that group digits.
fn table(page: &str, heading: &str) -> Vec<Vec<String>> {
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let tree = roxmltree::Document::parse_with_options(page, options).unwrap();
    let all = |node: roxmltree::Node<'_, '_>| {
        node.descendants()
            .filter_map(|n| if n.is_text() { n.text() } else { None })
            .collect::<String>()
            .replace('\u{202f}', "")
    };
    let tables = tree.descendants().filter(|node| node.has_tag_name("table"));
    let found =
        tables.filter(|table| all(table.descendants().find(|node| node.has_tag_name("th")).unwrap()) == heading);
    let rows = found.flat_map(|table| table.descendants().filter(|node| node.has_tag_name("tr")).skip(1));
    rows.map(|row| row.children().filter(|node| node.is_element()).map(all).collect()).collect()
}

#[test]
fn the_page_is_whole_and_shows_the_same_values() {
    let directory = Folder::new(TRUEAXIS);
    for (path, file) in [("page.html", "page.html"), ("folder", "folder/helicoid.html")] {
        directory.good(&with(&[&GEAR, &GRID, &PIVOT], &["-o", "o.csv", "--report", path]));
        let page = directory.read(file);
        let addresses = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
        for outside in ["src=", "http:", "https:", "@import", "url(", "<script"] {
            assert!(!addresses.contains(outside), "{outside}");
        }
        assert!(page.contains("trueaxis desk"));
        let csv = rows(&directory.read("o.csv"));
        let points = table(&page, "u, rad");
        assert_eq!(points.len(), csv.len());
        for (shown, row) in points.iter().zip(&csv) {
            let [u, theta] = [0, 1].map(|i| shown[i].replace('−', "-").parse::<f64>().unwrap());
            assert!((u - row[0]).abs() <= 5e-7 && (theta - row[1]).abs() <= 5e-7, "{shown:?} for {row:?}");
            assert_eq!(shown[2..], row[2..].iter().map(|value| as_on_a_page(*value)).collect::<Vec<_>>());
        }
        for (i, (shown, name)) in table(&page, "axis").iter().zip(["X", "Y", "Z", "A", "C"]).enumerate() {
            let of = || csv.iter().map(|row| row[2 + i]);
            let [low, high] = [of().fold(f64::INFINITY, f64::min), of().fold(f64::NEG_INFINITY, f64::max)];
            assert_eq!(shown[..4], [name.to_owned(), as_on_a_page(low), as_on_a_page(high), as_on_a_page(high - low)]);
        }
        let quantities = table(&page, "");
        let of = |name: &str| quantities.iter().find(|row| row[0] == name).unwrap()[1].clone();
        let sin = (6f64.sqrt() - 2f64.sqrt()) / 4.0;
        assert_eq!(of("lead"), as_on_a_page(std::f64::consts::PI * 72.0 / sin));
        assert!(quantities.contains(&vec!["pivot length L".into(), "150".into(), "mm".into()]));
    }
}

/// Each of the five figures has as many curves as values of u, at most five; with a single θ, one curve over u.
#[test]
fn the_page_draws_five_displacements_for_several_u() {
    let directory = Folder::new(TRUEAXIS);
    for (grid, curves, along) in [
        (["0.1:0.7:7", "0:1:21"], 5, "θ in rad"),
        (["0.2:0.4:2", "0:1:3"], 2, "θ in rad"),
        (["0.2:0.4:9", "1:1:1"], 1, "u in rad"),
    ] {
        let grid = ["--u-rad", grid[0], "--theta-rad", grid[1]];
        directory.good(&with(&[&BASE, &grid, &PIVOT], &["-o", "o.csv", "--report", "p.html"]));
        let page = directory.read("p.html");
        for axis in ["X", "Y", "Z", "A", "C"] {
            let figure =
                page.split("<figure").find(|figure| figure.contains(&format!("Displacement of {axis} over {along}")));
            let figure = figure.unwrap_or_else(|| panic!("no figure of {axis}"));
            assert_eq!(figure.matches("class=\"key\"").count(), curves, "{axis} of {grid:?}");
        }
    }
}

#[test]
fn surfaces_that_are_not_given_or_given_twice_are_refused() {
    refused(&[&BASE, &GEAR, &GRID, &PIVOT], &["--base-radius-mm", "--module-mm", "either"]);
    refused(&[&BASE, &["--teeth", "24"], &GRID, &PIVOT], &["--base-radius-mm", "--teeth"]);
    refused(&[&GRID, &PIVOT], &["no surface", "--module-mm", "--base-radius-mm"]);
    refused(&[&BASE[..2], &GRID, &PIVOT], &["--lead-parameter-mm-per-rad"]);
    refused(&[&BASE[2..], &GRID, &PIVOT], &["needed --base-radius-mm"]);
    refused(&[&GEAR[..6], &GRID, &PIVOT], &["needed --helix-angle-deg"]);
    refused(&[&GEAR[2..], &GRID, &PIVOT], &["needed --module-mm"]);
    refused(&[&BASE, &PIVOT, &GRID[..2]], &["--theta-rad"]);
    refused(&[&BASE, &PIVOT, &GRID[2..]], &["--u-rad"]);
}

#[test]
fn surfaces_that_cannot_be_are_refused() {
    let gear = |i: usize, value: &'static str| {
        let mut gear = GEAR;
        gear[i] = value;
        gear
    };
    for (i, values, option) in [
        (1, &["0", "-3", "nan", "inf", "three"][..], "--module-mm"),
        (3, &["0", "-24", "24.5", "10001"], "--teeth"),
        (5, &["0", "-20", "90", "nan"], "--pressure-angle-deg"),
        (7, &["0", "-0", "90", "-90", "inf"], "--helix-angle-deg"),
    ] {
        for value in values {
            refused(&[&gear(i, value), &GRID, &PIVOT], &[option, "found", "needed"]);
        }
    }
    for (i, values, option) in [
        (1, &["0", "-36", "nan", "1e300"][..], "--base-radius-mm"),
        (3, &["0", "inf", "nan", "-1e300"], "--lead-parameter-mm-per-rad"),
    ] {
        for value in values {
            let mut base = BASE;
            base[i] = value;
            refused(&[&base, &GRID, &PIVOT], &[option, "found", "needed"]);
        }
    }
}

#[test]
fn flanks_that_face_away_from_the_tool_are_refused() {
    refused(&[&BASE, &GRID, &PIVOT, &["--flank", "left"]], &["--flank", "faces away from the tool"]);
    refused(&[&gear_left_hand(), &GRID, &PIVOT], &["--flank", "faces away from the tool"]);
    let left = ["--u-rad", "-0.6:-0.2:3", "--theta-rad", "-0.1:0.1:5", "--flank", "left"];
    assert_eq!(rows(&text(&[&gear_left_hand(), &left, &PIVOT])).len(), 15);
    refused(&[&gear_left_hand(), &GRID, &PIVOT, &["--flank", "left"]], &["--u-rad: found 0.2", "u <= 0"]);
    refused(
        &[&BASE, &["--u-rad", "-1:2:10", "--theta-rad", "-1:2:10"], &PIVOT],
        &["--u-rad: found -1", "u >= 0 on the right flank"],
    );
    refused(&[&BASE, &GRID, &PIVOT, &["--flank", "top"]], &["--flank"]);
}

fn gear_left_hand() -> [&'static str; 8] {
    let mut gear = GEAR;
    gear[7] = "-15";
    gear
}

#[test]
fn grids_that_cannot_be_are_refused() {
    for grid in ["0.1:0.2:0", "0.1:0.2", "0.1:0.2:3:4", "0.1:0.2:-3", "0.1:0.2:1.5", "nan:1:3", "0:inf:3", "a:b:c", ""]
    {
        refused(&[&BASE, &PIVOT, &["--u-rad", grid, "--theta-rad", "0:1:3"]], &["--u-rad", "found", "needed"]);
        refused(&[&BASE, &PIVOT, &["--theta-rad", grid, "--u-rad", "0:1:3"]], &["--theta-rad", "found", "needed"]);
    }
    refused(&[&BASE, &PIVOT, &["--theta-rad", "0:1:1001", "--u-rad", "0:1:1000"]], &["found 1001000 points"]);
    refused(&[&BASE, &PIVOT, &["--theta-rad", "0:1e5:2", "--u-rad", "0:1:2"]], &["--theta-rad", "100000"]);
}

#[test]
fn machines_that_cannot_be_are_refused() {
    refused(&[&BASE, &GRID], &["no pivot length", "--pivot-mm", "--edge-finder-mm"]);
    refused(&[&BASE, &GRID, &PIVOT, &["--edge-finder-mm", "145"]], &["both --pivot-mm and an edge finder"]);
    refused(&[&BASE, &GRID, &["--edge-finder-mm", "145"]], &["--edge-finder-radius-mm"]);
    refused(&[&BASE, &GRID, &["--edge-finder-radius-mm", "5"]], &["--edge-finder-mm"]);
    let finder = |a, r| ["--edge-finder-mm", a, "--edge-finder-radius-mm", r];
    refused(&[&BASE, &GRID, &finder("145", "0")], &["--edge-finder-radius-mm: found 0"]);
    refused(&[&BASE, &GRID, &finder("-10", "5")], &["found -5"]);
    for pivot in ["-1", "nan", "inf", "long", "1e7"] {
        refused(&[&BASE, &GRID, &["--pivot-mm", pivot]], &["--pivot-mm", "found", "needed"]);
    }
    for (option, values) in [
        ("--work-offset-mm", &["1,2", "1,2,3,4", "1,x,3", "1,nan,3", "1,2,1e9"][..]),
        ("--direction-a", &["0", "2", "-2", "+"]),
        ("--direction-c", &["0", "1.5"]),
        ("--feed-mm-per-min", &["0", "-5", "nan"]),
        ("--clearance-mm", &["-1", "inf"]),
    ] {
        for value in values {
            refused(&[&BASE, &GRID, &PIVOT, &[option, value]], &[option, "found", "needed"]);
        }
    }
    for (option, value) in [("--branch", "3"), ("--branch", "0"), ("--form", "slanted"), ("--passes", "both")] {
        refused(&[&BASE, &GRID, &PIVOT, &[option, value]], &[option]);
    }
}
