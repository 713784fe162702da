//! Columns of the linear problem: what one unit of a cause makes of every row.

use super::{Record, Settings, span};
use std::vec;
use std::vec::Vec;
use trueaxis::Axis;
use trueaxis::temperature::{Decay, KNOTS, place};

/// What makes an axis grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    /// A sensor, from 0.
    Sensor(usize),
    /// The spindle's speed.
    Spindle,
}

/// A cause with its lag and, of a sensor, the temperatures at which its curve bends.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chosen {
    pub(super) cause: Cause,
    pub(super) lag_s: f64,
    pub(super) bends_c: Vec<f64>,
}

/// A record with what all fits of it share.
pub(super) struct Problem<'r> {
    pub(super) record: &'r Record,
    pub(super) settings: &'r Settings,
    /// Knots of the spindle's speed; none where it is constant.
    pub(super) speeds_rpm: Vec<f64>,
    /// Whether the axes were measured at more than one position; with more than one tool.
    slopes: [bool; 3],
    tilts: bool,
    pub(super) groups: Vec<usize>,
}

/// Position of a linear axis among X, Y, Z.
pub(super) fn slot(axis: Axis) -> usize {
    axis.index().min(2)
}

impl<'r> Problem<'r> {
    /// `rows`: those that a fit is made from.
    pub(super) fn new(record: &'r Record, settings: &'r Settings, rows: &[usize]) -> Self {
        let varies = |[low, high]: [f64; 2]| high > low;
        let samples = || record.samples.iter();
        Problem {
            record,
            settings,
            speeds_rpm: speeds(record, rows),
            slopes: [0, 1, 2].map(|axis| varies(span(samples().map(|sample| sample.position_mm[axis])))),
            tilts: varies(span(samples().map(|sample| sample.tool_mm))),
            groups: record.groups(),
        }
    }

    /// All causes there may be.
    pub(super) fn causes(&self) -> Vec<Cause> {
        let moves = |sensor: &usize| {
            let [low, high] = span(self.record.readings(*sensor));
            high - low >= super::LEAST_RANGE_K
        };
        let spindle = (!self.speeds_rpm.is_empty()).then_some(Cause::Spindle);
        (0..self.record.sensors.len()).filter(moves).map(Cause::Sensor).chain(spindle).collect()
    }

    /// Whether slope or tilt of a cause can be told on an axis.
    pub(super) fn levers(&self, axis: Axis, cause: Cause) -> bool {
        match cause {
            Cause::Sensor(_) => self.slopes[slot(axis)],
            Cause::Spindle => self.tilts,
        }
    }

    /// Lever of a row: the distance from the datum, or the tool.
    pub(super) fn lever(&self, axis: Axis, cause: Cause, row: usize) -> f64 {
        let (sample, axis) = (&self.record.samples[row], slot(axis));
        match cause {
            Cause::Sensor(_) => sample.position_mm[axis] - self.settings.datum_mm[axis],
            Cause::Spindle => sample.tool_mm,
        }
    }

    /// The responses of a cause over all rows: of a sensor its curve's straight part and its bends, of the spindle its knots
    /// but rest.
    pub(super) fn responses(&self, chosen: &Chosen) -> Vec<Vec<f64>> {
        match chosen.cause {
            Cause::Sensor(sensor) => {
                let reference = self.settings.reference_c;
                let lagged = self.lagged(chosen.lag_s, |row| self.record.samples[row].temperatures_c[sensor], None);
                let straight = lagged.iter().map(|at| at - reference).collect();
                let bends = chosen.bends_c.iter().map(|bend| {
                    let zero = (reference - bend).max(0.0);
                    lagged.iter().map(|at| (at - bend).max(0.0) - zero).collect()
                });
                core::iter::once(straight).chain(bends).collect()
            }
            Cause::Spindle => (1..self.speeds_rpm.len())
                .map(|knot| {
                    let share = |row: usize| {
                        let rpm = self.record.samples[row].spindle_rpm.abs();
                        let (cell, share, _) = place(self.speeds_rpm.iter().copied(), rpm);
                        if cell == knot {
                            1.0 - share
                        } else if cell + 1 == knot {
                            share
                        } else {
                            0.0
                        }
                    };
                    self.lagged(chosen.lag_s, share, Some(0.0))
                })
                .collect(),
        }
    }

    /// An input behind a lag; it begins as it is, or at `rest`.
    fn lagged(&self, lag_s: f64, input: impl Fn(usize) -> f64, rest: Option<f64>) -> Vec<f64> {
        let samples = &self.record.samples;
        let mut out = Vec::with_capacity(samples.len());
        let (mut x, mut before) = (0.0, 0.0);
        let mut decay = (f64::NAN, Decay::new(1.0, lag_s));
        for row in 0..samples.len() {
            let now = input(row);
            if self.record.begins(row) {
                x = rest.unwrap_or(now);
            } else {
                let dt_s = samples[row].t_s - samples[row - 1].t_s;
                if dt_s != decay.0 {
                    decay = (dt_s, Decay::new(dt_s, lag_s));
                }
                // Rows of one moment: nothing has passed.
                if dt_s > 0.0 {
                    x = decay.1.respond(x, before, now);
                }
            }
            before = now;
            out.push(x);
        }
        out
    }

    /// The values of `rows` less the mean of their group: the zero of every measuring point in every cycle is taken out.
    pub(super) fn centred(&self, rows: &[usize], value: impl Fn(usize) -> f64) -> Vec<f64> {
        let count = self.groups.iter().max().map_or(0, |last| last + 1);
        let mut means = vec![(0.0, 0.0); count];
        for &row in rows {
            let (sum, number) = &mut means[self.groups[row]];
            *sum += value(row);
            *number += 1.0;
        }
        rows.iter()
            .map(|&row| {
                let (sum, number) = means[self.groups[row]];
                value(row) - sum / number
            })
            .collect()
    }
}

/// Knots of the speed: those that were run in `rows` where they are few, else even ones up to the fastest. What was run in
/// other rows alone would be a knot of which nothing is known.
fn speeds(record: &Record, rows: &[usize]) -> Vec<f64> {
    let run = || rows.iter().filter_map(|row| record.samples.get(*row)).map(|sample| sample.spindle_rpm.abs());
    let mut found: Vec<f64> = Vec::new();
    for rpm in run().map(f64::round) {
        if rpm > 0.0 && !found.contains(&rpm) && found.len() <= record.samples.len() {
            found.push(rpm);
        }
    }
    let [low, high] = span(run());
    if high <= low || high < 1.0 {
        return Vec::new();
    }
    found.sort_by(f64::total_cmp);
    if found.len() >= KNOTS {
        found = (1..=4).map(|k| (0.25 * f64::from(k) * high).round()).collect();
    }
    core::iter::once(0.0).chain(found).collect()
}
