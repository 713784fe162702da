//! Checks of a machine description, run when tables are compiled and again when they are loaded.
//!
//! All checks run at build, in double precision, without allocation; they cost a few lookups per table line.

mod bounds;
mod drive;
mod grid;
mod inverse;
mod margins;
mod notch;
mod open_loop;
mod periodic;
mod resonance;
mod reversal;
mod scalars;
mod servo;
mod two_masses;
mod volumetric;

pub use bounds::{contribution, reach, slopes, tilt};
pub use grid::{GridBounds, grids};
pub(crate) use inverse::jacobian_norms;
pub use inverse::{
    INVERSE_TOLERANCE_MM, MOST_PASSES, error_range, inverse_passes, jacobian_norm, joint_range, machine_passes,
};
pub use margins::{GAIN_MARGIN_DB, Margins, PHASE_MARGIN_DEG};
pub use notch::Notch;
pub use open_loop::Margin;
pub use resonance::{ASSUMED_DAMPING, ASSUMED_LOWEST_HZ, RESONANCE_MARGIN_DB, Spread, assumed_lowest_hz};
pub use reversal::{HYSTERESIS_PER_STEP, lost_motion, reversal};
pub use servo::{decide_notches, feedback, feedback_margins, feedback_margins_within, feedback_within};
pub(crate) use servo::{notches, of_dynamic};
pub use volumetric::{angular_tip_error, tip_rate};

use crate::error::{ConfigError, Field};
use crate::machine::{
    Axis, AxisSettings, Curve, ErrorModel, GridData, Link, MachineSettings, Rows, links, nine_terms, wraps,
};
use crate::part::{self, Part};
use crate::range;

/// Tolerance within which the values at both ends of a full circle agree, mm.
pub const WRAP_TOLERANCE_MM: f64 = 1e-5;
/// Tolerance within which the values at both ends of a full circle agree, rad.
pub const WRAP_TOLERANCE_RAD: f64 = 1e-8;
/// Maximum number of lines of a table.
pub const MOST_ROWS: usize = 65_535;

fn need(holds: bool, error: ConfigError) -> Result<(), ConfigError> {
    if holds { Ok(()) } else { Err(error) }
}

/// Checks everything except the tables: every number in its physical range ([`crate::range`]), ranges ordered, a
/// well-formed chain, and the axes those of the chain. The margins of the contour feedback need the servo period:
/// [`feedback`], called by [`crate::Config::build`], checks them.
///
/// # Errors
/// The first wrong setting.
pub fn settings(machine: &MachineSettings) -> Result<(), ConfigError> {
    need(!machine.name.is_empty(), ConfigError::new(Field::Name, 0.0, "a name of 1 to 64 bytes"))?;
    need(
        !machine.name.chars().any(char::is_control),
        ConfigError::new(Field::Name, machine.name.len() as f64, "a name without control characters"),
    )?;
    left_out(machine)?;
    let links = links(&machine.chain)?;
    axes_of_chain(machine, &links)?;
    if !machine.compensation.is_volumetric() {
        nine_terms(&links)?;
    }
    scalars::machine(machine)?;
    five_axes(machine)?;
    machine.axes.iter().try_for_each(axis_settings)?;
    servo::settings(machine)?;
    periodic::settings(machine, &links)?;
    roundness(machine)
}

/// Checks that no setting needs a part that this build leaves out.
fn left_out(machine: &MachineSettings) -> Result<(), ConfigError> {
    let need = |part: Part, used: bool, field| need(part.is_built() || !used, ConfigError::left_out(part, field));
    need(Part::Volumetric, machine.compensation.model == ErrorModel::Volumetric, Field::Model)?;
    need(Part::Gauge, machine.roundness.is_some(), Field::Points)?;
    need(Part::Dynamic, machine.contour.feedback.is_some(), Field::Feedback)?;
    need(Part::Dynamic, !machine.crosstalk.is_empty(), Field::CrosstalkTable)?;
    machine.axes.iter().try_for_each(|axis| {
        let here = |error: ConfigError| error.on(axis.axis);
        need(Part::Rotary, axis.axis.is_rotary(), Field::Axes).map_err(here)?;
        need(Part::Dynamic, axis.servo.friction.is_some(), Field::Friction).map_err(here)?;
        need(Part::Dynamic, axis.servo.dynamic.is_some(), Field::DynamicMagnitude).map_err(here)
    })
}

