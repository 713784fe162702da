//! Volumetric error over the working volume, before and after the correction.
//!
//! At every point q of a grid over the travel of the linear axes, the rotary axes fixed in one pose:
//!
//! ```text
//! before   d(q) = R_w (p_actual(q) − p_ideal(q))
//! after    d(q) = R_w (p_actual(q + r(q)) − p_ideal(q))
//! ```
//!
//! p is the tip in the workpiece's frame by exact products of rigid transforms ([`trueaxis_tables::exact`], which shares
//! nothing with the compensation), r the correction that the servo step sends at rest, within its magnitude limits
//! ([`trueaxis::compensation::Compensation::correction`]). Errors are actual − ideal, tool relative to workpiece, in machine
//! directions (ISO 230-1), µm; rotations of the tool µrad. The step knows temperature and directions of travel.
//!
//! The residual is the part that the model omits: for nine terms the levers of angular errors, for the volumetric form
//! products of errors; and, if a correction meets its limit or an axis is missing, the part that could not be sent.

mod figures;
pub(crate) mod grid;
mod sample;
mod worst;

pub use figures::{Case, Figures, Left, Orientation, Slice};
pub use grid::{MOST_POINTS, Points};
pub use worst::{Cause, Table, Worst};

use crate::model::{passes, takes_rise};
use anyhow::{Result, anyhow, bail};
use grid::Grid;
use sample::{Pose, Sampler};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use trueaxis::check;
use trueaxis::machine::{AXES, Axis, ErrorModel};
use trueaxis_tables::Machine;

/// An error model by its name in a machine's description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Model {
    /// Axis by axis, without levers.
    Nine,
    /// Twists of all axes, carried to the tip.
    Volumetric,
}

impl Model {
    const BOTH: [Model; 2] = [Model::Nine, Model::Volumetric];

    fn of(model: ErrorModel) -> Model {
        match model {
            ErrorModel::Nine => Model::Nine,
            ErrorModel::Volumetric => Model::Volumetric,
        }
    }

    /// The machine with this model.
    fn on(self, machine: &Machine) -> Machine {
        let mut machine = machine.clone();
        machine.settings.compensation.model = match self {
            Model::Nine => ErrorModel::Nine,
            Model::Volumetric => ErrorModel::Volumetric,
        };
        machine
    }
}

/// Where and how the field is sampled.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Points along the linear axes.
    pub points: Points,
    /// Kelvin above the machine's reference temperature.
    pub kelvin: f64,
    /// Model of the correction; by default the machine's own.
    pub model: Option<Model>,
    /// Letters of the axes that travel in negative direction, such as `XZ`; the others travel in positive direction.
    pub negative: String,
    /// Tip from the last tool-side frame, mm; by default the machine's own.
    pub tool_mm: Option<[f64; 3]>,
    /// Positions of rotary axes by letter, degrees; 0 by default.
    pub pose_deg: BTreeMap<char, f64>,
}

/// The settings, checked against the machine.
struct Asked {
    /// Machine with the requested tool.
    machine: Machine,
    grid: Grid,
    kelvin: f64,
    /// Both by [`Axis::index`].
    reverse: [bool; AXES],
    pose: [f64; AXES],
}

impl Asked {
    fn new(machine: &Machine, settings: &Settings) -> Result<Asked> {
        let mut machine = machine.clone();
        if let Some(tool) = settings.tool_mm {
            machine.settings.tool_mm = tool;
            check::settings(&machine.settings).map_err(|error| anyhow!("{error}"))?;
        }
        let kelvin = settings.kelvin;
        if !takes_rise(&machine, kelvin) {
            bail!("temperature: found {kelvin} K above the reference, needed a growth of at most 10 mm and 1e-3");
        }
        let own = |letter: char| {
            let axis = Axis::from_letter(letter.to_ascii_uppercase());
            axis.and_then(|axis| machine.settings.axis(axis))
        };
        let letters = || machine.settings.axes.iter().map(|own| own.axis.letter()).collect::<String>();
        let mut reverse = [false; AXES];
        for letter in settings.negative.chars() {
            let own = own(letter).ok_or_else(|| {
                anyhow!("direction of travel: found axis {letter:?}, needed axes of the machine ({})", letters())
            })?;
            reverse[own.axis.index()] = true;
        }
        let mut pose = [0.0; AXES];
        for (&letter, &degrees) in &settings.pose_deg {
            let own = own(letter).filter(|own| own.axis.is_rotary()).ok_or_else(|| {
                anyhow!("pose: found axis {letter:?}, needed rotary axes of the machine ({})", letters())
            })?;
            let [low, high] = own.travel;
            if !(low..=high).contains(&degrees) {
                bail!("pose: found {degrees} degrees of {letter}, needed the declared travel, {low} to {high}");
            }
            pose[own.axis.index()] = degrees;
        }
        let grid = Grid::new(&machine, settings.points)?;
        Ok(Asked { machine, grid, kelvin, reverse, pose })
    }

