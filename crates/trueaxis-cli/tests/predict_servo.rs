//! `trueaxis predict-servo` as called.

use std::path::Path;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");
/// A line and back, so that X reverses.
const PROGRAM: &str = "G21 G90 F2000\nG1 X5 Y3\nG1 X0 Y0\nM2\n";

fn machine() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis").display().to_string()
}

#[test]
fn the_document_the_table_and_the_page_state_the_same_bound() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("part.ngc", PROGRAM);
    let machine = machine();
    let call = ["predict-servo", "part.ngc", &machine, "--rate-hz", "1000", "--plants", "8", "--feed-for", "50"];
    let document = folder.json(&[&call[..], &["--json", "--report", "page"]].concat());
    assert_eq!(document["program"], "part");
    assert_eq!(document["family"]["friction"], 0.5);
    assert_eq!(document["drawn"]["plants"], 8);
    let lines = document["lines"].as_array().unwrap();
    assert_eq!(lines.iter().map(|line| line["line"].as_u64().unwrap()).collect::<Vec<_>>(), [2, 3]);
    for line in lines {
        let um = |key: &str| line[key].as_f64().unwrap();
        assert!(um("stated_um") < um("bound_um") && um("drawn_um") < um("bound_um"), "{line}");
        // 50 µm need no other feed.
        assert_eq!(line["feed_for"]["feed_per_min"], 2000.0);
    }
    let bound = trueaxis_report::number::significant(document["bound_um"].as_f64().unwrap(), 3);
    let text = folder.good(&call);
    for shown in [text, folder.read("page/predict-servo.html")] {
        assert!(shown.contains(&format!("bound {bound} µm")) && shown.contains("friction ±50 %"), "{shown}");
    }
}

#[test]
fn what_cannot_be_is_refused_with_its_option() {
    let folder = Folder::new(TRUEAXIS);
    folder.write("part.ngc", PROGRAM);
    folder.write("bad.ngc", "G21 G90\nG1 X5\n");
    let machine = machine();
    let refusals: [(&str, &[&str], &str); 6] = [
        ("part.ngc", &["--gains", "95"], "--gains: found 95 %, needed 0 to 90 %"),
        ("part.ngc", &["--resonance-hz", "5"], "--resonance-hz: found 5 Hz, needed 10 to 2000 Hz"),
        ("part.ngc", &["--resonance-hz", "900"], "resonance_hz"),
        ("part.ngc", &["--feed-for", "0"], "--feed-for: found 0 µm, needed a bound above 0 µm"),
        ("part.ngc", &["--gains", "0", "--friction", "0", "--presliding", "0"], "needed a figure that varies"),
        ("bad.ngc", &[], "bad.ngc:2"),
    ];
    for (program, options, needed) in refusals {
        let call = [&["predict-servo", program, &machine, "--rate-hz", "1000"], options].concat();
        folder.bad(&call, &[needed]);
    }
}
