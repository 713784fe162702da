//! One axis' servo drive: position loop, velocity loop, moving mass with friction, lost motion.

use super::delay::Delay;
use super::variation::Variation;
use crate::range::Range;
use serde::{Deserialize, Serialize};
use trueaxis::machine::Axis;

/// Longest time step of the mechanics; a longer servo period is divided into several.
const MAX_STEP_S: f64 = 1e-4;

/// A drive and its axis. For a rotary axis, read degree for mm. Forces are per moved mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DriveSettings {
    /// Gain of the position loop Kv, 1/s.
    pub position_gain_per_s: f64,
    /// Share of the commanded velocity that is fed forward, 0 to 1: at constant velocity v the axis lags by
    /// (1 − share) · v / Kv.
    pub velocity_feed_forward: f64,
    /// Proportional gain of the velocity loop, 1/s (acceleration per velocity error).
    pub velocity_gain_per_s: f64,
    /// Reset time of the velocity loop, s.
    pub reset_time_s: f64,
    /// Time constant of the current loop, s.
    pub current_loop_s: f64,
    /// Largest acceleration that the motor can provide, mm/s².
    pub force_limit_mm_per_s2: f64,
    /// Coulomb friction, mm/s².
    pub coulomb_mm_per_s2: f64,
    /// Static friction above Coulomb friction, as a share of it.
    pub stribeck_share: f64,
    /// Velocity at which half of that share remains, mm/s.
    pub stribeck_velocity_mm_per_s: f64,
    /// Pre-sliding: travel over which friction reverses by 63 %, mm.
    pub presliding_mm: f64,
    /// Viscous friction, 1/s.
    pub viscous_per_s: f64,
    /// Dead time between a command and the position loop, s.
    pub dead_time_s: f64,
}

impl Default for DriveSettings {
    /// A tuned machine tool axis: lag 10 to 12 µm per 1000 mm/min; quadrant glitches of 1 to 3 µm on a circle of 50 mm
    /// radius at 1500 mm/min.
    fn default() -> DriveSettings {
        DriveSettings {
            position_gain_per_s: 110.0,
            velocity_feed_forward: 0.93,
            velocity_gain_per_s: 800.0,
            reset_time_s: 0.006,
            current_loop_s: 2.5e-4,
            force_limit_mm_per_s2: 10_000.0,
            coulomb_mm_per_s2: 420.0,
            stribeck_share: 0.3,
            stribeck_velocity_mm_per_s: 2.0,
            presliding_mm: 0.006,
            viscous_per_s: 4.0,
            dead_time_s: 0.0,
        }
    }
}

impl DriveSettings {
    /// The default drive of an axis.
    pub fn of(axis: Axis) -> DriveSettings {
        DriveSettings::default().varied(&Variation::of(axis))
    }

    /// The drive of an axis whose gains and friction differ from the common ones.
    pub fn varied(&self, by: &Variation) -> DriveSettings {
        DriveSettings {
            position_gain_per_s: self.position_gain_per_s * by.gain_factor,
            velocity_gain_per_s: self.velocity_gain_per_s * by.gain_factor,
            coulomb_mm_per_s2: self.coulomb_mm_per_s2 * by.friction_factor,
            ..*self
        }
    }

    /// Name, value and range of every setting.
    pub(crate) fn ranges(&self) -> [Range<'static>; 12] {
        let range = |key, found, low, high, unit| Range { key, found, low, high, unit };
        [
            range("position_gain_per_s", self.position_gain_per_s, 1.0, 1000.0, "1/s"),
            range("velocity_feed_forward", self.velocity_feed_forward, 0.0, 1.0, ""),
            range("velocity_gain_per_s", self.velocity_gain_per_s, 10.0, 4000.0, "1/s"),
            range("reset_time_s", self.reset_time_s, 1e-3, 10.0, "s"),
            range("current_loop_s", self.current_loop_s, 1e-6, 0.1, "s"),
            range("force_limit_mm_per_s2", self.force_limit_mm_per_s2, 1.0, 1e6, "mm/s²"),
            range("coulomb_mm_per_s2", self.coulomb_mm_per_s2, 0.0, 1e5, "mm/s²"),
            range("stribeck_share", self.stribeck_share, 0.0, 10.0, ""),
            range("stribeck_velocity_mm_per_s", self.stribeck_velocity_mm_per_s, 1e-3, 1000.0, "mm/s"),
            range("presliding_mm", self.presliding_mm, 1e-6, 1.0, "mm"),
            range("viscous_per_s", self.viscous_per_s, 0.0, 1000.0, "1/s"),
            range("dead_time_s", self.dead_time_s, 0.0, 0.1, "s"),
        ]
    }
}

