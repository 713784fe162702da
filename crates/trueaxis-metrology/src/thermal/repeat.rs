//! Repeatability of the drift: what no model of the recorded sensors predicts.

use super::basis::lagged;
use super::held_out::run;
use super::{Fit, LEAST_ROWS, Record, Series, span};
use std::vec;
use std::vec::Vec;
use trueaxis::Axis;

/// Lags, s, with which two rows must agree: the sensors' recent and earlier past.
const LAGS_S: [f64; 4] = [0.0, 300.0, 1_800.0, 7_200.0];
/// Two rows agree if no sensor with any of the lags differs by more than this share of its range.
const NEAR: f64 = 0.1;
/// Most rows that are compared per measuring point and cycle.
const MOST_ROWS: usize = 300;

/// Repeatability of one axis beside the residual of the cycles excluded from the fit: root mean squares, each about the mean of
/// its measuring point and cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Repeatability {
    /// The axis.
    pub axis: Axis,
    /// Drift of the cycles excluded from the fit, mm.
    pub drift_mm: f64,
    /// Residual of the cycles excluded from the fit, mm.
    pub left_mm: f64,
    /// Deviation of a cycle from another one with the same temperatures, mm; `None` if no two cycles come to the same ones.
    pub repeat_mm: Option<f64>,
    /// Number of rows compared.
    pub rows: usize,
}

/// Compares rows of different cycles at one measuring point for which all sensors and speeds agree, now and in the past: any
/// model of these sensors predicts the same growth for both (pure error from near neighbours, Daniel and Wood, *Fitting
/// Equations to Data*). The fit corrects for what they still differ by. `bytes` is the model's file, `series` from
/// [`held_out`](super::held_out).
pub fn repeatability(record: &Record, fit: &Fit, bytes: &[u8], series: &[Series]) -> Vec<Repeatability> {
    let pairs = pairs(record);
    // Cycles held out in turn have series of other fits.
    let own = (!fit.turns.is_empty()).then(|| run(record, fit, bytes).1);
    let fitted = own.as_deref().unwrap_or(series);
    let of_axis = |axis: &Axis| {
        let own: Vec<&Series> = fitted.iter().filter(|own| own.axis == *axis).collect();
        let left = |[group, row]: [usize; 2]| own[group].rows[row][1] - own[group].rows[row][2];
        let (mut squares, mut rows, mut free) = (0.0, 0, 0.0);
        for pair in &pairs {
            let apart = about_mean(pair.iter().map(|[one, other]| left(*one) - left(*other)));
            squares += 0.5 * apart.iter().map(|apart| apart * apart).sum::<f64>();
            (rows, free) = (rows + apart.len(), free + apart.len() as f64 - 1.0);
        }
        let held = || series.iter().filter(|own| own.axis == *axis && fit.held_out.contains(&own.cycle));
        let rms = |of: fn(&[f64; 3]) -> f64| {
            let all: Vec<f64> = held().flat_map(|own| about_mean(own.rows.iter().map(of))).collect();
            (all.iter().map(|x| x * x).sum::<f64>() / all.len().max(1) as f64).sqrt()
        };
        Repeatability {
            axis: *axis,
            drift_mm: rms(|row| row[1]),
            left_mm: rms(|row| row[1] - row[2]),
            repeat_mm: (free > 0.0).then(|| (squares / free).sqrt()),
            rows,
        }
    };
    record.axes.iter().map(of_axis).collect()
}

fn about_mean(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter_mut().for_each(|value| *value -= mean);
    values
}

/// For each two cycles at one measuring point the rows that agree, each as group and index within it.
fn pairs(record: &Record) -> Vec<Vec<[[usize; 2]; 2]>> {
    let states = states(record);
    let of_row = record.groups();
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); of_row.iter().max().map_or(0, |last| last + 1)];
    of_row.iter().enumerate().for_each(|(row, group)| groups[*group].push(row));
    let apart =
        |one: usize, other: usize| states.iter().map(|state| (state[one] - state[other]).abs()).fold(0.0, f64::max);
    let point =
        |group: &[usize]| group.first().map(|row| (record.samples[*row].position_mm, record.samples[*row].tool_mm));
    let mut pairs = Vec::new();
    for (one, rows) in groups.iter().enumerate() {
        for (other, others) in groups.iter().enumerate().skip(one + 1).filter(|(_, group)| point(group) == point(rows))
        {
            let every = |rows: &[usize]| rows.len().div_ceil(MOST_ROWS).max(1);
            let agree = rows.iter().enumerate().step_by(every(rows)).filter_map(|(k, row)| {
                let near = others.iter().enumerate().step_by(every(others)).map(|(k, other)| (k, apart(*row, *other)));
                let (near, found) = near.min_by(|a, b| a.1.total_cmp(&b.1))?;
                (found <= NEAR).then_some([[one, k], [other, near]])
            });
            let agree: Vec<_> = agree.collect();
            if agree.len() >= LEAST_ROWS {
                pairs.push(agree);
            }
        }
    }
    pairs
}

/// Sensors and speed with every lag over all rows, in parts of their range.
fn states(record: &Record) -> Vec<Vec<f64>> {
    let mut states = Vec::new();
    for lag_s in LAGS_S {
        let mut put = |range: [f64; 2], state: Vec<f64>| {
            let range = (range[1] - range[0]).max(f64::MIN_POSITIVE);
            states.push(state.iter().map(|value| value / range).collect());
        };
        for sensor in 0..record.sensors.len() {
            let range = span(record.readings(sensor));
            // A sensor that never moves would compare its noise.
            if range[1] - range[0] >= super::LEAST_RANGE_K {
                put(range, lagged(record, lag_s, |row| record.samples[row].temperatures_c[sensor], None));
            }
        }
        let speed = |row: usize| record.samples[row].spindle_rpm.abs();
        let range = span((0..record.samples.len()).map(speed));
        if range[1] > range[0] {
            put(range, lagged(record, lag_s, speed, Some(0.0)));
        }
    }
    states
}
