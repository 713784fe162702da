//! Tangents cached from cycle to cycle, for command and feedback.

#![deny(clippy::indexing_slicing)]

use super::Volumetric;
use super::tangent::{Pose, Tangent};
use crate::compensation::reversal::Direction;
use crate::compensation::thermal::ThermalLine;
use crate::compensation::{CycleGrids, PASSES_MASK, Query};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

/// Two tangents: one at the drive position, and one for a feedback on the other side of a table point. Either serves
/// both positions.
///
/// The cache drops them when an axis changes its direction of travel, when the host sets the thermal growth, and when
/// the tables change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TangentCache<R, P: Position, const N: usize> {
    key: u64,
    directions: [Direction; N],
    tangents: [Tangent<R, P, N>; 2],
}

impl<R: Real, P: Position, const N: usize> TangentCache<R, P, N> {
    /// The key that belongs to no tables: theirs are odd.
    const NONE: u64 = 0;

    /// An empty cache.
    pub(crate) fn empty() -> Self {
        TangentCache { key: Self::NONE, directions: [Direction::POSITIVE; N], tangents: [Tangent::empty(); 2] }
    }

    /// Empties the cache: the next lookup reads the tables.
    #[inline(always)]
    pub(crate) fn forget(&mut self) {
        self.key = Self::NONE;
    }
}

/// Inputs of a cycle's lookups.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cycle<'c, R, P, const N: usize> {
    /// Command.
    pub(crate) command: &'c [P; N],
    /// Command with the correction sent last.
    pub(crate) drive: &'c [P; N],
    /// Feedback.
    pub(crate) feedback: &'c [P; N],
    pub(crate) directions: &'c [Direction; N],
    pub(crate) thermal: &'c [ThermalLine<R>; N],
}

