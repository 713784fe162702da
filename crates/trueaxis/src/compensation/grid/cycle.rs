//! The grids in one cycle, beside the tangents of the volumetric model.

use super::near::Near;
use super::{Grids, LINEAR, NearGrids, Sum};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

/// A box, and the steps from its low corner.
type Place<'s, R, P> = (&'s Near<R, P>, [R; LINEAR]);

/// Grids at the drive positions and at the feedback.
#[derive(Debug)]
pub(crate) struct CycleGrids<'s, R, P: Position> {
    grids: &'s Grids<'s, R>,
    /// Boxes, and the steps from their low corners; `None` if rotary axes turn the levers, or the position is not in its box.
    near: [Option<Place<'s, R, P>>; 2],
    edge: u8,
}

impl<'s, R: Real, P: Position> CycleGrids<'s, R, P> {
    /// Prepares a cycle with drives and feedback at these positions.
    #[inline(always)]
    pub(crate) fn new(
        grids: &'s Grids<'s, R>,
        near: &'s mut NearGrids<R, P>,
        drive: &[P; LINEAR],
        feedback: &[P; LINEAR],
    ) -> Option<Self> {
        if grids.swings() {
            return Some(CycleGrids { grids, near: [None; 2], edge: 0 });
        }
        let [there, back] = near.about(grids, drive, feedback);
        let edge = if there.is_some() { near.edge() } else { 0 };
        let [command, feedback] = near.boxes();
        let near = [there.map(|there| (command, there)), back.map(|back| (feedback, back))];
        Some(CycleGrids { grids, near, edge })
    }

    /// The grids.
    #[inline(always)]
    pub(crate) fn grids(&self) -> &Grids<'s, R> {
        self.grids
    }

    /// One bit for every axis beyond the nodes of a grid; 0 without a box.
    #[inline(always)]
    pub(crate) fn edge(&self) -> u8 {
        self.edge
    }

    /// Error of the tip, mm, at the drive positions shifted by `moved` mm; `None` without a box.
    #[inline(always)]
    pub(crate) fn at_drives(&self, moved: [R; LINEAR]) -> Option<V3<R>> {
        let [Some((near, steps)), _] = &self.near else { return None };
        let mut steps = *steps;
        for (steps, moved) in steps.iter_mut().zip(moved) {
            *steps += moved * R::of(1.0 / P::STEP);
        }
        Some(near.at(steps))
    }

    /// Error of the tip, mm, at the feedback; `None` without a box.
    #[inline(always)]
    pub(crate) fn at_feedback(&self) -> Option<V3<R>> {
        let [_, Some((near, steps))] = &self.near else { return None };
        Some(near.at(*steps))
    }

    /// Error of tip and direction: looked up by `direct` if the direction is needed or `tip` is not known.
    #[inline(always)]
    pub(crate) fn pose(&self, tip: Option<V3<R>>, turn: bool, direct: impl FnOnce() -> Sum<R>) -> (V3<R>, V3<R>) {
        match tip {
            Some(tip) if !(turn && self.grids.turns()) => (tip, V3::ZERO),
            _ => {
                let sum = direct();
                (tip.unwrap_or(sum.tip), sum.turn)
            }
        }
    }
}
