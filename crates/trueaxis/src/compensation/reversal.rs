//! Direction of travel with a hysteresis band.

use crate::position::Position;
use crate::real::Real;

/// Direction of travel of an axis.
///
/// Stored as the mask with which the step selects the half of a table, so that the selection costs one instruction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Direction(usize);

impl Direction {
    /// Towards larger positions: the forward columns of a table.
    pub const POSITIVE: Direction = Direction(0);
    /// Towards smaller positions: the reverse columns and the backlash.
    pub const NEGATIVE: Direction = Direction(usize::MAX);

    /// Negative or positive.
    pub const fn of(is_negative: bool) -> Direction {
        if is_negative { Direction::NEGATIVE } else { Direction::POSITIVE }
    }

    /// Zero in positive travel, all ones in negative travel.
    #[inline(always)]
    pub(super) const fn mask(self) -> usize {
        self.0
    }

    #[inline(always)]
    const fn turned(self) -> Direction {
        Direction(!self.0)
    }
}

/// Direction in which the drive of an axis travels. The drive decides, not the command, because a correction takes up
/// lost motion like any other motion.
///
/// The turning point follows the drive while it continues in its direction; the direction changes once the drive has
/// moved back from the turning point by more than the band, so dither within the band at standstill toggles nothing.
/// Positive lost motion makes the correction step in the new direction, which confirms it; a step against it must stay
/// within the band ([`crate::check::reversal`]). Cost: one subtraction and two comparisons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reversal<P> {
    turning_point: P,
    direction: Direction,
}

impl<P: Position> Reversal<P> {
    /// Starts at a position, in positive travel.
    pub fn at(position: P) -> Self {
        Reversal { turning_point: position, direction: Direction::POSITIVE }
    }

    /// Updates with the drive's position, command plus correction; `band` in mm (deg). Returns the direction.
    #[inline(always)]
    pub fn update<R: Real>(&mut self, drive: P, band: R) -> Direction {
        let moved: R = drive.since_near(self.turning_point);
        let (onward, back) = if self.direction == Direction::POSITIVE {
            (moved > R::ZERO, moved < -band)
        } else {
            (moved < R::ZERO, moved > band)
        };
        if onward || back {
            self.turning_point = drive;
        }
        if back {
            self.direction = self.direction.turned();
        }
        self.direction
    }

    /// Fast form of [`Reversal::update`]. It returns `true` if the direction stays: the drive moves on, or has moved
    /// back by at most `within`, the band in steps rounded down. Otherwise it returns `false` and changes nothing; only
    /// the full update can then decide.
    #[inline(always)]
    pub(crate) fn continues(&mut self, drive: P, within: P::Reach) -> bool {
        let onward = if self.direction == Direction::POSITIVE {
            drive >= self.turning_point
        } else {
            drive <= self.turning_point
        };
        if onward {
            self.turning_point = drive;
        }
        onward || drive.apart(self.turning_point) <= within
    }

    /// Forces a reversal: the next [`Reversal::update`] of a drive at `drive`, or farther on, reports it.
    #[inline(always)]
    pub(crate) fn turn<R: Real>(&mut self, drive: P, band: R) {
        let beyond = band + band + R::of(2.0 * P::STEP.min(1e-6));
        self.turning_point =
            if self.direction == Direction::POSITIVE { drive.plus(beyond) } else { drive.plus(-beyond) };
    }

    /// The current direction.
    #[inline(always)]
    pub fn direction(&self) -> Direction {
        self.direction
    }
}
