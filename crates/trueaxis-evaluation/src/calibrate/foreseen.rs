//! Plans a task with its expected standard errors, and solves a task from its log, in one call each.

use super::log::read_log;
use super::plan::Plan;
use super::program::program;
use super::solve::{Calibration, calibrate, foresee};
use super::task::Task;
use super::trips::trips;
use anyhow::Result;
use serde::Serialize;
use std::path::Path;
use trueaxis_tables::Machine;

/// A term with the standard error expected from the stated repeatability.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expected {
    /// Name of the term.
    pub name: String,
    /// The standard error.
    pub standard_error: f64,
    /// Unit of the standard error.
    pub unit: &'static str,
}

/// The document that `trueaxis calibrate plan --json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Foreseen {
    /// The machine's name.
    pub machine: String,
    /// Program number that the log states, eight hexadecimal digits.
    pub program: String,
    /// Number of touches.
    pub touches: usize,
    /// Time without set-ups, minutes.
    pub minutes: f64,
    /// Every term.
    pub terms: Vec<Expected>,
    /// Number of unknowns, all distinguishable.
    pub rank: usize,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Conditions that may spoil the result, one sentence each.
    pub warnings: Vec<String>,
}

/// A planned task.
#[derive(Clone, Debug)]
pub struct Planning {
    /// Touches of the task.
    pub plan: Plan,
    /// The program in the task's dialect.
    pub program: String,
    /// How well every term would be known.
    pub foreseen: Foreseen,
}

impl Planning {
    /// Plans a task on a machine.
    ///
    /// # Errors
    /// As [`Plan::new`] and [`foresee`].
    pub fn new(task: &Task, machine: &Machine) -> Result<Planning> {
        let plan = Plan::new(task, machine)?;
        let Calibration { observed, solution, .. } = foresee(task, machine, &plan)?;
        let terms = observed.terms.terms.iter().zip(&solution.standard_errors).map(|(term, error)| {
            let (unit, factor) = term.unit();
            Expected { name: term.name(), standard_error: factor * error, unit }
        });
        let drift = "no [reference]: a drift while probing would be in the results";
        let foreseen = Foreseen {
            machine: machine.settings.name.to_string(),
            program: plan.number(),
            touches: plan.touches.len(),
            minutes: plan.minutes(),
            terms: terms.collect(),
            rank: solution.rank,
            condition: solution.condition,
            warnings: task.reference.is_none().then(|| drift.into()).into_iter().collect(),
        };
        Ok(Planning { program: program(task, machine, &plan), plan, foreseen })
    }
}

/// Solves a task from the text of its log. `file` names the log in errors; unusual separators in it are reported to the
/// callback.
///
/// # Errors
/// As [`read_log`], [`Plan::new`], [`trips`] and [`calibrate`].
pub fn solved(
    task: &Task,
    machine: &Machine,
    text: &str,
    file: &Path,
    note: impl FnMut(String),
) -> Result<(Plan, Calibration)> {
    let log = read_log(text, file, task.dialect, note)?;
    let plan = Plan::new(task, machine)?;
    let trips = trips(task, &plan, &log, file)?;
    let found = calibrate(task, machine, &plan, &trips, file)?;
    Ok((plan, found))
}
