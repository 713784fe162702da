//! Where an artefact fits.

use crate::calibrate::artefact::Artefact;
use crate::calibrate::kinematics::Ideal;
use crate::calibrate::place::{Place, printed};
use crate::calibrate::target::{Target, clear_mm};
use crate::calibrate::task::Task;
use crate::calibrate::touches::of_place;

/// Room along an axis below which one position is enough, and below which two are, mm.
const ONE: f64 = 30.0;
const TWO: f64 = 90.0;
/// Room between the reference and another artefact, beside the tip, mm.
const BESIDE: f64 = 10.0;

/// Lowest and highest position of X, Y and Z.
pub(super) type Range = [[f64; 2]; 3];

/// Extents of the touches of an artefact, from its origin.
pub(super) struct Extent {
    /// Centre of the tip at the touches.
    pub(super) touched: Range,
    /// All of the ways between them.
    pub(super) ways: Range,
}

fn bounds<'t>(targets: &'t [Target], points: impl Fn(&'t Target) -> Vec<[f64; 3]>, more: f64) -> Range {
    let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for point in targets.iter().flat_map(points) {
        for k in 0..3 {
            range[k] = [range[k][0].min(point[k] - more), range[k][1].max(point[k] + more)];
        }
    }
    range
}

impl Extent {
    /// Of an artefact at a place, from its origin.
    pub(super) fn new(task: &Task, ideal: &Ideal, of: &Artefact, place: &Place) -> Extent {
        let targets = of_place(task, ideal, of, place, false);
        let probe = &task.probe;
        let more = probe.approach_mm.max(probe.overtravel_mm).max(probe.take_up_mm);
        let from = |range: Range| -> Range { std::array::from_fn(|k| range[k].map(|q| q - place.at_mm[k])) };
        let touched = from(bounds(&targets, |target| vec![target.point], 0.0));
        let mut ways = from(bounds(&targets, |target| vec![target.point], more));
        let waits = from(bounds(&targets, |target| vec![target.home, target.entry], 0.0));
        for k in 0..3 {
            ways[k] = [ways[k][0].min(waits[k][0]), ways[k][1].max(waits[k][1])];
        }
        Extent { touched, ways }
    }

    /// Positions of the origin: the ways within `travel`, the touches within `free`.
    pub(super) fn room(&self, travel: &Range, free: &Range) -> Range {
        std::array::from_fn(|k| {
            let low = (travel[k][0] - self.ways[k][0]).max(free[k][0] - self.touched[k][0]);
            let high = (travel[k][1] - self.ways[k][1]).min(free[k][1] - self.touched[k][1]);
            [low, high]
        })
    }
}

/// Positions in a room, at its ends and in its middle; at most `most` along each axis. None if there is no room.
pub(super) fn positions(room: &Range, most: usize) -> Vec<[f64; 3]> {
    let along = |[low, high]: [f64; 2]| -> Vec<f64> {
        let width = high - low;
        let count = if width < ONE {
            1
        } else if width < TWO {
            2
        } else {
            3
        };
        match count.min(most) {
            _ if width < 0.0 => Vec::new(),
            1 => vec![0.5 * (low + high)],
            count => (0..count).map(|i| low + width * i as f64 / (count - 1) as f64).collect(),
        }
    };
    let [x, y, z] = room.map(along);
    let mut all = Vec::new();
    for x in &x {
        for y in &y {
            all.extend(z.iter().map(|z| [*x, *y, *z].map(printed)));
        }
    }
    all
}

/// Whether an artefact stands beside another one, seen from above.
pub(super) fn is_beside(task: &Task, one: (&Extent, [f64; 3]), other: (&Extent, [f64; 3])) -> bool {
    let margin = 2.0 * task.probe.tip_radius_mm + BESIDE;
    let span = |(extent, at): (&Extent, [f64; 3]), k: usize| extent.ways[k].map(|q| q + at[k]);
    (0..2).any(|k| {
        let ([a, b], [c, d]) = (span(one, k), span(other, k));
        b + margin < c || d + margin < a
    })
}

/// The least travel that an artefact needs, and what there is, in words.
pub(super) fn lacking(task: &Task, extent: &Extent, travel: &Range, free: &Range) -> String {
    let room = extent.room(travel, free);
    let (k, short) = (0..3)
        .map(|k| (k, room[k][0] - room[k][1]))
        .fold((0, f64::NEG_INFINITY), |worst, one| if one.1 > worst.1 { one } else { worst });
    let letter = ['X', 'Y', 'Z'][k];
    let [low, high] = free[k];
    let clear = clear_mm(task);
    format!(
        "{short:.0} mm more room along {letter} than its travel and plan.free_mm ({low} to {high}) leave, {clear} mm clear"
    )
}
