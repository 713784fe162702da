//! Caches, from cycle to cycle, the sum of all grids around command and feedback.
//!
//! In a box without any grid node, and without a height at which a grid begins or ends to fade, the sum of all grids is
//! one polynomial
//!
//! ```text
//! d = k0 + kx x + ky y + kxy x y + z (kz + kxz x + kyz y + kxyz x y)
//! ```
//!
//! of the distances from the low corner, in steps of the position, including the levers of rotations, which the slides
//! lengthen. It costs the same for one grid as for all of them. A box extends slightly beyond its borders, as far as the
//! jump of the slopes there stays below a fixed error, so that a reading that dithers around a node does not leave it in
//! every cycle. Cells of tables also end at its borders: an axis that stays in its cells stays in the box.

use super::{Grids, LINEAR};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

/// Half the width of the widest box, mm: integers count its steps.
const WIDEST_MM: f64 = 1000.0;

/// The sum of all grids in a box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near<R, P: Position> {
    low: [P; LINEAR],
    high: [P; LINEAR],
    /// Factors of 1, x, y, xy, z, xz, yz, xyz.
    factors: [V3<R>; 8],
    /// Axis that the sum does not depend on, at both command and feedback; 3 if it depends on all.
    flat: u8,
    /// One bit for every axis beyond the nodes of a grid.
    edge: u8,
}

impl<R: Real, P: Position> Near<R, P> {
    fn empty() -> Self {
        let nan = [P::of(f64::NAN); LINEAR];
        Near { low: nan, high: nan, factors: [V3::ZERO; 8], flat: 3, edge: 0 }
    }

    /// Ends of the box along an axis.
    #[inline(always)]
    pub(crate) fn ends(&self, axis: usize) -> Option<[P; 2]> {
        Some([*self.low.get(axis)?, *self.high.get(axis)?])
    }

    /// Whether the position is in the box.
    #[inline(always)]
    pub(crate) fn holds(&self, at: &[P; LINEAR]) -> bool {
        at.iter().zip(self.low.iter().zip(&self.high)).all(|(at, (low, high))| at.is_within(&[*low, *high]))
    }

    /// Steps from the low corner to a position in the box.
    #[inline(always)]
    fn along(&self, at: &[P; LINEAR]) -> [R; LINEAR] {
        let ([x, y, z], [low_x, low_y, low_z]) = (at, &self.low);
        let along = |at: &P, low: &P| at.steps_above(*low, P::Reach::default()).0;
        [along(x, low_x), along(y, low_y), along(z, low_z)]
    }

    /// One bit for every axis beyond the nodes of a grid.
    #[inline(always)]
    pub(crate) fn edge(&self) -> u8 {
        self.edge
    }

    /// Error of the tip at a position in the box, mm.
    #[inline(always)]
    pub(crate) fn error(&self, at: &[P; LINEAR]) -> V3<R> {
        self.at(self.along(at))
    }

    /// Error of the tip at a distance in steps from the low corner, mm.
    #[inline(always)]
    pub(crate) fn at(&self, steps: [R; LINEAR]) -> V3<R> {
        match self.flat {
            2 => self.over::<2>(steps),
            1 => self.over::<1>(steps),
            0 => self.over::<0>(steps),
            _ => self.over::<3>(steps),
        }
    }

    /// [`Near::at`] for a sum that does not depend on axis `FLAT`; 3 if it depends on all.
    #[inline(always)]
    fn over<const FLAT: u8>(&self, [x, y, z]: [R; LINEAR]) -> V3<R> {
        let [k, kx, ky, kxy, kz, kxz, kyz, kxyz] = self.factors;
        let two = |k: V3<R>, ka: V3<R>, kb: V3<R>, kab: V3<R>, a: R, b: R| k + ka * a + (kb + kab * a) * b;
        match FLAT {
            2 => two(k, kx, ky, kxy, x, y),
            1 => two(k, kx, kz, kxz, x, z),
            0 => two(k, ky, kz, kyz, y, z),
            _ => two(k, kx, ky, kxy, x, y) + two(kz, kxz, kyz, kxyz, x, y) * z,
        }
    }
}

/// Which of the two boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// The one around the command.
    Command,
    /// The one around the feedback.
    Feedback,
}

