//! Rows missing from an evenly spaced record.

use super::{REST_S, Record};
use std::vec::Vec;

/// Least number of steps of a measuring point in a cycle that determine an interval.
const LEAST_STEPS: usize = 8;
/// Relative deviation from the interval up to which a step counts as even.
const EVEN: f64 = 0.1;
/// One step in this many may be uneven, and always at least one.
const ONE_IN: usize = 10;
/// A step longer than this many intervals lacks a row.
const LACKS: f64 = 1.5;

/// Rows missing in a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Missing {
    /// Number of the cycle.
    pub cycle: u32,
    /// Index of the first row at or after the moment of the first missing one.
    pub index: usize,
    /// Number of missing rows, over all measuring points.
    pub rows: usize,
    /// Longest time without a row of one measuring point, s.
    pub found_s: f64,
    /// Usual time between that point's rows, s.
    pub interval_s: f64,
    /// Longest time without a row of any point, in which no temperature is known, s.
    pub unknown_s: f64,
}

/// A step of one measuring point that lacks rows.
struct Step {
    from: usize,
    to: usize,
    missing: Missing,
}

/// Finds the missing rows of every measuring point with even steps in a cycle: all but one in ten, or all but one, within a
/// tenth of their median. A step longer than one and a half intervals lacks a row, one of n intervals lacks n − 1. Uneven
/// records, the ends of a cycle and rests count as complete. Gaps of several points at the same time are merged.
pub(super) fn missing(record: &Record) -> Vec<Missing> {
    let groups = record.groups();
    let count = groups.iter().max().map_or(0, |last| last + 1);
    let mut rows: Vec<Vec<usize>> = (0..count).map(|_| Vec::new()).collect();
    groups.iter().enumerate().for_each(|(row, group)| rows[*group].push(row));
    let mut steps: Vec<Step> = rows.iter().flat_map(|own| of_point(record, own)).collect();
    steps.sort_by_key(|step| step.from);
    let mut merged: Vec<Step> = Vec::new();
    for step in steps {
        match merged.last_mut().filter(|last| record.samples[step.from].t_s < record.samples[last.to].t_s) {
            Some(last) => {
                last.to = last.to.max(step.to);
                last.missing.rows += step.missing.rows;
                last.missing.found_s = last.missing.found_s.max(step.missing.found_s);
            }
            None => merged.push(step),
        }
    }
    merged
        .into_iter()
        .map(|Step { from, to, missing }| {
            let blanks = record.samples[from..=to].windows(2).map(|pair| pair[1].t_s - pair[0].t_s);
            Missing { unknown_s: blanks.fold(0.0, f64::max), ..missing }
        })
        .collect()
}

/// Steps of one measuring point in one cycle that lack rows.
fn of_point(record: &Record, rows: &[usize]) -> Vec<Step> {
    let t = |row: usize| record.samples[row].t_s;
    let steps = || rows.windows(2).map(|pair| [pair[0], pair[1]]).filter(|[from, to]| t(*to) - t(*from) < REST_S);
    let mut sorted: Vec<f64> = steps().map(|[from, to]| t(to) - t(from)).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(&interval_s) = sorted.get(sorted.len() / 2).filter(|_| sorted.len() >= LEAST_STEPS) else {
        return Vec::new();
    };
    let uneven = sorted.iter().filter(|step| (*step - interval_s).abs() > EVEN * interval_s).count();
    if interval_s <= 0.0 || uneven > (sorted.len() / ONE_IN).max(1) {
        return Vec::new();
    }
    steps()
        .filter(|[from, to]| t(*to) - t(*from) > LACKS * interval_s)
        .map(|[from, to]| {
            let (found_s, due_s) = (t(to) - t(from), t(from) + interval_s);
            let index = (from + 1..to).find(|row| t(*row) >= due_s).unwrap_or(to);
            let missing = (found_s / interval_s).round() as usize - 1;
            let missing =
                Missing { cycle: record.samples[to].cycle, index, rows: missing, found_s, interval_s, unknown_s: 0.0 };
            Step { from, to, missing }
        })
        .collect()
}
