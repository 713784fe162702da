//! Tangents cached from cycle to cycle, for command and feedback.

#![deny(clippy::indexing_slicing)]

use super::Volumetric;
use super::slides::Work;
use super::tangent::{Pose, Tangent};
use crate::compensation::reversal::Direction;
use crate::compensation::thermal::ThermalLine;
use crate::compensation::{CycleGrids, InverseEnd, PASSES_MASK, Tables};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

/// Error of the inverse, mm, beside that of a tangent.
const INVERSE_MM: f64 = 0.2e-6;

/// Two tangents: one at the drive position, and one for a feedback on the other side of a table point. Either serves
/// both positions.
///
/// A position outside both is looked up in the tables themselves while a new tangent is made, the drive's before the
/// feedback's: for three slides one slide a cycle, otherwise the whole in one cycle.
///
/// The cache drops them when an axis changes its direction of travel, when the host sets the thermal growth, and when
/// the tables change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TangentCache<R, P: Position, const N: usize> {
    key: u64,
    directions: [Direction; N],
    /// Whether the second tangent is the one at the drive position.
    turned: bool,
    /// Whether `work` is on the second tangent.
    on_second: bool,
    end: InverseEnd<R>,
    tangents: [Tangent<R, P, N>; 2],
    work: Work<P, N>,
}

/// A tangent that holds a position, and the steps from its corner.
type Held<'t, R, P, const N: usize> = (&'t Tangent<R, P, N>, [R; N]);

impl<R: Real, P: Position, const N: usize> TangentCache<R, P, N> {
    /// The key that belongs to no tables: theirs are odd.
    const NONE: u64 = 0;

    /// An empty cache.
    pub(crate) fn empty() -> Self {
        TangentCache {
            key: Self::NONE,
            directions: [Direction::POSITIVE; N],
            turned: false,
            on_second: false,
            end: InverseEnd::NEVER,
            tangents: [Tangent::empty(); 2],
            work: Work::none(),
        }
    }

    /// Empties the cache: the next lookup reads the tables.
    #[inline(always)]
    pub(crate) fn forget(&mut self) {
        self.key = Self::NONE;
    }

    /// The tangents, the one at the drive position first.
    #[inline(always)]
    fn pair(&self) -> [&Tangent<R, P, N>; 2] {
        let [first, second] = &self.tangents;
        if self.turned { [second, first] } else { [first, second] }
    }

    /// The tangent that holds a position.
    #[inline(always)]
    fn held(&self, at: &[P; N]) -> Option<Held<'_, R, P, N>> {
        self.pair().into_iter().find_map(|tangent| {
            let (steps, inside) = tangent.steps(at);
            inside.then_some((tangent, steps))
        })
    }
}

/// Inputs of a cycle's lookups.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cycle<'c, R, P: Position, const N: usize> {
    /// Command.
    pub(crate) command: &'c [P; N],
    /// Command with the correction sent last.
    pub(crate) drive: &'c [P; N],
    /// Feedback.
    pub(crate) feedback: &'c [P; N],
    pub(crate) directions: &'c [Direction; N],
    pub(crate) thermal: &'c [ThermalLine<R>; N],
    /// Bounds of the inverse.
    pub(crate) tables: &'c Tables<R, P>,
}

