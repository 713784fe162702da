//! Deviations of the radius along a full circle, as measured by a ballbar.

use crate::report::CircleReport;
use trueaxis_report::Thinner;
use trueaxis_sim::Scenario;
use trueaxis_sim::program::{Curve, Move};
use trueaxis_sim::run::{Moment, Sample};

/// Buckets of a curve around the circle.
const AROUND: usize = 1400;
/// An arc whose ends are closer than this, mm, is a full circle; a larger rise along its axis makes it a helix.
const CLOSED_MM: f64 = 1e-6;
/// Minimum share of the axis direction that lies along one machine axis.
const ALONG_AN_AXIS: f64 = 1.0 - 1e-9;

/// The first full circle of a program, in a plane of two axes.
#[derive(Debug)]
pub(super) struct CircleSeries {
    /// Machine coordinates, mm.
    center: [f64; 3],
    radius: f64,
    /// Axes of the plane, ordered so that angles count from the first to the second.
    plane: [usize; 2],
    /// Path length at the start and end of the circle, mm.
    from_to: [f64; 2],
    line: u32,
    /// Angle and deviation, for every run.
    runs: Vec<Thinner<[f64; 2], 1>>,
}

impl CircleSeries {
    /// `None` if the program has no full circle, or moves more than X, Y, Z.
    pub(super) fn of(scenario: &Scenario, runs: usize) -> Option<CircleSeries> {
        if scenario.five_axis {
            return None;
        }
        let mut begins = 0.0;
        for step in &scenario.program.moves {
            let length = step.length();
            if let Some((center, plane)) = full_circle(step) {
                let start = step.curve.position(0.0);
                let [a, b] = plane;
                return Some(CircleSeries {
                    center: std::array::from_fn(|k| center[k] + scenario.origin_mm[k]),
                    radius: (start[a] - center[a]).hypot(start[b] - center[b]),
                    plane,
                    from_to: [begins, begins + length],
                    line: step.line,
                    runs: (0..runs).map(|_| Thinner::new(AROUND)).collect(),
                });
            }
            begins += length;
        }
        None
    }

    pub(super) fn add(&mut self, moment: &Moment, runs: &[Option<&Sample>]) {
        let [from, to] = self.from_to;
        if !(from..=to).contains(&moment.length_mm) {
            return;
        }
        let radial = self.plane.map(|k| (moment.nominal_mm[k] - self.center[k]) / self.radius);
        let angle = radial[1].atan2(radial[0]);
        for (curve, sample) in self.runs.iter_mut().zip(runs) {
            let Some(sample) = sample else { continue };
            let [a, b] = self.plane.map(|k| f64::from(sample.deviation_um[k]));
            let departure = radial[0] * a + radial[1] * b;
            curve.add([angle, departure], [departure]);
        }
    }

    pub(super) fn report(&self) -> Option<CircleReport> {
        let mut runs = self.runs.iter().map(Thinner::items);
        let [uncompensated, compensated, servo_only, full] = std::array::from_fn(|_| runs.next().unwrap_or_default());
        (!uncompensated.is_empty()).then_some(CircleReport {
            radius_mm: self.radius,
            plane: self.plane,
            line: self.line,
            uncompensated,
            compensated,
            servo_only,
            full,
        })
    }
}

/// Centre, and the axes of the plane in the order that makes angles counter-clockwise.
fn full_circle(step: &Move) -> Option<([f64; 3], [usize; 2])> {
    let Curve::Arc { start, end, center, normal, .. } = &step.curve else { return None };
    let closed = start.iter().zip(end).all(|(a, b)| (a - b).abs() < CLOSED_MM);
    let along = normal.iter().position(|n| n.abs() > ALONG_AN_AXIS)?;
    (closed && !step.rapid).then_some((*center, [(along + 1) % 3, (along + 2) % 3]))
}
