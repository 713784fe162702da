//! `trueaxis calibrate` with blocks and with a dial indicator, whose readings the tests compute by hand.

use std::path::Path;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

const HEAD: &str = "machine = \"mill\"\n[indicator]\nrepeatability_um = 1.0\n";

const CYLINDER: &str = "[[dial]]\nname = \"cylinder\"\nkind = \"squareness\"\nalong = \"X\"\nacross = \"Z\"\n\
                        at_mm = [150.0, 200.0, -280.0]\narms_mm = [200.0, 200.0]\n";
const EDGE: &str = "[[dial]]\nname = \"edge\"\nkind = \"straightness\"\nmoves = \"X\"\nreads = \"Y\"\n\
                    at_mm = [50.0, 200.0, -200.0]\nlength_mm = 400.0\npoints = 5\n";
const TRAM: &str = "[[dial]]\nname = \"tram\"\nkind = \"tram\"\nat_mm = [250.0, 200.0, -250.0]\nradius_mm = 100.0\n\
                    sweep_mm = [300.0, 250.0]\n";
const BAR: &str = "[[dial]]\nname = \"bar\"\nkind = \"test bar\"\nat_mm = [250.0, 200.0, -250.0]\nlength_mm = 200.0\n\
                   points = 3\nuncertainty_urad = 0.01\n";

fn folder(task: &str) -> Folder {
    let folder = Folder::new(TRUEAXIS);
    folder.copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../records/probing/mill"), "mill");
    folder.write("task.toml", task);
    folder
}

/// A row of a sheet: its number, X, Y, Z of the machine, angle of the spindle.
type Row = [f64; 5];

/// Plans a sheet and fills it with the readings, µm, of every row.
fn filled(folder: &Folder, reading_um: impl Fn(Row) -> f64) -> String {
    let sheet = folder.good(&["calibrate", "plan", "task.toml"]);
    let fill = |line: &str| match line.strip_suffix(',').filter(|_| !line.starts_with('#')) {
        Some(row) => {
            let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
            format!("{row},{:.3}\n", reading_um(cells.try_into().unwrap()))
        }
        None => format!("{line}\n"),
    };
    sheet.lines().map(fill).collect()
}

fn solve(folder: &Folder, sheet: &str) -> serde_json::Value {
    folder.write("sheet.csv", sheet);
    folder.json(&["calibrate", "solve", "task.toml", "sheet.csv", "--dry-run", "--json"])
}

fn term(found: &serde_json::Value, name: &str) -> f64 {
    let all = found["terms"].as_array().unwrap();
    all.iter().find(|term| term["name"] == name).unwrap_or_else(|| panic!("{found}"))["value"].as_f64().unwrap()
}

fn near(found: f64, truth: f64) {
    assert!((found - truth).abs() < 0.02, "{found} for {truth}");
}

/// Z leans by B0Z = −20 µrad: X is further by B0Z Z. The cylinder leans by 50 µrad, turned by −50. A dial on its −X side is
/// pushed in by (B0Z − 50e-6) Z, on its +X side by (50e-6 − B0Z) Z with the lean turned: −(B0Z + 50e-6) Z. The table, read
/// from above, is parallel to X.
#[test]
fn a_cylinder_turned_by_180_degrees_gives_its_lean_away() {
    let folder = folder(&format!("{HEAD}{CYLINDER}"));
    let sheet = filled(&folder, |[id, _, _, z, _]| {
        let lean = |urad: f64| 1e-3 * urad * (z + 280.0);
        match id {
            7.0..13.0 => lean(-20.0 - 50.0),
            19.0.. => lean(20.0 - 50.0),
            _ => 0.0,
        }
    });
    let found = solve(&folder, &sheet);
    near(found["location"]["B0Z_urad"].as_f64().unwrap(), -20.0);
    let cylinder = &found["artefacts"][0];
    // It leans towards the first arm.
    near(1e6 * (cylinder["found"].as_f64().unwrap() - 90.0).to_radians(), -50.0);
    folder.both(&["calibrate", "solve", "task.toml", "sheet.csv", "-o", "found"]);
    assert!(folder.read("found/machine.toml").contains("B0Z_urad = -20"));
    // On the other side the axis is where the cylinder has its other side.
    let moved = sheet.lines().map(|line| {
        let far = line.split(',').next().and_then(|id| id.parse().ok()).is_some_and(|id: f64| id >= 19.0);
        format!("{}\n", if far { line.replace(",150,", ",201.37,") } else { line.to_owned() })
    });
    let moved = solve(&folder, &moved.collect::<String>());
    near(moved["location"]["B0Z_urad"].as_f64().unwrap(), -20.0);
}

