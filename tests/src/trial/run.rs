//! One plant on its track, with and without the parts.

use super::{Case, PARTS, Plant};
use crate::course::Course;
use serde::Serialize;
use trueaxis::contour::Method;
use trueaxis::machine::{DynamicSettings, FeedbackSettings, MachineSettings};
use trueaxis::telemetry::Status;
use trueaxis::{Config, Dynamics, HostServo, Row};
use trueaxis_sim::Settings;
use trueaxis_sim::plant::drive::Drive;
use trueaxis_testing::machine::Machine;

/// Start of every run that does not count, s.
const SETTLING_S: f64 = 0.1;
/// Gains of the feedback, as in the sample machines.
const GAINS: [f64; 2] = [0.3, 10.0];

/// Shape of the track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Shape {
    /// A full circle.
    Circle,
    /// A line across both axes, there and back.
    Line,
}

/// Contour error of the load, µm.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Size {
    /// Exceeded in one cycle of a thousand.
    pub p999: f64,
    /// Root of the mean square.
    pub rms: f64,
}

/// Result of a run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Outcome {
    /// Contour error after the first 100 ms.
    pub error_um: Size,
    /// Whether the watch led the feedback out.
    pub led_out: bool,
}

impl Outcome {
    /// Error over that of another run, the larger of p99.9 and RMS.
    pub fn against(&self, other: &Outcome) -> f64 {
        let (own, other) = (self.error_um, other.error_um);
        (own.p999 / other.p999).max(own.rms / other.rms)
    }
}

/// Runs a plant on a track without and with every combination of parts.
pub(super) fn run(number: usize, plant: Plant, shape: Shape, feed_mm_per_s: f64, rule: Dynamics) -> Case {
    let (machine, gains) = accepted(&plant);
    let track = Track::new(shape, feed_mm_per_s, plant.period_s, &machine);
    let servo = servo(&machine, plant.period_s).expect("an accepted machine");
    let with = PARTS.map(|(_, parts)| follow(&plant, &track, &servo, Dynamics(parts.0 | rule.0)));
    let off = follow(&plant, &track, &servo, Dynamics::NONE);
    Case { number, plant, shape, feed_mm_per_s, gains, off, with }
}

/// The machine as configured, with the largest gains up to [`GAINS`] that are accepted.
fn accepted(plant: &Plant) -> (MachineSettings, Option<[f64; 2]>) {
    let mut gains = GAINS;
    for _ in 0..5 {
        let machine = machine(plant, Some(gains));
        match servo(&machine, plant.period_s) {
            Ok(_) => return (machine, Some(gains)),
            Err(refused) => {
                let Some(bound) = refused.bound else { break };
                gains = gains.map(|gain| 0.999 * bound / gains[0] * gain);
            }
        }
    }
    (machine(plant, None), None)
}

fn machine(plant: &Plant, gains: Option<[f64; 2]>) -> MachineSettings {
    let feedback = gains.map(|[proportional, integral_per_s]| FeedbackSettings {
        proportional,
        integral_per_s,
        watch_mm: 0.01,
        max_feed_per_s: 500.0,
    });
    Machine::three_axis()
        .each(|axis| {
            axis.servo.drive = Some(plant.figures());
            axis.servo.friction = Some(plant.friction());
            axis.servo.dynamic =
                Some(DynamicSettings { lag: true, acceleration: true, ..DynamicSettings::with_defaults(axis.axis) });
        })
        .with(|machine| machine.contour.feedback = feedback)
        .settings()
}

fn servo(machine: &MachineSettings, period_s: f64) -> Result<HostServo<'static, 3>, trueaxis::ConfigError> {
    let period_ns = (period_s * 1e9).round() as u32;
    let (machine_id, tables_crc, inverse_passes) = (0, 0, 1);
    let config =
        Config { machine, grids: &[], machine_id, tables_crc, period_ns, inverse_passes, method: Method::Guarded };
    config.build(|_| None::<&[Row]>, Default::default())
}

/// A shape with its commands.
struct Track {
    shape: Shape,
    radius_mm: f64,
    course: Course,
}

/// Slope of the line.
const LINE: [f64; 2] = [0.78, 0.625_780_5];

impl Track {
    fn new(shape: Shape, feed_mm_per_s: f64, period_s: f64, machine: &MachineSettings) -> Track {
        // A turn in some 1.6 s, slower where the acceleration limits it.
        let radius_mm = (0.25 * feed_mm_per_s).max(feed_mm_per_s * feed_mm_per_s / 500.0);
        let length = 0.6 * feed_mm_per_s + feed_mm_per_s * feed_mm_per_s / 1000.0;
        let [x, y] = LINE.map(|part| part * length);
        let feed = 60.0 * feed_mm_per_s;
        let program = match shape {
            Shape::Circle => {
                format!("G21 G90 F{feed:.3}\nG0 X{radius_mm:.4}\nG3 X{radius_mm:.4} I-{radius_mm:.4}\nM2\n")
            }
            Shape::Line => format!("G21 G90 F{feed:.3}\nG1 X{x:.4} Y{y:.4}\nG1 X0 Y0\nM2\n"),
        };
        let settings = Settings { rate_hz: 1.0 / period_s, ..Settings::default() };
        Track { shape, radius_mm, course: Course::new(&program, settings, machine) }
    }

    /// Distance of a point from the shape, mm.
    fn error(&self, [x, y]: [f64; 2]) -> f64 {
        match self.shape {
            Shape::Circle => (x.hypot(y) - self.radius_mm).abs(),
            Shape::Line => (LINE[0] * y - LINE[1] * x).abs() / LINE[0].hypot(LINE[1]),
        }
    }
}

/// Follows the track with some parts of the correction.
fn follow(plant: &Plant, track: &Track, servo: &HostServo<'static, 3>, parts: Dynamics) -> Outcome {
    let commands = &track.course.commands;
    let first = commands.iter().position(|command| command.cutting).unwrap_or(0);
    let settling = (SETTLING_S / plant.period_s) as usize;
    let mut drives = plant.drives.map(|drive| Drive::new(drive, plant.period_s));
    for (drive, at) in drives.iter_mut().zip(commands[first].at) {
        drive.rest_at(at);
    }
    let mut state = servo.start();
    let path = track.course.path();
    let (mut errors, mut led_out) = (Vec::new(), false);
    for (cycle, command) in commands[first..].iter().enumerate() {
        let readings = [drives[0].position(), drives[1].position()];
        let mut input = servo.input(command.at, [readings[0], readings[1], command.at[2]]);
        input.dynamics = parts;
        let output = servo.step(&mut state, &input, path.on(command.reference), ());
        led_out |= output.record.status.has(Status::FEEDBACK_OUT);
        for (i, drive) in drives.iter_mut().enumerate() {
            drive.cycle(output.drive[i], readings[i], 1.0);
        }
        if cycle >= settling {
            errors.push(1e3 * track.error([drives[0].load_position(), drives[1].load_position()]));
        }
    }
    Outcome { error_um: size(errors), led_out }
}

fn size(mut errors: Vec<f64>) -> Size {
    let rms = (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
    let at = errors.len() - 1 - errors.len() / 1000;
    let p999 = *errors.select_nth_unstable_by(at, f64::total_cmp).1;
    Size { p999, rms }
}
