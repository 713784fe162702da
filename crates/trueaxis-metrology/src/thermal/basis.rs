//! Columns of the linear problem: the effect of one unit of a cause on each row.

use super::{Record, Settings, span};
use std::vec;
use std::vec::Vec;
use trueaxis::Axis;
use trueaxis::temperature::{Decay, KNOTS, place};

/// Cause of thermal growth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    /// A sensor, from 0.
    Sensor(usize),
    /// The spindle's speed.
    Spindle,
}

/// A cause with its lag and, for a sensor, the temperatures at which its curve bends.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chosen {
    pub(super) cause: Cause,
    pub(super) lag_s: f64,
    pub(super) bends_c: Vec<f64>,
}

/// If one cycle has more than this share of a speed's rows, the other cycles count as uninformative about that speed.
const LONE: f64 = 0.95;

/// A record with the data that all its fits share.
pub(super) struct Problem<'r> {
    pub(super) record: &'r Record,
    pub(super) settings: &'r Settings,
    /// Knots of the spindle's speed; empty if it is constant.
    pub(super) speeds_rpm: Vec<f64>,
    /// For each speed knot the index, from 0, of the one fitted cycle that has it; `None` if several have it, and for
    /// standstill.
    pub(super) lone: Vec<Option<usize>>,
    /// Whether the axes were measured at more than one position, and with more than one tool.
    slopes: [bool; 3],
    tilts: bool,
    pub(super) groups: Vec<usize>,
}

/// Index of a linear axis among X, Y, Z.
pub(super) fn slot(axis: Axis) -> usize {
    axis.index().min(2)
}

impl<'r> Problem<'r> {
    /// `rows`: the rows used for the fit.
    pub(super) fn new(record: &'r Record, settings: &'r Settings, rows: &[usize]) -> Self {
        let varies = |[low, high]: [f64; 2]| high > low;
        let samples = || record.samples.iter();
        let speeds_rpm = speeds(record, rows);
        Problem {
            record,
            settings,
            lone: lone(record, rows, &speeds_rpm),
            speeds_rpm,
            slopes: [0, 1, 2].map(|axis| varies(span(samples().map(|sample| sample.position_mm[axis])))),
            tilts: varies(span(samples().map(|sample| sample.tool_mm))),
            groups: record.groups(),
        }
    }

    /// All possible causes.
    pub(super) fn causes(&self) -> Vec<Cause> {
        let moves = |sensor: &usize| {
            let [low, high] = span(self.record.readings(*sensor));
            high - low >= super::LEAST_RANGE_K
        };
        let spindle = (!self.speeds_rpm.is_empty()).then_some(Cause::Spindle);
        (0..self.record.sensors.len()).filter(moves).map(Cause::Sensor).chain(spindle).collect()
    }

    /// Whether the slope or tilt of a cause is observable on an axis.
    pub(super) fn levers(&self, axis: Axis, cause: Cause) -> bool {
        match cause {
            Cause::Sensor(_) => self.slopes[slot(axis)],
            Cause::Spindle => self.tilts,
        }
    }

    /// Lever of a row: the distance from the datum, or the tool length.
    pub(super) fn lever(&self, axis: Axis, cause: Cause, row: usize) -> f64 {
        let (sample, axis) = (&self.record.samples[row], slot(axis));
        match cause {
            Cause::Sensor(_) => sample.position_mm[axis] - self.settings.datum_mm[axis],
            Cause::Spindle => sample.tool_mm,
        }
    }

    /// Responses of a cause over all rows: the straight part and the bends of a sensor's curve, or the spindle's knots without
    /// standstill.
    pub(super) fn responses(&self, chosen: &Chosen) -> Vec<Vec<f64>> {
        match chosen.cause {
            Cause::Sensor(sensor) => {
                let reference = self.settings.reference_c;
                let lagged =
                    lagged(self.record, chosen.lag_s, |row| self.record.samples[row].temperatures_c[sensor], None);
                let straight = lagged.iter().map(|at| at - reference).collect();
                let bends = chosen.bends_c.iter().map(|bend| {
                    let zero = (reference - bend).max(0.0);
                    lagged.iter().map(|at| (at - bend).max(0.0) - zero).collect()
                });
                core::iter::once(straight).chain(bends).collect()
            }
            Cause::Spindle => (1..self.speeds_rpm.len())
                .map(|knot| {
                    let share = |row: usize| share(&self.speeds_rpm, knot, self.record.samples[row].spindle_rpm);
                    lagged(self.record, chosen.lag_s, share, Some(0.0))
                })
                .collect(),
        }
    }

