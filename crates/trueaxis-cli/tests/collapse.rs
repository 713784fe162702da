//! `trueaxis tables collapse` from outside.

use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn call(arguments: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Command::new(env!("CARGO_BIN_EXE_trueaxis")).args(arguments).current_dir(root).output().unwrap()
}

#[test]
fn nine_tables_that_check_accepts() {
    let directory = TempDir::new().unwrap();
    let out = directory.path().join("nine");
    let out = out.to_str().unwrap();
    let output =
        call(&["tables", "collapse", "compensation-tables/mill-3axis", "-o", out, "--volume", "-200:200,,", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["volume_mm"]["X"], serde_json::json!([-200.0, 200.0]));
    let rms = |key: &str| document[key]["rms_um"].as_f64().unwrap();
    assert!(rms("collapsed_tables") < rms("original_tables") && rms("collapsed_tables") < rms("before"));
    assert!(call(&["tables", "check", out]).status.success());
}

#[test]
fn bad_input_writes_nothing() {
    let directory = TempDir::new().unwrap();
    let out = directory.path().join("nine");
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
        let path = format!("compensation-tables/{machine}");
        let output = call(&["tables", "collapse", &path, "-o", out.to_str().unwrap(), option, value]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{option} {value}: {said}");
        assert!(said.contains("found") && said.contains("needed"), "{option} {value}: {said}");
        assert!(!out.exists(), "{option} {value}");
    }
    let own = "compensation-tables/mill-3axis";
    assert_eq!(call(&["tables", "collapse", own, "-o", own]).status.code(), Some(2));
}
