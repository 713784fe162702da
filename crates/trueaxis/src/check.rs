//! What a machine description has to keep to: checked where tables are compiled and again where they are loaded.
//!
//! Everything here runs at build, in double precision, without allocation; its cost is a few look-ups per table line.

mod bounds;
mod inverse;
mod reversal;
mod volumetric;

pub use bounds::{contribution, reach, slopes, tilt};
pub use inverse::{
    INVERSE_TOLERANCE_MM, MOST_PASSES, error_range, inverse_passes, jacobian_norm, joint_range, machine_passes,
};
pub use reversal::{HYSTERESIS_PER_STEP, lost_motion, reversal};
pub use volumetric::{angular_tip_error, tip_rate};

use crate::error::{ConfigError, Field};
use crate::machine::{Axis, AxisSettings, Curve, Link, MachineSettings, Rows, links, wraps};

/// Values at both ends of a full circle agree within this, mm.
pub const WRAP_TOLERANCE_MM: f64 = 1e-5;
/// Values at both ends of a full circle agree within this, rad.
pub const WRAP_TOLERANCE_RAD: f64 = 1e-8;
/// Most lines of a table.
pub const MOST_ROWS: usize = 65_535;

fn need(holds: bool, error: ConfigError) -> Result<(), ConfigError> {
    if holds { Ok(()) } else { Err(error) }
}

fn finite(values: &[f64], field: Field, axis: Option<Axis>) -> Result<(), ConfigError> {
    match values.iter().enumerate().find(|(_, value)| !value.is_finite()) {
        Some((index, value)) => {
            Err(ConfigError { axis, ..ConfigError::new(field, *value, "finite numbers").at(index) })
        }
        None => Ok(()),
    }
}

/// Everything but the tables: numbers finite, ranges ordered, limits positive, chain well-formed, axes as in the chain.
///
/// # Errors
/// The first setting that is wrong.
pub fn settings(machine: &MachineSettings) -> Result<(), ConfigError> {
    need(!machine.name.is_empty(), ConfigError::new(Field::Name, 0.0, "a name of 1 to 64 bytes"))?;
    need(
        !machine.name.chars().any(char::is_control),
        ConfigError::new(Field::Name, machine.name.len() as f64, "a name without control characters"),
    )?;
    let links = links(&machine.chain)?;
    axes_of_chain(machine, &links)?;
    finite(&machine.tool_mm, Field::Tool, None)?;
    let reference = machine.reference_temperature_c;
    need(
        reference.is_finite() && reference > -273.15,
        ConfigError::new(Field::ReferenceTemperature, reference, "a temperature above -273.15 °C"),
    )?;
    let location = &machine.location;
    finite(&[location.a0z, location.b0z, location.c0y], Field::Location, None)?;
    for (errors, axis) in location.rotary.iter().zip([Axis::A, Axis::B, Axis::C]) {
        finite(errors, Field::Location, Some(axis))?;
    }
    let faults = &machine.faults;
    let [linear_resume, rotary_resume] = faults.resume;
    let [linear_jump, rotary_jump] = faults.feedback_jump;
    let [linear_stuck, rotary_stuck] = faults.stuck;
    for limit in [linear_resume, rotary_resume, linear_jump, rotary_jump, linear_stuck, rotary_stuck] {
        need(limit > 0.0 && limit.is_finite(), ConfigError::new(Field::Faults, limit, "positive limits"))?;
    }
    let factor = faults.command_jump_factor;
    need(
        factor >= 1.0 && factor.is_finite(),
        ConfigError::new(Field::Faults, factor, "a command_jump_factor of at least 1"),
    )?;
    let lag = machine.contour.max_lag_mm;
    need(lag > 0.0 && lag.is_finite(), ConfigError::new(Field::Contour, lag, "a positive max_lag_mm"))?;
    let fade = machine.compensation.fade_deg;
    need((0.0..=45.0).contains(&fade), ConfigError::new(Field::Compensation, fade, "a fade_deg of 0 to 45 degrees"))?;
    five_axes(machine)?;
    machine.axes.iter().try_for_each(axis_settings)?;
    roundness(machine)
}

/// Tool axis and singular cone.
fn five_axes(machine: &MachineSettings) -> Result<(), ConfigError> {
    let kinematics = &machine.kinematics;
    finite(&kinematics.tool_axis, Field::Kinematics, None)?;
    let length = libm::sqrt(kinematics.tool_axis.iter().map(|x| x * x).sum());
    need(
        (1e-3..=1e3).contains(&length),
        ConfigError::new(Field::Kinematics, length, "a tool_axis of a length of about 1"),
    )?;
    let cone = kinematics.singular_cone_deg;
    need(
        (0.0..=45.0).contains(&cone),
        ConfigError::new(Field::Kinematics, cone, "a singular_cone_deg of 0 to 45 degrees"),
    )
}

