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

mod carriages;
mod inverse;
mod kept;
mod key;
mod slides;
mod tangent;

use super::PoseError;
use super::grid::{Grids, Sum};
use super::query::Query;
use super::reversal::Direction;
use super::table::{AxisTable, requirement_of_all};
use super::thermal::ThermalLine;
use super::trig::coarse_cos_sin_deg;
use crate::error::{ConfigError, Field};
use crate::machine::{Axis, Lookup, MachineSettings};
use crate::machine::{AxisOrder, Lines, Rows, Twist};
use crate::part::{self, Part, Presence};
use crate::position::Position;
use crate::real::Real;
use crate::vector::{About, V3};
use carriages::{Carriage, Carriages, Poses, about};
use inverse::Fade;
pub(crate) use inverse::{LEAST_DETERMINANT, LEAST_FADE};
pub(crate) use kept::{Cycle, Kept};

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
    /// C0Y, B0Z, A0Z.
    squareness: [R; 3],
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

/// Twist of a side at the origin of the frame that the walk has reached.
#[derive(Clone, Copy, Debug)]
struct Side<R> {
    v: V3<R>,
    w: V3<R>,
}

impl<R: Real> Side<R> {
    #[inline(always)]
    fn add(&mut self, (e, w): (V3<R>, V3<R>)) {
        self.v += e;
        self.w += w;
    }

    /// Moves the point of reference against a travel along X, Y or Z: `v ← v − w × travel`.
    #[inline(always)]
    fn slide(&mut self, axis: Axis, travel: R) {
        let V3 { x, y, z } = self.w;
        match axis {
            Axis::X | Axis::A => self.v -= V3::new(R::ZERO, z * travel, -(y * travel)),
            Axis::Y | Axis::B => self.v -= V3::new(-(z * travel), R::ZERO, x * travel),
            Axis::Z | Axis::C => self.v -= V3::new(y * travel, -(x * travel), R::ZERO),
        }
    }

    /// A slide that carries the workpiece shifts everything further out by −q, and its own twist too unless that is
    /// fixed.
    #[inline(always)]
    fn carry(&mut self, carriage: &Carriage<R>, q: R, twist: (V3<R>, V3<R>)) {
        if carriage.fixed {
            self.slide(carriage.axis, -q);
            self.add(twist);
        } else {
            self.add(twist);
            self.slide(carriage.axis, -q);
        }
    }

