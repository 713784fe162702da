//! The volumetric model: the twist of every axis, transferred to the tool tip by its lever.
//!
//! An axis at its position has three translations e (mm) and three rotations w (rad), tool relative to workpiece, in the
//! directions of its carrier (its neighbour towards the bed) and at the origin of its moved frame. The tip's error and
//! the tool's rotation in bed axes are
//!
//! ```text
//! d = Σ_i R_i e_i + (R_i w_i) × (p − o_i)          orientation = Σ_i R_i w_i
//! ```
//!
//! R_i is the orientation of i's carrier, o_i the origin of i's moved frame, p the tip. The sum is formed from either end
//! of the chain inwards: (v, w) is the twist of everything further out, at the origin of the current frame. An axis adds
//! its own twist, then the point of reference moves to its carrier's origin, `v ← v − w × (o_i − o_carrier)`; a rotary
//! axis first turns v, w (and the tip) by its pose. Tables state the tool relative to the workpiece whichever side moves,
//! so the two sides add: `d = v_t + v_w + (w_t + w_w) × p`.
//!
//! Without `measured_at_mm` (zero), a table applies at the origin of the axis' moved frame. With it, its translations are
//! the readings at a tool of length zero with the other slides there, so `e = e_measured − w × l`, l the position of that
//! point from the axis' frame. The constant part of l is in the table's polynomials; the axis' own position, part of l if
//! a slide carries the workpiece, cancels the travel of the slide's own twist.
//!
//! First order in the errors: at 60 µrad and a lever of half a metre the neglected terms are some nanometres. Squareness
//! tilts the direction of travel, not the carriage. Rotary poses are nominal, computed without libm.
//!
//! Source: ISO 230-1:2012 (errors, signs), ISO 10791-6:2014 (structural code).

#![deny(clippy::indexing_slicing)]

mod cache;
mod carriages;
mod inverse;
mod key;
mod slides;
mod tangent;
mod walk;

use super::grid::{Grids, Sum};
use super::query::Query;
use super::reversal::Direction;
use super::table::{AxisTable, requirement_of_all};
use super::thermal::ThermalLine;
use super::{PoseError, Squareness};
use crate::error::{ConfigError, Field};
use crate::machine::{Axis, AxisOrder, Lines, Lookup, MachineSettings, Rows, Twist};
use crate::part::{self, Part, Presence};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;
pub(crate) use cache::{Cycle, TangentCache};
use carriages::{Carriages, Poses, about};
use inverse::Fade;
pub(crate) use inverse::{LEAST_DETERMINANT, LEAST_FADE};

/// Tables of a machine in the volumetric form, and its chain: immutable, built once.
///
/// `N` axes: X, Y, Z first (an absent linear axis is a zero table), then the rotary axes of the chain.
#[derive(Clone, Copy, Debug)]
pub struct Volumetric<'a, R, P, const N: usize> {
    tables: [AxisTable<'a, R, P, 6>; N],
    /// Whether to look up at the feedback: the axis' own error, its cross terms.
    at_feedback: [(bool, bool); N],
    own: [usize; N],
    /// Position of each table's origin from machine zero, and of the thermal datum from that origin.
    origins: [R; N],
    datum: [R; N],
    squareness: Squareness<R>,
    /// Location errors of the rotary axes.
    constant: [Twist<R>; N],
    /// Whether every table is equidistant, linear and looked up at the command, and no rotary axis is corrected.
    plain: bool,
    chain: Carriages<R, N>,
    /// If the tool's direction is corrected: how the correction fades at the singular pose.
    orientation: Option<Fade<R>>,
    /// Largest correction of each axis, mm (deg).
    most: [R; N],
    /// Key of all this data.
    key: u64,
    /// Whether everything is looked up at the command.
    at_command: bool,
    /// Whether the slides run along the bed's axes and no rotary axis is corrected.
    upright: bool,
    /// Upper bound of every lever, mm, and how far a tangent may extend beyond a point of each table, mm (deg).
    longest: R,
    overlaps: [R; N],
    /// For three slides: width of the boxes, mm, and whether anything but products is curved in them.
    width: R,
    curved: bool,
    part: part::Volumetric,
}

/// Translations and rotations of a twist.
#[inline(always)]
fn halves<R: Real>([x, y, z, a, b, c]: Twist<R>) -> (V3<R>, V3<R>) {
    (V3::new(x, y, z), V3::new(a, b, c))
}

// Only with volumetric.
impl<'a, R: Real, P: Position, const N: usize> Volumetric<'a, R, P, N> {
    /// Memory that [`Volumetric::build`] needs, in scalars.
    pub fn requirement<'r, T: Rows + ?Sized + 'r>(
        machine: &MachineSettings,
        rows: impl Fn(Axis) -> Option<&'r T>,
    ) -> usize {
        requirement_of_all::<6, T>(machine, rows)
    }

