//! The crate's own files as written by an import.

use std::fs;
use std::path::Path;
use trueaxis::machine::{Axis, Row};
use trueaxis_tables::Table;
use trueaxis_tables::formats::{Format, import, write_axis_csv};
use trueaxis_testing::noise::Noise;

/// Reads a CSV as the format specifies: µm / 1e3, µrad / 1e6.
fn parse(text: &str, axis: Axis) -> (String, Table) {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut given = [false; 6];
    let mut rows = Vec::new();
    for line in lines {
        let fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        let mut row = Row { position: fields[0], forward: [0.0; 6], reverse: [0.0; 6] };
        for (name, value) in header.iter().zip(&fields).skip(1) {
            let component = Axis::from_letter(name.chars().nth(1).unwrap()).unwrap().index();
            assert_eq!(name.chars().nth(2), Some(axis.letter()));
            given[component] = true;
            let value = value / if name.ends_with("_um") { 1e3 } else { 1e6 };
            if !name.contains("_rev_") {
                row.forward[component] = value;
            }
            if !name.contains("_fwd_") {
                row.reverse[component] = value;
            }
        }
        rows.push(row);
    }
    let bidirectional = rows.iter().any(|row| row.forward != row.reverse);
    (header.join(","), Table { given, bidirectional, rows })
}

#[test]
fn every_sample_table_is_written_as_it_was_read() {
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables");
    for (machine, axes) in [("mill-3axis", "xyz"), ("mill-5axis", "xyzac")] {
        for letter in axes.chars() {
            let text = fs::read_to_string(samples.join(machine).join(format!("{letter}.csv"))).unwrap();
            let axis = Axis::from_letter(letter.to_ascii_uppercase()).unwrap();
            let written = write_axis_csv(&parse(&text, axis).1, axis);
            let plain: String =
                text.lines().filter(|line| !line.starts_with('#')).map(|line| format!("{line}\n")).collect();
            assert_eq!(written, plain, "{machine} {letter}");
        }
    }
}

/// Any value that a CSV can represent reads back bit for bit after writing; others to 1 unit in the last place.
#[test]
fn numbers_read_back_identical() {
    let mut noise = Noise::new(7);
    let mut off = 0;
    for k in 0..20_000 {
        let digits = k % 17;
        let micro: f64 = format!("{:.digits$e}", noise.signed() * 10_f64.powi(k as i32 % 7 - 2)).parse().unwrap();
        let from_file = [micro / 1e3, noise.signed() / 3.0, 0.0, micro / 1e6, noise.signed() * 1e-4, 0.0];
        let row = |position: f64| Row { position, forward: from_file, reverse: from_file };
        let table = Table { given: [true; 6], bidirectional: false, rows: vec![row(noise.signed() * 1e3), row(1e4)] };
        let back = parse(&write_axis_csv(&table, Axis::Z), Axis::Z).1;
        for (written, read) in table.rows.iter().zip(&back.rows) {
            assert_eq!(written.position, read.position);
            assert_eq!(written.forward[0].to_bits(), read.forward[0].to_bits());
            assert_eq!(written.forward[3].to_bits(), read.forward[3].to_bits());
            for component in [1, 4] {
                let (value, read) = (written.forward[component], read.forward[component]);
                assert!(read == value || read == value.next_up() || read == value.next_down());
                off += usize::from(read != value);
            }
        }
    }
    // 2 to 10 % of the others lie between the quotients of two neighbouring doubles.
    assert!(off < 80_000 / 10, "{off}");
}

#[test]
fn directions_and_columns() {
    let row = |position: f64, forward: [f64; 6], reverse: [f64; 6]| Row { position, forward, reverse };
    let table = Table {
        given: [true, false, false, true, false, false],
        bidirectional: true,
        rows: vec![
            row(-120.0, [0.0015, 0.0, 0.0, 2e-6, 0.0, 0.0], [0.0015, 0.0, 0.0, 1.5e-6, 0.0, 0.0]),
            row(0.5, [-1e-6, 0.0, 0.0, -0.0, 0.0, 0.0], [-1e-6, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ],
    };
    let expected = "A_deg,EXA_um,EAA_fwd_urad,EAA_rev_urad\n-120,1.5,2,1.5\n0.5,-0.001,0,0\n";
    assert_eq!(write_axis_csv(&table, Axis::A), expected);
}

#[test]
fn an_import_becomes_a_machine() {
    let text = "A0Z X0C EAC\n2e-5 0.0125 0\n#\n";
    let text =
        text.replace(" EAC", " A0C") + "X EXX EYX\n-100 0.0021 0\n100.5 -0.003 0.001\n#\nC ECC\n0 1e-5\n360 1e-5\n";
    let imported = import(Format::Isg, &text, Path::new("v.csv"), None).unwrap();
    let files = imported.machine_files("an \"old\" mill");
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["machine.toml", "x.csv", "c.csv"]);
    let machine: toml::Value = toml::from_str(&files[0].1).unwrap();
    assert_eq!(machine["name"].as_str(), Some("an \"old\" mill"));
    // Y has no table, and corrects EYX.
    assert_eq!(machine["chain"].as_str(), Some("w b X Y C t"));
    assert_eq!(machine["axis"]["X"]["table"].as_str(), Some("x.csv"));
    assert_eq!(machine["axis"]["X"]["travel_mm"][1].as_float(), Some(100.5));
    assert!(machine["axis"]["C"].get("travel_deg").is_none());
    assert_eq!(machine["location"]["A0Z_urad"].as_float(), Some(20.0));
    assert_eq!(machine["location"]["EX0C_um"].as_float(), Some(12.5));
    assert_eq!(machine["location"].as_table().unwrap().len(), 2);
    assert_eq!(files[1].1, "X_mm,EXX_um,EYX_um\n-100,2.1,0\n100.5,-3,1\n");
    assert_eq!(files[2].1, "C_deg,ECC_urad\n0,10\n360,10\n");
    let long = imported.machine_files(&"ä".repeat(80));
    let long: toml::Value = toml::from_str(&long[0].1).unwrap();
    assert_eq!(long["name"].as_str().unwrap().len(), 64);
}
