//! Bounds for the volumetric model: levers, largest errors, contraction of its inverse.

use super::bounds::{Step, contribution, length, reach, sense, slopes, tilt, width};
use super::grid::GridBounds;
use crate::compensation::volumetric::{LEAST_DETERMINANT, LEAST_FADE};
use crate::machine::{AXES, Axis, AxisSettings, Link, MachineSettings, Rows, is_turned, links};

#[cfg(test)]
mod tests;

fn norm(v: &[f64]) -> f64 {
    libm::sqrt(v.iter().map(|x| x * x).sum())
}

/// Largest |component| of the lever from the point where an axis' table applies to the tip, in its carrier's
/// directions, over the reach of all axes, mm.
///
/// If a rotary axis lies between the axis' frame and the tip, any component may be as long as the whole lever.
fn lever<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    settings: &AxisSettings,
) -> [f64; 3] {
    way_to_tip(machine, rows, settings, settings.measured_at_mm)
}

/// Longest distance from the origin of an axis' frame to the tip over the reach of all axes, mm.
fn arm<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    settings: &AxisSettings,
) -> f64 {
    norm(&way_to_tip(machine, rows, settings, [0.0; 3]))
}

/// Like [`lever`], from the position `measured` of the slides beyond the axis.
///
/// Everything between two rotary axes turns together: boxes on both sides of a rotary axis add by their lengths, as the
/// axis may turn them into one line.
fn way_to_tip<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    settings: &AxisSettings,
    measured: [f64; 3],
) -> [f64; 3] {
    let links = links(&machine.chain).unwrap_or_default();
    let on_workpiece = links.iter().any(|link| link.axis == settings.axis && link.carries_workpiece);
    let beyond = links.iter().skip_while(|link| link.axis != settings.axis).skip(1);
    let length = |ranges: &[[f64; 2]; 3]| norm(&ranges.map(|[low, high]| low.abs().max(high.abs())));
    let moved = |ranges: [[f64; 2]; 3], by: [f64; 3], sense: f64| {
        let [[a, b], [c, d], [e, f]] = ranges;
        let [x, y, z] = by.map(|by| sense * by);
        [[a + x, b + x], [c + y, d + y], [e + z, f + z]]
    };
    // From a frame that carries the workpiece, the lever to the tip includes the frame's offset; from one that carries
    // the tool, the offsets beyond it. A rotary axis that carries the tool turns all of its lever.
    let mut turned = settings.axis.is_rotary() && !on_workpiece;
    let mut ranges = moved([[0.0; 2]; 3], settings.offset_mm, if on_workpiece { -1.0 } else { 0.0 });
    // The axis' travel lies between the frame that it moves and the tool, unless its readings include that travel.
    if on_workpiece && !settings.axis.is_rotary() && !settings.is_measured_along_a_line() {
        let [low, high] = reach(settings, rows(settings.axis));
        if let Some([from, to]) = ranges.get_mut(settings.axis.index()) {
            (*from, *to) = (*from + low, *to + high);
        }
    }
    let mut closed = 0.0;
    // The position of measurement is in the carrier's directions, whichever axes turn beyond.
    let mut apart = [0.0; 3];
    for link in beyond {
        let Some(other) = machine.axis(link.axis) else { continue };
        let rotary = link.axis.is_rotary();
        if !link.carries_workpiece {
            ranges = moved(ranges, other.offset_mm, 1.0);
        }
        if rotary {
            closed += length(&ranges);
            ranges = [[0.0; 2]; 3];
            turned = true;
        }
        if link.carries_workpiece {
            ranges = moved(ranges, other.offset_mm, -1.0);
        }
        let k = link.axis.index();
        if let (false, Some(range), Some(measured)) = (rotary, ranges.get_mut(k), measured.get(k)) {
            let [from, to] = reach(other, rows(link.axis));
            let here = if turned { 0.0 } else { *measured };
            *range = [range[0] + from - here, range[1] + to - here];
            if let (true, Some(apart)) = (turned, apart.get_mut(k)) {
                *apart = *measured;
            }
        }
    }
    ranges = moved(ranges, machine.tool_mm, 1.0);
    if turned {
        [closed + length(&ranges) + norm(&apart); 3]
    } else {
        ranges.map(|[low, high]| low.abs().max(high.abs()))
    }
}