/// State of one drive and its axis; the encoder sits on the motor side of the lost motion.
#[derive(Clone, Debug)]
pub struct Drive {
    settings: DriveSettings,
    period_s: f64,
    steps: u32,
    step_s: f64,
    current_share: f64,
    delay: Delay,
    /// Latest command received, and latest command of the position loop.
    entered: f64,
    command: f64,
    position: f64,
    velocity: f64,
    acceleration: f64,
    integral: f64,
    /// Friction as a share of its sliding value, −1 to 1.
    friction: f64,
}

impl Drive {
    /// A drive at rest at 0.
    pub fn new(settings: DriveSettings, period_s: f64) -> Drive {
        let steps = (period_s / MAX_STEP_S - 1e-9).ceil().max(1.0);
        let step_s = period_s / steps;
        Drive {
            settings,
            period_s,
            steps: steps as u32,
            step_s,
            current_share: current_share(step_s, &settings),
            delay: Delay::new(0.0, settings.dead_time_s / period_s),
            entered: 0.0,
            command: 0.0,
            position: 0.0,
            velocity: 0.0,
            acceleration: 0.0,
            integral: 0.0,
            friction: 0.0,
        }
    }

    /// Sets the axis at rest at `position` (mm, deg).
    pub fn rest_at(&mut self, position: f64) {
        let delay = Delay::new(position, self.settings.dead_time_s / self.period_s);
        *self =
            Drive { delay, entered: position, command: position, position, ..Drive::new(self.settings, self.period_s) };
    }

    /// Position on the encoder's side, mm (deg).
    pub fn position(&self) -> f64 {
        self.position
    }

    /// Velocity, mm/s (deg/s).
    pub fn velocity(&self) -> f64 {
        self.velocity
    }

    /// Simulates one servo cycle, which for the drive lasts `periods` periods (1 unless the control is late, at most 1000).
    ///
    /// `command`: required position of the axis at the end of the period; a command that is not finite is replaced by the last
    /// one. `measured`: the encoder's reading at the end of the previous cycle, which closes the position loop:
    ///
    /// ```text
    /// v_ref = Kv (command_k−1 − measured_k−1) + share (command_k − command_k−1)/T
    /// ```
    ///
    /// The position loop receives its commands after the dead time.
    pub fn cycle(&mut self, command: f64, measured: f64, periods: f64) {
        self.entered = if command.is_finite() { command } else { self.entered };
        let command = self.delay.next(self.entered);
        let s = &self.settings;
        let proportional = s.position_gain_per_s * (self.command - measured);
        let reference = proportional + s.velocity_feed_forward * (command - self.command) / self.period_s;
        for _ in 0..self.steps {
            self.advance(reference, self.step_s, self.current_share);
        }
        self.command = command;
        let mut overdue = (periods.min(1000.0) - 1.0) * self.period_s;
        while overdue > 0.0 {
            // Until the late control responds, the drive stays on the last set point, without feed-forward.
            let step = overdue.min(self.step_s);
            let holding = self.settings.position_gain_per_s * (command - self.position);
            self.advance(holding, step, current_share(step, &self.settings));
            overdue -= self.step_s;
        }
    }

