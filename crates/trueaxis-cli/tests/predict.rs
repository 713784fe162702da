//! `trueaxis predict` as called.

use serde_json::Value;
use std::path::Path;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

/// Two holes 60 mm and 80 mm apart, reached in positive and in negative X; lines of the program from 1.
const PROGRAM: &str = "G21 G90 G17 G94 F200\nG0 X0 Y0 Z10\nG0 X20\nG81 X40 Y20 Z-5 R2\nG80\nG0 X180\nG0 Y100\n\
                       G81 X100 Y100 Z-5 R2\nG80\nM2\n";
const PART: &str = "name = \"two\"\nprogram = \"two.ngc\"\nat_mm = [0, 0, -50]\n\
                    [[feature]]\nname = \"one\"\nkind = \"hole\"\nlines = [4, 4]\n\
                    [[feature]]\nname = \"two\"\nkind = \"hole\"\nlines = [8, 8]\n\
                    [[tolerance]]\nfeature = \"two\"\nkind = \"distance\"\nfrom = \"one\"\nlimits_um = [-0.24, 0.24]\n";

/// X, Y 0 to 200 mm, Z −100 to 0 mm, without tables.
fn write(folder: &Folder, stated: &str, program: &str, part: &str) {
    folder.write(
        "machine.toml",
        format!(
            "name = \"small\"\nchain = \"w X' Y' b Z t\"\n[axis.X]\ntable = \"x.csv\"\ntravel_mm = [0, 200]\n\
             hysteresis_um = 0.1\n{stated}"
        ),
    );
    folder.write("x.csv", "X_mm,EXX_um\n0,0\n200,0\n");
    folder.write("two.ngc", program);
    folder.write("part.toml", part);
}

const OTHERS: &str = "[axis.Y]\ntravel_mm = [0, 200]\nhysteresis_um = 0.1\n[axis.Z]\ntravel_mm = [-100, 0]\n";

fn found(stated: &str) -> Value {
    let folder = Folder::new(TRUEAXIS);
    write(&folder, stated, PROGRAM, PART);
    folder.json(&["predict", ".", "part.toml", "--json"])
}

fn drive(axis: &str) -> String {
    format!(
        "[axis.{axis}.drive]\nposition_gain_per_s = 80\nvelocity_gain_per_s = 600\nreset_time_s = 0.01\n\
         lowest_resonance_hz = 1000\n"
    )
}

fn um(of: &Value, key: &str) -> f64 {
    of["features"][0][key].as_f64().unwrap_or_else(|| panic!("{key}: {of}"))
}

/// EXY −= C0Y y: over 80 mm of Y the distance of 100 mm changes by −0.6 · 80 C0Y.
#[test]
fn squareness_and_its_uncertainty_over_a_diagonal() {
    let square = format!("{OTHERS}[location]\nC0Y_urad = 50\n[uncertainty.location]\nC0Y_urad = 5\n");
    let found = found(&square);
    assert!((um(&found, "uncorrected_um") + 2.4).abs() < 0.001, "{found}");
    assert!(um(&found, "corrected_um").abs() < 0.001, "{found}");
    // 1.96 · 0.6 · 80 mm · 5 µrad; limits of one standard uncertainty; 10,000 draws.
    assert!((um(&found, "expanded_um") - 0.4704).abs() < 0.015, "{found}");
    assert!((um(&found, "conformance") - 0.6827).abs() < 0.015, "{found}");
    let feature = &found["features"][0];
    assert_eq!(feature["verdict"], "undecided");
    assert_eq!(feature["budget"][0]["term"], "C0Y");
    assert!(feature["parts_cut"].is_null() && (feature["budget"][0]["share"].as_f64().unwrap() - 1.0).abs() < 1e-9);
}

/// The second hole is reached in negative X, where the carriage lags: only there does the play count.
#[test]
fn lost_motion_follows_the_direction_of_travel() {
    let found = found(&format!("backlash_um = 2\n{OTHERS}[axis.X.uncertainty]\nbacklash_um = 0.5\n"));
    assert!((um(&found, "uncorrected_um") - 0.6 * 2.0).abs() < 0.001, "{found}");
    assert!(um(&found, "corrected_um").abs() < 0.001, "{found}");
    assert!((um(&found, "expanded_um") - 1.96 * 0.6 * 0.5).abs() < 0.02, "{found}");
}

/// EXX reaches 400 µm at the travel's end; the limit of 100 µm leaves the correction of 80 µm at X 40 whole, and of the
/// 200 µm at X 100 it removes half: the second hole is at 99.9 mm plus 0.002 of that.
#[test]
fn a_limit_of_the_correction_limits_the_predicted_one() {
    let folder = Folder::new(TRUEAXIS);
    let document = |limits: &str| {
        write(&folder, &format!("{limits}{OTHERS}"), PROGRAM, PART);
        folder.write("x.csv", "X_mm,EXX_um\n0,0\n200,400\n");
        folder.json(&["predict", ".", "part.toml", "--json"])
    };
    let limited = document("");
    let left = 99.9 * 1.002 - 40.0;
    assert!((um(&limited, "corrected_um") - 1e3 * (f64::hypot(left, 80.0) - 100.0)).abs() < 0.01, "{limited}");
    let warnings = limited["warnings"].to_string();
    for part in ["axis X", "removes up to 99.", "X100 Y100", "[axis.X.limits] magnitude_um is 100"] {
        assert!(warnings.contains(part), "{part}: {warnings}");
    }
    assert!(folder.good(&["predict", ".", "part.toml"]).contains("[axis.X.limits] magnitude_um is 100"));
    let whole = document("[axis.X.limits]\nmagnitude_um = 300\n");
    assert!(um(&whole, "corrected_um").abs() < 0.01 && whole["warnings"].as_array().unwrap().is_empty(), "{whole}");
}

