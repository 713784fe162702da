//! `trueaxis explain`.

use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");
const HEADER: &str = include_str!("../../trueaxis-capi/include/trueaxis.h");

/// `#define TRUEAXIS_ERROR_NULL 1` and its kind.
fn results() -> Vec<(u8, &'static str)> {
    let of = |line: &'static str| {
        let (name, number) = line.strip_prefix("#define ")?.split_once(' ')?;
        let is_result = name == "TRUEAXIS_OK" || name.starts_with("TRUEAXIS_ERROR_") && !name.ends_with("BYTES");
        is_result.then(|| Some((number.parse().ok()?, name)))?
    };
    HEADER.lines().filter_map(of).collect()
}

#[test]
fn every_result_of_the_header_is_explained_by_its_name() {
    let folder = Folder::new(TRUEAXIS);
    let results = results();
    assert!(results.len() >= 23, "{results:?}");
    for (number, name) in &results {
        let text = folder.good(&["explain", "result", &number.to_string()]);
        assert!(text.starts_with(&format!("{name}: ")) && text.ends_with('\n'), "{number} {name} {text}");
    }
    let last = results.iter().map(|(number, _)| number).max().unwrap();
    folder.bad(
        &["explain", "result", &(last + 1).to_string()],
        &["code: found 23, needed a code from 0 to 22 of the list: results"],
    );
}

#[test]
fn a_setting_is_explained_by_its_key_and_unit() {
    let folder = Folder::new(TRUEAXIS);
    // Without texts the C library writes `#22`.
    let text = folder.good(&["explain", "setting", "#22", "--axis", "X", "--found", "0.0003"]);
    assert_eq!(text, "axis.X.hysteresis_um: found 0.3\n");
    assert_eq!(folder.good(&["explain", "setting", "22"]), "axis.*.hysteresis_um\n");
    assert_eq!(folder.good(&["explain", "setting", "8"]), "location.EX0*_um\n");
    folder.bad(&["explain", "setting", "22", "--axis", "Q"], &["--axis: found Q, needed X, Y, Z, A, B or C"]);
    folder.bad(&["explain", "setting", "22", "--found", "1"], &["--found: found no axis, needed --axis too"]);
    folder.bad(&["explain", "setting", "255"], &["code: found 255, needed a code from 0 to 118 of the list: settings"]);
    folder.bad(&["explain", "fault", "3", "--found", "1"], &["--axis, --found: found a code that is not a setting's"]);
    folder.bad(&["explain", "tables", "eleven"], &["found eleven, needed a number from 0 to 255"]);
}

#[test]
fn all_codes_are_listed_by_kind() {
    let folder = Folder::new(TRUEAXIS);
    let all = folder.good(&["explain"]);
    for line in [
        "    5  the file is damaged (its CRC-32 is wrong)",
        "   11  a setting or a table is out of range: explain setting FIELD",
        "   17  a command lies outside the travel of its axis; the output holds, a stop is requested",
        "   15  made for another machine",
        "    8  growth",
    ] {
        assert!(all.lines().any(|found| found == line), "{line}\n{all}");
    }
    assert!(all.contains(&folder.good(&["explain", "learned"])), "{all}");
}
