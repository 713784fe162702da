//! One plant on its track, with and without the parts.

use super::error::{Size, amplitude, late_vibration};
use super::{ADAPTING, Case, Conditions, Cut, PARTS, Plant, Resonance};
use crate::course::Course;
use serde::Serialize;
use trueaxis::contour::Method;
use trueaxis::machine::{DynamicSettings, FeedbackSettings, MachineSettings};
use trueaxis::telemetry::Status;
use trueaxis::{Config, Dynamics, HostServo, Row};
use trueaxis_sim::Settings;
use trueaxis_sim::plant::drive::{Drive, ScaleAt};
use trueaxis_testing::machine::Machine;

/// Start of every run that does not count, s.
const SETTLING_S: f64 = 0.1;
/// K_p of the feedback that is tried, from that of the sample machines down.
const PROPORTIONAL: [f64; 11] = [0.3, 0.21, 0.15, 0.1, 0.07, 0.05, 0.035, 0.025, 0.015, 0.01, 0.0];
/// K_i, as in the sample machines, 1/s.
const INTEGRAL_PER_S: f64 = 10.0;
/// Share by which friction adapts, and how often the track is followed before it counts.
const ADAPT: f64 = 0.6;
pub(super) const BEFORE: usize = 10;

/// Shape of the track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Shape {
    /// A full circle.
    Circle,
    /// A line across both axes, there and back.
    Line,
}

/// Result of a run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Outcome {
    /// Contour error after the first 100 ms.
    pub error_um: Size,
    /// Vibration of the contour error at the end of the run, RMS, µm.
    pub vibration_um: f64,
    /// Amplitude of the loads' motion at the frequency of the chatter, µm; 0 without chatter.
    pub chatter_um: f64,
    /// Whether the watch led the feedback out.
    pub led_out: bool,
}

impl Outcome {
    /// Error over that of another run, the larger of p99.9 and RMS.
    pub fn against(&self, other: &Outcome) -> f64 {
        let (own, other) = (self.error_um, other.error_um);
        (own.p999 / other.p999).max(own.rms / other.rms)
    }

    /// Whether the run vibrates at its end by more than three times what another does, and by a micrometre more.
    pub fn is_unstable(&self, other: &Outcome) -> bool {
        self.vibration_um > 3.0 * other.vibration_um && self.vibration_um > other.vibration_um + 1.0
    }

    /// Whether the loads move more at the frequency of the chatter than in another run: by 5 % and 0.1 µm.
    pub fn chatters_above(&self, other: &Outcome) -> bool {
        self.chatter_um > 1.05 * other.chatter_um && self.chatter_um > other.chatter_um + 0.1
    }
}

/// Runs a plant on a track without and with every combination of parts.
pub(super) fn run(
    number: usize,
    plant: Plant,
    shape: Shape,
    feed_mm_per_s: f64,
    cut: Cut,
    conditions: Conditions,
) -> Case {
    let (machine, gains) = accepted(&plant, conditions.resonance);
    let track = Track::new(shape, feed_mm_per_s, plant.period_s, &machine);
    let servo = servo(&machine, plant.period_s).expect("an accepted machine");
    let mut adapts = machine.clone();
    adapts.axes.iter_mut().filter_map(|axis| axis.servo.friction.as_mut()).for_each(|friction| friction.adapt = ADAPT);
    let adapting = self::servo(&adapts, plant.period_s).expect("an accepted machine");
    let with = PARTS.map(|(name, parts)| {
        let parts = Dynamics(parts.0 | conditions.rule.0);
        match name {
            ADAPTING => follow(&plant, &track, &cut, &adapting, parts, BEFORE),
            _ => follow(&plant, &track, &cut, &servo, parts, 0),
        }
    });
    let off = follow(&plant, &track, &cut, &servo, Dynamics::NONE, 0);
    let off_again = follow(&plant, &track, &cut, &servo, Dynamics::NONE, BEFORE);
    Case { number, plant, shape, feed_mm_per_s, cut, gains, off, off_again, with }
}

