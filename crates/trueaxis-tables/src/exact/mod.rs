//! The machine's true geometric error, by exact products of rigid transforms along its structural chain.
//!
//! This module shares no code with the compensation: the two have only the machine file in common.
//!
//! **Transforms.** With all axes at zero all frames are parallel to the bed's, and each lies at its axis' `offset_mm` o from
//! its carrier. From the bed outwards on either side, an axis with the errors e (mm) and w (rad) contributes
//!
//! ```text
//! linear   T(o) · T(±q n) · E(e, w)   the errors act about the moved frame's origin, in the carrier's directions
//! rotary   T(o) · E(e, w) · Rot(n, direction · q)                the errors come before the axis' own turn
//! ```
//!
//! E is the exact rotation by the rotation vector w, then the shift e. Tables state the tool relative to the workpiece, so a
//! carriage that carries the workpiece moves by −q (linear) and has the errors (−e, −w).
//!
//! **Location errors.** Squareness tilts the direction of travel, not the carriage: EXY −= C0Y·y, EXZ += B0Z·z,
//! EYZ −= A0Z·z. The location errors `EX0r … EC0r` of a rotary axis r are constants added to its twist, at the origin of
//! its frame, in its carrier's directions, with the sign of the tables.
//!
//! **Where a table applies.** Without `measured_at_mm` (zero), translations are those of the origin of the axis' moved frame.
//! With it, they are the readings of an instrument at a tool of length zero with the other linear axes at `measured_at_mm` and
//! the rotary axes at zero. The twist at the axis frame's origin follows to first order:
//!
//! ```text
//! e = e_measured − w × l,   l = p_measured − o_i = Σ m_j n_j over the linear axes j between the moved frame of i and the tool
//! ```
//!
//! m_j is component j of `measured_at_mm`, but q_i if j is the axis i itself (only an axis that carries the workpiece lies
//! between its own frame and the tool). A machine with this table alone reads exactly the table along that line. l excludes
//! the offsets and the tool's length: they are not travel.
//!
//! **Grids.** A grid's twist (e, w) displaces the whole tool side in the bed, about the point p_m that a tool of length zero
//! reaches with the grid's axes where they are, the other linear axes at the grid's `measured_at_mm` and the rotary ones at
//! zero:
//!
//! ```text
//! T(p_m) · E(e, w) · T(−p_m) · (transforms of the tool side)
//! ```
//!
//! Source: ISO 230-1:2012 (names and signs of errors), ISO 10791-6:2014 (structural code).

mod carriage;
mod chain;
mod correction;
mod grid;
mod rotation;
#[cfg(test)]
mod sample;
pub(crate) mod table;
#[cfg(test)]
mod tests;

use crate::Machine;
use carriage::{Carriage, unit};
use chain::structural_code;
pub use correction::CorrectionSettings;
use glam::{DAffine3, DMat3, DVec3};
use grid::ErrorGrid;
use rotation::{rotation, rotation_vector};
use thiserror::Error;
use trueaxis::machine::{AXES, Axis};

/// Why a machine has no geometry.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum GeometryError {
    /// The structural code cannot be read.
    #[error("structural code \"{chain}\": found {found}, needed {needed}")]
    Chain {
        /// The code as given.
        chain: String,
        /// Found character.
        found: String,
        /// Understood characters.
        needed: &'static str,
    },
    /// The structural code and the list of axes disagree.
    #[error("structural code \"{chain}\": axis {axis} is not among the machine's axes or occurs there twice")]
    Axis {
        /// The code as given.
        chain: String,
        /// The axis' letter.
        axis: char,
    },
}

/// Deviation of the tool from its ideal pose relative to the workpiece, actual − ideal, in machine directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseError {
    /// Tool tip: d = R_w (p_w,actual − p_w,ideal), mm.
    pub tip_mm: [f64; 3],
    /// Tool direction (the unit vector along `tool_axis`): R_w (t_w,actual − t_w,ideal), rad.
    pub direction: [f64; 3],
    /// Orientation of the tool: rotation vector of the turn from the ideal to the actual orientation relative to the
    /// workpiece, log(R_w ΔR R_wᵀ) with ΔR = R_wt,actual R_wt,idealᵀ, in bed directions, rad. To first order Σ R_i w_i.
    pub orientation: [f64; 3],
}

/// The ideal pose at a commanded position.
#[derive(Clone, Copy, Debug)]
pub struct Commanded {
    /// Orientation of the workpiece's frame.
    workpiece: DMat3,
    /// Tool tip in that frame.
    tip: DVec3,
    /// Orientation of the tool in that frame.
    orientation: DMat3,
}