impl<R: Real, P: Position, const N: usize> Volumetric<'_, R, P, N> {
    /// The wanted correction, and the error of the pose at the feedback (its direction only if `needs_tilt`).
    ///
    /// Evaluates the cached tangents; for a position outside them it computes a new one, out of line.
    #[inline(always)]
    pub(crate) fn modelled(
        &self,
        cache: &mut TangentCache<R, P, N>,
        cycle: &Cycle<'_, R, P, N>,
        passes: u8,
        needs_tilt: bool,
        clamped: &mut u8,
    ) -> ([R; N], Pose<R>) {
        let mut changed = (cache.key != self.key) | (N == 3 && needs_tilt);
        for (cached, direction) in cache.directions.iter().zip(cycle.directions) {
            changed |= cached != direction;
        }
        let [first, second] = &cache.tangents;
        let (steps, inside) = first.steps(cycle.drive);
        let (steps_back, same) = first.steps(cycle.feedback);
        if !changed & inside & same {
            return (self.solved(first, &steps, cycle, passes, clamped), read(first, &steps_back, needs_tilt));
        }
        let (steps_back, other) = second.steps(cycle.feedback);
        if !changed & inside & other {
            return (self.solved(first, &steps, cycle, passes, clamped), read(second, &steps_back, needs_tilt));
        }
        self.renewed(cache, cycle, passes, needs_tilt, clamped)
    }

    /// [`Volumetric::modelled`] with grids beside the tables.
    #[inline(never)]
    pub(crate) fn modelled_with_grids(
        &self,
        cache: &mut TangentCache<R, P, N>,
        cycle: &Cycle<'_, R, P, N>,
        passes: u8,
        needs_tilt: bool,
        grids: &CycleGrids<'_, R, P>,
        clamped: &mut u8,
    ) -> ([R; N], Pose<R>) {
        let (_, (tip, turn)) = self.modelled(cache, cycle, 1, needs_tilt, clamped);
        *clamped |= grids.edge();
        let [first, _] = &cache.tangents;
        let (steps, sent) = (first.steps(cycle.drive).0, sent(cycle));
        let direction = self.orientation.is_some();
        let command = self.coordinates(cycle.command);
        let wanted = self.inverse(&command, sent, passes, |at, correction, poses| {
            let mut there = steps;
            let mut moved = [R::ZERO; 3];
            for ((there, correction), sent) in there.iter_mut().zip(correction).zip(&sent) {
                *there += (*correction - *sent) * R::of(1.0 / P::STEP);
            }
            for ((moved, correction), sent) in moved.iter_mut().zip(correction).zip(&sent) {
                *moved = *correction - *sent;
            }
            let (of_grids, turn) = grids.pose(grids.at_drives(moved), direction, || {
                let sum = self.swung(grids.grids(), at, poses);
                *clamped |= sum.edge;
                sum
            });
            (first.tip(&there) + of_grids, first.turn(&there) + turn)
        });
        let (of_grids, more) = grids
            .pose(grids.at_feedback(), needs_tilt, || self.of_grids(grids.grids(), &self.coordinates(cycle.feedback)));
        (wanted, (tip + of_grids, turn + if needs_tilt { more } else { V3::ZERO }))
    }

    /// [`Volumetric::modelled`] if a position is in neither box.
    #[cold]
    #[inline(never)]
    fn renewed(
        &self,
        cache: &mut TangentCache<R, P, N>,
        cycle: &Cycle<'_, R, P, N>,
        passes: u8,
        needs_tilt: bool,
        clamped: &mut u8,
    ) -> ([R; N], Pose<R>) {
        if cache.key != self.key || cache.directions != *cycle.directions {
            (cache.key, cache.directions) = (self.key, *cycle.directions);
            cache.tangents = [Tangent::empty(); 2];
        }
        let renew = |tangent: &mut Tangent<R, P, N>, at: &[P; N]| {
            if N == 3 {
                self.of_slides(tangent, at, cycle.directions, cycle.thermal);
            } else {
                self.tangent(tangent, at, cycle.directions, cycle.thermal);
            }
        };
        let [first, second] = &mut cache.tangents;
        if !first.steps(cycle.drive).1 {
            if second.steps(cycle.drive).1 {
                core::mem::swap(first, second);
            } else {
                renew(first, cycle.drive);
            }
        }
        let back = if first.steps(cycle.feedback).1 {
            &*first
        } else {
            if !second.steps(cycle.feedback).1 {
                renew(second, cycle.feedback);
            }
            &*second
        };
        let wanted = self.solved(first, &first.steps(cycle.drive).0, cycle, passes, clamped);
        let mut pose = read(back, &back.steps(cycle.feedback).0, needs_tilt);
        if N == 3 && needs_tilt {
            // The form for three slides has no direction.
            let feedback = self.coordinates(cycle.feedback);
            let query = Query::at(&feedback, cycle.directions, cycle.thermal);
            pose.1 = V3::from_glam(self.pose_error(&query, &mut 0).orientation);
        }
        (wanted, pose)
    }

    /// The correction from a tangent: `passes` passes from the correction sent last.
    ///
    /// With κ the norm of the errors' Jacobian, c the correction sent and r* the exact one, the error after p passes is
    /// at most `κ^p |c − r*|`.
    #[inline(always)]
    fn solved(
        &self,
        tangent: &Tangent<R, P, N>,
        steps: &[R; N],
        cycle: &Cycle<'_, R, P, N>,
        passes: u8,
        clamped: &mut u8,
    ) -> [R; N] {
        *clamped |= tangent.edge;
        if !self.upright {
            return self.solved_in_poses(tangent, steps, cycle, passes);
        }
        let mut correction = [R::ZERO; N];
        keep_present(&self.chain.present, tangent.tip(steps), &mut correction);
        if passes > 1 {
            let sent = sent(cycle);
            for _ in 1..passes & PASSES_MASK {
                let mut there = *steps;
                for ((there, correction), sent) in there.iter_mut().zip(&correction).zip(&sent).take(3) {
                    *there += (*correction - *sent) * R::of(1.0 / P::STEP);
                }
                keep_present(&self.chain.present, tangent.tip(&there), &mut correction);
            }
        }
        correction
    }

    /// [`Volumetric::solved`] if the slides turn or the direction is corrected.
    #[inline(never)]
    fn solved_in_poses(
        &self,
        tangent: &Tangent<R, P, N>,
        steps: &[R; N],
        cycle: &Cycle<'_, R, P, N>,
        passes: u8,
    ) -> [R; N] {
        let sent = sent(cycle);
        self.inverse(&self.coordinates(cycle.command), sent, passes, |_, correction, _| {
            let mut there = *steps;
            for ((there, correction), sent) in there.iter_mut().zip(correction).zip(&sent) {
                *there += (*correction - *sent) * R::of(1.0 / P::STEP);
            }
            (tangent.tip(&there), tangent.turn(&there))
        })
    }
}

/// The correction sent last, mm (deg).
#[inline(always)]
fn sent<R: Real, P: Position, const N: usize>(cycle: &Cycle<'_, R, P, N>) -> [R; N] {
    let mut sent = [R::ZERO; N];
    for ((sent, drive), command) in sent.iter_mut().zip(cycle.drive).zip(cycle.command) {
        *sent = drive.since_near(*command);
    }
    sent
}

/// `−error` along the slides that exist.
#[inline(always)]
fn keep_present<R: Real>(present: &[bool; 3], error: V3<R>, correction: &mut [R]) {
    for ((correction, error), present) in correction.iter_mut().zip(error.array()).zip(present) {
        *correction = if *present { -error } else { R::ZERO };
    }
}

#[inline(always)]
fn read<R: Real, P: Position, const N: usize>(tangent: &Tangent<R, P, N>, steps: &[R; N], needs_tilt: bool) -> Pose<R> {
    (tangent.tip(steps), if needs_tilt { tangent.turn(steps) } else { V3::ZERO })
}
