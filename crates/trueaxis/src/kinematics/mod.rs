//! Transforms axis positions to the tool in workpiece coordinates, and back.
//!
//! With the structural code read from the workpiece to the tool, and the offsets of all carriages between two rotary axes
//! added up, every machine with up to two rotary axes satisfies
//!
//! ```text
//! p_w = k0 + L0 + Rot(n1, s1 q1) · (k1 + L1 + Rot(n2, s2 q2) · (k2 + L2 + tool))
//! t_w =           Rot(n1, s1 q1) ·            Rot(n2, s2 q2) · t0
//! ```
//!
//! n1 is the rotary axis nearest the workpiece *in the code*, whichever side of the bed it is on; L0, L1, L2 are the positions
//! of the linear axes before, between and behind the rotary ones; k are their offsets. A positive command moves the tool along
//! +n over the workpiece on both sides. s is the axis's `direction` on the tool side and the opposite on the workpiece side,
//! where the carriage turns and the tool turns oppositely over the workpiece.
//!
//! Positions are six numbers in the order X Y Z A B C, mm and degrees; axes that the machine does not have are ignored. Every
//! function is bounded, allocates nothing and calls no transcendental function of a library.
//!
//! Source: ISO 10791-6:2014 (structural code).

#![deny(clippy::indexing_slicing)]

mod branch;
mod branch_tracker;
mod chain;
mod error;
mod inverse;

pub use branch::Branch;
pub use branch_tracker::BranchTracker;
pub use error::InverseError;
pub use inverse::Solution;

bench!(use inverse::{Choice, Solutions});

use crate::compensation::trig::{atan2, cos_sin_deg};
use crate::error::{ConfigError, Field};
use crate::machine::{AXES, Axis, MachineSettings};
use crate::part::Part;
use crate::real::Real;
use crate::vector::{About, V3};
use chain::{Chain, Rotary};

/// The tool in workpiece coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tool<R: Real> {
    /// Tip, mm.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub tip: R::Vec3,
    /// Unit vector from the tip to the spindle.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub axis: R::Vec3,
}

/// A machine's chain of axes, ready for transformations in both directions; immutable except for its tool.
#[derive(Clone, Copy, Debug)]
pub struct Kinematics<R> {
    chain: Chain<R>,
    /// Tip relative to the last tool-side frame at all axes zero, mm.
    tool: V3<R>,
    /// Tool axis at all axes zero.
    tool_axis: V3<R>,
    /// Within this distance from the singular pose the axis nearest the workpiece stays still or is guided, degrees.
    cone_deg: R,
}

impl<R: Real> Kinematics<R> {
    /// Reads the chain of a machine with X, Y, Z and up to two rotary axes.
    ///
    /// # Errors
    /// A structural code that cannot be parsed or does not fit the axes; a missing linear axis; three rotary axes; a second
    /// rotary axis parallel to the tool axis, so that it cannot turn the tool.
    #[doc(hidden)]
    pub fn new(machine: &MachineSettings) -> Result<Self, ConfigError> {
        if !Part::Rotary.is_built() {
            return Err(ConfigError::left_out(Part::Rotary, Field::ToolAxis));
        }
        let [x, y, z] = machine.kinematics.tool_axis;
        let length = libm::sqrt(x * x + y * y + z * z);
        if !(1e-3..=1e3).contains(&length) {
            return Err(ConfigError::new(Field::ToolAxis, length, "a tool_axis of a length of about 1"));
        }
        if let Some(bad) = machine.tool_mm.iter().find(|value| !value.is_finite()) {
            return Err(ConfigError::new(Field::Tool, *bad, "finite numbers"));
        }
        let cone = machine.kinematics.singular_cone_deg;
        if !(0.0..=45.0).contains(&cone) {
            return Err(ConfigError::new(Field::SingularCone, cone, "a singular_cone_deg of 0 to 45 degrees"));
        }
        let tool_axis = [x / length, y / length, z / length];
        Ok(Kinematics {
            chain: Chain::new(machine, tool_axis)?,
            tool: V3::of(machine.tool_mm),
            tool_axis: V3::of(tool_axis),
            cone_deg: R::of(cone),
        })
    }

    /// Replaces the tool: `tool_mm` is its tip relative to the last tool-side frame at all axes zero, mm.
    pub fn with_tool(self, tool_mm: impl Into<R::Vec3>) -> Self {
        Kinematics { tool: V3::from_glam(tool_mm.into()), ..self }
    }

    /// Replaces the tool by one on the tool axis through the origin of the last tool-side frame, with its tip `length_mm`
    /// before the origin: −length · tool axis. On a swivelling head without offset behind it, that is the pivot length.
    pub fn with_tool_length(self, length_mm: R) -> Self {
        Kinematics { tool: self.tool_axis * -length_mm, ..self }
    }

    /// Replaces the singular cone, degrees; clamped to 0 … 45.
    pub fn with_singular_cone_deg(self, cone_deg: R) -> Self {
        Kinematics { cone_deg: cone_deg.limit(R::ZERO, R::of(45.0)), ..self }
    }

