//! Sums over the tables of all axes: contraction and length of the exact inverse, range of the correction.

use super::bounds::{contribution, length, reach, sense, slopes, tilt};
use super::grid::GridBounds;
use super::volumetric;
use crate::compensation::ThermalLine;
use crate::error::{ConfigError, Field};
use crate::machine::{Axis, AxisSettings, Link, MachineSettings, Rows, is_turned, links};

/// Maximum number of lookups of the exact inverse.
pub const MOST_PASSES: u8 = 8;
/// Largest error that the inverse may leave, mm.
pub const INVERSE_TOLERANCE_MM: f64 = 1e-6;

/// Upper bound of the norm of the Jacobian of the error: the Frobenius norm of the largest |slopes|.
///
/// In the volumetric form it includes the slopes of the angular errors times their levers, and the angular errors
/// themselves where a travel lengthens their lever. The rest applies to the nine-term form.
///
/// With linear axes only, the Jacobian is 3 by 3, squareness included. A rotary axis adds its column (mm per degree,
/// with the effect of its rotation on the errors of the axes it carries) and the slope of its positioning error (degree
/// per degree): the norm combines millimetres and degrees. Grids add their slopes. Thermal growth, writable at run
/// time, is not included; the slopes within periods are.
pub fn jacobian_norm<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
) -> f64 {
    jacobian_norms(machine, rows, grids).into_iter().sum()
}

/// [`jacobian_norm`] of the tables and grids, and of the periods.
pub(crate) fn jacobian_norms<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
) -> [f64; 2] {
    let of_periods = steepest_period(machine);
    if machine.compensation.is_volumetric() {
        return [volumetric::contraction(machine, &rows, grids).0, of_periods];
    }
    let links = links(&machine.chain).unwrap_or_default();
    let mut sum = 0.0;
    for settings in &machine.axes {
        let slopes = rows(settings.axis).map_or([0.0; 6], |rows| slopes(settings, rows));
        for (component, slope) in slopes.into_iter().enumerate().take(3) {
            let slope = slope + tilt(machine, settings.axis, component).abs() + grids.slope(settings.axis, component);
            sum += slope * slope;
        }
        if settings.axis.is_rotary() {
            let own = slopes.get(settings.axis.index()).copied().unwrap_or(0.0).to_degrees();
            let swing = swing(machine, &rows, &links, settings.axis).to_radians();
            sum += own * own + swing * swing;
        }
    }
    [libm::sqrt(sum), of_periods]
}

/// Norm of the Jacobian of the periods' errors, which is diagonal.
fn steepest_period(machine: &MachineSettings) -> f64 {
    machine.axes.iter().map(|settings| machine.repeats(settings.axis, 1)).fold(0.0, f64::max)
}

/// Largest length of the errors that `carrier` turns, mm.
fn swing<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    links: &[Link],
    carrier: Axis,
) -> f64 {
    let others = machine.axes.iter().filter(|other| other.axis != carrier && is_turned(links, other.axis));
    others.map(|other| length(machine, other, rows(other.axis), reach(other, rows(other.axis)))).sum()
}

/// Smallest and largest error that a drive corrects, mm; degrees on a rotary axis: the sum over all axes, with the
/// axis' own positions restricted to `own`, the others anywhere in their reach, and grids at their worst. Thermal
/// growth is not included.
pub fn error_range<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
    drive: &AxisSettings,
    own: [f64; 2],
) -> (f64, f64) {
    let repeats = machine.repeats(drive.axis, 0);
    let (least, most) = range_without_periods(machine, &rows, grids, drive, own);
    (least - repeats, most + repeats)
}

