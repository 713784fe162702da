//! The mill-turn: table C turns the workpiece about z, head A turns the tool about x, and X, Y, Z carry the head.

use super::{Helicoid, LONGEST_MM};
use crate::error::{InputError, Quantity};

/// Pose of the head at A = 0. Both are the same machine: *vertical* is *horizontal* with the head turned by 90°.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// Spindle along +y at A = 0: t0 = [0, 1, 0].
    #[default]
    Horizontal,
    /// Spindle along +z at A = 0: t0 = [0, 0, 1].
    Vertical,
}

impl Form {
    /// Returns the direction t0 from the tool tip to the A axis at A = 0.
    pub const fn spindle(self) -> [f64; 3] {
        match self {
            Form::Horizontal => [0.0, 1.0, 0.0],
            Form::Vertical => [0.0, 0.0, 1.0],
        }
    }
}

/// The two pairs (A, C) that align the tool axis with the normal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Branch {
    /// C = −φ; A = γ (vertical) or 90° + γ (horizontal).
    #[default]
    First,
    /// C = 180° − φ; A = −γ (vertical) or 90° − γ (horizontal).
    Second,
}

/// The machine and the set-up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineSettings {
    /// Pose of the head at A = 0.
    pub form: Form,
    /// Pivot length L, tool tip to A axis, mm; 0 to 1e6. [`pivot_length`] computes it from an edge finder's reading.
    pub pivot_mm: f64,
    /// Sense of the A axis: 1 if positive A turns the tool right-handed about +x, otherwise −1.
    pub direction_a: i8,
    /// Sense of the C axis: 1 if positive C turns the workpiece right-handed about +z, otherwise −1.
    pub direction_c: i8,
    /// Position w of the gear's origin in the table's frame, mm; turns with C.
    pub work_offset_mm: [f64; 3],
}

/// Positions of the five axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// X, Y, Z, mm.
    pub linear_mm: [f64; 3],
    /// A, degrees.
    pub a_deg: f64,
    /// C, degrees; not wrapped.
    pub c_deg: f64,
}

/// Pose of a tool in the gear's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPose {
    /// Tip, mm.
    pub tip_mm: [f64; 3],
    /// Unit vector from the tip to the A axis.
    pub axis: [f64; 3],
}

/// A validated head-table machine.
///
/// At A = 0 and C = 0, X, Y, Z are the tip's position in the table's frame, whose origin is on the C axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadTable {
    form: Form,
    pivot: f64,
    sense_a: f64,
    sense_c: f64,
    offset: [f64; 3],
}

impl HeadTable {
    /// Validates the settings.
    ///
    /// # Errors
    /// A pivot length that is negative, beyond 1e6 mm or not finite; a sense other than ±1; a work offset beyond 1e6 mm or not
    /// finite.
    pub fn new(settings: &MachineSettings) -> Result<HeadTable, InputError> {
        let MachineSettings { form, pivot_mm, direction_a, direction_c, work_offset_mm } = *settings;
        if !(0.0..=LONGEST_MM).contains(&pivot_mm) {
            return Err(InputError::new(Quantity::Pivot, pivot_mm, "a length from 0 to 1e6 mm"));
        }
        for (direction, axis) in [(direction_a, trueaxis::Axis::A), (direction_c, trueaxis::Axis::C)] {
            if direction != 1 && direction != -1 {
                return Err(InputError::new(Quantity::Direction, f64::from(direction), "1 or -1").on(axis));
            }
        }
        for (index, offset) in work_offset_mm.into_iter().enumerate() {
            if !(-LONGEST_MM..=LONGEST_MM).contains(&offset) {
                return Err(InputError::new(Quantity::WorkOffset, offset, "a length within ±1e6 mm").at(index));
            }
        }
        Ok(HeadTable {
            form,
            pivot: pivot_mm,
            sense_a: f64::from(direction_a),
            sense_c: f64::from(direction_c),
            offset: work_offset_mm,
        })
    }

