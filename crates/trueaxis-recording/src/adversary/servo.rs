//! Dynamic correction in recorded and adversarial cycles: configuration, switches, learned correction.

use super::AXES;
use trueaxis::machine::{
    CrosstalkSettings, DriveFigures, DynamicSettings, FeedbackSettings, FrictionSettings, MachineSettings,
};
use trueaxis::{Axis, Dynamics, Input, Position};

/// Parts of the dynamic correction that a machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServoParts {
    /// Friction at reversals, on every axis.
    Friction,
    /// Friction and contour feedback.
    Feedback,
    /// Everything: also lag, acceleration, lost motion taken up, cross-talk by a constant and by a table.
    All,
}

impl ServoParts {
    /// Configures the parts identically on every axis: drives, as good as rigid, and friction of a small
    /// mill.
    pub fn configure(self, machine: &mut MachineSettings) {
        let all = self == ServoParts::All;
        for axis in &mut machine.axes {
            axis.servo.drive = Some(DriveFigures {
                velocity_feed_forward: 0.93,
                lowest_resonance_hz: 5000.0,
                ..DriveFigures::with_defaults(110.0, 800.0, 0.006)
            });
            axis.servo.friction = Some(FrictionSettings {
                stribeck_share: 0.3,
                viscous: 0.0043,
                ..FrictionSettings::with_defaults(0.5, 0.006)
            });
            let dynamic = DynamicSettings::with_defaults(axis.axis);
            axis.servo.dynamic = Some(DynamicSettings { lag: all, acceleration: all, take_up: all, ..dynamic });
        }
        machine.contour.feedback = (self != ServoParts::Friction).then(FeedbackSettings::default);
        machine.crosstalk.clear();
        if all {
            let entry = |tip, from, over, points: &[[f64; 2]]| CrosstalkSettings {
                tip,
                from,
                over,
                points: points.iter().copied().collect(),
            };
            // Six entries fit.
            let _ = machine.crosstalk.push(entry(Axis::X, Axis::Y, Axis::Y, &[[0.0, 1.2e-6]]));
            let _ = machine.crosstalk.push(entry(Axis::Y, Axis::X, Axis::Z, &[[-300.0, 1e-6], [0.0, 1.5e-6]]));
        }
    }
}

/// Number of cycles between two settings of the switches.
const SWITCHED: u32 = 60;

/// Switches parts off and on in cycle `number`, and adds up to 1 µm of learned correction.
pub fn vary<P: Position>(input: &mut Input<P, AXES>, number: u32) {
    let stretch = number / SWITCHED;
    let off = if stretch % 3 == 2 { stretch.wrapping_mul(37) } else { 0 };
    input.dynamics = Dynamics::ALL.without(Dynamics((off & 127) as u8));
    let learned = f64::from(number % 200) - 100.0;
    input.learned = [1e-5, -5e-6, 2e-6].map(|share| P::of(share * learned));
}
