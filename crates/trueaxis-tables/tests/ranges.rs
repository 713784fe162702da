//! Every number of every file has a range: a value outside is refused with its position, by bench and controller alike.
//!
//! The keys come from the reader itself, the ranges from the list in compensation-tables/README.md.

use std::fs;
use std::path::Path;
use trueaxis::machine::{
    Axis, CrosstalkSettings, DriveFigures, DynamicSettings, FeedbackSettings, FrictionSettings, MachineSettings,
};
use trueaxis::roundness::{Arm, ArmSettings, Band, GaugeSettings, InfeedSettings, ProbeAngles};
use trueaxis::tcomp::{MAGIC, Stored, Tcomp, TcompError, VERSION_WITHOUT_GRIDS, checksum, machine_id};
use trueaxis::{check, tcomp::HEADER_BYTES};
use trueaxis_tables::error::FileError;
use trueaxis_tables::formats::{Format, import, iso230_2::read_measurement};
use trueaxis_tables::{Machine, build, compile};

/// A machine with every section and every list.
const WHOLE: &str = "\
name = \"all\"
chain = \"w C' X' b Y Z t\"
tool_mm = [0.0, 0.0, -100.0]
[axis.X]
table = \"x.csv\"
travel_mm = [-100.0, 100.0]
joint_mm = [-101.0, 101.0]
offset_mm = [0.0, 0.0, 0.0]
measured_at_mm = [0.0, 0.0, 0.0]
[axis.X.limits]
[axis.X.thermal]
[axis.X.drive]
position_gain_per_s = 110
velocity_gain_per_s = 800
reset_time_s = 0.006
resonance_hz = 400
resonance_damping = 0.02
lowest_resonance_hz = 400
[axis.X.drive.uncertainty]
[axis.X.friction]
coulomb_mm_per_s = 0.5
presliding_um = 7.0
[axis.X.friction.uncertainty]
[axis.X.dynamic]
[[axis.X.periodic]]
period_mm = 5.0
harmonics_um = [[1.0, 2.0]]
[axis.X.uncertainty]
[axis.Y]
travel_mm = [-100.0, 100.0]
joint_mm = [-101.0, 101.0]
offset_mm = [0.0, 0.0, 0.0]
measured_at_mm = [0.0, 0.0, 0.0]
[axis.Y.limits]
[axis.Y.thermal]
[axis.Y.drive]
position_gain_per_s = 110
velocity_gain_per_s = 800
reset_time_s = 0.006
resonance_hz = 400
resonance_damping = 0.02
lowest_resonance_hz = 400
[axis.Y.friction]
coulomb_mm_per_s = 0.5
presliding_um = 7.0
[axis.Y.dynamic]
[axis.Y.uncertainty]
[axis.Z]
travel_mm = [-100.0, 100.0]
joint_mm = [-101.0, 101.0]
offset_mm = [0.0, 0.0, 0.0]
measured_at_mm = [0.0, 0.0, 0.0]
[axis.Z.limits]
[axis.Z.thermal]
[axis.Z.drive]
position_gain_per_s = 110
velocity_gain_per_s = 800
reset_time_s = 0.006
resonance_hz = 400
resonance_damping = 0.02
lowest_resonance_hz = 400
[axis.Z.friction]
coulomb_mm_per_s = 0.5
presliding_um = 7.0
[axis.Z.dynamic]
[axis.Z.uncertainty]
[axis.C]
travel_deg = [-100.0, 100.0]
joint_deg = [-101.0, 101.0]
offset_mm = [0.0, 0.0, 0.0]
measured_at_mm = [0.0, 0.0, 0.0]
[axis.C.limits]
[axis.C.thermal]
[axis.C.drive]
position_gain_per_s = 110
velocity_gain_per_s = 800
reset_time_s = 0.006
resonance_hz = 400
resonance_damping = 0.02
lowest_resonance_hz = 400
[axis.C.friction]
coulomb_deg_per_s = 0.5
presliding_urad = 7.0
[axis.C.dynamic]
[[axis.C.periodic]]
period_deg = 4.0
harmonics_urad = [[1.0, 2.0]]
[axis.C.uncertainty]
[location]
[uncertainty]
[uncertainty.location]
A0Z_urad = 3.0
B0Z_urad = 3.0
[[uncertainty.correlation]]
between = [\"uncertainty.location.A0Z_urad\", \"uncertainty.location.B0Z_urad\"]
coefficient = 0.5
[faults]
[contour]
[contour.feedback]
[compensation]
[kinematics]
tool_axis = [0.0, 0.0, 1.0]
[roundness]
points = 1024
probe_slots = [188, 667]
harmonics = [2, 100]
spindle_counts_per_revolution = 3600000
probe_gain_um = [1.0, 1.0, 1.0]
probe_zero = [0.0, 0.0, 0.0]
probe_low = [-500.0, -500.0, -500.0]
probe_high = [500.0, 500.0, 500.0]
[roundness.arm]
crank_mm = 45.0
wheel_mm = 300.0
pin_mm = 27.5
counts_per_revolution = 3600000
[roundness.infeed]
axis = \"X\"
harmonics = [2, 50]
[[crosstalk]]
tip = \"X\"
from = \"Y\"
k_um_per_m_per_s2 = 1.0
[[grid]]
axes = [\"X\", \"Y\"]
table = \"grid.csv\"
fade_mm = [1.0, 10.0]
measured_at_mm = [0.0, 0.0, 5.0]
";
const TABLE: &str = "X_mm,EXX_um,ECX_urad\n-100,1,1\n100,2,1\n";

fn read(machine: &str, table: &str) -> Result<Machine, FileError> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("machine.toml"), machine).unwrap();
    fs::write(folder.path().join("x.csv"), table).unwrap();
    fs::write(folder.path().join("grid.csv"), "X_mm,Y_mm,EZ_um\n0,0,0\n0,10,0\n10,0,0\n10,10,1\n").unwrap();
    Machine::read(folder.path())
}

