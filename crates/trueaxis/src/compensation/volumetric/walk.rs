//! The walk along the chain: every axis' twist at its lever, and their sum at the tip.

#![deny(clippy::indexing_slicing)]

use super::carriages::{Carriage, Poses, about};
use super::tangent::RAD;
use super::{Volumetric, halves};
use crate::compensation::trig::coarse_cos_sin_deg;
use crate::compensation::{PoseError, Query};
use crate::machine::{Axis, Twist};
use crate::position::Position;
use crate::real::Real;
use crate::vector::{About, V3};

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

/// Where the walk reads the axes. A trait and not a closure, so that both places that read can be inlined.
trait Axes<R> {
    /// Twist of an axis, translations and rotations, and its position, mm (deg).
    fn read(&mut self, carriage: &Carriage<R>) -> ((V3<R>, V3<R>), R);
    /// Cosine and sine of a rotary axis at the position read.
    fn pose(&self, carriage: &Carriage<R>, q: R) -> (R, R);
}

/// Twists and positions looked up before the walk.
struct Twists<'q, R, const N: usize> {
    twists: &'q [Twist<R>; N],
    positions: &'q [R; N],
    poses: &'q Poses<R, N>,
}

impl<R: Real, const N: usize> Axes<R> for Twists<'_, R, N> {
    #[inline(always)]
    fn read(&mut self, carriage: &Carriage<R>) -> ((V3<R>, V3<R>), R) {
        match (self.twists.get(carriage.slot), self.positions.get(carriage.slot)) {
            (Some(twist), Some(q)) => (halves(*twist), *q),
            _ => ((V3::ZERO, V3::ZERO), R::ZERO),
        }
    }

    #[inline(always)]
    fn pose(&self, carriage: &Carriage<R>, _: R) -> (R, R) {
        self.poses.get(carriage.slot).copied().unwrap_or((R::ONE, R::ZERO))
    }
}

/// Plain tables, read during the walk, plus the errors outside tables.
struct PlainTables<'q, 'a, R: Real, P, const N: usize> {
    model: &'q Volumetric<'a, R, P, N>,
    query: &'q Query<'q, R, N>,
    clamped: &'q mut u8,
}

impl<R: Real, P: Position, const N: usize> Axes<R> for PlainTables<'_, '_, R, P, N> {
    #[inline(always)]
    fn read(&mut self, carriage: &Carriage<R>) -> ((V3<R>, V3<R>), R) {
        let (slot, Volumetric { tables, origins, datum, squareness, .. }) = (carriage.slot, self.model);
        let (Some(table), Some(at), Some(reverse), Some(line), Some(origin), Some(datum)) = (
            tables.get(slot),
            self.query.command.get(slot),
            self.query.directions.get(slot),
            self.query.thermal.get(slot),
            origins.get(slot),
            datum.get(slot),
        ) else {
            return ((V3::ZERO, V3::ZERO), R::ZERO);
        };
        let (twist, edge) = table.at_plain(*at, *reverse);
        if edge {
            *self.clamped |= 1 << (slot & 7);
        }
        let ((mut e, mut w), q, growth) = (halves(twist), *at + *origin, line.at(*at - *datum));
        match carriage.axis {
            Axis::X => e.x += growth,
            Axis::Y => {
                e.x += squareness.of_y(q);
                e.y += growth;
            }
            Axis::Z => {
                let [x_tilt, y_tilt] = squareness.of_z(q);
                e.x += x_tilt;
                e.y += y_tilt;
                e.z += growth;
            }
            Axis::A => w.x += growth * R::of(RAD),
            Axis::B => w.y += growth * R::of(RAD),
            Axis::C => w.z += growth * R::of(RAD),
        }
        ((e, w), q)
    }

    #[inline(always)]
    fn pose(&self, carriage: &Carriage<R>, q: R) -> (R, R) {
        coarse_cos_sin_deg(q * carriage.motion)
    }
}

