//! Chooses the placements of a task's artefacts for a given time: those that reduce the error of the tip over the volume most.
//!
//! ```text
//! artefacts without places × directions × positions × styli ─► information about the machine's terms, minutes
//! trace of the tip's covariance over the volume ─► greedily per minute, then exchanges ─► task, program, what stays unseen
//! ```
//!
//! The information of a placement is that of its touches with the machine's terms, the tip's radius and the sizes of the
//! artefact kept; its position, and the deviations of its balls or faces from the certificate, are eliminated. The touches are
//! linearised where they are planned. Errors of the workpiece's position and orientation do not count: a rigid motion is how
//! the workpiece is set up. Drift enters the result, not the choice.

mod candidate;
mod lines;
mod placed;
mod room;
mod search;
mod turns;
mod volume;

use super::foreseen::{Planning, foresee};
use super::plan::Plan;
use super::task::Task;
use super::terms::{Term, Terms};
use crate::shown::{Cell, Table};
use anyhow::Result;
use candidate::{Candidate, Known, candidates};
pub use lines::CentreLine;
use lines::centre_lines;
use search::{Asked, choose};
use serde::Serialize;
use std::path::Path;
use trueaxis_tables::Machine;
use trueaxis_tables::error::FileError;
use volume::Volume;

/// A term of which less than this share of the variance is removed stays unseen.
const UNSEEN: f64 = 0.1;

/// A placement that was chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// Name of the artefact.
    pub artefact: String,
    /// Number of its place, from 1.
    pub place: usize,
    /// Direction that it faces; of a gauge or square also that of its row or first arm.
    pub facing: String,
    /// X, Y, Z of the machine.
    pub at_mm: [f64; 3],
    /// Length of the stylus; `None`: the machine's tool.
    pub stylus_mm: Option<f64>,
    /// Minutes with setting up and the reference.
    pub minutes: f64,
}

/// The document that `trueaxis calibrate plan --minutes --json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChosenDocument {
    /// The placements.
    pub choices: Vec<Choice>,
    /// Placements that were compared.
    pub compared: usize,
    /// Minutes with setting up.
    pub minutes: f64,
    /// Minutes that were allowed.
    pub allowed_minutes: f64,
    /// Standard uncertainty of the tip, root mean square over the volume, without a rigid motion: before, µm.
    pub before_um: f64,
    /// The same after the task.
    pub after_um: f64,
    /// Centre lines of the rotary axes of the table after the task.
    pub centre_lines: Vec<CentreLine>,
    /// Terms that stay as they were assumed.
    pub unseen: Vec<String>,
    /// What else to know.
    pub notes: Vec<String>,
}

impl ChosenDocument {
    /// The choice for people, line by line.
    pub fn shown(&self) -> Vec<String> {
        let row = |of: &Choice| {
            let [x, y, z] = of.at_mm;
            let stylus = of.stylus_mm.map_or_else(|| Cell::from("-"), Cell::shortest);
            let (at, minutes) = (format!("X{x} Y{y} Z{z}"), Cell::fixed(of.minutes, 1));
            vec![format!("{} {}", of.artefact, of.place).into(), of.facing.as_str().into(), at.into(), stylus, minutes]
        };
        let head = ["place", "facing", "at, mm", "stylus, mm", "minutes"];
        let table = Table::new("Chosen places", head, self.choices.iter().map(row));
        let mut lines: Vec<String> = table.to_string().lines().map(str::to_owned).collect();
        lines.push(format!(
            "error of the tip expected over the volume, RMS: {:.1} µm before, {:.1} µm after",
            self.before_um, self.after_um
        ));
        for line in &self.centre_lines {
            lines.push(format!(
                "centre line of {}: standard error of its place {:.1} µm, of its tilt {:.1} µrad",
                line.axis, line.place_um, line.tilt_urad
            ));
        }
        if !self.unseen.is_empty() {
            lines.push(format!("note: these stay as they were assumed: {}", self.unseen.join(", ")));
        }
        lines.extend(self.notes.iter().map(|note| format!("note: {note}")));
        lines
    }
}

/// Placements chosen for a task.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// What was chosen, and what it gives.
    pub document: ChosenDocument,
    /// The task's text with the places.
    pub task: String,
    /// The whole plan.
    pub planning: Planning,
}

