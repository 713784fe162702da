//! The machine's true geometric error, by exact products of rigid transforms along its structural chain.
//!
//! Nothing here is shared with the compensation: the two meet only in the machine file.
//!
//! **Transforms.** With all axes at zero all frames coincide. From the bed outwards on either side, an axis with the
//! errors e (mm) and w (rad) contributes
//!
//! ```text
//! linear   T(±q n) · E(e, w)          the errors act about the moved frame's origin, in the carrier's directions
//! rotary   E(e, w) · Rot(n, direction · q)                       the errors come before the axis' own turn
//! ```
//!
//! E is the exact rotation of the rotation vector w, then the shift e. Tables state the tool relative to the workpiece;
//! so a carriage that carries the workpiece moves by −q (linear) and has the errors (−e, −w).
//!
//! **Location errors.** Squareness tilts the direction of travel, not the carriage: EXY −= C0Y·y, EXZ += B0Z·z,
//! EYZ −= A0Z·z. The location errors `EX0r … EC0r` of a rotary axis r are constants added to its twist, at the origin of
//! its frame, in its carrier's directions, with the sign of the tables.
//!
//! **Where a table holds.** Translations are what an instrument reads at a tool of length zero while the other linear axes stand
//! at `measured_at_mm` and the rotary axes at zero. The twist at the axis frame's origin follows to first order:
//!
//! ```text
//! e = e_measured − w × l,   l = p_measured − o_i = Σ m_j n_j over the linear axes j between the moved frame of i and the tool
//! ```
//!
//! m_j is component j of `measured_at_mm`, but q_i where j is the axis i itself (only an axis that carries the
//! workpiece lies between its own frame and the tool). A machine with this one table alone reads exactly the table
//! along that line.
//!
//! Source: ISO 230-1:2012 (names and signs of errors), ISO 10791-6:2014 (structural code).

use super::table::ErrorTable;
use glam::{DAffine3, DMat3, DVec3};
use thiserror::Error;
use trueaxis::machine::{AXES, Axis, AxisSettings, LocationErrors, Twist};
use trueaxis_tables::{Machine, Table};

#[cfg(test)]
mod tests;

/// Why a machine cannot be simulated.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum GeometryError {
    /// The structural code cannot be read.
    #[error("structural code \"{chain}\": found {found}, needed {needed}")]
    Chain {
        /// The code as given.
        chain: String,
        /// What stands there.
        found: String,
        /// What would be understood.
        needed: &'static str,
    },
    /// The structural code and the list of axes differ.
    #[error("structural code \"{chain}\": axis {axis} is not among the machine's axes or stands there twice")]
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
    /// Tool direction (unit vector, +Z of the last tool-side frame): R_w (t_w,actual − t_w,ideal), rad.
    pub direction: [f64; 3],
}

/// Pose of the tool in the workpiece's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPose {
    /// Tool tip, mm.
    pub tip_mm: [f64; 3],
    /// Unit vector along +Z of the last tool-side frame.
    pub direction: [f64; 3],
}

/// One axis' carriage.
#[derive(Clone, Debug)]
struct Carriage {
    slot: usize,
    rotary: bool,
    along: DVec3,
    /// Sense of the carriage's motion for a positive command.
    motion: f64,
    /// −1 where the carriage carries the workpiece.
    sign: f64,
    table: Option<ErrorTable>,
    constant: Twist,
    per_position: Twist,
    /// Component of the axis' own positioning error, and its change in negative travel (mm, rad).
    own: usize,
    backlash: f64,
    lever: DVec3,
    own_lever: f64,
}

