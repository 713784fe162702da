//! Simulates a shift of a machine that re-probes balls: parts, re-probings between them, updates, exchanges of tables in
//! motion.
//!
//! ```text
//! bodies that warm, location errors that wander ─► true machine ─► probing, corrected by the tables ─► log ─► evaluate
//!                                                       │                       ▲                             │
//!                                                       ▼                       └── machine files, history ◄──┘
//!                                         error over the volume, exact           exchanged in motion, by the step
//! ```
//!
//! The tables are exact at the start of the shift. The logs are the loop's only information about the true machine.

mod drifting;

use super::artefacts::{SetUp, placed};
use crate::calibrate::{Plan, perfect, program, read_log, trips};
use crate::keep::{BallPlace, Before, KeepTask, Reprobing, begin, changes, evaluate, plan};
use anyhow::{Result, anyhow};
use drifting::Drifting;
use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trueaxis::machine::{AXES, Axis};
use trueaxis_sim::calibration::{Artefact, Class, Host, Probing, execute, random_five_axis, random_machine, remaining};
use trueaxis_sim::exchange::{Exchanged, in_motion};
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::machine_files;

/// The mill with three balls.
pub const MILL: &str = include_str!("../keep-mill.toml");
/// The trunnion machine with one ball.
pub const FIVE_AXES: &str = include_str!("../keep-five-axes.toml");

/// Displacement of a ball that was hit, mm.
const HIT_MM: f64 = 0.08;

/// Settings of a shift.
#[derive(Clone, Debug)]
pub struct Shift {
    /// Seed of machine, drift and noise.
    pub seed: u64,
    /// Whether the machine has five axes.
    pub five_axes: bool,
    /// The machine's task, such as [`MILL`] or [`FIVE_AXES`].
    pub task: String,
    /// The task's file name for error messages.
    pub task_file: PathBuf,
    /// Number of parts.
    pub parts: u32,
    /// Time per part, s, an even number.
    pub part_s: u32,
    /// Standard deviation of a touch, µm.
    pub noise_um: f64,
    /// Part at which the first ball is hit.
    pub hit: Option<u32>,
}

/// Tip error over the volume after a part, µm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Part {
    /// Number of parts made.
    pub parts: u32,
    /// Without the loop: root mean square and maximum.
    pub without_um: [f64; 2],
    /// With the loop: root mean square and maximum.
    pub with_um: [f64; 2],
}

/// A re-probing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluated {
    /// Number of parts made.
    pub parts: u32,
    /// Number of updated terms.
    pub updates: usize,
    /// Terms outside their bounds.
    pub refused: Vec<String>,
    /// Reason for refusing the log, if it was refused.
    pub log_refused: Option<String>,
    /// The exchange of tables, if any.
    pub exchanged: Option<Exchanged>,
}

/// Result of the shift.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// The machine's name.
    pub machine: String,
    /// Errors after every part.
    pub parts: Vec<Part>,
    /// Every re-probing.
    #[serde(rename = "looks")]
    pub reprobings: Vec<Evaluated>,
    /// Root mean square over the volume and the shift, µm, without and with the loop.
    pub rms_um: [f64; 2],
    /// Maximum over the volume and the shift, µm, without and with the loop.
    pub largest_um: [f64; 2],
    /// Number of re-probings that led to an update.
    pub updates: usize,
    /// Number of re-probings that needed an operator.
    pub refusals: usize,
    /// Largest jump that an exchange would have caused without the limiter, µm.
    pub largest_difference_um: f64,
    /// Largest change of the correction in one cycle after an exchange, µm.
    pub largest_step_um: f64,
    /// Largest velocity or acceleration of the correction after an exchange, as a share of its limit.
    pub of_limits: f64,
    /// Longest time until new tables were followed, s; `None` if those of any exchange never were.
    #[serde(rename = "longest_led_in_s")]
    pub longest_ramp_in_s: Option<f64>,
}

/// The machine as the loop knows it.
struct Known {
    /// The machine with its present tables.
    machine: Machine,
    /// Sums of all updates so far.
    totals: BTreeMap<String, f64>,
}

/// Machine, program and artefacts.
struct Bench<'s> {
    shift: &'s Shift,
    task: KeepTask,
    nominal: Machine,
    plan: Plan,
    program: String,
    artefacts: Vec<Artefact>,
}