#[test]
fn without_uncertainties_there_is_no_verdict_and_the_keys_are_named() {
    let folder = Folder::new(TRUEAXIS);
    write(&folder, &format!("{OTHERS}[location]\nC0Y_urad = 50\n"), PROGRAM, PART);
    let document = folder.json(&["predict", ".", "part.toml", "--json"]);
    assert!(document["features"][0].get("verdict").is_none(), "{document}");
    assert!((um(&document, "uncorrected_um") + 2.4).abs() < 0.001, "{document}");
    let text = folder.good(&["predict", ".", "part.toml"]);
    for part in ["No verdict: the machine states no standard uncertainty", "axis.X.uncertainty.EXX", "-2.40"] {
        assert!(text.replace('−', "-").contains(part), "{text}");
    }
}

#[test]
fn the_sample_part_as_document_table_and_page() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let [machine, part] =
        ["compensation-tables/mill-3axis", "records/plate/part.toml"].map(|name| root.join(name).display().to_string());
    let folder = Folder::new(TRUEAXIS);
    let call = ["predict", &machine, &part, "--trials", "400"];
    let document = folder.json(&[&call[..], &["--json", "--report", "page"]].concat());
    assert_eq!(folder.json(&[&call[..], &["--json"]].concat()), document, "the same seed");
    let features = document["features"].as_array().unwrap();
    assert_eq!(features.len(), 9);
    let text = folder.good(&call);
    let page = folder.read("page/predict.html");
    let shown = ["Deviations and tolerances", "share of the tolerance in %", "95 % of draws", "deviations magnified"];
    for part in shown {
        assert!(page.contains(part), "{part}");
    }
    picture_of_the_documents(&page);
    for feature in features {
        let budget = feature["budget"].as_array().unwrap();
        let share = |one: &Value| one["share"].as_f64().unwrap();
        assert!((budget.iter().map(share).sum::<f64>() - 1.0).abs() < 1e-9, "{feature}");
        assert!(budget.windows(2).all(|pair| share(&pair[0]) >= share(&pair[1])), "{feature}");
        assert!(feature["parts_cut"].is_null() || feature["parts_cut"] == 400, "{feature}");
        let end = |name: &str| trueaxis_report::number::decimals(feature["interval_um"][name].as_f64().unwrap(), 2);
        let interval = format!("{} to {}", end("low"), end("high"));
        let expanded = trueaxis_report::number::decimals(feature["expanded_um"].as_f64().unwrap(), 2);
        for shown in [&text, &page] {
            assert!(shown.contains(&interval), "{feature}");
            assert!(shown.contains(&expanded) && shown.contains(feature["verdict"].as_str().unwrap()), "{feature}");
        }
    }
    let other = folder.json(&[&call[..], &["--json", "--seed", "2"]].concat());
    assert_ne!(other["features"][0]["expanded_um"], document["features"][0]["expanded_um"]);
}

#[test]
fn the_test_parts_of_the_standards_are_predicted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (machine, part, count) in [("mill-3axis", "contouring", 27), ("mill-5axis", "cone", 2)] {
        let [machine, part] = [format!("compensation-tables/{machine}"), format!("records/{part}/part.toml")]
            .map(|name| root.join(name).display().to_string());
        let folder = Folder::new(TRUEAXIS);
        let document = folder.json(&["predict", &machine, &part, "--trials", "200", "--json"]);
        let features = document["features"].as_array().unwrap();
        assert_eq!(features.len(), count, "{document}");
        // The correction has something to correct.
        let most = |of: &str| features.iter().map(|own| own[of].as_f64().unwrap().abs()).fold(0.0, f64::max);
        assert!(most("uncorrected_um") > 5.0 * most("corrected_um"), "{document}");
        assert!(features.iter().all(|own| own["verdict"] == "conforms"), "{document}");
    }
}

/// The picture in the documents is the page's.
fn picture_of_the_documents(page: &str) {
    let (_, part) = page.split_once("Part with its deviations").unwrap();
    let (_, part) = part.split_once("<svg viewBox").unwrap();
    // Those of the legend have a class.
    let (part, _) = part.split_once("</svg>").unwrap();
    for label in ["bore ?", "hole 3 ✓", "front ✓"] {
        assert!(part.contains(label), "{label}");
    }
    // A standalone file needs its own white background.
    let (root, drawn) = part.split_once('>').unwrap();
    let svg = format!("<svg viewBox{root}>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{drawn}</svg>\n")
        .replace("><", ">\n<");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/predict.svg");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&file, &svg).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap(), svg, "UPDATE_DOCS=1 writes docs/predict.svg");
}