/// Largest |rotation| about X, Y, Z that an axis causes, location errors included, rad.
fn rotations<T: Rows + ?Sized>(
    machine: &MachineSettings,
    settings: &AxisSettings,
    rows: Option<&T>,
    range: [f64; 2],
) -> [f64; 3] {
    let location = machine.location.of(settings.axis);
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

/// Largest tip error, over the reach of all axes, that angular errors cause through their levers, mm: the part that the
/// nine-term form omits. An upper bound: every axis at its worst.
pub fn angular_tip_error<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
) -> f64 {
    let each = machine.axes.iter().map(|axis| {
        let table = rows(axis.axis);
        norm(&swing(rotations(machine, axis, table, reach(axis, table)), lever(machine, &rows, axis)))
    });
    each.sum::<f64>() + norm(&grids.of_tip(machine, &rows).swing)
}

/// Sums over all axes, and growth factors of the chain.
struct Bounds {
    /// Root of the sum of squares of the rotary axes' levers, mm: distance by which turns of length 1 rad move the tip.
    /// At least 1.
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

fn rotary_axes(links: &[Link]) -> f64 {
    links.iter().filter(|link| link.axis.is_rotary()).count() as f64
}

/// Growth of the slides' corrections over the error they correct.
fn slides_gain(links: &[Link]) -> f64 {
    if skewed(links) { libm::sqrt(3.0) / LEAST_DETERMINANT } else { 1.0 }
}

/// Growth of the rotary axes' corrections over the direction's error, rad per rad.
fn rotary_gain(machine: &MachineSettings, links: &[Link]) -> f64 {
    let fade = libm::sin(machine.compensation.fade_deg.to_radians()).max(LEAST_FADE);
    // √n for n columns of length 1 at most; x² (3 − 2x)/x is at most 9/8.
    libm::sqrt(rotary_axes(links)) * 1.125 / fade
}

fn bounds<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
) -> Bounds {
    let links = links(&machine.chain).unwrap_or_default();
    let mut squares: f64 = 1.0;
    let mut bounds =
        Bounds { lever: 0.0, tip: 0.0, turn: 0.0, slides: slides_gain(&links), rotary: rotary_gain(machine, &links) };
    for axis in &machine.axes {
        let table = rows(axis.axis);
        let range = reach(axis, table);
        let lever = lever(machine, rows, axis);
        let rotations = rotations(machine, axis, table, range);
        if axis.axis.is_rotary() {
            let longest = arm(machine, rows, axis).max(norm(&lever));
            squares += longest * longest;
        }
        bounds.turn += norm(&rotations);
        bounds.tip += length(machine, axis, table, range) + norm(&swing(rotations, lever));
    }
    let of_grids = grids.of_tip(machine, rows);
    let largest = [0, 1, 2].map(|k| grids.values(k)).map(|[least, most]| least.abs().max(most.abs()));
    bounds.turn += of_grids.turn;
    bounds.tip += norm(&largest) + norm(&of_grids.swing);
    bounds.lever = libm::sqrt(squares);
    bounds
}

