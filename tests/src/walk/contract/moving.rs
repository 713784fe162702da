//! One correction from cycle to cycle, compared with magnitude, slope and acceleration.

use crate::walk::facts::Bounds;
use crate::walk::scalar::Scalar;

/// Tolerance of the limits, as a share, in addition to the rounding of the scalar.
pub(super) const SHARE: f64 = 1e-6;

/// One correction of one axis, in double precision.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moving {
    pub(super) c: f64,
    pub(super) v: f64,
    /// Bound on |c| while limits that were lowered in motion are being reached.
    pub(super) ceiling: f64,
    /// Sizes of its summands, in the last cycle and the one before.
    others: [f64; 2],
}

impl Moving {
    /// A correction at rest.
    pub(super) fn at(c: f64) -> Self {
        Moving { c, ..Moving::default() }
    }
}

/// A change of a correction, with its bound on rounding.
struct Change {
    to: f64,
    by: f64,
    second: f64,
    rounding: f64,
}

impl Moving {
    /// Largest size of the other part in the last two cycles: its rounding still affects the velocity.
    pub(super) fn other(&self) -> f64 {
        self.others[0].max(self.others[1])
    }

    fn change<R: Scalar>(&self, to: f64, other: f64) -> Change {
        let by = to - self.c;
        let other = self.other().max(other.abs());
        // Splitting a correction into two parts and summing them rounds it twice more.
        let units = if other > 0.0 { 8.0 } else { 4.0 };
        let rounding = units * R::EPSILON.to_f64() * (to.abs().max(self.c.abs()) + other);
        Change { to, by, second: by - self.v, rounding }
    }

    /// Value at which a moving correction comes to rest; its speed is known to the rounding of the scalar.
    fn rests<R: Scalar>(&self, a: f64) -> f64 {
        let v = self.v.abs() + 4.0 * R::EPSILON.to_f64() * self.c.abs();
        self.c.abs() + v * v / (2.0 * a)
    }

    /// Applies new limits.
    pub(super) fn lowered<R: Scalar>(&mut self, bounds: &Bounds) {
        self.ceiling = self.rests::<R>(bounds.a).max(self.ceiling);
    }

    /// Takes the next value; returns whether it keeps the limits of magnitude, slope and acceleration.
    pub(super) fn keeps<R: Scalar>(&mut self, to: f64, other: f64, bounds: &Bounds) -> [bool; 3] {
        let Change { to, by, second, rounding } = self.change::<R>(to, other);
        let share = 1.0 + SHARE;
        // Over a thousand braking cycles, single precision accumulates a little more.
        let least = if R::EPSILON.to_f64() > 1e-10 { 1.0 + 10.0 * SHARE } else { share };
        if self.ceiling > 0.0 && self.rests::<R>(bounds.a) <= bounds.c {
            self.ceiling = 0.0;
        }
        let magnitude = to.abs() <= bounds.c.max(self.ceiling) * least + rounding;
        let slope = by.abs() <= bounds.v.max(self.v.abs() - bounds.a) * share + rounding;
        let acceleration = second.abs() <= bounds.a * share + rounding;
        (self.c, self.v, self.others) = (to, by, [other.abs(), self.others[0]]);
        [magnitude, slope, acceleration]
    }

    /// Stops the motion.
    pub(super) fn stop(&mut self) {
        self.v = 0.0;
    }
}
