//! The straight way of a probing move.

use glam::DVec3;

/// Up to this distance the ball is in contact, mm: a trip is rounded when work offsets are subtracted and added.
pub(super) const CONTACT: f64 = 1e-6;

/// Straight way of the ball's centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) start: DVec3,
    pub(super) change: DVec3,
}

impl Way {
    pub(super) fn at(&self, share: f64) -> DVec3 {
        self.start + share * self.change
    }
}
