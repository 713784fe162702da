//! Selects the parameters that the record determines: fixes the others, or refuses the record.

use super::least_squares::{self, Fit, fit};
use super::parameters::{
    COULOMB, COUNT, FEED_FORWARD, FEED_LAG, OFFSET, POSITION_GAIN, PRESLIDING, Problem, READING_LAG, RESET_TIME, REST,
    STRIBECK_SHARE, STRIBECK_VELOCITY, VELOCITY_GAIN, VISCOUS, Values,
};
use super::refused::FrictionRefusal;
use std::vec::Vec;
use trueaxis::Axis;

/// A parameter counts as determined at this many standard errors from 0.
const SIGNIFICANT: f64 = 3.0;
/// Largest relative standard error of a drive figure.
const LOOSE: f64 = 0.2;
/// Like [`LOOSE`], including the uncertainty of the times within a cycle.
const LOOSE_IN_TIME: f64 = 0.5;
/// Figures that the record must determine to identify a drive.
const DRIVE_FIGURES: [usize; 3] = [POSITION_GAIN, RESET_TIME, VELOCITY_GAIN];
/// Least residual with position gain and reset time exchanged, relative to that of the fit.
const EXCHANGED: f64 = 1.02;

/// Fits the parameters that the record determines; the others are fixed at neutral values.
pub(super) fn reduced(
    axis: Axis,
    [coarse, problem]: [&Problem; 2],
    start: Values,
    (with_drive, rests): (bool, bool),
    on_step: &mut dyn FnMut(),
) -> Result<(Fit, Vec<usize>), FrictionRefusal> {
    let unsettled = || FrictionRefusal::NoConvergence { axis, steps: least_squares::STEPS };
    let mut free = Vec::from([COULOMB, PRESLIDING, OFFSET]);
    if with_drive {
        free.extend([POSITION_GAIN, RESET_TIME, FEED_FORWARD, VELOCITY_GAIN]);
    } else {
        free.push(READING_LAG);
    }
    let rough = fit(coarse, start, &free, on_step).ok_or_else(unsettled)?;
    let mut values = rough.values;
    if with_drive {
        values = the_better_order(axis, coarse, &rough, &free, on_step)?;
        free.push(if problem.read_after_s.is_none() { READING_LAG } else { FEED_LAG });
    }
    if rests {
        free.push(REST);
    }
    let with = |parameter: usize| [&free[..], &[parameter, STRIBECK_SHARE, STRIBECK_VELOCITY]].concat();
    let (found, observable) =
        fit_of_observable_terms(problem, values, with(VISCOUS), with_drive, on_step).ok_or_else(unsettled)?;
    if with_drive
        || found.values.0[VISCOUS] >= SIGNIFICANT * found.uncertainties[VISCOUS] && observable.contains(&VISCOUS)
    {
        return Ok((found, observable));
    }
    // Apparent viscous friction may be a feed-forward that acts late in its cycle.
    values = found.values;
    (values.0[VISCOUS], values.0[FEED_LAG]) = (0.0, 0.5);
    let late = fit_of_observable_terms(problem, values, with(FEED_LAG), with_drive, on_step);
    let is_as_good =
        |(other, _): &(Fit, Vec<usize>)| !other.values.is_at_an_end(FEED_LAG) && other.rms <= EXCHANGED * found.rms;
    Ok(late.filter(is_as_good).unwrap_or((found, observable)))
}

/// Fits those of the parameters `free` that the record determines, and returns which; `None` if the fit does not converge.
fn fit_of_observable_terms(
    problem: &Problem,
    mut values: Values,
    mut free: Vec<usize>,
    with_drive: bool,
    on_step: &mut dyn FnMut(),
) -> Option<(Fit, Vec<usize>)> {
    loop {
        let found = fit(problem, values, &free, on_step)?;
        let Some(held) = unobservable(&found, &free, with_drive) else { return Some((found, free)) };
        values = found.values;
        for parameter in held {
            free.retain(|p| p != parameter);
            values.0[*parameter] = if *parameter == STRIBECK_VELOCITY { 2.0 } else { 0.0 };
        }
    }
}

