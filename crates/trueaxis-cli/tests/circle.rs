//! `trueaxis circle` as called.

use serde_json::Value;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

fn folder(points: &str) -> Folder {
    let directory = Folder::new(TRUEAXIS);
    directory.write("points.csv", points);
    directory
}

fn document(points: &str) -> Value {
    folder(points).json(&["circle", "points.csv", "--json"])
}

fn near(value: &Value, truth: f64) {
    let value = value.as_f64().unwrap();
    assert!((value - truth).abs() < 1e-9, "{value} for {truth}");
}

/// Eight points about (100, −50): four at 10 mm on the axes, two at 10.02 and two at 9.99 on the diagonals.
fn round() -> String {
    let mut text = String::from("# section\ny_mm,x_mm\n");
    let root = 0.5f64.sqrt();
    let place =
        [(1.0, 0.0), (root, root), (0.0, 1.0), (-root, root), (-1.0, 0.0), (-root, -root), (0.0, -1.0), (root, -root)];
    for ((x, y), r) in place.into_iter().zip([10.0, 10.02, 10.0, 9.99, 10.0, 10.02, 10.0, 9.99]) {
        text.push_str(&format!("{},{}\n", -50.0 + r * y, 100.0 + r * x));
    }
    text
}

#[test]
fn all_four_circles_of_a_round_section() {
    let found = document(&round());
    assert_eq!(found["points"], 8);
    let mzc = &found["mzc"];
    near(&mzc["centre_mm"][0], 100.0);
    near(&mzc["centre_mm"][1], -50.0);
    near(&mzc["cx_mm"], 100.0);
    near(&mzc["cy_mm"], -50.0);
    near(&mzc["outer_mm"], 10.02);
    near(&mzc["inner_mm"], 9.99);
    near(&mzc["radius_mm"], 10.005);
    near(&mzc["diameter_mm"], 20.01);
    near(&mzc["zone_um"], 30.0);
    near(&mzc["zone_mm"], 0.03);
    assert_eq!(mzc["contacts"], serde_json::json!([1, 3, 5, 7]));
    near(&found["mcc"]["radius_mm"], 10.02);
    near(&found["lsc"]["radius_mm"], 10.0025);
    assert_eq!(found["lsc"]["contacts"], serde_json::json!([]));
    let mic = found["mic"]["radius_mm"].as_f64().unwrap();
    assert!((mic - 9.99).abs() < 1e-4, "{mic}");
    assert!(found.get("refused").is_none());
}

/// The section in the plane of X and Z, and in a tilted plane: a circle of 10 mm about (30, −20, 5) with the normal
/// (2, −1, 2)/3, whose four points alternate by 1 µm on either side of it.
#[test]
fn other_planes_and_points_in_space() {
    let found = document(&round().replace("y_mm", "z_mm"));
    assert_eq!(found["lsc"]["centre_mm"].as_array().unwrap().len(), 2);
    near(&found["lsc"]["cx_mm"], 100.0);
    near(&found["lsc"]["cz_mm"], -50.0);
    assert!(found["lsc"].get("cy_mm").is_none());
    let ([one, other], normal) = ([[1.0, 2.0, 0.0], [-4.0, 2.0, 5.0]], [2.0, -1.0, 2.0]);
    let mut text = String::from("x_mm,y_mm,z_mm\n");
    for k in 0..8 {
        let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_4).sin_cos();
        let off = if k % 2 == 0 { 1e-3 } else { -1e-3 };
        let at: [f64; 3] = std::array::from_fn(|axis| {
            [30.0, -20.0, 5.0][axis]
                + 10.0 * (cos * one[axis] / 5f64.sqrt() + sin * other[axis] / 45f64.sqrt())
                + off * normal[axis] / 3.0
        });
        text.push_str(&format!("{:?},{:?},{:?}\n", at[0], at[1], at[2]));
    }
    let found = document(&text);
    for (axis, truth) in [30.0, -20.0, 5.0].into_iter().enumerate() {
        near(&found["lsc"]["centre_mm"][axis], truth);
        near(&found["plane"]["normal"][axis], normal[axis] / 3.0);
    }
    near(&found["lsc"]["radius_mm"], 10.0);
    near(&found["plane"]["flatness_um"], 2.0);
    let table = folder(&text).good(&["circle", "points.csv", "--report", "out"]);
    assert!(
        table.contains("in the plane fitted to them: normal 0.666667, −0.333333, 0.666667, flat within 2.000 µm"),
        "{table}"
    );
    assert!(table.contains("centre z, mm"), "{table}");
}

#[test]
fn the_table_gives_the_same_and_the_lines_in_the_file() {
    let text = folder(&round()).good(&["circle", "points.csv"]);
    assert!(text.starts_with("Reference circles: 8 points"), "{text}");
    let ring = text.lines().find_map(|line| line.trim().strip_prefix("MZC, minimum zone")).unwrap();
    let cells: Vec<&str> = ring.split_whitespace().collect();
    assert!((cells[3].parse::<f64>().unwrap() - 30.0).abs() < 1e-6, "{ring}");
    assert_eq!(cells[6..], ["4", "6", "8", "10"], "{ring}");
    for name in ["LSC", "MIC", "MCC"] {
        assert!(text.lines().any(|line| line.trim().starts_with(name)), "{text}");
    }
}

#[test]
fn a_part_arc_has_no_inscribed_circle() {
    let mut text = String::from("x_mm,y_mm\n");
    for i in 0..20 {
        let (sin, cos) = (f64::from(i) * 0.1).sin_cos();
        let r = 50.0 + 0.01 * f64::from(i % 3);
        text.push_str(&format!("{},{}\n", r * cos, r * sin));
    }
    let found = document(&text);
    assert!(found["mic"].is_null());
    assert!(found["refused"]["mic"].as_str().unwrap().contains("part arc"), "{found}");
    assert!((found["lsc"]["radius_mm"].as_f64().unwrap() - 50.0).abs() < 0.1);
    assert!(found["mzc"]["zone_um"].as_f64().unwrap() < 20.1);
    let table = folder(&text).good(&["circle", "points.csv"]);
    assert!(table.lines().any(|line| line.starts_with("note: MIC") && line.contains("part arc")), "{table}");
}

#[test]
fn bad_points_are_refused_with_what_is_needed() {
    let cases: [(&str, &[&str]); 8] = [
        ("x_mm,y_mm\n1,2\n3,4\n", &["points.csv", "points: found 2", "needed at least 3"]),
        (
            "x_mm,y_mm\n0.1,0.1\n0.2,0.2\n0.3,0.3\n0.7,0.7\n",
            &["points.csv", "4 points on one straight line", "needed three"],
        ),
        ("x_mm,y_mm\n1,1\n1,1\n1,1\n", &["points.csv", "found", "needed"]),
        ("x_mm,y_mm\n1,1\nnan,1\n1,5\n", &["points.csv:3", "x_mm", "nan", "a finite number"]),
        ("x_mm,y_mm\n1,1\n2,1\n1,inf\n", &["points.csv:4", "y_mm", "inf"]),
        ("x_mm,w_mm\n1,1\n2,1\n1,3\n", &["points.csv:1", "w_mm"]),
        ("x_mm\n1\n2\n3\n", &["points.csv:1", "two or three of x_mm, y_mm, z_mm"]),
        ("x_mm,y_mm,z_mm\n1,1,1\n2,2,2\n3,3,3\n", &["points.csv", "on one straight line"]),
    ];
    for (text, parts) in cases {
        folder(text).bad(&["circle", "points.csv", "--json"], parts);
    }
}