/// The text with one element of one key set, and the line of the key, from 1.
fn with(key: &str, element: usize, count: usize, value: &str) -> (String, u32) {
    let (section, name) = key.rsplit_once('.').unwrap_or(("", key));
    let mut lines: Vec<String> = WHOLE.lines().map(str::to_owned).collect();
    let start = if section.is_empty() {
        0
    } else {
        1 + lines
            .iter()
            .position(|line| line.trim_matches(['[', ']']) == section)
            .unwrap_or_else(|| panic!("no [{section}]"))
    };
    // One pair of angles only.
    if name == "probe_angles_deg" {
        let slots = lines.iter_mut().find(|line| line.starts_with("probe_slots")).unwrap();
        *slots = String::from("probe_angles_deg = [66.09, 234.49]");
    }
    let end = lines[start..].iter().position(|line| line.starts_with('[')).map_or(lines.len(), |end| start + end);
    let place = lines[start..end].iter().position(|line| line.starts_with(&format!("{name} ="))).map(|at| start + at);
    let text = if count == 1 {
        value.to_owned()
    } else {
        let place = place.unwrap_or_else(|| panic!("{key}: a list that the machine above has to have"));
        let list = lines[place].split_once('[').unwrap().1.trim_end_matches(']');
        let mut values: Vec<&str> = list.split(',').map(str::trim).collect();
        assert_eq!(values.len(), count, "{key}");
        values[element] = value;
        format!("[{}]", values.join(", "))
    };
    let place = match place {
        Some(place) => {
            lines[place] = format!("{name} = {text}");
            place
        }
        None => {
            lines.insert(start, format!("{name} = {text}"));
            start
        }
    };
    (lines.join("\n") + "\n", place as u32 + 1)
}

fn keys() -> Vec<(String, usize)> {
    let keys = Machine::number_keys(WHOLE).unwrap();
    assert!(keys.len() > 90, "{}", keys.len());
    keys
}

/// The README's list: (key, least, most), `None` if a bound is a rule.
fn listed() -> Vec<(String, Option<f64>, Option<f64>)> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/README.md");
    let text = fs::read_to_string(file).unwrap();
    let rows = text.split("### Ranges").nth(1).unwrap().split("## The measurement").next().unwrap();
    let mut found = Vec::new();
    for row in rows.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [names, least, most] = cells[..] else { panic!("{row}") };
        for name in names.split('`').skip(1).step_by(2) {
            found.push((name.to_owned(), least.parse().ok(), most.parse().ok()));
        }
    }
    found
}

/// Name of a key in the README.
fn general(key: &str) -> String {
    let (section, last) = key.rsplit_once('.').unwrap_or(("", key));
    let section =
        ["Y", "Z"].iter().fold(section.to_owned(), |section, axis| section.replace(&format!("axis.{axis}"), "axis.X"));
    let errors = section.ends_with("location") || (section.ends_with("uncertainty") && last.starts_with('E'));
    match last.rsplit_once('_') {
        _ if last.ends_with("_degrees_of_freedom") => format!("{section}.*_degrees_of_freedom"),
        Some((_, unit)) if errors && last.starts_with(|first: char| first.is_uppercase()) => {
            format!("{section}.*_{unit}")
        }
        _ if section.is_empty() => last.to_owned(),
        _ => format!("{section}.{last}"),
    }
}

