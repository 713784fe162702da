//! Bounds for the volumetric model: levers, largest errors, contraction of its inverse.

use super::chain::{self, Link};
use super::inverse::{contribution, length, reach, slopes, tilt};
use crate::compensation::Rows;
use crate::compensation::volumetric::{LEAST_DETERMINANT, LEAST_FADE};
use crate::machine::{Axis, AxisSettings, MachineSettings};

fn norm(v: &[f64]) -> f64 {
    libm::sqrt(v.iter().map(|x| x * x).sum())
}

/// Largest |component| of the lever from the point where an axis' table holds to the tip, in its carrier's directions,
/// over the reach of all axes, mm.
///
/// Where a rotary axis stands between the axis' frame and the tip, any component may be as long as all of it.
fn lever<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    settings: &AxisSettings,
) -> [f64; 3] {
    let links = chain::links(&machine.chain).unwrap_or_default();
    let beyond = links.iter().skip_while(|link| link.axis != settings.axis).skip(1);
    let (mut low, mut high) = (machine.tool_mm, machine.tool_mm);
    let mut turned = settings.axis.is_rotary();
    let own = links.iter().find(|link| link.axis == settings.axis);
    let mut add = |range: [f64; 2], k: usize| {
        if let (Some(l), Some(h)) = (low.get_mut(k), high.get_mut(k)) {
            (*l, *h) = (*l + range[0], *h + range[1]);
        }
    };
    // From a frame that carries the workpiece the way to the tip goes over its own offset, of a frame that carries the
    // tool over those beyond.
    let mut offset = |settings: &AxisSettings, carries_workpiece: bool| {
        for (k, length) in settings.offset_mm.into_iter().enumerate() {
            let length = if carries_workpiece { -length } else { length };
            add([length; 2], k);
        }
    };
    if own.is_some_and(|link| link.carries_workpiece) {
        offset(settings, true);
    }
    for link in beyond.clone() {
        if let Some(other) = machine.axes.iter().find(|other| other.axis == link.axis) {
            offset(other, link.carries_workpiece);
        }
    }
    for link in beyond {
        let Some(other) = machine.axes.iter().find(|other| other.axis == link.axis) else { continue };
        if link.axis.is_rotary() {
            turned = true;
            continue;
        }
        let k = link.axis.index();
        let measured = settings.measured_at_mm.get(k).copied().unwrap_or(0.0);
        let [from, to] = reach(other, rows(link.axis));
        add([from - measured, to - measured], k);
    }
    let boxed: [f64; 3] = core::array::from_fn(|k| match (low.get(k), high.get(k)) {
        (Some(low), Some(high)) => low.abs().max(high.abs()),
        _ => 0.0,
    });
    if turned { [norm(&boxed) + norm(&settings.measured_at_mm); 3] } else { boxed }
}

/// Largest |rotation| about X, Y, Z that an axis causes, location errors included, rad.
fn rotations<T: Rows + ?Sized>(
    machine: &MachineSettings,
    settings: &AxisSettings,
    rows: Option<&T>,
    range: [f64; 2],
) -> [f64; 3] {
    let location = settings.axis.index().checked_sub(3).and_then(|index| machine.location.rotary.get(index));
    core::array::from_fn(|k| {
        let (least, most) = contribution(machine, settings, rows, 3 + k, range);
        let constant = location.and_then(|errors| errors.get(3 + k)).copied().unwrap_or(0.0);
        (least + constant).abs().max((most + constant).abs())
    })
}

/// Largest tip error along X, Y, Z that the rotations of an axis cause through their lever, mm.
fn swing(rotations: [f64; 3], lever: [f64; 3]) -> [f64; 3] {
    let ([a, b, c], [x, y, z]) = (rotations, lever);
    [b * z + c * y, c * x + a * z, a * y + b * x]
}

/// Largest tip error, over the reach of all axes, that angular errors cause through their levers, mm: what the
/// nine-term form leaves out. An upper bound: every axis wherever it is worst.
pub fn angular_tip_error<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
) -> f64 {
    let each = machine.axes.iter().map(|axis| {
        let table = rows(axis.axis);
        norm(&swing(rotations(machine, axis, table, reach(axis, table)), lever(machine, &rows, axis)))
    });
    each.sum()
}