/// Boxes around command and feedback; after [`NearGrids::forget`] they are recomputed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearGrids<R, P: Position> {
    key: u64,
    command: Near<R, P>,
    feedback: Near<R, P>,
}

impl<R: Real, P: Position> NearGrids<R, P> {
    /// The key that belongs to no grids.
    const NONE: u64 = 0;

    /// Empty boxes, bound to no grids.
    pub(crate) fn empty() -> Self {
        NearGrids { key: Self::NONE, command: Near::empty(), feedback: Near::empty() }
    }

    /// Unbinds the boxes from their grids.
    #[inline(always)]
    pub(crate) fn forget(&mut self) {
        self.key = Self::NONE;
    }

    /// Steps of both positions from the low corners of their boxes; `None` for one that is not in its box. Moves at most one
    /// box that was left, the command's before the feedback's.
    // Only with grids.
    #[inline(always)]
    pub(crate) fn about(
        &mut self,
        grids: &Grids<'_, R>,
        command: &[P; LINEAR],
        feedback: &[P; LINEAR],
    ) -> [Option<[R; LINEAR]>; 2] {
        self.bind_to(grids);
        self.follow(grids, command, feedback);
        [(&self.command, command), (&self.feedback, feedback)].map(|(near, at)| near.holds(at).then(|| near.along(at)))
    }

    /// Moves a box that its position has left, the command's before the feedback's; returns which.
    // Only with grids.
    #[inline(always)]
    pub(crate) fn follow(
        &mut self,
        grids: &Grids<'_, R>,
        command: &[P; LINEAR],
        feedback: &[P; LINEAR],
    ) -> Option<Side> {
        let side = if !self.command.holds(command) {
            Side::Command
        } else if !self.feedback.holds(feedback) {
            Side::Feedback
        } else {
            return None;
        };
        self.renew(grids, side, if side == Side::Command { command } else { feedback });
        Some(side)
    }

    /// Replaces the box on one side by the one around a position.
    // Only with grids.
    #[cold]
    #[inline(never)]
    fn renew(&mut self, grids: &Grids<'_, R>, side: Side, at: &[P; LINEAR]) {
        let (own, other) = match side {
            Side::Command => (&mut self.command, &self.feedback),
            Side::Feedback => (&mut self.feedback, &self.command),
        };
        // The other box may already cover the position.
        *own = if other.holds(at) { *other } else { grids.near(at) };
        let (there, back) = (flat(&self.command.factors), flat(&self.feedback.factors));
        let both = if there == back { there } else { 3 };
        (self.command.flat, self.feedback.flat) = (both, both);
    }

    /// Binds the boxes to these grids, emptying them if they were bound to others.
    #[inline(always)]
    pub(crate) fn bind_to(&mut self, grids: &Grids<'_, R>) {
        if self.key != grids.key() {
            *self = NearGrids { key: grids.key(), ..Self::empty() };
        }
    }

    /// Errors of the tip at command and feedback in their boxes, mm.
    // Only with grids.
    #[inline(always)]
    pub(crate) fn errors(&self, command: &[P; LINEAR], feedback: &[P; LINEAR]) -> [V3<R>; 2] {
        if self.command.flat == 2 {
            return self.errors_over::<2>(command, feedback);
        }
        self.errors_over_more(command, feedback)
    }

    /// [`NearGrids::errors`] over axes other than X and Y: out of line, so that the X-Y case loads only its own factors.
    // Only with grids.
    #[inline(never)]
    fn errors_over_more(&self, command: &[P; LINEAR], feedback: &[P; LINEAR]) -> [V3<R>; 2] {
        match self.command.flat {
            3 => self.errors_over::<3>(command, feedback),
            _ => [self.command.error(command), self.feedback.error(feedback)],
        }
    }

    #[inline(always)]
    fn errors_over<const FLAT: u8>(&self, command: &[P; LINEAR], feedback: &[P; LINEAR]) -> [V3<R>; 2] {
        let (there, back) = (self.command.along(command), self.feedback.along(feedback));
        [self.command.over::<FLAT>(there), self.feedback.over::<FLAT>(back)]
    }