#[test]
fn the_whole_machine_is_sound() {
    let machine = read(WHOLE, TABLE).unwrap();
    build(&machine, 10_000.0).unwrap();
}

#[test]
fn no_number_of_machine_toml_is_absurd() {
    for (key, count) in keys() {
        for element in 0..count {
            for value in ["1e308", "-1e308", "nan", "inf", "-inf"] {
                let (text, line) = with(&key, element, count, value);
                let error = read(&text, TABLE).expect_err(&format!("{key} = {value}"));
                assert_eq!(
                    (error.line, error.column.as_deref()),
                    (Some(line), Some(&*key)),
                    "{key} = {value}: {error}"
                );
                assert!(error.file.ends_with("machine.toml") && error.found.contains(value), "{error}");
                assert!(!error.needed.is_empty() && error.found.len() < 200, "{error}");
            }
        }
    }
}

#[test]
fn the_readme_lists_every_key_and_its_range_is_the_one_that_holds() {
    let listed = listed();
    for (key, count) in keys() {
        let name = general(&key);
        let Some((_, least, most)) = listed.iter().find(|(listed, ..)| *listed == name) else {
            panic!("{name} is not in the list of compensation-tables/README.md")
        };
        for (bound, outwards) in [(least, -1.0), (most, 1.0)] {
            let Some(bound) = *bound else { continue };
            let beyond = bound + outwards * 1e-9 * bound.abs().max(1e-9);
            for element in 0..count {
                let (text, line) = with(&key, element, count, &format!("{beyond:?}"));
                let error = read(&text, TABLE).expect_err(&format!("{key} = {beyond:?}"));
                assert_eq!((error.line, error.column.as_deref()), (Some(line), Some(&*key)), "{beyond:?}: {error}");
                // The bound itself is accepted, or refused by another rule.
                let whole = ["points", "counts", "direction", "upr", "revolutions", "units", "slots"];
                let at = if whole.iter().any(|part| key.contains(part)) {
                    format!("{bound:.0}")
                } else {
                    format!("{bound:?}")
                };
                if let Err(other) = read(&with(&key, element, count, &at).0, TABLE) {
                    assert!(
                        other.column.as_deref() != Some(&*key) || other.needed != error.needed,
                        "{key} = {at}: {other}"
                    );
                }
            }
        }
    }
    for (name, ..) in listed.iter().filter(|(name, ..)| name.contains('.')) {
        assert!(keys().iter().any(|(key, _)| general(key) == *name), "{name} is in the list but is no key");
    }
}

#[test]
fn no_cell_of_a_table_is_absurd() {
    for (column, beyond) in [(0, "1000000.001"), (1, "1000.0001"), (2, "10000.001")] {
        let name = ["X_mm", "EXX_um", "ECX_urad"][column];
        for value in ["1e308", "-1e308", "nan", "inf", beyond, &format!("-{beyond}")] {
            let mut cells = ["0", "1", "1"];
            cells[column] = value;
            let table = format!("X_mm,EXX_um,ECX_urad\n{}\n2000000,1,1\n", cells.join(","));
            let error = read(WHOLE, &table).expect_err(value);
            assert_eq!((error.line, error.column.as_deref()), (Some(2), Some(name)), "{error}");
            assert!(error.file.ends_with("x.csv") && !error.needed.is_empty() && error.found.len() < 60, "{error}");
        }
    }
    // A wrong unit, with the hint at it.
    let error = read(WHOLE, "X_mm,EXX_um\n-100,3100\n100,3100\n").unwrap_err();
    assert!(
        error.to_string().ends_with("found 3100 um, needed -1000 to 1000 um (1 mm; is the unit right?)"),
        "{error}"
    );
    // Uncertainties cannot be negative.
    for (column, value) in [("EXX_u_um", "-0.001"), ("EXX_u_um", "1000.1"), ("EXX_u_um", "nan"), ("EXX_u_um", "")] {
        let error = read(WHOLE, &format!("X_mm,EXX_um,{column}\n-100,1,{value}\n100,2,0\n")).expect_err(value);
        assert_eq!((error.line, error.column.as_deref()), (Some(2), Some(column)), "{error}");
    }
    let error = read(WHOLE, "X_mm,EXX_um,EYX_u_um\n-100,1,1\n100,2,0\n").unwrap_err();
    assert!(
        error.to_string().ends_with("found an uncertainty without its error, needed a column EYX_um as well"),
        "{error}"
    );
    // Lines that no instrument can distinguish.
    let error = read(WHOLE, "X_mm,EXX_um\n0,1\n1e-300,1\n").unwrap_err();
    assert!(error.to_string().contains("by at least 0.001"), "{error}");
    assert!(read(WHOLE, "X_mm,EXX_um\n0,1\n0.001,1\n0.002,1\n").is_ok());
}

