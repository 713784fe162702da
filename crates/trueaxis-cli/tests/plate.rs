//! `trueaxis calibrate` with a plate of unknown places: the sample rehearsed, and what is refused.

use std::path::Path;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");
const PLATE: &str = include_str!("../../../records/probing/plate.toml");

fn folder(task: &str) -> Folder {
    let folder = Folder::new(TRUEAXIS);
    let records = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../records/probing");
    for machine in ["mill", "true"] {
        folder.copy(&records.join(machine), machine);
    }
    folder.write("task.toml", task);
    folder
}

/// Line of the task that begins with a text, from 1.
fn line(task: &str, text: &str) -> usize {
    task.lines().position(|line| line.starts_with(text)).unwrap_or_else(|| panic!("{text}")) + 1
}

#[test]
fn the_sample_is_rehearsed_and_written() {
    let folder = folder(PLATE);
    let program = folder.good(&["calibrate", "plan", "task.toml"]);
    let pauses: Vec<&str> = program.lines().filter(|line| line.starts_with("(MSG,set up plate")).collect();
    assert_eq!(pauses.len(), 4, "{program}");
    assert!(pauses[0].contains("its marked face towards Z, its marked hole 1-1 at X75 Y25"), "{pauses:?}");
    assert!(pauses[0].contains("hole 5-1 at X355 Y25"), "{pauses:?}");
    // Turned to the left about its middle, the first hole is at the lower right.
    assert!(pauses[1].contains("turned counter-clockwise by 90 degrees"), "{pauses:?}");
    assert!(pauses[1].contains("hole 1-1 at X355 Y25") && pauses[1].contains("hole 5-1 at X355 Y305"), "{pauses:?}");
    assert!(pauses[2].contains("its middle at X285 Y165"), "{pauses:?}");
    folder.good(&["calibrate", "simulate", "task.toml", "--machine", "true", "-o", "probe.log"]);
    let found = folder.json(&["calibrate", "solve", "task.toml", "probe.log", "-o", "found", "--json"]);
    let term = |name: &str| {
        let all = found["terms"].as_array().unwrap();
        let term = all.iter().find(|term| term["name"] == name).unwrap_or_else(|| panic!("{name}: {found}"));
        (term["value"].as_f64().unwrap(), term["standard_error"].as_f64().unwrap())
    };
    // As records/probing/true states them.
    for (name, truth) in [("squareness C0Y", 50.0), ("scale of X", 40.0), ("scale of Y", -30.0), ("backlash of X", 6.0)]
    {
        let (value, error) = term(name);
        assert!((value - truth).abs() < 3.5 * error && error < 8.0, "{name}: {value} ± {error}");
    }
    // Lost motion is seen on the ball and cancels on the plate: nothing of it is left in the scatter of 1 µm.
    assert!((0.85..1.15).contains(&found["sigma_um"].as_f64().unwrap()), "{}", found["sigma_um"]);
    assert_eq!(found["touches"], 400 + 29 + 5 * 18, "{found}");
    assert_eq!(found["artefacts"].as_array().unwrap().len(), 1 + 2 * 23, "{found}");
    assert!(folder.read("found/machine.toml").contains("C0Y_urad = "));
    // A hole that nobody touched.
    let log = folder.read("probe.log");
    let missing: String =
        log.lines().filter(|line| !line.contains("touch 60 ")).map(|line| format!("{line}\n")).collect();
    folder.write("probe.log", missing);
    let solve = ["calibrate", "solve", "task.toml", "probe.log", "-o", "found"];
    folder.bad(&solve, &["probe.log:", "no touch 60", "touch 60 after this line"]);
}

#[test]
fn an_upright_plate_names_its_stylus() {
    let flat = PLATE.replace("pitch_mm = 70.0", "pitch_mm = 50.0").replace("395.98", "282.84");
    let upright = ["", "turn_deg = 90\n", "moved = [0, 1]\n"]
        .map(|how| format!("[[plate.placement]]\nnormal = \"Y\"\nat_mm = [215.0, 200.0, -150.0]\n{how}"));
    let folder = folder(&(flat + &upright.concat()));
    let program = folder.good(&["calibrate", "plan", "task.toml"]);
    let pauses: Vec<&str> = program.lines().filter(|line| line.starts_with("(MSG,set up plate")).collect();
    let needs = |text: &str| text.contains("needs a stylus that points along Y");
    assert_eq!(
        pauses.iter().map(|pause| needs(pause)).collect::<Vec<_>>(),
        [false, false, false, false, true, true, true]
    );
    let found = folder.json(&["calibrate", "plan", "task.toml", "-o", "probe.ngc", "--json"]);
    let warnings = found["warnings"].as_array().unwrap();
    assert!(warnings.len() == 3 && warnings.iter().all(|of| needs(of.as_str().unwrap())), "{warnings:?}");
}