#[test]
fn bad_parts_are_refused_with_file_and_line() {
    let folder = Folder::new(TRUEAXIS);
    let part = |from: &str, to: &str| PART.replace(from, to);
    let limits = "limits_um = [-0.24, 0.24]";
    let datums =
        format!("{PART}[[tolerance]]\nfeature = \"one\"\nkind = \"position\"\ndatums = [\"two\"]\nwidth_um = 5\n");
    for (part, parts) in [
        (part(limits, "limits = [-0.24, 0.24]"), &["part.toml:16", "needed a unit, limits_um or limits_mm"][..]),
        (part(limits, ""), &["part.toml:13", "limits_um", "found nothing"]),
        (part(limits, "limits_um = [0.24, -0.24]"), &["part.toml:16", "a rising pair"]),
        (part("lines = [4, 4]", "lines = [3, 3]"), &["part.toml:5", "rapid motion alone", "needed lines that cut one"]),
        (part("lines = [4, 4]", "lines = [9, 9]"), &["part.toml:5", "no motion in lines 9 to 9"]),
        (part("lines = [4, 4]", "lines = [4, 3]"), &["part.toml:7", "first and last line"]),
        (part("lines = [4, 4]", "lines = [4, 8]"), &["two.ngc:4", "needed: one hole"]),
        (part("lines = [4, 4]", "lines = [400, 400]"), &["part.toml:5", "no motion in lines 400 to 400 of two.ngc"]),
        (
            part("kind = \"hole\"\nlines = [4, 4]", "kind = \"circle\"\nlines = [4, 4]"),
            &["two.ngc:4", "arcs of one circle"],
        ),
        (part("from = \"one\"", "from = \"three\""), &["part.toml:15", "needed the name of a feature: one, two"]),
        (part("kind = \"distance\"", "kind = \"size\""), &["part.toml", "size of a hole", "needed circle"]),
        (part("name = \"two\"\nkind", "name = \"one\"\nkind"), &["part.toml:9", "no other feature has"]),
        (part("at_mm = [0, 0, -50]\n", ""), &["at_mm", "found nothing"]),
        (part("[0, 0, -50]", "[120, 0, -50]"), &["two.ngc:6", "axis X at 300.000 mm", "0 to 200 mm"]),
        (format!("{PART}colour = 1\n"), &["part.toml:17", "colour"]),
        (datums, &["part.toml:18", "the datum two, cut in line 8", "made before one"]),
    ] {
        write(&folder, OTHERS, PROGRAM, &part);
        folder.bad(&["predict", ".", "part.toml", "--report", "out"], parts);
    }
    write(&folder, OTHERS, &PROGRAM.replace("G0 X180", "G0 X180 A5"), PART);
    folder.bad(&["predict", ".", "part.toml"], &["two.ngc:6", "axis A", "an axis of"]);
    write(&folder, OTHERS, PROGRAM, PART);
    folder.bad(&["predict", ".", "part.toml", "--trials", "199"], &["trials: found 199, needed 200 to 1000000"]);
    write(&folder, "[axis.Z]\ntravel_mm = [-100, 0]\n", PROGRAM, PART);
    folder.write("machine.toml", folder.read("machine.toml").replace("X' Y' b", "X' b"));
    folder.bad(&["predict", ".", "part.toml"], &["small: found axes X, Z, needed X, Y and Z"]);
    write(&folder, OTHERS, PROGRAM, &part("program = \"two.ngc\"\n", ""));
    folder.bad(&["predict", ".", "part.toml"], &["program", "--program"]);
}

/// The sample's part.toml was written by hand.
#[test]
fn the_features_of_the_sample_part_are_found_and_can_be_predicted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = Folder::new(TRUEAXIS);
    folder.copy(&root.join("records/plate"), ".");
    let by_hand = folder.read("part.toml");
    let tolerances = by_hand.find("[[tolerance]]").unwrap();
    let head = by_hand.find("[[feature]]").unwrap();
    let machine = root.join("compensation-tables/mill-3axis").display().to_string();
    folder.write("part.toml", &by_hand[..head]);
    folder.bad(&["predict", &machine, "part.toml"], &["part.toml: key tolerance: found nothing, needed at least one"]);
    let found = folder.good(&["predict", &machine, "part.toml", "--find"]);
    // The same kinds and lines in the same order; part.toml leaves out the fourth hole.
    let of = |text: &str| -> Vec<String> {
        let keys = |line: &&str| line.starts_with("kind") || line.starts_with("lines");
        text.lines().filter(keys).map(String::from).collect()
    };
    let wanted = [of(&by_hand[head..tolerances]), vec!["kind = \"hole\"".into(), "lines = [36, 36]".into()]].concat();
    assert_eq!(of(&found), wanted);
    let names = [("top", "plane 1"), ("front", "line 1"), ("left", "line 2"), ("bore", "circle 1")];
    let renamed = names.iter().fold(by_hand[tolerances..].to_owned(), |text, (from, to)| {
        text.replace(&format!("\"{from}\""), &format!("\"{to}\""))
    });
    let call = ["predict", &machine, "part.toml", "--json", "--trials", "200"];
    folder.write("part.toml", format!("{}{found}{renamed}", &by_hand[..head]));
    let value = |document: &Value| {
        document["features"].as_array().unwrap().iter().map(|of| of["uncorrected_um"].clone()).collect::<Vec<_>>()
    };
    let with_found = value(&folder.json(&call));
    folder.write("part.toml", &by_hand);
    assert_eq!(with_found, value(&folder.json(&call)));
}

