//! `trueaxis uncertainty`.

use crate::correct::position;
use crate::model;
use crate::numbers::{Numbers, numbers};
use crate::output::{json, print};
use crate::report;
use crate::tables::collapse::{Pose, Volume, pose, volume};
use anyhow::Result;
use clap::Args;
use std::fmt::Write;
use std::path::PathBuf;
use trueaxis_evaluation::uncertainty::{AtPoint, Options, Spread, UncertaintyDocument, evaluate};
use trueaxis_report::number::significant;
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
A table may state them point by point, in a column such as EXX_u_um. Each section may have degrees_of_freedom. \
Uncertainties that are not stated count as zero and are listed.

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
        report::write_to(&mut outputs, &report::uncertainty::page(&document), to, "uncertainty.html")?;
        outputs.commit()?;
    }
    if arguments.json { json(&document) } else { print(&table(&document)?) }
}

fn table(d: &UncertaintyDocument) -> Result<String, std::fmt::Error> {
    let mut text = format!("{}: uncertainty of the corrected position, {} %\n", d.machine, d.confidence_percent);
    let volume: Vec<String> =
        d.volume_mm.iter().map(|(letter, ends)| format!("{letter} {} … {}", ends[0], ends[1])).collect();
    writeln!(text, "working volume {} mm, {} points\n", volume.join(", "), d.points)?;
    writeln!(text, "{:<22}{:>9}{:>9}{:>9}{:>9}   µm", "expanded", "X", "Y", "Z", "radius")?;
    for (name, point) in [("worst point", Some(&d.worst)), ("position", d.at.as_ref())] {
        let Some(point) = point else { continue };
        writeln!(text, "{name}, at {}", point.place())?;
        methods(&mut text, point)?;
    }
    writeln!(
        text,
        "\nstandard uncertainty of the position over the volume {} µm RMS",
        significant(d.standard_rms_um, 3)
    )?;
    writeln!(text, "\n{:<28}{:>8}{:>12}{:>12}", "contribution", "share", "RMS, µm", "worst, µm")?;
    for share in &d.contributions {
        let [rms, worst] = [share.rms_um, share.worst_um].map(|um| significant(um, 3));
        writeln!(text, "{:<28}{:>6.1} %{rms:>12}{worst:>12}", share.term, 100.0 * share.share)?;
    }
    if !d.not_stated.is_empty() {
        writeln!(text, "\nnot stated, taken as zero: {}", d.not_stated.join(", "))?;
    }
    for warning in &d.warnings {
        writeln!(text, "note: {warning}")?;
    }
    Ok(text)
}

fn methods(text: &mut String, point: &AtPoint) -> std::fmt::Result {
    let mut line = |name: &str, spread: &Spread| {
        let [x, y, z] = spread.expanded_um.map(|um| significant(um, 3));
        writeln!(text, "  {name:<20}{x:>9}{y:>9}{z:>9}{:>9}", significant(spread.radius_um, 3))
    };
    line("by derivatives", &point.jacobian)?;
    line("by machines drawn", &point.monte_carlo)?;
    if let Some([x, y, z]) = point.jacobian.factor {
        writeln!(text, "  {:<20}{x:>9.3}{y:>9.3}{z:>9.3}", "factor k")?;
    }
    Ok(())
}