    /// Tip relative to the last tool-side frame at all axes zero, mm.
    pub fn tool_mm(&self) -> R::Vec3 {
        self.tool.glam()
    }

    /// Tool axis at all axes zero, from the tip to the spindle; a unit vector.
    pub fn tool_axis(&self) -> R::Vec3 {
        self.tool_axis.glam()
    }

    /// Whether the machine has the axis.
    pub fn has(&self, axis: Axis) -> bool {
        !axis.is_rotary() || self.chain.turns.iter().flatten().any(|turn| turn.axis == axis)
    }

    /// Tip and direction of the tool in workpiece coordinates.
    ///
    /// Positions in the order X Y Z A B C, mm and degrees (|angle| <= 1e6). Error: rounding, 1e-12 mm (f64) at a metre.
    #[inline]
    pub fn forward(&self, axes: &[R; AXES]) -> Tool<R> {
        let [x, y, z, ..] = *axes;
        let travel = V3::new(x, y, z);
        let [first, second] = self.chain.turns.map(|turn| turn.map(|turn| (turn, turn.cos_sin(axes))));
        let [before, between, behind] = self.chain.sections.map(|section| section.shift(travel));
        let inner = turned(second, behind + self.tool);
        let tip = turned(first, inner + between) + before;
        Tool { tip: tip.glam(), axis: turned(first, turned(second, self.tool_axis)).glam() }
    }

    /// Direction of the tool in workpiece coordinates, from the tip to the spindle; depends on the rotary axes only.
    #[inline]
    pub fn direction(&self, axes: &[R; AXES]) -> R::Vec3 {
        let [first, second] = self.chain.turns.map(|turn| turn.map(|turn| (turn, turn.cos_sin(axes))));
        turned(first, turned(second, self.tool_axis)).glam()
    }

    /// Converts a direction from bed to workpiece coordinates.
    #[inline]
    pub fn to_workpiece(&self, axes: &[R; AXES], bed: R::Vec3) -> R::Vec3 {
        let [first, second] = self.chain.turns.map(|turn| {
            let turn = turn.filter(|turn| turn.carries_workpiece)?;
            Some((turn, turn.cos_sin(axes)))
        });
        turned(first, turned(second, V3::from_glam(bed))).glam()
    }

    /// Converts a direction from workpiece to bed coordinates: the inverse of [`Kinematics::to_workpiece`].
    #[inline]
    pub fn to_bed(&self, axes: &[R; AXES], workpiece: R::Vec3) -> R::Vec3 {
        let [first, second] = self.chain.turns.map(|turn| {
            let turn = turn.filter(|turn| turn.carries_workpiece)?;
            let (cos, sin) = turn.cos_sin(axes);
            Some((turn, (cos, -sin)))
        });
        turned(second, turned(first, V3::from_glam(workpiece))).glam()
    }
}

/// Margin reported for a machine without a singular pose, degrees.
const NO_SINGULAR_POSE: f64 = 90.0;

impl<R: Real> Kinematics<R> {
    /// Distance of a pose from the singular pose, 0 … 90 degrees; see [`Solution::singularity_margin_deg`].
    pub fn singularity_margin_deg(&self, axes: &[R; AXES]) -> R {
        let [Some(first), Some(second)] = self.chain.turns else { return R::of(NO_SINGULAR_POSE) };
        let inner = self.tool_axis.turned(second.about, second.cos_sin(axes));
        let [u, b, w] = in_frame(first.about, second.about, inner);
        degrees(atan2(w.abs(), (u * u + b * b).sqrt()))
    }
}

/// Components along n1, n2 and n1 × n2.
#[inline(always)]
fn in_frame<R: Real>(first: About, second: About, V3 { x, y, z }: V3<R>) -> [R; 3] {
    match (first, second) {
        (About::X, About::Y) => [x, y, z],
        (About::X, _) => [x, z, -y],
        (About::Y, About::Z) => [y, z, x],
        (About::Y, _) => [y, x, -z],
        (About::Z, About::X) => [z, x, y],
        (About::Z, _) => [z, y, -x],
    }
}

#[inline(always)]
fn degrees<R: Real>(radians: R) -> R {
    radians * R::of(180.0 / core::f64::consts::PI)
}

/// `v` turned by an axis, if any.
#[inline(always)]
fn turned<R: Real>(turn: Option<(Rotary<R>, (R, R))>, v: V3<R>) -> V3<R> {
    match turn {
        Some((turn, angle)) => v.turned(turn.about, angle),
        None => v,
    }
}

impl<R: Real> Rotary<R> {
    /// Position of this axis, degrees.
    #[inline(always)]
    fn position(&self, axes: &[R; AXES]) -> R {
        let [_, _, _, a, b, c] = *axes;
        match self.axis {
            Axis::A => a,
            Axis::B => b,
            _ => c,
        }
    }

    /// Cosine and sine of the turn relative to the workpiece.
    #[inline(always)]
    fn cos_sin(&self, axes: &[R; AXES]) -> (R, R) {
        cos_sin_deg(self.sense * self.position(axes))
    }
}