impl Bench<'_> {
    /// Probes the true machine while the known tables correct it.
    fn log(&self, truth: &Machine, known: &Machine, parts: u32) -> Result<String> {
        let mut artefacts = self.artefacts.clone();
        if let (Some(Artefact::Ball { centre, .. }), true) =
            (artefacts.first_mut(), self.shift.hit.is_some_and(|hit| parts >= hit))
        {
            centre.y += HIT_MM;
        }
        let probing = Probing {
            machine: truth.clone(),
            known: Some(known.clone()),
            set_ups: vec![artefacts],
            tools_mm: Vec::new(),
            tip_radius_mm: self.task.probing.probe.tip_radius_mm,
            pre_travel_mm: 0.008,
            lobes_mm: 0.0003,
            noise_mm: 1e-3 * self.shift.noise_um,
            drift: Default::default(),
            pause_s: 0.0,
            seed: self.shift.seed.wrapping_mul(1_000).wrapping_add(u64::from(parts)),
            host: Host::LinuxCnc,
        };
        // The balls are in place from the start: the leading M0 sets them up.
        Ok(execute(&probing, &format!("M0\n{}", self.program))?)
    }

    /// Evaluates a log; without `before` it is the first one.
    fn evaluate(&self, known: &Machine, log: &str, before: Option<&Before<'_>>) -> Result<Reprobing> {
        let file = Path::new("look.log");
        let log = read_log(log, file, self.task.probing.dialect, |_| {})?;
        let trips = trips(&self.task.probing, &self.plan, &log, file)?;
        match before {
            None => begin(&self.task, known, &self.plan, &trips, file),
            Some(before) => evaluate(&self.task, known, &self.plan, &trips, file, before),
        }
    }

    /// Applies a re-probing: `known` receives its updates.
    fn taken(&self, known: &mut Known, parts: u32, taken: Result<Reprobing>) -> Result<Evaluated> {
        let mut evaluated = Evaluated { parts, updates: 0, refused: Vec::new(), log_refused: None, exchanged: None };
        let reprobing = match taken {
            Ok(reprobing) => reprobing,
            Err(error) => {
                evaluated.log_refused = Some(format!("{error:#}"));
                return Ok(evaluated);
            }
        };
        evaluated.refused = reprobing.refused().map(|(name, reason)| format!("{name} {reason}")).collect();
        if !evaluated.refused.is_empty() {
            return Ok(evaluated);
        }
        let name = Path::new("machine.toml");
        let own = machine_files(&known.machine, "");
        let files = Memory::new(own.iter().map(|(name, text)| (name, text.as_str())));
        let changes = changes(&self.task, &reprobing, &known.machine, &files, name)?;
        if changes.files.is_empty() {
            return Ok(evaluated);
        }
        let all = own.into_iter().map(|(name, text)| (name.into(), text)).chain(changes.files);
        let new = Machine::read_from(&Memory::new(all), name, &mut |_| {})?;
        evaluated.updates = reprobing.verdicts.iter().filter(|verdict| verdict.update() != 0.0).count();
        let about = self.task.probing.artefacts[0].places[0].at_mm;
        let about = [about[0], about[1].max(60.0), about[2], 0.0, 0.0, 0.0];
        evaluated.exchanged = Some(in_motion(&known.machine, &new, about)?);
        *known = Known { machine: new, totals: reprobing.totals(&self.task) };
        Ok(evaluated)
    }
}

/// Positions at which the tip error is evaluated, in the order of the machine's axes.
fn judged(machine: &Machine) -> Vec<[f64; AXES]> {
    let five = machine.settings.axis(Axis::C).is_some();
    let turns: &[[f64; 2]] = if five { &[[0.0, 0.0], [-30.0, 120.0], [30.0, 240.0]] } else { &[[0.0, 0.0]] };
    let at = |axis: Axis, share: f64| {
        let [low, high] = machine.settings.axis(axis).map_or([0.0; 2], |own| own.travel);
        low + share * (high - low)
    };
    let mut all = Vec::new();
    for [a, c] in turns {
        for x in [0.1, 0.5, 0.9] {
            for y in [0.1, 0.5, 0.9] {
                for z in [0.15, 0.5, 0.85] {
                    let mut position = [0.0; AXES];
                    for (slot, own) in machine.settings.axes.iter().enumerate() {
                        position[slot] = match own.axis {
                            Axis::X => at(Axis::X, x),
                            Axis::Y => at(Axis::Y, y),
                            Axis::Z => at(Axis::Z, z),
                            Axis::A => *a,
                            Axis::C => *c,
                            _ => 0.0,
                        };
                    }
                    all.push(position);
                }
            }
        }
    }
    all
}

/// Root mean square and maximum, µm.
fn figures(errors: &[DVec3]) -> [f64; 2] {
    let squares: f64 = errors.iter().map(|error| error.length_squared()).sum();
    let most = errors.iter().map(|error| error.length()).fold(0.0, f64::max);
    [1e3 * (squares / errors.len().max(1) as f64).sqrt(), 1e3 * most]
}

