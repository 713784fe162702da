//! Single changes to a machine's files: the surrounding text stays, and a refused change leaves the files as they are.

use std::path::Path;
use trueaxis::machine::Axis;
use trueaxis_tables::files::{Memory, Source};
use trueaxis_tables::{Change, Machine, Setting, change, changes, table_texts};

const DESCRIPTION: &str = "# The mill of hall 2.\nname = \"mill\"\nchain = \"w X' b C t\"  # table and spindle\n\n\
    [axis.X]\ntable = \"x.csv\"\ninterpolation = \"cubic\"\nbacklash_um = 1.5 # by dial gauge\n\n[axis.C]\ntable = \"c.csv\"\n";
const X: &str =
    "# laser, 20 C\nX_mm, EXX_um ,EYX_fwd_um,EYX_rev_um\n0, 1.0 ,0,0.5\n\n# middle\n10,2.5,1,1.5\n20,-3,0,0.5\n";
const C: &str = "C_deg;EXC_um\r\n0;\"1,5\"\r\n180;2,25\r\n360;1,5\r\n";

fn files() -> Memory {
    Memory::new([("machine.toml", DESCRIPTION), ("x.csv", X), ("c.csv", C)])
}

/// The single file that a change produces.
fn changed(of: &Change) -> (String, String) {
    let edited = change(&files(), Path::new("machine.toml"), of).unwrap();
    let [(name, text)] = edited.files.try_into().unwrap();
    (name.display().to_string(), text)
}

fn refused(of: &Change) -> String {
    change(&files(), Path::new("machine.toml"), of).unwrap_err().to_string()
}

fn point(axis: Axis, column: &str, row: usize, value: f64) -> Change {
    Change::Point { axis, column: column.into(), row, value, also: Vec::new() }
}

fn key(key: &str, value: Setting) -> Change {
    Change::Key { key: key.into(), value: Some(value) }
}

#[test]
fn a_point_changes_its_field_and_nothing_else() {
    let new = X.replace("0, 1.0 ,0,0.5", "0, -1.25 ,0,0.5");
    assert_eq!(changed(&point(Axis::X, "EXX_um", 0, -1.25)), ("x.csv".into(), new));
    assert_eq!(changed(&point(Axis::X, "EYX_rev_um", 2, 7.0)).1, X.replace("20,-3,0,0.5", "20,-3,0,7"));
    assert_eq!(changed(&point(Axis::X, "X_mm", 1, 9.5)).1, X.replace("10,2.5", "9.5,2.5"));
}

/// Positions that cross on the way to a table in order; only the result is checked, and a refused one changes nothing.
#[test]
fn several_changes_are_checked_as_one() {
    let both = [
        point(Axis::X, "X_mm", 0, 12.0),
        point(Axis::X, "X_mm", 1, 15.0),
        key("axis.X.backlash_um", Setting::Number(2.0)),
    ];
    refused(&both[0]);
    let edited = changes(&files(), Path::new("machine.toml"), &both).unwrap();
    let named: Vec<_> = edited.files.iter().map(|(name, text)| (name.to_str().unwrap(), text.as_str())).collect();
    let table = X.replace("0, 1.0 ,0,0.5", "12, 1.0 ,0,0.5").replace("10,2.5", "15,2.5");
    let description = DESCRIPTION.replace("backlash_um = 1.5", "backlash_um = 2.0");
    assert_eq!(named, [("x.csv", table.as_str()), ("machine.toml", description.as_str())]);
    assert!(changes(&files(), Path::new("machine.toml"), &both[..1]).is_err());
    assert!(changes(&files(), Path::new("machine.toml"), &[]).unwrap().files.is_empty());
}

#[test]
fn both_directions_change_as_one() {
    let also = vec![(String::from("EYX_rev_um"), -4.5)];
    let both = Change::Point { axis: Axis::X, column: "EYX_fwd_um".into(), row: 1, value: -5.0, also };
    assert_eq!(changed(&both).1, X.replace("10,2.5,1,1.5", "10,2.5,-5,-4.5"));
}

#[test]
fn separators_decimal_commas_quotes_and_line_ends_stay() {
    assert_eq!(changed(&point(Axis::C, "EXC_um", 1, -0.5)).1, C.replace("2,25", "-0,5"));
    // Both ends of the circle are the same point.
    let new = C.replace("\"1,5\"", "\"4,75\"").replace("360;1,5", "360;4,75");
    assert_eq!(changed(&point(Axis::C, "EXC_um", 0, 4.75)).1, new);
    assert_eq!(changed(&point(Axis::C, "EXC_um", 2, 4.75)).1, new);
    let line = changed(&Change::Insert { axis: Axis::C, position: 90.0 }).1;
    assert_eq!(line, C.replace("180;", "90;1,875\r\n180;"));
}

