//! The sum of all grids about command and feedback, kept from cycle to cycle.
//!
//! In a box in which no grid has a node, and none begins or ends to fade, the sum of all of them is one polynomial
//!
//! ```text
//! d = k0 + kx x + ky y + kxy x y + z (kz + kxz x + kyz y + kxyz x y)
//! ```
//!
//! of the distances from the low corner, in steps of the position; levers of rotations, which the slides make longer, included.
//! It costs the same for one grid as for all of them. A box goes on a little beyond its borders, as far as the jump of the
//! slopes there stays below a fixed error, so that a reading that dithers about a node does not leave it in every cycle.

use super::{Grids, LINEAR};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

/// Half of the widest box, mm: integers count its steps.
const WIDEST_MM: f64 = 1000.0;

/// The sum of all grids in a box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near<R, P: Position> {
    low: [P; LINEAR],
    reach: [P::Reach; LINEAR],
    /// Factors of 1, x, y, xy, z, xz, yz, xyz.
    factors: [V3<R>; 8],
    /// Axis that nothing depends on; 3 where there is none.
    flat: u8,
    /// A bit for every axis beyond the nodes of a grid.
    edge: u8,
}

impl<R: Real, P: Position> Near<R, P> {
    fn nowhere() -> Self {
        let zero = [P::of(f64::NAN); LINEAR];
        Near { low: zero, reach: [P::Reach::default(); LINEAR], factors: [V3::ZERO; 8], flat: 3, edge: 0 }
    }

    /// Steps from the low corner, where the position is in the box.
    #[inline(always)]
    fn steps(&self, at: &[P; LINEAR]) -> Option<[R; LINEAR]> {
        let ([x, y, z], [low_x, low_y, low_z], [reach_x, reach_y, reach_z]) = (at, &self.low, &self.reach);
        let (along_x, in_x) = x.steps_above(*low_x, *reach_x);
        let (along_y, in_y) = y.steps_above(*low_y, *reach_y);
        let (along_z, in_z) = z.steps_above(*low_z, *reach_z);
        (in_x & in_y & in_z).then_some([along_x, along_y, along_z])
    }

    /// Makes it the box about a position, by the `other` one where that is it; steps from its low corner.
    #[cold]
    #[inline(never)]
    fn renew(&mut self, other: &Self, grids: &Grids<'_, R>, at: &[P; LINEAR]) -> [R; LINEAR] {
        *self = if other.steps(at).is_some() { *other } else { grids.near(at) };
        self.steps(at).unwrap_or([R::ZERO; LINEAR])
    }

    /// Error of the tip so many steps from the low corner, mm.
    #[inline(always)]
    pub(crate) fn at(&self, [x, y, z]: [R; LINEAR]) -> V3<R> {
        let [k, kx, ky, kxy, kz, kxz, kyz, kxyz] = self.factors;
        let two = |k: V3<R>, ka: V3<R>, kb: V3<R>, kab: V3<R>, a: R, b: R| k + ka * a + (kb + kab * a) * b;
        match self.flat {
            2 => two(k, kx, ky, kxy, x, y),
            1 => two(k, kx, kz, kxz, x, z),
            0 => two(k, ky, kz, kyz, y, z),
            _ => two(k, kx, ky, kxy, x, y) + two(kz, kxz, kyz, kxyz, x, y) * z,
        }
    }
}

/// Boxes about command and feedback; forgotten, they are found again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearGrids<R, P: Position> {
    key: u64,
    command: Near<R, P>,
    feedback: Near<R, P>,
}

impl<R: Real, P: Position> NearGrids<R, P> {
    /// None yet.
    pub(crate) fn nowhere() -> Self {
        NearGrids { key: 0, command: Near::nowhere(), feedback: Near::nowhere() }
    }

    /// Errors of the tip at command and feedback, mm, and a bit for every axis at the command beyond the nodes of a grid.
    #[inline(always)]
    pub(crate) fn errors(
        &mut self,
        grids: &Grids<'_, R>,
        command: &[P; LINEAR],
        feedback: &[P; LINEAR],
    ) -> ([V3<R>; 2], u8) {
        if self.key == grids.key()
            && let (Some(there), Some(back)) = (self.command.steps(command), self.feedback.steps(feedback))
        {
            return ([self.command.at(there), self.feedback.at(back)], self.command.edge);
        }
        self.renewed(grids, command, feedback)
    }

    /// [`NearGrids::errors`] where a position has left its box.
    #[cold]
    #[inline(never)]
    fn renewed(&mut self, grids: &Grids<'_, R>, command: &[P; LINEAR], feedback: &[P; LINEAR]) -> ([V3<R>; 2], u8) {
        let (there, back) = self.about(grids, command, feedback);
        ([self.command.at(there), self.feedback.at(back)], self.command.edge)
    }

