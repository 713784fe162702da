//! The parameters of a fit as one vector, and the simulation that it compares with the record.

use super::drive::{Axis, delayed, positions};
use std::vec::Vec;
use trueaxis::machine::{DriveFigures, FrictionSettings};

/// Number of parameters.
pub(super) const COUNT: usize = 13;
pub(super) const POSITION_GAIN: usize = 0;
pub(super) const RESET_TIME: usize = 1;
pub(super) const FEED_FORWARD: usize = 2;
pub(super) const VELOCITY_GAIN: usize = 3;
pub(super) const READING_LAG: usize = 4;
pub(super) const COULOMB: usize = 5;
pub(super) const STRIBECK_SHARE: usize = 6;
pub(super) const STRIBECK_VELOCITY: usize = 7;
pub(super) const PRESLIDING: usize = 8;
pub(super) const VISCOUS: usize = 9;
pub(super) const REST: usize = 10;
pub(super) const OFFSET: usize = 11;
/// Lag of the feed-forward behind the command, in cycles of the record: 0 if the drive interpolates between samples, half a
/// cycle if it holds each command, a whole one if it closes the loop once per cycle.
pub(super) const FEED_LAG: usize = 12;

/// How a parameter is varied.
struct Kind {
    /// Whether the logarithm is varied: the parameter is positive, with a relative uncertainty.
    log: bool,
    low: f64,
    high: f64,
    /// Step of the difference quotient (of the logarithm, if that is varied).
    step: f64,
}

const fn kind(log: bool, low: f64, high: f64, step: f64) -> Kind {
    Kind { log, low, high, step }
}

/// In the order of the constants above; units s, mm.
const KINDS: [Kind; COUNT] = [
    kind(true, 1.0, 1000.0, 1e-4),
    kind(true, 5e-4, 1.0, 1e-4),
    kind(false, 0.0, 1.1, 1e-4),
    kind(true, 20.0, 2e4, 1e-3),
    kind(false, -0.02, 0.1, 1e-6),
    kind(true, 1e-6, 1e3, 1e-4),
    kind(false, -0.5, 10.0, 1e-3),
    kind(true, 0.02, 200.0, 1e-3),
    kind(true, 1e-5, 1.0, 1e-4),
    kind(false, -0.2, 1.0, 1e-5),
    kind(false, -1.0, 1.0, 1e-3),
    kind(false, -1e4, 1e4, 1e-6),
    kind(false, -0.25, 1.25, 1e-2),
];

/// Whether the logarithm of a parameter is varied.
pub(super) fn is_log(parameter: usize) -> bool {
    KINDS[parameter].log
}

/// Step of the difference quotient, away from the upper end of the range.
pub(super) fn step(parameter: usize, at: &Values) -> f64 {
    let kind = &KINDS[parameter];
    if at.0[parameter] >= kind.high * 0.999 { -kind.step } else { kind.step }
}

/// Values of all parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Values(pub(super) [f64; COUNT]);

impl Values {
    pub(super) fn new(drive: &DriveFigures, friction: &FrictionSettings) -> Values {
        Values([
            drive.position_gain_per_s,
            drive.reset_time_s,
            drive.velocity_feed_forward,
            drive.velocity_gain_per_s,
            0.0,
            friction.coulomb_per_s,
            friction.stribeck_share,
            friction.stribeck_velocity_per_s,
            friction.presliding,
            friction.viscous,
            0.0,
            0.0,
            0.0,
        ])
    }

    /// The drive, with current loop and dead time as given.
    pub(super) fn drive(&self, given: &DriveFigures) -> DriveFigures {
        let v = &self.0;
        DriveFigures {
            position_gain_per_s: v[POSITION_GAIN],
            velocity_gain_per_s: v[VELOCITY_GAIN],
            reset_time_s: v[RESET_TIME],
            velocity_feed_forward: v[FEED_FORWARD],
            ..*given
        }
    }

    pub(super) fn friction(&self) -> FrictionSettings {
        let v = &self.0;
        FrictionSettings {
            coulomb_per_s: v[COULOMB],
            stribeck_share: v[STRIBECK_SHARE],
            stribeck_velocity_per_s: v[STRIBECK_VELOCITY],
            presliding: v[PRESLIDING],
            viscous: v[VISCOUS],
            lead_s: 0.0,
            adapt: 0.0,
        }
    }

    /// Moves a parameter by `by` in the scale in which it is varied, within its range.
    pub(super) fn moved(&self, parameter: usize, by: f64) -> Values {
        let kind = &KINDS[parameter];
        let mut next = *self;
        let value = &mut next.0[parameter];
        *value = if kind.log { *value * by.exp() } else { *value + by }.max(kind.low).min(kind.high);
        next
    }

    /// Whether a parameter is at an end of its range.
    pub(super) fn is_at_an_end(&self, parameter: usize) -> bool {
        let Kind { low, high, step, .. } = KINDS[parameter];
        self.0[parameter] <= low + step || self.0[parameter] >= high - step
    }

    /// Converts a standard error from the scale in which the parameter is varied to the parameter's unit.
    pub(super) fn unscaled(&self, parameter: usize, error: f64) -> f64 {
        if KINDS[parameter].log { error * self.0[parameter] } else { error }
    }
}