    /// The box around the command.
    #[inline(always)]
    pub(crate) fn at_command(&self) -> &Near<R, P> {
        &self.command
    }

    /// The box around the feedback.
    #[inline(always)]
    pub(crate) fn at_feedback(&self) -> &Near<R, P> {
        &self.feedback
    }

    /// Both boxes.
    #[inline(always)]
    pub(crate) fn boxes(&self) -> [&Near<R, P>; 2] {
        [&self.command, &self.feedback]
    }

    /// One bit for every axis whose command is beyond the nodes of a grid.
    pub(crate) fn edge(&self) -> u8 {
        self.command.edge
    }
}

/// Rewrites a polynomial of three parameters (factors as in [`Near`]) for t = t0 + r s instead of t along one of them.
#[inline(always)]
fn moved<R: Real>(factors: &mut [R; 8], bit: usize, t0: R, rate: R) {
    for index in 0..8usize {
        if index & bit == 0 {
            let slope = factors.get(index | bit).copied().unwrap_or(R::ZERO);
            if let Some(value) = factors.get_mut(index) {
                *value += slope * t0;
            }
            if let Some(factor) = factors.get_mut(index | bit) {
                *factor = slope * rate;
            }
        }
    }
}

/// Ends of a box along X, Y and Z, mm.
struct Room<R> {
    low: [R; LINEAR],
    high: [R; LINEAR],
}

impl<R: Real> Room<R> {
    /// Clips the box to `[low, high]` along an axis.
    fn end(&mut self, axis: usize, [from, to]: [R; 2]) {
        if let (Some(low), Some(high)) = (self.low.get_mut(axis), self.high.get_mut(axis)) {
            (*low, *high) = (low.max(from), high.min(to));
        }
    }

    /// Clips the box at a border above or below a position.
    fn end_at(&mut self, axis: usize, border: R, at: R) {
        self.end(axis, if border < at { [border, R::MAX] } else { [-R::MAX, border] });
    }
}

// Only with grids.
impl<R: Real> Grids<'_, R> {
    /// The box around a position and the sum of all grids in it. Cost: some 100 operations for each error of each grid.
    #[inline(never)]
    pub(crate) fn near<P: Position>(&self, at: &[P; LINEAR]) -> Near<R, P> {
        let q: [R; LINEAR] = at.map(|at| at.since(P::default()));
        let room = self.room(&q);
        let mut near = Near::empty();
        let mut from = [R::ZERO; LINEAR];
        let ends = near.low.iter_mut().zip(&mut near.high).zip(&mut from);
        for (((low, high), from), (at, (down, up))) in ends.zip(at.iter().zip(room.low.into_iter().zip(room.high))) {
            let (down, up) = (P::default().plus(down), P::default().plus(up));
            // However the ends are rounded, the box contains the position itself.
            (*low, *high) = (if *at < down { *at } else { down }, if *at > up { *at } else { up });
            *from = at.since(*low);
        }
        for grid in self.grids.iter().flatten() {
            near.edge |= grid.add_to(&mut near.factors, &q, &from, R::of(P::STEP));
        }
        near
    }

    fn room(&self, q: &[R; LINEAR]) -> Room<R> {
        let widest = R::of(WIDEST_MM);
        let mut room = Room { low: q.map(|q| q - widest), high: q.map(|q| q + widest) };
        let [_, _, height] = *q;
        for grid in self.grids.iter().flatten() {
            let (places, _) = grid.cells.places(q);
            for (along, place) in grid.cells.along.iter().zip(&places) {
                let at = q.get(along.axis()).copied().unwrap_or(R::ZERO);
                if !along.is_there() {
                    continue;
                }
                if place.edge {
                    let [first, end] = along.ends();
                    room.end_at(along.axis(), if at < first { first } else { end }, at);
                } else {
                    let [low, high] = along.nodes_of(place.index);
                    room.end(along.axis(), [low - grid.overlap, high + grid.overlap]);
                }
            }
            if let Some(fade) = &grid.fade {
                room.end_at(2, fade.whole, height);
                room.end_at(2, fade.none, height);
            }
        }
        room
    }
}

