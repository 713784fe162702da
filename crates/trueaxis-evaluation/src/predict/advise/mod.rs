//! What to do about a predicted part: which measurements bring it to a verdict, where to put it, in which direction to cut.
//!
//! ```text
//! y = D z + ε                        readings of a measurement; z: the uncertain quantities of the machine, of unit variance
//! P = (C⁻¹ + Dᵀ R⁻¹ D)⁻¹            what it leaves of their correlation C; R: the covariance of ε
//! u(f)² = d P dᵀ                     d: derivatives of a feature
//! ```
//!
//! The readings of a laser are those of each position, with zero and length as further noise. Those of a ballbar are squareness,
//! difference of the scales and lost motion by least squares, those of a probe the terms that `calibrate` finds in one task of
//! all artefacts: D is what each term shows of a quantity by least squares, R the covariance that the fit foresees. Quantities
//! that differ from approach to approach, and those that act by their squares, are not measured.
//!
//! The set has most verdicts in a short time; the expected verdict is that at the predicted value. Up to 12 measurements
//! every set is compared, and the shortest found; beyond that measurements are added by gain per minute. The chosen set is
//! drawn: each machine is measured, and its part cut with what the readings do not explain.

mod candidate;
mod design;
pub(super) mod document;
mod elsewhere;
pub(super) mod instrument;
mod prior;
mod search;
mod shown;
mod sights;
mod switched;
mod text;

pub use document::{Advice, Advised, AdvisedTask, Directed, Elsewhere, Left, Measurement, Placed};
pub use instrument::{Instrument, InstrumentKind, Touching};

use super::verdict::verdict_of;
use super::{Part, PredictDocument, Prepared, State, correlations, responses};
use crate::calibrate::Task;
use crate::predict::cut::Cut;
use crate::predict::room::room;
use crate::predict::unknowns::{Model, Unknown};
use crate::uncertainty::terms::{Along, Counts, Effect, Terms};
use anyhow::{Result, bail};
use candidate::{Candidate, Shop, Way, grouped};
use elsewhere::Asked;
use prior::Prior;
use search::{Choice, Search};
use trueaxis_metrology::uncertainty::Interval;
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::uncertainty::Uncertainties;

/// Most measurements.
const MOST: usize = 60;
/// Terms named that keep a feature uncertain.
const LARGEST: usize = 3;
/// Keys named where no uncertainty is stated.
const KEYS: usize = 4;

/// Advice on a part that was predicted; `read` gives the task of a file named by an instrument.
///
/// # Errors
/// As [`predict`](super::predict); a machine without uncertainties; a part without instruments; a task that cannot be read.
pub fn advise(
    machine: &Machine,
    stated: &Uncertainties,
    program: &Program,
    part: &Part,
    predicted: &PredictDocument,
    read: &dyn Fn(&str) -> Result<Task>,
) -> Result<Advice> {
    if predicted.features.iter().any(|of| of.known.is_none()) {
        let keys: Vec<&str> = predicted.not_stated.iter().map(String::as_str).take(KEYS).collect();
        let more = predicted.not_stated.len().saturating_sub(KEYS);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let name = &predicted.machine;
        bail!(
            "{name}: no advice: found no standard uncertainty above zero, needed at least one of {}{more} in machine.toml",
            keys.join(", ")
        );
    }
    part.require_instruments()?;
    let mut prepared = Prepared::new(machine, stated, program, part)?;
    if let Some(servo) = &predicted.servo {
        prepared = prepared.with_servo(servo);
    }
    let model = prepared.model(machine, part);
    let prior = prior_of(&model, predicted)?;
    let [low, high] = extent(model.cuts);
    let shop = Shop {
        machine,
        middle_mm: std::array::from_fn(|k| 0.5 * (low[k] + high[k])),
        probe: &part.probe,
        scatter_mm: scatter(model.terms),
    };
    let candidates = candidates(&shop, part, read)?;
    let (choice, refused) = Search::new(&prior, &shop, &candidates).choose()?;
    let mut advice = advice_of(&prior, predicted, &candidates, &choice, &shop);
    advice.corrected = switched::corrected(predicted, &prior, program)?;
    for (of, why) in candidates.iter().zip(refused) {
        match why {
            Some(why) => advice.left_out.push(format!("{}: {why}", of.name)),
            None => advice.compared.push(of.name.clone()),
        }
    }
    Ok(advice)
}

/// The part at other places in X and Y, and the features that lost motion decides cut in the other direction, all without the
/// servo: what it leaves depends on the path, hardly on the place.
///
/// # Errors
/// As [`predict`](super::predict).
pub fn elsewhere(
    machine: &Machine,
    stated: &Uncertainties,
    program: &Program,
    part: &Part,
    predicted: &PredictDocument,
) -> Result<Elsewhere> {
    let asked = Asked { machine, stated, program, part, seed: predicted.seed };
    let [x, y, _] = room(machine, program, part)?;
    let without_servo = predicted.servo.is_some();
    Ok(Elsewhere { directions: asked.directions(predicted)?, without_servo, ..asked.place([x, y])? })
}

fn prior_of<'m>(model: &'m Model<'m>, predicted: &PredictDocument) -> Result<Prior<'m>> {
    let unknowns: Vec<Unknown> = model.all_unknowns();
    let at_zero = model.cut(&model.nothing(), State::Everything)?;
    let responses = responses(model, &unknowns, &at_zero)?;
    let limits: Vec<[f64; 2]> = model.part.tolerances.iter().map(|of| of.limits).collect();
    let features = prior::features(&predicted.features, &limits, |index| {
        let derivatives = responses.iter().map(|of| of.derivatives[index]).collect();
        [derivatives, responses.iter().map(|of| of.contributions[index]).collect()]
    })?;
    let correlations = correlations(model, &unknowns);
    Ok(Prior { model, unknowns, correlations, features, trials: predicted.trials, seed: predicted.seed })
}

