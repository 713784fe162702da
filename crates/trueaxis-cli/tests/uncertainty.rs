//! `trueaxis uncertainty` as called, and bands and verdicts of `trueaxis tables accuracy`.

use std::fs;
use std::path::{Path, PathBuf};
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables").join(name)
}

/// X 0 to 200 mm, Y 0 to 200 mm, linear tables of two points.
fn machine(folder: &Folder, stated: &str) {
    folder.write(
        "machine.toml",
        format!(
            "name = \"small\"\nchain = \"w X' Y' b Z t\"\n[axis.X]\ntable = \"x.csv\"\ntravel_mm = [0, 200]\n\
             [axis.Y]\ntravel_mm = [0, 200]\n[axis.Z]\ntravel_mm = [-100, 0]\n{stated}"
        ),
    );
    folder.write("x.csv", "X_mm,EXX_um,EYX_um\n0,0,0\n200,4,1\n");
}

fn spread(document: &serde_json::Value, place: &str, method: &str) -> [f64; 4] {
    let of = &document[place][method];
    let [x, y, z] = [0, 1, 2].map(|i| of["expanded_um"][i].as_f64().unwrap());
    [x, y, z, of["radius_um"].as_f64().unwrap()]
}

#[test]
fn analytic_cases() {
    let folder = Folder::new(TRUEAXIS);
    let k = 1.959_963_985;
    let found = |stated: &str, at: &str| {
        machine(&folder, stated);
        folder.json(&["uncertainty", ".", "--at", at, "--json", "--trials", "4000"])
    };
    let near = |found: [f64; 4], wanted: [f64; 4], tolerance: f64| {
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert!((found - wanted).abs() <= tolerance * wanted.abs() + 1e-6, "{found} for {wanted}");
        }
    };
    // EXY −= C0Y y: 5 µrad over 100 mm are 0.5 µm.
    let squareness = found("[uncertainty.location]\nC0Y_urad = 5\n", "50,100,-20");
    near(spread(&squareness, "at", "jacobian"), [0.5 * k, 0.0, 0.0, 0.5 * k], 1e-6);
    near(spread(&squareness, "at", "monte_carlo"), [0.5 * k, 0.0, 0.0, 0.5 * k], 0.05);
    near(spread(&squareness, "worst", "jacobian"), [1.0 * k, 0.0, 0.0, 1.0 * k], 1e-6);
    assert_eq!(squareness["contributions"][0]["term"], "C0Y");
    assert!((squareness["contributions"][0]["share"].as_f64().unwrap() - 1.0).abs() < 1e-12);
    // Uncertainty of a table's nodes, at a node and between two.
    let points = "[axis.X.uncertainty]\nEXX_um = 2\ndegrees_of_freedom = 4\n";
    let at_point = found(points, "200,0,0");
    near(spread(&at_point, "at", "jacobian")[..1].repeat(4).try_into().unwrap(), [2.0 * 2.776_445; 4], 1e-6);
    let between = spread(&found(points, "100,0,0"), "at", "jacobian");
    assert!((between[0] - 2.0 * 0.5_f64.sqrt() * 2.776_445).abs() < 1e-5, "{between:?}");
    // Scale: 3 ppm of 100 mm; and temperature: 0.5 K with α = 11.5 µm/(m K).
    let scale = found("[axis.X.uncertainty]\nscale_ppm = 3\n", "100,0,0");
    near(spread(&scale, "at", "jacobian"), [0.3 * k, 0.0, 0.0, 0.3 * k], 1e-6);
    let warm = "[uncertainty]\ntemperature_k = 0.5\n[axis.X.thermal]\nexpansion_um_per_m_k = 11.5\n";
    near(spread(&found(warm, "100,0,0"), "at", "jacobian"), [0.575 * k, 0.0, 0.0, 0.575 * k], 1e-6);
}

#[test]
fn the_sample_mill() {
    let folder = Folder::new(TRUEAXIS);
    let mill = sample("mill-3axis");
    let mill = mill.to_str().unwrap();
    let arguments = ["uncertainty", mill, "--at", "120,-40,-200", "--trials", "3000", "--json", "--report", "out"];
    let found = folder.json(&arguments);
    for place in ["worst", "at"] {
        let [first, drawn] = ["jacobian", "monte_carlo"].map(|method| spread(&found, place, method));
        for (first, drawn) in first.into_iter().zip(drawn) {
            // Quantities with 8 degrees of freedom are drawn from Student's distribution, 1.15 times as wide as its scale.
            assert!(first > 0.5 && (0.98..1.1).contains(&(drawn / first)), "{place}: {first} {drawn}");
        }
    }
    let differ = |warning: &serde_json::Value| warning.as_str().unwrap().contains("the methods differ");
    assert!(found["warnings"].as_array().unwrap().iter().all(differ), "{}", found["warnings"]);
    let shares: f64 =
        found["contributions"].as_array().unwrap().iter().map(|share| share["share"].as_f64().unwrap()).sum();
    assert!((shares - 1.0).abs() < 1e-9);
    let not_stated = found["not_stated"].to_string();
    assert!(not_stated.contains("axis.X.uncertainty.scale_ppm") && !not_stated.contains("eve_um"), "{not_stated}");
    let page = fs::read_to_string(folder.join("out/uncertainty.html")).unwrap();
    assert!(page.contains("Contributions") && page.contains("<svg") && page.contains("C0Y"));
    // The same seed draws the same machines; the text shows both methods.
    assert_eq!(folder.json(&arguments), found);
    let text = folder.good(&["uncertainty", mill, "--trials", "500"]);
    assert!(text.contains("by derivatives") && text.contains("by machines drawn"), "{text}");
    assert!(text.contains("not stated, taken as zero: "), "{text}");
}

