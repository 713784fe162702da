//! Additions of a calibration to a machine's files.

use std::path::Path;
use trueaxis::Axis;
use trueaxis_tables::files::Memory;
use trueaxis_tables::finding::{Finding, Known, table};
use trueaxis_tables::uncertainty::{Correlation, Uncertainties};
use trueaxis_tables::{Additions, Machine};

const MACHINE: &str = "# mine\nname = \"m\"\nchain = \"w X' Y' b Z t\"\n[axis.Y]\ntable = \"y.csv\" # kept\nbacklash_um = 1.5\n\
                       travel_mm = [0.0, 100.0]\n[axis.X]\ntravel_mm = [0.0, 100.0]\n[axis.Z]\ntravel_mm = [-50.0, 0.0]\n\
                       [location]\nC0Y_urad = 10.0 # before\n";

/// Translations without rotations.
fn along([x, y, z]: [f64; 3]) -> [f64; 6] {
    [x, y, z, 0.0, 0.0, 0.0]
}

/// A finding to be added to the stated value.
fn moved(key: &str, value: f64, uncertainty: f64) -> Finding {
    let found = Known { value, uncertainty: Some(uncertainty), degrees_of_freedom: None };
    Finding { key: key.into(), found, on_top: true, moved: true, ..Finding::default() }
}

#[test]
fn errors_are_added_and_everything_else_stays() {
    let files = Memory::new([("machine.toml", MACHINE), ("y.csv", "Y_mm,EYY_um,ECY_urad\n0,1,5\n40,2,5\n100,4,5\n")]);
    let additions = Additions {
        curves: vec![
            (Axis::X, vec![(0.0, [0.0; 6]), (100.0, along([0.01, 0.002, 0.0]))]),
            (Axis::Y, vec![(0.0, [0.0; 6]), (50.0, along([0.0, 0.005, 0.0])), (100.0, along([0.0, 0.01, 0.001]))]),
        ],
        findings: vec![moved("location.C0Y_urad", 5.0, 0.5), moved("axis.Y.backlash_um", 2.1, 0.2)],
        ..Additions::default()
    };
    let edited = additions.edit(&files, Path::new("machine.toml")).unwrap();
    let file = |name: &str| edited.files.iter().find(|(own, _)| own == Path::new(name)).map(|(_, text)| text.as_str());
    let text = file("machine.toml").unwrap();
    let parts = [
        "# mine\n",
        "table = \"y.csv\" # kept",
        "backlash_um = 3.6",
        "C0Y_urad = 15.0 # before",
        "[axis.Y.uncertainty]\nbacklash_um = 0.2\n",
        "[uncertainty.location]\nC0Y_urad = 0.5\n",
    ];
    for part in parts {
        assert!(text.contains(part), "{part} in {text}");
    }
    assert_eq!(file("x.csv").unwrap(), "X_mm,EXX_um,EYX_um\n0,0,0\n100,10,2\n");
    // At 40 mm 4 µm are added; the new point at 50 mm has the table's interpolated value.
    let table = "Y_mm,EYY_um,EZY_um,ECY_urad\n0,1,0,5\n40,6,0,5\n50,7.33333,0,5\n100,14,1,5\n";
    assert_eq!(file("y.csv").unwrap(), table);
    let all = [("y.csv", file("y.csv").unwrap()), ("x.csv", file("x.csv").unwrap()), ("machine.toml", text)];
    let machine = Machine::read_from(&Memory::new(all), Path::new("machine.toml"), &mut |_| {}).unwrap();
    assert!((machine.settings.location.c0y - 15e-6).abs() < 1e-15);
}

#[test]
fn a_machine_without_tables_is_one_without_errors() {
    let bare = "name = \"m\"\nchain = \"w X' b Z t\"\n[axis.X]\ntravel_mm = [0.0, 100.0]\n";
    let files = Memory::new([("machine.toml", bare)]);
    let machine = Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).unwrap();
    assert!(machine.tables.iter().all(Option::is_none));
    let too_much = Additions { findings: vec![moved("axis.X.backlash_um", 5000.0, 1.0)], ..Additions::default() };
    let refused = too_much.edit(&files, Path::new("machine.toml")).unwrap_err().to_string();
    assert!(refused.contains("axis.X.backlash_um") && refused.contains("nothing is written"), "{refused}");
}

