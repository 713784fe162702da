//! Every key of a `machine.toml` that can be wrong is refused at its own line.

use std::collections::BTreeSet;
use std::fs;
use trueaxis::error::Field;
use trueaxis::machine::Axis;
use trueaxis_tables::Machine;

/// A valid machine, every key on a separate line.
const MACHINE: &str = r#"name = "all keys"
chain = "w C' X' b t"
tool_mm = [0, 0, 0]
reference_temperature_c = 20
[axis.X]
table = "x.csv"
travel_mm = [0, 20]
joint_mm = [-1, 21]
measured_at_mm = [0, 0, 0]
offset_mm = [0, 0, 0]
max_feed_mm_per_min = 6000
backlash_um = 3
hysteresis_um = 4
encoder_resolution_um = 1
[axis.X.limits]
magnitude_um = 50
slope_mm_per_s = 2
acceleration_mm_per_s2 = 100
[axis.X.thermal]
offset_um_per_k = 2
expansion_um_per_m_k = 11.5
datum_mm = 5
[axis.X.drive]
position_gain_per_s = 110
velocity_gain_per_s = 800
reset_time_s = 0.006
velocity_feed_forward = 0.9
current_loop_s = 0.0003
dead_time_s = 0.0001
resonance_hz = 300
resonance_damping = 0.05
lowest_resonance_hz = 300
[axis.X.friction]
coulomb_mm_per_s = 0.5
presliding_um = 7
stribeck_share = 0.3
stribeck_velocity_mm_per_s = 2
viscous = 0.004
lead_s = 0
adapt = 0.5
[axis.X.dynamic]
lag_s = 0.0
magnitude_um = 40
slope_mm_per_s = 1
acceleration_mm_per_s2 = 90
lag = true
acceleration = true
[[axis.X.periodic]]
period_mm = 5
harmonics_um = [[1, 2], [0.1, 0.2]]
reverse_um = [[1, 2.1]]
[axis.C]
direction = 1
travel_deg = [-400, 400]
joint_deg = [-401, 401]
measured_at_mm = [0, 0, 0]
offset_mm = [0, 0, 0]
max_feed_deg_per_min = 18_000
backlash_urad = 12
hysteresis_urad = 30
encoder_resolution_urad = 5
[axis.C.limits]
magnitude_urad = 1000
slope_deg_per_s = 3
acceleration_deg_per_s2 = 300
[axis.C.thermal]
offset_urad_per_k = 1
expansion_urad_per_rad_k = 2
datum_deg = 90
[axis.C.drive]
position_gain_per_s = 110
velocity_gain_per_s = 800
reset_time_s = 0.006
velocity_feed_forward = 0.9
current_loop_s = 0.0003
dead_time_s = 0.0001
resonance_hz = 300
resonance_damping = 0.05
lowest_resonance_hz = 200
[axis.C.friction]
coulomb_deg_per_s = 0.5
presliding_urad = 7
stribeck_share = 0.3
stribeck_velocity_deg_per_s = 2
viscous = 0.004
lead_s = 0
adapt = 0.5
[axis.C.dynamic]
lag_s = 0.0
magnitude_urad = 40
slope_deg_per_s = 1
acceleration_deg_per_s2 = 90
lag = true
acceleration = true
[[axis.C.periodic]]
period_deg = 4
harmonics_urad = [[1, 2]]
reverse_urad = [[1, 3]]
[location]
A0Z_urad = 1
B0Z_urad = 1
C0Y_urad = 1
EX0C_um = 4
EY0C_um = 4
EZ0C_um = 4
EA0C_urad = 7
EB0C_urad = 7
EC0C_urad = 7
[faults]
resume_mm = 1
resume_deg = 1
command_jump_factor = 3
feedback_jump_mm = 1
feedback_jump_deg = 1
stuck_mm = 1
stuck_deg = 1
[contour]
max_lag_mm = 2
[contour.feedback]
proportional = 0.2
integral_per_s = 9
max_feed_mm_per_min = 5000
watch_um = 20
[compensation]
fade_deg = 3
[kinematics]
tool_axis = [0, 1, 0]
singular_cone_deg = 0.5
[roundness]
points = 1024
probe_slots = [188, 667]
harmonics = [2, 100]
noise_gain_limit = 100
probe_gain_um = [1, 1, 1]
probe_zero = [0, 0, 0]
probe_low = [-100, -100, -100]
probe_high = [100, 100, 100]
spindle_counts_per_revolution = 10000
spindle_direction = 1
spindle_index_tolerance_counts = 10
stop_s = 1
filter_upr = 50
revolutions = 8
units_per_cycle = 1
[roundness.arm]
crank_mm = 45
wheel_mm = 300
pin_mm = 27.5
counts_per_revolution = 10000
direction = 1
tolerance_deg = 1
[roundness.infeed]
axis = "X"
direction = 1
harmonics = [2, 50]
gain = 0.25
delay_revolutions = 2
contact_deg = 180
drive_delay_s = 0
limit_um = 20
noise_gain_limit = 10
[[crosstalk]]
tip = "X"
from = "X"
k_um_per_m_per_s2 = 1
[[crosstalk]]
tip = "X"
from = "C"
k_um_per_deg_per_s2 = 2
[[crosstalk]]
tip = "X"
from = "C"
over = "X"
table = [[0, 1], [10, 2]]
"#;