    /// Commanded position of a grid point, by [`Axis::index`].
    fn at(&self, index: usize) -> [f64; AXES] {
        let mut at = self.pose;
        at[..3].copy_from_slice(&self.grid.at(index));
        at
    }
}

/// The field as rows of nine: x, y, z of the point, mm; error of the tip before and after, µm. X changes fastest, Z slowest.
///
/// Cost: two products of the chain and one correction per point.
///
/// # Errors
/// Too few or too many points, axes that the machine does not have, a pose outside the travel, a travel that is neither
/// declared nor given by a table; a model that the machine's errors do not allow.
pub fn rows(machine: &Machine, settings: &Settings) -> Result<Vec<f32>> {
    let asked = Asked::new(machine, settings)?;
    let model = settings.model.unwrap_or(Model::of(machine.settings.compensation.model));
    let corrected = model.on(&asked.machine);
    let mut rows = Vec::with_capacity(9 * asked.grid.count());
    Sampler::new(&asked)?.compensated(&corrected, passes(&corrected, None)?, |sampler, model| {
        for index in 0..asked.grid.count() {
            let at = asked.at(index);
            let (before, command) = sampler.before(&at);
            let after = sampler.after(model, &at, &command)?;
            rows.extend(at[..3].iter().map(|mm| *mm as f32));
            rows.extend(before.tip.iter().chain(&after.pose.tip).map(|mm| (mm * 1e3) as f32));
        }
        Ok(())
    })?;
    Ok(rows)
}

/// Figures of the field under both models: largest, RMS, 95 %, by slices, worst points and their causes.
///
/// Cost: three products of the chain and two corrections per point, and one of each per term of the machine.
///
/// # Errors
/// As [`rows`], except that a model that the machine's errors do not allow is reported in place of its figures.
pub fn figures(machine: &Machine, settings: &Settings) -> Result<Figures> {
    let asked = Asked::new(machine, settings)?;
    let model = settings.model.unwrap_or(Model::of(machine.settings.compensation.model));
    let sampler = Sampler::new(&asked)?;
    let before: Vec<Pose> = (0..asked.grid.count()).map(|index| sampler.before(&asked.at(index)).0).collect();
    let worst = worst::before(&sampler, &before)?;
    let mut figures = Figures::new(&asked, model, sampler.beyond_tables(), Case::new(&asked.grid, &before, worst));
    for model in Model::BOTH {
        figures.add(model, after(&sampler, model).map_err(|error| format!("{error:#}")));
    }
    Ok(figures)
}

/// The error that remains under a model.
fn after(sampler: &Sampler<'_>, model: Model) -> Result<(Case, usize)> {
    let asked = sampler.asked;
    let machine = model.on(&asked.machine);
    let mut poses = Vec::with_capacity(asked.grid.count());
    let mut limited = 0;
    let passes = passes(&machine, None)?;
    sampler.compensated(&machine, passes, |sampler, model| {
        for index in 0..asked.grid.count() {
            let at = asked.at(index);
            let after = sampler.after(model, &at, &sampler.geometry.commanded(&sampler.slots(&at)))?;
            limited += usize::from(after.limited);
            poses.push(after.pose);
        }
        Ok(())
    })?;
    let worst = worst::after(sampler, &machine, passes, &poses)?;
    Ok((Case::new(&asked.grid, &poses, worst), limited))
}
