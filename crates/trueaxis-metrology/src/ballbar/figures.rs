//! Figures after ISO 230-4.

use super::Reading;
use crate::circles::minimum_zone;
use std::f64::consts::TAU;
use std::vec::Vec;

/// Circular test after ISO 230-4, mm; of a direction that was not recorded nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Figures {
    /// G(b): circular deviation of both directions together, the narrowest ring that holds them; with one direction none.
    pub g_b: Option<f64>,
    /// G: circular deviation counterclockwise and clockwise.
    pub g: [Option<f64>; 2],
    /// F: largest and smallest radial deviation, counterclockwise and clockwise, from the nominal circle about the
    /// least-squares centre.
    pub f: [Option<[f64; 2]>; 2],
    /// H: circular hysteresis, the largest difference of both directions at one angle.
    pub h: Option<f64>,
}

/// Angles at which both directions are compared.
const COMPARED: usize = 720;

pub(super) fn figures(radius: f64, centred: &[Reading]) -> Figures {
    let own = |ccw: bool| centred.iter().filter(move |reading| reading.counterclockwise == ccw);
    let ring = |readings: &mut dyn Iterator<Item = &Reading>| {
        let points: Vec<[f64; 2]> = readings
            .map(|reading| {
                let (sin, cos) = reading.angle_rad.sin_cos();
                let r = radius + reading.deviation_mm;
                [r * cos, r * sin]
            })
            .collect();
        minimum_zone(&points).ok().map(|circle| circle.zone)
    };
    let range = |ccw: bool| {
        let values = own(ccw).map(|reading| reading.deviation_mm);
        let ends = values.fold([f64::NEG_INFINITY, f64::INFINITY], |[a, b], v| [a.max(v), b.min(v)]);
        (ends[0] >= ends[1]).then_some(ends)
    };
    let profiles = [true, false].map(|ccw| profile(own(ccw)));
    let h = match &profiles {
        [Some(ccw), Some(cw)] => Some(ccw.iter().zip(cw).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)),
        _ => None,
    };
    Figures {
        g_b: h.and_then(|_| ring(&mut centred.iter())),
        g: [true, false].map(|ccw| ring(&mut own(ccw))),
        f: [true, false].map(range),
        h,
    }
}

/// Deviation at even angles, linear between the readings, their mean where several circles were run.
fn profile<'r>(readings: impl Iterator<Item = &'r Reading>) -> Option<Vec<f64>> {
    let mut sorted: Vec<[f64; 2]> = readings.map(|r| [r.angle_rad.rem_euclid(TAU), r.deviation_mm]).collect();
    crate::order::sort_by_number(&mut sorted, |one| one[0]);
    let (first, last) = (*sorted.first()?, *sorted.last()?);
    let step = TAU / COMPARED as f64;
    let mut next = 0;
    let profile = (0..COMPARED).map(|k| {
        let angle = (k as f64 + 0.5) * step;
        // Several readings between two angles: their mean.
        let begin = next;
        while sorted.get(next).is_some_and(|point| point[0] < angle + 0.5 * step) {
            next += 1;
        }
        let within = sorted.get(begin..next).unwrap_or_default();
        if !within.is_empty() {
            return within.iter().map(|point| point[1]).sum::<f64>() / within.len() as f64;
        }
        let before = begin.checked_sub(1).and_then(|i| sorted.get(i)).copied().unwrap_or([last[0] - TAU, last[1]]);
        let after = sorted.get(next).copied().unwrap_or([first[0] + TAU, first[1]]);
        let share = (angle - before[0]) / (after[0] - before[0]).max(f64::MIN_POSITIVE);
        before[1] + share * (after[1] - before[1])
    });
    Some(profile.collect())
}
