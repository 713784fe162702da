//! Standard uncertainties: the reader reads them, the compiler omits them, and edits preserve them.

use std::path::Path;
use trueaxis::machine::Axis;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::{Format, import};
use trueaxis_tables::uncertainty::Uncertainties;
use trueaxis_tables::{Change, Machine, Setting, change, compile, table_texts};

const PLAIN: &str =
    "name = \"u\"\nchain = \"w X' b C t\"\n[axis.X]\ntable = \"x.csv\"\n[axis.C]\ntravel_deg = [-180, 180]\n";
const STATED: &str = "
[uncertainty] # of the laser
device_um_per_m = 0.6
misalignment_mm = 0.5
temperature_difference_k = -1.5
degrees_of_freedom = 20
[uncertainty.location]
C0Y_urad = 3
EX0C_um = 2
[axis.X.uncertainty]
scale_ppm = 1
EXX_um = 0.25
EAX_urad = 4
[axis.C.uncertainty]
repeatability_urad = 5
";
const TABLE: &str = "X_mm,EXX_um,EYX_um\n0,1,2\n10,2,2\n";
const WITH_POINTS: &str = "X_mm,EXX_um,EYX_um,EYX_u_um\n0,1,2,0.5\n10,2,2,0.75\n";

fn files(machine: &str, table: &str) -> Memory {
    Memory::new([(Path::new("machine.toml"), machine), (Path::new("x.csv"), table)])
}

fn read(files: &Memory) -> Uncertainties {
    Uncertainties::read_from(files, Path::new("machine.toml")).unwrap()
}

#[test]
fn stated_uncertainties_are_read_in_their_units_and_no_others_assumed() {
    let found = read(&files(&format!("{PLAIN}{STATED}"), WITH_POINTS));
    assert_eq!(found.instrument.device_per_length, Some(0.6e-6));
    assert_eq!((found.instrument.device, found.instrument.eve), (None, None));
    assert_eq!(found.instrument.misalignment, Some(0.5));
    assert_eq!(found.instrument.temperature_difference_k, Some(-1.5));
    assert_eq!(found.instrument.degrees_of_freedom, Some(20.0));
    assert_eq!(found.location.squareness, [None, None, Some(3e-6)]);
    assert_eq!(found.location.rotary[2], [Some(2e-3), None, None, None, None, None]);
    let x = found.of(Axis::X).unwrap();
    assert_eq!((x.scale, x.columns[0], x.columns[3]), (Some(1e-6), Some(0.25e-3), Some(4e-6)));
    assert_eq!(x.points[1].as_deref(), Some(&[0.5e-3, 0.75e-3][..]));
    assert_eq!((x.of_point(0, 1), x.of_point(1, 1), x.of_point(2, 0)), (Some(0.25e-3), Some(0.75e-3), None));
    assert_eq!(found.of(Axis::C).unwrap().repeatability, Some(5e-6));
    assert!(found.of(Axis::Y).is_none());
}

#[test]
fn nothing_of_it_is_compiled() {
    let machine = |files: &Memory| Machine::read_from(files, Path::new("machine.toml"), &mut |_| {}).unwrap();
    let (plain, stated) = (machine(&files(PLAIN, TABLE)), machine(&files(&format!("{PLAIN}{STATED}"), WITH_POINTS)));
    assert_eq!(plain, stated);
    assert_eq!(compile(&plain).unwrap(), compile(&stated).unwrap());
}

#[test]
fn edits_keep_it() {
    let text = format!("{PLAIN}{STATED}");
    let before = files(&text, WITH_POINTS);
    let key = Change::Key { key: "axis.X.uncertainty.EXX_um".into(), value: Some(Setting::Number(0.5)) };
    let edited = change(&before, Path::new("machine.toml"), &key).unwrap();
    assert_eq!(edited.files[0].1, text.replace("EXX_um = 0.25", "EXX_um = 0.5"));
    // A new row gets the uncertainty of the row after it.
    let insert = Change::Insert { axis: Axis::X, position: 5.0 };
    let edited = change(&before, Path::new("machine.toml"), &insert).unwrap();
    assert_eq!(edited.files[0].1, "X_mm,EXX_um,EYX_um,EYX_u_um\n0,1,2,0.5\n5,1.5,2,0.75\n10,2,2,0.75\n");
    let column = &table_texts(&before, Path::new("machine.toml")).unwrap()[0].columns[3];
    assert_eq!((column.component, column.forward, column.reverse), (Some(1), false, false));
    // A new table: the uncertainties stated for the old one stay, and a note says so.
    let imported = import(Format::from_name("isg").unwrap(), "X EXX\n0 0\n10 0.001\n", Path::new("f"), None).unwrap();
    let edited = imported.edit(&before, Path::new("machine.toml")).unwrap();
    assert!(edited.files.iter().all(|(name, new)| name != Path::new("machine.toml") || new.contains(STATED)));
    assert!(edited.notes.iter().any(|note| note.contains("[axis.X.uncertainty] stays")), "{:?}", edited.notes);
}

