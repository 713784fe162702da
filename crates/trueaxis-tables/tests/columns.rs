//! Import of positions and deviations in columns of any name.

use std::path::Path;
use trueaxis::machine::Axis;
use trueaxis_tables::error::FileError;
use trueaxis_tables::formats::columns::{Mapping, Unit, import};
use trueaxis_tables::formats::{Format, Imported};

fn mapping(columns: &str, unit: Option<Unit>) -> Mapping {
    let columns = if columns.is_empty() { Mapping::default() } else { Mapping::parse(columns).unwrap() };
    Mapping { unit, ..columns }
}

fn try_read(text: &str, axis: Option<Axis>, mapping: &Mapping) -> Result<Imported, FileError> {
    import(text, Path::new("in.csv"), axis, mapping)
}

/// The table of an axis as CSV.
fn csv(text: &str, axis: Option<Axis>, mapping: &Mapping) -> String {
    try_read(text, axis, mapping).unwrap().machine_files("m").remove(1).1
}

#[test]
fn usual_headers_are_read_as_they_stand() {
    let x = Some(Axis::X);
    let none = mapping("", None);
    let expected = "X_mm,EXX_fwd_um,EXX_rev_um\n0,0.4,1.9\n100,-2.1,3.6\n";
    for text in [
        // Positions.
        "Position (mm),Forward,Reverse\n0,0.0004,0.0019\n100,99.9979,100.0036\n",
        // Deviations, with their unit and without.
        "Position (mm),Forward (um),Reverse (um)\n0,0.4,1.9\n100,-2.1,3.6\n",
        "Position (mm),Forward,Reverse\n0,0.4,1.9\n100,-2.1,3.6\n",
        "Position [mm];Forward [mm];Reverse [mm]\n0;0,0004;0,0019\n100;-0,0021;0,0036\n",
        "Position (mm),Forward,Reverse\n0,0.0004,0.0019\n100,-0.0021,0.0036\n",
        // Descending, in another order, in inches.
        "reverse_um,forward_um,nominal_mm\n3.6,-2.1,100\n1.9,0.4,0\n",
        "Target (inch),Forward (um),Reverse (um)\n0,0.4,1.9\n3.937007874015748,-2.1,3.6\n",
    ] {
        assert_eq!(csv(text, x, &none), expected, "{text}");
        assert_eq!(
            trueaxis_tables::formats::import(Format::Columns, text, Path::new("in.csv"), x).unwrap(),
            try_read(text, x, &none).unwrap()
        );
    }
    let imported = try_read("Position (mm),Forward,Reverse\n0,0.4,1.9\n100,-2.1,3.6\n", x, &none).unwrap();
    assert_eq!(imported.notes, ["Position (mm) in mm; Forward and Reverse in um are deviations, +E"]);
}

#[test]
fn one_reading_is_valid_for_both_directions() {
    let imported =
        try_read("Commanded,Reading\n0,0.0021\n100,100.0034\n", Some(Axis::Y), &mapping("", Some(Unit::Millimetre)));
    let imported = imported.unwrap();
    assert_eq!(imported.machine_files("m")[1].1, "Y_mm,EYY_um\n0,2.1\n100,3.4\n");
    assert_eq!(imported.notes[0], "Commanded in mm; Reading in mm are positions, E = reading − position");
    assert!(imported.notes[1].contains("without lost motion, which backlash_um"), "{:?}", imported.notes);
    assert!(!imported.tables[0].1.bidirectional);
    // 0.1 and 10.0002 inches.
    let inches = csv("Commanded,Reading\n0,0.0001\n10,10.0002\n", Some(Axis::Y), &mapping("", Some(Unit::Inch)));
    assert_eq!(inches, "Y_mm,EYY_um\n0,2.54\n254,5.08\n");
}

#[test]
fn a_mapping_names_the_columns_of_any_other_header() {
    let text = "No;Pos;Fwd;Rev;Temp (C)\n1;0;0,4;1,9;20,1\n2;100;-2,1;3,6;20,2\n";
    let columns = "position=Pos,forward=Fwd,reverse=Rev";
    let imported = try_read(text, Some(Axis::Z), &mapping(columns, Some(Unit::Micrometre))).unwrap();
    assert_eq!(imported.machine_files("m")[1].1, "Z_mm,EZZ_fwd_um,EZZ_rev_um\n0,0.4,1.9\n100,-2.1,3.6\n");
    assert!(imported.notes.contains(&String::from("not read: No, Temp (C)")), "{:?}", imported.notes);
    // Without its unit, in any case.
    let named = csv("pos (mm),FWD (um)\n0,1\n10,2\n", Some(Axis::Z), &mapping("position=Pos,forward=fwd", None));
    assert_eq!(named, "Z_mm,EZZ_um\n0,1\n10,2\n");
    // The axis from its letter; angles.
    let round = csv("C (deg),Reading (arcsec)\n0,1\n90,-2\n180,3\n", None, &mapping("", None));
    assert_eq!(round, "C_deg,ECC_urad\n0,4.84813681109536\n90,-9.69627362219072\n180,14.544410433286078\n");
}

