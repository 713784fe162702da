//! Every test named in the fault table exists; its statements on clocks and files hold for every source.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The rows of the table as cells.
fn rows(page: &str) -> Vec<Vec<&str>> {
    let cells = |line: &'_ str| line.trim_matches('|').split(" | ").count();
    let table = page.lines().filter(|line| line.starts_with("| ") && cells(line) == 4);
    let rows = table.map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect::<Vec<_>>());
    rows.filter(|row: &Vec<&str>| row[0] != "Fault").collect()
}

/// Names and files of the links in a cell.
fn links(cell: &str) -> Vec<(&str, &str)> {
    let link = |part: &'_ str| -> Option<(usize, usize)> { Some((part.find("](")?, part.find(')')?)) };
    cell.split('[')
        .skip(1)
        .map(|part| {
            let (middle, end) = link(part).unwrap_or_else(|| panic!("{part}: needed [test](file)"));
            (&part[..middle], &part[middle + 2..end])
        })
        .collect()
}

/// Whether a source has a test of that name: under `#[test]`, in a macro call or called by a runner.
fn has_test(file: &str, source: &str, name: &str) -> bool {
    match file.rsplit('.').next() {
        Some("rs") => source.split(&format!("fn {name}(")).next().is_some_and(|before| {
            let attributes = before.rsplit("\n\n").next().unwrap_or("");
            before.len() < source.len() && attributes.contains("#[test]")
        }),
        Some("mjs") => source.contains(&format!("test(\"{name}\"")),
        // Defined, and in the runner's list.
        Some("py") => source.split_once("\nTESTS = ").is_some_and(|(tests, list)| {
            let listed = list.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == name);
            listed && tests.contains(&format!("\ndef {name}(folder):\n"))
        }),
        Some("sh") => source.contains(&format!("\nsay '{name}'\n")),
        _ => false,
    }
}

#[test]
fn every_test_that_the_table_names_exists() {
    let page = read(&root().join("docs/faults.md"));
    let rows = rows(&page);
    assert!(rows.len() >= 30, "{} faults", rows.len());
    let mut faults = BTreeSet::new();
    for row in &rows {
        assert!(faults.insert(row[0]), "{}: twice", row[0]);
        assert!(row.iter().all(|cell| !cell.is_empty()), "{row:?}");
        let shown = links(row[2]);
        assert!(!shown.is_empty(), "{}: shown by nothing", row[0]);
        for (name, file) in shown {
            let path = root().join("docs").join(file);
            assert!(path.is_file(), "{}: no file {file}", row[0]);
            assert!(has_test(file, &read(&path), name), "{}: no test {name} in {file}", row[0]);
        }
    }
}

#[test]
fn functions_that_are_no_tests_are_recognised() {
    let source = "#[test]\nfn one() {\n}\n\nfn two() {\n}\n\n/// Said.\n#[test]\n#[cfg(unix)]\nfn three() {\n}\n";
    for (name, is) in [("one", true), ("two", false), ("three", true), ("four", false)] {
        assert_eq!(has_test("a.rs", source, name), is, "{name}");
    }
    assert_eq!(links("[a](b.rs), [c](d.py)"), [("a", "b.rs"), ("c", "d.py")]);
}

/// Sources of the delivered code: without tests, benches, examples, build scripts.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let aside = ["target", "node_modules", "tests", "benches", "examples", "testing", "trueaxis-testing", "dist"];
        if path.is_dir() && !aside.contains(&name.as_str()) {
            sources(&path, found);
        } else if name.ends_with(".rs") && name != "build.rs" && name != "tests.rs" {
            found.push(path);
        }
    }
}

/// Every line of the delivered sources, with its file, except for a file's own tests, which are at its end.
fn lines() -> Vec<(String, String)> {
    let root = root();
    let mut files = Vec::new();
    for folder in ["crates", "firmware-sim", "desk/wasm"] {
        sources(&root.join(folder), &mut files);
    }
    assert!(files.len() > 300, "{} files", files.len());
    let of = |path: PathBuf| {
        let name = path.strip_prefix(&root).unwrap().to_string_lossy().into_owned();
        let text = read(&path).split("\n#[cfg(test)]\n").next().unwrap().to_owned();
        text.lines().map(|line| (name.clone(), line.to_owned())).collect::<Vec<_>>()
    };
    files.into_iter().flat_map(of).filter(|(_, line)| !line.trim_start().starts_with("//")).collect()
}

/// No code may use the wall clock, which can jump at any time.
#[test]
fn no_clock_but_the_monotonic_one_is_used() {
    for (file, line) in lines() {
        for clock in ["SystemTime", "UNIX_EPOCH", "ClockId::Realtime", "ClockId::Tai", "chrono::"] {
            assert!(!line.contains(clock), "{file}: {line}");
        }
    }
    let all = lines();
    assert!(all.iter().any(|(file, line)| file.contains("pace/linux.rs") && line.contains("ClockId::Monotonic")));
}

/// Files are put in place through `trueaxis_tables::output`; anything else is written to temporary folders.
#[test]
fn files_are_written_in_one_place() {
    let thrown_away = [
        ("firmware-sim/src/rs274.rs", "the interpreter's folder"),
        ("firmware-sim/src/compare/image.rs", "the emulator's folder"),
    ];
    let ways = ["fs::write(", "File::create(", "File::create_new(", ".persist(", "fs::copy(", "fs::rename("];
    let mut met = BTreeSet::new();
    for (file, line) in lines() {
        if !ways.iter().any(|way| line.contains(way)) {
            continue;
        }
        if let Some((aside, _)) = thrown_away.iter().find(|(aside, _)| *aside == file) {
            met.insert(*aside);
        } else {
            assert!(file.starts_with("crates/trueaxis-tables/src/output/"), "{file}: {line}");
            met.insert("output");
        }
    }
    assert_eq!(met.len(), 1 + thrown_away.len(), "{met:?}");
}
