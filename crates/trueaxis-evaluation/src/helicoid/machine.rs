//! Machines for a request: builds one from its settings, checks whether a given one fits it, and adapts a given one to it.

use super::apart::apart;
use super::job::Job;
use super::travel::Limits;
use anyhow::{Result, anyhow};
use serde::Serialize;
use trueaxis::Axis;
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::{
    AXES, AxisSettings, CompensationSettings, ContourSettings, FaultSettings, KinematicsSettings, LocationErrors,
    MachineSettings, links,
};
use trueaxis_metrology::helicoid::{Form, MachineSettings as Settings, Placement};
use trueaxis_tables::Machine;

/// Structural code of the machine that the displacements assume.
const CHAIN: &str = "w C' b X Y Z A t";
/// Tolerances for equal tips, mm, and for equal directions.
const SAME_MM: f64 = 1e-6;
const SAME: f64 = 1e-9;

/// X Y Z A B C from X Y Z A C.
pub(super) fn six([x, y, z, a, c]: &[f64; 5]) -> [f64; AXES] {
    [*x, *y, *z, *a, 0.0, *c]
}

fn spindle(settings: &Settings, length: f64) -> [f64; 3] {
    settings.form.spindle().map(|part| length * part)
}

/// The transformation of a machine `w C' b X Y Z A t` with the request's pivot length, directions and form.
pub(super) fn twin(settings: &Settings) -> Result<Kinematics<f64>> {
    let failed = |_| anyhow!("the name of a machine is too long");
    let axis = |axis: Axis| {
        let plain = AxisSettings::with_defaults(axis, axis == Axis::C);
        match axis {
            Axis::A => AxisSettings {
                offset_mm: spindle(settings, settings.pivot_mm),
                direction: settings.direction_a,
                ..plain
            },
            Axis::C => AxisSettings { direction: settings.direction_c, ..plain },
            _ => plain,
        }
    };
    let machine = MachineSettings {
        name: "helicoid".parse().map_err(failed)?,
        chain: CHAIN.parse().map_err(failed)?,
        tool_mm: spindle(settings, -settings.pivot_mm),
        reference_temperature_c: 20.0,
        location: LocationErrors::default(),
        faults: FaultSettings::default(),
        contour: ContourSettings::default(),
        compensation: CompensationSettings::default(),
        kinematics: KinematicsSettings { tool_axis: spindle(settings, 1.0), ..KinematicsSettings::default() },
        axes: super::travel::AXES.into_iter().map(axis).collect(),
        roundness: None,
        crosstalk: Default::default(),
        periodic: Default::default(),
    };
    Kinematics::new(&machine).map_err(|error| anyhow!("{error}"))
}

/// Whether the displacements of a request are positions of a machine's axes.
#[derive(Clone, Debug, Serialize)]
pub struct Fit {
    /// The machine's name.
    pub machine: String,
    /// Structural code of the machine.
    pub chain: String,
    /// Whether they are such positions.
    pub fits: bool,
    /// Why not: found and needed.
    pub reasons: Vec<String>,
    /// Declared travel of the axes X, Y, Z, A and C; `None` unless the machine has A and C.
    pub travel: Option<Limits>,
}

/// Whether the displacements of a request are positions of this machine's axes: whether its own forward transformation gives
/// the same tool pose in the table's frame at the same positions.
pub fn fit(job: &Job, machine: &MachineSettings) -> Fit {
    let has = |axis: Axis| machine.axis(axis).is_some();
    let reasons = reasons(job, machine);
    Fit {
        machine: machine.name.as_str().to_owned(),
        chain: machine.chain.as_str().to_owned(),
        fits: reasons.is_empty(),
        reasons,
        travel: (has(Axis::A) && has(Axis::C)).then(|| Limits::of(machine)),
    }
}

fn reasons(job: &Job, machine: &MachineSettings) -> Vec<String> {
    let letters: String = machine.axes.iter().map(|own| own.axis.letter()).collect();
    if letters != "XYZAC" {
        let found: Vec<String> = letters.chars().map(String::from).collect();
        return vec![format!("found the axes {}, needed X, Y, Z, A and C", found.join(", "))];
    }
    let mut reasons = Vec::new();
    for link in links(&machine.chain).iter().flatten() {
        match link.axis {
            Axis::C if !link.carries_workpiece => {
                reasons.push("found C on the tool's side, needed a table C that turns the workpiece".to_owned());
            }
            Axis::A if link.carries_workpiece => {
                reasons.push("found A on the workpiece's side, needed a head A that turns the tool".to_owned());
            }
            _ => {}
        }
    }
    if !reasons.is_empty() {
        return reasons;
    }
    match Kinematics::new(machine) {
        Ok(kinematics) => geometry(job, &kinematics),
        Err(error) => vec![error.to_string()],
    }
}

