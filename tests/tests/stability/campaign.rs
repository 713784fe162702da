//! Randomly drawn plants, and the effect of the contour feedback on them.

use super::drive::Drive;
use trueaxis::machine::{DriveFigures, MachineSettings};
use trueaxis_sim::Settings;
use trueaxis_testing::noise::Noise;
use trueaxis_tests::course::{Command, Course};

/// Servo rate of the campaign, Hz.
const RATE: &str = "rate_hz = 2000\n";
/// Cycles of a run of the campaign.
pub(crate) const CYCLES: usize = 1000;
/// Cycles in which a force deflects X, mm/s²: a hard spot.
const PUSH: std::ops::Range<usize> = 240..260;
const FORCE_MM_PER_S2: f64 = -2000.0;
/// Cycles of each of the compared windows at the end of the run.
const WINDOW: usize = 260;
/// Radius of the circle, mm.
const RADIUS_MM: f64 = 10.0;

/// Shape of the track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    Line,
    Circle,
}

/// A course without the motion before the cut.
pub(crate) struct Track {
    pub(crate) shape: Shape,
    pub(crate) course: Course,
    first: usize,
}

impl Track {
    pub(crate) fn new(shape: Shape, machine: &MachineSettings) -> Track {
        let program = match shape {
            Shape::Line => "G21 G90 F600\nG1 X120 Y96\nM2\n",
            Shape::Circle => "G21 G90 F600\nG0 X10\nG3 X10 I-10\nM2\n",
        };
        Track::running(shape, program, machine)
    }

    /// A track with this program.
    pub(crate) fn running(shape: Shape, program: &str, machine: &MachineSettings) -> Track {
        let course = Course::new(program, Settings::parse(RATE, "rate.toml").unwrap(), machine);
        let first = course.commands.iter().position(|command| command.cutting).unwrap();
        Track { shape, course, first }
    }

    pub(crate) fn commands(&self, cycles: usize) -> &[Command] {
        &self.course.commands[self.first..][..cycles]
    }

    /// Signed distance of a point from the shape, mm.
    pub(crate) fn error(&self, [x, y]: [f64; 2]) -> f64 {
        match self.shape {
            Shape::Line => (30.0 * y - 24.0 * x) / 30.0_f64.hypot(24.0),
            Shape::Circle => x.hypot(y) - RADIUS_MM,
        }
    }
}

/// Runs the track on two drives, with the push scaled by 1 or 0; `control` computes drive positions from a command and a
/// reading. Returns the contour error of every cycle, µm.
pub(crate) fn errors(
    track: &Track,
    drives: &[DriveFigures; 2],
    (cycles, push): (usize, f64),
    mut control: impl FnMut(&Command, [f64; 2]) -> [f64; 2],
) -> Vec<f64> {
    let [x, y, _] = track.commands(cycles)[0].at;
    let period_s = track.course.period_s;
    let mut drives = [Drive::at(x, drives[0], period_s), Drive::at(y, drives[1], period_s)];
    let cycle = |(cycle, command): (usize, &Command)| {
        let [x, y] = control(command, [drives[0].position, drives[1].position]);
        drives[0].advance(x, if PUSH.contains(&cycle) { push * FORCE_MM_PER_S2 } else { 0.0 });
        drives[1].advance(y, 0.0);
        1e3 * track.error([drives[0].position, drives[1].position])
    };
    track.commands(cycles).iter().enumerate().map(cycle).collect()
}

/// Largest effect of the push on the contour error in each window, µm. The error due to the path alone is subtracted: axes
/// with different lag describe an ellipse, which is not an oscillation of the loop.
pub(crate) fn effects(pushed: &[f64], alone: &[f64]) -> [f64; 3] {
    let first = pushed.len() - 3 * WINDOW;
    std::array::from_fn(|i| {
        let window = first + i * WINDOW..first + (i + 1) * WINDOW;
        pushed[window.clone()].iter().zip(&alone[window]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    })
}

/// A machine tool drive, with typical ratios of the loops' speeds.
pub(crate) fn drive(random: &mut Noise) -> DriveFigures {
    let position_gain_per_s = 30.0 * 6.0_f64.powf(random.unit());
    let velocity_gain_per_s = position_gain_per_s * random.range(5.0, 10.0);
    DriveFigures {
        position_gain_per_s,
        velocity_gain_per_s,
        reset_time_s: random.range(4.0, 10.0) / velocity_gain_per_s,
        velocity_feed_forward: random.unit(),
        current_loop_s: random.range(0.05, 0.2) / velocity_gain_per_s,
        dead_time_s: random.range(0.0, 0.003),
        // Rigid.
        lowest_resonance_hz: 10_000.0,
        ..DriveFigures::with_defaults(0.0, 0.0, 0.0)
    }
}

/// A drive whose figures are each off by up to ±`share`.
pub(crate) fn near(of: &DriveFigures, share: f64, random: &mut Noise) -> DriveFigures {
    let mut off = |figure: f64| figure * random.range(1.0 - share, 1.0 + share);
    DriveFigures {
        position_gain_per_s: off(of.position_gain_per_s),
        velocity_gain_per_s: off(of.velocity_gain_per_s),
        reset_time_s: off(of.reset_time_s),
        velocity_feed_forward: off(of.velocity_feed_forward).min(1.0),
        current_loop_s: off(of.current_loop_s),
        dead_time_s: off(of.dead_time_s),
        ..*of
    }
}
