//! The fit: causes and lags by search, curves by least squares, and the model for the task.

use super::basis::{Cause, Chosen, Problem, slot};
use super::check::{OWN_RATE, check, fastest_k_per_min, longest_run_s};
use super::linear::{Solved, solve};
use super::missing::{Missing, missing};
use super::model::{AxisCurves, Model, SensorCurve, Spindle};
use super::search::{DIFFERENCE, Parts, Search};
use super::{Record, Settings, ThermalRefusal, span};
use nalgebra::{DMatrix, DVector};
use std::string::{String, ToString};
use std::vec;
use std::vec::Vec;
use trueaxis::Axis;
use trueaxis::temperature::{COLDEST_MK, WARMEST_MK};

/// Condition number above which the causes count as inseparable.
const CONDITION_LIMIT: f64 = 1e4;
/// Prior standard deviation of a lag's logarithm: between 30 s and 6 h.
const LAG_KNOWN: f64 = 2.0;
/// Curves continue straight beyond the recorded range by this share of it.
const BEYOND: f64 = 0.25;
/// A sensor counts as stuck if it repeats a reading this many times longer than ever in the record, and at least this long, s.
const STUCK_TIMES: f64 = 4.0;
const STUCK_LEAST_S: f64 = 600.0;

/// Value of a curve at a knot, with standard errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficient {
    /// Offset or growth, mm; slope or tilt.
    pub value: [f64; 2],
    /// Standard errors of the values; 0 for parts that the curve does not have.
    pub standard_error: [f64; 2],
}

/// Result for one axis.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct OfAxis {
    /// The axis.
    pub axis: Axis,
    /// Values at the knots of each sensor of the model.
    pub sensors: Vec<Vec<Coefficient>>,
    /// Values at the speed knots.
    pub spindle: Vec<Coefficient>,
    /// Root mean square residual of the fitted cycles, mm.
    pub rms_mm: f64,
    /// Condition number of the fit.
    pub condition: f64,
}

/// A sensor, or the spindle, that the model does not use.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Name of the sensor, or `spindle`.
    pub name: String,
    /// Range over the record, K or rpm.
    pub range: f64,
    /// Whether it moves too little to be used; otherwise it adds nothing to the prediction by others.
    pub still: bool,
}

/// A model with its standard errors and residuals.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Fit {
    /// Model for the task.
    pub model: Model,
    /// Index in the record of each sensor of the model, from 0.
    pub sensors: Vec<usize>,
    /// Values with their standard errors.
    pub axes: Vec<OfAxis>,
    /// Covariance of the values at the knots, row by row: axis by axis, the knots of its sensors and then of the spindle, two
    /// values each; products of mm, mm/K and their like. Row and column are zero for a value that the fit does not have.
    ///
    /// It is conditional on the causes and bends found, and includes the uncertainty of the lags, which all axes share.
    /// The residuals of different axes count as independent. The search takes the lags that predict best, which are less certain
    /// than those of least squares: values that depend on them scatter by up to 1.4 standard errors in the tests.
    pub covariance: Vec<Vec<f64>>,
    /// Sensors, or the spindle, that the model does not use.
    pub left_out: Vec<LeftOut>,
    /// Root mean square of the drift over all axes, mm, and of the residual when each cycle is predicted from the others.
    pub predicted_mm: [f64; 2],
    /// Cycles excluded from the fit.
    pub held_out: Vec<u32>,
    /// Speeds of the model that only one fitted cycle has, each with that cycle: no other cycle predicts them, so their share
    /// of `predicted_mm` is the residual of the fit, and no second cycle confirms their values.
    pub unconfirmed: Vec<(f64, u32)>,
    /// Rows missing from the record; the fit can follow across all of them.
    pub missing: Vec<Missing>,
    /// If every cycle is held out in turn, the fits without one cycle each: causes, lags and parts as in this one, values from
    /// the other cycles, none of them listed as unconfirmed.
    pub turns: Vec<Fit>,
}