fn range_without_periods<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
    drive: &AxisSettings,
    own: [f64; 2],
) -> (f64, f64) {
    if machine.compensation.is_volumetric() {
        return volumetric::error_range(machine, rows, grids, drive, own);
    }
    let axis = drive.axis;
    if axis.is_rotary() {
        let (least, most) = contribution(machine, drive, rows(axis), axis.index(), own);
        let sense = sense(machine, drive);
        let ends = [least.to_degrees() * sense, most.to_degrees() * sense];
        return (ends[0].min(ends[1]), ends[0].max(ends[1]));
    }
    let links = links(&machine.chain).unwrap_or_default();
    let [least, most] = grids.values(axis.index());
    let mut sum = (least, most);
    for other in &machine.axes {
        let rows = rows(other.axis);
        let range = if other.axis == axis { own } else { reach(other, rows) };
        let (least, most) = if is_turned(&links, other.axis) {
            let length = length(machine, other, rows, range);
            (-length, length)
        } else {
            let location = machine.location.of(other.axis);
            let constant = location.and_then(|errors| errors.get(axis.index())).copied().unwrap_or(0.0);
            let (least, most) = contribution(machine, other, rows, axis.index(), range);
            (least + constant, most + constant)
        };
        sum = (sum.0 + least, sum.1 + most);
    }
    sum
}

/// Checks that command + correction stays inside the joint over the declared travel, at any position of the other axes.
///
/// The corrected position grows with the command (slopes are below 1), so it is enough to check both ends of the
/// travel. The correction counts as limited by the magnitude limit.
///
/// # Errors
/// [`Field::Joint`] with the corrected position that leaves the range.
pub fn joint_range<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
) -> Result<(), ConfigError> {
    let rows: &dyn Fn(Axis) -> Option<&'r T> = &rows;
    for drive in &machine.axes {
        let magnitude = drive.limits.magnitude;
        let [low, high] = drive.travel;
        let lowest = low - error_range(machine, rows, grids, drive, [low; 2]).1.min(magnitude).max(-magnitude);
        let highest = high - error_range(machine, rows, grids, drive, [high; 2]).0.min(magnitude).max(-magnitude);
        let [joint_low, joint_high] = drive.joint;
        let wrong = |found| Err(ConfigError::new(Field::Joint, found, "room for travel and correction").on(drive.axis));
        if lowest < joint_low {
            return wrong(lowest);
        }
        if highest > joint_high {
            return wrong(highest);
        }
    }
    Ok(())
}

/// Smallest number of lookups `r ← −E(q + r)`, from `r = 0`, that leaves at most 1e-6 mm.
///
/// After N lookups the error is at most `magnitude · normᴺ` (Banach): 0.1 mm at norm 0.05 takes 4.
///
/// # Errors
/// [`Field::Inverse`]: norm of 1 or more (no contraction), or more than 8 lookups.
pub fn inverse_passes(norm: f64, magnitude_mm: f64) -> Result<u8, ConfigError> {
    if !(0.0..1.0).contains(&norm) {
        return Err(ConfigError::new(Field::Inverse, norm, "a norm of the errors' Jacobian below 1"));
    }
    if !(magnitude_mm >= 0.0 && magnitude_mm.is_finite()) {
        return Err(ConfigError::new(Field::Magnitude, magnitude_mm, "a finite magnitude"));
    }
    let mut error = magnitude_mm;
    for passes in 1..=MOST_PASSES {
        error *= norm;
        // Rounding of a product that should be exactly the tolerance must not cost another lookup.
        if error <= INVERSE_TOLERANCE_MM * (1.0 + 1e-12) {
            return Ok(passes);
        }
    }
    Err(ConfigError::new(Field::Inverse, norm, "a norm of the errors' Jacobian small enough for 8 passes"))
}

/// Number of lookups that the inverse of a whole machine needs, for corrections up to the magnitude limits of all axes
/// together and any thermal growth that may be set at run time ([`ThermalLine::SLOPE_LIMIT`] on top of the norm). Periods take
/// no more look-ups, but their slope counts against the largest norm.
///
/// # Errors
/// As [`inverse_passes`].
pub fn machine_passes<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
) -> Result<u8, ConfigError> {
    let (norm, magnitude) = if machine.compensation.is_volumetric() {
        let (norm, magnitude) = volumetric::contraction(machine, &rows, grids);
        (norm + ThermalLine::<f64>::SLOPE_LIMIT * volumetric::thermal_gain(machine), magnitude)
    } else {
        let squares = machine.axes.iter().map(|axis| axis.limits.magnitude * axis.limits.magnitude);
        let [norm, _] = jacobian_norms(machine, rows, grids);
        (norm + ThermalLine::<f64>::SLOPE_LIMIT, libm::sqrt(squares.sum()))
    };
    inverse_passes(norm + steepest_period(machine), magnitude)?;
    inverse_passes(norm, magnitude)
}
