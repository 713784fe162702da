//! The grids of one cycle beside the tangents of the volumetric model.

use super::kept::Near;
use super::{Grids, LINEAR, NearGrids, Sum};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

/// A box, and steps from its low corner.
type Place<'s, R, P> = (&'s Near<R, P>, [R; LINEAR]);

/// Grids where the drives stand and at the feedback.
#[derive(Debug)]
pub(crate) struct Beside<'s, R, P: Position> {
    grids: &'s Grids<'s, R>,
    /// Boxes, and steps from their low corners; none where rotary axes turn the levers.
    near: Option<[Place<'s, R, P>; 2]>,
    edge: u8,
}

impl<'s, R: Real, P: Position> Beside<'s, R, P> {
    /// For a cycle with the drives and the feedback there.
    #[inline(always)]
    pub(crate) fn new(
        grids: &'s Grids<'s, R>,
        kept: &'s mut NearGrids<R, P>,
        drive: &[P; LINEAR],
        feedback: &[P; LINEAR],
    ) -> Option<Self> {
        if grids.swings() {
            return Some(Beside { grids, near: None, edge: 0 });
        }
        let (there, back) = kept.about(grids, drive, feedback);
        let edge = kept.edge();
        let [command, feedback] = kept.boxes();
        Some(Beside { grids, near: Some([(command, there), (feedback, back)]), edge })
    }

    /// The grids.
    #[inline(always)]
    pub(crate) fn grids(&self) -> &Grids<'s, R> {
        self.grids
    }

    /// A bit for every axis beyond the nodes of a grid, where boxes say so.
    #[inline(always)]
    pub(crate) fn edge(&self) -> u8 {
        self.edge
    }

    /// Error of the tip, mm, where the drives stand, `moved` mm from there; none where the boxes do not know it.
    #[inline(always)]
    pub(crate) fn at_drives(&self, moved: [R; LINEAR]) -> Option<V3<R>> {
        let [(near, steps), _] = self.near.as_ref()?;
        let mut steps = *steps;
        for (steps, moved) in steps.iter_mut().zip(moved) {
            *steps += moved * R::of(1.0 / P::STEP);
        }
        Some(near.at(steps))
    }

    /// At the feedback, likewise.
    #[inline(always)]
    pub(crate) fn at_feedback(&self) -> Option<V3<R>> {
        let [_, (near, steps)] = self.near.as_ref()?;
        Some(near.at(*steps))
    }

    /// Where the direction is asked for, or the boxes do not know the tip: by a look-up of `direct`.
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