/// Fits lags and curves; reports each cause that enters, by name, to the callback.
///
/// Cost: some seconds for a thousand rows and ten sensors.
///
/// # Errors
/// [`ThermalRefusal`].
pub fn fit(record: &Record, settings: &Settings, on_cause: &mut dyn FnMut(&str)) -> Result<Fit, ThermalRefusal> {
    check(record, settings.rate_k_per_min)?;
    let (held_out, cycles) = (held_out(record, settings)?, record.cycles());
    let rows_without = |out: &[u32]| -> Vec<usize> {
        (0..record.samples.len()).filter(|row| !out.contains(&record.samples[*row].cycle)).collect()
    };
    let in_turn = cycles.iter().all(|cycle| held_out.contains(cycle));
    let rows = rows_without(if in_turn { &[] } else { &held_out });
    let problem = Problem::new(record, settings, &rows);
    let search = Search::new(&problem, &rows);
    let name = |cause: Cause| match cause {
        Cause::Sensor(sensor) => record.sensors[sensor].clone(),
        Cause::Spindle => "spindle".into(),
    };
    let (mut causes, left) = search.causes(&mut |cause| on_cause(&name(cause)));
    if causes.is_empty() {
        return Err(ThermalRefusal::NothingFound);
    }
    // Sensors in the order of the record, the spindle last.
    causes.sort_by_key(|chosen| match chosen.cause {
        Cause::Sensor(sensor) => sensor,
        Cause::Spindle => usize::MAX,
    });
    let count = (rows.len() * record.axes.len()).max(1) as f64 / search.share();
    let predicted_mm = left.map(|squares| (squares / count).sqrt());
    let found = Found { problem: &problem, causes: &causes, predicted_mm };
    let parts: Vec<Vec<Parts>> = (0..record.axes.len()).map(|axis| search.parts(axis, &causes)).collect();
    let mut fit = found.fit(&rows, &parts, held_out)?;
    followed(&fit)?;
    if in_turn {
        let without = |cycle: &u32| {
            let turn = found.fit(&rows_without(&[*cycle]), &parts, vec![*cycle]);
            let turn = turn.map(|turn| Fit { unconfirmed: Vec::new(), ..turn });
            turn.map_err(|refusal| ThermalRefusal::WithoutCycle { cycle: *cycle, refusal: refusal.into() })
        };
        fit.turns = cycles.iter().map(without).collect::<Result<_, _>>()?;
    }
    Ok(fit)
}

/// Causes with their lags and bends, and the drift before and after, as in [`Fit::predicted_mm`].
struct Found<'p, 'r> {
    problem: &'p Problem<'r>,
    causes: &'p [Chosen],
    predicted_mm: [f64; 2],
}

impl Found<'_, '_> {
    /// Fits the curves to these rows.
    fn fit(&self, rows: &[usize], parts: &[Vec<Parts>], held_out: Vec<u32>) -> Result<Fit, ThermalRefusal> {
        let Found { problem, causes, predicted_mm } = *self;
        let (record, settings) = (problem.record, problem.settings);
        let sensors: Vec<usize> = causes.iter().filter_map(|chosen| sensor(chosen.cause)).collect();
        let linear = (0..record.axes.len()).map(|axis| Linear::of(problem, rows, axis, causes, &parts[axis]));
        let linear = linear.collect::<Result<Vec<Linear>, ThermalRefusal>>()?;
        let lags = lags(&linear, causes.len());
        let found = (0..record.axes.len()).map(|axis| of_axis(problem, axis, causes, &linear[axis], &lags));
        let (axes, weights): (Vec<OfAxis>, Vec<Vec<DVector<f64>>>) = found.unzip();
        let covariance = covariance(&linear, &weights, &lags);
        let curves = |of: &OfAxis| AxisCurves {
            axis: of.axis,
            datum: settings.datum_mm[slot(of.axis)],
            sensors: of.sensors.iter().map(|curve| curve.iter().map(|at| at.value).collect()).collect(),
            spindle: of.spindle.iter().map(|at| at.value).collect(),
        };
        let spindle = causes.iter().find(|chosen| chosen.cause == Cause::Spindle);
        let model = Model {
            sensors: causes.iter().filter_map(|chosen| curve(record, settings.rate_k_per_min, chosen)).collect(),
            spindle: spindle.map(|chosen| Spindle { lag_s: chosen.lag_s, knots_rpm: problem.speeds_rpm.clone() }),
            axes: axes.iter().map(curves).collect(),
        };
        model.encode(0).map_err(ThermalRefusal::Encoding)?;
        let mut fitted: Vec<u32> = rows.iter().map(|row| record.samples[*row].cycle).collect();
        fitted.dedup();
        let knots = problem.speeds_rpm.iter().zip(&problem.lone).filter(|_| model.spindle.is_some());
        let unconfirmed = knots.filter_map(|(rpm, lone)| Some((*rpm, *fitted.get((*lone)?)?))).collect();
        let left_out = left_out(record, problem, causes);
        let (missing, turns) = (missing(record), Vec::new());
        Ok(Fit { left_out, model, sensors, axes, covariance, predicted_mm, held_out, unconfirmed, missing, turns })
    }
}

