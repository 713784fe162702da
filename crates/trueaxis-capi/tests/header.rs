//! Checks that the committed header is the one generated from the source.

use std::{env, fs, path::Path};
use trueaxis_capi::{ABI_MAJOR, ABI_MINOR};

/// Source files in the order in which the header presents them.
const SOURCES: &[&str] = &[
    "scalar",
    "version",
    "result",
    "error",
    "tables",
    "spans",
    "path",
    "segments",
    "command_window",
    "kinematics",
    "rtcp",
    "gauge",
    "gauge_ride",
    "measure",
    "built",
    "servo",
    "contour",
    "axes",
    "dynamic",
    "cycle",
    "step",
    "friction",
    "encoder",
    "learned",
    "thermal",
    "fault",
    "frame",
    "evaluation",
    "query",
];

fn generated(root: &Path) -> String {
    let mut config = cbindgen::Config::from_file(root.join("cbindgen.toml")).unwrap();
    config.header = Some(include_str!("header/opening.h").trim_end().to_string());
    let version = include_str!("header/version.h");
    let version = version.replace("@MAJOR@", &ABI_MAJOR.to_string()).replace("@MINOR@", &ABI_MINOR.to_string());
    config.after_includes = Some(format!("\n{}", version.trim_end()));
    let mut builder = cbindgen::Builder::new().with_config(config);
    for source in SOURCES {
        builder = builder.with_src(root.join(format!("src/{source}.rs")));
    }
    let mut bytes = Vec::new();
    builder.generate().unwrap().write(&mut bytes);
    without_safety_sections(&String::from_utf8(bytes).unwrap())
}

/// Removes the `# Safety` sections, which are for readers of the Rust code: in C the pointer types imply them.
fn without_safety_sections(header: &str) -> String {
    let mut kept = Vec::new();
    let mut inside = false;
    for line in header.lines() {
        if line.trim() == "/// # Safety" {
            inside = true;
            kept.pop_if(|last: &mut &str| last.trim() == "///");
        }
        inside &= line.trim_start().starts_with("///");
        if !inside {
            kept.push(line);
        }
    }
    kept.join("\n") + "\n"
}

#[test]
fn header_is_current() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let file = root.join("include/trueaxis.h");
    let header = generated(root);
    if env::var_os("TRUEAXIS_WRITE_HEADER").is_some() {
        fs::write(&file, &header).unwrap();
    }
    let committed = fs::read_to_string(&file).unwrap_or_default();
    assert!(
        header == committed,
        "include/trueaxis.h is not what the source gives: TRUEAXIS_WRITE_HEADER=1 cargo test -p trueaxis-capi --test capi header"
    );
}

#[test]
fn every_source_with_a_function_for_c_is_in_the_header() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let sources = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let exports = |file: &std::path::PathBuf| fs::read_to_string(file).unwrap().contains("#[unsafe(no_mangle)]");
    let missing: Vec<_> = sources
        .filter(exports)
        .map(|file| file.file_stem().unwrap().to_str().unwrap().to_owned())
        .filter(|name| !SOURCES.contains(&name.as_str()))
        .collect();
    assert!(missing.is_empty(), "sources that export functions and are not among SOURCES: {missing:?}");
}