/// Checks that the tool axis has a direction: a length of 1e-3 to 1e3.
fn five_axes(machine: &MachineSettings) -> Result<(), ConfigError> {
    let length = libm::sqrt(machine.kinematics.tool_axis.iter().map(|x| x * x).sum());
    need(
        (1e-3..=1e3).contains(&length),
        ConfigError::new(Field::ToolAxis, length, "a tool_axis of a length of about 1"),
    )
}

/// Checks the gauge, if the machine has one: its settings, and that the machine has the infeed axis and lets it move
/// far enough.
fn roundness(machine: &MachineSettings) -> Result<(), ConfigError> {
    let (Some(settings), Some(_)) = (&machine.roundness, part::GAUGE) else { return Ok(()) };
    settings.check()?;
    let Some(infeed) = &settings.infeed else { return Ok(()) };
    let index = infeed.axis.index() as f64;
    let Some(axis) = machine.axes.iter().find(|known| known.axis == infeed.axis) else {
        return Err(ConfigError::new(Field::InfeedAxis, index, "an axis of the machine"));
    };
    let needed = "a limit within the magnitude of the axis' correction";
    need(infeed.limit_um * 1e-3 <= axis.limits.magnitude, ConfigError::new(Field::InfeedLimit, infeed.limit_um, needed))
}

/// Checks that the axes are those of the chain, each once, in the order X Y Z A B C.
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
    let ([low, high], [joint_low, joint_high]) = (axis.travel, axis.joint);
    let sense = f64::from(axis.direction);
    need(
        axis.direction == 1 || (axis.direction == -1 && axis.axis.is_rotary()),
        wrong(Field::Direction, sense, "1, or -1 for a rotary axis"),
    )?;
    need(low < high, wrong(Field::Travel, high, "a high end above the low end"))?;
    need(joint_low < joint_high, wrong(Field::Joint, joint_high, "a high end above the low end"))?;
    need(joint_low <= low, wrong(Field::Joint, joint_low, "a range that contains the travel"))?;
    need(joint_high >= high, wrong(Field::Joint, joint_high, "a range that contains the travel"))
}

/// A rule that every table must satisfy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TableRule {
    /// Number of lines.
    Count,
    /// Positions of a linear axis lie in their range.
    Position,
    /// Positions of a rotary axis lie in their range.
    Angle,
    /// Translations lie in their range.
    Translation,
    /// Rotations lie in their range.
    Rotation,
    /// Positions increase.
    Increasing,
    /// The ends of a full circle agree.
    Closed,
    /// Slope of the axis' own error.
    Slope,
}

impl TableRule {
    /// The rule in words.
    pub const fn needed(self) -> &'static str {
        match self {
            TableRule::Count => "2 to 65535 lines",
            TableRule::Position => range::POSITION.linear.needed,
            TableRule::Angle => range::POSITION.rotary.needed,
            TableRule::Translation => range::TRANSLATION.needed,
            TableRule::Rotation => range::ROTATION.needed,
            TableRule::Increasing => "a position above that of the line before, by at least 0.001",
            TableRule::Closed => "the value at the start of the full circle, within 0.01 um or 0.01 urad",
            TableRule::Slope => "a slope of the own error below 1",
        }
    }
}

/// Location of a fault in a table.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TableFault {
    /// The rule that is broken.
    pub rule: TableRule,
    /// Line, from 0.
    pub row: usize,
    /// Component, 0 to 5; `None` if the fault is not in a component.
    pub component: Option<usize>,
    /// Whether the fault is in the reverse column.
    pub reverse: bool,
    /// Value found: number of lines; mm, degrees, rad; a slope in mm/mm or rad/rad.
    pub found: f64,
}

