//! Checks of drives, friction, dynamic correction, contour feedback and cross-talk.

use super::drive::{is_stable, stiffness};
use super::margins::{Closed, Margins, rigid};
use super::open_loop::decibels;
use super::resonance::{gain_without_notch, margins};
use super::{Margin, Notch, RESONANCE_MARGIN_DB, Spread, need};
use crate::error::{ConfigError, Field};
use crate::machine::{Axis, AxisSettings, DriveFigures, MachineSettings};
use crate::part;

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
        resonances(settings.axis, drive)?;
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

/// Checks that a resonance has a damping, and is not below the lowest one.
fn resonances(axis: Axis, drive: &DriveFigures) -> Result<(), ConfigError> {
    let DriveFigures { resonance_hz, resonance_damping, lowest_resonance_hz, .. } = *drive;
    let wrong = |field, found, needed| ConfigError::new(field, found, needed).on(axis);
    let damped = resonance_hz == 0.0 || resonance_damping > 0.0;
    need(damped, wrong(Field::ResonanceDamping, 0.0, "the damping of the resonance, 0.001 to 0.9 of critical"))?;
    let known = resonance_damping == 0.0 || resonance_hz > 0.0;
    need(known, wrong(Field::Resonance, 0.0, "the frequency of the resonance with this damping"))?;
    let outside = resonance_hz == 0.0 || lowest_resonance_hz <= resonance_hz;
    let error = wrong(Field::LowestResonance, lowest_resonance_hz, "at most the stated resonance");
    need(outside, ConfigError { bound: Some(resonance_hz), ..error })
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
    feedback_margins_within(machine, period_s, |_| Spread::LEAST)
}

/// Like [`feedback_margins`], with the uncertainty of the stated resonances.
pub fn feedback_margins_within(
    machine: &MachineSettings,
    period_s: f64,
    spread: impl Fn(Axis) -> Spread,
) -> impl Iterator<Item = (Axis, Margins)> {
    loops(machine, period_s).map(move |(axis, closed)| (axis, margins(&closed, &spread(axis))))
}

/// The loops of the contour feedback.
pub(super) fn loops(machine: &MachineSettings, period_s: f64) -> impl Iterator<Item = (Axis, Closed<'_>)> {
    let linear = machine.axes.iter().filter(|axis| !axis.axis.is_rotary());
    linear.filter_map(move |axis| {
        let (feedback, drive) = (machine.contour.feedback.as_ref()?, axis.servo.drive.as_ref()?);
        Some((axis.axis, Closed { drive, friction: axis.servo.friction.as_ref(), feedback, period_s }))
    })
}

/// Decides which drives have a notch in the contour feedback, from their figures: where a machine is compiled.
pub fn decide_notches(machine: &mut MachineSettings) {
    for place in 0..machine.axes.len() {
        let Some(letter) = machine.axes.get(place).map(|own| own.axis) else { return };
        // Any period: the choice does not depend on it.
        let own = loops(machine, 0.0).find(|(axis, _)| *axis == letter);
        let gain = own.map_or(0.0, |(_, closed)| gain_without_notch(&closed));
        if let Some(drive) = machine.axes.get_mut(place).and_then(|own| own.servo.drive.as_mut()) {
            drive.gain_without_notch = gain;
        }
    }
}

/// Notches of the contour feedback at a servo period, s, by linear axis.
pub(crate) fn notches(machine: &MachineSettings, period_s: f64) -> impl Iterator<Item = (Axis, Notch)> {
    loops(machine, period_s).filter_map(move |(axis, closed)| Some((axis, Notch::of(closed.drive, period_s)?)))
}

/// Refuses gains of the contour feedback as a controller does: with less than [`super::PHASE_MARGIN_DEG`] or
/// [`super::GAIN_MARGIN_DB`] on the rigid drive of an axis at this servo period, s (0: not known yet), or if the drive needs a
/// notch for which the servo is too slow. [`Margins`] lists the loops. The margin at the resonances is [`feedback_within`]'s.
///
/// # Errors
/// The proportional gain, or the integral one if the proportional gain is zero; bound: its largest permitted value at
/// this ratio of the two, rounded down to three digits; 0 if no gain is safe.
pub fn feedback(machine: &MachineSettings, period_s: f64) -> Result<(), ConfigError> {
    refuse(machine, &mut loops(machine, period_s).map(|(axis, closed)| (axis, on_controller(&closed))))
}

