//! The faces of blocks: where they are touched, and their surfaces.
//!
//! ```text
//! side    s (n′ · p − o) − L/2 − r        n′ = n + θ × n + Σ γ n_i:  n along an axis of the machine, s = ±1 the side
//! top     n′ · p − o − r
//! base    n′ · p − o + L − r              the surface under the block, touched from above beside it
//! ```
//!
//! L is the length between two faces, o and θ are the place and the rotation of the block in its set-up, γ the deviations of
//! its right angles. Turned half a turn about its second length, the block shows the angles to its other lengths with the
//! other sign.

use super::artefact::Artefact;
use super::block::{ANGLES, Block, directions};
use super::place::{Place, unit};
use super::target::{CLEAR_ABOVE, Target, clear_mm};
use super::task::{Probe, Task};
use trueaxis::machine::Axis;
use trueaxis_metrology::calibration::{Part, Surface};

/// Columns and rows of touches lie at these shares of a face.
const SHARES: [f64; 2] = [0.2, 0.8];
/// Room between the tip and the base, mm, with the block as far off its place as a task may be.
const ROOM_MM: f64 = 1.0;
/// Accepted distance of an artefact from its stated place, over the approach.
const OFF_PLACE: f64 = 0.5;
/// Distance from a block's corner at which its base is touched, mm.
const BESIDE_MM: f64 = 5.0;

/// A face to be touched.
struct Face {
    /// Index of its pair.
    pair: usize,
    /// Axis across it.
    axis: usize,
    /// Side of the block that it is on.
    side: f64,
    kind: FaceKind,
}

#[derive(Clone, Copy, PartialEq)]
enum FaceKind {
    Side,
    Top,
    Base,
}

/// Feature of a face: its pair of faces and whether it is the upper one.
fn feature(pair: usize, upper: bool) -> usize {
    2 * pair + usize::from(upper)
}

fn face(place: &Place, feature: usize) -> Face {
    let [axes, _] = directions(place);
    let (pair, upper) = ((feature / 2) % 3, feature % 2 == 1);
    let axis = axes[pair] as usize;
    let kind = match (axis == place.normal.index() % 3, upper) {
        (false, _) => FaceKind::Side,
        (true, true) => FaceKind::Top,
        (true, false) => FaceKind::Base,
    };
    Face { pair, axis, side: if upper { 1.0 } else { -1.0 }, kind }
}

/// Way from the base, or from the top, that a block off its place needs, mm.
pub(super) fn off_place(probe: &Probe) -> f64 {
    OFF_PLACE * probe.approach_mm
}

/// Height of a block at a place, mm.
fn height(block: &Block, place: &Place) -> f64 {
    let [axes, _] = directions(place);
    let up = axes.iter().position(|axis| *axis as usize == place.normal.index() % 3);
    up.map_or(0.0, |up| block.size_mm[up])
}

/// Depths of the two rows of touches on the sides below the top, mm; `None` if the tip finds no room above the base.
pub(super) fn depths(block: &Block, place: &Place, probe: &Probe) -> Option<[f64; 2]> {
    let (high, off) = (height(block, place), off_place(probe));
    let shallow = (SHARES[0] * high).max(off);
    let deep = (SHARES[1] * high).min(high - probe.tip_radius_mm - ROOM_MM - off);
    (deep - shallow >= SHARES[0] * high).then_some([shallow, deep])
}

/// Length of the stylus below the body of the probe that a place needs, mm: the body stays above the block.
fn stylus_mm(block: &Block, place: &Place, probe: &Probe) -> f64 {
    let [_, deep] = depths(block, place, probe).unwrap_or_default();
    let reach = if place.base { height(block, place) } else { deep + probe.tip_radius_mm };
    (reach + ROOM_MM + off_place(probe)).ceil()
}

/// The touches of a block at a place.
pub(super) fn targets(task: &Task, block: &Block, place: &Place, radius: f64) -> Vec<Target> {
    let [axes, _] = directions(place);
    let up = place.normal.index() % 3;
    // Extent along each axis of the machine.
    let mut size = [0.0; 3];
    (0..3).for_each(|pair| size[axes[pair] as usize] = block.size_mm[pair]);
    let depths = depths(block, place, &task.probe).unwrap_or_default();
    let mut targets = Vec::new();
    for pair in 0..block.measured {
        for upper in [false, true] {
            let of = face(place, feature(pair, upper));
            if of.kind == FaceKind::Base && !place.base {
                continue;
            }
            let level: Vec<usize> = (0..3).filter(|axis| *axis != up && *axis != of.axis).collect();
            for [i, j] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
                let mut point = place.at_mm;
                let mut from_above = [false; 3];
                for (axis, share) in level.iter().zip([SHARES[i], SHARES[j]]) {
                    let end = if share < 0.5 { -1.0 } else { 1.0 };
                    point[*axis] += match of.kind {
                        FaceKind::Base => end * (0.5 * size[*axis] + radius + BESIDE_MM),
                        _ => (share - 0.5) * size[*axis],
                    };
                    // Beside the base the tip comes from outside: it takes up the play away from the block.
                    from_above[*axis] = of.kind == FaceKind::Base && end > 0.0;
                }
                let mut approach = [0.0; 3];
                match of.kind {
                    FaceKind::Side => {
                        point[of.axis] += of.side * (0.5 * size[of.axis] + radius);
                        point[up] -= radius + depths[j];
                        approach[of.axis] = -of.side;
                        // Not from below, where the base is near.
                        from_above[up] = true;
                    }
                    FaceKind::Top => approach[up] = -1.0,
                    FaceKind::Base => {
                        point[up] -= size[up];
                        approach[up] = -1.0;
                    }
                }
                targets.push(Target { from_above, ..target(task, feature(pair, upper), point, approach, place) });
            }
        }
    }
    targets
}

