//! State of the dynamic correction, carried from cycle to cycle.

#![deny(clippy::indexing_slicing)]

use super::Dynamics;
use super::adapt::Factors;
use super::adapted::Adapted;
use super::common::Shared;
use super::evidence::Worth;
use super::feed_forward::Drift;
use super::feedback::{Heading, NotchState};
use super::harm::{Trial, Wave};
use super::watch::Swing;
use crate::error::Fault;
use crate::limiter::LimiterState;
use crate::position::Position;
use crate::real::Real;
use crate::telemetry::Status;

/// Mutable half of the stage, and the geometric part of the corrections sent by the output stage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DynamicState<R, P: Position, const N: usize> {
    pub(super) drift: [Drift<R>; N],
    pub(super) adapted: Adapted<R, P, N>,
    pub(super) shared: [Shared<R>; N],
    /// Share of the common part that was sent last.
    pub(super) share: R,
    pub(super) limited: [LimiterState<R>; N],
    pub(super) integral: [R; N],
    /// Notches of the feedback, by linear axis.
    pub(super) notched: [NotchState<R>; 3],
    pub(super) swing: [Swing; N],
    pub(super) heading: [Heading<R>; N],
    /// Oscillations of the tip, and what the feedback does to them.
    pub(super) waves: [Wave<R>; 3],
    pub(super) trial: Trial<R>,
    /// Shares of the feed-forward.
    pub(super) worth: Worth<R>,
    /// Whether the watch has ramped the feedback out.
    pub(super) out: bool,
    /// The parts of the last cycle.
    pub(super) parts: Dynamics,
    /// Whether the next cycle starts from rest, with distances measured from there.
    pub(super) fresh: bool,
    /// Command at the end of the last move, and the rate-limited geometric correction there.
    pub(super) command: [P; N],
    pub(super) geometric_before: [R; N],
    /// Change of the command in the last cycle.
    pub(super) trend: [R; N],
    /// Geometric correction, rate-limited ahead of the axis limiter.
    ramped: [LimiterState<R>; N],
    /// Geometric correction sent last, mm (deg), also as a position offset, and the resulting drive position.
    pub(super) geometric: [R; N],
    offsets: [P::Offset; N],
    drive: [P; N],
    /// Number of the cycle for which this state is valid.
    next: u32,
}

impl<R: Real, P: Position, const N: usize> DynamicState<R, P, N> {
    /// The state before the first cycle.
    pub(crate) fn new() -> Self {
        DynamicState {
            drift: [Drift::default(); N],
            adapted: Adapted::new(),
            shared: [Shared::default(); N],
            share: R::ONE,
            limited: [LimiterState::default(); N],
            integral: [R::ZERO; N],
            notched: [NotchState::default(); 3],
            swing: [Swing::default(); N],
            heading: [Heading::new(); N],
            waves: [Wave::default(); 3],
            trial: Trial::new(),
            worth: Worth::new(false),
            out: false,
            parts: Dynamics::NONE,
            fresh: true,
            command: [P::default(); N],
            geometric_before: [R::ZERO; N],
            trend: [R::ZERO; N],
            ramped: [LimiterState::default(); N],
            geometric: [R::ZERO; N],
            offsets: [P::offset(R::ZERO); N],
            drive: [P::default(); N],
            next: 0,
        }
    }

    /// Whether this state is from the cycle before `cycle`: `false` after cycles of a loop without dynamic correction.
    #[inline(always)]
    pub(crate) fn is_for(&self, cycle: u32) -> bool {
        self.next == cycle
    }

    /// Restarts: the entire correction sent is geometric.
    #[cold]
    pub(crate) fn begin(&mut self, sent: [R; N], offsets: &[P::Offset; N], drive: &[P; N]) {
        let ramped = sent.map(LimiterState::at_rest);
        *self = DynamicState { ramped, geometric: sent, offsets: *offsets, drive: *drive, ..DynamicState::new() };
    }

    /// Ends the cycle: the correction sent by the axis limiter, minus the dynamic part, is geometric.
    #[inline(always)]
    pub(crate) fn settle(&mut self, sent: [R; N], command: Option<&[P; N]>, cycle: u32) {
        self.next = cycle.wrapping_add(1);
        let Some(command) = command else { return };
        let parts = self.geometric.iter_mut().zip(&mut self.offsets).zip(self.drive.iter_mut().zip(command));
        for (((geometric, offset), (drive, command)), (sent, limited)) in parts.zip(sent.iter().zip(&self.limited)) {
            *geometric = *sent - limited.sent();
            *offset = P::offset(*geometric);
            *drive = command.moved(*offset);
        }
    }

    /// Takes back a cycle that sent nothing.
    #[cold]
    pub(crate) fn take_back(&mut self, sent: [R; N]) {
        self.ramped = self.geometric.map(LimiterState::at_rest);
        self.limited = sent.map(LimiterState::at_rest);
        self.rest();
    }

    /// Sets the drives to rest: the next distance is measured from here.
    pub(super) fn rest(&mut self) {
        self.fresh = true;
        self.trend = [R::ZERO; N];
        self.notched = [NotchState::default(); 3];
        self.drift.iter_mut().for_each(Drift::rest);
        self.shared.iter_mut().for_each(Shared::rest);
        self.worth.supplied();
    }

    /// Dynamic corrections sent last.
    #[inline(always)]
    pub(crate) fn sent(&self) -> [R; N] {
        self.limited.map(|limited| limited.sent())
    }

    /// Rate-limited geometric corrections.
    #[inline(always)]
    pub(crate) fn ramped_mut(&mut self) -> &mut [LimiterState<R>; N] {
        &mut self.ramped
    }

    /// Geometric corrections sent last.
    #[inline(always)]
    pub(crate) fn geometric(&self) -> &[R; N] {
        &self.geometric
    }

    /// Geometric corrections sent last, as position offsets.
    #[inline(always)]
    pub(crate) fn offsets(&self) -> &[P::Offset; N] {
        &self.offsets
    }

    pub(crate) fn offsets_mut(&mut self) -> &mut [P::Offset; N] {
        &mut self.offsets
    }

    /// Command plus geometric correction of the last cycle.
    #[inline(always)]
    pub(crate) fn drive(&self) -> &[P; N] {
        &self.drive
    }

    /// Changes of the commands in the last cycle.
    #[inline(always)]
    pub(crate) fn trend_mut(&mut self) -> &mut [R; N] {
        &mut self.trend
    }

    /// Freezes the friction where it is, or lets it adapt again.
    pub(crate) fn freeze_friction(&mut self, frozen: bool) {
        self.adapted.freeze(frozen);
    }

    /// Returns to the identified friction.
    pub(crate) fn reset_friction(&mut self) {
        self.adapted.clear();
        self.drift.iter_mut().for_each(|drift| drift.factors = Factors::default());
    }

    /// The fault of the friction, and its axis.
    #[inline(always)]
    pub(crate) fn friction_fault(&self) -> Option<(Fault, u8)> {
        self.adapted.fault()
    }

    /// Which parts the watches have led out.
    #[inline(always)]
    pub(crate) fn led_out(&self) -> Status {
        let [friction, following] = self.worth.out();
        Status::default()
            .with(Status::FEEDBACK_OUT, self.out)
            .with(Status::FRICTION_OUT, friction)
            .with(Status::LAG_OUT, following)
    }
}
