//! Five-axis machines through the formats of other controls: the same machine is read back, or the loss is listed.

use std::fs;
use std::path::Path;
use trueaxis::machine::{AXES, Axis, Interpolation};
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::formats::linuxcnc::CompFileType;
use trueaxis_tables::formats::{ExportOptions, Format, Imported, Loss, export, import};
use trueaxis_tables::{Machine, Table};
use trueaxis_testing::noise::Noise;

const TYPE_0: Format = Format::LinuxCnc(CompFileType::Positions);

fn sample(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables").join(name)).unwrap()
}

fn dropping(axis: Option<Axis>) -> ExportOptions {
    ExportOptions { loss: Loss::Drop, axis, ..ExportOptions::default() }
}

fn files(imported: &Imported) -> Machine {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in imported.machine_files("back") {
        fs::write(folder.path().join(name), text).unwrap();
    }
    Machine::read(folder.path()).unwrap()
}

/// The machine after export to and import from an ISG file, without any loss.
fn there_and_back(machine: &Machine) -> (Machine, Vec<String>) {
    let exported = export(Format::Isg, machine, &ExportOptions::default()).unwrap();
    let imported = import(Format::Isg, &exported.files[0].1, Path::new("in"), None).unwrap();
    (files(&imported), exported.notes)
}

/// Removes everything that depends on the direction of travel or the temperature, and perturbs all values so that the written
/// digits are not exact.
fn one_way(machine: &mut Machine, seed: u64) {
    let mut noise = Noise::new(seed);
    for (settings, table) in machine.settings.axes.iter_mut().zip(&mut machine.tables) {
        settings.backlash = 0.0;
        settings.thermal = Default::default();
        let table = table.as_mut().unwrap();
        table.bidirectional = false;
        for row in &mut table.rows {
            row.forward = std::array::from_fn(|k| row.forward[k] + noise.signed() * if k < 3 { 1e-3 } else { 1e-6 });
            row.reverse = row.forward;
        }
        let (first, last) = (table.rows[0], table.rows.len() - 1);
        if settings.axis.is_rotary() && table.rows[last].position - first.position == 360.0 {
            (table.rows[last].forward, table.rows[last].reverse) = (first.forward, first.reverse);
        }
    }
}