fn target(task: &Task, feature: usize, point: [f64; 3], approach: [f64; 3], place: &Place) -> Target {
    let up = place.normal.index() % 3;
    let mut home: [f64; 3] = std::array::from_fn(|k| point[k] - task.probe.approach_mm * approach[k]);
    // Above the top, however deep the touch.
    home[up] = place.at_mm[up] + clear_mm(task) + CLEAR_ABOVE;
    let mut lift = [0.0; 3];
    lift[up] = 1.0;
    Target { feature, point, approach, from_above: [false; 3], home, entry: home, lift: Some(lift), pose: [0.0; 3] }
}

/// Indices of a block's unknowns in the network.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Sizes {
    /// Lengths, mm.
    pub(super) lengths: Vec<usize>,
    /// Differences of these from those of another block, mm; empty if they are the block's own.
    pub(super) differences: Vec<usize>,
    /// Deviations from right angles, rad, in the order of [`ANGLES`].
    pub(super) angles: Vec<usize>,
}

/// Names and initial values of the unknowns of a place: the offsets of its pairs of faces, then its rotation. `tip` is the
/// place in workpiece coordinates.
pub(super) fn place_unknowns(block: &Block, place: &Place, tip: [f64; 3], radius: f64) -> Vec<(String, f64)> {
    let up = place.normal.index() % 3;
    let axes = touched(block, place);
    let start = |axis: usize| tip[axis] - if axis == up { radius } else { 0.0 };
    let name = |what: &str, axis: usize| format!("{what} {}", ['X', 'Y', 'Z'][axis]);
    let offsets = axes.iter().map(|axis| (name("offset", *axis), start(*axis)));
    let turns = turns(&axes).into_iter().map(|axis| (name("turn about", axis), 0.0));
    offsets.chain(turns).collect()
}

/// Axes whose faces are touched.
fn touched(block: &Block, place: &Place) -> Vec<usize> {
    let [axes, _] = directions(place);
    axes[..block.measured].iter().map(|axis| *axis as usize).collect()
}

/// Axes about which a rotation moves a touched face.
fn turns(axes: &[usize]) -> Vec<usize> {
    (0..3).filter(|turn| axes.iter().any(|axis| axis != turn)).collect()
}

/// The surface of a touch. `first` is the first unknown of its place, `elongation` the relative error of all lengths.
pub(super) fn surface(
    block: &Block,
    place: &Place,
    feature: usize,
    sizes: &Sizes,
    (first, elongation): (usize, Option<usize>),
) -> Surface {
    let of = face(place, feature);
    let axes = touched(block, place);
    let [all, senses] = directions(place);
    let part = |unknown, factor, along| Part { unknown, factor, along };
    let offset = axes.iter().position(|axis| *axis == of.axis).unwrap_or_default();
    let mut parts = vec![part(first + offset, 1.0, None)];
    // Share of the length by which the face is beyond the offset.
    let share = match of.kind {
        FaceKind::Side => 0.5 * of.side,
        FaceKind::Top => 0.0,
        FaceKind::Base => -1.0,
    };
    if share != 0.0 {
        parts.push(part(sizes.lengths[of.pair], share, None));
        parts.extend(sizes.differences.get(of.pair).map(|index| part(*index, share, None)));
        parts.extend(elongation.map(|index| part(index, share * block.size_mm[of.pair], None)));
    }
    // A plane turned by θ: n + θ × n, component by component.
    for (index, turn) in turns(&axes).into_iter().enumerate().filter(|(_, turn)| *turn != of.axis) {
        let third = 3 - turn - of.axis;
        let sense = if (of.axis + 3 - turn) % 3 == 1 { -1.0 } else { 1.0 };
        parts.push(part(first + axes.len() + index, sense, Some(unit(third))));
    }
    for (pair, angle) in ANGLES.iter().zip(&sizes.angles).filter(|(pair, _)| pair[1] == of.pair) {
        let sense = f64::from(senses[pair[0]] * senses[pair[1]]);
        parts.push(part(*angle, -sense, Some(unit(all[pair[0]] as usize))));
    }
    let outward = if of.kind == FaceKind::Side { of.side } else { 1.0 };
    Surface::Face { normal: unit(of.axis), outward, known_mm: 0.0, parts }
}

/// Words of the operator's message.
pub(super) fn set_up_text(artefact: &Artefact, block: &Block, place: &Place, probe: &Probe) -> String {
    let name = if block.measured == 1 { "gauge block" } else { "block" };
    let letters = [place.along, place.across].map(Axis::letter);
    let over = if place.reversed { ", turned over about its second length" } else { "" };
    let base = if place.base { ", free room around it on its base" } else { "" };
    let second = if block.measured == 1 {
        String::new()
    } else {
        // All lengths start at one corner: it tells the block from itself turned over.
        let [axes, senses] = directions(place);
        let corner = (0..3_i8).map(|axis| {
            let sense = axes.iter().zip(senses).find(|(of, _)| **of == axis).map_or(1, |(_, sense)| sense);
            format!(" {}{}", if sense > 0 { '-' } else { '+' }, ['X', 'Y', 'Z'][axis as usize])
        });
        format!(", second along {}, its marked corner at{}", letters[1], corner.collect::<String>())
    };
    let stylus = stylus_mm(block, place, probe);
    let what = format!("{name} {}, length along {}{second}{over}{base}", artefact.name, letters[0]);
    format!("{what}, needs a stylus of {stylus} mm")
}
