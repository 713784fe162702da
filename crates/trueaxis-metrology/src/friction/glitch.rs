//! Spikes at reversals: as recorded, as predicted by the identified friction, and with its feed-forward.

use super::drive::{feed_forward, positions};
use super::parameters::{COULOMB, Problem, VISCOUS, Values};
use super::record::Reversal;
use std::vec::Vec;

/// Start of the window before a reversal, s.
const BEFORE_S: f64 = 0.02;
/// Circles whose accelerations at the reversal agree within this share count as one size.
const SAME: f64 = 0.05;

/// Size of the spikes of all reversals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Size {
    /// Largest deviation, mm.
    pub largest: f64,
    /// Root mean square over the windows at the reversals, mm.
    pub rms: f64,
}

/// Mean spike of the circles of one size, positive against the new direction of travel.
#[derive(Clone, Debug, PartialEq)]
pub struct Spike {
    /// Acceleration at the reversal (feed²/radius), mm/s².
    pub acceleration: f64,
    /// Number of averaged reversals.
    pub reversals: usize,
    /// Time after the reversal, s.
    pub time_s: Vec<f64>,
    /// As recorded, mm.
    pub before: Vec<f64>,
    /// As predicted by the identified friction, mm.
    pub predicted: Vec<f64>,
    /// Recorded deviation minus the part that the feed-forward removes, mm.
    pub after: Vec<f64>,
}

/// Spikes of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Glitch {
    /// As recorded.
    pub before: Size,
    /// Prediction of the model alone.
    pub predicted: Size,
    /// Expected with the feed-forward: the recorded deviation plus the model's response to it.
    pub after: Size,
    /// Share of the recorded mean square that the model explains.
    pub explained: f64,
    /// Curves by size of circle, from slow to fast.
    pub spikes: Vec<Spike>,
}

/// Deviation of an axis from its drive without friction, sample by sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    /// Time between two samples, s; the first is the record's first.
    pub sample_s: f64,
    /// As recorded, mm; positive if the axis lags its command towards negative positions (c − x).
    pub before: Vec<f64>,
    /// As predicted by the identified friction, mm.
    pub predicted: Vec<f64>,
    /// Recorded deviation minus the part that the feed-forward removes, mm.
    pub after: Vec<f64>,
}

pub(super) fn deviation(problem: &Problem, values: &Values) -> Deviation {
    let axis = problem.axis(values);
    let mut smooth = *values;
    (smooth.0[COULOMB], smooth.0[VISCOUS]) = (0.0, 0.0);
    let calm = problem.model(&smooth);
    let simulated = problem.model(values);
    let offsets = feed_forward(&axis, &problem.command, problem.step_s);
    let driven: Vec<f64> = problem.command.iter().zip(&offsets).map(|(command, offset)| command + offset).collect();
    let corrected = problem.followed(values, &positions(&axis, &driven, problem.step_s));
    let difference = |one: &[f64]| -> Vec<f64> { one.iter().zip(&calm).map(|(a, b)| a - b).collect() };
    let [before, predicted] = [difference(&problem.error), difference(&simulated)];
    let after: Vec<f64> = (0..before.len()).map(|k| before[k] + corrected[k] - simulated[k]).collect();
    Deviation { sample_s: problem.sample_s(), before, predicted, after }
}

pub(super) fn glitch(problem: &Problem, values: &Values, turns: &[Reversal]) -> Glitch {
    let Deviation { before, predicted, after, .. } = deviation(problem, values);
    let windows: Vec<(usize, usize, f64)> = turns
        .iter()
        .filter_map(|turn| {
            let [from, to] = window(problem, values, turn);
            (from >= problem.skip && to <= before.len()).then_some((from, to, turn.acceleration))
        })
        .collect();
    let mut unexplained = 0.0;
    let mut all = 0.0;
    for &(from, to, _) in &windows {
        for k in from..to {
            unexplained += (before[k] - predicted[k]).powi(2);
            all += before[k].powi(2);
        }
    }
    let size = |curve: &[f64]| size(curve, &windows);
    Glitch {
        before: size(&before),
        predicted: size(&predicted),
        after: size(&after),
        explained: if all > 0.0 { 1.0 - unexplained / all } else { 0.0 },
        spikes: spikes(problem, [&before, &predicted, &after], windows),
    }
}

/// Samples from shortly before a reversal until the axis has left pre-sliding and the drive has settled.
fn window(problem: &Problem, values: &Values, turn: &Reversal) -> [usize; 2] {
    let friction = values.friction();
    let drive = values.drive(&problem.given);
    let sliding = (10.0 * friction.presliding / turn.acceleration.abs()).sqrt();
    let settled = 8.0 * drive.reset_time_s.max(1.0 / drive.position_gain_per_s);
    let samples = |seconds: f64| (seconds / problem.sample_s()).ceil() as usize;
    [turn.index.saturating_sub(samples(BEFORE_S)), turn.index + samples((sliding + settled).min(0.5))]
}

fn size(curve: &[f64], windows: &[(usize, usize, f64)]) -> Size {
    let [mut largest, mut sum, mut count]: [f64; 3] = [0.0; 3];
    for &(from, to, _) in windows {
        for value in &curve[from..to] {
            largest = largest.max(value.abs());
            sum += value * value;
            count += 1.0;
        }
    }
    Size { largest, rms: (sum / count.max(1.0)).sqrt() }
}

fn spikes(problem: &Problem, curves: [&[f64]; 3], mut windows: Vec<(usize, usize, f64)>) -> Vec<Spike> {
    crate::order::sort_by_number(&mut windows, |one| one.2.abs());
    let groups = windows.chunk_by(|one, next| next.2.abs() <= (1.0 + SAME) * one.2.abs());
    let spike = |group: &[(usize, usize, f64)]| {
        let length = group.iter().map(|(from, to, _)| to - from).min().unwrap_or(0);
        let count = group.len() as f64;
        let mean = |curve: &[f64]| -> Vec<f64> {
            let at = |k: usize| group.iter().map(|(from, _, a)| a.signum() * curve[from + k]).sum::<f64>() / count;
            (0..length).map(at).collect()
        };
        let [before, predicted, after] = curves.map(mean);
        Spike {
            acceleration: group.iter().map(|(_, _, a)| a.abs()).sum::<f64>() / count,
            reversals: group.len(),
            time_s: (0..length).map(|k| k as f64 * problem.sample_s() - BEFORE_S).collect(),
            before,
            predicted,
            after,
        }
    };
    groups.map(spike).collect()
}