fn held_out(record: &Record, settings: &Settings) -> Result<Vec<u32>, ThermalRefusal> {
    let cycles = record.cycles();
    let named = if settings.held_out.is_empty() {
        cycles.last().copied().into_iter().collect()
    } else {
        settings.held_out.clone()
    };
    for &cycle in &named {
        let every = cycles.iter().all(|cycle| named.contains(cycle));
        if !cycles.contains(&cycle) || (cycles.len() < named.len() + 2 && !every) {
            return Err(ThermalRefusal::HeldOut { cycle });
        }
    }
    Ok(named)
}

fn sensor(cause: Cause) -> Option<usize> {
    match cause {
        Cause::Sensor(sensor) => Some(sensor),
        Cause::Spindle => None,
    }
}

/// Knots of a sensor's curves: beyond both ends of the recorded range, within the limits of the file, and at the bends.
fn knots(record: &Record, sensor: usize, bends: &[f64]) -> Vec<f64> {
    let [low, high] = span(record.readings(sensor));
    let beyond = BEYOND * (high - low);
    let millis = |value: f64| (1e3 * value).round() / 1e3;
    let [coldest, warmest] = [COLDEST_MK, WARMEST_MK].map(|limit| 1e-3 * f64::from(limit));
    let ends = [(low - beyond).max(coldest), (high + beyond).min(warmest)];
    core::iter::once(ends[0]).chain(bends.iter().copied()).chain([ends[1]]).map(millis).collect()
}

fn curve(record: &Record, rate_k_per_min: Option<f64>, chosen: &Chosen) -> Option<SensorCurve> {
    let sensor = sensor(chosen.cause)?;
    let lag_s = (10.0 * chosen.lag_s).round() / 10.0;
    let stuck_s = (STUCK_TIMES * longest_run_s(record, sensor)).max(STUCK_LEAST_S).round();
    let knots = knots(record, sensor, &chosen.bends_c);
    let usual = SensorCurve::new(&record.sensors[sensor], lag_s, knots);
    let [least, most] = usual.plausible_c;
    let ends = [usual.knots_c.first().copied().unwrap_or(least), usual.knots_c.last().copied().unwrap_or(most)];
    // The recorded readings, and changes at the stated rate or twice the sensor's own, must be plausible to the task.
    let plausible_c = [least.min(ends[0]), most.max(ends[1])];
    let [sudden_k, usual_rate] = usual.jump_k;
    let own = || (OWN_RATE * fastest_k_per_min(record, sensor, sudden_k)).ceil();
    let jump_k = [sudden_k, usual_rate.max(rate_k_per_min.unwrap_or_else(own))];
    Some(SensorCurve { stuck_s, plausible_c, jump_k, ..usual })
}

/// The linear problem of one axis, solved for the lags found.
struct Linear {
    /// Cause, index of its response, and part, for each column.
    places: Vec<(usize, usize, usize)>,
    values: DVector<f64>,
    covariance: DMatrix<f64>,
    condition: f64,
    rms_mm: f64,
    /// Derivative of the values with respect to the logarithm of each cause's lag.
    slopes: Vec<DVector<f64>>,
    /// Information of this axis on the logarithms of the lags: the inverse of their covariance.
    information: DMatrix<f64>,
}

