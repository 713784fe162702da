//! Where the drives bring the axes at the points of a part's features: the simulator's step and plant run the program.
//!
//! ```text
//! q(t)  = q_c(t) + e(t)            e: reading − command of a run, in which the correction and the error of the servo are
//! e(z)  ≈ e + Σ_k z_k e_k          e_k: what one standard uncertainty of a figure of the drives changes of it, a run each
//! ```
//!
//! The drives are those of the machine.toml, rigid, with encoders that are free of errors; friction that is not stated is
//! zero. A figure with a standard uncertainty differs in the plant alone: the controller keeps the stated one. A point gets the
//! positions of the moment at which it is commanded: the lag along the path moves it along the feature, and what is left across
//! the path is in the feature.
//!
//! Some plants with all figures drawn at once are run beside them, to compare with the sum of the single effects.

mod caught;
mod departure;
mod figures;
mod parts;
mod runs;
mod shortened;

use super::cut::{Cut, Followed};
use super::fixture::Moves;
use crate::uncertainty::terms::{Effect, Term};
use anyhow::{Result, bail};
use caught::Stopped;
use figures::{Plant, Uncertain, drives, uncertain};
use runs::Driven;
use serde::Serialize;
use std::sync::Arc;
use trueaxis::machine::AXES;
use trueaxis_sim::run::Kind;
use trueaxis_tables::Machine;
use trueaxis_tables::uncertainty::Uncertainties;

pub(super) use departure::{departure, notes};
pub(super) use parts::{Alone, alone};
pub(super) use runs::Ran;

/// Plants with all figures drawn at once.
const DRAWN: u64 = 8;
/// Their stream is apart from those of the machines.
const STREAM: u64 = 0xd21e;

/// How the servo was simulated.
#[derive(Clone, Debug, Serialize)]
pub struct ServoDocument {
    /// Servo rate.
    pub rate_hz: f64,
    /// Simulated machines, by how they are driven.
    pub machines: Vec<&'static str>,
    /// Simulated time of each machine.
    pub simulated_s: f64,
    /// Moves simulated, and moves of the programs.
    pub moves: [usize; 2],
    /// Further machines with everything on, whose drives differ from the stated figures.
    pub plants: usize,
    /// Uncertain figures of the drives.
    pub figures: Vec<String>,
    /// How far parts cut with all figures drawn at once are from the sum of their single effects: root mean square as a share
    /// of the scatter, the largest of all characteristics; absent without uncertain figures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub departure: Option<f64>,
    /// What the advice needs of the runs.
    #[serde(skip)]
    pub(super) kept: Kept,
}

/// The features where the drives bring the axes, and what is not known of the drives.
#[derive(Clone, Default)]
pub(super) struct Kept {
    pub(super) cuts: Arc<Vec<Cut>>,
    pub(super) terms: Arc<Vec<Term>>,
}

impl std::fmt::Debug for Kept {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Kept").field("cuts", &self.cuts.len()).field("terms", &self.terms.len()).finish()
    }
}

impl Kept {
    /// What the terms move: each a figure, in their order.
    pub(super) fn moves(&self) -> impl Iterator<Item = Moves> + '_ {
        self.terms.iter().map(|_| Moves::Drive)
    }
}

impl ServoDocument {
    /// What a reader has to know of the runs.
    pub(super) fn summary(&self) -> String {
        let [simulated, all] = self.moves;
        let plants = match self.plants {
            0 => String::new(),
            count => format!(", and {count} machines with other figures of their drives"),
        };
        format!(
            "with the servo: {simulated} of {all} moves, {:.1} s at {} Hz, {}{plants}",
            self.simulated_s,
            self.rate_hz,
            self.machines.join(", ")
        )
    }
}

/// A plant with all figures drawn at once.
pub(super) struct Drawn {
    /// How far every figure is off, in standard uncertainties.
    pub(super) z: Vec<f64>,
    /// By point of the features; nothing if the step stopped the machine.
    pub(super) errors: Option<Vec<Option<Followed>>>,
}

/// What the runs gave beside the positions of the axes.
pub(super) struct Run {
    pub(super) document: ServoDocument,
    pub(super) drawn: Vec<Drawn>,
    pub(super) not_stated: Vec<String>,
}

