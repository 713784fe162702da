//! `trueaxis uncertainty`.

use crate::correct::position;
use crate::model;
use crate::numbers::{Numbers, numbers};
use crate::output::{json, print};
use crate::report;
use crate::tables::collapse::{Pose, Volume, pose, volume};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use trueaxis_evaluation::uncertainty::{Options, evaluate};
use trueaxis_tables::output::Outputs;
use trueaxis_tables::uncertainty::Uncertainties;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis uncertainty compensation-tables/mill-3axis --at 120,-40,-200";

pub(crate) const HELP: &str = "\
The machine.toml states how well the machine's figures are known, as standard uncertainties (k = 1):
  [uncertainty]: instrument and set-up after ISO/TR 230-9, with the keys
    device_um_per_m, device_um, misalignment_mm, temperature_k, eve_um,
    expansion_um_per_m_k with temperature_difference_k
  [uncertainty.location]: the keys of [location]
  [axis.X.uncertainty]: scale_ppm, backlash_um, repeatability_um,
    and EXX_um … ECX_urad for every point of a column
  [[uncertainty.correlation]]: between = [two of these keys], coefficient
A table may state them point by point, in a column such as EXX_u_um. Each section may have degrees_of_freedom. \
Uncertainties that are not stated count as zero and are listed; figures without a coefficient are independent. The share \
of a correlated term has half of what it has in common with each other one, and may be negative.

They are propagated to the tip through the error model twice: by its derivatives (first order), and by machines \
drawn at random, whose exact geometry is corrected by the tables as they are. An expanded uncertainty is Student's \
factor times the standard uncertainty, or the interval that contains that share of the machines drawn. The radius is \
that of the sphere about the corrected position that contains the tip.

All axes travel in negative direction, where lost motion counts. The angular errors that nine terms leave are not \
included: see `trueaxis tables collapse`.";

#[derive(Args)]
pub(crate) struct UncertaintyArgs {
    /// machine.toml or its folder.
    #[arg(value_name = "M")]
    machine: PathBuf,
    /// Also evaluate this position: X, Y, Z in mm, then the machine's rotary axes in the order A, B, C in degrees.
    #[arg(
        long,
        value_name = "X,Y,Z[,A,B,C]",
        value_parser = numbers,
        allow_hyphen_values = true,
        help_heading = "Positions"
    )]
    at: Option<Numbers>,
    /// Working volume, mm; an empty entry: the declared travel, or the table's range.
    #[arg(
        long,
        value_name = "X0:X1,Y0:Y1,Z0:Z1",
        value_parser = volume,
        allow_hyphen_values = true,
        help_heading = "Positions"
    )]
    volume: Option<Volume>,
    /// Angles of the rotary axes over the working volume, degrees [default: zero].
    #[arg(long, value_name = "A=..,C=..", value_parser = pose, allow_hyphen_values = true, help_heading = "Positions")]
    pose: Option<Pose>,
    /// Points along each linear axis, 2 to 51.
    #[arg(long, value_name = "N", default_value_t = 9, help_heading = "Positions")]
    points: usize,
    /// Coverage of the expanded uncertainty, percent; 95.45 is k = 2 of a well-known standard uncertainty.
    #[arg(long, value_name = "PERCENT", default_value_t = 95.0, help_heading = "Coverage")]
    confidence: f64,
    /// Number of machines drawn at random.
    #[arg(long, value_name = "N", default_value_t = 10_000, help_heading = "Coverage")]
    trials: usize,
    /// Seed of the machines drawn; the same seed draws the same machines.
    #[arg(long, value_name = "SEED", default_value_t = 1, help_heading = "Coverage")]
    seed: u64,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write a page with plots: a folder (uncertainty.html) or a file that ends in .html.
    #[arg(long, value_name = "DIR|FILE")]
    report: Option<PathBuf>,
}

pub(crate) fn run(arguments: &UncertaintyArgs) -> Result<()> {
    let machine = model::source(&arguments.machine)?;
    let stated = Uncertainties::read(&arguments.machine)?;
    let options = Options {
        at: arguments.at.as_ref().map(|at| position(at, &machine)).transpose()?,
        volume_mm: arguments.volume.unwrap_or_default(),
        pose_deg: arguments.pose.clone().unwrap_or_default(),
        points: arguments.points,
        coverage: arguments.confidence / 100.0,
        trials: arguments.trials,
        seed: arguments.seed,
    };
    let document = evaluate(&machine, &stated, &options)?;
    if let Some(to) = &arguments.report {
        let mut outputs = Outputs::of(model::files(&arguments.machine));
        let page = document.shown().page(&document.machine, report::uncertainty::figures(&document));
        report::write_to(&mut outputs, &page, to, "uncertainty.html")?;
        outputs.commit()?;
    }
    if arguments.json { json(&document) } else { print(&document.shown().text()) }
}
