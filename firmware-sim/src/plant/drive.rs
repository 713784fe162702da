//! One axis' position loop, its friction and its lost motion.

/// Parameters of an axis' servo and mechanics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveSettings {
    /// Position gain Kv, 1/s.
    pub position_gain_per_s: f64,
    /// Share of the command's velocity fed forward, 0 to 1.
    pub feed_forward: f64,
    /// Bandwidth of the velocity loop, 1/s.
    pub velocity_gain_per_s: f64,
    /// Integral action of the velocity loop, 1/s.
    pub integral_per_s: f64,
    /// Coulomb friction over mass, mm/s² (deg/s²).
    pub friction_per_s2: f64,
    /// Way over which friction builds up after a reversal, mm (deg).
    pub presliding: f64,
    /// Viscous friction over mass, 1/s.
    pub damping_per_s: f64,
}

impl DriveSettings {
    /// A retrofitted machine with a decent servo; `place` detunes the axes slightly against each other.
    pub fn typical(place: usize) -> DriveSettings {
        let detune = [1.0, 0.96, 1.03, 1.0, 0.98, 1.0][place.min(5)];
        DriveSettings {
            position_gain_per_s: 90.0 * detune,
            feed_forward: 0.97,
            velocity_gain_per_s: 600.0,
            integral_per_s: 150.0,
            friction_per_s2: 60.0 * detune,
            presliding: 0.004,
            damping_per_s: 2.0,
        }
    }
}

/// An axis in motion.
///
/// Position loop with velocity feed-forward, PI velocity loop, friction as a Dahl bristle (builds up over the
/// presliding way, so that it does not jump at a reversal), semi-implicit Euler at the servo period.
#[derive(Clone, Debug)]
pub struct Drive {
    settings: DriveSettings,
    period: f64,
    position: f64,
    velocity: f64,
    integral: f64,
    bristle: f64,
    last_command: Option<f64>,
}

impl Drive {
    /// An axis at rest that takes its first command as its position.
    pub fn new(settings: DriveSettings, period_s: f64) -> Drive {
        Drive {
            settings,
            period: period_s,
            position: 0.0,
            velocity: 0.0,
            integral: 0.0,
            bristle: 0.0,
            last_command: None,
        }
    }

    /// One servo period: follows `command` by what the encoder reads; returns the new position, mm (deg).
    pub fn cycle(&mut self, command: f64, measured: f64) -> f64 {
        let s = &self.settings;
        let Some(last) = self.last_command.replace(command) else {
            self.position = command;
            return self.position;
        };
        let t = self.period;
        let wanted = s.position_gain_per_s * (command - measured) + s.feed_forward * (command - last) / t;
        let error = wanted - self.velocity;
        self.integral += s.integral_per_s * error * t;
        // Dahl: z' = v (1 − z sgn v) / presliding, friction = z × Coulomb.
        let slide = self.velocity * t / s.presliding;
        self.bristle = (self.bristle + slide * (1.0 - self.bristle * slide.signum())).clamp(-1.0, 1.0);
        let resistance = s.friction_per_s2 * self.bristle + s.damping_per_s * self.velocity;
        self.velocity += t * (s.velocity_gain_per_s * (error + self.integral) - resistance);
        self.position += t * self.velocity;
        self.position
    }

    /// Where the axis stands as a perfect encoder would read it.
    pub fn position(&self) -> f64 {
        self.position
    }
}

/// Lost motion: what lies behind the encoder follows only once the play is used up.
///
/// In positive travel the axis is where the encoder says, in negative travel it stays behind by the width: actual −
/// indicated = + backlash.
#[derive(Clone, Copy, Debug)]
pub struct Play {
    width: f64,
    used: f64,
    last: Option<f64>,
}

impl Play {
    /// A play of some width, mm (deg); the axis is taken to have come in positive direction.
    pub fn new(width: f64) -> Play {
        Play { width, used: 0.0, last: None }
    }

    /// Follows the indicated position; returns how far the reversal has gone: 0 in positive travel, 1 in negative.
    pub fn cycle(&mut self, indicated: f64) -> f64 {
        let moved = indicated - self.last.replace(indicated).unwrap_or(indicated);
        if self.width <= 0.0 {
            if moved != 0.0 {
                self.used = if moved < 0.0 { 1.0 } else { 0.0 };
            }
            return self.used;
        }
        self.used = (self.used - moved).clamp(0.0, self.width);
        self.used / self.width
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    const T: f64 = 1e-4;

    #[test]
    fn lag_at_constant_speed_is_what_gain_and_feed_forward_leave() {
        let settings = DriveSettings { friction_per_s2: 0.0, damping_per_s: 0.0, ..DriveSettings::typical(0) };
        let mut drive = Drive::new(settings, T);
        let mut command = 0.0;
        let mut position = drive.cycle(0.0, 0.0);
        for _ in 0..20_000 {
            command += 25.0 * T;
            position = drive.cycle(command, position);
        }
        // The reading that the loop closes over is one period old.
        let lag = (1.0 - settings.feed_forward) * 25.0 / settings.position_gain_per_s - 25.0 * T;
        assert!((command - position - lag).abs() < 1e-9, "{} against {lag}", command - position);
    }

    #[test]
    fn reversal_of_friction_makes_a_glitch_of_a_few_micrometres() {
        let mut drive = Drive::new(DriveSettings::typical(0), T);
        let ideal = DriveSettings { friction_per_s2: 0.0, ..DriveSettings::typical(0) };
        let mut free = Drive::new(ideal, T);
        let (mut a, mut b) = (0.0, 0.0);
        let mut worst = 0.0_f64;
        for n in 0..200_000 {
            let command = 40.0 * (f64::from(n) * T * 25.0 / 40.0).sin();
            a = drive.cycle(command, a);
            b = free.cycle(command, b);
            if n > 40_000 {
                worst = worst.max((a - b).abs());
            }
        }
        assert!((0.3e-3..4e-3).contains(&worst), "{worst} mm");
    }

    #[test]
    fn in_negative_travel_the_axis_stays_behind() {
        let mut play = Play::new(0.004);
        assert_eq!(play.cycle(10.0), 0.0);
        assert_eq!(play.cycle(11.0), 0.0);
        assert!((play.cycle(10.998) - 0.5).abs() < 1e-9);
        assert_eq!(play.cycle(10.0), 1.0);
        assert!((play.cycle(10.001) - 0.75).abs() < 1e-9);
        assert_eq!(play.cycle(10.1), 0.0);
    }
}
