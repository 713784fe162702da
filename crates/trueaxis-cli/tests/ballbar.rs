//! `trueaxis ballbar` as it is called; the circle is run by positions, not radii.

use std::fmt::Write;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

/// 100 mm: C0Y 50 µrad, lost motion of 5 µm in X, the pivot 20 µm off.
fn record(directions: &[f64]) -> String {
    let mut text = String::from("angle_deg,deviation_um,direction\n");
    for d in directions {
        for k in 0..360 {
            let (sin, cos) = (f64::from(k) + 0.5).to_radians().sin_cos();
            let (x, y) = (100.0 * cos, 100.0 * sin);
            let x = x - 50e-6 * y + 0.0025 * (d * sin).signum() + 0.02;
            writeln!(text, "{},{},{d}", f64::from(k) + 0.5, 1e3 * (x.hypot(y) - 100.0)).unwrap();
        }
    }
    text
}

#[test]
fn causes_are_found() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("record.csv", record(&[1.0, -1.0]));
    let found = folder.json(&["ballbar", "record.csv", "--radius-mm", "100", "--json", "--report", "out"]);
    let near = |found: &serde_json::Value, truth: f64, tolerance: f64| {
        assert!((found.as_f64().unwrap() - truth).abs() < tolerance, "{found} for {truth}");
    };
    near(&found["squareness_urad"], 50.0, 0.05);
    near(&found["backlash_um"]["x"], 5.0, 0.01);
    near(&found["backlash_um"]["y"], 0.0, 0.01);
    near(&found["centre_um"][0], 20.0, 0.01);
    near(&found["h_um"], 5.0, 0.02);
    assert!(found["standard_errors"]["squareness_urad"].as_f64().unwrap() < 0.1);
    assert_eq!(found["shares"][0]["cause"], "squareness");
    let page = std::fs::read_to_string(folder.join("out/ballbar.html")).unwrap();
    assert!(page.contains("Circular test") && page.contains("squareness C0Y"));
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    let folder = Folder::new(TRUEAXIS);
    let good = record(&[1.0]);
    folder.write("still.csv", good.replacen("2.5,", "2.5,0,0\n3.5,", 1).replace("0,0\n3.5,", "0,0\n#"));
    folder.write("part.csv", good.lines().take(200).fold(String::new(), |text, line| text + line + "\n"));
    for (file, told) in [
        ("still.csv", "still.csv:4: column direction: found 0, needed 1 counterclockwise or -1 clockwise"),
        ("part.csv", "part.csv: found no counterclockwise reading over 162.0° from 198.5° on"),
    ] {
        let refused = folder.run(&["ballbar", file, "--radius-mm", "100"]);
        let error = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(2) && error.contains(told), "{error}");
    }
}