    /// Computes the axis positions at which the tip is on the flank and the tool along its normal.
    ///
    /// ```text
    /// R_z(C) n = R_x(A) t0                      γ = atan2(p, r_b)
    ///   branch 1: C = −φ,        A = γ  (vertical),  90° + γ (horizontal)
    ///   branch 2: C = 180° − φ,  A = −γ (vertical),  90° − γ (horizontal)
    /// [X, Y, Z] = R_z(C) (F + w) + L (R_x(A) t0 − t0)
    /// ```
    ///
    /// The returned A and C are multiplied by the senses of their axes. C follows φ over any number of turns. Error below 1e-9
    /// mm and 1e-12 rad for radii up to 1000 mm and angles up to 100 rad: rounding only.
    ///
    /// # Errors
    /// u or θ outside the flank ([`Helicoid::contains`]).
    ///
    /// Source: parametric coordinates of a five-axis mill-turn (Nanjing Tech patent family); the publication measures the
    /// head's angle left-handed, A = −θ_A.
    pub fn place(&self, surface: &Helicoid, u: f64, theta: f64, branch: Branch) -> Result<Placement, InputError> {
        surface.contains(u, theta)?;
        let (phi, tilt) = (u + theta, surface.tilt());
        // A measured from the vertical pose, and the table's rotation.
        let (from_z, table) = match branch {
            Branch::First => (tilt, -phi),
            Branch::Second => (-tilt, core::f64::consts::PI - phi),
        };
        let [x, y, z] = about_z(table, add(surface.point(u, theta), self.offset));
        // R_x(A) t0 is the same direction in both forms: only the zero of A differs.
        let (sin, cos) = libm::sincos(from_z);
        let [_, rest_y, rest_z] = self.form.spindle();
        let quarter = match self.form {
            Form::Vertical => 0.0,
            Form::Horizontal => 90.0,
        };
        Ok(Placement {
            linear_mm: [x, y + self.pivot * (-sin - rest_y), z + self.pivot * (cos - rest_z)],
            a_deg: self.sense_a * (quarter + from_z.to_degrees()),
            c_deg: self.sense_c * table.to_degrees(),
        })
    }

    /// Computes the pose of the tool in the gear's frame at given axis positions: the forward transformation.
    ///
    /// axis = R_z(−C) R_x(A) t0, tip = R_z(−C) ([X, Y, Z] + L t0 − L R_x(A) t0) − w, with the senses removed from A and C.
    /// Rounding only; composed from the machine's joints from the A axis outward, not by inverting [`HeadTable::place`].
    pub fn tool(&self, axes: &Placement) -> ToolPose {
        let (a, c) = ((self.sense_a * axes.a_deg).to_radians(), (self.sense_c * axes.c_deg).to_radians());
        let rest = self.form.spindle();
        let pivot_point = add(axes.linear_mm, scaled(self.pivot, rest));
        let spindle = about_x(a, rest);
        let tip = add(pivot_point, scaled(-self.pivot, spindle));
        ToolPose { tip_mm: add(about_z(-c, tip), scaled(-1.0, self.offset)), axis: about_z(-c, spindle) }
    }
}

/// Computes the pivot length from an edge finder's reading.
///
/// L = a + r, mm. The tip touches a face in the vertical pose; the head is turned by 90° and the relative display of z zeroed;
/// then an edge finder with ball radius r moves along z by a until it touches the same face.
///
/// # Errors
/// a not finite or beyond 1e6 mm; r not above 0; a sum below 0.
///
/// Source: as [`HeadTable::place`].
pub fn pivot_length(travel_mm: f64, ball_radius_mm: f64) -> Result<f64, InputError> {
    if !(-LONGEST_MM..=LONGEST_MM).contains(&travel_mm) {
        return Err(InputError::new(Quantity::EdgeFinder, travel_mm, "a travel within ±1e6 mm"));
    }
    if !(ball_radius_mm > 0.0 && ball_radius_mm <= LONGEST_MM) {
        return Err(InputError::new(Quantity::EdgeFinderRadius, ball_radius_mm, "a ball radius above 0 mm"));
    }
    let length = travel_mm + ball_radius_mm;
    if length < 0.0 {
        return Err(InputError::new(Quantity::Pivot, length, "a travel and a ball radius with a sum from 0"));
    }
    Ok(length)
}

fn add([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [a + x, b + y, c + z]
}

fn scaled(s: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    [s * x, s * y, s * z]
}

/// Right-handed rotation about z, rad.
fn about_z(angle: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = libm::sincos(angle);
    [cos * x - sin * y, sin * x + cos * y, z]
}

/// Right-handed rotation about x, rad.
fn about_x(angle: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = libm::sincos(angle);
    [x, cos * y - sin * z, sin * y + cos * z]
}