/// For each key a value that the core, or the reader before it, refuses.
const WRONG: &[(&str, &str)] = &[
    ("name", "\"\""),
    ("chain", "\"w C' X' b\""),
    ("tool_mm", "[0, 2e6, 0]"),
    ("reference_temperature_c", "-300"),
    ("axis.X.table", "\"gone.csv\""),
    ("axis.X.travel_mm", "[20, 0]"),
    ("axis.X.joint_mm", "[1, 21]"),
    ("axis.X.measured_at_mm", "[0, 0, 2e6]"),
    ("axis.X.offset_mm", "[2e6, 0, 0]"),
    ("axis.X.max_feed_mm_per_min", "0"),
    ("axis.X.backlash_um", "2000"),
    ("axis.X.hysteresis_um", "200"),
    ("axis.X.encoder_resolution_um", "0"),
    ("axis.X.limits.magnitude_um", "0"),
    ("axis.X.limits.slope_mm_per_s", "0"),
    ("axis.X.limits.acceleration_mm_per_s2", "0"),
    ("axis.X.thermal.offset_um_per_k", "200"),
    ("axis.X.thermal.expansion_um_per_m_k", "2000"),
    ("axis.X.thermal.datum_mm", "2e6"),
    ("axis.C.direction", "2"),
    ("axis.C.travel_deg", "[400, -400]"),
    ("axis.C.joint_deg", "[-401, 399]"),
    ("axis.C.measured_at_mm", "[2e6, 0, 0]"),
    ("axis.C.offset_mm", "[0, 2e6, 0]"),
    ("axis.C.max_feed_deg_per_min", "0"),
    ("axis.C.backlash_urad", "20000"),
    ("axis.C.hysteresis_urad", "3000"),
    ("axis.C.encoder_resolution_urad", "0"),
    ("axis.C.limits.magnitude_urad", "0"),
    ("axis.C.limits.slope_deg_per_s", "0"),
    ("axis.C.limits.acceleration_deg_per_s2", "0"),
    ("axis.C.thermal.offset_urad_per_k", "2000"),
    ("axis.C.thermal.expansion_urad_per_rad_k", "2000"),
    ("axis.C.thermal.datum_deg", "2e9"),
    ("location.A0Z_urad", "20000"),
    ("location.B0Z_urad", "20000"),
    ("location.C0Y_urad", "20000"),
    ("location.EX0C_um", "2000"),
    ("location.EY0C_um", "2000"),
    ("location.EZ0C_um", "2000"),
    ("location.EA0C_urad", "20000"),
    ("location.EB0C_urad", "20000"),
    ("location.EC0C_urad", "20000"),
    ("faults.resume_mm", "0"),
    ("faults.resume_deg", "0"),
    ("faults.command_jump_factor", "0"),
    ("faults.feedback_jump_mm", "0"),
    ("faults.feedback_jump_deg", "0"),
    ("faults.stuck_mm", "0"),
    ("faults.stuck_deg", "0"),
    ("contour.max_lag_mm", "0"),
    ("axis.X.drive.position_gain_per_s", "0"),
    ("axis.X.drive.velocity_gain_per_s", "0"),
    ("axis.X.drive.reset_time_s", "0"),
    ("axis.X.drive.velocity_feed_forward", "1.1"),
    ("axis.X.drive.current_loop_s", "0"),
    ("axis.X.drive.dead_time_s", "-0.001"),
    ("axis.X.drive.resonance_hz", "0"),
    ("axis.X.drive.resonance_damping", "1"),
    ("axis.X.drive.lowest_resonance_hz", "400"),
    ("axis.X.friction.coulomb_mm_per_s", "-1"),
    ("axis.X.friction.presliding_um", "0"),
    ("axis.X.friction.stribeck_share", "-0.1"),
    ("axis.X.friction.stribeck_velocity_mm_per_s", "0"),
    ("axis.X.friction.viscous", "-0.1"),
    ("axis.X.friction.lead_s", "-0.001"),
    ("axis.X.friction.adapt", "1.1"),
    ("axis.X.periodic.period_mm", "0"),
    ("axis.X.periodic.harmonics_um", "[[2000, 0]]"),
    ("axis.X.periodic.reverse_um", "[[0, 2000]]"),
    ("axis.X.dynamic.magnitude_um", "0"),
    ("axis.X.dynamic.slope_mm_per_s", "0"),
    ("axis.X.dynamic.acceleration_mm_per_s2", "0"),
    ("axis.X.dynamic.lag", "1"),
    ("axis.X.dynamic.acceleration", "0"),
    ("axis.X.dynamic.lag_s", "-0.001"),
    ("axis.C.drive.position_gain_per_s", "0"),
    ("axis.C.drive.velocity_gain_per_s", "0"),
    ("axis.C.drive.reset_time_s", "0"),
    ("axis.C.drive.velocity_feed_forward", "1.1"),
    ("axis.C.drive.current_loop_s", "0"),
    ("axis.C.drive.dead_time_s", "-0.001"),
    ("axis.C.drive.resonance_hz", "1e5"),
    ("axis.C.drive.resonance_damping", "-0.1"),
    ("axis.C.drive.lowest_resonance_hz", "0.1"),
    ("axis.C.friction.coulomb_deg_per_s", "-1"),
    ("axis.C.friction.presliding_urad", "0"),
    ("axis.C.friction.stribeck_share", "-0.1"),
    ("axis.C.friction.stribeck_velocity_deg_per_s", "0"),
    ("axis.C.friction.viscous", "-0.1"),
    ("axis.C.friction.lead_s", "-0.001"),
    ("axis.C.friction.adapt", "1.1"),
    ("axis.C.periodic.period_deg", "7"),
    ("axis.C.periodic.harmonics_urad", "[[20000, 0]]"),
    ("axis.C.periodic.reverse_urad", "[]"),
    ("axis.C.dynamic.magnitude_urad", "0"),
    ("axis.C.dynamic.slope_deg_per_s", "0"),
    ("axis.C.dynamic.acceleration_deg_per_s2", "0"),
    ("axis.C.dynamic.lag", "1"),
    ("axis.C.dynamic.acceleration", "0"),
    ("axis.C.dynamic.lag_s", "-0.001"),
    ("contour.feedback.proportional", "20"),
    ("contour.feedback.integral_per_s", "-1"),
    ("contour.feedback.max_feed_mm_per_min", "0"),
    ("contour.feedback.watch_um", "0"),
    ("crosstalk.tip", "\"C\""),
    ("crosstalk.from", "\"Y\""),
    ("crosstalk.over", "\"B\""),
    ("crosstalk.table", "[[0, 1], [0, 2]]"),
    ("crosstalk.k_um_per_m_per_s2", "2000"),
    ("crosstalk.k_um_per_deg_per_s2", "2000"),
    ("compensation.fade_deg", "46"),
    ("kinematics.tool_axis", "[0, 0, 0]"),
    ("kinematics.singular_cone_deg", "46"),
    ("roundness.points", "1000"),
    ("roundness.probe_slots", "[188, 0]"),
    ("roundness.probe_angles_deg", "[180, 30]"),
    ("roundness.harmonics", "[1, 100]"),
    ("roundness.noise_gain_limit", "0"),
    ("roundness.probe_gain_um", "[1, 0, 1]"),
    ("roundness.probe_zero", "[0, 0, 2e9]"),
    ("roundness.probe_low", "[-2e9, -100, -100]"),
    ("roundness.probe_high", "[100, -100, 100]"),
    ("roundness.spindle_counts_per_revolution", "100"),
    ("roundness.spindle_direction", "0"),
    ("roundness.spindle_index_tolerance_counts", "5000"),
    ("roundness.stop_s", "0"),
    ("roundness.filter_upr", "51"),
    ("roundness.revolutions", "0"),
    ("roundness.units_per_cycle", "0"),
    ("roundness.arm.crank_mm", "400"),
    ("roundness.arm.wheel_mm", "0"),
    ("roundness.arm.pin_mm", "0"),
    ("roundness.arm.counts_per_revolution", "0"),
    ("roundness.arm.direction", "0"),
    ("roundness.arm.tolerance_deg", "0"),
    ("roundness.infeed.axis", "\"C\""),
    ("roundness.infeed.direction", "0"),
    ("roundness.infeed.harmonics", "[2, 400]"),
    ("roundness.infeed.gain", "0"),
    ("roundness.infeed.delay_revolutions", "0"),
    ("roundness.infeed.contact_deg", "400"),
    ("roundness.infeed.drive_delay_s", "1"),
    // Within its range, but beyond the axis' correction limit.
    ("roundness.infeed.limit_um", "60"),
    ("roundness.infeed.noise_gain_limit", "0"),
];