impl Shift {
    /// Runs the shift; `done` is called after every part.
    ///
    /// # Errors
    /// The task is invalid, or its balls do not determine its terms.
    pub fn run(&self, done: &dyn Fn()) -> Result<Outcome> {
        let task = KeepTask::read(&self.task, &self.task_file)?;
        let most = Drifting::most(self.part_s);
        if self.parts > most {
            let (parts, part_s) = (self.parts, self.part_s);
            return Err(anyhow!(
                "--parts: found {parts}, needed at most {most} of {part_s} s each, a shift of eight hours"
            ));
        }
        let started = if self.five_axes {
            random_five_axis(self.seed, &Class::MILL)
        } else {
            random_machine(self.seed, &Class::MILL)
        };
        let drifting = Drifting::new(started.clone(), self.seed, self.part_s);
        let nominal = perfect(&started);
        let plan = plan(&task, &nominal)?;
        let mut dice = ChaCha8Rng::seed_from_u64(self.seed ^ 0xba11);
        let mut normal = || -> f64 { StandardNormal.sample(&mut dice) };
        let set_ups = placed(&task.probing, &nominal, SetUp { misplaced_mm: 0.3, askew: 5e-4 }, &mut normal)?;
        // All artefacts are on the machine at once.
        let mut all: Vec<Artefact> = Vec::new();
        set_ups.into_iter().flatten().for_each(|one| {
            if !all.contains(&one) {
                all.push(one);
            }
        });
        let program = program(&task.probing, &nominal, &plan);
        let bench = Bench { shift: self, task, nominal, plan, program, artefacts: all };
        self.over(&bench, &drifting, &started, done)
    }

    fn over(&self, bench: &Bench<'_>, drifting: &Drifting, started: &Machine, done: &dyn Fn()) -> Result<Outcome> {
        let positions = judged(&bench.nominal);
        let first = bench.evaluate(started, &bench.log(&drifting.after(0), started, 0)?, None)?;
        let balls: Vec<BallPlace> = first.balls;
        let mut known = Known { machine: started.clone(), totals: BTreeMap::new() };
        let (mut parts, mut reprobings) = (Vec::new(), Vec::new());
        for made in 1..=self.parts {
            let truth = drifting.after(made);
            let without_um = figures(&remaining(&truth, started, &positions)?);
            let with_um = figures(&remaining(&truth, &known.machine, &positions)?);
            parts.push(Part { parts: made, without_um, with_um });
            if made.is_multiple_of(bench.task.every_parts) {
                let before = Before { known: &balls, totals: &known.totals, accepted: &[] };
                let log = bench.log(&truth, &known.machine, made);
                let taken = log.and_then(|log| bench.evaluate(&known.machine, &log, Some(&before)));
                reprobings.push(bench.taken(&mut known, made, taken)?);
            }
            done();
        }
        Ok(Outcome::of(started, parts, reprobings))
    }
}

impl Outcome {
    fn of(machine: &Machine, parts: Vec<Part>, reprobings: Vec<Evaluated>) -> Outcome {
        let count = parts.len().max(1) as f64;
        let rms = |take: fn(&Part) -> f64| (parts.iter().map(|part| take(part).powi(2)).sum::<f64>() / count).sqrt();
        let most = |take: fn(&Part) -> f64| parts.iter().map(take).fold(0.0, f64::max);
        let exchanges = || reprobings.iter().filter_map(|reprobing| reprobing.exchanged.as_ref());
        let largest = |take: fn(&Exchanged) -> f64| exchanges().map(take).fold(0.0, f64::max);
        let ramp_in: Option<Vec<f64>> = exchanges().map(|exchanged| exchanged.ramp_in_s).collect();
        Outcome {
            machine: machine.settings.name.to_string(),
            rms_um: [rms(|part| part.without_um[0]), rms(|part| part.with_um[0])],
            largest_um: [most(|part| part.without_um[1]), most(|part| part.with_um[1])],
            updates: reprobings.iter().filter(|reprobing| reprobing.updates > 0).count(),
            refusals: reprobings
                .iter()
                .filter(|reprobing| !reprobing.refused.is_empty() || reprobing.log_refused.is_some())
                .count(),
            largest_difference_um: 1e3 * largest(|exchanged| exchanged.difference),
            largest_step_um: 1e3 * largest(|exchanged| exchanged.largest_step),
            of_limits: largest(|exchanged| exchanged.of_limits),
            longest_ramp_in_s: ramp_in.map(|times| times.into_iter().fold(0.0, f64::max)),
            parts,
            reprobings,
        }
    }
}
