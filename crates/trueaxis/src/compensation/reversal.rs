//! Direction of travel with a hysteresis band.

use crate::position::Position;
use crate::real::Real;

/// Which way an axis travels; a command that dithers within the band at standstill does not toggle it.
///
/// The turning point follows the command while it goes on in its direction; the direction changes once the command has
/// come back from the turning point by more than the band. Cost: one subtraction and two comparisons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reversal<P> {
    turning_point: P,
    /// All ones in negative travel, zero in positive: a mask for table offsets.
    reverse: usize,
}

impl<P: Position> Reversal<P> {
    /// Starts at a position, in positive travel.
    pub fn at(position: P) -> Self {
        Reversal { turning_point: position, reverse: 0 }
    }

    /// Takes the command of this cycle; `band` in mm (deg). Returns the mask: all ones in negative travel.
    #[inline(always)]
    pub fn update<R: Real>(&mut self, command: P, band: R) -> usize {
        let moved: R = command.since(self.turning_point);
        let (onward, back) =
            if self.reverse == 0 { (moved > R::ZERO, moved < -band) } else { (moved < R::ZERO, moved > band) };
        if onward || back {
            self.turning_point = command;
        }
        if back {
            self.reverse = !self.reverse;
        }
        self.reverse
    }

    /// The mask as it stands.
    #[inline(always)]
    pub fn mask(&self) -> usize {
        self.reverse
    }
}