/// A cylinder that leans by 5 mrad, read on both its sides; its name has a line break. One reading is 0.4 mm off its place:
/// there the dial reads 2 µm more.
#[test]
fn a_typed_position_is_that_of_its_reading() {
    let folder = folder(&format!("{HEAD}{}", CYLINDER.replace("\"cylinder\"", "\"cylinder\\nof steel\"")));
    let sheet = filled(&folder, |[id, _, _, z, _]| {
        let z = if id == 8.0 { z + 0.4 } else { z };
        if (7.0..13.0).contains(&id) || id >= 19.0 { -5.0 * (z + 280.0) } else { 0.0 }
    });
    assert!(sheet.contains("# from 1 on: cylinder\\nof steel: along X"), "{sheet}");
    let sheet = sheet.replace("\n8,150,200,-240,", "\n8,150,200,-239.6,");
    assert!(sheet.contains("-239.6,0,-202.000"), "{sheet}");
    let found = solve(&folder, &sheet);
    near(term(&found, "squareness B0Z"), 0.0);
}

/// The carriage bows by y = 8 µm (1 − t²), t from −1 to 1; the face by 5 µm at its middle. On the +Y side a reading is the
/// face less the carriage, turned over on the −Y side the carriage plus the face.
#[test]
fn an_edge_turned_over_gives_its_form_away() {
    let folder = folder(&format!("{HEAD}{EDGE}[solve]\nstraightness_degree = 2\n"));
    let sheet = filled(&folder, |[id, x, ..]| {
        let t = (x - 250.0) / 200.0;
        let (carriage, form) = (8.0 * (1.0 - t * t), if x == 250.0 { 5.0 } else { 0.0 });
        if id <= 5.0 { form - carriage } else { form + carriage }
    });
    let found = solve(&folder, &sheet);
    // −8 t² = −16/3 P₂ − 8/3.
    near(term(&found, "EYX of degree 2"), -16.0 / 3.0);
    // A form beyond the tolerance: it is not the face of the task.
    let bent = filled(&folder, |[_, x, ..]| if x == 250.0 { 300.0 } else { 0.0 });
    folder.write("sheet.csv", bent);
    let bad = ["calibrate", "solve", "task.toml", "sheet.csv", "--dry-run"];
    folder.bad(&bad, &["task.toml:5:", "form 3 of edge 300.0 µm from a straight line", "150 µm (tolerance_um)"]);
}

/// The table rises by 100 µrad along X, ten times what is stated.
#[test]
fn a_slope_of_the_table_is_compared_in_urad() {
    let folder = folder(&format!("{HEAD}{TRAM}uncertainty_urad = 10.0\n"));
    let sheet = filled(&folder, |[_, x, _, _, spindle_deg]| 0.1 * (x - 250.0 + 100.0 * spindle_deg.to_radians().cos()));
    let found = solve(&folder, &sheet);
    let warnings = found["warnings"].to_string();
    assert!(warnings.contains("slope of the table along X of tram, placement 1 differs by "), "{found}");
    assert!(warnings.contains(" µrad from the stated value, whose uncertainty is 10.0 µrad"), "{found}");
}

