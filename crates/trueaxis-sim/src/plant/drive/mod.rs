//! One axis' servo drive: position loop, velocity loop, and one moving mass with friction or motor and load.

#[cfg(test)]
mod frequency_response;
mod friction;
mod settings;
#[cfg(test)]
mod tests;
mod two_masses;
mod variant;

use super::delay::Delay;
use friction::Friction;
use std::f64::consts::TAU;
use two_masses::{Step, TwoMasses};

pub use settings::{Disagreement, DriveSettings, ScaleAt};
pub use variant::Variant;

/// Longest time step of the mechanics; a longer servo period is divided into several.
const MAX_STEP_S: f64 = 1e-4;
/// Steps of two masses in a period of their resonance: a contact of the play gains less energy from the step in which it
/// begins, (2π/100)²/2, than the least damping takes.
const STEPS_PER_RESONANCE: f64 = 100.0;
/// Steps of two masses in the time constant of the motor's velocity loop.
const STEPS_PER_VELOCITY_LOOP: f64 = 10.0;

/// The masses that the drive moves.
#[derive(Clone, Copy, Debug)]
enum Mechanics {
    /// One mass: position and velocity.
    Rigid { position: f64, velocity: f64 },
    /// Motor and load, and their solution over the standard step.
    TwoMasses(TwoMasses, Step),
}

/// State of one drive and its axis; the lost motion lies behind the encoder, on whichever side that is.
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
    mechanics: Mechanics,
    acceleration: f64,
    integral: f64,
    friction: Friction,
    /// Force on the load, per moved mass.
    side_load: f64,
}

impl Drive {
    /// A drive at rest at 0.
    pub fn new(settings: DriveSettings, period_s: f64) -> Drive {
        let steps = (period_s / longest_step(&settings) - 1e-9).ceil().max(1.0);
        let step_s = period_s / steps;
        let mut drive = Drive {
            settings,
            period_s,
            steps: steps as u32,
            step_s,
            current_share: current_share(step_s, &settings),
            delay: Delay::new(0.0, settings.dead_time_s / period_s),
            entered: 0.0,
            command: 0.0,
            mechanics: Mechanics::Rigid { position: 0.0, velocity: 0.0 },
            acceleration: 0.0,
            integral: 0.0,
            friction: Friction::default(),
            side_load: 0.0,
        };
        drive.rest_at(0.0);
        drive
    }

    /// Sets the axis at rest at `position` (mm, deg), last moved in positive direction.
    pub fn rest_at(&mut self, position: f64) {
        self.delay = Delay::new(position, self.settings.dead_time_s / self.period_s);
        (self.entered, self.command) = (position, position);
        (self.acceleration, self.integral, self.friction) = (0.0, 0.0, Friction::default());
        self.mechanics = if self.settings.resonance_hz > 0.0 {
            Mechanics::TwoMasses(TwoMasses::at(position), Step::new(self.step_s, &self.settings))
        } else {
            Mechanics::Rigid { position, velocity: 0.0 }
        };
    }

    /// Pushes the load in positive direction from now on, mm/s² (deg/s²): a force per moved mass, such as a cutting force.
    pub fn push(&mut self, side_load: f64) {
        self.side_load = side_load;
    }

    /// Position on the encoder's side, mm (deg).
    pub fn position(&self) -> f64 {
        match self.settings.scale_at {
            ScaleAt::Motor => self.motor_position(),
            ScaleAt::Load => self.load_position(),
        }
    }

    /// Position of the load, mm (deg).
    pub fn load_position(&self) -> f64 {
        match &self.mechanics {
            Mechanics::Rigid { position, .. } => *position,
            Mechanics::TwoMasses(masses, _) => masses.load(&self.settings),
        }
    }

    /// Velocity of the motor, mm/s (deg/s).
    pub fn velocity(&self) -> f64 {
        match &self.mechanics {
            Mechanics::Rigid { velocity, .. } => *velocity,
            Mechanics::TwoMasses(masses, _) => masses.motor_velocity(&self.settings),
        }
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
    /// The position loop receives its commands after the dead time. The velocity loop is closed on the motor.
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
            let holding = self.settings.position_gain_per_s * (command - self.position());
            self.advance(holding, step, current_share(step, &self.settings));
            overdue -= self.step_s;
        }
    }

    /// One step of velocity loop, current loop and mechanics (one mass: semi-implicit Euler).
    fn advance(&mut self, reference: f64, dt: f64, current_share: f64) {
        self.accelerate(reference - self.velocity(), dt, current_share);
        let s = &self.settings;
        let force = match s.torque_ripple_mm_per_s2 {
            0.0 => self.acceleration,
            _ => self.acceleration + ripple(self.motor_position(), s),
        };
        match &mut self.mechanics {
            Mechanics::Rigid { position, velocity } => {
                let drag = self.friction.drag(*velocity, dt, s) - self.side_load;
                *velocity += (force - drag) * dt;
                *position += *velocity * dt;
            }
            Mechanics::TwoMasses(masses, step) => {
                let drag = self.friction.drag(masses.load_velocity(s), dt, s) - self.side_load;
                let other = (dt != step.dt()).then(|| Step::new(dt, s));
                masses.advance(force, drag, other.as_ref().unwrap_or(step), s);
            }
        }
    }

    /// The motor's acceleration after a step of velocity loop and current loop.
    fn accelerate(&mut self, error: f64, dt: f64, current_share: f64) {
        let s = &self.settings;
        let integral = self.integral + error * dt / s.reset_time_s;
        let wanted = s.velocity_gain_per_s * (error + integral);
        let given = wanted.max(-s.force_limit_mm_per_s2).min(s.force_limit_mm_per_s2);
        if given == wanted {
            self.integral = integral;
        }
        self.acceleration += current_share * (given - self.acceleration);
    }

    fn motor_position(&self) -> f64 {
        match &self.mechanics {
            Mechanics::Rigid { position, .. } => *position,
            Mechanics::TwoMasses(masses, _) => masses.motor(&self.settings),
        }
    }
}

/// Longest step of the mechanics, s.
fn longest_step(s: &DriveSettings) -> f64 {
    if s.resonance_hz == 0.0 {
        return MAX_STEP_S;
    }
    let motor_loop_s = (1.0 - s.load_share) / s.velocity_gain_per_s;
    let resonance_s = 1.0 / (STEPS_PER_RESONANCE * s.resonance_hz);
    MAX_STEP_S.min(resonance_s).min(motor_loop_s / STEPS_PER_VELOCITY_LOOP)
}

/// The motor's ripple at its `position`, mm/s²: A sin(2π x/period).
fn ripple(position: f64, s: &DriveSettings) -> f64 {
    s.torque_ripple_mm_per_s2 * libm::sin(TAU * (position / s.ripple_period_mm).fract())
}

/// Share of a change of force that the current loop has completed after `dt`.
fn current_share(dt: f64, settings: &DriveSettings) -> f64 {
    1.0 - libm::exp(-dt / settings.current_loop_s)
}
