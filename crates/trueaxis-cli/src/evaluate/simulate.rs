//! `trueaxis evaluate … simulate`.

use super::probing::Of;
use super::thermal::Kind;
use crate::numbers::triple;
use crate::simulate::{Disturbances, OnMachine, Rehearsal, write};
use anyhow::{Result, anyhow, bail};
use clap::Args;
use std::path::PathBuf;
use trueaxis_evaluation::simulated::rehearsal::{Diagonals, FollowedBall, NOISE_UM, ProbedFeature, TracedPoints};
use trueaxis_sim::warming::{IsoTest, Load};
use trueaxis_tables::output::Outputs;

const ON_MACHINE: &str = "\
TRUE is a machine.toml, whose tables, location errors and backlash are the true errors; with --corrected-by the tables \
of another one correct it. The instrument reads the true tip, which comes from exact products of rigid transforms.";

macro_rules! rehearsal {
    ($of:ty, $about:literal, $example:literal, $help:expr) => {
        impl Rehearsal for $of {
            const ABOUT: &'static str = $about;
            const EXAMPLE: &'static str = concat!("Example:\n", $example);
            const HELP: &'static str = $help;
        }
    };
}

/// Arguments of `points simulate`.
#[derive(Args)]
pub(crate) struct PointsArgs {
    #[command(flatten)]
    on: OnMachine,
    /// Points along X, Y, Z over the travels, 2 to 41.
    #[arg(long, value_name = "NX,NY,NZ", default_value = "6,6,6", value_parser = three_counts)]
    points: [usize; 3],
    /// Offset of the reflector from the last tool-side frame (may be given several times) [default: the machine's tool_mm].
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    reflector_mm: Vec<[f64; 3]>,
}

rehearsal!(
    PointsArgs,
    "Write the points that a tracer would measure on a machine of stated errors, noise and drift",
    "  trueaxis evaluate points simulate \\\n      --machine compensation-tables/mill-3axis -o tracer.csv",
    ON_MACHINE
);

impl PointsArgs {
    pub(super) fn run(&self) -> Result<()> {
        let points = TracedPoints { points: self.points, reflectors_mm: self.reflector_mm.clone() };
        self.on.write(|instrument| points.record(instrument))
    }
}

fn three_counts(text: &str) -> Result<[usize; 3], String> {
    let needed = || format!("found {text:?}, needed three whole numbers: NX,NY,NZ");
    let counts: Result<Vec<usize>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    counts.ok().and_then(|counts| counts.try_into().ok()).ok_or_else(needed)
}

/// Arguments of `r-test simulate`.
#[derive(Args)]
pub(crate) struct RTestArgs {
    #[command(flatten)]
    on: OnMachine,
    /// Position of X, Y, Z at which the tool is at the ball with the rotary axes at zero.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    ball_mm: [f64; 3],
    /// Angles of A, B, C (given once for every pose).
    #[arg(long, value_name = "A,B,C", value_parser = triple, allow_hyphen_values = true, required = true)]
    angles_deg: Vec<[f64; 3]>,
}

rehearsal!(
    RTestArgs,
    "Write the R-test that a machine of stated errors would give, with noise and drift",
    "  trueaxis evaluate r-test simulate --machine records/trunnion \\\n      --ball-mm 60,0,-80 --angles-deg 0,0,0 --angles-deg 0,0,90 \\\n      \
     --angles-deg 0,0,180 --angles-deg 0,0,270 -o r-test.csv",
    ON_MACHINE
);

impl RTestArgs {
    pub(super) fn run(&self) -> Result<()> {
        let ball = FollowedBall { ball_mm: self.ball_mm, angles_deg: self.angles_deg.clone() };
        self.on.write(|instrument| ball.record(instrument))
    }
}

/// Arguments of `step-diagonal simulate`.
#[derive(Args)]
pub(crate) struct StepDiagonalArgs {
    #[command(flatten)]
    on: OnMachine,
    /// Move X, Y and Z one after the other, which makes it a step-diagonal test.
    #[arg(long)]
    steps: bool,
    /// Steps along a diagonal, 2 to 100.
    #[arg(long, value_name = "N", default_value_t = 5)]
    targets: usize,
    /// Runs of every diagonal.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=20))]
    runs: u32,
    /// Standard deviation of the mirror's and the beam's alignment on each diagonal, 0 to 10000.
    #[arg(long, value_name = "U", default_value_t = 0.0, allow_negative_numbers = true)]
    alignment_urad: f64,
    /// Distance of the box from the ends of the travels.
    #[arg(long, value_name = "MM", default_value_t = 10.0, allow_negative_numbers = true)]
    margin_mm: f64,
}

rehearsal!(
    StepDiagonalArgs,
    "Write the diagonal test that a machine of stated errors would give, with noise and drift",
    "  trueaxis evaluate step-diagonal simulate \\\n      --machine compensation-tables/mill-3axis -o diagonal.csv",
    ON_MACHINE
);

impl StepDiagonalArgs {
    pub(super) fn run(&self) -> Result<()> {
        if !(0.0..=1e4).contains(&self.alignment_urad) {
            bail!("--alignment-urad: found {}, needed 0 to 10000 urad", self.alignment_urad);
        }
        if !(0.0..=1e5).contains(&self.margin_mm) {
            bail!("--margin-mm: found {}, needed 0 to 100000 mm", self.margin_mm);
        }
        let diagonals = Diagonals {
            steps: self.steps,
            targets: self.targets,
            runs: self.runs,
            alignment: 1e-6 * self.alignment_urad,
            margin_mm: self.margin_mm,
        };
        self.on.write(|instrument| diagonals.record(instrument))
    }
}