/// The parameters to fix next: the first that can be omitted and that the fit does not determine, in a fixed order.
///
/// Viscous friction and velocity feed-forward act alike on a circle. If the drive is fitted, viscous friction therefore stays
/// free, however uncertain (fixing it at 0 would bias K_v), unless it leaves the drive undetermined.
fn unobservable(found: &Fit, free: &[usize], with_drive: bool) -> Option<&'static [usize]> {
    let value = |parameter: usize| found.values.0[parameter];
    let significance = |parameter: usize| value(parameter).abs() / found.errors[parameter];
    let loose = !with_drive || !DRIVE_FIGURES.iter().all(|&p| found.errors[p] <= LOOSE * value(p));
    let is_observable = |parameter: usize| match parameter {
        READING_LAG => significance(parameter) >= SIGNIFICANT,
        VISCOUS => value(parameter) > 0.0 && (significance(parameter) >= SIGNIFICANT || !loose),
        _ => value(parameter) > 0.0 && significance(parameter) >= SIGNIFICANT,
    };
    let candidates: [(usize, &'static [usize]); 4] = [
        (READING_LAG, &[READING_LAG]),
        (STRIBECK_SHARE, &[STRIBECK_SHARE, STRIBECK_VELOCITY]),
        (STRIBECK_VELOCITY, &[STRIBECK_VELOCITY]),
        (VISCOUS, &[VISCOUS]),
    ];
    let next = candidates.into_iter().find(|(parameter, _)| free.contains(parameter) && !is_observable(*parameter));
    next.map(|(_, held)| held)
}

/// The better of a fit and the one started with position gain and 1/reset time exchanged.
fn the_better_order(
    axis: Axis,
    problem: &Problem,
    found: &Fit,
    free: &[usize],
    on_step: &mut dyn FnMut(),
) -> Result<Values, FrictionRefusal> {
    let mut start = found.values;
    let [gain, reset] = [start.0[POSITION_GAIN], start.0[RESET_TIME]];
    start.0[POSITION_GAIN] = 1.0 / reset;
    start.0[RESET_TIME] = 1.0 / gain;
    start.0[FEED_FORWARD] = (1.0 - (1.0 - start.0[FEED_FORWARD]) / (gain * reset)).max(0.0);
    let Some(other) = fit(problem, start, free, on_step) else { return Ok(found.values) };
    let [best, worse] = if found.rms <= other.rms { [found, &other] } else { [&other, found] };
    let apart = |parameter: usize| (best.values.0[parameter] / worse.values.0[parameter]).ln().abs();
    if apart(POSITION_GAIN).max(apart(RESET_TIME)) > 0.02 && worse.rms < EXCHANGED * best.rms {
        return Err(FrictionRefusal::GainOrResetTime {
            axis,
            position_gain_per_s: best.values.0[POSITION_GAIN],
            reset_time_s: best.values.0[RESET_TIME],
            residual_um: 1e3 * best.rms,
            exchanged_um: 1e3 * worse.rms,
        });
    }
    Ok(best.values)
}

/// Refuses a fit that leaves figures for the feed-forward undetermined.
pub(super) fn judge(axis: Axis, found: &Fit, free: &[usize], with_drive: bool) -> Result<(), FrictionRefusal> {
    if found.rank < free.len() {
        return Err(FrictionRefusal::RankShort { axis, rank: found.rank, of: free.len(), condition: found.condition });
    }
    let [value, error] = [found.values.0[COULOMB], found.errors[COULOMB]];
    let is_significant = value > SIGNIFICANT * error;
    if !is_significant {
        return Err(FrictionRefusal::NoFriction { axis, found_mm_per_s: value, standard_error_mm_per_s: error });
    }
    let circles = "circles of another radius or at another feed";
    let drive = "a record that starts and stops, or the drive's figures (--machine)";
    let mut needed = Vec::from([(PRESLIDING, "pre-sliding", circles)]);
    if with_drive {
        needed.extend([
            (POSITION_GAIN, "position gain", drive),
            (RESET_TIME, "reset time", drive),
            (VELOCITY_GAIN, "velocity gain", drive),
        ]);
    }
    for (parameter, figure, needed) in needed {
        let share = |of: &[f64; COUNT]| of[parameter] / found.values.0[parameter];
        let is_tight = share(&found.errors) <= LOOSE && share(&found.uncertainties) <= LOOSE_IN_TIME;
        if !is_tight {
            let relative_error = share(&found.uncertainties);
            return Err(FrictionRefusal::NotExcited { axis, figure, relative_error, needed });
        }
    }
    Ok(())
}