#[test]
fn an_inserted_row_lies_on_the_curve_that_the_step_looks_up() {
    let text = changed(&Change::Insert { axis: Axis::X, position: 5.0 }).1;
    let row = text.lines().find(|line| line.starts_with("5,")).unwrap();
    assert_eq!(text.replace(&format!("{row}\n"), ""), X);
    // The three-point end slopes 1.5 − (−5.5 − 1.5)... by hand: d0 = 0.15, d1 = −0.55, m0 = (3·0.15 + 0.55)/2 = 0.5 limited
    // to 3 d0 = 0.45, m1 = 0 at the top: E(5) = 1 + 10·(0.5·0.45 + 0.25·(0.45 − 0.9) + 0.125·(0.45 − 0.3)) = 2.3125.
    assert_eq!(row.split(',').nth(1), Some("2.313"));
    assert!(changed(&Change::Insert { axis: Axis::X, position: 30.0 }).1.ends_with("\n30,-3,0,0.5\n"));
    assert_eq!(changed(&Change::Remove { axis: Axis::X, row: 1 }).1, X.replace("10,2.5,1,1.5\n", ""));
}

#[test]
fn changes_that_the_controller_would_refuse_are_refused_with_their_line() {
    let begins = |change: &Change, with: &str| {
        let error = refused(change);
        assert!(error.starts_with(with), "{error}");
    };
    begins(
        &point(Axis::X, "X_mm", 1, 25.0),
        "x.csv:7: column X_mm: found 20, needed a position above that of the line before",
    );
    begins(&point(Axis::X, "EXX_um", 1, f64::NAN), "x.csv:6: column EXX_um: found \"NaN\", needed a finite number");
    begins(&point(Axis::X, "EXX_um", 3, 1.0), "x.csv: found row 4, needed one of its 3 rows");
    let last = format!("x.csv: found row {}, needed one of its 3 rows", usize::MAX);
    begins(&point(Axis::X, "EXX_um", usize::MAX, 1.0), &last);
    let columns = "X_mm EXX_um EYX_fwd_um EYX_rev_um";
    begins(&point(Axis::X, "EZX_um", 0, 1.0), &format!("x.csv: found no column \"EZX_um\", needed one of {columns}"));
    let backlash = key("axis.X.backlash_um", Setting::Number(1e9));
    begins(&backlash, "machine.toml:8: key axis.X.backlash_um: found 1000000000.0, needed ");
    let unknown = key("axis.Y.backlash_um", Setting::Number(1.0));
    begins(&unknown, "machine.toml:13: key axis.Y: found ");
}

#[test]
fn a_key_keeps_comments_and_order() {
    let new = DESCRIPTION.replace("backlash_um = 1.5 # by", "backlash_um = 2.75 # by");
    assert_eq!(changed(&key("axis.X.backlash_um", Setting::Number(2.75))), ("machine.toml".into(), new));
    let text = changed(&key("axis.X.thermal.expansion_um_per_m_k", Setting::Number(11.5))).1;
    let read = Machine::read_from(&over(&text), Path::new("machine.toml"), &mut |_| {}).unwrap();
    assert_eq!(read.settings.axis(Axis::X).unwrap().thermal.expansion_per_k, 11.5e-6);
    assert_eq!(text.replace("\n[axis.X.thermal]\nexpansion_um_per_m_k = 11.5\n", ""), DESCRIPTION);
    let text = changed(&key("location.C0Y_urad", Setting::Number(-12.0))).1;
    assert_eq!(text, format!("{DESCRIPTION}\n[location]\nC0Y_urad = -12.0\n"));
    let text = changed(&Change::Key { key: "axis.X.interpolation".into(), value: None }).1;
    assert_eq!(text, DESCRIPTION.replace("interpolation = \"cubic\"\n", ""));
}

fn over(description: &str) -> Memory {
    Memory::new([("machine.toml", description), ("x.csv", X), ("c.csv", C)])
}

#[test]
fn tables_are_given_in_the_units_of_their_files() {
    let tables = table_texts(&files(), Path::new("machine.toml")).unwrap();
    assert_eq!(tables.iter().map(|table| table.axis).collect::<Vec<_>>(), [Axis::X, Axis::C]);
    assert_eq!(tables[1].rows, [[0.0, 1.5], [180.0, 2.25], [360.0, 1.5]]);
    assert_eq!(tables[0].lines, [3, 6, 7]);
    let own: Vec<_> = tables[0].columns.iter().map(|c| (c.component, c.forward, c.reverse)).collect();
    assert_eq!(own, [(None, false, false), (Some(0), true, true), (Some(1), true, false), (Some(1), false, true)]);
    assert!(files().read(Path::new("c.csv")).is_ok());
}

#[test]
fn a_change_reads_as_json() {
    let text = "{\"change\": \"point\", \"axis\": \"X\", \"column\": \"EXX_um\", \"row\": 0, \"value\": -1.25}";
    assert_eq!(serde_json::from_str::<Change>(text).unwrap(), point(Axis::X, "EXX_um", 0, -1.25));
    let text = "{\"change\": \"key\", \"key\": \"tool_mm\", \"value\": [0, 0, -5.5]}";
    let numbers = Setting::Numbers(vec![0.0, 0.0, -5.5]);
    assert_eq!(serde_json::from_str::<Change>(text).unwrap(), key("tool_mm", numbers));
}