/// Reads a machine; returns a refusal without the folder.
fn read(machine: &str) -> Result<Machine, String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("machine.toml"), machine).unwrap();
    fs::write(folder.path().join("x.csv"), "X_mm,EXX_um\n0,1\n10,2\n20,3\n").unwrap();
    let prefix = format!("{}/", folder.path().display());
    Machine::read(folder.path()).map_err(|error| error.to_string().replace(&prefix, ""))
}

/// The machine with a different line for a key, and the number of that line.
fn edited(key: &str, new: &str) -> (String, usize) {
    let (mut section, mut line) = (String::new(), None);
    let edit = |(index, text): (usize, &'static str)| {
        if text.starts_with('[') {
            section = format!("{}.", text.trim_matches(['[', ']']));
        }
        match text.split_once(" = ") {
            Some((name, _)) if line.is_none() && format!("{section}{name}") == key => {
                line = Some(index + 1);
                format!("{new}\n")
            }
            _ => format!("{text}\n"),
        }
    };
    let machine = MACHINE.lines().enumerate().map(edit).collect();
    (machine, line.unwrap_or_else(|| panic!("no {key} in the sample")))
}

#[test]
fn every_key_is_refused_at_its_line() {
    read(MACHINE).unwrap();
    for (key, wrong) in WRONG {
        let (_, name) = key.rsplit_once('.').unwrap_or(("", key));
        // The angles replace the slots.
        let replaced = key.replace("probe_angles_deg", "probe_slots");
        let (machine, line) = edited(&replaced, &format!("{name} = {wrong}"));
        let error = read(&machine).expect_err(key);
        let expected = format!("machine.toml:{line}: key {key}: found {wrong}, ");
        let table = *key == "axis.X.table" && error.starts_with(expected.trim_end_matches(", "));
        assert!(table || error.starts_with(&expected), "{error}\n{expected}");
    }
}