#[test]
fn few_degrees_of_freedom_and_cosine_errors_are_reported() {
    let folder = Folder::new(TRUEAXIS);
    // A cosine error is one-sided and skewed: the methods differ.
    machine(&folder, "[uncertainty]\nmisalignment_mm = 5\n");
    let found = folder.json(&["uncertainty", ".", "--json", "--trials", "4000"]);
    assert!(found["warnings"][0].as_str().unwrap().contains("the methods differ"), "{}", found["warnings"]);
}

#[test]
fn bad_uncertainties_and_arguments_are_refused() {
    let folder = Folder::new(TRUEAXIS);
    let grinder = sample("grinder");
    for (stated, arguments, message) in [
        ("", vec![], "found no standard uncertainty above zero"),
        ("[uncertainty]\neve_um = 0\n", vec![], "found no standard uncertainty above zero"),
        ("[uncertainty]\neve_um = -1\n", vec![], "needed a standard uncertainty of 0 to 1000 um"),
        ("[uncertainty]\neve_um = nan\n", vec![], "a finite number"),
        ("[uncertainty]\neve_um = 1\n", vec!["--confidence", "100"], "confidence: found 100 %"),
        ("[uncertainty]\neve_um = 1\n", vec!["--trials", "1"], "trials: found 1"),
        ("[uncertainty]\neve_um = 1\n", vec!["--points", "1"], "points along X: found 1"),
        ("[uncertainty]\neve_um = 1\n", vec!["--volume", "5:1,,"], "needed a rising range"),
        ("[uncertainty]\neve_um = 1\n", vec!["--pose", "A=1"], "needed a rotary axis of the machine"),
        ("[uncertainty]\neve_um = 1\n", vec!["--at", "1,2"], "--at: found 2 numbers"),
    ] {
        machine(&folder, stated);
        let arguments: Vec<&str> = ["uncertainty", ".", "--report", "out"].into_iter().chain(arguments).collect();
        folder.bad(&arguments, &[message]);
    }
    folder.bad(&["uncertainty", grinder.to_str().unwrap()], &["needed [uncertainty]"]);
}

#[test]
fn accuracy_has_bands_and_no_verdict_within_them() {
    let folder = Folder::new(TRUEAXIS);
    let (mill, measured) = (sample("mill-3axis"), sample("mill-3axis/x-iso230-2.csv"));
    let (mill, measured) = (mill.to_str().unwrap(), measured.to_str().unwrap());
    let run = |tolerance: &str| {
        folder.json(&["tables", "accuracy", measured, "--instrument", mill, "--tolerance-um", tolerance, "--json"])
    };
    let found = run("30");
    let band = found["uncertainty"]["figures"][0].clone();
    assert_eq!(band["figure"], "A");
    let [value, low, high] =
        [&band["value"], &band["interval"]["low"], &band["interval"]["high"]].map(|number| number.as_f64().unwrap());
    assert_eq!(value, found["measured"]["both"]["accuracy"].as_f64().unwrap());
    assert!(low < value && value < high + 0.5 && high - low > 0.2, "{band}");
    for (tolerance, verdict) in [(high + 0.01, "pass"), (low - 0.01, "fail"), (0.5 * (low + high), "undecided")] {
        assert_eq!(run(&tolerance.to_string())["verdict"]["verdict"], verdict);
    }
    let text = folder.good(&["tables", "accuracy", measured, "--instrument", mill, "--tolerance-um", "1000"]);
    assert!(text.contains("± 95 %") && text.contains("kept, uncertainty included: pass"), "{text}");
    for (arguments, message) in [
        (vec!["--tolerance-um", "30"], "--instrument"),
        (vec!["--instrument", mill, "--tolerance-um", "-1"], "--tolerance-um: found -1"),
        (vec!["--instrument", mill, "--confidence", "20"], "--confidence: found 20"),
    ] {
        let arguments: Vec<&str> = ["tables", "accuracy", measured].into_iter().chain(arguments).collect();
        folder.bad(&arguments, &[message]);
    }
    let grinder = sample("grinder");
    let arguments = ["tables", "accuracy", measured, "--instrument", grinder.to_str().unwrap()];
    folder.bad(&arguments, &["found no uncertainty of the instrument"]);
}
