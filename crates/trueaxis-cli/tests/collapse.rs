//! `trueaxis tables collapse` from outside.

use std::path::Path;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

/// A folder with the sample machines.
fn folder() -> Folder {
    let directory = Folder::new(TRUEAXIS);
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables");
    for name in ["mill-3axis", "mill-5axis"] {
        directory.copy(&samples.join(name), name);
    }
    directory
}

#[test]
fn nine_tables_that_check_accepts() {
    let directory = folder();
    let document =
        directory.json(&["tables", "collapse", "mill-3axis", "-o", "nine", "--volume", "-200:200,,", "--json"]);
    assert_eq!(document["volume_mm"]["X"], serde_json::json!([-200.0, 200.0]));
    let rms = |key: &str| document[key]["rms_um"].as_f64().unwrap();
    assert!(rms("collapsed_tables") < rms("original_tables") && rms("collapsed_tables") < rms("before"));
    directory.good(&["tables", "check", "nine"]);
}

#[test]
fn bad_input_writes_nothing() {
    let directory = folder();
    for (machine, option, value) in [
        ("mill-3axis", "--volume", "-900:0,,"),
        ("mill-3axis", "--volume", "0:0,,"),
        ("mill-3axis", "--volume", "10:5,,"),
        ("mill-3axis", "--volume", "nan:5,,"),
        ("mill-3axis", "--volume", "0:5"),
        ("mill-3axis", "--pose", "A=3"),
        ("mill-3axis", "--tool-mm", "1,2"),
        ("mill-3axis", "--tool-mm", "1,2,inf"),
        ("mill-3axis", "--reference-mm", "0,0,900"),
        ("mill-5axis", "--pose", "A=90"),
        ("mill-5axis", "--pose", "A=1,A=2"),
    ] {
        let arguments = ["tables", "collapse", machine, "-o", "nine", option, value];
        directory.bad(&arguments, &["found", "needed"]);
    }
    directory.bad(&["tables", "collapse", "mill-3axis", "-o", "mill-3axis"], &[]);
}