#[test]
fn uncertainties_of_the_points_stay() {
    let csv = "X_mm,EXX_um,EXX_u_um,ECX_urad,ECX_u_urad\n0,0,1,5,2\n100,4,3,5,2\n";
    let toml = "name = \"m\"\nchain = \"w X' b t\"\n[axis.X]\ntable = \"x.csv\"\n";
    let files = Memory::new([("machine.toml", toml), ("x.csv", csv)]);
    let curve = vec![(0.0, [0.0; 6]), (50.0, along([0.001, 0.0, 0.0])), (100.0, along([0.002, 0.0, 0.0]))];
    let additions = Additions { curves: vec![(Axis::X, curve)], ..Additions::default() };
    let edited = additions.edit(&files, Path::new("machine.toml")).unwrap();
    let (_, text) = edited.files.iter().find(|(name, _)| name == Path::new("x.csv")).unwrap();
    assert_eq!(text, "X_mm,EXX_um,ECX_urad,EXX_u_um,ECX_u_urad\n0,0,5,1,2\n50,3,5,2,2\n100,6,5,3,2\n");
}

/// The control over-compensates one axis: its backlash is not written, with the cause as the reason; everything else is.
#[test]
fn lost_motion_below_zero_is_named_and_the_rest_is_given() {
    let additions = Additions {
        findings: vec![
            moved("location.C0Y_urad", 20.0, 0.3),
            moved("axis.X.backlash_um", -7.8, 0.1),
            moved("axis.Y.backlash_um", 2.0, 0.2),
        ],
        ..Additions::default()
    };
    let into = |keys: &str| {
        let toml = format!("name = \"m\"\nchain = \"w b X Y t\"\n[axis.X]\n{keys}");
        let (files, name) = (Memory::new([("machine.toml", toml)]), Path::new("machine.toml"));
        let edited = additions.edit(&files, name).unwrap();
        (edited.files.last().unwrap().1.clone(), table(&additions.decide(&files, name).unwrap()))
    };
    let (text, notes) = into("");
    assert!(text.contains("C0Y_urad = 20.0") && text.contains("backlash_um = 2.0"), "{text}");
    assert!(!text.contains("-7.8") && !text.contains("axis.X.uncertainty") && !text.contains("hysteresis"), "{text}");
    assert!(text.contains("[axis.Y.uncertainty]"), "{text}");
    let said = notes.lines().find(|line| line.starts_with("axis.X.backlash_um")).unwrap();
    assert!(said.contains("-7.8 (u 0.1)") && said.contains("the control takes up too much"), "{notes}");
    // With a backlash already corrected here, 7.8 µm less remains; a sufficient hysteresis allows a negative backlash.
    assert!(into("backlash_um = 10\n").0.contains("backlash_um = 2.2"));
    assert!(into("hysteresis_um = 9\n").0.contains("backlash_um = -7.8"));
}

/// The hysteresis of a rotary axis, in degrees in the core, is compared in microradians.
#[test]
fn lost_motion_of_a_rotary_axis_is_compared_with_its_hysteresis() {
    let additions = Additions { findings: vec![moved("axis.C.backlash_urad", -20.0, 0.1)], ..Additions::default() };
    let written = |hysteresis: f64| {
        let toml = format!("name = \"m\"\nchain = \"w C' b X Y Z t\"\n[axis.C]\nhysteresis_urad = {hysteresis}\n");
        let decisions = additions.decide(&Memory::new([("machine.toml", toml)]), Path::new("machine.toml")).unwrap();
        decisions[0].written.map(|written| written.value)
    };
    assert_eq!(written(10.0), None);
    assert_eq!(written(30.0), Some(-20.0));
}

/// A location error that cancels is set to zero; one below a nanoradian counts as zero.
#[test]
fn location_errors_that_change_are_set() {
    let toml = "name = \"m\"\nchain = \"w b X Y Z t\"\n[location]\nC0Y_urad = 10\nA0Z_urad = 3\n";
    let with = |findings: Vec<Finding>| {
        let additions = Additions { findings, ..Additions::default() };
        let edited = additions.edit(&Memory::new([("machine.toml", toml)]), Path::new("machine.toml")).unwrap();
        edited.files.last().map(|(_, text)| text.clone())
    };
    let none = Finding { moved: false, ..moved("location.B0Z_urad", 1e-7, 0.1) };
    let text = with(vec![moved("location.C0Y_urad", -10.0, 0.1), none.clone()]).unwrap();
    assert!(text.contains("C0Y_urad = 0.0") && text.contains("A0Z_urad = 3\n") && !text.contains("B0Z"), "{text}");
    assert_eq!(with(vec![none]), None);
}

const KNOWN: &str = "[uncertainty.location]\nC0Y_urad = 4.0\nB0Z_urad = 3.0\n[axis.X.uncertainty]\nbacklash_um = 2.0\n\
                     [[uncertainty.correlation]]\nbetween = [\"uncertainty.location.C0Y_urad\", \
                     \"uncertainty.location.B0Z_urad\"] # by hand\ncoefficient = 0.5\n[[uncertainty.correlation]]\n\
                     between = [\"uncertainty.location.B0Z_urad\", \"axis.X.uncertainty.backlash_um\"]\n\
                     coefficient = -0.4\n";