/// A gauge, where there is one: its settings, and an infeed axis that the machine has and may move far enough.
fn roundness(machine: &MachineSettings) -> Result<(), ConfigError> {
    let Some(settings) = &machine.roundness else { return Ok(()) };
    settings.check()?;
    let Some(infeed) = &settings.infeed else { return Ok(()) };
    let index = infeed.axis.index() as f64;
    let Some(axis) = machine.axes.iter().find(|known| known.axis == infeed.axis) else {
        return Err(ConfigError::new(Field::Infeed, index, "an axis of the machine"));
    };
    let needed = "a limit within the magnitude of the axis' correction";
    need(infeed.limit_um * 1e-3 <= axis.limits.magnitude, ConfigError::new(Field::Infeed, infeed.limit_um, needed))
}

/// The axes are those of the chain, each once, in the order X Y Z A B C.
fn axes_of_chain(machine: &MachineSettings, links: &[Link]) -> Result<(), ConfigError> {
    let count = machine.axes.len() as f64;
    need(!machine.axes.is_empty(), ConfigError::new(Field::Axes, count, "at least one axis"))?;
    for pair in machine.axes.windows(2) {
        let [before, after] = pair else { continue };
        need(
            before.axis < after.axis,
            ConfigError::new(Field::Axes, count, "the order X Y Z A B C, each axis once").on(after.axis),
        )?;
    }
    for axis in &machine.axes {
        need(
            links.iter().any(|link| link.axis == axis.axis),
            ConfigError::new(Field::Axes, count, "only axes that the chain names").on(axis.axis),
        )?;
    }
    for link in links {
        need(
            machine.axes.iter().any(|axis| axis.axis == link.axis),
            ConfigError::new(Field::Axes, count, "every axis that the chain names").on(link.axis),
        )?;
    }
    Ok(())
}

fn axis_settings(axis: &AxisSettings) -> Result<(), ConfigError> {
    let wrong = |field, found, needed| ConfigError::new(field, found, needed).on(axis.axis);
    let on = Some(axis.axis);
    finite(&axis.travel, Field::Travel, on)?;
    finite(&axis.joint, Field::Joint, on)?;
    finite(&axis.offset_mm, Field::Offset, on)?;
    finite(&axis.measured_at_mm, Field::MeasuredAt, on)?;
    let ([low, high], [joint_low, joint_high]) = (axis.travel, axis.joint);
    let sense = f64::from(axis.direction);
    need(
        axis.direction == 1 || (axis.direction == -1 && axis.axis.is_rotary()),
        wrong(Field::Direction, sense, "1, or -1 for a rotary axis"),
    )?;
    let positive = |value: f64| value > 0.0 && value.is_finite();
    let limits = &axis.limits;
    need(positive(axis.max_feed_per_s), wrong(Field::MaxFeed, axis.max_feed_per_s, "a positive feed"))?;
    need(positive(limits.magnitude), wrong(Field::Magnitude, limits.magnitude, "a positive limit"))?;
    need(positive(limits.slope_per_s), wrong(Field::Slope, limits.slope_per_s, "a positive limit"))?;
    let acceleration = limits.acceleration_per_s2;
    need(positive(acceleration), wrong(Field::Acceleration, acceleration, "a positive limit"))?;
    // After the limits: the joint's default is the travel widened by the magnitude.
    need(low < high, wrong(Field::Travel, high, "a high end above the low end"))?;
    need(joint_low < joint_high, wrong(Field::Joint, joint_high, "a high end above the low end"))?;
    need(joint_low <= low, wrong(Field::Joint, joint_low, "a range that contains the travel"))?;
    need(joint_high >= high, wrong(Field::Joint, joint_high, "a range that contains the travel"))?;
    need(axis.backlash.is_finite(), wrong(Field::Backlash, axis.backlash, "a finite number"))?;
    need(
        axis.hysteresis >= 0.0 && axis.hysteresis.is_finite(),
        wrong(Field::Hysteresis, axis.hysteresis, "zero or more"),
    )?;
    let step = axis.encoder_resolution.unwrap_or(1.0);
    need(positive(step), wrong(Field::Encoder, step, "a positive step"))?;
    let thermal = &axis.thermal;
    finite(&[thermal.offset_per_k, thermal.expansion_per_k, thermal.datum], Field::Thermal, on)
}

/// What a table has to keep to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableRule {
    /// Number of lines.
    Count,
    /// Numbers are finite.
    Finite,
    /// Positions increase.
    Increasing,
    /// The ends of a full circle agree.
    Closed,
    /// Slope of the own error.
    Slope,
}

