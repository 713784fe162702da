//! `trueaxis predict-servo`.

use crate::output::{json, print};
use crate::{model, report};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use trueaxis_evaluation::simulated::servo::{Family, Options, predict};
use trueaxis_sim::program::{Program, ReadOptions, Source};
use trueaxis_sim::{Scenario, Settings};
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis predict-servo short-tour compensation-tables/mill-3axis \\
    --rate-hz 1000";

pub(crate) const HELP: &str = "\
The drives of a machine are never exactly what its machine.toml states. The bound is a contour error that the program \
does not exceed, with the corrections as the machine.toml configures them, on plants of a family about its figures in \
[axis.X.drive] and [axis.X.friction]: every figure of every axis varies by itself. Geometry is as the tables state it.

For the bound some 30 to 140 plants are simulated: the figures as stated, one figure at a time at either end, and those \
that are the worst of 4,000 drawn plants if the effects add up. The bound of a line is 1.15 times its worst error. It \
is not a proof for every plant: it is made to be above the worst of 1,000 plants drawn evenly from the family, and at \
most 1.5 times that. --plants draws some, and shows the worst beside the bound.

Rigid drives have no resonance. With --resonance-hz every axis has two masses, the motor with half of the mass and the \
position encoder; the machine.toml's figures are then those of this motor's loops.";

#[derive(Args)]
pub(crate) struct PredictServoArgs {
    /// Program: a G-code file, or circle-diamond-square, butterfly, pocket-3d, cone-5axis, s-shape, short-tour.
    #[arg(value_name = "PROGRAM")]
    program: PathBuf,
    /// machine.toml or its folder.
    #[arg(value_name = "MACHINE")]
    machine: PathBuf,
    /// Feed of every line that keeps this bound, µm.
    #[arg(long, value_name = "UM")]
    feed_for: Option<f64>,
    /// Servo rate, Hz.
    #[arg(long, value_name = "HZ", default_value_t = 10_000.0)]
    rate_hz: f64,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write a page with a plot: a folder (predict-servo.html) or a file that ends in .html.
    #[arg(long, value_name = "DIR|FILE")]
    report: Option<PathBuf>,
    /// Also simulate this many plants drawn from the family, up to 100000, and show the worst of them.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=100_000), help_heading = "Drawn plants")]
    plants: u32,
    /// Seed of the plants drawn; the same seed draws the same plants.
    #[arg(long, value_name = "SEED", default_value_t = 1, help_heading = "Drawn plants")]
    seed: u64,
    #[command(flatten)]
    family: FamilyArgs,
}

#[derive(Args)]
#[command(next_help_heading = "Family")]
struct FamilyArgs {
    /// Gains of position and velocity loop, ± percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 10.0)]
    gains: f64,
    /// Coulomb and viscous friction, ± percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 50.0)]
    friction: f64,
    /// Pre-sliding, ± percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 30.0)]
    presliding: f64,
    /// Resonance of motor and load on every axis, Hz [default: none, rigid drives].
    #[arg(long, value_name = "HZ")]
    resonance_hz: Option<f64>,
    /// Damping of the resonance, share of critical.
    #[arg(long, value_name = "SHARE", default_value_t = 0.03)]
    resonance_damping: f64,
    /// Frequency of the resonance, ± percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 10.0)]
    resonance: f64,
    /// Damping of the resonance, ± percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 50.0)]
    damping: f64,
}

impl FamilyArgs {
    fn family(&self) -> Family {
        Family {
            gains: self.gains / 100.0,
            friction: self.friction / 100.0,
            presliding: self.presliding / 100.0,
            resonance_hz: self.resonance_hz.unwrap_or(0.0),
            resonance_damping: self.resonance_damping,
            resonance: self.resonance / 100.0,
            damping: self.damping / 100.0,
        }
    }
}

pub(crate) fn run(arguments: &PredictServoArgs) -> Result<()> {
    let source = Source::read(&arguments.program)?;
    let program =
        Program::read(&source.name, &source.bytes, &source.file, &ReadOptions::default().beside(&arguments.program))?;
    let machine = model::source(&arguments.machine)?;
    let settings = Settings { rate_hz: arguments.rate_hz, ..Settings::default() };
    let scenario = Scenario::new(machine, program, settings)?;
    let options = Options {
        family: arguments.family.family(),
        plants: arguments.plants as usize,
        seed: arguments.seed,
        feed_for_um: arguments.feed_for,
    };
    let document = predict(scenario, &options)?;
    if let Some(to) = &arguments.report {
        let mut outputs = Outputs::of(model::files(&arguments.machine).into_iter().chain([arguments.program.clone()]));
        let page = document.shown().page("", report::NO_FIGURES);
        report::write_to(&mut outputs, &page, to, "predict-servo.html")?;
        outputs.commit()?;
    }
    if arguments.json { json(&document) } else { print(&document.shown().text()) }
}
