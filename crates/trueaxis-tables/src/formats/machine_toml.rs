//! Writes a whole machine.

use super::axis_csv::{axis_csv_name, location_lines, write_axis_csv};
use super::decimal::{shortest, shortest_read_as};
use super::grid_csv::{grid_csv_name, grid_section, write_grid_csv};
use super::servo_toml;
use super::toml_lines::{Lines, section};
use crate::Machine;
use crate::read::units::degrees_from_urad;
use std::fmt::Write;
use trueaxis::machine::{
    AxisSettings, CompensationSettings, ContourSettings, ErrorModel, FaultSettings, Interpolation, KinematicsSettings,
    Lookup, PeriodicSettings,
};
use trueaxis::roundness::{ArmSettings, GaugeSettings, InfeedSettings, ProbeAngles};

/// The files of a machine, as (file name, text): the axis tables `x.csv` … and, last, `machine.toml`.
///
/// `comment` is written at the head of `machine.toml`, each line after a `#`. Settings at their defaults are omitted. Reading
/// the files gives the machine again; only settings that are stored in other units than they are written in (feeds, a rotary
/// axis' angular limits) may differ in the last place.
pub fn machine_files(machine: &Machine, comment: &str) -> Vec<(String, String)> {
    let settings = &machine.settings;
    let mut text = String::new();
    for line in comment.lines() {
        let _ = writeln!(text, "# {line}");
    }
    let quoted = |text: &str| toml::Value::from(text);
    let _ = writeln!(text, "name = {}\nchain = {}", quoted(&settings.name), quoted(&settings.chain));
    let _ = writeln!(text, "tool_mm = {:?}", settings.tool_mm);
    let _ = writeln!(text, "reference_temperature_c = {:?}", settings.reference_temperature_c);
    let mut files = Vec::new();
    for (own, table) in machine.axes() {
        let name = table.map(|table| {
            let name = axis_csv_name(own.axis);
            files.push((name.clone(), write_axis_csv(table, own.axis)));
            name
        });
        axis(&mut text, own, name.as_deref(), settings.chain.contains(&format!("{}'", own.axis.letter())));
        let periods = settings.periodic.iter().filter(|period| period.axis == own.axis);
        periods.for_each(|period| periodic(&mut text, period));
    }
    section(&mut text, "location", &location_lines(&settings.location));
    let mut lines = Lines::default();
    let (faults, plain) = (&settings.faults, FaultSettings::default());
    for (key, value, default) in [
        ("resume", faults.resume, plain.resume),
        ("feedback_jump", faults.feedback_jump, plain.feedback_jump),
        ("stuck", faults.stuck, plain.stuck),
    ] {
        for (unit, (value, default)) in ["mm", "deg"].into_iter().zip(value.into_iter().zip(default)) {
            lines.number(&format!("{key}_{unit}"), value, default);
        }
    }
    lines.number("command_jump_factor", faults.command_jump_factor, plain.command_jump_factor);
    section(&mut text, "faults", &lines.0);
    let mut lines = Lines::default();
    lines.number("max_lag_mm", settings.contour.max_lag_mm, ContourSettings::default().max_lag_mm);
    section(&mut text, "contour", &lines.0);
    if let Some(feedback) = &settings.contour.feedback {
        servo_toml::feedback(&mut text, feedback);
    }
    let mut lines = Lines::default();
    let (compensation, plain) = (&settings.compensation, CompensationSettings::default());
    lines.put("model", if compensation.model == ErrorModel::Nine { "\"nine\"" } else { "\"volumetric\"" });
    if compensation.orientation {
        lines.put("orientation", true);
    }
    lines.number("fade_deg", compensation.fade_deg, plain.fade_deg);
    section(&mut text, "compensation", &lines.0);
    let mut lines = Lines::default();
    let (kinematics, plain) = (&settings.kinematics, KinematicsSettings::default());
    lines.numbers("tool_axis", &kinematics.tool_axis, &plain.tool_axis);
    lines.number("singular_cone_deg", kinematics.singular_cone_deg, plain.singular_cone_deg);
    section(&mut text, "kinematics", &lines.0);
    if let Some(gauge) = &settings.roundness {
        roundness(&mut text, gauge);
    }
    for crosstalk in &settings.crosstalk {
        servo_toml::crosstalk(&mut text, crosstalk);
    }
    for (number, grid) in machine.grids.iter().enumerate() {
        let csv = grid_csv_name(number);
        grid_section(&mut text, grid, &csv);
        files.push((csv, write_grid_csv(grid)));
    }
    files.push((String::from("machine.toml"), text));
    files
}