/// The chain of carriages with their errors; immutable, no allocation after `new`.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// Both sides from the bed outwards.
    workpiece: Vec<Carriage>,
    tool: Vec<Carriage>,
    tool_mm: DVec3,
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
            carriage.add_thermal_growth(own, temperature_rise_k);
            carriage.lever = links[k + 1..]
                .iter()
                .filter(|(beyond, _)| !beyond.is_rotary())
                .map(|(beyond, _)| unit(*beyond) * own.measured_at_mm[beyond.index()])
                .sum();
            carriages.push((on_workpiece, carriage));
        }
        let side = |which: bool| carriages.iter().filter(move |(on, _)| *on == which).map(|(_, c)| c.clone());
        // The code runs from the workpiece through the bed to the tool: only the first side has to be turned round.
        let workpiece = side(true).rev().collect();
        let tool = side(false).collect();
        Ok(Geometry { workpiece, tool, tool_mm: DVec3::from_array(settings.tool_mm) })
    }

    /// Error of the tool tip, d = R_w (p_w,actual − p_w,ideal), mm in machine directions.
    ///
    /// `position`: axis positions in the order of `settings.axes`, mm or degrees. `reverse`: 0 for an axis in positive
    /// travel, 1 in negative travel (reverse columns, backlash), in between while its lost motion is being traversed.
    /// Rounding: below 1e-12 mm at positions of a metre.
    pub fn tip_error(&self, position: &[f64; AXES], reverse: &[f64; AXES]) -> [f64; 3] {
        let (workpiece, workpiece_actual) = side(&self.workpiece, position, reverse);
        let (tool, tool_actual) = side(&self.tool, position, reverse);
        let ideal = into_frame(&workpiece, tool.transform_point3(self.tool_mm));
        let actual = into_frame(&workpiece_actual, tool_actual.transform_point3(self.tool_mm));
        (workpiece.matrix3 * (actual - ideal)).to_array()
    }

    /// Error of tool tip and tool direction; arguments as for [`Geometry::tip_error`].
    pub fn pose_error(&self, position: &[f64; AXES], reverse: &[f64; AXES]) -> PoseError {
        let (workpiece, workpiece_actual) = side(&self.workpiece, position, reverse);
        let (tool, tool_actual) = side(&self.tool, position, reverse);
        let ideal = workpiece.matrix3.transpose() * tool.matrix3.z_axis;
        let actual = workpiece_actual.matrix3.transpose() * tool_actual.matrix3.z_axis;
        PoseError {
            tip_mm: self.tip_error(position, reverse),
            direction: (workpiece.matrix3 * (actual - ideal)).to_array(),
        }
    }

    /// Where the tool really is in the workpiece's frame; arguments as for [`Geometry::tip_error`].
    pub fn actual_pose(&self, position: &[f64; AXES], reverse: &[f64; AXES]) -> ToolPose {
        let (_, workpiece) = side(&self.workpiece, position, reverse);
        let (_, tool) = side(&self.tool, position, reverse);
        self.pose(&workpiece, &tool)
    }

    /// Where the tool of a perfect machine would be in the workpiece's frame at `position`.
    pub fn ideal_pose(&self, position: &[f64; AXES]) -> ToolPose {
        let (workpiece, _) = side(&self.workpiece, position, &[0.0; AXES]);
        let (tool, _) = side(&self.tool, position, &[0.0; AXES]);
        self.pose(&workpiece, &tool)
    }

    fn pose(&self, workpiece: &DAffine3, tool: &DAffine3) -> ToolPose {
        ToolPose {
            tip_mm: into_frame(workpiece, tool.transform_point3(self.tool_mm)).to_array(),
            direction: (workpiece.matrix3.transpose() * tool.matrix3.z_axis).to_array(),
        }
    }
}

impl Carriage {
    fn new(slot: usize, settings: &AxisSettings, table: Option<&Table>, on_workpiece: bool) -> Carriage {
        let rotary = settings.axis.is_rotary();
        let sign = if on_workpiece { -1.0 } else { 1.0 };
        Carriage {
            slot,
            rotary,
            along: unit(settings.axis),
            motion: if rotary { f64::from(settings.direction) } else { sign },
            sign,
            table: table.map(|table| ErrorTable::new(settings, &table.rows)),
            constant: [0.0; 6],
            per_position: [0.0; 6],
            own: settings.axis.index(),
            backlash: if rotary { settings.backlash.to_radians() } else { settings.backlash },
            lever: DVec3::ZERO,
            own_lever: if on_workpiece && !rotary { 1.0 } else { 0.0 },
        }
    }

    fn add_location_errors(&mut self, axis: Axis, location: &LocationErrors) {
        match axis {
            Axis::X => {}
            Axis::Y => self.per_position[0] -= location.c0y,
            Axis::Z => {
                self.per_position[0] += location.b0z;
                self.per_position[1] -= location.a0z;
            }
            Axis::A => self.constant = location.rotary[0],
            Axis::B => self.constant = location.rotary[1],
            Axis::C => self.constant = location.rotary[2],
        }
    }

    fn add_thermal_growth(&mut self, settings: &AxisSettings, rise_k: f64) {
        let growth = &settings.thermal;
        let unit = if self.rotary { 1f64.to_radians() } else { 1.0 };
        let slope = unit * rise_k * growth.expansion_per_k;
        self.per_position[self.own] += slope;
        self.constant[self.own] += unit * rise_k * growth.offset_per_k - slope * growth.datum;
    }