impl TableRule {
    /// The rule in words.
    pub const fn needed(self) -> &'static str {
        match self {
            TableRule::Count => "2 to 65535 lines",
            TableRule::Finite => "a finite number",
            TableRule::Increasing => "a position above that of the line before",
            TableRule::Closed => "the value at the start of the full circle, within 0.01 um or 0.01 urad",
            TableRule::Slope => "a slope of the own error below 1",
        }
    }
}

/// Where a table is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableFault {
    /// What is broken.
    pub rule: TableRule,
    /// Line, from 0.
    pub row: usize,
    /// Component, 0 to 5, where it is one; otherwise the position.
    pub component: Option<usize>,
    /// In the reverse column.
    pub reverse: bool,
    /// What was found: number of lines; mm, degrees, rad; a slope in mm/mm or rad/rad.
    pub found: f64,
}

/// One table: 2 to 65535 lines, finite, positions strictly increasing, a full circle closed, and the slope of the axis'
/// own positioning error below 1 (mm/mm; rad/rad), so that the corrected position grows with the command.
///
/// # Errors
/// The first line that is wrong, and its column.
pub fn table(settings: &AxisSettings, rows: &(impl Rows + ?Sized)) -> Result<(), TableFault> {
    let count = rows.len();
    let position = |rule, row, found| TableFault { rule, row, component: None, reverse: false, found };
    if !(2..=MOST_ROWS).contains(&count) {
        return Err(position(TableRule::Count, 0, count as f64));
    }
    let mut before = f64::NEG_INFINITY;
    for index in 0..count {
        let row = rows.row(index).ok_or(position(TableRule::Count, index, index as f64))?;
        if !row.position.is_finite() {
            return Err(position(TableRule::Finite, index, row.position));
        }
        if row.position <= before {
            return Err(position(TableRule::Increasing, index, row.position));
        }
        before = row.position;
        for (twist, reverse) in [(row.forward, false), (row.reverse, true)] {
            if let Some((component, found)) = twist.into_iter().enumerate().find(|(_, value)| !value.is_finite()) {
                let component = Some(component);
                return Err(TableFault { rule: TableRule::Finite, row: index, component, reverse, found });
            }
        }
    }
    closed(settings.axis, rows)?;
    let own = settings.axis.index();
    for reverse in [false, true] {
        let (slope, row) = Curve::new(settings, rows, own, reverse).steepest();
        let found = if settings.axis.is_rotary() { slope.to_degrees() } else { slope };
        if found.is_nan() || found >= 1.0 {
            return Err(TableFault { rule: TableRule::Slope, row, component: Some(own), reverse, found });
        }
    }
    Ok(())
}

/// The ends of a full circle agree.
fn closed(axis: Axis, rows: &(impl Rows + ?Sized)) -> Result<(), TableFault> {
    let last = rows.len().saturating_sub(1);
    let (Some(first), Some(end)) = (rows.row(0), rows.row(last)) else { return Ok(()) };
    if !wraps(axis, rows) {
        return Ok(());
    }
    for (start, end, reverse) in [(first.forward, end.forward, false), (first.reverse, end.reverse, true)] {
        for (component, (start, end)) in start.into_iter().zip(end).enumerate() {
            // Two decimals that differ by exactly the tolerance pass whatever their rounding.
            let tolerance = if component < 3 { WRAP_TOLERANCE_MM } else { WRAP_TOLERANCE_RAD } * (1.0 + 1e-9);
            if (end - start).abs() > tolerance {
                let component = Some(component);
                return Err(TableFault { rule: TableRule::Closed, row: last, component, reverse, found: end });
            }
        }
    }
    Ok(())
}

/// [`table`] with the fault as an error of the configuration.
///
/// # Errors
/// [`Field::Table`] with the axis and the line.
pub fn rows(settings: &AxisSettings, rows: &(impl Rows + ?Sized)) -> Result<(), ConfigError> {
    table(settings, rows).map_err(|fault| {
        ConfigError::new(Field::Table, fault.found, fault.rule.needed()).on(settings.axis).at(fault.row)
    })
}

/// A whole machine: [`settings`], [`rows`] of every table, at least one table, [`joint_range`], [`reversal`]; returns the look-ups that
/// its exact inverse takes.
///
/// # Errors
/// The first thing that is wrong.
pub fn machine<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    tables: impl Fn(Axis) -> Option<&'r T>,
) -> Result<u8, ConfigError> {
    settings(machine)?;
    let mut count = 0;
    for axis in &machine.axes {
        if let Some(table) = tables(axis.axis) {
            rows(axis, table)?;
            count += 1;
        }
    }
    need(count > 0, ConfigError::new(Field::Table, 0.0, "at least one axis with a table"))?;
    joint_range(machine, &tables)?;
    reversal(machine, &tables)?;
    machine_passes(machine, &tables)
}

#[cfg(test)]
mod tests;