/// Lowest and highest positions of X, Y, Z on the part's features.
fn extent(cuts: &[Cut]) -> [[f64; 3]; 2] {
    let points = || cuts.iter().flat_map(|cut| &cut.points).map(|point| point.uncorrected.sent);
    let end = |pick: fn(f64, f64) -> f64| std::array::from_fn(|k| points().map(|at| at[k]).reduce(pick).unwrap_or(0.0));
    [end(f64::min), end(f64::max)]
}

/// Largest standard deviation of an axis' approach, mm.
fn scatter(terms: &Terms) -> f64 {
    let approach = |one: &Along| if one.counts == Counts::Approach { one.constant } else { 0.0 };
    let of = |effect: &Effect| match effect {
        Effect::Along(axes) => axes.iter().filter(|one| !one.axis.is_rotary()).map(approach).fold(0.0, f64::max),
        _ => 0.0,
    };
    terms.all.iter().map(|term| of(&term.effect)).fold(0.0, f64::max)
}

fn candidates(shop: &Shop<'_>, part: &Part, read: &dyn Fn(&str) -> Result<Task>) -> Result<Vec<Candidate>> {
    let mut all: Vec<Candidate> = Vec::new();
    for of in &part.instruments {
        all.extend(shop.candidates(of));
        if let Some(file) = &of.file {
            let task = read(file)?;
            let set_ups: usize = task.artefacts.iter().map(|artefact| artefact.places.len().max(1)).sum();
            let minutes = of.minutes * set_ups as f64;
            all.push(Candidate { name: of.name.clone(), minutes, way: Way::Task(Box::new(task)) });
        }
        let twice = (1..all.len()).find(|k| all[..*k].iter().any(|other| other.name == all[*k].name));
        if let Some(twice) = twice {
            let found = format!("a second {}", all[twice].name);
            return Err(part.wrong(of.line, found, "another name = \"…\" for each instrument of a kind").into());
        }
    }
    if all.len() > MOST {
        let line = part.instruments.last().map_or(0, |of| of.line);
        let needed = format!("at most {MOST}");
        return Err(part.wrong(line, format!("{} measurements by all instruments", all.len()), needed).into());
    }
    Ok(all)
}

fn advice_of(
    prior: &Prior<'_>,
    predicted: &PredictDocument,
    candidates: &[Candidate],
    choice: &Choice,
    shop: &Shop<'_>,
) -> Advice {
    let half = |interval: Interval| 1e3 * 0.5 * (interval.high - interval.low);
    let features = predicted.features.iter().zip(&prior.features).enumerate().map(|(index, (of, own))| {
        let after = choice.intervals[index];
        let verdict_after = verdict_of(after, own.limits);
        let mut left = Vec::new();
        if verdict_after == "undecided" {
            let terms = prior.left(&choice.readings, own).into_iter().take(LARGEST);
            left = terms.map(|(term, share, is_measured)| Left { term, share, is_measured }).collect();
        }
        Advised {
            feature: of.feature.clone(),
            kind: of.kind,
            before_um: half(own.interval),
            after_um: half(after),
            least_um: half(choice.with_all.get(index).copied().unwrap_or(own.interval)).min(half(after)),
            interval_um: Interval { low: 1e3 * after.low, high: 1e3 * after.high },
            verdict_before: verdict_of(own.interval, own.limits),
            verdict_after,
            left,
            title: of.title(),
        }
    });
    let chosen = choice.chosen.iter().map(|k| &candidates[*k]);
    let is_artefact = |of: &&Candidate| matches!(of.way, Way::Artefact(_));
    let artefacts = grouped(chosen.clone());
    // The probing program is that of all artefacts together.
    let probing = choice.probing_minutes / chosen.clone().filter(is_artefact).count().max(1) as f64;
    let measurements = chosen.map(|of| {
        let in_task = is_artefact(&of);
        let minutes = of.minutes + if in_task { probing } else { 0.0 };
        let file = if let Way::Task(task) = &of.way { Some(task.file.display().to_string()) } else { None };
        Measurement { name: of.name.clone(), minutes, in_task, file }
    });
    let (probe, scatter_mm) = (shop.probe.clone(), shop.scatter_mm);
    Advice {
        measurements: measurements.collect(),
        exact: choice.exact,
        minutes: choice.minutes,
        features: features.collect(),
        compared: Vec::new(),
        left_out: Vec::new(),
        independent: independent(choice.chosen.iter().map(|k| &candidates[*k])),
        elsewhere: None,
        corrected: Vec::new(),
        task: (!artefacts.is_empty()).then_some(AdvisedTask { probe, scatter_mm, artefacts }),
    }
}

/// Lasers that are used more than once.
fn independent<'a>(chosen: impl Iterator<Item = &'a Candidate>) -> Vec<String> {
    let is_laser = |of: &&Candidate| matches!(&of.way, Way::Read(sights) if sights.found.is_empty());
    let mut names: Vec<&str> = Vec::new();
    let mut twice: Vec<String> = Vec::new();
    for (name, _) in chosen.filter(is_laser).filter_map(|of| of.name.rsplit_once(" along ")) {
        if names.contains(&name) && !twice.iter().any(|own| own == name) {
            twice.push(name.to_owned());
        }
        names.push(name);
    }
    twice
}