// Only with grids.
impl<R: Real> super::Grid<'_, R> {
    /// Adds the grid's polynomial around the position `q`, in steps from a corner `from` mm below it; returns one bit for
    /// every axis beyond its nodes.
    fn add_to(&self, factors: &mut [V3<R>; 8], q: &[R; LINEAR], from: &[R; LINEAR], step: R) -> u8 {
        let (places, edge) = self.cells.places(q);
        let mut widths = [R::ONE; LINEAR];
        for ((along, place), width) in self.cells.along.iter().zip(&places).zip(&mut widths) {
            let [low, high] = along.nodes_of(place.index);
            if along.is_there() {
                *width = high - low;
            }
        }
        let weight = self.fade.as_ref().map(|fade| {
            let [_, _, height] = *q;
            let rate = if height > fade.whole && height < fade.none { -fade.rate } else { R::ZERO };
            let [_, _, back] = *from;
            (fade.weight(height) - rate * back, rate * step)
        });
        let mut twists = [[V3::ZERO; 8]; 2];
        self.cells.polynomials(places.map(|place| place.index), |component, mut own| {
            for (bit, ((along, place), width)) in
                [1usize, 2, 4].into_iter().zip(self.cells.along.iter().zip(&places).zip(&widths))
            {
                let back = from.get(along.axis()).copied().unwrap_or(R::ZERO);
                // Beyond its nodes the grid is constant.
                let beyond = place.edge || !along.is_there();
                let (t0, rate) = if beyond { (place.t, R::ZERO) } else { (place.t - back / *width, step / *width) };
                moved(&mut own, bit, t0, rate);
            }
            if let Some((whole, rate)) = weight {
                // The grid spans X and Y, so nothing depends on the third axis yet.
                for index in 0..4usize {
                    let value = own.get(index).copied().unwrap_or(R::ZERO);
                    if let Some(factor) = own.get_mut(index | 4) {
                        *factor = value * rate;
                    }
                    if let Some(factor) = own.get_mut(index) {
                        *factor = value * whole;
                    }
                }
            }
            for (index, value) in own.into_iter().enumerate() {
                let mut to = 0;
                for (bit, along) in [1usize, 2, 4].into_iter().zip(&self.cells.along) {
                    to |= if index & bit == 0 { 0 } else { 1 << (along.axis() & 3) };
                }
                let half = twists.get_mut(usize::from(component >= 3)).and_then(|half| half.get_mut(to));
                if let Some(half) = half {
                    match component % 3 {
                        0 => half.x = value,
                        1 => half.y = value,
                        _ => half.z = value,
                    }
                }
            }
        });
        let [shifts, turns] = twists;
        for (factor, shift) in factors.iter_mut().zip(shifts) {
            *factor += shift;
        }
        if self.turns {
            self.add_levers(factors, &turns, q, from, step);
        }
        edge
    }

    /// Adds the effect of the rotations through their levers, which the slides outside the grid lengthen.
    fn add_levers(&self, factors: &mut [V3<R>; 8], turns: &[V3<R>; 8], q: &[R; LINEAR], from: &[R; LINEAR], step: R) {
        let ([x, y, z], [fx, fy, fz], [bx, by, bz]) = (*q, *from, self.along);
        let lever = self.lever + V3::new(bx * (x - fx), by * (y - fy), bz * (z - fz));
        for (index, turn) in turns.iter().enumerate() {
            if let Some(factor) = factors.get_mut(index) {
                *factor += turn.cross(lever);
            }
            for (bit, way) in [
                (1, V3::new(bx * step, R::ZERO, R::ZERO)),
                (2, V3::new(R::ZERO, by * step, R::ZERO)),
                (4, V3::new(R::ZERO, R::ZERO, bz * step)),
            ] {
                if index & bit == 0
                    && let Some(factor) = factors.get_mut(index | bit)
                {
                    *factor += turn.cross(way);
                }
            }
        }
    }
}

/// The axis that the sum does not depend on, Z before Y before X; 3 if it depends on all.
fn flat<R: Real>(factors: &[V3<R>; 8]) -> u8 {
    for (axis, bit) in [(2, 4usize), (1, 2), (0, 1)] {
        let with = factors.iter().enumerate().filter(|(index, _)| index & bit != 0);
        if with.clone().all(|(_, factor)| *factor == V3::ZERO) {
            return axis;
        }
    }
    3
}