#[test]
fn what_could_be_two_things_is_refused() {
    let (x, none) = (Some(Axis::X), mapping("", None));
    for (text, axis, mapping, place, words) in [
        ("Commanded,Reading\n0,0\n10,10.1\n", x, &none, "in.csv:1: column Commanded", "--unit mm"),
        (
            "Position (mm),Forward\n0,0\n10,0.5\n",
            x,
            &none,
            "in.csv: found readings up to 0.5 without a unit",
            "--unit mm",
        ),
        ("Position (deg),Forward\n0,0\n90,3\n", Some(Axis::C), &none, "in.csv: found readings up to 3", "(arcsec)"),
        ("Position (mm),Forward (mm)\n0,0.1\n0.2,0.1\n", x, &none, "in.csv: found errors up to 0.1", "clearly one"),
        ("Position (mm),Forward (um)\n0,0\n10,1\n", None, &none, "in.csv:1: column Position (mm)", "--axis X"),
        ("X (mm),Forward (um)\n0,0\n10,1\n", Some(Axis::Y), &none, "in.csv:1: column X (mm)", "axis Y"),
        ("Position (deg),Forward (um)\n0,0\n10,1\n", x, &none, "in.csv:1: column Position (deg)", "lengths for X"),
        ("Position (mm),Forward (um)\n10,0\n10,1\n", x, &none, "in.csv:3: column position: found 10 again", "iso230-2"),
        ("Position (mm),Forward (um)\n0,0\n10,1,2\n", x, &none, "in.csv:3:", "2 as in the header"),
        ("Position (mm),Forward (um)\n0,0\n10,far\n", x, &none, "in.csv:3: column Forward (um)", "a number"),
        ("Position (mm),Forward (um)\n10,0\n", x, &none, "in.csv: found one point", "at least two"),
        (
            "Position (mm),Forward (um),Reverse\n0,0,1\n9,1,1\n",
            x,
            &none,
            "a unit in one of",
            "both columns, or of none",
        ),
        ("Position (mm),Forward (um),Temp\n0,0,1\n", x, &none, "in.csv:1: column Temp", "--columns position=NAME"),
        ("Position (mm),Forward,Reading\n0,0,1\n", x, &none, "in.csv:1: column Reading", "each once"),
        ("Position (mm)\n0\n", x, &none, "in.csv:1:", "Forward and Reverse"),
        ("0,0\n100,1\n", x, &none, "in.csv:1:", "the names of the columns in the first line"),
    ] {
        let error = try_read(text, axis, mapping).unwrap_err().to_string();
        assert!(error.contains(place) && error.contains(words), "{error}");
    }
    let text = "Pos (mm),Forwrd (um),Temp\n0,0,20\n10,1,20\n";
    for (columns, unit, words) in [
        (
            "position=Pos,forward=Forward (um)",
            None,
            "no column for --columns forward=Forward (um), needed Forwrd (um), or another of Pos (mm), Forwrd (um), Temp",
        ),
        (
            "position=Place,forward=Temp",
            None,
            "no column for --columns position=Place, needed one of Pos (mm), Forwrd (um), Temp",
        ),
        ("position=Pos,forward=Forwrd", Some(Unit::Inch), "--unit beside the unit of the column"),
    ] {
        let error = try_read(text, x, &mapping(columns, unit)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    for (columns, words) in [
        ("Pos", "found \"Pos\", needed position=NAME"),
        ("position=Pos", "found \"position=Pos\""),
        ("position=Pos,forward=", "found \"forward=\""),
        ("position=Pos,forwards=Fwd", "found \"forwards\""),
        ("position=Pos,position=P,forward=Fwd", "after another"),
    ] {
        let error = Mapping::parse(columns).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn damaged_files_do_not_panic() {
    let text = "Position (mm);Forward (um);Reverse [um]\n0;0,4;1,9\n100;-2,1;3,6\n";
    for end in 0..text.len() {
        let _ = try_read(&text[..end], Some(Axis::X), &mapping("", None));
    }
    for place in 0..text.len() {
        for damage in [b' ', b'-', b'e', b',', b'\n', b'(', b')', b'9', b'_', 0] {
            let mut bytes = text.as_bytes().to_vec();
            bytes[place] = damage;
            let _ = try_read(&String::from_utf8_lossy(&bytes), None, &mapping("", Some(Unit::Inch)));
        }
    }
}