// Only with volumetric.
impl<R: Real, P: Position, const N: usize> Volumetric<'_, R, P, N> {
    /// The wanted correction, and the error of the pose at the feedback (its direction only if `needs_tilt`).
    ///
    /// Evaluates the cached tangents; a position outside them is looked up, out of line.
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
        let [first, second] = cache.pair();
        let (steps, inside) = first.steps(cycle.drive);
        let (steps_back, same) = first.steps(cycle.feedback);
        if !changed & inside & same {
            return (
                self.solved((first, steps), cycle, passes, &cache.end, clamped),
                read(first, &steps_back, needs_tilt),
            );
        }
        let (steps_back, other) = second.steps(cycle.feedback);
        if !changed & inside & other {
            return (
                self.solved((first, steps), cycle, passes, &cache.end, clamped),
                read(second, &steps_back, needs_tilt),
            );
        }
        self.outside_tangents(cache, cycle, passes, needs_tilt, clamped)
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
        let (held, sent) = (cache.held(cycle.drive), sent(cycle));
        let direction = self.orientation.is_some();
        let command = self.coordinates(cycle.command);
        let wanted = self.inverse(&command, sent, passes, |at, correction, poses| {
            let (tip, turn) = self.near_drive(held.as_ref(), cycle, at, correction, &sent);
            let mut moved = [R::ZERO; 3];
            for ((moved, correction), sent) in moved.iter_mut().zip(correction).zip(&sent) {
                *moved = *correction - *sent;
            }
            let (of_grids, more) = grids.pose(grids.at_drives(moved), direction, || {
                let grids = grids.grids();
                let sum = if grids.swings() { self.swung(grids, at, poses) } else { grids.of_slides(&self.slides(at)) };
                *clamped |= sum.edge;
                sum
            });
            (tip + of_grids, turn + more)
        });
        let (of_grids, more) = grids
            .pose(grids.at_feedback(), needs_tilt, || self.of_grids(grids.grids(), &self.coordinates(cycle.feedback)));
        (wanted, (tip + of_grids, turn + if needs_tilt { more } else { V3::ZERO }))
    }

    /// Errors of tip and direction at a position `at` in table coordinates, the command with a correction: by the tangent at
    /// the drive position if there is one.
    #[inline(always)]
    fn near_drive(
        &self,
        held: Option<&Held<'_, R, P, N>>,
        cycle: &Cycle<'_, R, P, N>,
        at: &[R; N],
        correction: &[R; N],
        sent: &[R; N],
    ) -> Pose<R> {
        let Some((tangent, steps)) = held else {
            let pose = self.pose_error_at(at, cycle.directions, cycle.thermal, &mut 0);
            return (V3::from_glam(pose.tip), V3::from_glam(pose.orientation));
        };
        let mut there = *steps;
        for ((there, correction), sent) in there.iter_mut().zip(correction).zip(sent) {
            *there += (*correction - *sent) * R::of(1.0 / P::STEP);
        }
        (tangent.tip(&there), tangent.turn(&there))
    }

    /// [`Volumetric::modelled`] if a position is in neither box.
    #[cold]
    #[inline(never)]
    fn outside_tangents(
        &self,
        cache: &mut TangentCache<R, P, N>,
        cycle: &Cycle<'_, R, P, N>,
        passes: u8,
        needs_tilt: bool,
        clamped: &mut u8,
    ) -> ([R; N], Pose<R>) {
        if cache.key != self.key || cache.directions != *cycle.directions {
            (cache.key, cache.directions) = (self.key, *cycle.directions);
            cache.tangents.iter_mut().for_each(Tangent::clear);
            cache.work = Work::none();
            cache.end = cycle.tables.inverse_end(INVERSE_MM, cycle.thermal);
        }
        self.refill(cache, cycle);
        let wanted = match cache.held(cycle.drive) {
            Some(held) => self.solved(held, cycle, passes, &cache.end, clamped),
            None => self.solved_by_lookup(cycle, passes, &cache.end, clamped),
        };
        let mut pose = match cache.held(cycle.feedback) {
            Some((tangent, steps)) => read(tangent, &steps, needs_tilt),
            None => self.looked_up(cycle.feedback, cycle, &mut 0),
        };
        if N == 3 && needs_tilt {
            // The form for three slides has no direction.
            pose.1 = self.looked_up(cycle.feedback, cycle, &mut 0).1;
        }
        (wanted, pose)
    }

    /// Works on one tangent for the drive position or, if there is one, for the feedback.
    #[inline(never)]
    fn refill(&self, cache: &mut TangentCache<R, P, N>, cycle: &Cycle<'_, R, P, N>) {
        let [first, second] = cache.pair();
        let of_drive = [first.steps(cycle.drive).1, second.steps(cycle.drive).1];
        let of_feedback = [first.steps(cycle.feedback).1, second.steps(cycle.feedback).1];
        let drive_is_held = of_drive != [false; 2];
        if drive_is_held && of_feedback != [false; 2] {
            cache.turned ^= of_drive == [false, true];
            return;
        }
        // The tangent that holds the other position, if any, stays.
        let [stays, _] = if drive_is_held { of_drive } else { of_feedback };
        let wanted = if drive_is_held { cycle.feedback } else { cycle.drive };
        let begins = N != 3 || !cache.work.serves::<R>(wanted);
        if begins {
            cache.on_second = stays != cache.turned;
        }
        let TangentCache { tangents: [first, second], on_second, work, .. } = cache;
        let tangent = if *on_second { second } else { first };
        let done = if N != 3 {
            self.tangent(tangent, wanted, cycle.directions, cycle.thermal);
            true
        } else if begins {
            self.begin_slides(tangent, work, wanted, cycle.directions);
            false
        } else {
            self.add_slide(tangent, work, cycle.directions, cycle.thermal)
        };
        if done && !drive_is_held {
            cache.turned = cache.on_second;
        }
    }

    /// Errors of tip and direction at a position, from the tables themselves.
    #[inline(always)]
    fn looked_up(&self, at: &[P; N], cycle: &Cycle<'_, R, P, N>, clamped: &mut u8) -> Pose<R> {
        let pose = self.pose_error_at(&self.coordinates(at), cycle.directions, cycle.thermal, clamped);
        (V3::from_glam(pose.tip), V3::from_glam(pose.orientation))
    }

    /// The correction from a tangent: at most `passes` passes from the correction sent last.
    ///
    /// With κ the norm of the errors' Jacobian, c the correction sent and r* the exact one, the error after p passes is
    /// at most `κ^p |c − r*|`.
    #[inline(always)]
    fn solved(
        &self,
        (tangent, steps): Held<'_, R, P, N>,
        cycle: &Cycle<'_, R, P, N>,
        passes: u8,
        end: &InverseEnd<R>,
        clamped: &mut u8,
    ) -> [R; N] {
        *clamped |= tangent.edge;
        if !self.upright {
            return self.solved_in_poses(Some(&(tangent, steps)), cycle, passes);
        }
        let mut correction = [R::ZERO; N];
        keep_present(&self.chain.present, tangent.tip(&steps), &mut correction);
        if passes > 1 {
            let sent = sent(cycle);
            let mut before = sent;
            for _ in 1..passes & PASSES_MASK {
                if end.has_converged(apart_squared(&correction, &before)) {
                    break;
                }
                before = correction;
                let mut there = steps;
                for ((there, correction), sent) in there.iter_mut().zip(&correction).zip(&sent).take(3) {
                    *there += (*correction - *sent) * R::of(1.0 / P::STEP);
                }
                keep_present(&self.chain.present, tangent.tip(&there), &mut correction);
            }
        }
        correction
    }

    /// [`Volumetric::solved`] from the tables themselves. A correction that the limiter cannot send takes no second pass.
    #[inline(never)]
    fn solved_by_lookup(
        &self,
        cycle: &Cycle<'_, R, P, N>,
        passes: u8,
        end: &InverseEnd<R>,
        clamped: &mut u8,
    ) -> [R; N] {
        let (tip, _) = self.looked_up(cycle.drive, cycle, clamped);
        if !self.upright {
            return self.solved_in_poses(None, cycle, passes);
        }
        let mut correction = [R::ZERO; N];
        keep_present(&self.chain.present, tip, &mut correction);
        let mut before = sent(cycle);
        for _ in 1..passes & PASSES_MASK {
            if end.is_reached(apart_squared(&correction, &before)) {
                break;
            }
            before = correction;
            let mut at = *cycle.command;
            for (at, correction) in at.iter_mut().zip(&correction) {
                *at = at.moved(P::offset(*correction));
            }
            keep_present(&self.chain.present, self.looked_up(&at, cycle, &mut 0).0, &mut correction);
        }
        correction
    }

    /// [`Volumetric::solved`] if the slides turn or the direction is corrected.
    #[inline(never)]
    fn solved_in_poses(&self, held: Option<&Held<'_, R, P, N>>, cycle: &Cycle<'_, R, P, N>, passes: u8) -> [R; N] {
        let sent = sent(cycle);
        self.inverse(&self.coordinates(cycle.command), sent, passes, |at, correction, _| {
            self.near_drive(held, cycle, at, correction, &sent)
        })
    }
}

/// |a − b|² over the slides.
#[inline(always)]
fn apart_squared<R: Real, const N: usize>(a: &[R; N], b: &[R; N]) -> R {
    let mut square = R::ZERO;
    for (a, b) in a.iter().zip(b).take(3) {
        square += (*a - *b) * (*a - *b);
    }
    square
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
