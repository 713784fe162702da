//! Residuals of the task itself on cycles excluded from the fit.

use super::{Fit, Record};
use std::vec;
use std::vec::Vec;
use trueaxis::Axis;
use trueaxis::temperature::{Readings, Thermal, ThermalState};

/// Drift and residual of one axis in one cycle, both relative to the cycle's beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HeldOut {
    /// The axis.
    pub axis: Axis,
    /// Number of the cycle.
    pub cycle: u32,
    /// Whether the cycle was excluded from the fit.
    pub held_out: bool,
    /// Largest drift, mm.
    pub drift_mm: f64,
    /// Largest residual, mm.
    pub left_mm: f64,
    /// Root mean square of the drift, mm.
    pub drift_rms_mm: f64,
    /// Root mean square of the residual, mm.
    pub left_rms_mm: f64,
}

/// Drift over time at one measuring point.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Series {
    /// The axis.
    pub axis: Axis,
    /// Number of the cycle.
    pub cycle: u32,
    /// Positions of X, Y, Z, and length of the tool, mm.
    pub point_mm: [f64; 4],
    /// Time since the beginning of the cycle, s; measured and predicted drift, mm, both relative to the beginning.
    pub rows: Vec<[f64; 3]>,
}

/// Runs the task over the record; `bytes` is the model's file. The results are in the order of axes and cycles. If every cycle
/// is held out in turn, its results are those of the fit without it.
pub fn held_out(record: &Record, fit: &Fit, bytes: &[u8]) -> (Vec<HeldOut>, Vec<Series>) {
    let (mut figures, mut series) = run(record, fit, bytes);
    for turn in &fit.turns {
        let (own, drifts) = turn.model.encode(0).map_or_else(|_| Default::default(), |bytes| run(record, turn, &bytes));
        let out = |cycle: u32| turn.held_out.contains(&cycle);
        figures.iter_mut().zip(own).filter(|(_, own)| out(own.cycle)).for_each(|(all, own)| *all = own);
        series.iter_mut().zip(drifts).filter(|(_, own)| out(own.cycle)).for_each(|(all, own)| *all = own);
    }
    (figures, series)
}

pub(super) fn run(record: &Record, fit: &Fit, bytes: &[u8]) -> (Vec<HeldOut>, Vec<Series>) {
    let Ok(thermal) = Thermal::parse(bytes) else { return (Vec::new(), Vec::new()) };
    let groups = record.groups();
    // The record has been checked, so the sensors are trusted from the start.
    let start = || {
        let mut state = ThermalState::new();
        (0..thermal.sensors()).for_each(|sensor| state.accept(sensor));
        state
    };
    let mut state = start();
    let mut series: Vec<Vec<Series>> = vec![Vec::new(); record.axes.len()];
    let mut numbers: Vec<usize> = Vec::new();
    let mut begun = 0.0;
    for (row, sample) in record.samples.iter().enumerate() {
        if record.begins(row) {
            state = start();
        }
        if row == 0 || record.samples[row - 1].cycle != sample.cycle {
            begun = sample.t_s;
        }
        let dt_s = if row == 0 { 0.0 } else { sample.t_s - record.samples[row - 1].t_s };
        let temperatures: Vec<Option<f64>> =
            fit.sensors.iter().map(|sensor| sample.temperatures_c.get(*sensor).copied()).collect();
        let readings =
            Readings { temperatures_c: &temperatures, spindle_rpm: Some(sample.spindle_rpm), tool_mm: sample.tool_mm };
        let growth = thermal.update(&mut state, dt_s, &readings);
        let number = numbers.iter().position(|group| *group == groups[row]).unwrap_or_else(|| {
            numbers.push(groups[row]);
            numbers.len() - 1
        });
        for (axis, series) in record.axes.iter().zip(&mut series) {
            let [x, y, z] = sample.position_mm;
            if series.len() == number {
                let point_mm = [x, y, z, sample.tool_mm];
                series.push(Series { axis: *axis, cycle: sample.cycle, point_mm, rows: Vec::new() });
            }
            let place = axis.index();
            let datum = thermal.axes().find(|(own, _)| own == axis).map_or(0.0, |(_, datum)| datum);
            let [offset, slope] = growth.lines[place].unwrap_or([0.0; 2]);
            let said = offset + slope * (sample.position_mm[place.min(2)] - datum);
            let own = record.axes.iter().position(|name| name == axis).unwrap_or(0);
            series[number].rows.push([sample.t_s - begun, sample.error_mm[own], said]);
        }
    }
    for series in series.iter_mut().flatten() {
        let [_, measured, said] = series.rows.first().copied().unwrap_or([0.0; 3]);
        for row in &mut series.rows {
            *row = [row[0], row[1] - measured, row[2] - said];
        }
    }
    let mut figures = Vec::new();
    for series in &series {
        for cycle in record.cycles() {
            let rows = || series.iter().filter(|own| own.cycle == cycle).flat_map(|own| &own.rows);
            let Some(axis) = series.first().map(|own| own.axis) else { continue };
            let most = |of: fn(&[f64; 3]) -> f64| rows().map(of).fold(0.0_f64, |most, value| most.max(value.abs()));
            let count = rows().count().max(1) as f64;
            let rms = |of: fn(&[f64; 3]) -> f64| (rows().map(|row| of(row).powi(2)).sum::<f64>() / count).sqrt();
            figures.push(HeldOut {
                axis,
                cycle,
                held_out: fit.held_out.contains(&cycle),
                drift_mm: most(|row| row[1]),
                left_mm: most(|row| row[1] - row[2]),
                drift_rms_mm: rms(|row| row[1]),
                left_rms_mm: rms(|row| row[1] - row[2]),
            });
        }
    }
    (figures, series.into_iter().flatten().collect())
}
