//! Squareness of the linear axes.

use crate::machine::LocationErrors;
use crate::real::Real;

/// Squareness C0Y, B0Z, A0Z (rad, ISO 230-1:2012): the error of the tip, mm in bed axes, at y and z from machine zero.
///
/// ```text
/// dx = −C0Y·y + B0Z·z          dy = −A0Z·z
/// ```
///
/// It tilts the direction of travel, so it is linear in the position and not clamped at a table's edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Squareness<R> {
    c0y: R,
    b0z: R,
    a0z: R,
}

impl<R: Real> Squareness<R> {
    pub(crate) fn of(location: &LocationErrors) -> Self {
        let LocationErrors { a0z, b0z, c0y, .. } = location;
        Squareness { c0y: R::of(*c0y), b0z: R::of(*b0z), a0z: R::of(*a0z) }
    }

    /// C0Y, B0Z, A0Z, rad.
    pub(crate) fn angles(&self) -> [R; 3] {
        [self.c0y, self.b0z, self.a0z]
    }

    /// dx that Y causes, mm.
    #[inline(always)]
    pub(crate) fn of_y(&self, y: R) -> R {
        -(self.c0y * y)
    }

    /// dx and dy that Z causes, mm.
    #[inline(always)]
    pub(crate) fn of_z(&self, z: R) -> [R; 2] {
        [self.b0z * z, -(self.a0z * z)]
    }

    /// dx and dy, mm.
    #[inline(always)]
    pub(crate) fn error(&self, y: R, z: R) -> [R; 2] {
        let [dx, dy] = self.of_z(z);
        [dx + self.of_y(y), dy]
    }

    /// dx and dy per mm of the axis in a slot (1 = Y, 2 = Z); zero for the others.
    #[inline(always)]
    pub(crate) fn slopes(&self, slot: usize) -> [R; 2] {
        match slot {
            1 => [-self.c0y, R::ZERO],
            2 => [self.b0z, -self.a0z],
            _ => [R::ZERO; 2],
        }
    }
}