/// Sums over all axes and what the chain makes of them.
struct Bounds {
    /// Longest lever of any axis, mm.
    lever: f64,
    /// Largest error of the tip and of the orientation, mm and rad.
    tip: f64,
    turn: f64,
    /// Growth of the slides' corrections over the error they correct.
    slides: f64,
    /// Growth of the rotary axes' corrections over the direction's error, rad per rad.
    rotary: f64,
}

/// Whether the slides' directions in the bed may differ from a rotated X, Y, Z.
fn skewed(links: &[Link]) -> bool {
    let carriers = |slide: &Link| {
        let place = links.iter().position(|link| link.axis == slide.axis);
        let nearer =
            move |other: usize| place.is_some_and(|p| if slide.carries_workpiece { other > p } else { other < p });
        let mut mask = 0u8;
        for (index, link) in links.iter().enumerate() {
            if link.axis.is_rotary() && link.carries_workpiece == slide.carries_workpiece && nearer(index) {
                mask |= 1 << link.axis.index();
            }
        }
        mask
    };
    let mut slides = links.iter().filter(|link| !link.axis.is_rotary()).map(carriers);
    let first = slides.next();
    slides.any(|other| Some(other) != first)
}

fn bounds<'r, T: Rows + ?Sized + 'r>(machine: &MachineSettings, rows: &impl Fn(Axis) -> Option<&'r T>) -> Bounds {
    let links = chain::links(&machine.chain).unwrap_or_default();
    let fade = libm::sin(machine.compensation.fade_deg.to_radians()).max(LEAST_FADE);
    let mut bounds = Bounds {
        lever: 1.0,
        tip: 0.0,
        turn: 0.0,
        slides: if skewed(&links) { libm::sqrt(3.0) / LEAST_DETERMINANT } else { 1.0 },
        // Two columns of length 1 at most; x² (3 − 2x)/x is at most 9/8.
        rotary: libm::sqrt(2.0) * 1.125 / fade,
    };
    for axis in &machine.axes {
        let table = rows(axis.axis);
        let range = reach(axis, table);
        let lever = lever(machine, rows, axis);
        let rotations = rotations(machine, axis, table, range);
        bounds.lever = bounds.lever.max(norm(&lever));
        bounds.turn += norm(&rotations);
        bounds.tip += length(machine, axis, table, range) + norm(&swing(rotations, lever));
    }
    bounds
}

/// Largest |∂d/∂q| of the tip and |∂w/∂q| of the orientation that the motion of an axis causes, with what it does to the
/// levers of the others: mm and rad, per mm or per degree.
fn rates<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    settings: &AxisSettings,
) -> [f64; 2] {
    let slopes = rows(settings.axis).map_or([0.0; 6], |rows| slopes(settings, rows));
    let [x, y, z, a, b, c] = slopes;
    let tilted: [f64; 3] =
        [(x, 0), (y, 1), (z, 2)].map(|(slope, k): (f64, usize)| slope + tilt(machine, settings.axis, k).abs());
    let own = norm(&tilted) + norm(&swing([a, b, c], lever(machine, rows, settings)));
    let links = chain::links(&machine.chain).unwrap_or_default();
    let place = |axis: Axis| links.iter().position(|link| link.axis == axis).unwrap_or(0);
    let on_workpiece = links.get(place(settings.axis)).is_some_and(|link| link.carries_workpiece);
    let (mut tip, mut turn) = (0.0, 0.0);
    let arm = norm(&lever(machine, rows, settings));
    for other in machine.axes.iter().filter(|other| other.axis != settings.axis) {
        let (here, there) = (place(settings.axis), place(other.axis));
        let same = links.get(there).is_some_and(|link| link.carries_workpiece == on_workpiece);
        let carried = same && if on_workpiece { there < here } else { there > here };
        let range = reach(other, rows(other.axis));
        let rotations = rotations(machine, other, rows(other.axis), range);
        if !settings.axis.is_rotary() {
            // A travel between the other's frame and the tool makes its lever longer.
            tip += if there < here { norm(&rotations) } else { 0.0 };
        } else if carried {
            // The error turns with what is carried; on the workpiece side the way to the tip turns against it too.
            let swung = norm(&swing(rotations, lever(machine, rows, other)));
            tip += length(machine, other, rows(other.axis), range) + if on_workpiece { 2.0 * swung } else { swung };
            turn += norm(&rotations);
        } else if !on_workpiece {
            tip += norm(&rotations) * arm;
        }
    }
    if settings.axis.is_rotary() {
        let radian = 1f64.to_radians();
        let location = rotations(machine, settings, rows(settings.axis), reach(settings, rows(settings.axis)));
        // Its own twist stands in its carrier's directions; on the tool side the way to the tip turns under it.
        let under = if on_workpiece { 0.0 } else { norm(&location) * arm };
        [own + (tip + under) * radian, norm(&[a, b, c]) + turn * radian]
    } else {
        [own + tip, norm(&[a, b, c])]
    }
}

