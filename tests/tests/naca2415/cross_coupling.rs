//! Variable-gain cross-coupling, the published reference: Koren and Lo, CIRP Annals 40/1 (1991) 371.
//!
//! ```text
//! ε = C_y E_y − C_x E_x        E = command − tip
//! C_x = sin θ − E_x/(2 ρ)      C_y = cos θ + E_y/(2 ρ)      circular; tangential: without ρ
//! u = K_p ε + K_i ∫ε dt        to Y by C_y, to X by −C_x
//! ```
//!
//! Written independently of the plugin that it is compared with.

use super::course::Control;
use trueaxis_tests::course::Course;

/// Approximation of the path for the contour error estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Estimate {
    /// The tangent at the command.
    Tangent,
    /// The circle of curvature at the command.
    Circle,
}

/// Cross-coupling controller on top of the drives, at the same place as the plugin.
pub(crate) struct CrossCoupling {
    pub(crate) estimate: Estimate,
    pub(crate) proportional: f64,
    pub(crate) integral_per_s: f64,
    sum: f64,
}

impl CrossCoupling {
    pub(crate) fn new(estimate: Estimate, proportional: f64, integral_per_s: f64) -> CrossCoupling {
        CrossCoupling { estimate, proportional, integral_per_s, sum: 0.0 }
    }
}

impl Control for CrossCoupling {
    fn drive(&mut self, course: &Course, cycle: usize, tip: [f64; 2]) -> [f64; 2] {
        // The reading is from the end of the previous cycle, and so is the corresponding command.
        let before = &course.commands[cycle.saturating_sub(1)];
        let curve = &course.program.moves[before.setpoint.move_index].curve;
        let at = curve.derivatives(before.setpoint.u);
        let speed = at.first[0].hypot(at.first[1]);
        let [cos, sin] = [at.first[0] / speed, at.first[1] / speed];
        let bend = match self.estimate {
            Estimate::Tangent => 0.0,
            Estimate::Circle => (at.first[0] * at.second[1] - at.first[1] * at.second[0]) / speed.powi(3),
        };
        let error = [before.at[0] - tip[0], before.at[1] - tip[1]];
        let [cx, cy] = [sin - 0.5 * bend * error[0], cos + 0.5 * bend * error[1]];
        let contour = cy * error[1] - cx * error[0];
        self.sum += contour * course.period_s;
        let u = self.proportional * contour + self.integral_per_s * self.sum;
        let [x, y, _] = course.commands[cycle].at;
        [x - cx * u, y + cy * u]
    }
}
