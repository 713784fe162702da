//! Friction of a sliding mass.

use super::DriveSettings;

/// State of the friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Friction {
    /// Share of the sliding value, −1 to 1.
    share: f64,
}

impl Friction {
    /// The force against a motion of `velocity` during a step of `dt`, per moved mass.
    pub(super) fn drag(&mut self, velocity: f64, dt: f64, s: &DriveSettings) -> f64 {
        // Dahl's model, implicit: df = (v − |v| f) dt / z. Cannot overshoot ±1 whatever the velocity and the step.
        let travel = velocity * dt / s.presliding_mm;
        self.share = (self.share + travel) / (1.0 + travel.abs());
        let ratio = velocity / s.stribeck_velocity_mm_per_s;
        let sliding = s.coulomb_mm_per_s2 * (1.0 + s.stribeck_share / (1.0 + ratio * ratio));
        sliding * self.share + s.viscous_per_s * velocity
    }
}
