//! One axis' servo drive: position loop, velocity loop, moving mass with friction, lost motion.

use trueaxis::machine::Axis;

/// Longest step of the mechanics; a slower servo is worked off in several.
const MAX_STEP_S: f64 = 1e-4;

/// A drive and its axis. For a rotary axis every mm reads degree. Forces are given per moved mass.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Largest acceleration that the motor can give, mm/s².
    pub force_limit_mm_per_s2: f64,
    /// Coulomb friction, mm/s².
    pub coulomb_mm_per_s2: f64,
    /// Static friction above Coulomb friction, as a share of it.
    pub stribeck_share: f64,
    /// Velocity at which half of that share is left, mm/s.
    pub stribeck_velocity_mm_per_s: f64,
    /// Pre-sliding: travel over which friction reverses by 63 % of the way, mm.
    pub presliding_mm: f64,
    /// Viscous friction, 1/s.
    pub viscous_per_s: f64,
}

impl DriveSettings {
    /// A tuned machine tool axis; gains and friction differ by a few per cent from axis to axis, as on real machines.
    ///
    /// Lag 10 to 12 µm per 1000 mm/min; quadrant glitches of 1 to 3 µm on a circle of 50 mm radius at 1500 mm/min.
    pub fn of(axis: Axis) -> DriveSettings {
        let (gain, friction) = match axis {
            Axis::X => (1.0, 1.0),
            Axis::Y => (0.97, 1.12),
            Axis::Z => (1.02, 1.25),
            Axis::A => (0.94, 0.9),
            Axis::B => (0.95, 0.95),
            Axis::C => (1.01, 0.8),
        };
        DriveSettings {
            position_gain_per_s: 110.0 * gain,
            velocity_feed_forward: 0.93,
            velocity_gain_per_s: 800.0 * gain,
            reset_time_s: 0.006,
            current_loop_s: 2.5e-4,
            force_limit_mm_per_s2: 10_000.0,
            coulomb_mm_per_s2: 420.0 * friction,
            stribeck_share: 0.3,
            stribeck_velocity_mm_per_s: 2.0,
            presliding_mm: 0.006,
            viscous_per_s: 4.0,
        }
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
            command: 0.0,
            position: 0.0,
            velocity: 0.0,
            acceleration: 0.0,
            integral: 0.0,
            friction: 0.0,
        }
    }

    /// Puts the axis to rest at `position` (mm, deg).
    pub fn rest_at(&mut self, position: f64) {
        *self = Drive { command: position, position, ..Drive::new(self.settings, self.period_s) };
    }

    /// Position on the encoder's side, mm (deg).
    pub fn position(&self) -> f64 {
        self.position
    }

    /// Velocity, mm/s (deg/s).
    pub fn velocity(&self) -> f64 {
        self.velocity
    }

    /// One servo cycle that the drive takes `periods` periods over (1 unless the control is late, at most 1000).
    ///
    /// `command`: where the axis should be at the end of the period; a command that is not finite is ignored, the last one
    /// holds. `measured`: the encoder's reading at the end of the previous cycle, which closes the position loop:
    ///
    /// ```text
    /// v_ref = Kv (command_k−1 − measured_k−1) + share (command_k − command_k−1)/T
    /// ```
    pub fn cycle(&mut self, command: f64, measured: f64, periods: f64) {
        let command = if command.is_finite() { command } else { self.command };
        let s = &self.settings;
        let proportional = s.position_gain_per_s * (self.command - measured);
        let reference = proportional + s.velocity_feed_forward * (command - self.command) / self.period_s;
        for _ in 0..self.steps {
            self.advance(reference, self.step_s, self.current_share);
        }
        self.command = command;
        let mut overdue = (periods.min(1000.0) - 1.0) * self.period_s;
        while overdue > 0.0 {
            // Until the late control shows up the drive stays on the last set point, without feed-forward.
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

/// Share of a change of force that the current loop has made after `dt`.
fn current_share(dt: f64, settings: &DriveSettings) -> f64 {
    1.0 - (-dt / settings.current_loop_s).exp()
}

/// Lost motion between encoder and carriage: a play that is traversed during each reversal.
///
/// The table holds in positive travel; in negative travel the carriage stays behind, actual − indicated = +backlash.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LostMotion {
    width: f64,
    reverse: f64,
}

impl LostMotion {
    /// A play of `width` mm (deg), approached in positive travel. A width of 0 switches at once.
    pub fn new(width: f64) -> LostMotion {
        LostMotion { width: width.abs(), reverse: 0.0 }
    }

    /// Follows the encoder's side by `travel` mm (deg).
    pub fn follow(&mut self, travel: f64) {
        let moved = if self.width > 0.0 { travel / self.width } else { travel * f64::MAX };
        self.reverse = (self.reverse - moved).clamp(0.0, 1.0);
    }

    /// Share of the play that is traversed: 0 in positive travel, 1 in negative travel.
    pub fn reverse(&self) -> f64 {
        self.reverse
    }
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
            // Friction can brake on top of the motor.
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
    fn play_is_traversed_within_its_width() {
        let mut play = LostMotion::new(0.010);
        play.follow(1.0);
        assert_eq!(play.reverse(), 0.0);
        play.follow(-0.004);
        assert!((play.reverse() - 0.4).abs() < 1e-12);
        play.follow(-0.006);
        play.follow(-2.0);
        assert!((play.reverse() - 1.0).abs() < 1e-12);
        play.follow(0.0025);
        assert!((play.reverse() - 0.75).abs() < 1e-12);
    }
}