impl Linear {
    fn of(
        problem: &Problem<'_>,
        rows: &[usize],
        axis: usize,
        causes: &[Chosen],
        parts: &[Parts],
    ) -> Result<Linear, ThermalRefusal> {
        let record = problem.record;
        let name = record.axes[axis];
        let lever = |part: usize, cause, row| if part == 0 { 1.0 } else { problem.lever(name, cause, row) };
        let (mut columns, mut places) = (Vec::new(), Vec::new());
        for (which, chosen) in causes.iter().enumerate() {
            for (k, response) in problem.responses(chosen).iter().enumerate() {
                for part in [0, 1].into_iter().filter(|part| parts[which][*part]) {
                    let column = problem.centred(rows, |row| response[row] * lever(part, chosen.cause, row));
                    // After its lag a sensor may never have reached the bend of its curve.
                    if column.iter().any(|value| *value != 0.0) {
                        columns.push(column);
                        places.push((which, k, part));
                    }
                }
            }
        }
        let right = problem.centred(rows, |row| record.samples[row].error_mm[axis]);
        let zeros: Vec<usize> = rows.iter().map(|row| problem.groups[*row]).collect();
        let (lost, step) = zeros_lost(&zeros);
        let count = causes.len();
        let solved = match solve(&columns, &right, lost, step) {
            Some(solved) if solved.condition <= CONDITION_LIMIT => solved,
            Some(solved) => return Err(ThermalRefusal::Condition { found: solved.condition }),
            None if !columns.is_empty() => return Err(ThermalRefusal::Condition { found: f64::INFINITY }),
            // No cause predicts this axis.
            None => {
                let rms_mm = (right.iter().map(|x| x * x).sum::<f64>() / right.len().max(1) as f64).sqrt();
                let (values, covariance) = (DVector::zeros(0), DMatrix::zeros(0, 0));
                let (slopes, information) = (vec![DVector::zeros(0); count], DMatrix::zeros(count, count));
                return Ok(Linear { places, values, covariance, condition: 1.0, rms_mm, slopes, information });
            }
        };
        // Change of the drift with the logarithm of each lag, and the part of it that the values cannot absorb.
        let (mut slopes, mut left) = (Vec::new(), Vec::new());
        for (which, chosen) in causes.iter().enumerate() {
            let at = |factor: f64| problem.responses(&Chosen { lag_s: factor * chosen.lag_s, ..chosen.clone() });
            let (longer, shorter) = (at(DIFFERENCE.exp()), at((-DIFFERENCE).exp()));
            let own = || places.iter().zip(solved.values.iter()).filter(|((cause, ..), _)| *cause == which);
            let change = problem.centred(rows, |row| {
                let sum = own().map(|(&(_, k, part), value)| {
                    value * (longer[k][row] - shorter[k][row]) * lever(part, chosen.cause, row)
                });
                sum.sum::<f64>() / (2.0 * DIFFERENCE)
            });
            let made_up =
                solve(&columns, &change, lost, step).map_or_else(|| DVector::zeros(columns.len()), |own| own.values);
            let mut rest = change;
            for (column, share) in columns.iter().zip(made_up.iter()) {
                rest.iter_mut().zip(column).for_each(|(rest, value)| *rest -= share * value);
            }
            slopes.push(-made_up);
            left.push(rest);
        }
        let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
        let variance = solved.variance.max(f64::MIN_POSITIVE);
        let information = DMatrix::from_fn(count, count, |i, j| dot(&left[i], &left[j]) / variance);
        let Solved { values, covariance, condition, rms: rms_mm, .. } = solved;
        Ok(Linear { places, values, covariance, condition, rms_mm, slopes, information })
    }
}

/// Covariance of the logarithms of the lags, from the information of all axes and the prior.
fn lags(axes: &[Linear], count: usize) -> DMatrix<f64> {
    let beforehand = DMatrix::identity(count, count) / (LAG_KNOWN * LAG_KNOWN);
    let information = axes.iter().fold(beforehand, |sum, axis| sum + &axis.information);
    information.cholesky().map_or_else(|| DMatrix::zeros(count, count), |factors| factors.inverse())
}

/// A sum of an axis' values.
struct Sum<'w> {
    axis: usize,
    weights: &'w DVector<f64>,
    /// Derivative with respect to the logarithm of each cause's lag.
    slopes: DVector<f64>,
}

/// Covariance of the sums of the axes' values with these weights, by axis.
fn covariance(linear: &[Linear], weights: &[Vec<DVector<f64>>], lags: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let mut sums = Vec::new();
    for (axis, (linear, weights)) in linear.iter().zip(weights).enumerate() {
        sums.extend(weights.iter().map(|weights| {
            let slopes = linear.slopes.iter().map(|slope| slope.dot(weights));
            Sum { axis, weights, slopes: DVector::from_iterator(linear.slopes.len(), slopes) }
        }));
    }
    let entry = |one: &Sum<'_>, other: &Sum<'_>| {
        let own =
            if one.axis == other.axis { one.weights.dot(&(&linear[one.axis].covariance * other.weights)) } else { 0.0 };
        own + one.slopes.dot(&(lags * &other.slopes))
    };
    sums.iter().map(|one| sums.iter().map(|other| entry(one, other)).collect()).collect()
}

