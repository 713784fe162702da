//! Logs of a touch probe, for `calibrate` and `keep`.

#[cfg(feature = "simulated")]
use super::dial;
use super::{Conditions, Stream, truth_of};
use crate::calibrate::{Dialect, Plan, Task, perfect, program};
use crate::keep::{KeepTask, plan};
use crate::simulated::artefacts::{SetUp, placed, tools_mm};
use anyhow::{Context, Result};
use trueaxis_sim::calibration::{Artefact, Drift, Host, Probing, execute};
use trueaxis_tables::Machine;

/// Position error of a manual set-up, mm, at most; and misalignment about each direction, rad.
const MISPLACED_MM: f64 = 0.3;
const ASKEW: f64 = 5e-4;
/// Largest position error as a share of the way before and after the surface.
const OF_THE_WAY: f64 = 0.1;
/// Duration of every pause, s.
const PAUSE_S: f64 = 300.0;

/// The log of a calibration's program: touches on `truth`, which the tables of `machine` correct if the task says so.
///
/// # Errors
/// Any error of planning; a true machine of another structure; a program that touches nothing or something else.
pub fn calibrate(task: &Task, machine: &Machine, truth: &Machine, conditions: &Conditions) -> Result<String> {
    if task.is_read() {
        // Left out of the desk's page for its size.
        #[cfg(feature = "simulated")]
        return Ok(dial(task, machine, truth, conditions)?.text);
        #[cfg(not(feature = "simulated"))]
        anyhow::bail!(
            "{}: found a task with dials, needed touches; `trueaxis calibrate simulate` fills its sheet",
            task.file.display()
        );
    }
    let plan = Plan::new(task, &perfect(machine))?;
    let set_ups = surfaces(task, machine, conditions)?;
    let known = task.compensated.then(|| machine.clone());
    let rehearsed = Rehearsed { task, machine, truth, known, plan: &plan, set_ups };
    rehearsed.log(conditions, "")
}

/// The log of a re-probing's program, on `truth` as the tables of `machine` correct it. All balls are in place from the start.
///
/// # Errors
/// As [`calibrate`].
pub fn keep(task: &KeepTask, machine: &Machine, truth: &Machine, conditions: &Conditions) -> Result<String> {
    let plan = plan(task, &perfect(machine))?;
    let mut all: Vec<Artefact> = Vec::new();
    for one in surfaces(&task.probing, machine, conditions)?.into_iter().flatten() {
        if !all.contains(&one) {
            all.push(one);
        }
    }
    let known = Some(machine.clone());
    let rehearsed = Rehearsed { task: &task.probing, machine, truth, known, plan: &plan, set_ups: vec![all] };
    // A pause sets the artefacts up.
    rehearsed.log(conditions, "M0\n")
}

/// True surfaces in every set-up: sizes drawn within their uncertainty, places off as in a manual set-up.
fn surfaces(task: &Task, machine: &Machine, conditions: &Conditions) -> Result<Vec<Vec<Artefact>>> {
    let way = task.probe.approach_mm.min(task.probe.overtravel_mm);
    let set_up = SetUp { misplaced_mm: MISPLACED_MM.min(OF_THE_WAY * way), askew: ASKEW };
    let mut draws = conditions.draws(Stream::SetUp);
    placed(task, &perfect(machine), set_up, &mut || draws.normal())
}

struct Rehearsed<'t> {
    task: &'t Task,
    machine: &'t Machine,
    truth: &'t Machine,
    known: Option<Machine>,
    plan: &'t Plan,
    set_ups: Vec<Vec<Artefact>>,
}

impl Rehearsed<'_> {
    fn log(self, conditions: &Conditions, before: &str) -> Result<String> {
        let Rehearsed { task, machine, truth, known, plan, set_ups } = self;
        let (host, dialect) = match task.dialect {
            Dialect::LinuxCnc => (Host::LinuxCnc, Dialect::LinuxCnc),
            Dialect::GrblHal => (Host::GrblHal, Dialect::GrblHal),
            // Klipper's macros are no G-code: the same touches, read from LinuxCNC's program.
            Dialect::Klipper => (Host::Klipper, Dialect::LinuxCnc),
        };
        let program = program(&Task { dialect, ..task.clone() }, &perfect(machine), plan);
        let probe = &task.probe;
        let off = probe.tip_uncertainty_mm.map_or(0.0, |u| u * conditions.draws(Stream::Tip).normal());
        let probing = Probing {
            machine: truth_of(machine, truth)?,
            known,
            set_ups,
            tools_mm: tools_mm(task, machine),
            tip_radius_mm: probe.tip_radius_mm,
            pre_travel_mm: probe.pre_travel_mm + off,
            lobes_mm: 0.0,
            noise_mm: conditions.noise_um.map_or(probe.repeatability_mm, |um| 1e-3 * um),
            drift: Drift { rate: conditions.rate(), ..Drift::default() },
            pause_s: PAUSE_S,
            seed: conditions.seed,
            host,
        };
        execute(&probing, &format!("{before}{program}"))
            .with_context(|| format!("{}: the program of this task", task.file.display()))
    }
}