    /// Translations (mm) and rotations (rad) at the axis frame's origin, tool relative to workpiece.
    fn errors(&self, q: f64, reverse: f64) -> (DVec3, DVec3) {
        let table = self.table.as_ref().map_or([0.0; 6], |table| table.at(q, reverse));
        let turn = DVec3::new(table[3], table[4], table[5]);
        let shift = turn.cross(self.lever + self.along * (self.own_lever * q));
        let mut sum: Twist = std::array::from_fn(|i| table[i] + self.constant[i] + self.per_position[i] * q);
        sum[self.own] += reverse * self.backlash;
        let [ex, ey, ez, ea, eb, ec] = sum;
        (DVec3::new(ex, ey, ez) - shift, DVec3::new(ea, eb, ec))
    }
}

/// Ideal and actual transform from the last frame of a side to the bed.
fn side(carriages: &[Carriage], position: &[f64; AXES], reverse: &[f64; AXES]) -> (DAffine3, DAffine3) {
    let mut ideal = DAffine3::IDENTITY;
    let mut actual = DAffine3::IDENTITY;
    for carriage in carriages {
        let q = position[carriage.slot];
        let (e, w) = carriage.errors(q, reverse[carriage.slot]);
        let error = DAffine3 { matrix3: rotation(w * carriage.sign), translation: e * carriage.sign };
        if carriage.rotary {
            let turn = DMat3::from_axis_angle(carriage.along, (carriage.motion * q).to_radians());
            ideal.matrix3 *= turn;
            actual *= DAffine3 { matrix3: error.matrix3 * turn, translation: error.translation };
        } else {
            let travel = carriage.along * (carriage.motion * q);
            ideal.translation += ideal.matrix3 * travel;
            actual *= DAffine3 { matrix3: error.matrix3, translation: error.translation + travel };
        }
    }
    (ideal, actual)
}

/// A point of the bed in the coordinates of `frame`.
fn into_frame(frame: &DAffine3, point: DVec3) -> DVec3 {
    frame.matrix3.transpose() * (point - frame.translation)
}

/// Rotation matrix of a rotation vector (Rodrigues).
///
/// Below 0.01 rad sin θ/θ and (1 − cos θ)/θ² are the first three terms of their series, exact to the last bit.
fn rotation(w: DVec3) -> DMat3 {
    let square = w.length_squared();
    let (a, b) = if square < 1e-4 {
        (1.0 - square / 6.0 * (1.0 - square / 20.0), 0.5 - square / 24.0 * (1.0 - square / 30.0))
    } else {
        let angle = square.sqrt();
        (angle.sin() / angle, (1.0 - angle.cos()) / square)
    };
    let cross = DMat3::from_cols(DVec3::new(0.0, w.z, -w.y), DVec3::new(-w.z, 0.0, w.x), DVec3::new(w.y, -w.x, 0.0));
    let outer = DMat3::from_cols(w * w.x, w * w.y, w * w.z);
    DMat3::from_diagonal(DVec3::splat(1.0 - b * square)) + cross * a + outer * b
}

fn unit(axis: Axis) -> DVec3 {
    match axis {
        Axis::X | Axis::A => DVec3::X,
        Axis::Y | Axis::B => DVec3::Y,
        Axis::Z | Axis::C => DVec3::Z,
    }
}

/// Axes in the order of the code, and whether they carry the workpiece.
fn structural_code(chain: &str) -> Result<Vec<(Axis, bool)>, GeometryError> {
    let wrong = |found: Option<char>, needed| GeometryError::Chain {
        chain: chain.to_owned(),
        found: found.map_or("the end".to_owned(), |c| format!("'{c}'")),
        needed,
    };
    let mut code = chain.chars().filter(|c| !c.is_whitespace()).peekable();
    match code.next() {
        Some('w') => {}
        other => return Err(wrong(other, "'w' first")),
    }
    let mut links = Vec::new();
    let mut on_workpiece = true;
    loop {
        let next = code.next();
        match next {
            Some('b') if on_workpiece => on_workpiece = false,
            Some('t') if !on_workpiece => break,
            Some(letter) => {
                let axis = Axis::from_letter(letter).ok_or_else(|| wrong(next, "an axis letter, 'b' or 't'"))?;
                let primed = code.next_if_eq(&'\'').is_some();
                if primed != on_workpiece {
                    return Err(wrong(next, "a prime on every axis between w and b, none between b and t"));
                }
                links.push((axis, on_workpiece));
            }
            None => return Err(wrong(None, "'b' and 't'")),
        }
    }
    match code.next() {
        None => Ok(links),
        other => Err(wrong(other, "nothing after 't'")),
    }
}