/// Values of an axis at the knots, and the weights of the linear problem's values in each, in the order of [`Fit::covariance`].
fn of_axis(
    problem: &Problem<'_>,
    axis: usize,
    causes: &[Chosen],
    linear: &Linear,
    lags: &DMatrix<f64>,
) -> (OfAxis, Vec<DVector<f64>>) {
    let record = problem.record;
    let name = record.axes[axis];
    let Linear { places, values, condition, rms_mm, .. } = linear;
    let mut covariance = linear.covariance.clone();
    for (one, along) in linear.slopes.iter().enumerate() {
        for (other, across) in linear.slopes.iter().enumerate() {
            covariance += along * across.transpose() * lags[(one, other)];
        }
    }
    // A value at a knot is the sum of the parts' contributions there.
    let mut all_weights = Vec::new();
    let mut at = |which: usize, shares: &[f64]| {
        let mut found = Coefficient { value: [0.0; 2], standard_error: [0.0; 2] };
        for part in [0, 1] {
            let own = |i: usize| {
                let (cause, k, of) = places[i];
                if cause == which && of == part { shares.get(k).copied().unwrap_or(0.0) } else { 0.0 }
            };
            let weights: Vec<f64> = (0..places.len()).map(own).collect();
            found.value[part] = weights.iter().zip(values.iter()).map(|(weight, value)| weight * value).sum();
            let mut variance = 0.0;
            for (i, one) in weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                variance += weights.iter().enumerate().map(|(j, other)| one * other * covariance[(i, j)]).sum::<f64>();
            }
            found.standard_error[part] = variance.max(0.0).sqrt();
            all_weights.push(DVector::from_vec(weights));
        }
        found
    };
    let reference = problem.settings.reference_c;
    let (rms_mm, condition) = (*rms_mm, *condition);
    let mut found = OfAxis { axis: name, sensors: Vec::new(), spindle: Vec::new(), rms_mm, condition };
    for (which, chosen) in causes.iter().enumerate() {
        match chosen.cause {
            Cause::Sensor(sensor) => {
                let bends = &chosen.bends_c;
                let curve = knots(record, sensor, bends).into_iter().map(|knot| {
                    let bent = bends.iter().map(|bend| (knot - bend).max(0.0) - (reference - bend).max(0.0));
                    at(which, &core::iter::once(knot - reference).chain(bent).collect::<Vec<f64>>())
                });
                found.sensors.push(curve.collect());
            }
            Cause::Spindle => {
                let speeds = problem.speeds_rpm.len();
                let unit = |knot: usize| (1..speeds).map(|k| if k == knot { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
                found.spindle = (0..speeds).map(|knot| at(which, &unit(knot))).collect();
            }
        }
    }
    (found, all_weights)
}

/// Number of zeros among the rows, and number of measuring points per moment.
fn zeros_lost(groups: &[usize]) -> (usize, usize) {
    let mut known: Vec<usize> = Vec::new();
    for group in groups {
        if !known.contains(group) {
            known.push(*group);
        }
    }
    let first = groups.first();
    let step = groups.iter().skip(1).position(|group| Some(group) == first).map_or(1, |k| k + 1);
    (known.len(), step)
}

fn left_out(record: &Record, problem: &Problem<'_>, causes: &[Chosen]) -> Vec<LeftOut> {
    let known = |cause: Cause| causes.iter().any(|chosen| chosen.cause == cause);
    let able = problem.causes();
    let mut left_out = vec![];
    for sensor in (0..record.sensors.len()).filter(|sensor| !known(Cause::Sensor(*sensor))) {
        let [low, high] = span(record.readings(sensor));
        let still = !able.contains(&Cause::Sensor(sensor));
        left_out.push(LeftOut { name: record.sensors[sensor].clone(), range: high - low, still });
    }
    if !known(Cause::Spindle) {
        let [low, high] = span(record.samples.iter().map(|sample| sample.spindle_rpm.abs()));
        let still = !able.contains(&Cause::Spindle);
        left_out.push(LeftOut { name: "spindle".into(), range: high - low, still });
    }
    left_out
}

/// Refuses a fit that cannot follow the temperature across missing rows: the gap is longer than a lag, but the usual interval
/// of the rows is not. After such a gap, at least 1 − 1/e of the lagged temperature comes from unrecorded readings.
fn followed(fit: &Fit) -> Result<(), ThermalRefusal> {
    let sensors = fit.model.sensors.iter().map(|sensor| (sensor.name.as_str(), sensor.lag_s));
    let lags: Vec<(&str, f64)> = sensors.chain(fit.model.spindle.iter().map(|of| ("spindle", of.lag_s))).collect();
    for own in &fit.missing {
        let lost = lags.iter().filter(|(_, lag_s)| (own.interval_s..own.unknown_s).contains(lag_s));
        if let Some((name, lag_s)) = lost.min_by(|one, other| one.1.total_cmp(&other.1)) {
            return Err(ThermalRefusal::Missing { missing: *own, of: name.to_string(), lag_s: *lag_s });
        }
    }
    Ok(())
}