/// The spindle is tilted by 100 µrad about Y: at +X it is lower by 10 µm on a radius of 100 mm, which pushes the dial in. Along
/// the bar the dial is pushed in by 120 µrad times the way down of Z: the carriage leans by B0Z = −20 µrad. The bar runs out by
/// 15 µm and 30 µrad, the other way at 180°.
#[test]
fn a_bar_turned_by_180_degrees_gives_its_run_out_away() {
    let folder = folder(&format!("{HEAD}{TRAM}{BAR}"));
    let sheet = filled(&folder, |[id, _, _, z, spindle_deg]| {
        let turned = spindle_deg.to_radians().cos();
        let down = -50.0 - z;
        match id {
            1.0..9.0 => 10.0 * turned,
            // The dial stays at +X while the table is read.
            9.0..13.0 => 10.0,
            13.0..19.0 => 0.12 * down + turned * (15.0 + 0.03 * down),
            _ => turned * (-4.0 + 0.01 * down),
        }
    });
    let found = solve(&folder, &sheet);
    near(term(&found, "tilt of the spindle about Y"), 100.0);
    near(term(&found, "tilt of the spindle about X"), 0.0);
    near(found["location"]["B0Z_urad"].as_f64().unwrap(), -20.0);
    near(found["location"]["A0Z_urad"].as_f64().unwrap(), 0.0);
    // Without the second readings the run-out cannot be told from the tilt.
    folder.write("task.toml", format!("{HEAD}{TRAM}{BAR}angles_deg = [0]\n"));
    folder.bad(
        &["calibrate", "plan", "task.toml"],
        &["task.toml:17: key dial.angles_deg", "[0, 180]", "run-out cancels"],
    );
}

#[test]
fn bad_sheets_are_refused_with_their_line() {
    let folder = folder(&format!("{HEAD}{CYLINDER}"));
    let sheet = filled(&folder, |_| 0.0);
    let first = sheet.lines().position(|line| line.starts_with("1,")).unwrap() + 1;
    let refused = |text: String, parts: &[&str]| {
        folder.write("sheet.csv", text);
        folder.bad(&["calibrate", "solve", "task.toml", "sheet.csv", "-o", "found"], parts);
    };
    let at = |id: usize| format!("sheet.csv:{}:", first + id - 1);
    let row = |id: usize| sheet.lines().nth(first + id - 2).unwrap();
    let changed = |id: usize, to: &str| sheet.replace(row(id), to);
    let blank = format!("{},", row(8).rsplit_once(',').unwrap().0);
    refused(changed(8, &blank), &[&at(8), "column reading_um", "an empty cell", "needed reading 8"]);
    refused(sheet.replace(&format!("{}\n", row(8)), ""), &[&at(7), "no reading 8", "all 24 readings"]);
    refused(changed(8, &format!("{}\n{}", row(8), row(8))), &[&at(9), "8 for the second time"]);
    refused(changed(8, &row(8).replace(",0.000", ",in")), &[&at(8), "column reading_um", "\"in\""]);
    refused(changed(8, &row(8).replace(",0.000", ",40000")), &[&at(8), "40 mm", "at most 30 mm"]);
    refused(changed(8, &row(8).replace(",-240,", ",-200,")), &[&at(8), "column z_mm", "-200", "-240, as planned"]);
    refused(changed(8, &row(8).replace(",150,", ",640,")), &[&at(8), "column x_mm", "X at 640", "its travel 0 to 500"]);
    refused(changed(8, &row(8).replace("8,", "88,")), &[&at(8), "column id", "88", "1 to 24"]);
    refused(sheet.replace("reading_um", "reading"), &["sheet.csv", "reading", "reading_um"]);
    let head = at(0);
    refused(sheet.replace("0.000\n", "0.000,0\n").replace("_um\n", "_um,reading_mm\n"), &[&head, "one of"]);
    refused(sheet.replace(&format!("{}\n", row(1)), ""), &[&head, "no reading 1", "all 24 readings"]);
    refused(changed(8, &row(8).replace(",0.000", ",95")), &[&at(8), "reading 8 on cylinder", "off the position"]);
    // The sheet of another set-up: the same positions of the machine, with the spindle elsewhere.
    folder.write("task.toml", format!("{HEAD}{}", CYLINDER.replace("-280", "-270")));
    refused(sheet, &["sheet.csv:1:", "the sheet of plan", "task.toml plans"]);
    assert!(!folder.has("found"));
}