/// Differences between the machine's transformation and the request's: tool direction at rest, axis senses, tip at rest, pivot
/// length.
fn geometry(job: &Job, kinematics: &Kinematics<f64>) -> Vec<String> {
    let at = |a: f64, c: f64| {
        let found = kinematics.forward(&[0.0, 0.0, 0.0, a, 0.0, c]);
        let needed = job.machine.tool(&Placement { linear_mm: [0.0; 3], a_deg: a, c_deg: c });
        let offset = job.settings.work_offset_mm;
        let tip: [f64; 3] = std::array::from_fn(|i| needed.tip_mm[i] + offset[i]);
        (found.tip.to_array(), found.axis.to_array(), tip, needed.axis)
    };
    let said = |[x, y, z]: [f64; 3]| [x, y, z].map(|part| format!("{}", (part * 1e6).round() / 1e6 + 0.0)).join(", ");
    let (tip, axis, tip_needed, axis_needed) = at(0.0, 0.0);
    if apart(axis, axis_needed) > SAME {
        let (form, axis, needed) = (job.form_name(), said(axis), said(axis_needed));
        return vec![format!("at A = 0: found the tool along [{axis}], needed [{needed}] ({form})")];
    }
    let mut reasons = Vec::new();
    if apart(tip, tip_needed) > SAME_MM {
        let (tip, needed) = (said(tip), said(tip_needed));
        reasons.push(format!("at all axes zero: found the tip at [{tip}] mm of the table, needed [{needed}] mm"));
    }
    let (turned, axis, turned_needed, axis_needed) = at(30.0, 0.0);
    let is_a = apart(axis, axis_needed) <= SAME;
    if !is_a {
        let needed = job.settings.direction_a;
        reasons.push(format!("direction of A: found {}, needed {needed}", -needed));
    }
    // The tip moves on a circle about the A axis: a chord of 30 degrees.
    let pivot = |from, to| apart(from, to) / (2.0 * 15f64.to_radians().sin());
    let [found, needed] = [pivot(tip, turned), pivot(tip_needed, turned_needed)];
    if (found - needed).abs() > SAME_MM {
        let rounded = (found * 1e6).round() / 1e6;
        reasons.push(format!("pivot length: found {rounded} mm, needed {} mm", job.settings.pivot_mm));
    }
    let (_, axis, _, axis_needed) = at(30.0, 40.0);
    if is_a && apart(axis, axis_needed) > SAME {
        let needed = job.settings.direction_c;
        reasons.push(format!("direction of C: found {}, needed {needed}", -needed));
    }
    if reasons.is_empty() {
        let (tip, _, needed, _) = at(-50.0, 130.0);
        if apart(tip, needed) > SAME_MM {
            reasons.push("found axes A and C whose offsets differ from the formula's".to_owned());
        }
    }
    reasons
}

/// Adapts a machine of the chain `w C' b X Y Z A t`, upright at A = 0 and with positive senses, to a request: pivot length,
/// form and directions. Tables and travel of A and C follow the joints, not their numbers.
///
/// # Errors
/// A machine with another chain.
pub fn adapted(job: &Job, mut machine: Machine) -> Result<Machine> {
    let chain = machine.settings.chain.as_str();
    if links(chain) != links(CHAIN) {
        return Err(anyhow!("found a machine of the chain {chain}, needed {CHAIN}"));
    }
    let settings = &job.settings;
    machine.settings.tool_mm = spindle(settings, -settings.pivot_mm);
    machine.settings.kinematics.tool_axis = spindle(settings, 1.0);
    let quarter = if settings.form == Form::Vertical { 0.0 } else { 90.0 };
    for (own, table) in machine.settings.axes.iter_mut().zip(&mut machine.tables) {
        let (direction, rest) = match own.axis {
            Axis::A => (settings.direction_a, quarter),
            Axis::C => (settings.direction_c, 0.0),
            _ => continue,
        };
        if own.axis == Axis::A {
            own.offset_mm = spindle(settings, settings.pivot_mm);
        }
        own.direction = direction;
        let sense = f64::from(direction);
        let ends = |[low, high]: [f64; 2]| {
            let [one, other] = [low, high].map(|end| sense * (end + rest));
            [one.min(other), one.max(other)]
        };
        (own.travel, own.joint) = (ends(own.travel), ends(own.joint));
        let Some(table) = table else { continue };
        for row in &mut table.rows {
            row.position = sense * (row.position + rest) + 0.0;
            if direction < 0 {
                std::mem::swap(&mut row.forward, &mut row.reverse);
            }
        }
        if direction < 0 {
            table.rows.reverse();
        }
    }
    Ok(machine)
}
