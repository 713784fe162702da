//! Checks of drives, friction, dynamic correction, contour feedback and cross-talk.

use super::drive::{is_stable, stiffness};
use super::margins::{Margins, margins};
use super::need;
use crate::error::{ConfigError, Field};
use crate::machine::{Axis, AxisSettings, MachineSettings};
use crate::part;

/// Delay of the step itself, in servo periods: one from a reading to the command computed from it, half of one for the
/// hold between two commands.
const OWN_DELAY: f64 = 1.5;

/// Checks everything except the margins. Drive figures must be present wherever a setting needs them, and describe a
/// stable drive; limits must be within those of the axis; cross-talk must act between axes of the machine, onto a
/// linear one, at increasing positions.
pub(super) fn settings(machine: &MachineSettings) -> Result<(), ConfigError> {
    if part::DYNAMIC.is_none() {
        return Ok(());
    }
    machine.axes.iter().try_for_each(axis)?;
    if machine.contour.feedback.is_some() {
        let mut without = machine.axes.iter().filter(|axis| !axis.axis.is_rotary() && axis.servo.drive.is_none());
        if let Some(axis) = without.next() {
            return Err(ConfigError::new(Field::Feedback, 0.0, NEEDS_DRIVE).on(axis.axis));
        }
    }
    crosstalk(machine)
}

const NEEDS_DRIVE: &str = "the figures of the axis' drive as well";

fn axis(settings: &AxisSettings) -> Result<(), ConfigError> {
    let servo = &settings.servo;
    if let Some(drive) = &servo.drive {
        let stiffness = servo.friction.as_ref().map_or(0.0, |friction| stiffness(drive, friction));
        let stable = is_stable(drive, 0.0) && is_stable(drive, stiffness);
        let needed = "a gain at which the drive alone is stable with its other figures";
        let found = drive.position_gain_per_s;
        need(stable, ConfigError::new(Field::PositionGain, found, needed).on(settings.axis))?;
    }
    let wants = |field, wanted: bool| {
        let missing = wanted && servo.drive.is_none();
        need(!missing, ConfigError::new(field, 1.0, NEEDS_DRIVE).on(settings.axis))
    };
    wants(Field::Friction, servo.friction.is_some())?;
    let Some(dynamic) = &servo.dynamic else { return Ok(()) };
    wants(Field::Lag, dynamic.lag)?;
    wants(Field::AccelerationAhead, dynamic.acceleration)?;
    let (found, bound) = (dynamic.limits.magnitude, settings.limits.magnitude);
    let needed = "a magnitude within that of the axis' correction";
    let error = ConfigError::new(Field::DynamicMagnitude, found, needed).on(settings.axis);
    need(found <= bound, ConfigError { bound: Some(bound), ..error })
}

/// Moves an error of a limiter to the key of the dynamic correction's limits.
pub(crate) fn of_dynamic(error: ConfigError) -> ConfigError {
    let field = match error.field {
        Field::Magnitude => Field::DynamicMagnitude,
        Field::Slope => Field::DynamicSlope,
        Field::Acceleration => Field::DynamicAcceleration,
        other => other,
    };
    ConfigError { field, ..error }
}

fn crosstalk(machine: &MachineSettings) -> Result<(), ConfigError> {
    for (index, entry) in machine.crosstalk.iter().enumerate() {
        let wrong = |field, found, needed| ConfigError::new(field, found, needed).at(index);
        for (field, axis) in
            [(Field::CrosstalkTip, entry.tip), (Field::CrosstalkFrom, entry.from), (Field::CrosstalkOver, entry.over)]
        {
            need(machine.axis(axis).is_some(), wrong(field, axis.index() as f64, "an axis of the machine"))?;
        }
        let tip = wrong(Field::CrosstalkTip, entry.tip.index() as f64, "a linear axis");
        need(!entry.tip.is_rotary(), tip)?;
        need(!entry.points.is_empty(), wrong(Field::CrosstalkTable, 0.0, "at least one point"))?;
        for pair in entry.points.windows(2) {
            let [[before, _], [position, _]] = pair else { continue };
            let apart = position - before >= crate::range::LEAST_PITCH * (1.0 - 1e-6);
            let needed = "positions that increase by at least 0.001";
            need(apart, wrong(Field::CrosstalkTable, *position, needed))?;
        }
    }
    Ok(())
}

/// Margins of the contour feedback on every linear axis with drive figures, for a servo period, s. Empty without
/// contour feedback.
pub fn feedback_margins(machine: &MachineSettings, period_s: f64) -> impl Iterator<Item = (Axis, Margins)> {
    let linear = machine.axes.iter().filter(|axis| !axis.axis.is_rotary());
    linear.filter_map(move |axis| {
        let (feedback, drive) = (machine.contour.feedback.as_ref()?, axis.servo.drive.as_ref()?);
        Some((axis.axis, margins(drive, axis.servo.friction.as_ref(), feedback, OWN_DELAY * period_s)))
    })
}

/// Refuses gains of the contour feedback that leave less than [`super::PHASE_MARGIN_DEG`] or [`super::GAIN_MARGIN_DB`]
/// on an axis at this servo period, s (0: not known yet). [`Margins`] lists the loops.
///
/// # Errors
/// The proportional gain, or the integral one if the proportional gain is zero; bound: its largest permitted value at
/// this ratio of the two, rounded down to three digits.
pub fn feedback(machine: &MachineSettings, period_s: f64) -> Result<(), ConfigError> {
    let (Some(settings), Some(_)) = (&machine.contour.feedback, part::DYNAMIC) else { return Ok(()) };
    let all = feedback_margins(machine, period_s).map(|(axis, margins)| (axis, margins.factor));
    let Some((axis, factor)) = all.reduce(|least, next| if next.1 < least.1 { next } else { least }) else {
        return Ok(());
    };
    let (field, found, needed) = match settings.proportional > 0.0 {
        true => (
            Field::Proportional,
            settings.proportional,
            "60 degrees of phase margin and 12 dB of gain margin; at this ratio of the gains it may be at most",
        ),
        false => (
            Field::Integral,
            settings.integral_per_s,
            "60 degrees of phase margin and 12 dB of gain margin; it may be at most",
        ),
    };
    let error = ConfigError::new(field, found, needed).on(axis);
    need(factor >= 1.0, ConfigError { bound: Some(rounded_down(found * factor)), ..error })
}

/// Rounds to three digits, towards zero.
fn rounded_down(value: f64) -> f64 {
    let digits = 2.0 - libm::floor(libm::log10(value));
    if !digits.is_finite() || digits.abs() > 200.0 {
        return value;
    }
    let (up, down) = (libm::exp10(digits.max(0.0)), libm::exp10((-digits).max(0.0)));
    libm::floor(value * up / down) * down / up
}