    /// Builds the tables of a machine in borrowed memory.
    ///
    /// # Errors
    /// A table with fewer than two points or not ascending, memory too small, a structural code that cannot be read,
    /// more axes than `N`.
    pub fn build<'r, T: Rows + ?Sized + 'r>(
        order: &AxisOrder<N>,
        machine: &MachineSettings,
        rows: impl Fn(Axis) -> Option<&'r T>,
        mut memory: &'a mut [R],
    ) -> Result<Self, ConfigError> {
        let part = part::VOLUMETRIC.ok_or_else(|| ConfigError::left_out(Part::Volumetric, Field::Model))?;
        let axes = order.axes();
        let (mut chain, levers) = Carriages::build(order, machine)?;
        let mut tables = [AxisTable::zero(); N];
        let mut at_feedback = [(false, false); N];
        let mut most = [R::ZERO; N];
        let (mut origins, mut datum) = ([R::ZERO; N], [R::ZERO; N]);
        let mut constant = [[R::ZERO; 6]; N];
        let mut plain = !machine.compensation.orientation;
        let mut at_command = true;
        let longest = tangent::longest(machine, &rows);
        let mut overlaps = [R::ZERO; N];
        let mut bends = [R::ZERO; N];
        let mut curved = false;
        for (slot, (axis, lever)) in axes.into_iter().zip(levers).enumerate() {
            let Some(settings) = machine.axis(axis) else { continue };
            let located = machine.location.of(axis).copied().unwrap_or_default();
            let (table, apart): (AxisTable<'a, R, P, 6>, _) = match Lines::of(machine, &rows, settings) {
                Some((lines, settings)) => {
                    (AxisTable::build_twists(&settings, &lines, lever, located, &mut memory)?, [0.0; 6])
                }
                None => (AxisTable::zero(), located),
            };
            if let Some(most) = most.get_mut(slot) {
                *most = R::of(settings.limits.magnitude);
            }
            let feedback = (settings.lookup == Lookup::Feedback, settings.cross_lookup == Lookup::Feedback);
            at_command &= feedback == (false, false);
            plain &= table.is_even() && feedback == (false, false) && apart == [0.0; 6];
            if let Some(overlap) = overlaps.get_mut(slot) {
                *overlap = tangent::overlap(table.largest_kinks(), longest);
            }
            if let Some(bend) = bends.get_mut(slot) {
                *bend = halves(table.largest_bends()).1.norm();
            }
            curved |= !table.is_straight();
            let origin = table.origin().to_f64();
            chain.set_origin(slot, origin);
            if let (Some(slot), Some(at), Some(from), Some(q0)) =
                (tables.get_mut(slot), at_feedback.get_mut(slot), origins.get_mut(slot), datum.get_mut(slot))
            {
                (*slot, *at, *from, *q0) = (table, feedback, R::of(origin), R::of(settings.thermal.datum - origin));
            }
            if let Some(slot) = constant.get_mut(slot) {
                *slot = apart.map(R::of);
            }
        }
        let settings = &machine.compensation;
        let orientation = settings.orientation.then(|| Fade::from_deg(settings.fade_deg));
        let upright = orientation.is_none() && !chain.turned;
        let width = slides::width(&chain.beyond, &bends);
        let curved = curved || chain.carries_itself();
        Ok(Volumetric {
            tables,
            at_feedback,
            // A spare slot counts as a slide that stands still: as a rotary axis it would narrow the tangents' boxes.
            own: axes.map(|axis| machine.axis(axis).map_or(axis.index() % 3, |own| own.axis.index())),
            origins,
            datum,
            squareness: Squareness::of(&machine.location),
            constant,
            plain,
            chain,
            orientation,
            most,
            key: key::of(order, machine, &rows),
            at_command,
            upright,
            longest: R::of(longest),
            overlaps,
            width,
            curved,
            part,
        })
    }

    /// Does nothing; unreachable in a build without the model.
    #[inline(always)]
    pub(crate) fn exists(&self) {
        self.part.exists();
    }

    /// Converts positions to table coordinates.
    #[inline(always)]
    pub fn coordinates(&self, positions: &[P; N]) -> [R; N] {
        let mut at = [R::ZERO; N];
        for ((at, table), position) in at.iter_mut().zip(&self.tables).zip(positions) {
            *at = table.coordinate(*position);
        }
        at
    }

    /// Position of each table's origin from machine zero, mm (deg).
    pub(crate) fn origins(&self) -> &[R; N] {
        &self.origins
    }

    /// X, Y, Z from machine zero, mm, from table coordinates.
    #[inline(always)]
    pub(crate) fn slides(&self, at: &[R; N]) -> [R; 3] {
        let mut slides = [R::ZERO; 3];
        for ((q, at), origin) in slides.iter_mut().zip(at).zip(&self.origins) {
            *q = *at + *origin;
        }
        slides
    }

