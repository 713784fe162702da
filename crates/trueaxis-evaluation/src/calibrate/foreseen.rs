//! Plans a task with its expected standard errors, before anything is measured.

use super::grid::stylus;
use super::observed::{Observed, observe};
use super::place::Place;
use super::plan::Plan;
use super::program::program;
use super::solve::Calibration;
use super::source::Source;
use super::task::Task;
use crate::shown::{EXPANDED, Table, Uncertainty};
use anyhow::Result;
use serde::Serialize;
use trueaxis::machine::AXES;
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

impl Foreseen {
    /// The uncertainties expected.
    pub fn expected(&self) -> Table {
        let row = |of: &Expected| {
            vec![of.name.as_str().into(), Uncertainty::foreseen(of.standard_error).cell(), of.unit.into()]
        };
        Table::new("Expected uncertainty of every term", ["term", EXPANDED, "unit"], self.terms.iter().map(row))
    }
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
        let found = foresee(task, machine, &plan)?;
        let unseen = found.unseen_words(task);
        let Calibration { observed, solution, .. } = found;
        let terms = observed.terms.terms.iter().zip(&solution.standard_errors).map(|(term, error)| {
            let (unit, factor) = term.unit();
            Expected { name: term.name(), standard_error: factor * error, unit }
        });
        let tilts = observed.tilts().map(|index| Expected {
            name: observed.names[index].clone(),
            standard_error: 1e6 * solution.standard_errors[index],
            unit: "µrad",
        });
        let drift = (task.reference.is_none() && !task.is_read())
            .then(|| "no [reference]: a drift while probing would be in the results".to_owned());
        let foreseen = Foreseen {
            machine: machine.settings.name.to_string(),
            program: plan.number(),
            touches: plan.touches.len(),
            minutes: plan.minutes(),
            terms: terms.chain(tilts).collect(),
            rank: solution.rank,
            condition: solution.condition,
            warnings: drift.into_iter().chain(upright(task)).chain(unseen).collect(),
        };
        Ok(Planning { program: program(task, machine, &plan), plan, foreseen })
    }
}

/// Placements of a plate for which a stylus along Z would run into it.
fn upright(task: &Task) -> impl Iterator<Item = String> {
    task.plate().into_iter().flat_map(|plate| {
        let needs = move |(index, place): (usize, &Place)| {
            Some(format!("{}, place {}, {}", plate.name, index + 1, stylus(place)?))
        };
        plate.places.iter().enumerate().filter_map(needs)
    })
}

/// Checks before measuring whether the places of a task separate its unknowns, and computes the standard errors from the
/// stated repeatability, with every touch at its planned position.
///
/// # Errors
/// The names of the unknowns that cannot be separated.
pub fn foresee(task: &Task, machine: &Machine, plan: &Plan) -> Result<Calibration> {
    let positions = planned(task, plan);
    foresee_observed(task, plan, observe(&Task { compensated: true, ..task.clone() }, machine, plan, &positions)?)
}

/// Axis positions at the touches of a plan if every artefact is where the task says: X, Y, Z, A, B, C.
pub fn planned(task: &Task, plan: &Plan) -> Vec<[f64; AXES]> {
    plan.nominal(&task.probe)
}

/// [`foresee`] for a network of [`planned`] touches.
///
/// # Errors
/// As [`foresee`].
pub fn foresee_observed(task: &Task, plan: &Plan, observed: Observed) -> Result<Calibration> {
    let source = Source { task, plan, file: &task.file, lines: Vec::new() };
    source.separates(&observed)?;
    let solution = observed.network.foresee().map_err(|refused| source.refused(&observed, refused))?;
    Ok(Calibration { observed, solution, lines: Vec::new() })
}
