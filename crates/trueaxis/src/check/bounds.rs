//! Bounds of the errors of one axis, and of their slopes, over its reach.

use crate::compensation::Squareness;
use crate::machine::{Axis, AxisSettings, Curve, MachineSettings, Rows, carries_workpiece};

/// Largest |dE/dq| of each component of a table over both directions: mm or rad per mm or degree; exact.
pub fn slopes(settings: &AxisSettings, rows: &(impl Rows + ?Sized)) -> [f64; 6] {
    core::array::from_fn(|component| {
        let steepest = |reverse| Curve::new(settings, rows, component, reverse).steepest().0;
        steepest(false).max(steepest(true))
    })
}

/// Part of the nine-term error that grows with the position, by squareness; mm/mm.
pub fn tilt(machine: &MachineSettings, axis: Axis, component: usize) -> f64 {
    let slopes = Squareness::<f64>::of(&machine.location).slopes(axis.index());
    slopes.get(component).copied().unwrap_or(0.0)
}

/// The range of an axis' positions: its travel; if that is not declared, the range of its table, or zero.
pub fn reach<T: Rows + ?Sized>(settings: &AxisSettings, rows: Option<&T>) -> [f64; 2] {
    let open = AxisSettings::with_defaults(settings.axis, false).travel;
    if settings.travel != open {
        return settings.travel;
    }
    let ends = rows.and_then(|rows| Some([rows.row(0)?.position, rows.row(rows.len().checked_sub(1)?)?.position]));
    ends.unwrap_or([0.0; 2])
}

/// Smallest and largest error of one component that an axis causes over a range of its positions, in both directions,
/// including backlash and squareness; mm (components 3 to 5: rad, an axis' own with backlash).
pub fn contribution<T: Rows + ?Sized>(
    machine: &MachineSettings,
    settings: &AxisSettings,
    rows: Option<&T>,
    component: usize,
    [low, high]: [f64; 2],
) -> (f64, f64) {
    let tilt = tilt(machine, settings.axis, component);
    let mut both = (f64::INFINITY, f64::NEG_INFINITY);
    for reverse in [false, true] {
        let found = rows.and_then(|rows| Curve::new(settings, rows, component, reverse).extremes(low, high, tilt));
        let (least, most) = found.unwrap_or(((tilt * low).min(tilt * high), (tilt * low).max(tilt * high)));
        let own = reverse && component == settings.axis.index();
        let lost = match (own, settings.axis.is_rotary()) {
            (false, _) => 0.0,
            (true, false) => settings.backlash,
            (true, true) => settings.backlash.to_radians(),
        };
        both = (both.0.min(least + lost), both.1.max(most + lost));
    }
    both
}

/// Largest norm of the translation that an axis causes, including the location errors of a rotary axis, mm.
pub(super) fn length<T: Rows + ?Sized>(
    machine: &MachineSettings,
    settings: &AxisSettings,
    rows: Option<&T>,
    range: [f64; 2],
) -> f64 {
    let location = machine.location.of(settings.axis);
    let mut sum = 0.0;
    for component in 0..3 {
        let (least, most) = contribution(machine, settings, rows, component, range);
        let constant = location.and_then(|errors| errors.get(component)).copied().unwrap_or(0.0);
        let largest = (least + constant).abs().max((most + constant).abs());
        sum += largest * largest;
    }
    libm::sqrt(sum)
}

/// Sense in which the own angular error of a rotary axis adds to its reading, +1 or −1.
pub(super) fn sense(machine: &MachineSettings, drive: &AxisSettings) -> f64 {
    f64::from(drive.direction) * if carries_workpiece(&machine.chain, drive.axis) { -1.0 } else { 1.0 }
}

/// Smallest and largest step of a drive's correction in negative travel relative to positive travel: mm (deg).
pub(super) type Step = [f64; 2];

/// The larger of the two magnitudes.
pub(super) fn width([least, most]: &Step) -> f64 {
    least.abs().max(most.abs())
}