/// Runs the program on the machine and moves the points of the features to where the drives bring them: uncorrected, with the
/// geometric correction, and with everything that the machine configures; of the last also what each uncertain figure of the
/// drives changes, if there is anything to compare with (`known`). `on_progress` gets the cycles done and all cycles.
///
/// # Errors
/// A moving axis without figures of its drive; a machine or program that the simulator refuses; a run that the step stops.
pub(super) fn follow(
    machine: &Machine,
    known: Option<&Uncertainties>,
    ran: &Ran<'_>,
    seed: u64,
    on_progress: &mut dyn FnMut(u64, u64),
) -> Result<(Run, Vec<Cut>)> {
    let has_dynamics = Kind::of(&machine.settings).len() > Kind::BASIC.len();
    let mut kinds = vec![Kind::Uncompensated, Kind::Compensated];
    kinds.extend(has_dynamics.then_some(Kind::Configured));
    let stated = drives(&machine.settings, ran.program.is_five_axis())?;
    let (figures, not_stated) = match known {
        Some(known) => uncertain(&machine.settings, known, ran.cuts)?,
        None => Default::default(),
    };
    let plants = plants(machine, &figures, seed);
    let mut driven: Vec<Driven<'_>> =
        kinds.iter().map(|kind| Driven { machine, kind: *kind, drives: vec![stated] }).collect();
    let of_plants = plants.iter().map(|plant| plant.drives).collect();
    driven.extend(kinds.last().map(|kind| Driven { machine, kind: *kind, drives: of_plants }));
    let outcome = ran.run(&driven, on_progress)?;
    let names = (0..kinds.len()).map(|_| String::new());
    let names = names.chain(figures.iter().map(|of| format!(", with the {} one standard uncertainty off", of.name())));
    for (name, stopped) in names.zip(&outcome.stopped) {
        refuse(&name, stopped.as_ref())?;
    }
    let (of_kinds, of_plants) = outcome.errors.split_at(kinds.len());
    let last = kinds.len() - 1;
    let mut cuts = ran.cuts.to_vec();
    for (index, point) in cuts.iter_mut().flat_map(|cut| &mut cut.points).enumerate() {
        let [Some(uncorrected), Some(corrected), Some(everything)] = [0, 1, last].map(|kind| of_kinds[kind][index])
        else {
            continue;
        };
        point.follow([uncorrected, corrected, everything]);
        let effects = of_plants.iter().zip(&plants).take(figures.len()).enumerate();
        let effect = |(k, (errors, plant)): (usize, (&Vec<Option<Followed>>, &Plant))| {
            unit(everything, errors[index].unwrap_or(everything), plant.off[k])
        };
        point.drives = effects.map(effect).collect();
    }
    let stopped = outcome.stopped.iter().skip(kinds.len() + figures.len());
    let drawn = of_plants.iter().zip(&plants).skip(figures.len()).zip(stopped);
    let drawn = drawn.map(|((errors, plant), stopped)| Drawn {
        z: plant.off.clone(),
        errors: stopped.is_none().then(|| errors.clone()),
    });
    let drawn = drawn.collect();
    let document = ServoDocument {
        rate_hz: ran.rate_hz,
        machines: kinds.iter().map(|kind| kind.words()).collect(),
        simulated_s: outcome.simulated_s,
        moves: outcome.moves,
        plants: plants.len(),
        figures: figures.iter().map(Uncertain::name).collect(),
        departure: None,
        kept: Kept { cuts: Arc::new(cuts.clone()), terms: Arc::new(figures.iter().map(term).collect()) },
    };
    Ok((Run { document, drawn, not_stated }, cuts))
}

/// Plants with one figure off each, then those with all figures drawn.
fn plants(machine: &Machine, figures: &[Uncertain], seed: u64) -> Vec<Plant> {
    let settings = &machine.settings;
    let alone = (0..figures.len()).map(|index| Plant::alone(settings, figures, index, 1.0));
    let drawn = (0..DRAWN).map(|number| Plant::drawn(settings, figures, seed ^ STREAM, number));
    alone.chain(drawn.filter(|_| !figures.is_empty())).collect()
}

fn term(of: &Uncertain) -> Term {
    Term { name: of.name(), effect: Effect::Part, degrees_of_freedom: of.degrees_of_freedom }
}

/// What a plant changes, per unit of what its figure is off.
fn unit(stated: Followed, found: Followed, off: f64) -> Followed {
    let by = |of: usize, axis: usize| if off == 0.0 { 0.0 } else { (found[of][axis] - stated[of][axis]) / off };
    std::array::from_fn(|of| -> [f64; AXES] { std::array::from_fn(|axis| by(of, axis)) })
}

fn refuse(how: &str, stopped: Option<&(String, Stopped)>) -> Result<()> {
    let Some((file, (line, fault))) = stopped else { return Ok(()) };
    bail!(
        "{file}:{line}: found fault {fault}, at which the simulated controller stops{how}; needed a program that it cuts: \
         trueaxis explain fault {fault}"
    );
}