/// Chooses places for the artefacts without any; `text`: the task's. `minutes`: for the whole program with setting up.
/// `progress` gets the share that is done.
///
/// # Errors
/// With the line of the task: no artefact without places, an artefact that fits nowhere, too few minutes for any placement;
/// as [`Planning::new`].
pub fn chosen(
    text: &str,
    file: &Path,
    machine: &Machine,
    minutes: f64,
    progress: &mut dyn FnMut(f64),
) -> Result<Chosen> {
    let task = Task::read_open(text, file)?;
    check(&task, machine)?;
    let known = Known::new(&task, machine)?;
    let volume = Volume::new(&task, machine, &known.terms)?;
    let all = candidates(&task, machine, &known, &mut |share| progress(0.8 * share))?;
    let ranges: Vec<f64> = known.terms.terms.iter().map(|term| known.range(&task, *term)).collect();
    let asked = Asked {
        fixed: &all.fixed,
        candidates: &all.open,
        prior: &all.prior,
        volume: &volume,
        ranges: &ranges,
        minutes,
    };
    let shortest = all.open.iter().map(|one| one.minutes).fold(f64::INFINITY, f64::min);
    if all.fixed_minutes + shortest > minutes {
        let least = (all.fixed_minutes + shortest).ceil();
        let found = format!("{minutes} minutes");
        let needed =
            format!("at least {least}: the shortest placement with its set-up, and those that the task states");
        return Err(error(&task, task.wishes.line, "--minutes", found, needed));
    }
    let mut picked = choose(&asked, all.fixed_minutes, &mut |share| progress(0.8 + 0.2 * share));
    // The whole plan is exact about the time: a placement less, as long as it takes too long.
    loop {
        let done = placed::placed(text, &task, &picked.iter().map(|k| &all.open[*k]).collect::<Vec<_>>())?;
        let whole = Task::read(&done, file)?;
        let plan = Plan::new(&whole, machine)?;
        let set_ups: usize = whole.artefacts.iter().map(|artefact| artefact.places.len()).sum();
        let total = plan.minutes() + set_ups as f64 * task.wishes.set_up_minutes;
        if total > minutes && picked.len() > 1 {
            let least = asked.least_useful(&picked);
            picked.remove(least);
            continue;
        }
        if total > minutes || picked.is_empty() {
            let found = format!("{minutes} minutes");
            let needed = format!("at least {:.0}, with one place", total.max(all.fixed_minutes + shortest).ceil());
            return Err(error(&task, task.wishes.line, "--minutes", found, needed));
        }
        let planning = Planning::new(&whole, machine)?;
        let document = document(&asked, &known, [&task, &whole], &planning, machine, &picked, total)?;
        return Ok(Chosen { document, task: done, planning });
    }
}

fn error(task: &Task, line: u32, key: &str, found: String, needed: String) -> anyhow::Error {
    let line = Some(line).filter(|line| *line > 0);
    FileError { file: task.file.clone(), line, column: Some(key.to_owned()), found, needed }.into()
}

fn check(task: &Task, machine: &Machine) -> Result<()> {
    if task.is_read() || task.plate().is_some() {
        let needed = "certified artefacts: dials and plates of unknown places state their placements";
        return Err(error(
            task,
            task.artefacts.first().map_or(0, |of| of.line),
            "--minutes",
            "such a task".into(),
            needed.into(),
        ));
    }
    let Some(last) = task.artefacts.last().filter(|_| task.artefacts.iter().all(|of| !of.places.is_empty())) else {
        let needs = [trueaxis::machine::Axis::X, trueaxis::machine::Axis::Y, trueaxis::machine::Axis::Z];
        for axis in needs {
            let travel = machine.settings.axis(axis).map(|own| own.travel);
            if travel.is_none_or(|[low, high]| !(low.is_finite() && high.is_finite()) || high - low <= 0.0) {
                let found = format!("a machine without a travel of {}", axis.letter());
                return Err(error(task, 0, "machine", found, "travel_mm of X, Y and Z: the volume to be known".into()));
            }
        }
        return Ok(());
    };
    let found = "every artefact with its places".to_owned();
    let needed = "an artefact without [[artefact.place]], whose places are chosen; stated places are kept".to_owned();
    Err(error(task, last.line, "--minutes", found, needed))
}