// Only with volumetric.
impl<R: Real, P: Position, const N: usize> Volumetric<'_, R, P, N> {
    /// [`Volumetric::pose_error`] for plain tables: uses every twist as soon as it is read.
    #[inline(always)]
    pub(super) fn plain_pose_error(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> PoseError<R> {
        if N == 3 {
            return self.slides_at_command::<true>(query, clamped);
        }
        self.walk(PlainTables { model: self, query, clamped })
    }

    /// Transfers the twists of all axes, plus the errors outside tables, to the tip.
    #[inline(always)]
    pub(super) fn carried(&self, query: &Query<'_, R, N>, poses: &Poses<R, N>, twists: &[Twist<R>; N]) -> PoseError<R> {
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
                growth = growth * R::of(RAD);
                for (twist, constant) in twist.iter_mut().zip(constant) {
                    *twist += *constant;
                }
            }
            if let Some(own) = twist.get_mut(*own) {
                *own += growth;
            }
        }
        if let ([_, y, z, ..], [[x_of_y, ..], [x_of_z, y_of_z, ..], ..]) =
            (&positions[..], twists.get_mut(1..).unwrap_or(&mut []))
        {
            let [x_tilt, y_tilt] = self.squareness.of_z(*z);
            *x_of_y += self.squareness.of_y(*y);
            *x_of_z += x_tilt;
            *y_of_z += y_tilt;
        }
        if N == 3 {
            return self.sum_of_slides(&positions, &twists);
        }
        self.walk(Twists { twists: &twists, positions: &positions, poses })
    }

    /// Walks the twists of both sides from their outer ends to the bed.
    #[inline(always)]
    fn walk(&self, mut axes: impl Axes<R>) -> PoseError<R> {
        let mut tool = Side { v: V3::ZERO, w: V3::ZERO };
        let mut tip = self.chain.tool;
        for carriage in self.chain.tool_side() {
            let (twist, q) = axes.read(carriage);
            if carriage.axis.is_rotary() {
                let pose = axes.pose(carriage, q);
                tip = tip.turned(about(carriage.axis), pose) + carriage.offset;
                tool.turn(carriage, pose, twist);
            } else {
                tool.add(twist);
                tool.slide(carriage.axis, q);
                match about(carriage.axis) {
                    About::X => tip.x += q,
                    About::Y => tip.y += q,
                    About::Z => tip.z += q,
                }
            }
        }
        let mut workpiece = Side { v: V3::ZERO, w: V3::ZERO };
        for carriage in self.chain.workpiece_side() {
            let (twist, q) = axes.read(carriage);
            if carriage.axis.is_rotary() {
                workpiece.turn(carriage, axes.pose(carriage, q), twist);
            } else {
                workpiece.carry(carriage, q, twist);
            }
        }
        let w = tool.w + workpiece.w;
        PoseError { tip: (tool.v + workpiece.v + w.cross(tip)).glam(), orientation: w.glam() }
    }

    /// Without rotary axes the lever of every twist is the sum of the travels beyond it; the tool is in the tables. All are
    /// looked up at the command; `PLAIN`: the tables are.
    ///
    /// Computes what [`Volumetric::sum_of_slides`] computes from the tables' values, but adds the terms one by one, for
    /// processors with a multiply-add instruction: the results may differ in the last bit.
    #[inline(always)]
    pub(super) fn slides_at_command<const PLAIN: bool>(
        &self,
        query: &Query<'_, R, N>,
        clamped: &mut u8,
    ) -> PoseError<R> {
        let Query { command: at, directions: reverse, thermal, .. } = *query;
        let (mut d, mut orientation) = (V3::ZERO, V3::ZERO);
        let mut q = [R::ZERO; 3];
        for ((q, at), origin) in q.iter_mut().zip(at).zip(&self.origins) {
            *q = *at + *origin;
        }
        let [qx, qy, qz] = q;
        let mut bit = 1;
        for (((table, [bx, by, bz]), at), reverse) in self.tables.iter().zip(&self.chain.beyond).zip(at).zip(reverse) {
            let (twist, edge) = if PLAIN { table.at_plain(*at, *reverse) } else { table.at(*at, *reverse) };
            if edge {
                *clamped |= bit;
            }
            bit <<= 1;
            let (e, w) = halves(twist);
            let (x, y, z) = (*bx * qx, *by * qy, *bz * qz);
            d = V3::new(d.x + e.x + w.y * z - w.z * y, d.y + e.y + w.z * x - w.x * z, d.z + e.z + w.x * y - w.y * x);
            orientation += w;
        }
        let mut growth = [R::ZERO; 3];
        for (((growth, at), line), datum) in growth.iter_mut().zip(at).zip(thermal).zip(&self.datum) {
            *growth = line.at(*at - *datum);
        }
        let [x_tilt, y_tilt] = self.squareness.error(qy, qz);
        d += V3::from(growth) + V3::new(x_tilt, y_tilt, R::ZERO);
        PoseError { tip: d.glam(), orientation: orientation.glam() }
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
}