/// Largest difference of the tip errors at random poses within the travels, mm.
fn apart(one: &Machine, other: &Machine, reverse: f64) -> f64 {
    let (a, b) = (Geometry::new(one, 0.0).unwrap(), Geometry::new(other, 0.0).unwrap());
    let mut noise = Noise::new(99);
    let poses = (0..2000).map(|_| {
        let mut q = [0.0; AXES];
        for (q, axis) in q.iter_mut().zip(&one.settings.axes) {
            let [low, high] = axis.travel.map(|end| end.clamp(-720.0, 1000.0));
            *q = 0.5 * (low + high) + 0.5 * (high - low) * noise.signed();
        }
        let (a, b) = (a.tip_error(&q, &[reverse; AXES]), b.tip_error(&q, &[0.0; AXES]));
        (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
    });
    poses.fold(0.0, f64::max)
}

/// Half a unit of the last digit, 1 nm and 1 nrad, in three components of five axes, over a lever of at most 1.5 m.
const ROUNDING: f64 = 5.0 * 1.732_051 * (0.5e-6 + 0.5e-9 * 1500.0);

fn same_settings(machine: &Machine, back: &Machine) {
    let (a, b) = (&machine.settings, &back.settings);
    assert_eq!((&a.chain, a.tool_mm, a.kinematics), (&b.chain, b.tool_mm, b.kinematics));
    assert_eq!((a.compensation, a.reference_temperature_c), (b.compensation, b.reference_temperature_c));
    for (a, b) in a.axes.iter().zip(&b.axes) {
        assert_eq!((a.axis, a.direction, a.offset_mm, a.travel), (b.axis, b.direction, b.offset_mm, b.travel));
        assert_eq!((a.interpolation, a.lookup, a.cross_lookup), (b.interpolation, b.lookup, b.cross_lookup));
        assert_eq!(b.measured_at_mm, [0.0; 3]);
    }
}

/// A monotone cubic passes through the lines with slopes that depend on them: twice their rounding.
#[test]
fn samples_come_back_through_isg() {
    for name in ["mill-5axis", "head-5axis"] {
        let mut machine = sample(name);
        one_way(&mut machine, 1);
        let (back, _) = there_and_back(&machine);
        same_settings(&machine, &back);
        let found = apart(&machine, &back, 0.0);
        assert!(found < 2.0 * ROUNDING && found > 1e-8, "{name}: {found:e} mm");
    }
}

/// Offsets, tool, tool axis, senses and all other settings that are written; tables measured away from zero are converted, so
/// that the tip error is unchanged everywhere between linear lines.
#[test]
fn measured_elsewhere_comes_back_measured_at_zero() {
    for name in ["mill-5axis", "head-5axis"] {
        let mut machine = sample(name);
        one_way(&mut machine, 2);
        let settings = &mut machine.settings;
        settings.tool_mm = [0.1, -0.25, -123.456_789_012];
        settings.kinematics.tool_axis = [0.0, 0.6, 0.8];
        settings.kinematics.singular_cone_deg = 0.3;
        settings.compensation.orientation = true;
        settings.compensation.fade_deg = 7.25;
        settings.reference_temperature_c = 21.5;
        for (k, axis) in settings.axes.iter_mut().enumerate() {
            axis.interpolation = Interpolation::Linear;
            axis.offset_mm = [1.0 / 3.0, -20.0, 100.0 * k as f64];
            axis.measured_at_mm = [150.0, -80.0, 210.0 + k as f64];
            axis.direction *= if axis.axis == Axis::C { -1 } else { 1 };
        }
        // A table of angles alone gets translations through its lever.
        let x = machine.tables[0].as_mut().unwrap();
        x.given = [false, false, false, true, true, true];
        for row in &mut x.rows {
            row.forward[..3].fill(0.0);
            row.reverse = row.forward;
        }
        let (back, notes) = there_and_back(&machine);
        same_settings(&machine, &back);
        let found = apart(&machine, &back, 0.0);
        // The lever of the head machine's slide X' includes its travel: exact at the lines, a parabola between them.
        let between = if name == "head-5axis" { 5e-5 } else { 0.0 };
        assert!(found < ROUNDING + between, "{name}: {found:e} mm");
        let mut ignored = machine.clone();
        ignored.settings.axes.iter_mut().for_each(|axis| axis.measured_at_mm = [0.0; 3]);
        assert!(apart(&ignored, &back, 0.0) > 1e-3);
        let notes = notes.join("\n");
        for part in [
            "measured_at_mm 150 -80 210 of axis X",
            "tool tip 0.1 -0.25 -123.456789012",
            machine.settings.chain.as_str(),
        ] {
            assert!(notes.contains(part), "{part}: {notes}");
        }
        assert!(notes.contains("axis Z is 0.3333333333333333 -20 200 mm"), "{notes}");
    }
}

/// With both directions and backlash the mean is written: the tip error is that in the middle of the lost motion.
#[test]
fn the_mean_of_both_directions_comes_back() {
    let mut machine = sample("mill-5axis");
    machine.settings.axes.iter_mut().for_each(|axis| axis.interpolation = Interpolation::Linear);
    let exported = export(Format::Isg, &machine, &dropping(None)).unwrap();
    let dropped = exported.dropped.join("\n");
    assert!(dropped.contains("directions of axis A") && dropped.contains("directions of axis C"), "{dropped}");
    assert_eq!(exported.dropped.len(), 3, "{dropped}");
    let back = files(&import(Format::Isg, &exported.files[0].1, Path::new("in"), None).unwrap());
    let found = apart(&machine, &back, 0.5);
    assert!(found < ROUNDING, "{found:e} mm");
}

/// One axis of a five-axis machine: chain and offsets stay, the location errors are listed.
#[test]
fn a_single_axis_keeps_the_chain() {
    let mut machine = sample("head-5axis");
    machine.settings.axes[3].offset_mm = [0.0, 0.0, 150.0];
    let exported = export(Format::Isg, &machine, &dropping(Some(Axis::C))).unwrap();
    assert!(exported.dropped.iter().any(|loss| loss.starts_with("location errors A0Z 14.000 urad")), "{exported:?}");
    let back = files(&import(Format::Isg, &exported.files[0].1, Path::new("in"), Some(Axis::C)).unwrap());
    same_settings(&machine, &back);
    assert_eq!(back.tables.iter().flatten().count(), 1);
}

/// Own positioning follows the axis: a nominal machine at the positions of the LinuxCNC file is where the true machine is, on
/// either side of the bed and for either sense of a rotary axis.
#[test]
fn own_positioning_is_that_of_the_axis_on_either_side() {
    let half_turn = 180.0 / std::f64::consts::PI;
    for chain in ["w C' A' Y' b X Z t", "w X' Z' b Y A C t", "w A' X' b Z Y C t"] {
        for direction in [1, -1] {
            let mut machine = sample("mill-5axis");
            machine.settings.chain = chain.parse().unwrap();
            machine.settings.location = Default::default();
            machine.settings.tool_mm = [3.0, 4.0, 5.0];
            for (axis, table) in machine.settings.axes.iter_mut().zip(&mut machine.tables) {
                axis.backlash = 0.0;
                if axis.axis.is_rotary() {
                    axis.direction = direction;
                }
                let own = axis.axis.index();
                for row in &mut table.as_mut().unwrap().rows {
                    row.forward = std::array::from_fn(|k| if k == own { row.forward[k] } else { 0.0 });
                    row.reverse = row.forward;
                }
            }
            let geometry = Geometry::new(&machine, 0.0).unwrap();
            for (slot, axis) in machine.settings.axes.iter().enumerate() {
                let exported = export(TYPE_0, &machine, &dropping(Some(axis.axis))).unwrap();
                let line = exported.files[0].1.lines().nth(9).unwrap();
                let numbers: Vec<f64> = line.split(' ').map(|number| number.parse().unwrap()).collect();
                // A machine with this table alone, so that the other axes' own errors do not interfere.
                let mut alone = machine.clone();
                for (other, table) in alone.tables.iter_mut().enumerate() {
                    if other != slot {
                        *table = None;
                    }
                }
                let geometry_alone = Geometry::new(&alone, 0.0).unwrap();
                let mut q = [10.0, -20.0, 30.0, 25.0, 40.0, 0.0];
                q[slot] = numbers[0];
                let actual = geometry_alone.actual_pose(&q, &[0.0; AXES]);
                q[slot] = numbers[1];
                let ideal = geometry.ideal_pose(&q);
                for k in 0..3 {
                    // 1 nm; 1e-7 degrees over 100 mm.
                    let found = (actual.tip_mm[k] - ideal.tip_mm[k]).abs();
                    assert!(found < 1.1e-6, "{chain} {direction} {:?}: {found:e}", axis.axis);
                    assert!((actual.direction[k] - ideal.direction[k]).abs() < 2e-7 / half_turn);
                }
                assert!((numbers[1] - numbers[0]).abs() > 1e-5, "{line}");
            }
        }
    }
}

/// The own errors of rotary axes survive the one-dimensional formats: 1 mdeg/1e4 and 1 nrad.
#[test]
fn rotary_positioning_survives() {
    let mut machine = sample("head-5axis");
    one_way(&mut machine, 3);
    for format in [TYPE_0, Format::LinuxCnc(CompFileType::Trims), Format::Siemens, Format::Iso230_2] {
        for axis in [Axis::A, Axis::C] {
            let (_, text) = export(format, &machine, &dropping(Some(axis))).unwrap().files.remove(0);
            let (_, back): (Axis, Table) = import(format, &text, Path::new("in"), Some(axis)).unwrap().tables.remove(0);
            let table = machine.axes().find(|(settings, _)| settings.axis == axis).unwrap().1.unwrap();
            assert_eq!(table.rows.len(), back.rows.len());
            for (row, read) in table.rows.iter().zip(&back.rows) {
                let apart = (row.forward[axis.index()] - read.forward[axis.index()]).abs();
                assert!(row.position == read.position && apart < 1.001e-9, "{format:?} {axis:?} {apart:e}");
            }
        }
    }
}

/// The complete list, word for word, for formats that hold positioning only.
#[test]
fn losses_of_five_axes_are_named() {
    let mut machine = sample("head-5axis");
    machine.settings.kinematics.tool_axis = [0.0, 1.0, 0.0];
    machine.settings.axes[3].offset_mm = [0.0, 0.0, 150.0];
    machine.settings.axes[0].measured_at_mm = [0.0, 0.0, 80.0];
    let mut expected = vec![
        String::from(
            "location errors A0Z 14.000 urad, B0Z -18.000 urad, C0Y 20.000 urad, EY0A 14.000 um, EZ0A -6.000 um, \
            EB0A 19.000 urad, EC0A -25.000 urad, EX0C 9.000 um, EY0C -12.000 um, EA0C 22.000 urad, EB0C -17.000 urad",
        ),
        String::from("chain w X' b Y Z C A t (rotary: C A; carrying the workpiece: X)"),
        String::from("tool_mm 0 0 -250"),
        String::from("tool_axis 0 1 0"),
        String::from("compensation settings: model volumetric, orientation false, fade_deg 5"),
        String::from(
            "measured_at_mm 0 0 80 of axis X: its error is valid there, elsewhere its angular errors of up to 14.074 urad \
            change it",
        ),
        String::from("offset_mm 0 0 150 of axis A"),
    ];
    expected.extend(
        ['X', 'Y', 'Z', 'A', 'C'].map(|axis| format!("cubic interpolation of axis {axis}: the control has its own")),
    );
    for axis in ["X", "Y", "Z", "A", "C"] {
        let names: Vec<String> = ["X", "Y", "Z", "A", "B", "C"]
            .iter()
            .filter(|direction| *direction != &axis)
            .map(|direction| format!("E{direction}{axis}"))
            .collect();
        expected.push(format!("{} of axis {axis} (up to ", names.join(", ")));
    }
    for format in [TYPE_0, Format::LinuxCnc(CompFileType::Trims), Format::Siemens, Format::Iso230_2] {
        let dropped = export(format, &machine, &dropping(None)).unwrap().dropped;
        let refused = export(format, &machine, &ExportOptions::default()).unwrap_err().found;
        let mut rest: Vec<&String> = dropped.iter().collect();
        for loss in &expected {
            let place = rest.iter().position(|found| {
                if loss.ends_with("up to ") { found.starts_with(loss.as_str()) } else { *found == loss }
            });
            let place = place.unwrap_or_else(|| panic!("{format:?}: {loss} is not in {dropped:#?}"));
            assert!(refused.contains(rest.remove(place).as_str()));
        }
        rest.retain(|loss| !loss.starts_with("wrapping of axis C: LinuxCNC"));
        assert!(rest.is_empty(), "{format:?}: {rest:#?}");
    }
    // X of head-5axis, by hand from its table: EYX 6.735 um and 14.074 urad are the largest.
    let dropped = export(TYPE_0, &machine, &dropping(Some(Axis::X))).unwrap().dropped;
    let cross = dropped.iter().find(|loss| loss.starts_with("EYX")).unwrap();
    assert!(cross.ends_with("of axis X (up to 6.735 um, 14.074 urad)"), "{cross}");
    assert!(!dropped.iter().any(|loss| loss.contains("of axis A")), "{dropped:?}");
}

#[test]
fn nonsense_in_comments_is_refused() {
    let table = "X EXX\n0 0\n1 0.001\n";
    let chain = "// trueaxis chain: w X' b Y Z C t\n";
    for (text, line, fragment) in [
        (format!("// trueaxis chain: w X' b X t\n{table}"), 1, "each axis at most once"),
        (format!("// trueaxis chain: w X b t\n{table}"), 1, "a prime"),
        (format!("// trueaxis chain:\n{table}"), 1, "at the start of the chain"),
        (format!("// trueaxis chain: w b t\n{table}"), 1, "at least one axis"),
        (format!("// trueaxis chain: w b{}X t\n{table}", " ".repeat(60)), 1, "48 bytes"),
        (format!("// trueaxis chain: w b Y t\n{table}"), 2, "not in the chain w b Y t"),
        (format!("{chain}{chain}{table}"), 2, "already on line 1"),
        (format!("{chain}X0A\n1e-3\n#\n{table}"), 2, "axis A, which is not in the chain"),
        (format!("{table}// trueaxis tool_mm: 0 0 1\n"), 4, "no chain"),
        (format!("{chain}// trueaxis tool_mm: 0 0\n{table}"), 2, "2 numbers"),
        (format!("{chain}// trueaxis tool_mm: 0 0 nan\n{table}"), 2, "a finite number"),
        (format!("{chain}// trueaxis tool_mm 0 0 0\n{table}"), 2, "a colon"),
        (format!("{chain}// trueaxis tool: 0 0 0\n{table}"), 2, "tool_mm"),
        (format!("{chain}// trueaxis tool_axis: 0 0 0\n{table}"), 2, "length of about 1"),
        (format!("{chain}// trueaxis singular_cone_deg: 46\n{table}"), 2, "0 to 45"),
        (format!("{chain}// trueaxis fade_deg: -1\n{table}"), 2, "0 to 45"),
        (format!("{chain}// trueaxis model: best\n{table}"), 2, "nine or volumetric"),
        (format!("{chain}// trueaxis reference_temperature_c: -300\n{table}"), 2, "-50 to 150"),
        (format!("{chain}// trueaxis axis A direction: 1\n{table}"), 2, "axis A, which is not in the chain"),
        (format!("{chain}// trueaxis axis Q direction: 1\n{table}"), 2, "X Y Z A B C"),
        (format!("{chain}// trueaxis axis C direction: 2\n{table}"), 2, "1 or -1"),
        (format!("{chain}// trueaxis axis X direction: -1\n{table}"), 2, "rotary axis only"),
        (format!("{chain}// trueaxis axis C travel_mm: 0 1\n{table}"), 2, "travel_mm (travel_deg)"),
        (format!("{chain}// trueaxis axis C travel_deg: 1 0\n{table}"), 2, "above the low end"),
        (format!("{chain}// trueaxis axis C offset_mm: 0 0 1 x\n{table}"), 2, "a number"),
        (format!("{chain}\n// trueaxis axis C interpolation: spline\n{table}"), 3, "linear or cubic"),
    ] {
        let error = import(Format::Isg, &text, Path::new("in.csv"), None).unwrap_err();
        assert_eq!(error.line, Some(line), "{error}");
        assert!(error.to_string().contains(fragment), "{fragment}: {error}");
    }
    // Other comments have no effect, and a file without comments of this crate leaves the chain open.
    let foreign = import(Format::Isg, &format!("// true axis chain: x\n{table}"), Path::new("in.csv"), None).unwrap();
    assert_eq!(foreign.settings, None);
    assert!(foreign.machine_files("m")[0].1.contains("chain = \"w b X t\""));
}
