//! Dynamic correction of a machine: drives, friction, feedback, cross-talk, drawn at random.

use super::dice::Dice;
use trueaxis::Axis;
use trueaxis::machine::{
    CrosstalkSettings, DriveFigures, DynamicSettings, FeedbackSettings, FrictionSettings, Limits, MachineSettings,
};

/// Configures some or all parts of it.
pub(super) fn configure(dice: &mut Dice, machine: &mut MachineSettings) {
    let feedback = dice.one_in(2);
    for axis in &mut machine.axes {
        let servo = &mut axis.servo;
        if feedback || !dice.one_in(4) {
            let drive = DriveFigures::with_defaults(dice.range(60.0, 160.0), dice.range(500.0, 1200.0), 0.006);
            let velocity_feed_forward = dice.one_of(&[0.0, 0.5, 0.93, 1.0]);
            servo.drive = Some(DriveFigures { velocity_feed_forward, lowest_resonance_hz: 5000.0, ..drive });
        }
        if servo.drive.is_some() && !dice.one_in(4) {
            servo.friction = Some(FrictionSettings {
                stribeck_share: dice.range(0.0, 0.5),
                viscous: dice.range(0.0, 0.01),
                lead_s: dice.one_of(&[0.0, 0.001]),
                ..FrictionSettings::with_defaults(dice.range(0.1, 1.0), dice.factor(1e-3, 2e-2))
            });
        }
        if servo.drive.is_some() && !dice.one_in(4) {
            let default = DynamicSettings::with_defaults(axis.axis);
            let limits = Limits {
                magnitude: dice.factor(0.002, 0.1),
                slope_per_s: dice.factor(0.5, 20.0),
                acceleration_per_s2: dice.factor(200.0, 20_000.0),
            };
            let [lag, acceleration, take_up] = [(); 3].map(|()| dice.one_in(2));
            let limits = if dice.one_in(3) { default.limits } else { limits };
            servo.dynamic = Some(DynamicSettings { limits, lag, acceleration, take_up, lag_s: 0.0 });
        }
    }
    if feedback {
        let default = FeedbackSettings::default();
        let share = dice.range(0.2, 1.0);
        machine.contour.feedback = Some(FeedbackSettings {
            proportional: share * default.proportional,
            integral_per_s: share * default.integral_per_s,
            max_feed_per_s: dice.factor(20.0, 400.0),
            watch_mm: dice.factor(1e-4, 0.02),
        });
    }
    if dice.one_in(2) {
        let mut entry = |tip, from, over, points: &[[f64; 2]]| {
            let points = points.iter().copied().collect();
            // The list has room for six.
            let _ = machine.crosstalk.push(CrosstalkSettings { tip, from, over, points });
        };
        entry(Axis::X, Axis::Y, Axis::Y, &[[0.0, 1.2e-6]]);
        entry(Axis::Y, Axis::X, Axis::Z, &[[-30.0, 1e-6], [0.0, 1.5e-6]]);
    }
}
