//! State of the friction that adapts, beside the factors of the axes.

#![deny(clippy::indexing_slicing)]

use super::spike::Spike;
use crate::error::Fault;
use crate::position::Position;
use crate::real::Real;

/// State of the adaptation of all axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Adapted<R, P, const N: usize> {
    pub(super) spike: Spike<R, P>,
    /// Reversals with the wrong sign, and windows with stick-slip, in a row, by axis.
    pub(super) reversed: [u8; N],
    pub(super) stuck: [u8; N],
    /// The first fault since the last reset, and its axis.
    pub(super) fault: Fault,
    pub(super) slot: u8,
    /// Whether the host has stopped it.
    pub(super) frozen: bool,
}

impl<R: Real, P: Position, const N: usize> Adapted<R, P, N> {
    pub(super) fn new() -> Self {
        let none = [0; N];
        Adapted { spike: Spike::default(), reversed: none, stuck: none, fault: Fault::None, slot: 0, frozen: false }
    }

    /// Forgets faults, and the window in progress.
    pub(super) fn clear(&mut self) {
        *self = Adapted { frozen: self.frozen, ..Adapted::new() };
    }

    /// The fault and its axis.
    pub(super) fn fault(&self) -> Option<(Fault, u8)> {
        (self.fault != Fault::None).then_some((self.fault, self.slot))
    }

    /// Freezes the factors, or lets them follow again.
    pub(super) fn freeze(&mut self, frozen: bool) {
        self.frozen = frozen;
        self.spike.end();
    }
}
