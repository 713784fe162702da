//! Direction of travel with a hysteresis band.

use crate::position::Position;
use crate::real::Real;

/// Which way an axis travels: its drive, not its command, because a correction takes up lost motion like any other way.
///
/// The turning point follows the drive while it goes on in its direction; the direction changes once the drive has come
/// back from the turning point by more than the band, so that a dither within it at standstill toggles nothing. Lost motion
/// that is positive makes the correction step in the new direction, which confirms it; what steps against it has to stay
/// within the band ([`crate::check::reversal`]). Cost: one subtraction and two comparisons.
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

    /// Takes the drive's position, command plus correction; `band` in mm (deg). Returns the mask: all ones in negative travel.
    #[inline(always)]
    pub fn update<R: Real>(&mut self, drive: P, band: R) -> usize {
        let moved: R = drive.since_near(self.turning_point);
        let (onward, back) =
            if self.reverse == 0 { (moved > R::ZERO, moved < -band) } else { (moved < R::ZERO, moved > band) };
        if onward || back {
            self.turning_point = drive;
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
