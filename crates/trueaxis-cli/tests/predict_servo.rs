//! `trueaxis predict-servo` as called.

use serde_json::Value;
use std::path::Path;
use trueaxis_testing::command::Folder;
use trueaxis_testing::share::share;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");
/// A line and back, so that X reverses.
const PROGRAM: &str = "G21 G90 F2000\nG1 X5 Y3\nG1 X0 Y0\nM2\n";
/// A circle, an oblique line, a sharp corner at twice the feed, a half circle and a line into the depth.
const TOUR: &str = "G21 G90 G17\nF3000\nG0 X20 Y0\nG3 X20 Y0 I-20 J0\nG1 X40 Y15\nG1 X30 Y-10 F6000\nG2 X50 Y-10 I10 J0\n\
                    G1 X0 Y0 Z-5\nM2\n";
/// A shallow arc at a low feed, on which only Y reverses.
const ARC: &str = "G21 G90 G17\nF800\nG0 X-10 Y0\nG2 X10 Y0 I10 J-30\nM2\n";

/// The document of a program at 1 kHz.
fn predicted(program: &str, options: &[&str]) -> Value {
    let folder = Folder::new(TRUEAXIS);
    folder.write("part.ngc", program);
    let machine = machine();
    folder.json(&[&["predict-servo", "part.ngc", &machine, "--rate-hz", "1000", "--json"], options].concat())
}

fn number(of: &Value, key: &str) -> f64 {
    of[key].as_f64().unwrap_or_else(|| panic!("{key}: {of}"))
}

/// 1,000 plants with `TRUEAXIS_TEST_SHARE=1`, otherwise 100, whose worst is up to a third below that of 1,000.
#[test]
fn no_drawn_plant_exceeds_the_bound_of_a_line_and_none_is_far_below() {
    let plants = share(1000);
    let most = if plants >= 1000 { 1.5 } else { 2.0 };
    for (program, family) in [(TOUR, &[][..]), (ARC, &[]), (ARC, &["--resonance-hz", "90"])] {
        let found = predicted(program, &[&["--plants", &plants.to_string()], family].concat());
        for line in found["lines"].as_array().unwrap() {
            let ratio = number(line, "bound_um") / number(line, "drawn_um");
            assert!((1.0..most).contains(&ratio), "{family:?}, {ratio}: {line}");
            assert!(number(line, "stated_um") < number(line, "bound_um"), "{line}");
        }
        let (bound, worst) = (number(&found, "bound_um"), number(&found["drawn"], "worst_um"));
        assert!(worst <= bound && bound < most * worst, "{family:?}: {worst} {bound}");
    }
}

#[test]
fn a_narrower_family_has_a_smaller_bound() {
    let [narrow, wide] = ["10", "50"].map(|friction| predicted(ARC, &["--friction", friction]));
    assert!(number(&narrow, "bound_um") < 0.7 * number(&wide, "bound_um"), "{narrow} {wide}");
    assert_eq!(narrow["stated_um"], wide["stated_um"]);
}

#[test]
fn the_feeds_found_keep_the_wanted_bound() {
    let found = predicted(TOUR, &["--feed-for", "2.6"]);
    let mut program: Vec<String> = TOUR.lines().map(str::to_owned).collect();
    let (mut slowed, lines) = (0, found["lines"].as_array().unwrap());
    for line in lines {
        let feed = number(&line["feed_for"], "feed_per_min");
        slowed += usize::from(feed < number(line, "feed_per_min"));
        let text = &mut program[line["line"].as_u64().unwrap() as usize - 1];
        *text = format!("{} F{feed}", text.split(" F").next().unwrap());
    }
    assert!(slowed > 0 && slowed < lines.len(), "{slowed} lines");
    let again = number(&predicted(&program.join("\n"), &[]), "bound_um");
    assert!(again <= 2.6, "{again}");
}

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