    /// Values of `rows` minus the mean of their group: removes the zero of each measuring point in each cycle.
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

/// An input after a lag, starting at its first value or at `rest`.
pub(super) fn lagged(record: &Record, lag_s: f64, input: impl Fn(usize) -> f64, rest: Option<f64>) -> Vec<f64> {
    let samples = &record.samples;
    let mut out = Vec::with_capacity(samples.len());
    let (mut x, mut before) = (0.0, 0.0);
    let mut decay = (f64::NAN, Decay::new(1.0, lag_s));
    for row in 0..samples.len() {
        let now = input(row);
        if record.begins(row) {
            x = rest.unwrap_or(now);
        } else {
            let dt_s = samples[row].t_s - samples[row - 1].t_s;
            if dt_s != decay.0 {
                decay = (dt_s, Decay::new(dt_s, lag_s));
            }
            // Rows of the same moment: no time has passed.
            if dt_s > 0.0 {
                x = decay.1.respond(x, before, now);
            }
        }
        before = now;
        out.push(x);
    }
    out
}

/// Share of a knot at a speed.
fn share(knots_rpm: &[f64], knot: usize, rpm: f64) -> f64 {
    let (cell, share, _) = place(knots_rpm.iter().copied(), rpm.abs());
    if cell == knot {
        1.0 - share
    } else if cell + 1 == knot {
        share
    } else {
        0.0
    }
}

/// For each knot the only fitted cycle that has it.
fn lone(record: &Record, rows: &[usize], knots_rpm: &[f64]) -> Vec<Option<usize>> {
    let mut cycles: Vec<Vec<f64>> = Vec::new();
    let mut before = None;
    for sample in rows.iter().filter_map(|row| record.samples.get(*row)) {
        if before.replace(sample.cycle) != Some(sample.cycle) {
            cycles.push(vec![0.0; knots_rpm.len()]);
        }
        for (knot, sum) in cycles.last_mut().into_iter().flatten().enumerate() {
            *sum += share(knots_rpm, knot, sample.spindle_rpm);
        }
    }
    let of = |knot: usize| {
        let whole = cycles.iter().map(|cycle| cycle[knot]).sum::<f64>();
        (0..cycles.len()).find(|cycle| knot > 0 && cycles[*cycle][knot] > LONE * whole)
    };
    (0..knots_rpm.len()).map(of).collect()
}

/// Speed knots: the speeds in `rows` if they are few, otherwise equidistant ones up to the fastest, without those that no row
/// is near. A knot at a speed that only other rows have would be undetermined.
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
        let even = |k: u32| (0.25 * f64::from(k) * high).round();
        let near = |k: &u32| run().any(|rpm| even(k - 1) < rpm && rpm < even(k + 1));
        found = (1..=4).filter(near).map(even).collect();
    }
    core::iter::once(0.0).chain(found).collect()
}

#[cfg(test)]
mod tests {
    use super::{lone, speeds};
    use crate::thermal::{Record, Sample};
    use std::vec;
    use std::vec::Vec;

    /// Rows with these speeds, four per cycle.
    fn record(speeds_rpm: &[f64]) -> Record {
        let sample = |(row, rpm): (usize, &f64)| Sample {
            t_s: row as f64,
            temperatures_c: vec![],
            spindle_rpm: *rpm,
            cycle: (row / 4) as u32,
            position_mm: [0.0; 3],
            tool_mm: 0.0,
            error_mm: vec![],
        };
        let samples = speeds_rpm.iter().enumerate().map(sample).collect();
        Record { sensors: vec![], axes: vec![], samples }
    }

    #[test]
    fn many_speeds_have_even_knots_where_any_of_them_is_near() {
        let record = record(&[100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 12_000.0]);
        // No row is near 6,000 rpm: the growth at such a knot would be 0.
        assert_eq!(speeds(&record, &[0, 1, 2, 3, 4, 5, 6, 7]), [0.0, 3000.0, 12_000.0]);
    }

    #[test]
    fn a_knot_is_lone_where_one_cycle_has_it() {
        let record = record(&[0.0, 3e3, 3e3, 0.0, 3e3, 6e3, 6e3, 0.0, 3e3, 9e3, 9e3, 9e3]);
        let rows: Vec<usize> = (0..12).collect();
        assert_eq!(lone(&record, &rows, &speeds(&record, &rows)), [None, None, Some(1), Some(2)]);
    }
}