/// The machine as configured, with the largest of [`PROPORTIONAL`] that is accepted beside [`INTEGRAL_PER_S`].
fn accepted(plant: &Plant, resonance: Resonance) -> (MachineSettings, Option<[f64; 2]>) {
    for proportional in PROPORTIONAL {
        let gains = [proportional, INTEGRAL_PER_S];
        let machine = machine(plant, resonance, Some(gains));
        if servo(&machine, plant.period_s).is_ok() {
            return (machine, Some(gains));
        }
    }
    (machine(plant, resonance, None), None)
}

fn machine(plant: &Plant, resonance: Resonance, gains: Option<[f64; 2]>) -> MachineSettings {
    let feedback = gains.map(|[proportional, integral_per_s]| FeedbackSettings {
        proportional,
        integral_per_s,
        watch_mm: 0.01,
        max_feed_per_s: 500.0,
    });
    Machine::three_axis()
        .each(|axis| {
            axis.servo.drive = Some(plant.figures(axis.axis.index(), resonance));
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

    /// Distance of a point from the shape, mm; negative within the circle and right of the line.
    fn error(&self, [x, y]: [f64; 2]) -> f64 {
        match self.shape {
            Shape::Circle => x.hypot(y) - self.radius_mm,
            Shape::Line => (LINE[0] * y - LINE[1] * x) / LINE[0].hypot(LINE[1]),
        }
    }
}

/// Follows the track with some parts of the correction, `before` times without counting.
fn follow(
    plant: &Plant,
    track: &Track,
    cut: &Cut,
    servo: &HostServo<'static, 3>,
    parts: Dynamics,
    before: usize,
) -> Outcome {
    let commands = &track.course.commands;
    let first = commands.iter().position(|command| command.cutting).unwrap_or(0);
    let settling = (SETTLING_S / plant.period_s) as usize;
    let duration_s = (commands.len() - first) as f64 * plant.period_s;
    let mut drives = plant.drives.map(|drive| Drive::new(drive, plant.period_s));
    for (drive, at) in drives.iter_mut().zip(commands[first].at) {
        drive.rest_at(at);
    }
    let mut state = servo.start();
    let path = track.course.path();
    let (mut errors, mut off_command, mut led_out) = (Vec::new(), [Vec::new(), Vec::new()], false);
    let mut shaken = [0.0; 2];
    let track_cycles = commands.len() - first;
    let counts = before * track_cycles + settling;
    for (cycle, command) in commands[first..].iter().cycle().take((before + 1) * track_cycles).enumerate() {
        let time_s = (cycle % track_cycles) as f64 * plant.period_s;
        let load = cut.load_at(time_s, duration_s);
        let readings = [0, 1].map(|i| match plant.drives[i].scale_at {
            ScaleAt::Motor => drives[i].position(),
            ScaleAt::Load => drives[i].position() + shaken[i],
        });
        let mut input = servo.input(command.at, [readings[0], readings[1], command.at[2]]);
        input.dynamics = parts;
        let output = servo.step(&mut state, &input, path.on(command.reference), ());
        led_out |= output.record.status.has(Status::FEEDBACK_OUT);
        for (i, drive) in drives.iter_mut().enumerate() {
            drive.push(load[i]);
            drive.cycle(output.drive[i], readings[i], 1.0);
        }
        shaken = cut.chatter_at(time_s);
        if cycle >= counts {
            let loads = [0, 1].map(|i| drives[i].load_position() + shaken[i]);
            errors.push(1e3 * track.error(loads));
            off_command.iter_mut().enumerate().for_each(|(i, off)| off.push(1e3 * (loads[i] - command.at[i])));
        }
    }
    let at_chatter = |off: &Vec<f64>| amplitude(off, plant.period_s, cut.chatter_hz);
    let chatter_um = if cut.chatters() { at_chatter(&off_command[0]).hypot(at_chatter(&off_command[1])) } else { 0.0 };
    let vibration_um = late_vibration(&errors, plant.period_s);
    Outcome { error_um: Size::of(&errors), vibration_um, chatter_um, led_out }
}