    /// Moves from a rotary axis' frame into its carrier's and adds the axis' own twist.
    #[inline(always)]
    fn turn(&mut self, carriage: &Carriage<R>, pose: (R, R), (e, w): (V3<R>, V3<R>)) {
        self.v = self.v.turned(about(carriage.axis), pose) + e;
        self.w = self.w.turned(about(carriage.axis), pose) + w;
        if carriage.is_offset {
            self.v -= self.w.cross(carriage.offset);
        }
    }
}

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
        let location = &machine.location;
        Ok(Volumetric {
            tables,
            at_feedback,
            own: axes.map(Axis::index),
            origins,
            datum,
            squareness: [location.c0y, location.b0z, location.a0z].map(R::of),
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
        let mut twists = [[R::ZERO; 6]; N];
        self.look_up(0..N, query, &mut twists, clamped);
        self.carried(query, &self.chain.poses(query.command), &twists)
    }

    /// Without rotary axes the lever of every twist is the sum of the travels beyond it; the tool is in the tables.
    #[inline(always)]
    fn plain_slides(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> PoseError<R> {
        let Query { command: at, directions: reverse, thermal, .. } = *query;
        let (mut d, mut orientation) = (V3::ZERO, V3::ZERO);
        let mut q = [R::ZERO; 3];
        for ((q, at), origin) in q.iter_mut().zip(at).zip(&self.origins) {
            *q = *at + *origin;
        }
        let [qx, qy, qz] = q;
        let mut bit = 1;
        for (((table, [bx, by, bz]), at), reverse) in self.tables.iter().zip(&self.chain.beyond).zip(at).zip(reverse) {
            let (twist, edge) = table.at_plain(*at, *reverse);
            if edge {
                *clamped |= bit;
            }
            bit <<= 1;
            let (e, w) = halves(twist);
            // Terms are added one by one, for processors with a multiply-add instruction.
            let (x, y, z) = (*bx * qx, *by * qy, *bz * qz);
            d = V3::new(d.x + e.x + w.y * z - w.z * y, d.y + e.y + w.z * x - w.x * z, d.z + e.z + w.x * y - w.y * x);
            orientation += w;
        }
        let mut growth = [R::ZERO; 3];
        for (((growth, at), line), datum) in growth.iter_mut().zip(at).zip(thermal).zip(&self.datum) {
            *growth = line.at(*at - *datum);
        }
        let [c0y, b0z, a0z] = self.squareness;
        d += V3::from(growth) + V3::new(b0z * qz - c0y * qy, -(a0z * qz), R::ZERO);
        PoseError { tip: d.glam(), orientation: orientation.glam() }
    }

    /// Twist and position of one axis from its plain table, plus the errors outside tables.
    #[inline(always)]
    fn read_plain(&self, carriage: &Carriage<R>, query: &Query<'_, R, N>, clamped: &mut u8) -> (V3<R>, V3<R>, R) {
        let slot = carriage.slot;
        let (Some(table), Some(at), Some(reverse), Some(line), Some(origin), Some(datum)) = (
            self.tables.get(slot),
            query.command.get(slot),
            query.directions.get(slot),
            query.thermal.get(slot),
            self.origins.get(slot),
            self.datum.get(slot),
        ) else {
            return (V3::ZERO, V3::ZERO, R::ZERO);
        };
        let (twist, edge) = table.at_plain(*at, *reverse);
        if edge {
            *clamped |= 1 << (slot & 7);
        }
        let ((mut e, mut w), q, growth) = (halves(twist), *at + *origin, line.at(*at - *datum));
        let [c0y, b0z, a0z] = self.squareness;
        match carriage.axis {
            Axis::X => e.x += growth,
            Axis::Y => {
                e.x -= c0y * q;
                e.y += growth;
            }
            Axis::Z => {
                e.x += b0z * q;
                e.y -= a0z * q;
                e.z += growth;
            }
            Axis::A => w.x += growth * R::of(core::f64::consts::PI / 180.0),
            Axis::B => w.y += growth * R::of(core::f64::consts::PI / 180.0),
            Axis::C => w.z += growth * R::of(core::f64::consts::PI / 180.0),
        }
        (e, w, q)
    }

    /// [`Volumetric::pose_error`] for plain tables: uses every twist as soon as it is read.
    #[inline(always)]
    fn plain_pose_error(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> PoseError<R> {
        if N == 3 {
            return self.plain_slides(query, clamped);
        }
        let mut tool = Side { v: V3::ZERO, w: V3::ZERO };
        let mut tip = self.chain.tool;
        for carriage in self.chain.tool_side() {
            let (e, w, q) = self.read_plain(carriage, query, clamped);
            if carriage.axis.is_rotary() {
                let pose = coarse_cos_sin_deg(q * carriage.motion);
                tip = tip.turned(about(carriage.axis), pose) + carriage.offset;
                tool.turn(carriage, pose, (e, w));
                continue;
            }
            tool.add((e, w));
            tool.slide(carriage.axis, q);
            match about(carriage.axis) {
                About::X => tip.x += q,
                About::Y => tip.y += q,
                About::Z => tip.z += q,
            }
        }
        let mut workpiece = Side { v: V3::ZERO, w: V3::ZERO };
        for carriage in self.chain.workpiece_side() {
            let (e, w, q) = self.read_plain(carriage, query, clamped);
            if carriage.axis.is_rotary() {
                workpiece.turn(carriage, coarse_cos_sin_deg(q * carriage.motion), (e, w));
                continue;
            }
            workpiece.carry(carriage, q, (e, w));
        }
        let w = tool.w + workpiece.w;
        PoseError { tip: (tool.v + workpiece.v + w.cross(tip)).glam(), orientation: w.glam() }
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

    /// Transfers the twists of all axes, plus the errors outside tables, to the tip.
    #[inline(always)]
    fn carried(&self, query: &Query<'_, R, N>, poses: &Poses<R, N>, twists: &[Twist<R>; N]) -> PoseError<R> {
        let Query { command: at, thermal, .. } = *query;
        let mut twists = *twists;
        let mut positions = [R::ZERO; N];
        for (((twist, q), (at, origin)), ((line, datum), (constant, own))) in twists
            .iter_mut()
            .zip(&mut positions)
            .zip(at.iter().zip(&self.origins))
            .zip(thermal.iter().zip(&self.datum).zip(self.constant.iter().zip(&self.own)))
        {
            *q = *at + *origin;
            let mut growth = line.at(*at - *datum);
            if *own >= 3 {
                growth = growth * R::of(core::f64::consts::PI / 180.0);
                for (twist, constant) in twist.iter_mut().zip(constant) {
                    *twist += *constant;
                }
            }
            if let Some(own) = twist.get_mut(*own) {
                *own += growth;
            }
        }
        let [c0y, b0z, a0z] = self.squareness;
        if let ([_, y, z, ..], [[x_error, ..], [x_error_of_z, y_error, ..], ..]) =
            (&positions[..], twists.get_mut(1..).unwrap_or(&mut []))
        {
            *x_error += -(c0y * *y);
            *x_error_of_z += b0z * *z;
            *y_error += -(a0z * *z);
        }
        if N == 3 { self.sum_of_slides(&positions, &twists) } else { self.walk(&positions, poses, &twists) }
    }

    /// Without rotary axes the lever of every twist is the sum of the travels beyond it, and the tool is in the tables:
    /// no walk.
    #[inline(always)]
    fn sum_of_slides(&self, positions: &[R; N], twists: &[Twist<R>; N]) -> PoseError<R> {
        let (mut d, mut orientation) = (V3::ZERO, V3::ZERO);
        if let [qx, qy, qz, ..] = positions.as_slice() {
            for ([x, y, z, a, b, c], [bx, by, bz]) in twists.iter().zip(&self.chain.beyond) {
                let w = V3::new(*a, *b, *c);
                let lever = V3::new(*bx * *qx, *by * *qy, *bz * *qz);
                d += V3::new(*x, *y, *z) + w.cross(lever);
                orientation += w;
            }
        }
        PoseError { tip: d.glam(), orientation: orientation.glam() }
    }

    /// Walks the twists of both sides from their outer ends to the bed.
    #[inline(always)]
    fn walk(&self, positions: &[R; N], poses: &Poses<R, N>, twists: &[Twist<R>; N]) -> PoseError<R> {
        let of = |carriage: &Carriage<R>| match (
            positions.get(carriage.slot),
            twists.get(carriage.slot),
            poses.get(carriage.slot),
        ) {
            (Some(q), Some(twist), Some(pose)) => (*q, *twist, *pose),
            _ => (R::ZERO, [R::ZERO; 6], (R::ONE, R::ZERO)),
        };
        let mut tool = Side { v: V3::ZERO, w: V3::ZERO };
        let mut tip = self.chain.tool;
        for carriage in self.chain.tool_side() {
            let (q, twist, pose) = of(carriage);
            if carriage.axis.is_rotary() {
                tool.turn(carriage, pose, halves(twist));
                tip = tip.turned(about(carriage.axis), pose) + carriage.offset;
                continue;
            }
            tool.add(halves(twist));
            tool.slide(carriage.axis, q);
            match carriage.axis {
                Axis::X | Axis::A => tip.x += q,
                Axis::Y | Axis::B => tip.y += q,
                Axis::Z | Axis::C => tip.z += q,
            }
        }
        let mut workpiece = Side { v: V3::ZERO, w: V3::ZERO };
        for carriage in self.chain.workpiece_side() {
            let (q, twist, pose) = of(carriage);
            if carriage.axis.is_rotary() {
                workpiece.turn(carriage, pose, halves(twist));
                continue;
            }
            workpiece.carry(carriage, q, halves(twist));
        }
        let w = tool.w + workpiece.w;
        PoseError { tip: (tool.v + workpiece.v + w.cross(tip)).glam(), orientation: w.glam() }
    }
}

#[cfg(test)]
mod tests;