#[test]
fn bad_plates_are_refused_with_their_line() {
    let folder = folder(PLATE);
    let refused = |task: &str, parts: &[&str]| {
        folder.write("task.toml", task);
        folder.bad(&["calibrate", "plan", "task.toml", "-o", "probe.ngc"], parts);
    };
    let at = |task: &str, text: &str, key: &str| format!("task.toml:{}: key {key}", line(task, text));
    let name = "name = \"plate\"";
    // One placement only, with the null vectors named.
    let once = &PLATE[..PLATE.find("[[plate.placement]]\nturn_deg = 90").unwrap()];
    let said = [
        &at(once, name, "plate.placement")[..],
        "a plate in 1 placement: rank ",
        "squareness C0Y",
        "EYX",
        "EXY",
        "EYY",
        "without the turned placement squareness and the ratio of the scales cannot be told from the plate's own skew",
        "without a moved placement",
        "needed a [[plate.placement]] with turn_deg = 90; and a [[plate.placement]] with moved = [1, 0] or moved = [0, 1]\n",
    ];
    refused(once, &said);
    let (before, after) = (PLATE.find("[plate.length]").unwrap(), PLATE.find("[[plate.placement]]").unwrap());
    let loose = format!("{}{}", &PLATE[..before], &PLATE[after..]);
    let said = [
        &at(&loose, name, "plate.placement")[..],
        "these stay free: scale of X, scale of Y; without a known length one scale stays free",
        "needed [plate.length] between two of its holes\n",
    ];
    refused(&loose, &said);
    let changed = |from: &str, to: &str| {
        assert!(PLATE.contains(from), "{from}");
        PLATE.replacen(from, to, 1)
    };
    let far = changed("[215.0, 165.0", "[285.0, 165.0");
    refused(&far, &[&at(&far, "moved = [1", "plate.placement"), "a touch with X at", "within its travel 0 to 500 mm"]);
    let odd = changed("rows = 5", "rows = 4").replace("to = [5, 5]", "to = [5, 4]").replace("395.98", "350");
    let said =
        ["key plate.placement.turn_deg", "turned by 90 degrees", "on the lines of the placements before: 0.5 pitches"];
    refused(&odd, &[&[&at(&odd, "turn_deg = 90", "")[..12]][..], &said].concat());
    let oblique = changed("turn_deg = 90", "turn_deg = 45");
    refused(&oblique, &[&at(&oblique, "turn_deg = 45", "plate.placement.turn_deg"), "0, 90, 180 or 270"]);
    // Two digits exchanged: 2,300 ppm of scale.
    let long = changed("mm = 395.98", "mm = 395.08");
    let said = [&at(&long, "mm = 395.08", "plate.length.mm")[..], "395.08", "395.980 mm, by its pitch, within 600 um"];
    refused(&long, &said);
    let beside = changed("to = [5, 5]", "to = [6, 5]");
    refused(&beside, &[&at(&beside, "to = [6", "plate.length.to"), "column 1 to 5 and row 1 to 5"]);
    let narrow = changed("diameter_mm = 20.0", "diameter_mm = 8.0");
    refused(&narrow, &[&at(&narrow, name, "plate.diameter_mm"), "too little room in a hole", "approach_mm (3)"]);
    let short = changed("repeats = 1", "repeats = 1\novertravel_mm = 1.4");
    refused(&short, &[&at(&short, name, "probe.overtravel_mm"), "1.4 mm", "at least 1.5 mm"]);
    // 1.5 mm beside the middle of a ball, of 3.5 + 2 mm.
    let small = changed("\"holes\"", "\"balls\"").replace("diameter_mm = 20.0", "diameter_mm = 7.0");
    refused(&small, &[&at(&small, name, "plate.diameter_mm"), "1.5 mm", "at most 1.375 mm", "approach_mm"]);
    let low = changed("repeats = 1", "repeats = 1\nsafe_z_mm = -170.0");
    refused(&low, &["task.toml:", "at Z -1", "above safe_z_mm (-170)", "safe_z_mm of at least -1"]);
    let alone =
        format!("{}{}", &PLATE[..PLATE.find("[reference]").unwrap()], &PLATE[PLATE.find("[[plate]]").unwrap()..]);
    let lost = format!("{alone}[solve]\nbacklash = true\n");
    refused(&lost, &[&at(&lost, "backlash", "solve.backlash"), "lost motion cancels"]);
    let second = format!("{PLATE}[[plate]]\nname = \"other\"\n");
    refused(&second, &[&at(&second, "name = \"other\"", "plate"), "one plate"]);
    let ring =
        changed("kind = \"ball\"", "kind = \"ring\"").replace("[reference]\nartefact = \"ball\"\nevery = 40\n", "");
    refused(&ring, &["key artefact.kind", "only balls beside a plate of unknown places"]);
    let kind = changed("\"holes\"", "\"pins\"");
    refused(&kind, &[&at(&kind, "kind = \"pins\"", "plate.kind"), "balls"]);
    let many = changed("columns = 5", "columns = 20").replace("rows = 5", "rows = 20");
    let said = [&at(&many, name, "plate.placement")[..], "20 x 20 holes in 4 placements: 1600 centres", "at most 1000"];
    refused(&many, &said);
    assert!(!folder.has("probe.ngc"));
}