/// Largest |∂d/∂q| of the tip and |∂w/∂q| of the orientation that the motion of an axis causes, with its effect on the
/// levers of the others: mm and rad, per mm or per degree.
fn rates<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
    settings: &AxisSettings,
) -> [f64; 2] {
    let of_grids = grids.of_tip(machine, rows);
    let slopes = rows(settings.axis).map_or([0.0; 6], |rows| slopes(settings, rows));
    let [x, y, z, a, b, c] = slopes;
    let tilted: [f64; 3] =
        [(x, 0), (y, 1), (z, 2)].map(|(slope, k): (f64, usize)| slope + tilt(machine, settings.axis, k).abs());
    let own = norm(&tilted) + norm(&swing([a, b, c], lever(machine, rows, settings)));
    let links = links(&machine.chain).unwrap_or_default();
    let place = |axis: Axis| links.iter().position(|link| link.axis == axis).unwrap_or(0);
    let on_workpiece = links.get(place(settings.axis)).is_some_and(|link| link.carries_workpiece);
    let (mut tip, mut turn) = (0.0, 0.0);
    let arm = arm(machine, rows, settings);
    for other in machine.axes.iter().filter(|other| other.axis != settings.axis) {
        let (here, there) = (place(settings.axis), place(other.axis));
        let same = links.get(there).is_some_and(|link| link.carries_workpiece == on_workpiece);
        let carried = same && if on_workpiece { there < here } else { there > here };
        let range = reach(other, rows(other.axis));
        let rotations = rotations(machine, other, rows(other.axis), range);
        if !settings.axis.is_rotary() {
            // A travel between the other's frame and the tool lengthens its lever.
            tip += if there < here { norm(&rotations) } else { 0.0 };
        } else if carried {
            // The error turns with the carried axes. The tip turns along only on the tool side: with the workpiece the
            // derivative is n × d − w × (n × (p − o)), o on the axis that turns.
            let swung = norm(&swing(rotations, lever(machine, rows, other)));
            let against = if on_workpiece { norm(&rotations) * arm } else { 0.0 };
            tip += length(machine, other, rows(other.axis), range) + swung + against;
            turn += norm(&rotations);
        } else if !on_workpiece {
            tip += norm(&rotations) * arm;
        }
    }
    if settings.axis.is_rotary() {
        let radian = 1f64.to_radians();
        let location = rotations(machine, settings, rows(settings.axis), reach(settings, rows(settings.axis)));
        // The axis' twist is in its carrier's directions; on the tool side the lever to the tip turns with it.
        let under = if on_workpiece { 0.0 } else { norm(&location) * arm };
        // Grids turn the tool side about a point that does not turn with it.
        let swung = if on_workpiece { 0.0 } else { of_grids.turn * arm };
        [own + (tip + under + swung) * radian, norm(&[a, b, c]) + turn * radian]
    } else {
        let [of_tip, of_turn] = of_grids.rates.get(settings.axis.index()).copied().unwrap_or_default();
        [own + tip + of_tip, norm(&[a, b, c]) + of_turn]
    }
}

/// Upper bound of the rate at which the tip error changes with one axis, mm per mm or degree.
pub fn tip_rate<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
    settings: &AxisSettings,
) -> f64 {
    let bounds = bounds(machine, &rows, grids);
    let [tip, _] = rates(machine, &rows, grids, settings);
    tip * bounds.slides
}