/// Pose of the tool in the workpiece's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPose {
    /// Tool tip, mm.
    pub tip_mm: [f64; 3],
    /// Unit vector along the machine's `tool_axis`, moving with the last tool-side frame.
    pub direction: [f64; 3],
}

/// The chain of carriages with their errors; immutable, no allocation after `new`.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// Both sides from the bed outwards.
    workpiece: Vec<Carriage>,
    tool: Vec<Carriage>,
    grids: Vec<ErrorGrid>,
    tool_mm: DVec3,
    tool_axis: DVec3,
}

impl Geometry {
    /// The geometry of `machine` at `temperature_rise_k` kelvin above its reference temperature.
    pub fn new(machine: &Machine, temperature_rise_k: f64) -> Result<Geometry, GeometryError> {
        let settings = &machine.settings;
        let chain = settings.chain.as_str();
        let links = structural_code(chain)?;
        let mut seen = [false; AXES];
        let mut carriages = Vec::with_capacity(links.len());
        for (k, &(axis, on_workpiece)) in links.iter().enumerate() {
            let found = machine.axes().enumerate().find(|(_, (own, _))| own.axis == axis);
            let Some((slot, (own, table))) = found.filter(|_| !seen[axis.index()]) else {
                return Err(GeometryError::Axis { chain: chain.to_owned(), axis: axis.letter() });
            };
            seen[axis.index()] = true;
            let mut carriage = Carriage::new(slot, own, table, on_workpiece);
            carriage.add_location_errors(axis, &settings.location);
            settings.periods_of(axis).for_each(|period| carriage.add_period(period));
            carriage.add_thermal_growth(own, temperature_rise_k);
            carriage.lever = links[k + 1..]
                .iter()
                .filter(|(beyond, _)| !beyond.is_rotary())
                .map(|(beyond, _)| unit(*beyond) * own.measured_at_mm[beyond.index()])
                .sum();
            carriages.push((on_workpiece, carriage));
        }
        let side = |which: bool| carriages.iter().filter(move |(on, _)| *on == which).map(|(_, c)| c.clone());
        // The code runs from the workpiece through the bed to the tool, so only the workpiece side has to be reversed.
        let workpiece = side(true).rev().collect();
        let tool = side(false).collect();
        let on_tool: Vec<Axis> = links.iter().filter(|(_, on)| !on).map(|(axis, _)| *axis).collect();
        let grids = machine.grids.iter().map(|grid| ErrorGrid::new(settings, grid, &on_tool)).collect();
        Ok(Geometry {
            workpiece,
            tool,
            grids,
            tool_mm: DVec3::from_array(settings.tool_mm),
            tool_axis: DVec3::from_array(settings.kinematics.tool_axis).normalize_or(DVec3::Z),
        })
    }

    /// Error of the tool tip, d = R_w (p_w,actual − p_w,ideal), mm in machine directions.
    ///
    /// `position`: axis positions in the order of `settings.axes`, mm or degrees. `reverse`: 0 for an axis in positive travel,
    /// 1 in negative travel (reverse columns, backlash), in between while the axis traverses its lost motion. Rounding: below
    /// 1e-12 mm at positions of a metre.
    pub fn tip_error(&self, position: &[f64; AXES], reverse: &[f64; AXES]) -> [f64; 3] {
        let (workpiece, workpiece_actual) = side(&self.workpiece, position, reverse);
        let (tool, tool_actual) = self.tool_side(position, reverse);
        let ideal = into_frame(&workpiece, tool.transform_point3(self.tool_mm));
        let actual = into_frame(&workpiece_actual, tool_actual.transform_point3(self.tool_mm));
        (workpiece.matrix3 * (actual - ideal)).to_array()
    }

    /// Error of tool tip, tool direction and orientation; arguments as for [`Geometry::tip_error`].
    ///
    /// Rounding of the angles: below 1e-15 rad.
    pub fn pose_error(&self, position: &[f64; AXES], reverse: &[f64; AXES]) -> PoseError {
        self.pose_error_of(&self.commanded(position), position, reverse)
    }

    /// The ideal pose at a command, for [`Geometry::pose_error_of`] with the axes at other positions.
    pub fn commanded(&self, position: &[f64; AXES]) -> Commanded {
        let workpiece = ideal(&self.workpiece, position);
        let tool = ideal(&self.tool, position);
        let tip = into_frame(&workpiece, tool.transform_point3(self.tool_mm));
        Commanded { workpiece: workpiece.matrix3, tip, orientation: workpiece.matrix3.transpose() * tool.matrix3 }
    }

