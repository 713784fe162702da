//! Runs the profile on the published axes and evaluates the errors.

use super::plant::{PUBLISHED, Plant};
use trueaxis::machine::MachineSettings;
use trueaxis_sim::Settings;
use trueaxis_sim::truth::Truth;
use trueaxis_tests::course::Course;

const PROGRAM: &str = include_str!("../../programs/naca2415.ngc");

/// Servo rate, and motion limits of a fast finishing cut.
const MOTION: &str = "rate_hz = 1000
[motion]
acceleration_mm_per_s2 = 2000
jerk_mm_per_s3 = 50000
normal_acceleration_mm_per_s2 = 1000
";

/// Determines the drive positions of X and Y.
pub(crate) trait Control {
    /// Drive positions of a cycle, mm; `tip` was read at the end of the previous cycle.
    fn drive(&mut self, course: &Course, cycle: usize, tip: [f64; 2]) -> [f64; 2];
}

/// Sends the commands to the drives unchanged.
pub(crate) struct Nothing;

impl Control for Nothing {
    fn drive(&mut self, course: &Course, cycle: usize, _: [f64; 2]) -> [f64; 2] {
        let [x, y, _] = course.commands[cycle].at;
        [x, y]
    }
}

/// Errors along the profile, µm.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outcome {
    /// Largest contour error.
    pub(crate) largest: f64,
    /// Mean contour error.
    pub(crate) mean: f64,
    /// Root mean square of the contour error.
    pub(crate) rms: f64,
    /// Largest and RMS tracking error of X and Y.
    pub(crate) axes: [[f64; 2]; 2],
}

/// The profile at a feed, mm/min.
pub(crate) fn profile(feed_mm_per_min: f64, machine: &MachineSettings) -> Course {
    let mut settings = Settings::parse(MOTION, "motion.toml").unwrap();
    settings.motion.feed_percent = 100.0 * feed_mm_per_min / 12_000.0;
    Course::new(PROGRAM, settings, machine)
}

/// Runs the course with a control.
pub(crate) fn run(course: &Course, control: &mut dyn Control) -> Outcome {
    let [x, y, _] = course.commands[0].at;
    let mut plants = [Plant::at(PUBLISHED[0], x), Plant::at(PUBLISHED[1], y)];
    let (mut tip, mut truth) = ([x, y], Truth::default());
    let (mut outcome, mut count) = (Outcome::default(), 0.0);
    for (cycle, command) in course.commands.iter().enumerate() {
        let drive = control.drive(course, cycle, tip);
        for (plant, drive) in plants.iter_mut().zip(drive) {
            plant.advance(drive, course.period_s);
        }
        tip = [plants[0].position(), plants[1].position()];
        if command.cutting {
            let off = course.deviation(&mut truth, command, [tip[0], tip[1], 0.0]);
            outcome.add(1e3 * off.length(), [0, 1].map(|i| 1e3 * (command.at[i] - tip[i])));
            count += 1.0;
        }
    }
    outcome.over(count)
}

impl Outcome {
    fn add(&mut self, error: f64, tracking: [f64; 2]) {
        self.largest = self.largest.max(error);
        self.mean += error;
        self.rms += error * error;
        for ([largest, rms], error) in self.axes.iter_mut().zip(tracking) {
            *largest = largest.max(error.abs());
            *rms += error * error;
        }
    }

    fn over(mut self, count: f64) -> Outcome {
        self.mean /= count;
        self.rms = (self.rms / count).sqrt();
        for [_, rms] in &mut self.axes {
            *rms = (*rms / count).sqrt();
        }
        self
    }
}