fn axis(text: &mut String, own: &AxisSettings, table: Option<&str>, carries_workpiece: bool) {
    let rotary = own.axis.is_rotary();
    let plain = AxisSettings::with_defaults(own.axis, carries_workpiece);
    let (unit, micro) = if rotary { ("deg", "urad") } else { ("mm", "um") };
    let mut lines = Lines::default();
    if let Some(table) = table {
        lines.put("table", format_args!("\"{table}\""));
    }
    lines.put("interpolation", if own.interpolation == Interpolation::Linear { "\"linear\"" } else { "\"cubic\"" });
    for (key, lookup) in [("lookup", own.lookup), ("cross_lookup", own.cross_lookup)] {
        if lookup == Lookup::Feedback {
            lines.put(key, "\"feedback\"");
        }
    }
    if own.direction != plain.direction {
        lines.put("direction", own.direction);
    }
    lines.numbers(&format!("travel_{unit}"), &own.travel, &plain.travel);
    let [low, high] = own.travel;
    let reach = own.limits.magnitude;
    lines.numbers(&format!("joint_{unit}"), &own.joint, &[low - reach, high + reach]);
    lines.numbers("offset_mm", &own.offset_mm, &plain.offset_mm);
    lines.numbers("measured_at_mm", &own.measured_at_mm, &plain.measured_at_mm);
    lines.number(&format!("max_feed_{unit}_per_min"), own.max_feed_per_s * 60.0, plain.max_feed_per_s * 60.0);
    let small = |lines: &mut Lines, key: &str, value: f64, default: f64| {
        if !rotary {
            lines.scaled(key, value, default, 1e3);
        } else if value != default {
            let urad = shortest_read_as(value, value.to_radians() * 1e6, degrees_from_urad);
            lines.put(key, format_args!("{urad:?}"));
        }
    };
    small(&mut lines, &format!("backlash_{micro}"), own.backlash, plain.backlash);
    small(&mut lines, &format!("hysteresis_{micro}"), own.hysteresis, plain.hysteresis);
    if let Some(step) = own.encoder_resolution {
        small(&mut lines, &format!("encoder_resolution_{micro}"), step, 0.0);
    }
    let name = format!("axis.{}", own.axis.letter());
    section(text, &name, &lines.0);

    let mut lines = Lines::default();
    small(&mut lines, &format!("magnitude_{micro}"), own.limits.magnitude, plain.limits.magnitude);
    lines.number(&format!("slope_{unit}_per_s"), own.limits.slope_per_s, plain.limits.slope_per_s);
    let acceleration = plain.limits.acceleration_per_s2;
    lines.number(&format!("acceleration_{unit}_per_s2"), own.limits.acceleration_per_s2, acceleration);
    section(text, &format!("{name}.limits"), &lines.0);

    let mut lines = Lines::default();
    small(&mut lines, &format!("offset_{micro}_per_k"), own.thermal.offset_per_k, 0.0);
    let key = if rotary { "expansion_urad_per_rad_k" } else { "expansion_um_per_m_k" };
    lines.scaled(key, own.thermal.expansion_per_k, 0.0, 1e6);
    lines.number(&format!("datum_{unit}"), own.thermal.datum, 0.0);
    section(text, &format!("{name}.thermal"), &lines.0);
    servo_toml::axis(text, own);
}

