//! A drive as described in the methods, written independently of the plugin and the simulator.

use trueaxis::machine::DriveFigures;

/// Longest integration step of the mechanics, s.
const STEP_S: f64 = 1e-4;

/// Position loop K_v with velocity feed-forward, velocity loop K_vp (1 + 1/(τ s)), current loop, mass; commands are delayed by
/// the dead time.
#[derive(Clone, Debug)]
pub(crate) struct Drive {
    figures: DriveFigures,
    period_s: f64,
    /// Latest commands, newest first.
    commands: Vec<f64>,
    command: f64,
    pub(crate) position: f64,
    velocity: f64,
    acceleration: f64,
    integral: f64,
}

impl Drive {
    pub(crate) fn at(position: f64, figures: DriveFigures, period_s: f64) -> Drive {
        let late = (figures.dead_time_s / period_s).ceil() as usize + 2;
        let commands = vec![position; late];
        Drive {
            figures,
            period_s,
            commands,
            command: position,
            position,
            velocity: 0.0,
            acceleration: 0.0,
            integral: 0.0,
        }
    }

    /// Advances one period, at whose end the axis should be at `command`; `force` acts on the axis, mm/s².
    pub(crate) fn advance(&mut self, command: f64, force: f64) {
        let f = &self.figures;
        self.commands.rotate_right(1);
        self.commands[0] = command;
        let late = f.dead_time_s / self.period_s;
        let (whole, part) = (late as usize, late.fract());
        let arrived = (1.0 - part) * self.commands[whole] + part * self.commands[whole + 1];
        let wanted = f.position_gain_per_s * (self.command - self.position)
            + f.velocity_feed_forward * (arrived - self.command) / self.period_s;
        self.command = arrived;
        let steps = (self.period_s / STEP_S).ceil();
        let h = self.period_s / steps;
        let share = 1.0 - (-h / f.current_loop_s).exp();
        for _ in 0..steps as u32 {
            let error = wanted - self.velocity;
            self.integral += error * h / f.reset_time_s;
            self.acceleration += share * (f.velocity_gain_per_s * (error + self.integral) - self.acceleration);
            self.velocity += (self.acceleration + force) * h;
            self.position += self.velocity * h;
        }
    }
}
