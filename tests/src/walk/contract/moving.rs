//! One correction from cycle to cycle, against magnitude, slope and acceleration.

use crate::walk::facts::Bounds;
use crate::walk::scalar::Scalar;

/// Limits hold to this share, and to the rounding of the scalar.
pub(super) const SHARE: f64 = 1e-6;

/// One correction of one axis, in doubles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moving {
    pub(super) c: f64,
    pub(super) v: f64,
    /// Largest |c| while limits lowered in motion are being reached.
    pub(super) ceiling: f64,
    /// Sizes of what it was added up from, in this cycle and the two before.
    beside: [f64; 2],
}

impl Moving {
    /// At rest.
    pub(super) fn at(c: f64) -> Self {
        Moving { c, ..Moving::default() }
    }
}

/// A change of a correction, with what rounding may add.
struct Change {
    to: f64,
    by: f64,
    second: f64,
    rounding: f64,
}

impl Moving {
    /// Largest size of what was sent beside it in the last two cycles: its rounding is in the velocity still.
    pub(super) fn beside(&self) -> f64 {
        self.beside[0].max(self.beside[1])
    }

    fn change<R: Scalar>(&self, to: f64, beside: f64) -> Change {
        let by = to - self.c;
        let beside = self.beside().max(beside.abs());
        // Split into two parts and added up again, a correction is rounded twice more.
        let units = if beside > 0.0 { 8.0 } else { 4.0 };
        let rounding = units * R::EPSILON.to_f64() * (to.abs().max(self.c.abs()) + beside);
        Change { to, by, second: by - self.v, rounding }
    }

    /// Where a correction that moves comes to rest; its speed is known to the rounding of the scalar.
    fn rests<R: Scalar>(&self, a: f64) -> f64 {
        let v = self.v.abs() + 4.0 * R::EPSILON.to_f64() * self.c.abs();
        self.c.abs() + v * v / (2.0 * a)
    }

    /// Other limits are in force from now on.
    pub(super) fn lowered<R: Scalar>(&mut self, bounds: &Bounds) {
        self.ceiling = self.rests::<R>(bounds.a).max(self.ceiling);
    }

    /// Takes the next value; which of magnitude, slope and acceleration it keeps.
    pub(super) fn keeps<R: Scalar>(&mut self, to: f64, beside: f64, bounds: &Bounds) -> [bool; 3] {
        let Change { to, by, second, rounding } = self.change::<R>(to, beside);
        let share = 1.0 + SHARE;
        // Braking for a thousand cycles, single precision adds up to a little more.
        let least = if R::EPSILON.to_f64() > 1e-10 { 1.0 + 10.0 * SHARE } else { share };
        if self.ceiling > 0.0 && self.rests::<R>(bounds.a) <= bounds.c {
            self.ceiling = 0.0;
        }
        let magnitude = to.abs() <= bounds.c.max(self.ceiling) * least + rounding;
        let slope = by.abs() <= bounds.v.max(self.v.abs() - bounds.a) * share + rounding;
        let acceleration = second.abs() <= bounds.a * share + rounding;
        (self.c, self.v, self.beside) = (to, by, [beside.abs(), self.beside[0]]);
        [magnitude, slope, acceleration]
    }

    /// Stands.
    pub(super) fn stop(&mut self) {
        self.v = 0.0;
    }
}