#[test]
fn bad_set_ups_of_a_dial_are_refused_with_their_line() {
    let folder = folder("");
    let refused = |task: String, parts: &[&str]| {
        folder.write("task.toml", task);
        folder.bad(&["calibrate", "plan", "task.toml", "-o", "sheet.csv"], parts);
    };
    let cylinder = |from: &str, to: &str| format!("{HEAD}{}", CYLINDER.replace(from, to));
    let edge = |from: &str, to: &str| format!("{HEAD}{}", EDGE.replace(from, to));
    refused(cylinder("across = \"Z\"\n", ""), &["task.toml:5: key dial.across", "the axis along its second arm"]);
    refused(cylinder("\"Z\"", "\"X\""), &["task.toml:7: key dial.along", "another axis across"]);
    refused(cylinder("\"Z\"", "\"C\""), &["task.toml:8: key dial.across", "\"X\", \"Y\" or \"Z\""]);
    refused(cylinder("arms_mm", "arm_mm"), &["task.toml:10: key dial.arm_mm", "needed arms_mm"]);
    refused(cylinder("across", "form_um = 3\nacross"), &["task.toml:8: key dial.form_um"]);
    refused(cylinder("200.0, 200.0]", "200.0, 0.0]"), &["task.toml:10: key dial.arms_mm", "10 to 5000 mm"]);
    refused(cylinder("-280", "-80"), &["task.toml:5: key dial", "a reading with Z at", "its travel -300 to 0 mm"]);
    let once = format!("{HEAD}{CYLINDER}placements = 1\n");
    refused(once, &["task.toml:5: key dial.uncertainty_urad", "turned over, or its uncertainty (uncertainty_urad)"]);
    refused(edge("reads = \"Y\"\n", ""), &["task.toml:5: key dial.reads", "the axis along which the dial reads"]);
    refused(edge("\"Y\"", "\"X\""), &["task.toml:8: key dial.reads", "another axis than moves"]);
    refused(edge("\"Y\"", "\"Z\""), &["task.toml:8: key dial.reads", "placements = 1 and uncertainty_um"]);
    refused(edge("points = 5", "points = 3"), &["task.toml:5: key dial.points", "found 3, needed at least 4"]);
    let loose = format!("{HEAD}{CYLINDER}tolerance_um = 100.0\n");
    refused(loose, &["task.toml:11: key dial.tolerance_um", "largest form of a face"]);
    for key in ["scale", "backlash"] {
        let more = format!("{HEAD}{CYLINDER}[solve]\n{key} = true\n");
        refused(more, &[&format!("task.toml:12: key solve.{key}"), "needed false: no reading of a dial shows it"]);
    }
    refused(edge("straightness", "flatness"), &["task.toml:6: key dial.kind", "\"test bar\""]);
    let tram = TRAM.replace("sweep_mm = [300.0, 250.0]\n", "");
    refused(format!("{HEAD}{tram}"), &["task.toml:5: key dial.sweep_mm", "uncertainty_urad of its parallelism"]);
    let bar = BAR.replace("uncertainty_urad = 0.01\n", "");
    refused(format!("{HEAD}{bar}"), &["task.toml:5: key dial.uncertainty_urad", "taper"]);
    refused(format!("machine = \"mill\"\n{EDGE}"), &["task.toml", "indicator.repeatability_um"]);
    let both = format!("{HEAD}{EDGE}[[artefact]]\nname = \"ball\"\n");
    refused(both, &["task.toml:13:", "an artefact beside a dial", "in two tasks"]);
    refused(format!("{HEAD}[probe]\ntip_radius_mm = 2.0\n{EDGE}"), &["task.toml:4:", "probe"]);
    assert!(!folder.has("sheet.csv"));
}