/// Checks a table: 2 to 65535 lines, every value in its range, positions increasing, a full circle closed, and the
/// slope of the axis' own positioning error below 1 (mm/mm; rad/rad), so that the corrected position grows with the
/// command.
///
/// # Errors
/// The first wrong line, and its column.
pub fn table(settings: &AxisSettings, rows: &(impl Rows + ?Sized)) -> Result<(), TableFault> {
    let count = rows.len();
    let position = |rule, row, found| TableFault { rule, row, component: None, reverse: false, found };
    if !(2..=MOST_ROWS).contains(&count) {
        return Err(position(TableRule::Count, 0, count as f64));
    }
    let mut before = f64::NEG_INFINITY;
    for index in 0..count {
        let row = rows.row(index).ok_or(position(TableRule::Count, index, index as f64))?;
        if !range::POSITION.of(settings.axis).contains(row.position) {
            let rule = if settings.axis.is_rotary() { TableRule::Angle } else { TableRule::Position };
            return Err(position(rule, index, row.position));
        }
        if row.position < before + range::LEAST_PITCH * (1.0 - 1e-6) {
            return Err(position(TableRule::Increasing, index, row.position));
        }
        before = row.position;
        for (twist, reverse) in [(row.forward, false), (row.reverse, true)] {
            for (component, found) in twist.into_iter().enumerate() {
                let (range, rule) = match component {
                    0..3 => (range::TRANSLATION, TableRule::Translation),
                    _ => (range::ROTATION, TableRule::Rotation),
                };
                if !range.contains(found) {
                    return Err(TableFault { rule, row: index, component: Some(component), reverse, found });
                }
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

/// Checks that the ends of a full circle agree.
fn closed(axis: Axis, rows: &(impl Rows + ?Sized)) -> Result<(), TableFault> {
    let last = rows.len().saturating_sub(1);
    let (Some(first), Some(end)) = (rows.row(0), rows.row(last)) else { return Ok(()) };
    if !wraps(axis, rows) {
        return Ok(());
    }
    for (start, end, reverse) in [(first.forward, end.forward, false), (first.reverse, end.reverse, true)] {
        for (component, (start, end)) in start.into_iter().zip(end).enumerate() {
            // Two decimals that differ by exactly the tolerance pass, however they are rounded.
            let tolerance = if component < 3 { WRAP_TOLERANCE_MM } else { WRAP_TOLERANCE_RAD } * (1.0 + 1e-9);
            if (end - start).abs() > tolerance {
                let component = Some(component);
                return Err(TableFault { rule: TableRule::Closed, row: last, component, reverse, found: end });
            }
        }
    }
    Ok(())
}

/// Checks a table like [`table`], but returns the fault as an error of the configuration.
///
/// # Errors
/// [`Field::Table`] with the axis and the line.
pub fn rows(settings: &AxisSettings, rows: &(impl Rows + ?Sized)) -> Result<(), ConfigError> {
    table(settings, rows).map_err(|fault| {
        ConfigError::new(Field::Table, fault.found, fault.rule.needed()).on(settings.axis).at(fault.row)
    })
}

/// Checks a whole machine: [`settings`], [`rows`] of every table, [`grids`], [`joint_range`], [`reversal()`]; returns the
/// number of lookups that its exact inverse needs. Tables are optional: errors stated in the settings apply without
/// one.
///
/// # Errors
/// The first fault found.
pub fn machine<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    tables: impl Fn(Axis) -> Option<&'r T>,
    grids: &[GridData<'_>],
) -> Result<u8, ConfigError> {
    // Behind `dyn`, whatever the closure's type, so that a firmware contains one copy of the checks.
    let tables: &dyn Fn(Axis) -> Option<&'r T> = &tables;
    settings(machine)?;
    for axis in &machine.axes {
        if let Some(table) = tables(axis.axis) {
            rows(axis, table)?;
        }
    }
    self::grids(machine, grids)?;
    let grids = GridBounds::of(grids);
    joint_range(machine, tables, &grids)?;
    reversal(machine, tables, &grids)?;
    machine_passes(machine, tables, &grids)
}

#[cfg(test)]
mod tests;