/// Upper bound of the norm of the volumetric inverse's Jacobian, and the largest correction it starts from, mm.
///
/// With slides only, it is the Frobenius norm of |∂d/∂q|, times the growth that nearly dependent slide directions
/// cause. With the direction corrected, rotary corrections count as their radians times the root of their levers' sum
/// of squares.
pub(super) fn contraction<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
) -> (f64, f64) {
    let all = bounds(machine, rows, grids);
    let orientation = machine.compensation.orientation;
    let (mut sum, mut magnitude) = (0.0, 0.0);
    for axis in &machine.axes {
        let [tip, turn] = rates(machine, rows, grids, axis);
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

/// Largest factor by which [`contraction`] amplifies thermal growth's slope.
///
/// Corrected rotary axes grow too: 1 rad of their correction, which counts as its lever, turns the tip by as much as
/// that and the direction by √n; the rotary axes and, through their levers, the slides compensate that turn.
pub(super) fn thermal_gain(machine: &MachineSettings) -> f64 {
    let links = links(&machine.chain).unwrap_or_default();
    let slides = slides_gain(&links);
    if !machine.compensation.orientation {
        return slides;
    }
    let turn = libm::sqrt(rotary_axes(&links)) * rotary_gain(machine, &links);
    norm(&[slides, slides * (1.0 + turn), turn])
}

/// Smallest and largest error that a drive corrects under the volumetric model; arguments as for
/// [`super::error_range`].
pub(super) fn error_range<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
    drive: &AxisSettings,
    own: [f64; 2],
) -> (f64, f64) {
    let all = bounds(machine, rows, grids);
    let orientation = machine.compensation.orientation;
    let turned_back = all.rotary * all.turn;
    if drive.axis.is_rotary() {
        let most = if orientation { turned_back.to_degrees() } else { 0.0 };
        return (-most, most);
    }
    let carried = if orientation { turned_back * all.lever } else { 0.0 };
    let links = links(&machine.chain).unwrap_or_default();
    if links.iter().any(|link| !link.axis.is_rotary() && is_turned(&links, link.axis)) {
        let most = all.slides * (all.tip + carried);
        return (-most, most);
    }
    let component = drive.axis.index();
    let [least, most] = grids.values(component);
    let swung = grids.of_tip(machine, rows).swing.get(component).copied().unwrap_or(0.0);
    let mut sum = (least - swung - carried, most + swung + carried);
    for other in &machine.axes {
        let table = rows(other.axis);
        let range = if other.axis == drive.axis { own } else { reach(other, table) };
        let swing = swing(rotations(machine, other, table, range), lever(machine, rows, other));
        if is_turned(&links, other.axis) {
            let most = length(machine, other, table, range) + norm(&swing);
            sum = (sum.0 - most, sum.1 + most);
            continue;
        }
        let location = machine.location.of(other.axis);
        let constant = location.and_then(|errors| errors.get(component)).copied().unwrap_or(0.0);
        let (least, most) = contribution(machine, other, table, component, range);
        let swing = swing.get(component).copied().unwrap_or(0.0);
        sum = (sum.0 + least + constant - swing, sum.1 + most + constant + swing);
    }
    sum
}

/// Steps of all drives that the reversal of one axis causes; `twist`: the steps of its six errors, mm and rad.
pub(super) fn reversal_steps<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    moving: &AxisSettings,
    twist: &[Step; 6],
) -> [Step; AXES] {
    let links = links(&machine.chain).unwrap_or_default();
    let orientation = machine.compensation.orientation;
    let [x, y, z, a, b, c] = *twist;
    // Lost motion acts over the whole distance to the tip; the lever of readings starts at the position of measurement.
    let (measured, whole) = (lever(machine, rows, moving), way_to_tip(machine, rows, moving, [0.0; 3]));
    let lever =
        core::array::from_fn(|k| measured.get(k).copied().unwrap_or(0.0).max(whole.get(k).copied().unwrap_or(0.0)));
    let rotations = [a, b, c].map(|step| width(&step));
    let swing = swing(rotations, lever);
    let mut other_rotations = rotations;
    if let Some(own) = moving.axis.index().checked_sub(Axis::A.index()).and_then(|own| other_rotations.get_mut(own)) {
        *own = 0.0;
    }
    let gain = rotary_gain(machine, &links);
    // A rotary axis compensates its own error alone.
    let others = norm(&other_rotations) * gain;
    // The rotary axes compensate the other rotations, which moves the tip again.
    let carried = if orientation { others * bounds(machine, rows, &GridBounds::NONE).lever } else { 0.0 };
    let anywhere = is_turned(&links, moving.axis)
        || links.iter().any(|link| !link.axis.is_rotary() && is_turned(&links, link.axis));
    let mut steps = [[0.0; 2]; AXES];
    for (drive, step) in machine.axes.iter().zip(&mut steps) {
        if drive.axis.is_rotary() {
            if !orientation {
                continue;
            }
            let own = if drive.axis == moving.axis { [a, b, c] } else { [[0.0; 2]; 3] };
            let [least, most] =
                drive.axis.index().checked_sub(Axis::A.index()).and_then(|k| own.get(k)).copied().unwrap_or_default();
            let [least, most] = if sense(machine, drive) < 0.0 { [-most, -least] } else { [least, most] };
            // The fade makes the axis' own step smaller.
            *step = [(least.min(0.0) - others).to_degrees(), (most.max(0.0) + others).to_degrees()];
        } else if anywhere {
            let length = slides_gain(&links) * (norm(&[x, y, z].map(|step| width(&step))) + norm(&swing) + carried);
            *step = [-length, length];
        } else {
            let k = drive.axis.index();
            let [least, most] = [x, y, z].get(k).copied().unwrap_or_default();
            let around = swing.get(k).copied().unwrap_or(0.0) + carried;
            *step = [least - around, most + around];
        }
    }
    steps
}
