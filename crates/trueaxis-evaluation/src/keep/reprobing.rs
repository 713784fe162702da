//! Re-probing the balls: which terms have moved, and whether to update each.

use super::entry::BallPlace;
use super::task::{Home, KeepTask};
use crate::calibrate::{
    Calibration, Logged, Observed, Plan, Step, Term, Terms, foresee_observed, observe_terms, planned, settle,
};
use anyhow::{Result, anyhow};
use std::collections::BTreeMap;
use std::path::Path;
use trueaxis::machine::AXES;
use trueaxis_metrology::calibration::{Selection, Unknown};
use trueaxis_tables::Machine;

/// Smallest standard uncertainty of a ball's position at the beginning, mm.
const LEAST: f64 = 1e-6;

/// Decision on a term.
#[derive(Clone, Debug, PartialEq)]
pub enum Decision {
    /// No change: the term has not moved by more than the scatter.
    Unchanged,
    /// The term is changed.
    Update,
    /// The term is out of its bounds, for this reason; a person has to check.
    Refused(String),
}

/// A term after a probing, in mm, rad or 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Name in the task.
    pub name: String,
    /// Residual that the tables leave.
    pub value: f64,
    /// Standard error of the value, at least that of the probe's stated repeatability.
    pub standard_error: f64,
    /// Sum of the updates since the beginning, before this one.
    pub total: f64,
    /// Decision on the term.
    pub decision: Decision,
}

impl Verdict {
    /// Amount added to the machine's files.
    pub fn update(&self) -> f64 {
        if self.decision == Decision::Update { self.value } else { 0.0 }
    }
}

/// A probing of the balls.
#[derive(Clone, Debug)]
pub struct Reprobing {
    /// The network with all terms.
    pub calibration: Calibration,
    /// Positions of the balls, from the network.
    pub balls: Vec<BallPlace>,
    /// One per term of the task, in order; the first probing omits terms that only a later one can determine.
    pub verdicts: Vec<Verdict>,
}

/// The plan of a task: as for a calibration, but without pauses, since no operator is present.
///
/// # Errors
/// As [`Plan::new`], or a term of an axis that the machine lacks.
pub fn plan(task: &KeepTask, machine: &Machine) -> Result<Plan> {
    task.fits(machine)?;
    let mut plan = Plan::new(&task.probing, machine)?;
    plan.steps.retain(|step| !matches!(step, Step::Pause(_)));
    Ok(plan)
}

/// Whether the term can be determined without knowing the balls' positions.
fn is_observable_by_rotation(task: &KeepTask, term: Term) -> bool {
    match term {
        Term::Location(..) | Term::Backlash(_) => true,
        Term::Squareness(_) => task.turns(),
        Term::Curve { .. } => false,
    }
}

/// The network of a probing; `known`: the positions of the balls at the beginning.
fn network(
    task: &KeepTask,
    machine: &Machine,
    plan: &Plan,
    positions: &[[f64; AXES]],
    known: Option<&[BallPlace]>,
) -> Result<Observed> {
    let wanted = task.terms.iter().map(|kept| kept.term);
    let wanted = wanted.filter(|term| known.is_some() || is_observable_by_rotation(task, *term)).collect();
    let terms = Terms::named(wanted, machine, plan.reach_mm(&task.probing));
    let mut observed = observe_terms(&task.probing, machine, plan, positions, terms)?;
    // If rotation determines all terms, a ball that was removed and put back does no harm.
    let needed = task.terms.iter().any(|kept| !is_observable_by_rotation(task, kept.term));
    for (ball, place) in known.unwrap_or_default().iter().enumerate().filter(|_| needed) {
        let Some(&first) = observed.places.get(ball).and_then(|places| places.first()) else { continue };
        for k in 0..3 {
            let uncertainty = Some((1e-3 * place.standard_error_um[k]).max(LEAST));
            observed.network.unknowns[first + k] = Unknown { start: place.centre_mm[k], uncertainty };
        }
    }
    Ok(observed)
}

/// Standard errors expected of a probing, before anything is measured.
///
/// # Errors
/// Terms that the balls do not separate, by their names; a bound below the smallest change that the probe can resolve.
pub fn foreseen(task: &KeepTask, machine: &Machine, plan: &Plan) -> Result<Vec<f64>> {
    let positions = planned(&task.probing, plan);
    let first = foresee_observed(&task.probing, plan, network(task, machine, plan, &positions, None)?)?;
    let known = balls(task, &first);
    let later = foresee_observed(&task.probing, plan, network(task, machine, plan, &positions, Some(&known))?)?;
    let errors = later.solution.standard_errors[..task.terms.len()].to_vec();
    for (kept, error) in task.terms.iter().zip(&errors) {
        let least = kept.bounds.significance * error;
        if kept.bounds.update < least {
            let (unit, factor) = kept.term.unit();
            return Err(anyhow!(
                "{}:{}: key term: found a largest update of {} {unit} for {}, needed at least {:.2} {unit}, which the balls \
                 and this probe can resolve ({} standard errors), or fewer terms",
                task.probing.file.display(),
                kept.line,
                factor * kept.bounds.update,
                kept.name,
                factor * least,
                kept.bounds.significance
            ));
        }
    }
    Ok(errors)
}