/// Names of the terms that stay unseen; a curve once if all of its degrees do.
fn unseen(terms: &[Term], is_unseen: impl Fn(usize) -> bool) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (k, term) in terms.iter().enumerate().filter(|(k, _)| is_unseen(*k)) {
        let mut own = (0..terms.len()).filter(|other| terms[*other].curve_of() == term.curve_of());
        let name = match term.curve_name() {
            Some(curve) if own.all(&is_unseen) => curve,
            _ => terms[k].name(),
        };
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// What the placements give, by the covariance of the whole network.
fn document(
    asked: &Asked<'_>,
    known: &Known,
    [open, task]: [&Task; 2],
    planning: &Planning,
    machine: &Machine,
    picked: &[usize],
    minutes: f64,
) -> Result<ChosenDocument> {
    let found = foresee(task, machine, &planning.plan)?;
    let terms: &Terms = &found.observed.terms;
    let place = |term: &Term| known.terms.terms.iter().position(|own| own == term);
    // Terms that the placements do not span stay as assumed.
    // The curves of the solution are those over the touched range.
    let touched = Terms { reach_mm: terms.reach_mm, ..known.terms.clone() };
    let after = Volume::new(open, machine, &touched)?;
    let ranges = asked.ranges;
    let mut covariance: Vec<Vec<f64>> = (0..ranges.len())
        .map(|i| (0..ranges.len()).map(|j| if i == j { ranges[i] * ranges[i] } else { 0.0 }).collect())
        .collect();
    let of_found: Vec<Option<usize>> = terms.terms.iter().map(place).collect();
    for (i, to) in of_found.iter().enumerate() {
        for (j, other) in of_found.iter().enumerate() {
            if let (Some(to), Some(other)) = (to, other) {
                covariance[*to][*other] = found.solution.covariance[i][j];
            }
        }
    }
    let left = |k: usize| covariance[k][k] / (ranges[k] * ranges[k]);
    let unseen = unseen(&known.terms.terms, |k| left(k) > 1.0 - UNSEEN);
    let centre_lines = centre_lines(open, machine, known.shortest(&machine.settings), &touched, &covariance)?;
    let mut notes = Vec::new();
    if task.wanted.angle == 0 {
        notes.push("roll, pitch and yaw are not among the terms: angular_degree in [solve]".to_owned());
    } else if known.styli.len() < 2 {
        notes.push(
            "with one length of the stylus turns of Z about X and Y are not told from its straightness: a second length in \
             plan.styli_mm"
                .to_owned(),
        );
    }
    let is_left_out = |k: &usize| {
        open.artefacts[*k].places.is_empty() && !picked.iter().any(|of| asked.candidates[*of].artefact == *k)
    };
    let left_out: Vec<&str> =
        (0..open.artefacts.len()).filter(is_left_out).map(|k| open.artefacts[k].name.as_str()).collect();
    if !left_out.is_empty() {
        notes.push(format!("left out of the task, since others gain more in the time: {}", left_out.join(", ")));
    }
    if asked.candidates.len() == picked.len() {
        notes.push("every placement that fits was chosen".to_owned());
    }
    let mut numbers: Vec<usize> = Vec::new();
    let choices = picked.iter().map(|k| {
        let one: &Candidate = &asked.candidates[*k];
        numbers.push(one.artefact);
        let place = numbers.iter().filter(|of| **of == one.artefact).count();
        let stylus_mm = one.place.stylus_mm;
        let artefact = open.artefacts[one.artefact].name.clone();
        let (facing, at_mm) = (one.facing(open), one.place.at_mm);
        Choice { artefact, place, facing, at_mm, stylus_mm, minutes: one.minutes }
    });
    Ok(ChosenDocument {
        choices: choices.collect(),
        compared: asked.candidates.len(),
        minutes,
        allowed_minutes: asked.minutes,
        before_um: 1e3 * asked.volume.of_ranges(ranges).sqrt(),
        after_um: 1e3 * after.of(&covariance).sqrt(),
        centre_lines,
        unseen,
        notes,
    })
}