    /// Makes the boxes those about these positions; steps of both from the low corners.
    #[inline(always)]
    pub(crate) fn about(
        &mut self,
        grids: &Grids<'_, R>,
        command: &[P; LINEAR],
        feedback: &[P; LINEAR],
    ) -> ([R; LINEAR], [R; LINEAR]) {
        if self.key != grids.key() {
            *self = NearGrids { key: grids.key(), ..Self::nowhere() };
        }
        let there = self.command.steps(command).unwrap_or_else(|| {
            // The feedback may have been here before.
            self.command.renew(&self.feedback, grids, command)
        });
        let back = self.feedback.steps(feedback).unwrap_or_else(|| self.feedback.renew(&self.command, grids, feedback));
        (there, back)
    }

    /// The boxes about command and feedback.
    #[inline(always)]
    pub(crate) fn boxes(&self) -> [&Near<R, P>; 2] {
        [&self.command, &self.feedback]
    }

    /// The box about the command.
    pub(crate) fn of_command(&self) -> &Near<R, P> {
        &self.command
    }

    /// The error at a feedback so many steps from the low corner of its box, mm.
    pub(crate) fn at_feedback(&self, steps: [R; LINEAR]) -> V3<R> {
        self.feedback.at(steps)
    }

    /// A bit for every axis at the command beyond the nodes of a grid.
    pub(crate) fn edge(&self) -> u8 {
        self.command.edge
    }
}

/// A polynomial of three parameters, factors as in [`Near`], written for t = t0 + r s instead of t along one of them.
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

/// The box about a position, mm: how far it goes down and up along X, Y and Z.
struct Room<R> {
    down: [R; LINEAR],
    up: [R; LINEAR],
}

impl<R: Real> Room<R> {
    /// Ends it at a border `distance` above (below) the position along an axis.
    fn end(&mut self, axis: usize, distance: R) {
        let side = if distance < R::ZERO { &mut self.down } else { &mut self.up };
        if let Some(side) = side.get_mut(axis) {
            *side = side.min(distance.abs());
        }
    }
}

impl<R: Real> Grids<'_, R> {
    /// The box about a position and the sum of all grids in it. Cost: some 100 operations an error of each grid.
    #[inline(never)]
    pub(crate) fn near<P: Position>(&self, at: &[P; LINEAR]) -> Near<R, P> {
        let q: [R; LINEAR] = at.map(|at| at.since(P::default()));
        let room = self.room(&q);
        let mut near = Near::nowhere();
        let mut from = [R::ZERO; LINEAR];
        for axis in 0..LINEAR {
            let (Some(at), Some(down), Some(up), Some(low), Some(reach), Some(from)) = (
                at.get(axis),
                room.down.get(axis),
                room.up.get(axis),
                near.low.get_mut(axis),
                near.reach.get_mut(axis),
                from.get_mut(axis),
            ) else {
                continue;
            };
            *low = at.plus(-*down);
            *reach = at.plus(*up).apart(*low);
            *from = at.since(*low);
        }
        for grid in self.grids.iter().flatten() {
            near.edge |= grid.add_to(&mut near.factors, &q, &from, R::of(P::STEP));
        }
        near.flat = flat(&near.factors);
        near
    }

    fn room(&self, q: &[R; LINEAR]) -> Room<R> {
        let mut room = Room { down: [R::of(WIDEST_MM); LINEAR], up: [R::of(WIDEST_MM); LINEAR] };
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
                    room.end(along.axis(), if at < first { first - at } else { end - at });
                    continue;
                }
                let [low, high] = along.nodes_of(place.index);
                // At a node itself the distance is zero on one side.
                let (down, up) = (at - low, high - at);
                if let (Some(below), Some(above)) = (room.down.get_mut(along.axis()), room.up.get_mut(along.axis())) {
                    *below = below.min(down.max(R::ZERO) + grid.overlap);
                    *above = above.min(up.max(R::ZERO) + grid.overlap);
                }
            }
            if let Some(fade) = &grid.fade {
                room.end(2, fade.whole - height);
                room.end(2, fade.none - height);
            }
        }
        room
    }
}

impl<R: Real> super::Grid<'_, R> {
    /// Adds the grid's polynomial about the position `q`, in steps from a corner `from` mm below it; a bit for every axis beyond
    /// its nodes.
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
                // Beyond its nodes the grid does not change.
                let beyond = place.edge || !along.is_there();
                let (t0, rate) = if beyond { (place.t, R::ZERO) } else { (place.t - back / *width, step / *width) };
                moved(&mut own, bit, t0, rate);
            }
            if let Some((whole, rate)) = weight {
                // The grid stands over X and Y, so that nothing depends on the third yet.
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

    /// What the rotations do through their levers, which the slides that the grid does not stand over make longer.
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

/// The axis that nothing depends on, Z before Y before X; 3 where there is none.
fn flat<R: Real>(factors: &[V3<R>; 8]) -> u8 {
    for (axis, bit) in [(2, 4usize), (1, 2), (0, 1)] {
        let with = factors.iter().enumerate().filter(|(index, _)| index & bit != 0);
        if with.clone().all(|(_, factor)| *factor == V3::ZERO) {
            return axis;
        }
    }
    3
}
