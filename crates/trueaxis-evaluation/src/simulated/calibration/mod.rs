//! The complete calibration of a simulated machine: task, program, probing, log, solution, tables, and the residual error.
//!
//! ```text
//! random machine ─┐
//! task ─► plan ─► program ─► probing ─► log ─► solution ─► machine files ─► compiled ─► correction ─► error over the volume
//!         artefacts within their uncertainty, misplaced; probe noise and lobes; drift
//! ```
//!
//! The log is the solution's only information about the true machine.

mod five_axes;
mod refused;
mod summary;
mod tasks;

pub use five_axes::{FiveAxes, compared, five_axes};
pub use refused::RefusedMachine;
pub use summary::{Machines, Summary, all, summary};
pub use tasks::{BALL_PLATE, FIVE_AXES, GAUGE_AND_SQUARE, MILL, TaskText};

use super::artefacts::{self, SetUp};
use crate::calibrate::{Calibration, Dialect, Plan, Task, calibrate, perfect, program, read_log, trips};
use anyhow::{Result, bail};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;
use std::path::Path;
use trueaxis_sim::calibration::{Class, Drift, Errors, Host, Probing, execute, random_machine, volumetric};
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::machine_files;

/// Conditions during the probing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Standard deviation of a touch, µm.
    pub noise_um: f64,
    /// Pre-travel of the probe, and its variation around the tip, µm.
    pub pre_travel_um: [f64; 2],
    /// Drift: standard deviation of its rate in each direction, µm/h, and of a part that settles, µm.
    pub drift_um: [f64; 2],
    /// Position error of the artefacts relative to the task, mm.
    pub misplaced_mm: f64,
    /// Misalignment of the artefacts about each direction, µrad.
    pub askew_urad: f64,
}

impl Conditions {
    /// A touch probe with 1 µm scatter on a machine that has not settled.
    pub const SHOP: Conditions = Conditions {
        noise_um: 1.0,
        pre_travel_um: [8.0, 0.3],
        drift_um: [4.0, 3.0],
        misplaced_mm: 0.3,
        askew_urad: 500.0,
    };

    /// An exact probe on a machine without drift; artefacts are set up as in [`Conditions::SHOP`].
    pub const EXACT: Conditions =
        Conditions { noise_um: 0.0, pre_travel_um: [8.0, 0.0], drift_um: [0.0, 0.0], ..Conditions::SHOP };
}

/// One machine calibrated.
#[derive(Clone, Debug)]
pub struct Calibrated {
    /// The log.
    pub log: String,
    /// The solution of the log.
    pub found: Calibration,
    /// The machine as its files describe it after the calibration.
    pub known: Machine,
}

/// Result for one machine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Seed of the machine and of everything else.
    pub seed: u64,
    /// Error over the volume without correction.
    pub before_um: Errors,
    /// Error over the volume with the identified correction.
    pub after_um: Errors,
    /// Share of the root-mean-square error that was removed.
    pub removed: f64,
    /// Standard deviation of a touch as estimated, µm.
    pub sigma_um: f64,
}

/// Calibrates the three-axis machine of a seed by a task such as [`MILL`].
///
/// # Errors
/// Any error of planning; [`RefusedMachine`] for an error of probing or solving.
pub fn three_axes<'t>(
    seed: u64,
    task: impl Into<TaskText<'t>>,
    class: &Class,
    conditions: &Conditions,
) -> Result<Outcome> {
    let truth = random_machine(seed, class);
    let calibrated = run(task, &truth, seed, conditions)?;
    let [before_um, after_um] = volumetric(&truth, &calibrated.known)?;
    let removed = 1.0 - after_um.rms / before_um.rms;
    Ok(Outcome { seed, before_um, after_um, removed, sigma_um: 1e3 * calibrated.found.solution.sigma_mm })
}

/// Runs the complete calibration on one machine.
///
/// # Errors
/// As [`three_axes`].
pub fn run<'t>(
    task: impl Into<TaskText<'t>>,
    truth: &Machine,
    seed: u64,
    conditions: &Conditions,
) -> Result<Calibrated> {
    let TaskText { file, text } = task.into();
    let task = Task::read(text, file)?;
    if task.is_read() {
        bail!(
            "{}: found a task with dials, needed touches; `trueaxis calibrate simulate` fills its sheet",
            file.display()
        );
    }
    let nominal = perfect(truth);
    let plan = Plan::new(&task, &nominal)?;
    let mut dice = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut dice) };
    let set_up = SetUp { misplaced_mm: conditions.misplaced_mm, askew: 1e-6 * conditions.askew_urad };
    let set_ups = artefacts::placed(&task, &nominal, set_up, &mut normal)?;
    let mut vector = |size: f64| [normal(), normal(), normal()].map(|part| 1e-3 * size * part).into();
    let drift = Drift { rate: vector(conditions.drift_um[0]), settles: vector(conditions.drift_um[1]), lag_s: 2400.0 };
    let probing = Probing {
        machine: truth.clone(),
        known: None,
        set_ups,
        tools_mm: artefacts::tools_mm(&task, &nominal),
        tip_radius_mm: task.probe.tip_radius_mm,
        pre_travel_mm: 1e-3 * conditions.pre_travel_um[0],
        lobes_mm: 1e-3 * conditions.pre_travel_um[1],
        noise_mm: 1e-3 * conditions.noise_um,
        drift,
        pause_s: 300.0,
        seed: seed ^ 0x9015e,
        // Alternates between the two controls.
        host: if seed.is_multiple_of(2) { Host::LinuxCnc } else { Host::GrblHal },
    };
    let dialect = if probing.host == Host::LinuxCnc { Dialect::LinuxCnc } else { Dialect::GrblHal };
    let task = Task { dialect, ..task };
    let text = program(&task, &nominal, &plan);
    let axes = truth.settings.axes.len();
    let (log, found) = probed(&task, &nominal, &plan, || Ok(execute(&probing, &text)?))
        .map_err(|error| RefusedMachine { axes, seed, reason: format!("{error:#}") })?;
    let files = Memory::new(machine_files(&nominal, ""));
    let edited = found.additions(&task).edit(&files, Path::new("machine.toml"))?;
    let all = machine_files(&nominal, "").into_iter().map(|(name, text)| (name.into(), text)).chain(edited.files);
    let known = Machine::read_from(&Memory::new(all), Path::new("machine.toml"), &mut |_| {})?;
    Ok(Calibrated { log, found, known })
}

/// Probes one machine: its log, and the solution.
fn probed(
    task: &Task,
    nominal: &Machine,
    plan: &Plan,
    probe: impl FnOnce() -> Result<String>,
) -> Result<(String, Calibration)> {
    let file = Path::new("probe.log");
    let log = probe()?;
    let read = read_log(&log, file, task.dialect, |_| {})?;
    let trips = trips(task, plan, &read, file)?;
    let found = calibrate(task, nominal, plan, &trips, file)?;
    Ok((log, found))
}