#[test]
fn every_field_of_the_file_is_among_them() {
    let tested: BTreeSet<&str> = WRONG.iter().map(|(key, _)| *key).collect();
    for field in Field::ALL {
        for axis in [Axis::X, Axis::C] {
            let Some(key) = field.key(Some(axis)).map(|key| key.to_string()) else { continue };
            // Keys of grids are refused in `grid.rs`, which has their tables. Sections follow from the chain; only rotary axes
            // have a sense and location errors; C has no table here. A model is refused only by a build without it.
            let absent = ["axis.X", "axis.C", "axis.C.table", "axis.X.direction"].contains(&key.as_str())
                || key.ends_with(".friction")
                || key.starts_with("grid.")
                || ["contour.feedback", "compensation.model"].contains(&key.as_str());
            let linear = key.starts_with("location.") && axis == Axis::X;
            assert!(absent || linear || tested.contains(key.as_str()), "{field:?} {key}");
        }
    }
}

/// A default is refused at the line of its section.
#[test]
fn a_default_is_refused_at_its_section() {
    let (machine, _) = edited("axis.X.limits.magnitude_um", "magnitude_um = 10");
    let machine = machine.replace("limit_um = 20\n", "").replace("magnitude_um = 40\n", "magnitude_um = 8\n");
    let line = 1 + machine.lines().position(|line| line == "[roundness.infeed]").unwrap();
    let expected = format!("machine.toml:{line}: key roundness.infeed.limit_um: found 20, the default, needed a limit");
    let error = read(&machine).unwrap_err();
    assert!(error.starts_with(&expected), "{error}\n{expected}");
}

/// Two keys of one section with the same value: the error names the wrong one.
#[test]
fn errors_at_equal_values_name_the_right_key() {
    let (machine, line) = edited("axis.X.thermal.datum_mm", "datum_mm = 2e6");
    let machine = machine.replace("expansion_um_per_m_k = 11.5", "expansion_um_per_m_k = 0");
    assert!(read(&machine).unwrap_err().starts_with(&format!("machine.toml:{line}: key axis.X.thermal.datum_mm")));
    // A radius of the arm that equals its crank.
    let (machine, line) = edited("roundness.arm.pin_mm", "pin_mm = 0");
    let machine = machine.replace("crank_mm = 45", "crank_mm = 0");
    assert!(read(&machine).unwrap_err().starts_with(&format!("machine.toml:{line}: key roundness.arm.pin_mm")));
}