#[test]
fn errors_name_their_line() {
    for (line, needed) in [
        ("eve_um = -0.1", "0 to 1000 um"),
        ("device_um = \"0.1\"", "a number"),
        ("degrees_of_freedom = 0", "1 to 1e9"),
        ("eve_mm = 1", "eve_um, or another of device_um_per_m, device_um"),
    ] {
        let files = files(&format!("{PLAIN}[uncertainty]\n{line}\n"), TABLE);
        let error = Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).unwrap_err();
        assert_eq!(error.line, Some(8), "{error}");
        assert!(error.needed.contains(needed) && error.column.is_some(), "{error}");
    }
    // A rotary axis has no scale in ppm.
    let files = files(&format!("{PLAIN}[axis.C.uncertainty]\nscale_ppm = 1\n"), TABLE);
    let error = Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).unwrap_err();
    assert_eq!(error.column.as_deref(), Some("axis.C.uncertainty.scale_ppm"));
}

const CORRELATED: &str = "
[[uncertainty.correlation]]
between = [\"uncertainty.location.C0Y_urad\", \"axis.X.uncertainty.scale_ppm\"] # by one ring
coefficient = -0.6
[[uncertainty.correlation]]
between = [\"uncertainty.location.EX0C_um\", \"uncertainty.location.C0Y_urad\"]
coefficient = 0.3
";

#[test]
fn correlations_are_read_and_edits_keep_them() {
    let text = format!("{PLAIN}{STATED}{CORRELATED}");
    let before = files(&text, TABLE);
    let found = read(&before).correlations;
    let c0y = String::from("uncertainty.location.C0Y_urad");
    assert_eq!(found.len(), 2);
    assert_eq!(found[0].coefficient, -0.6);
    assert!(found[0].between.contains(&c0y) && found[0].between.contains(&"axis.X.uncertainty.scale_ppm".into()));
    assert!(found[1].between.contains(&"uncertainty.location.EX0C_um".into()) && found[1].coefficient == 0.3);
    // Another standard uncertainty keeps them; a removed one, or zero, takes its own along.
    let set = |key: &str, value: Option<f64>| {
        let key = Change::Key { key: key.into(), value: value.map(Setting::Number) };
        change(&before, Path::new("machine.toml"), &key).unwrap().files.remove(0).1
    };
    assert_eq!(set("axis.X.uncertainty.scale_ppm", Some(2.0)), text.replace("scale_ppm = 1\n", "scale_ppm = 2.0\n"));
    for value in [None, Some(0.0)] {
        let without = set("axis.X.uncertainty.scale_ppm", value);
        assert_eq!(without.matches("[[uncertainty.correlation]]").count(), 1, "{without}");
        assert!(without.contains("EX0C_um\", ") && !without.contains("coefficient = -0.6"), "{without}");
    }
    assert!(!set("uncertainty.location.C0Y_urad", None).contains("correlation"));
}

#[test]
fn impossible_correlations_name_their_line() {
    let [x, c0y, ex0c] =
        ["axis.X.uncertainty.scale_ppm", "uncertainty.location.C0Y_urad", "uncertainty.location.EX0C_um"];
    // Line of the error after the machine's text.
    let refused = |entries: &[(&str, &str, &str)]| {
        let of = |(one, other, r): &(&str, &str, &str)| {
            format!("[[uncertainty.correlation]]\nbetween = [\"{one}\", \"{other}\"]\ncoefficient = {r}\n")
        };
        let text = format!("{PLAIN}{STATED}{}", entries.iter().map(of).collect::<String>());
        let error = Machine::read_from(&files(&text, TABLE), Path::new("machine.toml"), &mut |_| {}).unwrap_err();
        let start = format!("{PLAIN}{STATED}").lines().count() as u32;
        (error.line.unwrap() - start, error.column.unwrap_or_default(), error.needed)
    };
    for (entries, line, needed) in [
        (&[(x, "uncertainty.location.C0Y_um", "0.5")][..], 2, "uncertainty.location.C0Y_urad, or another of"),
        (&[(x, "scale Y", "0.5")], 2, "one of uncertainty.location.A0Z_urad"),
        (&[(x, "axis.X.uncertainty.backlash_um", "0.5")], 2, "axis.X.uncertainty.backlash_um stated above zero"),
        (&[(x, "axis.X.uncertainty.EXX_um", "0.5")], 2, "every point of a table has its own value"),
        (&[(x, "uncertainty.misalignment_mm", "0.5")], 2, "every axis has its own value"),
        (&[(x, "axis.C.uncertainty.repeatability_urad", "0.5")], 2, "every approach has its own value"),
        (&[(x, x, "1")], 2, "two different keys"),
        (&[(x, c0y, "1.01")], 3, "a coefficient of correlation, -1 to 1"),
        (&[(x, c0y, "\"high\"")], 3, "a number"),
        (&[(x, c0y, "0.5"), (c0y, x, "0.5")], 5, "each pair once, this one is in line"),
        (&[(x, c0y, "0.7"), (c0y, ex0c, "0.7"), (x, ex0c, "-0.95")], 9, "their matrix has the eigenvalue -0."),
    ] {
        let (found, column, said) = refused(entries);
        assert!(said.contains(needed) && column.starts_with("uncertainty.correlation."), "{needed}: {column} {said}");
        assert_eq!(found, line, "{needed}: {said}");
    }
    let (_, _, said) = refused(&[(x, c0y, "0.7"), (c0y, ex0c, "0.7"), (x, ex0c, "-0.95")]);
    assert!([x, c0y, ex0c].iter().all(|name| said.contains(name)) && !said.contains("A0Z"), "{said}");
    let whole = |body: &str| {
        let text = format!("{PLAIN}{STATED}[[uncertainty.correlation]]\n{body}\n");
        Machine::read_from(&files(&text, TABLE), Path::new("machine.toml"), &mut |_| {}).map(|_| ())
    };
    assert!(whole(&format!("between = [\"{x}\", \"{c0y}\"]\ncoefficient = -1")).is_ok());
    for (body, needed) in [
        (format!("between = [\"{x}\"]\ncoefficient = 0.5"), "the keys of two standard uncertainties"),
        ("coefficient = 0.5".into(), "the keys of two standard uncertainties"),
        (format!("between = [\"{x}\", \"{c0y}\"]"), "a coefficient of correlation"),
        (format!("between = [\"{x}\", \"{c0y}\"]\ncoefficient = 0.5\nr = 1"), "one of between, coefficient"),
    ] {
        let error = whole(&body).unwrap_err();
        assert!(error.needed.contains(needed) && error.line.is_some(), "{error}");
    }
}

#[test]
fn figures_of_drive_and_friction_are_read_with_their_degrees_of_freedom() {
    let servo = |axis: &str, micro: &str, unit: &str| {
        format!(
            "[axis.{axis}.drive]\nposition_gain_per_s = 50\nvelocity_gain_per_s = 400\nreset_time_s = 0.01\n\
             [axis.{axis}.drive.uncertainty]\nposition_gain_per_s = 2\ndead_time_s = 0\ndegrees_of_freedom = 7\n\
             [axis.{axis}.friction]\ncoulomb_{unit}_per_s = 0.4\npresliding_{micro} = 5\n\
             [axis.{axis}.friction.uncertainty]\ncoulomb_{unit}_per_s = 0.04\npresliding_{micro} = 1\n"
        )
    };
    let found = read(&files(&format!("{PLAIN}{}{}", servo("X", "um", "mm"), servo("C", "urad", "deg")), TABLE));
    for (axis, presliding) in [(Axis::X, 1e-3), (Axis::C, 1e-6_f64.to_degrees())] {
        let own = found.of(axis).unwrap();
        let stated = [Some(2.0), None, None, None, Some(0.0), Some(0.04), Some(presliding), None, None, None];
        for (found, stated) in own.servo.iter().zip(stated) {
            assert!((found.unwrap_or(-1.0) - stated.unwrap_or(-1.0)).abs() < 1e-15, "{axis:?}: {:?}", own.servo);
        }
        assert_eq!(own.servo_degrees_of_freedom, [Some(7.0), None]);
    }
    let unknown = format!("{PLAIN}{}", servo("X", "um", "mm").replace("dead_time_s", "gain"));
    let error = Machine::read_from(&files(&unknown, TABLE), Path::new("machine.toml"), &mut |_| {}).unwrap_err();
    assert_eq!(error.line, Some(13), "{error}");
}