    /// One step of velocity loop, current loop and mass (semi-implicit Euler).
    fn advance(&mut self, reference: f64, dt: f64, current_share: f64) {
        let s = &self.settings;
        let error = reference - self.velocity;
        let integral = self.integral + error * dt / s.reset_time_s;
        let wanted = s.velocity_gain_per_s * (error + integral);
        let given = wanted.max(-s.force_limit_mm_per_s2).min(s.force_limit_mm_per_s2);
        if given == wanted {
            self.integral = integral;
        }
        self.acceleration += current_share * (given - self.acceleration);
        // Dahl's model, implicit: df = (v − |v| f) dt / z. Cannot overshoot ±1 whatever the velocity and the step.
        let travel = self.velocity * dt / s.presliding_mm;
        self.friction = (self.friction + travel) / (1.0 + travel.abs());
        let ratio = self.velocity / s.stribeck_velocity_mm_per_s;
        let sliding = s.coulomb_mm_per_s2 * (1.0 + s.stribeck_share / (1.0 + ratio * ratio));
        let drag = sliding * self.friction + s.viscous_per_s * self.velocity;
        self.velocity += (self.acceleration - drag) * dt;
        self.position += self.velocity * dt;
    }
}

/// Share of a change of force that the current loop has completed after `dt`.
fn current_share(dt: f64, settings: &DriveSettings) -> f64 {
    1.0 - libm::exp(-dt / settings.current_loop_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lags_by_the_velocity_that_is_not_fed_forward() {
        for period in [1e-4, 2.5e-4, 1e-3] {
            let settings = DriveSettings::of(Axis::X);
            let mut drive = Drive::new(settings, period);
            let velocity = 25.0;
            let mut command = 0.0;
            for k in 1..=(1.0 / period) as u32 {
                command = velocity * f64::from(k) * period;
                drive.cycle(command, drive.position(), 1.0);
            }
            let designed = velocity * (1.0 - settings.velocity_feed_forward) / settings.position_gain_per_s;
            let lag = command - drive.position();
            assert!((lag / designed - 1.0).abs() < 1e-3, "period {period}: lag {lag}, designed {designed}");
        }
    }

    #[test]
    fn a_step_settles_without_much_overshoot_and_within_the_force_limit() {
        let settings = DriveSettings::of(Axis::Y);
        let mut drive = Drive::new(settings, 1e-4);
        let (mut top, mut before): (f64, f64) = (0.0, 0.0);
        for _ in 0..20_000 {
            drive.cycle(1.0, drive.position(), 1.0);
            top = top.max(drive.position());
            let acceleration = (drive.velocity() - before) / 1e-4;
            // Friction can add to the motor's braking.
            let friction = 1.3 * settings.coulomb_mm_per_s2 + settings.viscous_per_s * before.abs();
            assert!(acceleration.abs() <= settings.force_limit_mm_per_s2 + friction + 1.0);
            before = drive.velocity();
        }
        assert!((drive.position() - 1.0).abs() < 5e-4, "{}", drive.position());
        assert!(top < 1.35, "{top}");
    }

    #[test]
    fn a_command_that_is_not_finite_is_ignored() {
        let mut drive = Drive::new(DriveSettings::of(Axis::X), 1e-4);
        drive.rest_at(3.0);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            drive.cycle(bad, 3.0, 1.0);
        }
        assert_eq!(drive.position(), 3.0);
    }

    #[test]
    fn absurd_commands_leave_the_state_finite() {
        let mut drive = Drive::new(DriveSettings::of(Axis::X), 1e-4);
        for bad in [f64::MAX, f64::MIN, f64::MAX, 1e200, 0.0] {
            drive.cycle(bad, drive.position(), 2.5);
        }
        for _ in 0..50_000 {
            drive.cycle(0.0, drive.position(), 1.0);
        }
        assert!(drive.position().abs() < 1e-3, "{}", drive.position());
    }

    #[test]
    fn dead_time_adds_to_the_lag() {
        let velocity = 25.0;
        let lag = |dead_time_s: f64| {
            let mut drive = Drive::new(DriveSettings { dead_time_s, ..DriveSettings::of(Axis::X) }, 1e-4);
            for k in 1..=10_000 {
                drive.cycle(velocity * f64::from(k) * 1e-4, drive.position(), 1.0);
            }
            velocity - drive.position()
        };
        let more = lag(0.00125) - lag(0.0);
        assert!((more / (velocity * 0.00125) - 1.0).abs() < 1e-3, "{more}");
    }
}