/// The file's sections are unfinished: an unknown kind, a tolerance of a feature that there is not, a key without a value.
#[test]
fn features_are_found_for_an_unfinished_part_and_repeated_passes_are_named() {
    let folder = Folder::new(TRUEAXIS);
    let program = "G21 G90 G17 G94 F200\nG0 X0 Y0 Z10\nG81 X40 Y20 Z-1 R2\nG81 X40 Y20 Z-5 R2\nG80\nM2\n";
    let head = &PART[..PART.find("[[feature]]").unwrap()];
    let unfinished = "[[feature]]\nname = \"one\"\nkind = \"slot\"\n[[tolerance]]\nfeature = \"none\"\nwidth_um =\n";
    write(&folder, OTHERS, program, &format!("{head}{unfinished}"));
    let found = folder.good(&["predict", ".", "part.toml", "--find"]);
    let wanted = "# line 3 left out: the same hole, cut before hole 1\n[[feature]]\nname = \"hole 1\"\nkind = \"hole\"\n\
                  lines = [4, 4]\n";
    assert_eq!(found, wanted);
    folder.bad(&["predict", ".", "part.toml"], &["part.toml:9"]);
    write(&folder, OTHERS, program, unfinished);
    folder.bad(&["predict", ".", "part.toml", "--find"], &["part.toml: key program: found nothing"]);
}

/// Squareness makes an ellipse of the circle: its roundness is C0Y times the radius, by either association.
#[test]
fn the_association_of_a_form_is_in_document_and_table() {
    let folder = Folder::new(TRUEAXIS);
    let program = "G21 G90 G17 G94 F200\nG0 X120 Y100 Z0\nG3 X120 I-20 J0\nM2\n";
    let head = &PART[..PART.find("[[feature]]").unwrap()];
    let tolerance = "[[tolerance]]\nfeature = \"ring\"\nkind = \"roundness\"\nwidth_um = 5\n";
    let part = format!(
        "{head}[[feature]]\nname = \"ring\"\nkind = \"circle\"\nlines = [3, 3]\n{tolerance}association = \"minimum zone\"\n\
         {tolerance}"
    );
    write(&folder, &format!("{OTHERS}[location]\nC0Y_urad = 50\n"), program, &part);
    let document = folder.json(&["predict", ".", "part.toml", "--json"]);
    for (k, association) in ["minimum zone", "least squares"].into_iter().enumerate() {
        let of = &document["features"][k];
        assert_eq!(of["association"], association);
        assert!((of["uncorrected_um"].as_f64().unwrap() - 1e3 * 20.0 * 50e-6).abs() < 0.01, "{document}");
    }
    let text = folder.good(&["predict", ".", "part.toml"]);
    assert!(text.contains("ring, roundness, minimum zone") && text.contains("ring, roundness "), "{text}");
}

/// Scale of X and squareness within 5 ppm and 5 µrad: over 60 mm of X and 80 mm of Y the distance of 100 mm has derivatives of
/// 36 mm and 48 mm. Either alone leaves more than 0.3 µm.
const TWO_TERMS: &str = "[axis.X.uncertainty]\nscale_ppm = 5\n[uncertainty.location]\nC0Y_urad = 5\n";
const INSTRUMENTS: &str = "[[instrument]]\nkind = \"laser\"\nalong = [\"X\"]\n\
                           [[instrument]]\nkind = \"square\"\nplanes = [\"XY\"]\nuncertainty_urad = 1\n\
                           [probe]\nrepeatability_um = 0.1\n";

fn advised(folder: &Folder, stated: &str, instruments: &str, limit: f64) {
    let part = PART.replace("[-0.24, 0.24]", &format!("[-{limit}, {limit}]"));
    write(folder, &format!("{OTHERS}{stated}"), PROGRAM, &format!("{part}{instruments}"));
}