#[test]
fn no_number_of_another_controls_file_is_absurd() {
    for value in ["1e308", "-1e308", "1.1"] {
        for (format, text) in [
            ("linuxcnc-1", format!("0 0 0\n10 {value} 0\n")),
            (
                "siemens",
                format!(
                    "$AA_ENC_COMP[0,0,X1]=0\n$AA_ENC_COMP[0,1,X1]={value}\n$AA_ENC_COMP_STEP[0,X1]=10\n\
                 $AA_ENC_COMP_MIN[0,X1]=0\n$AA_ENC_COMP_MAX[0,X1]=10\n$AA_ENC_COMP_IS_MODULO[0,X1]=0\n"
                ),
            ),
            ("isg", format!("X EXX\n0 0\n10 {value}\n")),
        ] {
            let error =
                import(Format::from_name(format).unwrap(), &text, Path::new("f"), Some(Axis::X)).expect_err(format);
            assert!(error.line.is_some() && error.needed.contains("is the unit right?"), "{format} {value}: {error}");
        }
    }
    for (row, column) in [
        ("0,1,+,1e308", "deviation_um"),
        ("0,1,+,-3100", "deviation_um"),
        ("1e308,1,+,1", "X_mm"),
        ("-1e7,1,+,1", "X_mm"),
    ] {
        let text = format!("X_mm,run,direction,deviation_um\n{row}\n");
        let error = read_measurement(&text, Path::new("m.csv"), None).unwrap_err();
        assert_eq!((error.line, error.column.as_deref()), (Some(2), Some(column)), "{error}");
    }
}

/// The controller runs everything that the bench accepts, in both scalar types; here a setting that only the step's stages
/// refuse.
#[test]
fn the_bench_refuses_settings_that_the_controller_refuses() {
    let (text, line) = with("contour.max_lag_mm", 0, 1, "5000");
    let error = read(&text, TABLE).unwrap_err();
    assert_eq!((error.line, error.column.as_deref()), (Some(line), Some("contour.max_lag_mm")), "{error}");
    // Three rotary axes below X: the nine terms turn by two.
    let chain = WHOLE.split("[location]").next().unwrap().replace("w C' X' b Y Z t", "w X' A' B' C' b Y Z t");
    // Neither X there nor C in the volumetric form may have a period.
    let chain = ["X", "C"].iter().fold(chain, |text, axis| {
        let (before, section) = text.split_once(&format!("[[axis.{axis}.periodic]]")).unwrap();
        let (_, behind) = section.split_once("]]\n").unwrap();
        format!("{before}{behind}")
    });
    let error = read(&chain, TABLE).unwrap_err();
    assert_eq!(error.column.as_deref(), Some("chain"), "{error}");
    build(&read(&format!("{chain}[compensation]\nmodel = \"volumetric\"\n"), TABLE).unwrap(), 1e4).unwrap();
    // A limit that one cycle of single precision cannot resolve.
    let slow = read(&with("axis.X.limits.acceleration_mm_per_s2", 0, 1, "1.0").0, TABLE).unwrap();
    build(&slow, 1_000.0).unwrap();
    assert_eq!(build(&slow, 10_000.0).unwrap_err().axis, Some(Axis::X));
}

