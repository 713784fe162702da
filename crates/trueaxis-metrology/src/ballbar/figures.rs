//! Figures after ISO 230-4.

use super::{Reading, WIDEST_GAP_DEG};
use crate::circles::{least_squares, minimum_zone};
use std::f64::consts::TAU;
use std::vec::Vec;

/// Figures of a circular test after ISO 230-4, mm; `None` for a direction that was not recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Figures {
    /// G(b): bidirectional circular deviation, the minimum zone (MZC) of both directions together; `None` with one direction.
    pub g_b: Option<f64>,
    /// G: circular deviation counterclockwise and clockwise, the minimum zone (MZC).
    pub g: [Option<f64>; 2],
    /// F: largest and smallest radial deviation, counterclockwise and clockwise, from the nominal circle about the
    /// least-squares centre (LSC) of that direction; `None` for an arc, because the centre is defined by the whole circle.
    pub f: [Option<[f64; 2]>; 2],
    /// H: circular hysteresis, the largest difference between both directions at one angle, about the least-squares centre of
    /// both.
    pub h: Option<f64>,
}

/// Number of angles at which the directions are compared.
const COMPARED: usize = 720;

pub(super) fn figures(radius: f64, readings: &[Reading], whole: bool) -> Figures {
    let own = |ccw: bool| readings.iter().filter(move |reading| reading.counterclockwise == ccw).copied();
    let points = |readings: &mut dyn Iterator<Item = Reading>| -> Vec<[f64; 2]> {
        let point = |reading: Reading| {
            let (sin, cos) = reading.angle_rad.sin_cos();
            let r = radius + reading.deviation_mm;
            [r * cos, r * sin]
        };
        readings.map(point).collect()
    };
    let ring =
        |readings: &mut dyn Iterator<Item = Reading>| minimum_zone(&points(readings)).ok().map(|circle| circle.zone);
    let centre = |readings: &mut dyn Iterator<Item = Reading>| Some(least_squares(&points(readings)).ok()?.centre);
    let range = |ccw: bool| {
        let [x, y] = centre(&mut own(ccw)).filter(|_| whole)?;
        let values = points(&mut own(ccw)).into_iter().map(|point| (point[0] - x).hypot(point[1] - y) - radius);
        Some(values.fold([f64::NEG_INFINITY, f64::INFINITY], |[a, b], v| [a.max(v), b.min(v)]))
    };
    let both = centre(&mut readings.iter().copied()).unwrap_or_default();
    let profiles = [true, false].map(|ccw| profile(own(ccw).map(|reading| about(radius, both, &reading))));
    let h = match &profiles {
        [Some(ccw), Some(cw)] => {
            let apart = ccw.iter().zip(cw).filter_map(|(a, b)| Some((a.as_ref()? - b.as_ref()?).abs()));
            Some(apart.fold(0.0, f64::max))
        }
        _ => None,
    };
    Figures {
        g_b: h.and_then(|_| ring(&mut readings.iter().copied())),
        g: [true, false].map(|ccw| ring(&mut own(ccw))),
        f: [true, false].map(range),
        h,
    }
}

/// Deviation at equidistant angles, linear between the readings, averaged over repeated circles; `None` beyond the ends of an
/// arc.
fn profile(readings: impl Iterator<Item = Reading>) -> Option<Vec<Option<f64>>> {
    let mut sorted: Vec<[f64; 2]> = readings.map(|r| [r.angle_rad.rem_euclid(TAU), r.deviation_mm]).collect();
    crate::order::sort_by_number(&mut sorted, |one| one[0]);
    let (first, last) = (*sorted.first()?, *sorted.last()?);
    let step = TAU / COMPARED as f64;
    let mut next = 0;
    let profile = (0..COMPARED).map(|k| {
        let angle = (k as f64 + 0.5) * step;
        // The mean of several readings between two angles.
        let begin = next;
        while sorted.get(next).is_some_and(|point| point[0] < angle + 0.5 * step) {
            next += 1;
        }
        let within = sorted.get(begin..next).unwrap_or_default();
        if !within.is_empty() {
            return Some(within.iter().map(|point| point[1]).sum::<f64>() / within.len() as f64);
        }
        let before = begin.checked_sub(1).and_then(|i| sorted.get(i)).copied().unwrap_or([last[0] - TAU, last[1]]);
        let after = sorted.get(next).copied().unwrap_or([first[0] + TAU, first[1]]);
        let gap = after[0] - before[0];
        let share = (angle - before[0]) / gap.max(f64::MIN_POSITIVE);
        (gap.to_degrees() <= WIDEST_GAP_DEG).then(|| before[1] + share * (after[1] - before[1]))
    });
    Some(profile.collect())
}

/// The reading of a bar pivoted in the circle's centre: the part of |c + (R + Δ) (cos θ, sin θ)| along the commanded radius.
pub(super) fn about(radius: f64, [x, y]: [f64; 2], reading: &Reading) -> Reading {
    let (sin, cos) = reading.angle_rad.sin_cos();
    let (along, across) = (x * cos + y * sin, y * cos - x * sin);
    let r = radius + reading.deviation_mm;
    Reading { deviation_mm: (r * r - across * across).max(0.0).sqrt() - along - radius, ..*reading }
}