/// u(f)² = 36² s² + 48² c² with s⁻² = 5⁻² + s_m⁻², c⁻² = 5⁻² + c_m⁻². The laser reads 0 and 200 mm twice, 0.2 µm a reading:
/// s_m² = 0.2²/(4 · 0.1²) ppm² by the readings and 0.7² ppm² by its calibration. c_m is what `calibrate plan` foresees.
#[test]
fn advice_on_two_terms_is_the_closed_form_and_its_task_is_planned() {
    let folder = Folder::new(TRUEAXIS);
    advised(&folder, TWO_TERMS, INSTRUMENTS, 0.3);
    let call = ["predict", ".", "part.toml", "--advise", "-o", "task.toml"];
    let document = folder.json(&[&call[..], &["--json", "--report", "page"]].concat());
    let planned = folder.json(&["calibrate", "plan", "task.toml", "-o", "probe.ngc", "--json"]);
    let terms = planned["terms"].as_array().unwrap();
    let of = |name: &str| terms.iter().find(|term| term["name"] == name).unwrap_or_else(|| panic!("{planned}"));
    let c_m = of("squareness C0Y")["standard_error"].as_f64().unwrap();
    let left = |measured: f64| 1.0 / (1.0 / 25.0 + 1.0 / (measured * measured));
    let s_m = (0.2_f64.powi(2) / (4.0 * 0.1_f64.powi(2)) + 0.7_f64.powi(2)).sqrt();
    let expanded = |s2: f64, c2: f64| 1.96e-3 * (36.0_f64.powi(2) * s2 + 48.0_f64.powi(2) * c2).sqrt();
    let advice = &document["advice"];
    let feature = &advice["features"][0];
    let um = |key: &str| feature[key].as_f64().unwrap();
    for (key, wanted) in [
        ("before_um", expanded(25.0, 25.0)),
        ("after_um", expanded(left(s_m), left(c_m))),
        ("least_um", expanded(left(s_m), left(c_m))),
    ] {
        // The ends of 10,000 draws scatter by 1.4 %.
        assert!((um(key) / wanted - 1.0).abs() < 0.04, "{key}: {wanted} for {advice}");
    }
    assert!(expanded(left(s_m), 25.0) > 0.3 && expanded(25.0, left(c_m)) > 0.3, "one would be enough: {c_m}");
    assert_eq!((&feature["verdict_before"], &feature["verdict_after"]), (&"undecided".into(), &"conforms".into()));
    let measurements = advice["measurements"].as_array().unwrap();
    let names: Vec<&str> = measurements.iter().map(|of| of["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["laser along X", "square XY"]);
    // An hour, and ten minutes beside those of the program.
    let minutes = 60.0 + 10.0 + planned["minutes"].as_f64().unwrap();
    assert!((advice["minutes"].as_f64().unwrap() - minutes).abs() < 1e-6, "{advice}");
    let text = folder.good(&call);
    for shown in [&text, &folder.read("page/predict.html")] {
        for part in ["What to measure", "laser along X", "square XY", "Before and after", "expected after"] {
            assert!(shown.contains(part), "{part}: {shown}");
        }
    }
    // The written task, stated as an instrument, is the same measurement.
    let laser = INSTRUMENTS.split_inclusive("[\"X\"]\n").next().unwrap();
    let task = "[[instrument]]\nkind = \"task\"\nfile = \"task.toml\"\n";
    advised(&folder, TWO_TERMS, &format!("{laser}{task}"), 0.3);
    let again = folder.json(&["predict", ".", "part.toml", "--advise", "--json"]);
    // Its readings come in another order, and with them other draws of their noise.
    let after = again["advice"]["features"][0]["after_um"].as_f64().unwrap();
    assert!((after / um("after_um") - 1.0).abs() < 0.04, "{again}");
    assert!((again["advice"]["minutes"].as_f64().unwrap() - minutes).abs() < 1e-6, "{again}");
    let call_other = ["predict", ".", "part.toml", "--advise", "-o", "other.toml"];
    assert!(folder.reported(&call_other).contains("your own task; next, trueaxis calibrate plan task.toml"));
    assert!(folder.good(&call_other).contains("calibrate plan task.toml") && !folder.has("other.toml"));
    let named = format!("{laser}{task}name = \"the square\"\n");
    advised(&folder, TWO_TERMS, &named, 0.3);
    let again = folder.json(&["predict", ".", "part.toml", "--advise", "--json"]);
    assert_eq!(again["advice"]["measurements"][1]["name"], "the square", "{again}");
    assert_eq!(again["advice"]["measurements"][1]["file"], "task.toml", "{again}");
    let own = folder.read("task.toml");
    folder.write("other/machine.toml", folder.read("machine.toml"));
    folder.write("other/x.csv", folder.read("x.csv"));
    folder.write("task.toml", own.replacen("machine = \".\"", "machine = \"other\"", 1));
    folder.bad(&["predict", ".", "part.toml", "--advise"], &["task.toml: key machine: found other, needed ."]);
    folder.write("task.toml", own);
    // The owner's task stays what it is.
    folder.bad(&call, &["task.toml"]);
}

#[test]
fn several_uses_of_a_laser_are_said_to_be_taken_as_independent() {
    let folder = Folder::new(TRUEAXIS);
    let scales = "[axis.X.uncertainty]\nscale_ppm = 50\n[axis.Y.uncertainty]\nscale_ppm = 50\n";
    advised(&folder, scales, "[[instrument]]\nkind = \"laser\"\n", 1.2);
    let text = folder.good(&["predict", ".", "part.toml", "--advise"]);
    assert!(text.contains("common to the uses of laser along several axes"), "{text}");
}

/// Fourteen measurements, more than every set is tried of: five squares and three lasers along three axes.
#[test]
fn of_many_measurements_the_shortest_is_found_step_by_step() {
    let folder = Folder::new(TRUEAXIS);
    let square = |k: usize| {
        let minutes = if k == 3 { 4 } else { 9 };
        format!(
            "[[instrument]]\nkind = \"square\"\nname = \"s{k}\"\nplanes = [\"XY\"]\nuncertainty_urad = 1\n\
             minutes = {minutes}\n"
        )
    };
    let laser = |k: usize| format!("[[instrument]]\nkind = \"laser\"\nname = \"l{k}\"\nminutes = {}\n", 40 - k);
    let all: String = (0..5).map(square).chain((0..3).map(laser)).collect();
    let all = all + "[probe]\nrepeatability_um = 0.1\n";
    for (limit, wanted) in [(0.45, &["s3 XY"][..]), (0.3, &["s3 XY", "l2 along X"])] {
        advised(&folder, TWO_TERMS, &all, limit);
        let advice = folder.json(&["predict", ".", "part.toml", "--advise", "--json"])["advice"].clone();
        assert_eq!(advice["compared"].as_array().unwrap().len(), 14);
        let names: Vec<&str> =
            advice["measurements"].as_array().unwrap().iter().map(|of| of["name"].as_str().unwrap()).collect();
        assert_eq!(names, wanted, "{advice}");
        assert_eq!(advice["exact"], false, "{advice}");
    }
    let text = folder.good(&["predict", ".", "part.toml", "--advise"]);
    assert!(text.contains("a short set found by adding measurements one at a time"), "{text}");
}

/// The scale of X counts from X 0: of the positions within the travel the lowest is the best. A hole at 60 mm comes to 41 mm.
#[test]
fn a_place_where_the_scale_matters_less_is_found() {
    let folder = Folder::new(TRUEAXIS);
    let part = PART.replace("[0, 0, -50]", "[20, 0, -50]");
    let part = &part[..part.find("[[tolerance]]").unwrap()];
    let position = "[[tolerance]]\nfeature = \"one\"\nkind = \"position\"\nwidth_um = 5\n";
    let stated = "[axis.X.uncertainty]\nscale_ppm = 20\n";
    write(&folder, &format!("{OTHERS}{stated}"), PROGRAM, &format!("{part}{position}{INSTRUMENTS}"));
    let advice = folder.json(&["predict", ".", "part.toml", "--advise", "--json"])["advice"].clone();
    let place = &advice["place"];
    assert_eq!(place["at_mm"], serde_json::json!([1.0, 0.0, -50.0]), "{advice}");
    let share = |key: &str| place[key].as_f64().unwrap();
    assert!((share("there") / share("here") - 41.0 / 60.0).abs() < 1e-3, "{advice}");
    let text = folder.good(&["predict", ".", "part.toml", "--advise"]);
    assert!(text.contains("places compared before the measurements"), "{text}");
    // The distance of the holes is the largest share everywhere, and the same: only the position conforms elsewhere.
    let stated = "[axis.X.uncertainty]\nscale_ppm = 20\nbacklash_um = 1\n";
    let distance = "[[tolerance]]\nfeature = \"two\"\nkind = \"distance\"\nfrom = \"one\"\nlimits_um = [-0.1, 0.1]\n";
    let position = position.replace("width_um = 5", "width_um = 4.2");
    write(&folder, &format!("{OTHERS}{stated}"), PROGRAM, &format!("{part}{position}{distance}{INSTRUMENTS}"));
    let advice = folder.json(&["predict", ".", "part.toml", "--advise", "--json"])["advice"].clone();
    assert_eq!(advice["place"]["conform"], serde_json::json!([0, 1]), "{advice}");
}

/// The bevel is cut in negative X, where the carriage lags by an uncertain amount; the other way round it does not.
#[test]
fn a_direction_without_uncertain_lost_motion_is_found() {
    let folder = Folder::new(TRUEAXIS);
    let program = "G21 G90 G17 G94 F200\nG0 X0 Y0 Z10\nG0 X20\nG81 X40 Y20 Z-5 R2\nG80\nG0 X180\nG1 Z-5\nG1 X100 Y100\n\
                   G0 Z10\nM2\n";
    let part = PART.replace("name = \"two\"\nkind = \"hole\"", "name = \"two\"\nkind = \"line\"").replace("0.24", "2");
    let stated = "[axis.X.uncertainty]\nbacklash_um = 1\n";
    write(&folder, &format!("{OTHERS}{stated}"), program, &format!("{part}{INSTRUMENTS}"));
    let call = ["predict", ".", "part.toml", "--advise"];
    let advice = folder.json(&[&call[..], &["--json"]].concat())["advice"].clone();
    let [direction] = &advice["directions"].as_array().unwrap()[..] else { panic!("{advice}") };
    assert_eq!(direction["feature"], "two");
    let share = |key: &str| direction[key].as_f64().unwrap();
    // 1.96 · 1 µm · cos 45° of 2 µm; 200 draws.
    assert!((share("here") - 0.693).abs() < 0.15 && share("there") < 1e-3, "{advice}");
    assert!(folder.good(&call).contains("two cut in the other direction: "), "{advice}");
}

/// Measurements that are not needed are left out; terms that none of them shows are named.
#[test]
fn advice_is_the_shortest_set_or_says_what_is_not_measured() {
    let folder = Folder::new(TRUEAXIS);
    let of = |stated: &str, limit: f64| {
        advised(&folder, stated, INSTRUMENTS, limit);
        folder.json(&["predict", ".", "part.toml", "--advise", "--json"])["advice"].clone()
    };
    let names = |advice: &Value| -> Vec<String> {
        advice["measurements"].as_array().unwrap().iter().map(|of| of["name"].as_str().unwrap().to_owned()).collect()
    };
    // The square alone is enough, and shorter than the laser.
    let short = of(TWO_TERMS, 0.45);
    assert_eq!((names(&short), &short["exact"]), (vec!["square XY".into()], &true.into()));
    let text = folder.good(&["predict", ".", "part.toml", "--advise"]);
    assert!(text.contains("bring every characteristic to a verdict, the shortest of all sets"), "{text}");
    assert!(names(&of(TWO_TERMS, 0.7)).is_empty());
    let scattered = TWO_TERMS.replace("scale_ppm = 5", "scale_ppm = 5\nrepeatability_um = 1");
    let advice = of(&scattered, 0.3);
    assert!(names(&advice).is_empty(), "{advice}");
    let left = &advice["features"][0]["left"][0];
    assert_eq!((&left["term"], &left["is_measured"]), (&"repeatability X".into(), &false.into()));
    let text = folder.good(&["predict", ".", "part.toml", "--advise", "-o", "task.toml"]);
    for part in ["No set of the 2 measurements brings one more characteristic", "repeatability X", "not measured"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!folder.has("task.toml"));
    let call = ["predict", ".", "part.toml", "--advise", "-o", "task.toml"];
    folder.write("task.toml", "stale");
    let said = folder.reported(&call);
    assert!(said.contains("no measurement helps; the file of this name is not from this advice"), "{said}");
    advised(&folder, TWO_TERMS, INSTRUMENTS, 0.7);
    assert!(folder.reported(&call).contains("not written task.toml: nothing has to be measured"));
    let laser = "[[instrument]]\nkind = \"laser\"\nalong = [\"X\"]\nminutes = 1\n";
    advised(&folder, "[axis.X.uncertainty]\nscale_ppm = 5\n", laser, 0.3);
    assert!(folder.reported(&call).contains("not written task.toml: no measurement with the probe is needed"));
    let text = folder.good(&call);
    assert!(text.contains("1 minute of measuring brings every characteristic to a verdict"), "{text}");
    // 0.6 · 80 mm · 50 µrad without the correction.
    advised(&folder, "[location]\nC0Y_urad = 50\n[uncertainty.location]\nC0Y_urad = 1\n", laser, 0.3);
    let text = folder.good(&call);
    let said = "two distance from one conforms with the correction on; without it, it does not conform";
    assert!(text.contains(said), "{text}");
}

#[test]
fn advice_without_what_it_needs_is_refused() {
    let folder = Folder::new(TRUEAXIS);
    let bad = |stated: &str, instruments: &str, parts: &[&str]| {
        advised(&folder, stated, instruments, 0.3);
        folder.bad(&["predict", ".", "part.toml", "--advise"], parts);
    };
    bad("", INSTRUMENTS, &["small: no advice", "uncertainty.device_um_per_m"]);
    bad(TWO_TERMS, "", &["part.toml", "instrument: found nothing", "[[instrument]]"]);
    let one = |text: &str| format!("[[instrument]]\n{text}\n");
    bad(TWO_TERMS, &one("kind = \"ruler\""), &["part.toml:18", "ruler", "gauge block"]);
    bad(TWO_TERMS, &one("minutes = 5"), &["part.toml:18", "kind", "\"ballbar\""]);
    bad(TWO_TERMS, &one("kind = \"laser\"\nalong = [\"A\"]"), &["part.toml:19", "each once of X, Y, Z"]);
    bad(TWO_TERMS, &one("kind = \"laser\"\nalong = [\"X\", \"X\"]"), &["part.toml:19", "each once of X, Y, Z"]);
    bad(TWO_TERMS, &one("kind = \"ring\"\nminutes = 0"), &["part.toml:19", "0.1 to 10000 minutes"]);
    bad(TWO_TERMS, &one("kind = \"ring\"\nlength_mm = 5"), &["part.toml:19", "length_mm"]);
    bad(TWO_TERMS, &one("kind = \"task\""), &["part.toml:18", "file", "a task of calibrate"]);
    bad(TWO_TERMS, &one("kind = \"task\"\nfile = \"none.toml\""), &["none.toml"]);
    let twice = one("kind = \"ball\"").repeat(2);
    bad(TWO_TERMS, &twice, &["part.toml:20", "a second ball", "another name"]);
    bad(
        TWO_TERMS,
        &format!("{}[probe]\ntip_radius_mm = 0\n", one("kind = \"ball\"")),
        &["part.toml:20", "0.05 to 25 mm"],
    );
    // A measurement beyond the travel of 200 mm is reported, and the others are compared.
    advised(&folder, TWO_TERMS, &format!("{INSTRUMENTS}{}", one("kind = \"ballbar\"\nradius_mm = 150")), 0.3);
    let text = folder.good(&["predict", ".", "part.toml", "--advise"]);
    assert!(text.contains("not compared, ballbar XY: found X at") && text.contains("square XY"), "{text}");
    let advice = folder.json(&["predict", ".", "part.toml", "--advise", "--json"])["advice"].clone();
    assert_eq!(advice["compared"], serde_json::json!(["laser along X", "square XY"]), "{advice}");
}

/// The correction of EYX takes up the play of Y before the program begins, in negative travel; Y itself first moves, in positive
/// travel, between the two holes, which would otherwise be 0.8 times the play nearer to each other.
#[test]
fn the_servo_begins_with_the_play_that_the_correction_has_taken_up() {
    let folder = Folder::new(TRUEAXIS);
    let drives = ["X", "Y", "Z"].map(drive).join("");
    let stated = format!("{}{drives}", OTHERS.replace("[axis.Z]", "backlash_um = 4\n[axis.Z]"));
    let program = "G21 G90 G17 G94 F200\nG0 X0 Y0 Z10\nG81 X40 Y0 Z-5 R2\nG80\nG0 Y40\nG0 X0\nG0 X90\n\
                   G81 X100 Y80 Z-5 R2\nG80\nM2\n";
    write(&folder, &stated, program, &PART.replace("[4, 4]", "[3, 3]"));
    folder.write("x.csv", "X_mm,EYX_um\n0,10\n200,10\n");
    let document = folder.json(&["predict", ".", "part.toml", "--servo", "--rate-hz", "2000", "--json"]);
    assert!(um(&document, "corrected_um").abs() < 0.8, "{document}");
    assert!(um(&document, "uncorrected_um").abs() < 0.8, "{document}");
}

/// X and Y still settle when the strokes begin, which moves the middle of a hole by a fraction of a micrometre.
#[test]
fn the_servo_is_simulated_where_the_machine_states_its_drives() {
    let folder = Folder::new(TRUEAXIS);
    write(&folder, &format!("{OTHERS}[location]\nC0Y_urad = 50\n"), PROGRAM, PART);
    let call = ["predict", ".", "part.toml", "--servo", "--rate-hz", "2000"];
    folder.bad(&call, &["small: key axis.X.drive: found nothing", "needed position_gain_per_s"]);
    let drives = ["X", "Y", "Z"].map(drive).join("");
    write(&folder, &format!("{OTHERS}[location]\nC0Y_urad = 50\n{drives}"), PROGRAM, PART);
    let document = folder.json(&[&call[..], &["--json"]].concat());
    assert!((um(&document, "uncorrected_um") + 2.4).abs() < 0.6, "{document}");
    let corrected = um(&document, "corrected_um");
    assert!(corrected.abs() < 0.6 && corrected.abs() > 0.01, "{document}");
    // Nothing acts on the servo.
    assert_eq!(um(&document, "everything_um"), corrected);
    assert_eq!(document["servo"]["rate_hz"], 2000.0);
    let text = folder.good(&call);
    for part in
        ["everything on", "uncertainty of the drives, temperature while cutting, bending and process are not included"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    folder.good(&[&call[..], &["--report", "page"]].concat());
    assert!(folder.read("page/predict.html").contains("Part with everything on"));
    folder.bad(&["predict", ".", "part.toml", "--rate-hz", "2000"], &["--servo"]);
    folder.bad(&["predict", ".", "part.toml", "--servo", "--rate-hz", "10"], &["rate_hz", "100"]);
    folder.bad(&[&call[..], &["--advise"]].concat(), &["key instrument: found nothing"]);
}

/// The spindle end of X grows by 4 µm/K; the second hole is drilled later and warmer.
#[test]
fn a_record_of_temperatures_or_a_thermal_toml_adds_the_growth() {
    let folder = Folder::new(TRUEAXIS);
    write(&folder, OTHERS, PROGRAM, PART);
    let record: String =
        (0..20).map(|row| format!("{},{}\n", 28_800 + 60 * row, 20.0 + 0.5 * f64::from(row))).collect();
    folder.write("shift.csv", format!("t_s,T1_c\n{record}"));
    let call = ["predict", ".", "part.toml", "--thermal", "shift.csv"];
    folder.bad(&call, &["small", "found no growth of any axis", "thermal.toml beside machine.toml"]);
    write(&folder, &format!("{OTHERS}[axis.X.thermal]\noffset_um_per_k = 4\n"), PROGRAM, PART);
    let document = folder.json(&[&call[..], &["--start", "120", "--json"]].concat());
    assert_eq!(folder.json(&[&call[..], &["--at", "08:02", "--json"]].concat()), document, "the same moment");
    let temperature = &document["temperature"];
    assert_eq!((&temperature["record"], &temperature["start_s"]), (&"shift.csv".into(), &120.0.into()));
    let [first, last] = [0, 1].map(|end| temperature["growth"][0]["growth"][end].as_f64().unwrap());
    let [from, to] = [0, 1].map(|end| temperature["sensors"][0]["celsius"][end].as_f64().unwrap());
    assert!((first - 4.0 * (from - 20.0)).abs() < 1e-9 && (last - 4.0 * (to - 20.0)).abs() < 1e-9, "{temperature}");
    assert!(from > 21.0 && to > from, "{temperature}");
    // Middles of the strokes against their ends: 0.6 of the difference along X.
    let uncorrected = um(&document, "uncorrected_um");
    assert!(uncorrected > 0.3 * (last - first) && uncorrected < 0.6 * (last - first), "{document}");
    assert!(um(&document, "corrected_um").abs() < 1e-6, "{document}");
    let text = folder.good(&[&call[..], &["--start", "120"]].concat());
    for part in
        ["the program starts 120 s into it", "servo, temperature of the part, bending and process are not included"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    folder.bad(&[&call[..], &["--start", "1139"]].concat(), &["shift.csv:21", "needed rows until"]);
    for (arguments, parts) in [
        (&["--at", "8:2"][..], &["00:00 to 23:59"][..]),
        (&["--at", "07:00"], &["shift.csv:21", "a start within the record"]),
        (&["--at", "08:00", "--start", "5"], &["cannot be used with"]),
    ] {
        folder.bad(&[&call[..], arguments].concat(), parts);
    }
    folder.bad(&["predict", ".", "part.toml", "--start", "5"], &["--thermal"]);

    // The file beside machine.toml comes before its keys: 8 µm/K, and a part of the same temperature.
    folder.write(
        "thermal.toml",
        "reference_temperature_c = 20\n[[sensor]]\nname = \"T1\"\nknots_c = [10, 40]\n[axis.X]\nuncertainty_um = 0.5\n\
         [axis.X.sensor.T1]\noffset_um = [-80, 160]\n",
    );
    folder.write(
        "part.toml",
        format!("{PART}[temperature]\nmachine_c = 21\npart_c = 21\npart_expansion_um_per_m_k = 24\n"),
    );
    let document = folder.json(&["predict", ".", "part.toml", "--json"]);
    assert!((document["temperature"]["growth"][0]["growth"][0].as_f64().unwrap() - 8.0).abs() < 1e-6, "{document}");
    assert!((um(&document, "corrected_um") + 2.4).abs() < 1e-3, "{document}");
    let text = folder.good(&["predict", ".", "part.toml"]);
    assert!(text.contains("servo, bending and process are not included"), "{text}");
}
