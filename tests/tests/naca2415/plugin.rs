//! The step with its dynamic correction, on a machine without geometric errors.

use super::course::Control;
use super::plant::{Cascade, PUBLISHED};
use trueaxis::contour::{Flags, Method};
use trueaxis::learned::Learned;
use trueaxis::machine::{
    AxisServo, DriveFigures, DynamicSettings, FeedbackSettings, FrictionSettings, Limits, MachineSettings,
};
use trueaxis::{Config, HostServo, Row, State};
use trueaxis_metrology::learning::MeasuredError;
use trueaxis_testing::machine::Machine;
use trueaxis_tests::course::Course;

/// Gains of the contour feedback: proportional, integral per second.
pub(crate) type Gains = [f64; 2];

/// Factors by which the configured figures are off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Off {
    /// Factor of the gains of both loops.
    pub(crate) gains: f64,
    /// Factor of the reset time.
    pub(crate) reset: f64,
    /// Factor of the friction.
    pub(crate) friction: f64,
}

impl Off {
    /// The true figures.
    pub(crate) const BY_NOTHING: Off = Off { gains: 1.0, reset: 1.0, friction: 1.0 };
    /// The simulator's default errors.
    pub(crate) const AS_USUAL: Off = Off { gains: 1.05, reset: 1.0, friction: 0.9 };
}

/// A machine whose X and Y are configured with the figures of the published axes, `off` by factors; the plugin never sees the
/// plant.
///
/// The published axes have no Coulomb friction, but much viscous friction.
pub(crate) fn machine(gains: Option<Gains>, feed_forward: Option<Off>) -> MachineSettings {
    let off = feed_forward.unwrap_or(Off::BY_NOTHING);
    let mut at = 0;
    let configured = Machine::three_axis().each(|axis| {
        // Z is stationary, but feedback needs its drive nevertheless.
        let cascade = Cascade::of(&PUBLISHED[at % 2]);
        at += 1;
        // The published motion is fast: lag and force need corrections that exceed a machine tool's default limits.
        let on = feed_forward.is_some();
        let limits = Limits { magnitude: 0.5, slope_per_s: 50.0, acceleration_per_s2: 50_000.0 };
        axis.joint = axis.travel.map(|end| end + limits.magnitude.copysign(end));
        axis.limits = limits;
        axis.servo = AxisServo {
            drive: Some(DriveFigures {
                position_gain_per_s: cascade.position_gain * off.gains,
                velocity_gain_per_s: cascade.velocity_gain * off.gains,
                reset_time_s: cascade.reset_time * off.reset,
                velocity_feed_forward: cascade.feed_forward,
                current_loop_s: cascade.current_loop,
                dead_time_s: 1e-3,
                resonance_hz: 0.0,
                resonance_damping: 0.0,
                lowest_resonance_hz: 5000.0,
                gain_without_notch: 0.0,
            }),
            friction: feed_forward.map(|off| FrictionSettings {
                coulomb_per_s: 0.0,
                stribeck_share: 0.0,
                stribeck_velocity_per_s: 2.0,
                presliding: 1e-3,
                viscous: cascade.viscous / cascade.velocity_gain * off.friction,
                lead_s: 0.0,
                adapt: 0.0,
            }),
            dynamic: Some(DynamicSettings { limits, lag: on, acceleration: on, take_up: false, lag_s: 0.0 }),
        };
    });
    configured
        .with(|machine| {
            machine.contour.feedback = gains.map(|[proportional, integral_per_s]| FeedbackSettings {
                proportional,
                integral_per_s,
                max_feed_per_s: 500.0,
                watch_mm: 0.02,
            });
        })
        .settings()
}

/// A servo loop and its state.
pub(crate) struct Plugin<'s> {
    servo: &'s HostServo<'s, 3>,
    state: State<f64, f64, 3>,
    /// Correction learned from earlier parts.
    pub(crate) learned: Option<Learned<'s, f64>>,
    /// Record of this part, for the next one.
    pub(crate) record: Vec<MeasuredError>,
}

impl<'s> Plugin<'s> {
    pub(crate) fn new(servo: &'s HostServo<'s, 3>) -> Plugin<'s> {
        Plugin { servo, state: servo.start(), learned: None, record: Vec::new() }
    }
}

/// Builds the servo loop of a machine for a course.
pub(crate) fn with_servo<T>(
    machine: &MachineSettings,
    course: &Course,
    user: impl FnOnce(&HostServo<'_, 3>) -> T,
) -> T {
    let period_ns = (course.period_s * 1e9).round() as u32;
    let config = Config {
        machine,
        grids: &[],
        machine_id: 0,
        tables_crc: 0,
        period_ns,
        inverse_passes: 1,
        method: Method::Guarded,
    };
    let rows = |_| None::<&[Row]>;
    let mut memory = vec![0.0; config.requirement(rows)];
    user(&config.build(rows, &mut memory).unwrap())
}

impl Control for Plugin<'_> {
    fn drive(&mut self, course: &Course, cycle: usize, tip: [f64; 2]) -> [f64; 2] {
        let command = &course.commands[cycle];
        let mut input = self.servo.input(command.at, [tip[0], tip[1], command.at[2]]);
        if let Some(learned) = &self.learned {
            input.learned = learned.at(command.setpoint.length);
        }
        let output = self.servo.step(&mut self.state, &input, course.path().on(command.reference), ());
        let tip = &output.record.tip;
        let error_mm = (command.cutting && tip.flags == Flags::BRACKETED).then(|| tip.vector.into());
        self.record.push(MeasuredError { length_mm: command.setpoint.length, error_mm });
        [output.drive[0], output.drive[1]]
    }
}