    /// Error against a command with the axes at `sent`, for example the corrected command: actual pose at `sent` − ideal pose
    /// at the command, in the directions of the machine as commanded.
    ///
    /// Rounding as for [`Geometry::tip_error`] and [`Geometry::pose_error`]. Cost: one product of the chain.
    pub fn pose_error_of(&self, command: &Commanded, sent: &[f64; AXES], reverse: &[f64; AXES]) -> PoseError {
        let (_, workpiece) = side(&self.workpiece, sent, reverse);
        let (_, tool) = self.tool_side(sent, reverse);
        let tip = into_frame(&workpiece, tool.transform_point3(self.tool_mm));
        let (ideal, actual) = (command.orientation, workpiece.matrix3.transpose() * tool.matrix3);
        let turn = actual * ideal.transpose();
        PoseError {
            tip_mm: (command.workpiece * (tip - command.tip)).to_array(),
            direction: (command.workpiece * (actual * self.tool_axis - ideal * self.tool_axis)).to_array(),
            orientation: (command.workpiece * rotation_vector(turn)).to_array(),
        }
    }

    /// Pose of the real tool in the workpiece's frame; arguments as for [`Geometry::tip_error`].
    pub fn actual_pose(&self, position: &[f64; AXES], reverse: &[f64; AXES]) -> ToolPose {
        let (_, workpiece) = side(&self.workpiece, position, reverse);
        let (_, tool) = self.tool_side(position, reverse);
        self.pose(&workpiece, &tool)
    }

    /// Pose of a perfect machine's tool in the workpiece's frame at `position`.
    pub fn ideal_pose(&self, position: &[f64; AXES]) -> ToolPose {
        let (workpiece, _) = side(&self.workpiece, position, &[0.0; AXES]);
        let (tool, _) = side(&self.tool, position, &[0.0; AXES]);
        self.pose(&workpiece, &tool)
    }

    /// Ideal and actual transform from the last frame of the tool's side to the bed.
    fn tool_side(&self, position: &[f64; AXES], reverse: &[f64; AXES]) -> (DAffine3, DAffine3) {
        let (ideal, actual) = side(&self.tool, position, reverse);
        let displaced = self.grids.iter().fold(actual, |actual, grid| grid.displacement(position) * actual);
        (ideal, displaced)
    }

    fn pose(&self, workpiece: &DAffine3, tool: &DAffine3) -> ToolPose {
        ToolPose {
            tip_mm: into_frame(workpiece, tool.transform_point3(self.tool_mm)).to_array(),
            direction: (workpiece.matrix3.transpose() * tool.matrix3 * self.tool_axis).to_array(),
        }
    }
}

/// Ideal and actual transform from the last frame of a side to the bed.
fn side(carriages: &[Carriage], position: &[f64; AXES], reverse: &[f64; AXES]) -> (DAffine3, DAffine3) {
    let mut ideal = DAffine3::IDENTITY;
    let mut actual = DAffine3::IDENTITY;
    for carriage in carriages {
        let q = position[carriage.slot];
        let (e, w) = carriage.errors(q, reverse[carriage.slot]);
        let (travel, turn) = carriage.nominal(q);
        moved(&mut ideal, travel, turn);
        let tilt = rotation(w * carriage.sign);
        let matrix3 = turn.map_or(tilt, |turn| tilt * turn);
        actual *= DAffine3 { matrix3, translation: travel + e * carriage.sign };
    }
    (ideal, actual)
}

/// Ideal transform of [`side`] alone.
fn ideal(carriages: &[Carriage], position: &[f64; AXES]) -> DAffine3 {
    let mut ideal = DAffine3::IDENTITY;
    for carriage in carriages {
        let (travel, turn) = carriage.nominal(position[carriage.slot]);
        moved(&mut ideal, travel, turn);
    }
    ideal
}

/// Moves a frame by the next carriage's own travel and rotation.
fn moved(frame: &mut DAffine3, travel: DVec3, turn: Option<DMat3>) {
    frame.translation += frame.matrix3 * travel;
    if let Some(turn) = turn {
        frame.matrix3 *= turn;
    }
}

/// A point of the bed in the coordinates of `frame`.
fn into_frame(frame: &DAffine3, point: DVec3) -> DVec3 {
    frame.matrix3.transpose() * (point - frame.translation)
}
