//! Import of Renishaw's linear measurements.

use std::path::Path;
use trueaxis::machine::Axis;
use trueaxis_tables::error::FileError;
use trueaxis_tables::formats::{Format, Imported, import};

const RTL: &str = "HEADER::\r\nFile type  : rtl\r\nOwner      : Linear\r\n\r\nTARGET DATA::\r\nFiletype  : ISO\r\nTarget-count: 3\r\n\
    Targets :\r\n0.000000  100.000000 \r\n 200.500000 \r\nFlags: 0 0 2 0\r\n\r\nUSER-TEXT::\r\nMachine: mill\r\nAxis:X\r\n\r\n\
    RUNS::\r\nRun-count:4\r\n\r\nDEVIATIONS::\r\nRun Target Data:\r\n1   1      0.1\r\n1   2      1.4\r\n1   3      2\r\n\
    2   3      12.9\r\n2   2      12.2\r\n2   1      10.8\r\n3   1      0.3\r\n3   2      1.2\r\n3   3      2.4\r\n\
    4   3      13.1\r\n4   2      12.4\r\n4   1      11.0\r\n\r\nENVIRONMENT::\r\nAir temp   : 20.1\r\n\r\nEOF::\r\n";

fn read(text: &str, axis: Option<Axis>) -> Result<Imported, FileError> {
    import(Format::Rtl, text, Path::new("x.rtl"), axis)
}

#[test]
fn the_mean_of_the_runs_in_each_direction_is_the_table() {
    let expected = "X_mm,EXX_fwd_um,EXX_rev_um\n0,0.2,10.9\n100,1.3,12.3\n200.5,2.2,13\n";
    assert_eq!(read(RTL, None).unwrap().machine_files("m")[1].1, expected);
    // An axis in words is left to the caller.
    let worded = RTL.replace("Axis:X", "Axis: X travel");
    assert_eq!(read(&worded, Some(Axis::X)).unwrap().machine_files("m")[1].1, expected);
    // The same measurement of a machine whose targets descend: the first run goes in negative direction.
    let down = RTL.replace("0.000000  100.000000 \r\n 200.500000", "0.0  -100.0  -200.5");
    let down = read(&down, None).unwrap().machine_files("m")[1].1.clone();
    assert_eq!(down, "X_mm,EXX_fwd_um,EXX_rev_um\n-200.5,13,2.2\n-100,12.3,1.3\n0,10.9,0.2\n");
}

#[test]
fn damaged_measurements_are_refused_with_their_line() {
    for (from, to, axis, place, words) in [
        ("rtl", "rta", None, "x.rtl: found File type \"rta\"", "a linear measurement"),
        ("File type", "Type", None, "x.rtl: found no File type", "File type : rtl"),
        ("Axis:X", "Axis:", None, "x.rtl: found no axis", "--axis X"),
        ("Axis:X", "Axis:X", Some(Axis::Y), "x.rtl:15: column Axis", "axis Y"),
        ("Axis:X", "Axis:C", None, "x.rtl: found axis C", "a linear axis"),
        ("Target-count: 3", "Target-count: 4", None, "x.rtl:7: column Target-count", "3, as the file has"),
        ("Run-count:4", "Run-count:5", None, "x.rtl:18: column Run-count", "4, as the file has"),
        ("1   3      2", "1   4      2", None, "x.rtl:24: column Target", "1 to 3"),
        ("1   3      2", "1   1      2", None, "x.rtl:22: column Target", "one direction of travel"),
        ("1   3      2\r\n", "", None, "x.rtl:", "needed"),
        ("1   3      2", "1   3", None, "x.rtl:24:", "the numbers of the run"),
        ("1   3      2", "1   3      two", None, "x.rtl:24: column Data", "a number"),
        ("1   3      2", "1   3      2000", None, "x.rtl:24: column Data", "-1000 to 1000 um"),
        (
            "12.9\r\n2   2      12.2\r\n2   1      10.8",
            "0\r\n2   2      0\r\n2   1      0",
            None,
            "x.rtl:25: column Data",
            "zero throughout",
        ),
        ("100.000000", "far", None, "x.rtl:9: column Targets", "a number"),
        ("Run Target Data:", "Run Target:", None, "x.rtl: found no rows", "the deviations"),
    ] {
        assert!(RTL.contains(from));
        let error = read(&RTL.replacen(from, to, 1), axis).unwrap_err().to_string();
        assert!(error.contains(place) && error.contains(words), "{error}");
    }
    // The type of a file of another kind is named, also where its rows are not found.
    let error = read("HEADER::\nFile type  : ang\n", None).unwrap_err().to_string();
    assert!(error.contains("File type \"ang\""), "{error}");
    for end in 0..RTL.len() {
        let _ = read(&RTL[..end], None);
    }
    for place in 0..RTL.len() {
        for damage in [b' ', b'-', b'0', b':', b'\n', b'9', 0xff] {
            let mut bytes = RTL.as_bytes().to_vec();
            bytes[place] = damage;
            let _ = read(&String::from_utf8_lossy(&bytes), Some(Axis::X));
        }
    }
}
