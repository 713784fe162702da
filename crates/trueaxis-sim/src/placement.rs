//! Converts programmed points to axis positions, and those to tool positions, by the exact geometry of a perfect machine.
//!
//! Workpiece coordinates are those of the workpiece's frame, which coincides with the machine's while all axes are at zero.
//! The program's zero is the position of the tool tip with X, Y, Z at the origin and the rotary axes at zero. With the rotary
//! axes at zero or at whole turns, a programmed position is the same point with and without tool centre point mode.

use crate::program::Move;
use glam::{DMat3, DVec3};
use trueaxis::machine::AXES;
use trueaxis_tables::Machine;
use trueaxis_tables::exact::{Geometry, GeometryError};

/// Step of numerical derivatives, share of a move.
const STEP: f64 = 1.0e-4;

/// Tool tip and unit tool direction in workpiece coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Tip.
    pub tip: DVec3,
    /// Direction from the tip to the spindle.
    pub direction: DVec3,
}

/// Derivatives of the axis positions (X, Y, Z, A, B, C) with respect to the length of [`Move::length`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates {
    /// mm per unit of length.
    pub(crate) linear: DVec3,
    /// Degrees per unit of length.
    pub(crate) rotary: DVec3,
    /// Second derivative of X, Y, Z that results from rotation under the tool centre point.
    pub(crate) bend: DVec3,
}

/// A perfect machine and a program's zero on it.
#[derive(Clone, Debug)]
pub struct Placement {
    geometry: Geometry,
    /// Index of each axis X Y Z A B C among the machine's.
    slots: [Option<usize>; AXES],
    origin: DVec3,
    /// Tool tip in workpiece coordinates with all axes at zero.
    zero_tip: DVec3,
    max_feed_per_s: [f64; AXES],
}

impl Placement {
    /// A machine without errors, its program zero at `origin_mm` of X, Y, Z.
    ///
    /// # Errors
    /// The machine's structural code cannot be read.
    pub fn new(machine: &Machine, origin_mm: [f64; 3]) -> Result<Placement, GeometryError> {
        let mut placement = Placement {
            geometry: Geometry::new(machine, 0.0)?,
            slots: [None; AXES],
            origin: DVec3::from(origin_mm),
            zero_tip: DVec3::ZERO,
            max_feed_per_s: [f64::INFINITY; AXES],
        };
        for (slot, own) in machine.settings.axes.iter().enumerate() {
            placement.slots[own.axis.index()] = Some(slot);
            placement.max_feed_per_s[own.axis.index()] = own.max_feed_per_s;
        }
        placement.zero_tip = placement.place_of(&[0.0; AXES]).tip;
        Ok(placement)
    }

    /// Program zero in workpiece coordinates, mm.
    pub fn zero(&self) -> DVec3 {
        self.origin + self.zero_tip
    }

    /// Highest feed of each axis, mm/s or deg/s; infinite for an axis that the machine does not have.
    pub(crate) fn max_feed_per_s(&self) -> &[f64; AXES] {
        &self.max_feed_per_s
    }

    /// The tool of the perfect machine with X, Y, Z, A, B, C at `axes` (mm, degrees).
    pub fn place_of(&self, axes: &[f64; AXES]) -> Place {
        let mut position = [0.0; AXES];
        for (slot, q) in self.slots.iter().zip(axes) {
            if let Some(to) = slot.and_then(|s| position.get_mut(s)) {
                *to = *q;
            }
        }
        let pose = self.geometry.ideal_pose(&position);
        Place { tip: DVec3::from(pose.tip_mm), direction: DVec3::from(pose.direction) }
    }

    /// Positions of X, Y, Z, A, B, C at parameter `u` of a move, mm and degrees.
    ///
    /// Under the tool centre point X, Y, Z solve tip(X, Y, Z) = programmed point. With the rotary axes fixed the tip is affine
    /// in them: a linear system of three equations, exact to rounding (1e-12 mm at positions of a metre).
    pub fn axes(&self, step: &Move, u: f64) -> [f64; AXES] {
        let [a, b, c] = step.rotary(u);
        let programmed = DVec3::from(step.curve.position(u)) + self.origin;
        if !step.tool_center {
            return [programmed.x, programmed.y, programmed.z, a, b, c];
        }
        let tip = |x, y, z| self.place_of(&[x, y, z, a, b, c]).tip;
        let base = tip(0.0, 0.0, 0.0);
        let columns = [tip(1.0, 0.0, 0.0), tip(0.0, 1.0, 0.0), tip(0.0, 0.0, 1.0)].map(|end| end - base);
        let matrix = DMat3::from_cols(columns[0], columns[1], columns[2]);
        let linear = matrix.inverse() * (programmed + self.zero_tip - base);
        [linear.x, linear.y, linear.z, a, b, c]
    }

    /// Programmed tip and direction at parameter `u` of a move.
    pub fn place(&self, step: &Move, u: f64) -> Place {
        let [a, b, c] = step.rotary(u);
        if step.tool_center {
            let direction = self.place_of(&[0.0, 0.0, 0.0, a, b, c]).direction;
            return Place { tip: DVec3::from(step.curve.position(u)) + self.zero(), direction };
        }
        self.place_of(&self.axes(step, u))
    }

    /// d(tip)/du at parameter `u` of a move: central differences, accurate to 1e-7 of the speed.
    pub fn tip_velocity(&self, step: &Move, u: f64) -> DVec3 {
        if step.tool_center {
            return step.curve.vectors(u).1;
        }
        let (first, last) = step.curve.domain();
        let h = STEP * (last - first);
        (self.place(step, u + h).tip - self.place(step, u - h).tip) / (2.0 * h)
    }

    /// Derivatives of the axis positions along a move at parameter `u`.
    pub(crate) fn rates(&self, step: &Move, u: f64) -> Rates {
        let (first, last) = step.curve.domain();
        let width = last - first;
        let speed = if step.in_degrees() { step.turn.angle() / width } else { step.curve.speed(u) };
        let rotary = DVec3::from(step.turn.change) / (width * speed);
        let h = STEP * width;
        if !step.tool_center {
            return Rates { linear: step.curve.vectors(u).1 / speed, rotary, bend: DVec3::ZERO };
        }
        let linear = |u: f64| {
            let [x, y, z, ..] = self.axes(step, u);
            DVec3::new(x, y, z)
        };
        let (before, here, after) = (linear(u - h), linear(u), linear(u + h));
        let still = step.turn.change == [0.0; 3];
        let bend = if still { DVec3::ZERO } else { (before - 2.0 * here + after) / (h * h * speed * speed) };
        Rates { linear: (after - before) / (2.0 * h * speed), rotary, bend }
    }
}