/// Data of a fit: commands and following errors of one axis on the model's grid.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    /// Commands, mm; `fine` steps per sample.
    pub(super) command: Vec<f64>,
    /// Recorded following error c − x, mm; one value per sample.
    pub(super) error: Vec<f64>,
    /// Model steps per sample.
    pub(super) fine: usize,
    /// Model step, s.
    pub(super) step_s: f64,
    /// Number of first samples to ignore: the state before them is unknown.
    pub(super) skip: usize,
    /// `false` for further samples to ignore; if empty, all count.
    pub(super) even: Vec<bool>,
    /// Samples at which the stretch of one reversal ends and the next begins.
    pub(super) borders: Vec<usize>,
    /// Current loop, dead time, and all figures that are not fitted.
    pub(super) given: DriveFigures,
    /// Time between two samples of the record, s.
    pub(super) period_s: f64,
    /// Time from the moment at which a row's command takes effect to the encoder's reading, s; `None` if unknown.
    pub(super) read_after_s: Option<f64>,
}

impl Problem {
    /// Creates a problem with a model step and a sample distance of about `step_s`, from a record of period `period_s`.
    pub(super) fn new(command: &[f64], reading: &[f64], period_s: f64, step_s: f64, given: DriveFigures) -> Problem {
        let coarse = ((step_s / period_s) * (1.0 + 1e-9)).floor().max(1.0) as usize;
        let fine = (period_s * coarse as f64 / step_s - 1e-9).ceil().max(1.0) as usize;
        let picked: Vec<f64> = command.iter().copied().step_by(coarse).collect();
        let error = picked.iter().zip(reading.iter().step_by(coarse)).map(|(c, x)| c - x).collect();
        let mut dense = Vec::with_capacity(picked.len() * fine);
        for pair in picked.windows(2) {
            dense.extend((0..fine).map(|i| pair[0] + (pair[1] - pair[0]) * i as f64 / fine as f64));
        }
        dense.extend(picked.last());
        let step_s = period_s * coarse as f64 / fine as f64;
        Problem {
            command: dense,
            error,
            fine,
            step_s,
            skip: 0,
            even: Vec::new(),
            borders: Vec::new(),
            given,
            period_s,
            read_after_s: None,
        }
    }

    /// Time between two samples, s.
    pub(super) fn sample_s(&self) -> f64 {
        self.step_s * self.fine as f64
    }

    /// Times within a cycle that a fit over `free` does not determine, and the standard uncertainty of each: every reading
    /// within half a cycle of its command, and every lag of the feed-forward up to a cycle, is equally likely (JCGM 100,
    /// 4.3.7).
    pub(super) fn open_times(&self, free: &[usize]) -> Vec<(usize, f64)> {
        let with_drive = free.contains(&POSITION_GAIN);
        let is_read_any_time = with_drive && self.read_after_s.is_none();
        let reading = (READING_LAG, self.period_s / 12_f64.sqrt());
        let feed = (FEED_LAG, 1.0 / 3_f64.sqrt());
        let open = [is_read_any_time.then_some(reading), Some(feed)];
        open.into_iter().flatten().filter(|(time, _)| !free.contains(time)).collect()
    }

    /// Whether a sample counts.
    pub(super) fn counts(&self, k: usize) -> bool {
        k >= self.skip && self.even.get(k).copied().unwrap_or(true)
    }

    pub(super) fn axis(&self, values: &Values) -> Axis {
        let feed_lag_s = self.period_s * values.0[FEED_LAG];
        Axis { drive: values.drive(&self.given), friction: values.friction(), feed_lag_s, rest: values.0[REST] }
    }

    /// Following error of the model, one value per sample, mm.
    pub(super) fn model(&self, values: &Values) -> Vec<f64> {
        self.followed(values, &positions(&self.axis(values), &self.command, self.step_s))
    }

    /// Following error for positions on the fine grid.
    pub(super) fn followed(&self, values: &Values, positions: &[f64]) -> Vec<f64> {
        let read = delayed(positions, values.0[READING_LAG] / self.step_s);
        let pairs = self.command.iter().zip(&read).step_by(self.fine);
        pairs.map(|(command, position)| command - position + values.0[OFFSET]).collect()
    }

    /// Model − reading; zero for ignored samples.
    pub(super) fn residuals(&self, values: &Values) -> Vec<f64> {
        let mut residuals = self.model(values);
        for (k, (residual, error)) in residuals.iter_mut().zip(&self.error).enumerate() {
            *residual = if self.counts(k) { *residual - error } else { 0.0 };
        }
        residuals
    }

    /// Derivatives of the residuals with respect to a parameter, in the scale in which it is varied.
    pub(super) fn derivative(&self, values: &Values, at: &[f64], parameter: usize) -> Vec<f64> {
        if parameter == OFFSET {
            return (0..at.len()).map(|k| if self.counts(k) { 1.0 } else { 0.0 }).collect();
        }
        let step = step(parameter, values);
        let moved = self.residuals(&values.moved(parameter, step));
        moved.iter().zip(at).map(|(moved, at)| (moved - at) / step).collect()
    }
}