/// Positions of the balls.
fn balls(task: &KeepTask, calibration: &Calibration) -> Vec<BallPlace> {
    let solution = &calibration.solution;
    let of = |(artefact, places): (usize, &Vec<usize>)| {
        let first = *places.first()?;
        Some(BallPlace {
            name: task.probing.artefacts.get(artefact)?.name.clone(),
            centre_mm: std::array::from_fn(|k| solution.values[first + k]),
            standard_error_um: std::array::from_fn(|k| 1e3 * solution.standard_errors[first + k]),
        })
    };
    calibration.observed.places.iter().enumerate().filter_map(of).collect()
}

/// Evaluates the first probing: the positions of the balls, and the terms that rotating them determines already. Changes
/// nothing.
///
/// # Errors
/// As [`crate::calibrate::calibrate`].
pub fn begin(task: &KeepTask, machine: &Machine, plan: &Plan, trips: &[Logged], file: &Path) -> Result<Reprobing> {
    let positions: Vec<[f64; AXES]> = trips.iter().map(|trip| trip.position).collect();
    let observed = network(task, machine, plan, &positions, None)?;
    let calibration = settle(&task.probing, plan, trips, file, observed)?;
    let observable = task.terms.iter().filter(|kept| is_observable_by_rotation(task, kept.term));
    let (values, errors) = (&calibration.solution.values, &calibration.solution.standard_errors);
    let verdicts = observable.zip(values).zip(errors).map(|((kept, value), error)| Verdict {
        name: kept.name.clone(),
        value: *value,
        standard_error: *error,
        total: 0.0,
        decision: Decision::Unchanged,
    });
    Ok(Reprobing { balls: balls(task, &calibration), verdicts: verdicts.collect(), calibration })
}

/// Baseline of a later probing.
#[derive(Clone, Copy, Debug)]
pub struct Before<'b> {
    /// Positions of the balls at the beginning.
    pub known: &'b [BallPlace],
    /// Sums of the updates since then, in the units of documents.
    pub totals: &'b BTreeMap<String, f64>,
    /// Names of terms that a person has allowed out of their bounds.
    pub accepted: &'b [String],
}

/// Evaluates a later probing.
///
/// # Errors
/// As [`crate::calibrate::calibrate`].
pub fn evaluate(
    task: &KeepTask,
    machine: &Machine,
    plan: &Plan,
    trips: &[Logged],
    file: &Path,
    before: &Before<'_>,
) -> Result<Reprobing> {
    let positions: Vec<[f64; AXES]> = trips.iter().map(|trip| trip.position).collect();
    let observed = network(task, machine, plan, &positions, Some(before.known))?;
    let calibration = settle(&task.probing, plan, trips, file, observed)?;
    let factors: Vec<f64> = task.terms.iter().map(|kept| kept.bounds.significance).collect();
    let selection = calibration.observed.network.moved(&factors);
    let selection = selection.map_err(|refused| anyhow!("{}: {refused}", file.display()))?;
    let verdicts = (0..task.terms.len()).map(|index| verdict(task, machine, &selection, index, before));
    Ok(Reprobing { balls: balls(task, &calibration), verdicts: verdicts.collect(), calibration })
}

fn verdict(task: &KeepTask, machine: &Machine, selection: &Selection, index: usize, before: &Before<'_>) -> Verdict {
    let kept = &task.terms[index];
    let (unit, factor) = kept.term.unit();
    let total = before.totals.get(&kept.name).copied().unwrap_or(0.0) / factor;
    let found = if selection.moved[index] { &selection.chosen } else { &selection.all };
    let (mut value, standard_error) = (found.values[index], found.standard_errors[index]);
    if let Term::Backlash(axis) = kept.term {
        // Lost motion is never negative.
        let own = machine.settings.axis(axis).map_or(0.0, |own| own.backlash);
        value = if selection.moved[index] { value.max(-own) } else { value };
    }
    let shown = |value: f64| trueaxis_report::number::significant(factor * value, 3);
    let decision = if !selection.moved[index] || value == 0.0 {
        Decision::Unchanged
    } else if before.accepted.contains(&kept.name) {
        Decision::Update
    } else if value.abs() > kept.bounds.update {
        let (moved, most) = (shown(value), shown(kept.bounds.update));
        Decision::Refused(format!("moved by {moved} {unit}, at most {most} {unit} is applied at once"))
    } else if (total + value).abs() > kept.bounds.total {
        let (sum, most) = (shown(total + value), shown(kept.bounds.total));
        Decision::Refused(format!("would be {sum} {unit} since the beginning, at most {most} {unit} is applied in all"))
    } else {
        Decision::Update
    };
    Verdict { name: kept.name.clone(), value, standard_error, total, decision }
}

impl Reprobing {
    /// Terms that are out of their bounds.
    pub fn refused(&self) -> impl Iterator<Item = (&str, &str)> {
        self.verdicts.iter().filter_map(|verdict| match &verdict.decision {
            Decision::Refused(reason) => Some((verdict.name.as_str(), reason.as_str())),
            _ => None,
        })
    }

    /// Amounts added to the files of a home: one per term of the network, 0 for unchanged terms.
    pub fn updates(&self, task: &KeepTask, home: Home) -> Vec<f64> {
        let own =
            |(kept, verdict): (&super::KeptTerm, &Verdict)| if kept.home == home { verdict.update() } else { 0.0 };
        task.terms.iter().zip(&self.verdicts).map(own).collect()
    }
}