fn gauged() -> Machine {
    let mut machine = crate::small_machine::machine();
    for axis in &mut machine.settings.axes {
        axis.servo.drive = Some(DriveFigures::with_defaults(110.0, 800.0, 0.006));
        axis.servo.friction = Some(FrictionSettings::with_defaults(0.5, 0.007));
        axis.servo.dynamic = Some(DynamicSettings::with_defaults(axis.axis));
    }
    machine.settings.contour.feedback =
        Some(FeedbackSettings { proportional: 0.03, integral_per_s: 1.0, ..FeedbackSettings::default() });
    let points = [[0.0, 1e-6], [100.0, 2e-6]].into_iter().collect();
    let crosstalk = CrosstalkSettings { tip: Axis::X, from: Axis::Z, over: Axis::X, points };
    machine.settings.crosstalk.push(crosstalk).unwrap();
    let mut gauge = GaugeSettings::with_defaults(256, ProbeAngles::Degrees { phi2: 66.1, phi3: 234.5 }, 1 << 20);
    let lengths = Arm { crank_mm: 40.0, wheel_mm: 300.0, pin_mm: 20.0 };
    gauge.arm = Some(ArmSettings { lengths, counts: 1 << 20, direction: 1, tolerance_deg: 1.0 });
    gauge.infeed = Some(InfeedSettings {
        gain: 0.2,
        drive_delay_s: 0.001,
        ..InfeedSettings::with_defaults(Axis::X, Band { first: 2, last: 20 })
    });
    machine.settings.roundness = Some(gauge);
    machine
}

/// Paths of all non-integer numbers of a JSON document.
fn floats(value: &serde_json::Value, path: String, found: &mut Vec<String>) {
    match value {
        serde_json::Value::Number(number) if number.is_f64() => found.push(path),
        serde_json::Value::Array(list) => {
            list.iter().enumerate().for_each(|(index, value)| floats(value, format!("{path}/{index}"), found));
        }
        serde_json::Value::Object(fields) => {
            fields.iter().for_each(|(name, value)| floats(value, format!("{path}/{name}"), found));
        }
        _ => {}
    }
}

/// A forged file with a valid checksum: every double of the settings, one after the other.
#[test]
fn a_compiled_file_with_a_valid_sum_and_an_absurd_number_is_refused() {
    let machine = gauged();
    let good = compile(&machine).unwrap();
    assert!(Tcomp::parse(&good).is_ok());
    let tables =
        good[HEADER_BYTES + postcard::to_stdvec(&Stored(&machine.settings)).unwrap().len()..good.len() - 4].to_vec();
    let forged = |settings: &[u8]| {
        let payload = [settings, &tables].concat();
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION_WITHOUT_GRIDS.to_le_bytes());
        bytes.extend(machine_id(&machine.settings.name, &machine.settings.chain).to_le_bytes());
        bytes.extend((payload.len() as u32).to_le_bytes());
        bytes.extend(payload);
        bytes.extend(checksum(&bytes).to_le_bytes());
        bytes
    };
    let document = serde_json::to_value(Stored(&machine.settings)).unwrap();
    let mut places = Vec::new();
    floats(&document, String::new(), &mut places);
    assert!(places.len() > 90, "{}", places.len());
    const MARK: f64 = 1.234_567_891_234e-77;
    for place in places {
        let mut changed = document.clone();
        *changed.pointer_mut(&place).unwrap() = serde_json::json!(MARK);
        let Stored(settings): Stored<MachineSettings> = serde_json::from_value(changed).unwrap();
        let bytes = postcard::to_stdvec(&Stored(&settings)).unwrap();
        let mark = MARK.to_le_bytes();
        let at = bytes.windows(8).position(|window| window == mark).unwrap();
        for value in [1e308, -1e308, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e12] {
            let mut bytes = bytes.clone();
            bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
            let Stored(settings): Stored<MachineSettings> = postcard::from_bytes(&bytes).unwrap();
            assert!(check::settings(&settings).is_err(), "{place} = {value}");
            let refused = Tcomp::parse(&forged(&bytes)).err();
            assert!(matches!(refused, Some(TcompError::Content(_))), "{place} = {value}: {refused:?}");
        }
    }
    // Then every double of a table.
    let header = tables.len();
    for at in (0..header.saturating_sub(8)).filter(|at| {
        let double: [u8; 8] = tables[*at..at + 8].try_into().unwrap();
        machine.axes().flat_map(|(_, table)| table.into_iter().flat_map(|table| &table.rows)).any(|row| {
            let values = row.forward.iter().chain(&row.reverse).chain([&row.position]);
            values.clone().any(|value| *value != 0.0 && value.to_le_bytes() == double)
        })
    }) {
        for value in [1e308, f64::NAN] {
            let mut bytes = good.clone();
            let start = bytes.len() - 4 - tables.len() + at;
            bytes[start..start + 8].copy_from_slice(&f64::to_le_bytes(value));
            let end = bytes.len() - 4;
            let sum = checksum(&bytes[..end]);
            bytes[end..].copy_from_slice(&sum.to_le_bytes());
            let refused = Tcomp::parse(&bytes).err();
            assert!(matches!(refused, Some(TcompError::Content(_))), "byte {at} = {value}: {refused:?}");
        }
    }
}