/// Upper bound of the rate at which the tip error changes with one axis, mm per mm or degree.
pub fn tip_rate<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
    settings: &AxisSettings,
) -> f64 {
    let bounds = bounds(machine, &rows);
    let [tip, _] = rates(machine, &rows, settings);
    tip * bounds.slides
}

/// Upper bound of the norm of the volumetric inverse's Jacobian, and the largest correction it starts from, mm.
///
/// Slides only: the Frobenius norm of |∂d/∂q|, times what directions that stand badly to each other make of it. With the
/// direction corrected, rotary corrections count as the longest lever times their radians.
pub(super) fn contraction<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
) -> (f64, f64) {
    let all = bounds(machine, rows);
    let orientation = machine.compensation.orientation;
    let (mut sum, mut magnitude) = (0.0, 0.0);
    for axis in &machine.axes {
        let [tip, turn] = rates(machine, rows, axis);
        let limit = axis.limits.magnitude;
        if axis.axis.is_rotary() {
            if orientation {
                let (tip, turn) = (tip.to_degrees() / all.lever, turn.to_degrees() * all.rotary);
                let slides = all.slides * (tip + turn + all.slides * all.tip / all.lever);
                sum += slides * slides + turn * turn;
                magnitude += (all.lever * limit.to_radians()) * (all.lever * limit.to_radians());
            }
        } else {
            let carried = if orientation { all.lever * all.rotary * turn } else { 0.0 };
            let slides = all.slides * (tip + carried);
            sum += slides * slides + carried * carried;
            magnitude += limit * limit;
        }
    }
    (libm::sqrt(sum), libm::sqrt(magnitude))
}

/// Largest growth that [`contraction`] makes of thermal growth's slope.
pub(super) fn thermal_gain(machine: &MachineSettings) -> f64 {
    let links = chain::links(&machine.chain).unwrap_or_default();
    if skewed(&links) { libm::sqrt(3.0) / LEAST_DETERMINANT } else { 1.0 }
}

/// Smallest and largest error that a drive corrects under the volumetric model; arguments as for
/// [`super::error_range`].
pub(super) fn error_range<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    drive: &AxisSettings,
    own: [f64; 2],
) -> (f64, f64) {
    let all = bounds(machine, rows);
    let orientation = machine.compensation.orientation;
    let turned_back = all.rotary * all.turn;
    if drive.axis.is_rotary() {
        let most = if orientation { turned_back.to_degrees() } else { 0.0 };
        return (-most, most);
    }
    let carried = if orientation { turned_back * all.lever } else { 0.0 };
    let links = chain::links(&machine.chain).unwrap_or_default();
    if links.iter().any(|link| !link.axis.is_rotary() && chain::is_turned(&links, link.axis)) {
        let most = all.slides * (all.tip + carried);
        return (-most, most);
    }
    let component = drive.axis.index();
    let mut sum = (-carried, carried);
    for other in &machine.axes {
        let table = rows(other.axis);
        let range = if other.axis == drive.axis { own } else { reach(other, table) };
        let swing = swing(rotations(machine, other, table, range), lever(machine, rows, other));
        if chain::is_turned(&links, other.axis) {
            let most = length(machine, other, table, range) + norm(&swing);
            sum = (sum.0 - most, sum.1 + most);
            continue;
        }
        let location = other.axis.index().checked_sub(3).and_then(|index| machine.location.rotary.get(index));
        let constant = location.and_then(|errors| errors.get(component)).copied().unwrap_or(0.0);
        let (least, most) = contribution(machine, other, table, component, range);
        let swing = swing.get(component).copied().unwrap_or(0.0);
        sum = (sum.0 + least + constant - swing, sum.1 + most + constant + swing);
    }
    sum
}