    /// Errors that grids add at table coordinates.
    #[inline(never)]
    pub(super) fn of_grids(&self, grids: &Grids<'_, R>, at: &[R; N]) -> Sum<R> {
        if grids.swings() { self.swung(grids, at, &self.chain.poses(at)) } else { grids.of_slides(&self.slides(at)) }
    }

    /// [`Volumetric::of_grids`] if rotary axes turn the levers, in their poses.
    pub(super) fn swung(&self, grids: &Grids<'_, R>, at: &[R; N], poses: &Poses<R, N>) -> Sum<R> {
        let mut tip = self.chain.tool;
        for carriage in self.chain.tool_side() {
            let q = at.get(carriage.slot).copied().unwrap_or(R::ZERO)
                + self.origins.get(carriage.slot).copied().unwrap_or(R::ZERO);
            match carriage.axis {
                Axis::X => tip.x += q,
                Axis::Y => tip.y += q,
                Axis::Z => tip.z += q,
                Axis::A | Axis::B | Axis::C => {
                    let pose = poses.get(carriage.slot).copied().unwrap_or((R::ONE, R::ZERO));
                    tip = tip.turned(about(carriage.axis), pose) + carriage.offset;
                }
            }
        }
        grids.at_tip(&self.slides(at), tip)
    }

    /// Whether every table is looked up at the command.
    pub(crate) fn is_at_command(&self) -> bool {
        self.at_command
    }

    /// Unit vector along the tool, from the tip to the spindle, in bed axes at a position.
    pub fn tool_axis(&self, at: &[R; N]) -> R::Vec3 {
        self.chain.directions(&self.chain.poses(at)).1.glam()
    }

    /// Returns the error of the tool's pose at a position: tip in mm, rotation in rad, bed axes.
    ///
    /// Takes positions from [`Volumetric::coordinates`]; sets a bit in `clamped` for every axis whose edge value is
    /// clamped.
    #[inline(always)]
    pub fn pose_error(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> PoseError<R> {
        self.pose_error_at(query.command, query.directions, query.thermal, clamped)
    }

    /// All lookups at one position. Arguments stay in registers across the call; a [`Query`] would go through memory.
    #[inline(never)]
    fn pose_error_at(
        &self,
        at: &[R; N],
        directions: &[Direction; N],
        thermal: &[ThermalLine<R>; N],
        clamped: &mut u8,
    ) -> PoseError<R> {
        let query = &Query::at(at, directions, thermal);
        if self.plain {
            return self.plain_pose_error(query, clamped);
        }
        if N == 3 && self.at_command {
            return self.slides_at_command::<false>(query, clamped);
        }
        let mut twists = [[R::ZERO; 6]; N];
        self.look_up(0..N, query, &mut twists, clamped);
        self.carried(query, &self.chain.poses(query.command), &twists)
    }

    /// Twists of all axes from plain tables, at the command.
    #[inline(always)]
    fn look_up_plain(&self, query: &Query<'_, R, N>, twists: &mut [Twist<R>; N], clamped: &mut u8) {
        let Query { command: at, directions: reverse, .. } = *query;
        let mut bit = 1;
        for (((twist, table), at), reverse) in twists.iter_mut().zip(&self.tables).zip(at).zip(reverse) {
            let (found, edge) = table.at_plain(*at, *reverse);
            *twist = found;
            if edge {
                *clamped |= bit;
            }
            bit <<= 1;
        }
    }

    /// Twists of some axes, each looked up at the command or the feedback as configured.
    #[inline(always)]
    fn look_up(
        &self,
        slots: core::ops::Range<usize>,
        query: &Query<'_, R, N>,
        twists: &mut [Twist<R>; N],
        clamped: &mut u8,
    ) {
        let Query { command, feedback, directions: reverse, .. } = *query;
        for slot in slots {
            let (Some(table), Some(command), Some(feedback), Some(reverse)) =
                (self.tables.get(slot), command.get(slot), feedback.get(slot), reverse.get(slot))
            else {
                continue;
            };
            let (Some(twist), Some((own_feedback, cross_feedback)), Some(own)) =
                (twists.get_mut(slot), self.at_feedback.get(slot), self.own.get(slot))
            else {
                continue;
            };
            let (found, mut edge) = table.at(if *cross_feedback { *feedback } else { *command }, *reverse);
            *twist = found;
            if own_feedback != cross_feedback {
                let (found, own_edge) = table.at(if *own_feedback { *feedback } else { *command }, *reverse);
                edge |= own_edge;
                if let (Some(to), Some(from)) = (twist.get_mut(*own), found.get(*own)) {
                    *to = *from;
                }
            }
            if edge {
                *clamped |= 1 << (slot & 7);
            }
        }
    }
}

#[cfg(test)]
mod tests;