#[test]
fn bad_blocks_are_refused_with_their_line() {
    const BLOCK: &str = "machine = \"mill\"\ndialect = \"linuxcnc\"\n[probe]\ntip_radius_mm = 2.0\ntip_uncertainty_um = 1.0\n\
                         [[artefact]]\nname = \"block\"\nkind = \"gauge block\"\nlength_mm = 100.0\n\
                         section_mm = [35.0, 9.0]\nuncertainty_um = 0.12\n\
                         [[artefact.place]]\nat_mm = [250.0, 200.0, -150.0]\n";
    let folder = folder("");
    let refused = |from: &str, to: &str, parts: &[&str]| {
        folder.write("task.toml", BLOCK.replace(from, to));
        folder.bad(&["calibrate", "plan", "task.toml", "-o", "probe.ngc"], parts);
    };
    refused("length_mm = 100.0\n", "", &["task.toml:7: key artefact.length_mm", "the distance of its faces"]);
    refused("100.0", "0.0", &["task.toml:9: key artefact.length_mm", "0.5 to 5000 mm"]);
    refused("section_mm = [35.0, 9.0]\n", "", &["task.toml:7: key artefact.section_mm", "two sides of its faces"]);
    refused("35.0, 9.0", "35.0, 0.0", &["task.toml:10: key artefact.section_mm", "0.5 to 5000 mm each"]);
    let none = ["task.toml:7: key artefact.uncertainty_um", "or unknown_length = true"];
    refused("uncertainty_um = 0.12\n", "", &none);
    let unknown = ["task.toml:7: found a set-up that cannot separate", "length of block"];
    refused("uncertainty_um = 0.12\n", "unknown_length = true\n", &unknown);
    let both = ["task.toml:12: key artefact.uncertainty_um", "either unknown_length or uncertainty_um"];
    refused("uncertainty_um = 0.12", "unknown_length = true\nuncertainty_um = 0.12", &both);
    refused("section_mm", "points = 3\nsection_mm", &["task.toml:10: key artefact.points"]);
    refused("-150.0]\n", "-150.0]\nacross = \"X\"\n", &["task.toml:14: key artefact.place.across", "than along"]);
    refused("-150.0]\n", "-150.0]\nalong = \"Z\"\n", &["task.toml:13: key artefact.place.base", "base = true"]);
    refused("35.0, 9.0", "35.0, 4.0", &["task.toml:13: key artefact.place.normal", "too low beside a tip of 2 mm"]);
    let low = ["task.toml:13: key artefact.place.normal", "1.5 mm (half of approach_mm) off its place"];
    refused("35.0, 9.0", "35.0, 7.0", &low);
    refused("-150.0]", "-10.0]", &["task.toml:13: key artefact.place", "above safe_z_mm (0)", "or a lower place"]);
    let same = "same_as = \"parallel\"\n";
    refused("section_mm", &format!("{same}section_mm"), &["task.toml:10: key artefact.same_as", "above it"]);
    let second = BLOCK[BLOCK.find("[[artefact]]").unwrap()..].replace("\"block\"", "\"second\"");
    let two = |length: &str, more: &str| {
        let second = second.replace("uncertainty_um = 0.12", more).replace("100.0", length);
        folder.write("task.toml", format!("{BLOCK}{second}"));
    };
    let plan = ["calibrate", "plan", "task.toml", "-o", "probe.ngc"];
    two("100.0", "same_as = \"block\"");
    folder.bad(&plan, &["task.toml:15: key artefact.difference_um", "uncertainty of the difference"]);
    two("90.0", "same_as = \"block\"\ndifference_um = 1.0");
    folder.bad(&plan, &["task.toml:19: key artefact.same_as", "[90.0] mm", "[100.0] mm, as block"]);
    assert!(!folder.has("probe.ngc"));
}