/// The margins of the rigid drive; where its notch is left out, also the margin at the resonance without it.
fn on_controller(closed: &Closed<'_>) -> Margins {
    let DriveFigures { gain_without_notch, resonance_hz, .. } = *closed.drive;
    let notch = Notch::of(closed.drive, closed.period_s);
    let rigid = rigid(closed, notch.as_ref());
    if gain_without_notch == 0.0 || notch.is_some() {
        return rigid;
    }
    let value = RESONANCE_MARGIN_DB + decibels(gain_without_notch);
    let resonance = Some(Margin { value, frequency_hz: resonance_hz });
    Margins { resonance, factor: rigid.factor.min(gain_without_notch), ..rigid }
}

/// Like [`feedback`], also with less than [`RESONANCE_MARGIN_DB`] at the resonances, with the uncertainty of the stated ones:
/// where a machine is compiled or checked.
///
/// # Errors
/// As [`feedback`].
pub fn feedback_within(
    machine: &MachineSettings,
    period_s: f64,
    spread: impl Fn(Axis) -> Spread,
) -> Result<(), ConfigError> {
    refuse(machine, &mut feedback_margins_within(machine, period_s, spread))
}

/// Refuses gains with which the least of these margins is too small.
fn refuse(machine: &MachineSettings, all: &mut dyn Iterator<Item = (Axis, Margins)>) -> Result<(), ConfigError> {
    let (Some(settings), Some(_)) = (&machine.contour.feedback, part::DYNAMIC) else { return Ok(()) };
    let Some((axis, margins)) = all.reduce(|least, next| if next.1.factor < least.1.factor { next } else { least })
    else {
        return Ok(());
    };
    let factor = margins.factor;
    let proportional = settings.proportional > 0.0;
    let (field, found) = match proportional {
        true => (Field::Proportional, settings.proportional),
        false => (Field::Integral, settings.integral_per_s),
    };
    let resonant = margins.resonance.is_some_and(|margin| factor * margin_factor(margin.value) >= 1.0 - 1e-9);
    let drive = machine.axis(axis).and_then(|own| own.servo.drive);
    let known = drive.is_some_and(|drive| drive.states_resonance());
    let left_out = margins.notch.is_none() && drive.is_some_and(|drive| drive.gain_without_notch > 0.0);
    let needed = match (proportional, resonant) {
        _ if factor == 0.0 => NO_GAIN,
        (true, false) => {
            "60 degrees of phase margin and 12 dB of gain margin; at this ratio of the gains it may be at most"
        }
        (false, false) => "60 degrees of phase margin and 12 dB of gain margin; it may be at most",
        (_, true) if left_out => TOO_SLOW,
        (true, true) if known => {
            "6 dB of margin at the resonances of the axis; at this ratio of the gains it may be at most"
        }
        (false, true) if known => "6 dB of margin at the resonances of the axis; it may be at most",
        (true, true) => UNKNOWN_RATIO,
        (false, true) => UNKNOWN,
    };
    let error = ConfigError::new(field, found, needed).on(axis);
    need(factor >= 1.0, ConfigError { bound: Some(rounded_down(found * factor)), ..error })
}

const TOO_SLOW: &str = "a servo at least four times as fast as the resonance, for the notch there, or 6 dB of margin \
                        without it; at this ratio of the gains it may be at most";

const NO_GAIN: &str = "a drive that is stable by itself with gains and resonance 10 % off: no gain is safe; without \
                       [contour.feedback] the feed-forward still works; it may be at most";

const UNKNOWN: &str = "6 dB of margin at any resonance above 100 Hz with 2 % damping, because none is stated \
                       (resonance_hz and resonance_damping, or lowest_resonance_hz); it may be at most";
const UNKNOWN_RATIO: &str = "6 dB of margin at any resonance above 100 Hz with 2 % damping, because none is stated \
                             (resonance_hz and resonance_damping, or lowest_resonance_hz); at this ratio of the gains it \
                             may be at most";

/// The present gain at the resonances over the permitted one.
fn margin_factor(margin_db: f64) -> f64 {
    libm::exp10((RESONANCE_MARGIN_DB - margin_db) / 20.0)
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