/// Arguments of `probing simulate`.
#[derive(Args)]
pub(crate) struct ProbingArgs {
    #[command(flatten)]
    on: OnMachine,
    /// The probed feature.
    #[arg(long, value_enum)]
    feature: Of,
    /// Diameter of the ring or sphere, 1 to 1000.
    #[arg(long, value_name = "D", default_value_t = 50.0, allow_negative_numbers = true)]
    diameter_mm: f64,
    /// Diameter of the stylus tip.
    #[arg(long, value_name = "D", default_value_t = 6.0, allow_negative_numbers = true)]
    tip_mm: f64,
    /// Amplitude of three lobes of the probe around its tip, 0 to 100.
    #[arg(long, value_name = "U", default_value_t = 0.0, allow_negative_numbers = true)]
    lobes_um: f64,
    /// Axis positions of the feature's centre [default: the middle of the travels].
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    at_mm: Option<[f64; 3]>,
    /// Runs.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    runs: u32,
}

rehearsal!(
    ProbingArgs,
    "Write the touches that a probe would give on a machine of stated errors, with noise and drift",
    "  trueaxis evaluate probing simulate --machine records/probing/true \\\n      --feature ring -o ring.csv",
    "\
A ring gets 36 touches, a sphere 25 over its upper half, a point 10 of a face. The feature is some 0.1 mm off its \
place. The tip trips where it touches, apart from lobes and noise. TRUE is a machine.toml, whose tables, location errors \
and backlash are the true errors; with --corrected-by the tables of another one correct it."
);

impl ProbingArgs {
    pub(super) fn run(&self) -> Result<()> {
        let feature = ProbedFeature {
            feature: self.feature.feature(),
            diameter_mm: self.diameter_mm,
            tip_mm: self.tip_mm,
            lobes_mm: 1e-3 * self.lobes_um,
            at_mm: self.at_mm,
            runs: self.runs,
        };
        feature.check().map_err(|wrong| wrong.option())?;
        self.on.write(|instrument| feature.record(instrument))
    }
}

/// Arguments of `thermal simulate`.
#[derive(Args)]
pub(crate) struct ThermalArgs {
    /// The test of ISO 230-3.
    #[arg(long, value_enum, default_value = "spindle")]
    test: Kind,
    /// Duration, 0.5 to 8.
    #[arg(long, value_name = "H", default_value_t = 6.0, allow_negative_numbers = true)]
    hours: f64,
    /// Speed of the spindle in the first two thirds of --test spindle, 100 to 20000.
    #[arg(long, value_name = "RPM", default_value_t = 9000.0, allow_negative_numbers = true)]
    spindle_rpm: f64,
    /// Distance of the probes at both heights, 1 to 500.
    #[arg(long, value_name = "L", default_value_t = 100.0, allow_negative_numbers = true)]
    distance_mm: f64,
    /// Standard deviation of a reading, 0 to 1000 [default: 0.1].
    #[arg(long, value_name = "U", allow_negative_numbers = true, help_heading = "Disturbances")]
    noise_um: Option<f64>,
    /// Seed; the same seed gives the same file.
    #[arg(long, value_name = "SEED", default_value_t = 1, help_heading = "Disturbances")]
    seed: u64,
    /// The record [default: standard output].
    #[arg(short, long, value_name = "RECORD")]
    output: Option<PathBuf>,
}

rehearsal!(
    ThermalArgs,
    "Write the record that a machine of simulated bodies would give in a thermal test",
    "  trueaxis evaluate thermal simulate --test spindle -o spindle.csv",
    "\
The machine is that of `trueaxis thermal simulate`. The mandrel is as long as the probes are apart and 40 mm more; it is \
read every two minutes. The spindle turns, or X moves, in the first two thirds of the test; the air of the hall follows \
the seed. --test axis reads at X -200 and 200."
);

/// Length of the mandrel below the upper probes' height, mm, and interval of the readings, s.
const MANDREL_MM: f64 = 40.0;
const EVERY_S: u32 = 120;
/// Share of the time in which an axis moves.
const FEED: f64 = 0.8;

impl ThermalArgs {
    pub(super) fn run(&self) -> Result<()> {
        let conditions = Disturbances::of(self.noise_um, self.seed).conditions(None)?;
        let ranges = [
            ("hours", self.hours, [0.5, 8.0]),
            ("spindle-rpm", self.spindle_rpm, [100.0, 20_000.0]),
            ("distance-mm", self.distance_mm, [1.0, 500.0]),
        ];
        for (name, found, [low, high]) in ranges {
            if !(low..=high).contains(&found) {
                return Err(anyhow!("--{name}: found {found}, needed {low} to {high}"));
            }
        }
        let (load, x) = match self.test {
            Kind::Etve => (Load::Air, 0.0),
            Kind::Spindle => (Load::Spindle(self.spindle_rpm), 0.0),
            Kind::Axis => (Load::Axes(FEED), 200.0),
        };
        let test = IsoTest {
            load,
            duration_s: (3600.0 * self.hours) as u32,
            every_s: EVERY_S,
            mandrel_mm: [self.distance_mm + MANDREL_MM, self.distance_mm],
            at_mm: [[-x, 0.0, -200.0], [x, 0.0, -200.0]],
            noise_um: conditions.noise_um.unwrap_or(NOISE_UM),
            seed: conditions.seed,
        };
        let none: [PathBuf; 0] = [];
        write(Outputs::of(none), self.output.as_deref(), &test.record(), &[])
    }
}