/// `[[axis.*.periodic]]`.
fn periodic(text: &mut String, own: &PeriodicSettings) {
    let (unit, micro, base, scale) =
        if own.axis.is_rotary() { ("deg", "urad", 1f64.to_radians(), 1e6) } else { ("mm", "um", 1.0, 1e3) };
    let _ = write!(text, "\n[[axis.{}.periodic]]\nperiod_{unit} = {:?}\n", own.axis.letter(), own.period);
    for (key, pairs) in [("harmonics", &own.harmonics), ("reverse", &own.reverse)] {
        let figure = |figure: &f64| format!("{:?}", shortest(figure * base, scale));
        let pairs: Vec<String> = pairs.iter().map(|[a, b]| format!("[{}, {}]", figure(a), figure(b))).collect();
        if !pairs.is_empty() {
            let _ = writeln!(text, "{key}_{micro} = [{}]", pairs.join(", "));
        }
    }
}

fn roundness(text: &mut String, gauge: &GaugeSettings) {
    let mut lines = Lines::default();
    lines.put("points", gauge.points);
    match gauge.angles {
        ProbeAngles::Slots { p, q } => lines.put("probe_slots", format_args!("[{p}, {q}]")),
        ProbeAngles::Degrees { phi2, phi3 } => lines.put("probe_angles_deg", format_args!("[{phi2:?}, {phi3:?}]")),
    }
    lines.put("harmonics", format_args!("[{}, {}]", gauge.band.first, gauge.band.last));
    lines.put("noise_gain_limit", format_args!("{:?}", gauge.noise_gain_limit));
    let probes = gauge.probes;
    lines.put("probe_gain_um", format_args!("{:?}", probes.map(|probe| probe.gain_um)));
    lines.put("probe_zero", format_args!("{:?}", probes.map(|probe| probe.zero)));
    lines.put("probe_low", format_args!("{:?}", probes.map(|probe| probe.range[0])));
    lines.put("probe_high", format_args!("{:?}", probes.map(|probe| probe.range[1])));
    let spindle = &gauge.spindle;
    lines.put("spindle_counts_per_revolution", spindle.counts);
    lines.put("spindle_direction", spindle.direction);
    lines.put("spindle_index", spindle.index);
    lines.put("spindle_index_tolerance_counts", spindle.index_tolerance);
    if let Some(filter) = gauge.filter {
        lines.put("filter_upr", filter);
    }
    lines.put("revolutions", gauge.revolutions);
    lines.put("units_per_cycle", gauge.slices_per_cycle);
    lines.put("stop_s", format_args!("{:?}", gauge.stop_s));
    section(text, "roundness", &lines.0);
    if let Some(arm) = &gauge.arm {
        section(text, "roundness.arm", &arm_lines(arm).0);
    }
    if let Some(infeed) = &gauge.infeed {
        section(text, "roundness.infeed", &infeed_lines(infeed).0);
    }
}

fn arm_lines(arm: &ArmSettings) -> Lines {
    let mut lines = Lines::default();
    lines.put("crank_mm", format_args!("{:?}", arm.lengths.crank_mm));
    lines.put("wheel_mm", format_args!("{:?}", arm.lengths.wheel_mm));
    lines.put("pin_mm", format_args!("{:?}", arm.lengths.pin_mm));
    lines.put("counts_per_revolution", arm.counts);
    lines.put("direction", arm.direction);
    lines.put("tolerance_deg", format_args!("{:?}", arm.tolerance_deg));
    lines
}

fn infeed_lines(infeed: &InfeedSettings) -> Lines {
    let mut lines = Lines::default();
    lines.put("axis", format_args!("\"{}\"", infeed.axis.letter()));
    lines.put("direction", infeed.direction);
    lines.put("gain", format_args!("{:?}", infeed.gain));
    lines.put("delay_revolutions", infeed.delay_revolutions);
    lines.put("contact_deg", format_args!("{:?}", infeed.contact_deg));
    lines.put("drive_delay_s", format_args!("{:?}", infeed.drive_delay_s));
    lines.put("limit_um", format_args!("{:?}", infeed.limit_um));
    lines.put("noise_gain_limit", format_args!("{:?}", infeed.noise_gain_limit));
    lines.put("harmonics", format_args!("[{}, {}]", infeed.band.first, infeed.band.last));
    lines
}
