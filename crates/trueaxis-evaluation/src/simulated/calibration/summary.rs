//! Statistics over many simulated calibrations.

use super::{Conditions, FiveAxes, Outcome, RefusedMachine, TaskText, five_axes, three_axes};
use anyhow::Result;
use rayon::prelude::*;
use serde::Serialize;
use trueaxis_sim::calibration::Class;

/// Statistics over many machines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Number of calibrated three-axis machines.
    pub machines: usize,
    /// Number of machines of either kind whose calibration was refused; they enter no other figure.
    pub refused: usize,
    /// Median share of the volumetric error (root mean square) that is removed.
    pub median_removed: f64,
    /// Smallest share removed on any machine.
    pub least_removed: f64,
    /// Machines whose error is larger after calibration than before, root mean square or maximum.
    pub made_worse: usize,
    /// Position error of the centre lines of the worst five-axis machine, µm.
    pub worst_place_um: f64,
    /// Tilt error of the worst five-axis machine, µrad.
    pub worst_tilt_urad: f64,
    /// Median position error, µm.
    pub median_place_um: f64,
    /// Median tilt error, µrad.
    pub median_tilt_urad: f64,
}

/// Results of many machines.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Machines {
    /// Three-axis machines.
    pub three_axes: Vec<Outcome>,
    /// Five-axis machines.
    pub five_axes: Vec<FiveAxes>,
    /// Refused machines, which are in neither list.
    pub refused: Vec<RefusedMachine>,
}

/// Calibrates `machines` three-axis machines with consecutive seeds from `seed`, and a tenth as many with five axes, by one
/// task for each kind; `done` is called after each machine. Refused machines are in [`Machines::refused`].
///
/// # Errors
/// A task cannot be read or planned.
pub fn all<'t>(
    machines: u64,
    seed: u64,
    tasks: [impl Into<TaskText<'t>>; 2],
    class: &Class,
    conditions: &Conditions,
    done: &(dyn Fn() + Sync),
) -> Result<Machines> {
    let [mill, trunnion] = tasks.map(Into::into);
    let with_seed = |count: u64| (0..count).into_par_iter().map(move |k| seed.wrapping_add(k));
    let three = with_seed(machines).map(|seed| split_refusal(three_axes(seed, mill, class, conditions), done));
    let three = three.collect::<Result<Vec<_>>>()?;
    let five =
        with_seed(machines.div_ceil(10)).map(|seed| split_refusal(five_axes(seed, trunnion, class, conditions), done));
    let mut all = Machines::default();
    for one in five.collect::<Result<Vec<_>>>()? {
        one.map_or_else(|refused| all.refused.push(refused), |one| all.five_axes.push(one));
    }
    for one in three {
        one.map_or_else(|refused| all.refused.push(refused), |one| all.three_axes.push(one));
    }
    all.refused.sort_by_key(|refused| (refused.axes, refused.seed));
    Ok(all)
}

/// Separates the refusal of one machine from errors that end the run.
fn split_refusal<T>(outcome: Result<T>, done: &(dyn Fn() + Sync)) -> Result<Result<T, RefusedMachine>> {
    done();
    match outcome {
        Ok(outcome) => Ok(Ok(outcome)),
        Err(error) => error.downcast::<RefusedMachine>().map(Err),
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    match values.len() % 2 {
        0 if half > 0 => 0.5 * (values[half - 1] + values[half]),
        _ => values.get(half).copied().unwrap_or_default(),
    }
}

/// Computes the statistics.
///
/// Without a three-axis machine, the smallest share is NaN.
pub fn summary(all: &Machines) -> Summary {
    let (three, five) = (&all.three_axes, &all.five_axes);
    let worse = |one: &&Outcome| one.after_um.rms > one.before_um.rms || one.after_um.max > one.before_um.max;
    Summary {
        machines: three.len(),
        refused: all.refused.len(),
        median_removed: median(three.iter().map(|one| one.removed)),
        least_removed: three.iter().map(|one| one.removed).fold(f64::NAN, f64::min),
        made_worse: three.iter().filter(worse).count(),
        worst_place_um: five.iter().map(|one| one.place_um).fold(0.0, f64::max),
        worst_tilt_urad: five.iter().map(|one| one.tilt_urad).fold(0.0, f64::max),
        median_place_um: median(five.iter().map(|one| one.place_um)),
        median_tilt_urad: median(five.iter().map(|one| one.tilt_urad)),
    }
}