/// Coefficients in the machine after additions, by the last parts of the keys without units.
fn coefficients(additions: &Additions) -> Vec<(String, f64)> {
    let machine = format!("{MACHINE}{KNOWN}");
    let files = Memory::new([("machine.toml", machine.as_str()), ("y.csv", "Y_mm,EYY_um\n0,1\n100,4\n")]);
    let edited = additions.edit(&files, Path::new("machine.toml")).unwrap();
    let all = edited.files.iter().map(|(name, text)| (name.as_path(), text.as_str()));
    let files = Memory::new([(Path::new("y.csv"), "Y_mm,EYY_um\n0,1\n100,4\n")].into_iter().chain(all));
    let read = Uncertainties::read_from(&files, Path::new("machine.toml")).unwrap();
    let name = |key: &String| key.rsplit('.').next().unwrap().rsplit_once('_').unwrap().0.to_owned();
    let pair = |own: &Correlation| {
        let mut names = own.between.each_ref().map(name);
        names.sort();
        (names.join(" "), own.coefficient)
    };
    let mut found: Vec<(String, f64)> = read.correlations.iter().map(pair).collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    found
}

fn together(one: &str, other: &str, coefficient: f64) -> Correlation {
    Correlation { between: [one.into(), other.into()], coefficient }
}

#[test]
fn coefficients_of_replaced_figures_are_replaced() {
    let [c0y, b0z, a0z] = ["location.C0Y_urad", "location.B0Z_urad", "location.A0Z_urad"];
    let with = |findings: Vec<Finding>, correlations: Vec<Correlation>| {
        coefficients(&Additions { findings, correlations, ..Additions::default() })
    };
    let named = |all: &[(&str, f64)]| all.iter().map(|(name, r)| ((*name).to_owned(), *r)).collect::<Vec<_>>();
    // C0Y replaced by a test that says nothing of B0Z: theirs goes, that of B0Z stays.
    assert_eq!(with(vec![moved(c0y, 50.0, 1.0)], Vec::new()), named(&[("B0Z backlash", -0.4)]));
    // Both replaced: theirs is the found one, that of B0Z and the lost motion goes; less than 0.1 is not written, nor that of
    // errors of a table or of what is not written itself.
    let both = || vec![moved(c0y, 50.0, 1.0), moved(b0z, 40.0, 1.0), moved(a0z, 30.0, 1.0)];
    let of_three = vec![
        together(c0y, b0z, 0.7),
        together(a0z, b0z, -0.099),
        together(a0z, c0y, -0.1),
        together(a0z, "axis.X.EYX_um", 0.9),
        together(a0z, "axis.Y.backlash_um", 0.9),
    ];
    assert_eq!(with(both(), of_three), named(&[("A0Z C0Y", -0.1), ("B0Z C0Y", 0.7)]));
    // 0.998 and 0.12 leave at least 0.057 for the third, which is written although it is small.
    let near = vec![together(c0y, b0z, 0.998), together(a0z, b0z, 0.12), together(a0z, c0y, 0.06)];
    let found = with(both(), near);
    assert_eq!(found.len(), 3, "{found:?}");
}

/// C0Y is the mean of the stated 10 ± 4 and the found 12 ± 3: w = 16/25, u = 2.4. B0Z stays as it is, or is such a mean too.
#[test]
fn coefficients_of_weighted_means() {
    let [c0y, b0z] = ["location.C0Y_urad", "location.B0Z_urad"];
    let found = |key: &str, value: f64, uncertainty: f64| Finding {
        moved: false,
        on_top: false,
        ..moved(key, value, uncertainty)
    };
    let one = Additions { findings: vec![found(c0y, 12.0, 3.0)], ..Additions::default() };
    let of = |all: &[(String, f64)], name: &str| all.iter().find(|own| own.0 == name).unwrap().1;
    // 0.5 · (1 − w) 4/2.4 = 0.3.
    assert!((of(&coefficients(&one), "B0Z C0Y") - 0.3).abs() < 1e-4, "{:?}", coefficients(&one));
    let both = Additions {
        findings: vec![found(c0y, 12.0, 3.0), found(b0z, 1.0, 4.0)],
        correlations: vec![together(b0z, c0y, -0.8)],
        ..Additions::default()
    };
    // B0Z: stated 3, found 4, w = 9/25, u = 2.4: 0.5 · 0.36 · 4 · 0.64 · 3/2.4² − 0.8 · 0.64 · 3 · 0.36 · 4/2.4² = 0.24 − 0.384.
    let found = coefficients(&both);
    assert!((of(&found, "B0Z C0Y") + 0.144).abs() < 1e-4, "{found:?}");
    assert!((of(&found, "B0Z backlash") + 0.4 * 0.64 * 3.0 / 2.4).abs() < 1e-4, "{found:?}");
}
