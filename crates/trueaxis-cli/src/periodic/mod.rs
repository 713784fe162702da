//! `trueaxis periodic`.

mod simulate;

use crate::machine_folder::{self, Writing};
use crate::numbers::{number, triple};
use crate::output::print;
use crate::simulate::OrSimulate;
use crate::{csv_in, report};
use anyhow::{Result, bail};
use clap::Args;
use std::path::PathBuf;
use trueaxis::Axis;
use trueaxis_evaluation::friction::pair;
use trueaxis_evaluation::periodic::{COLUMNS, Circle, Options, Recording, Test};
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis periodic records/screw.csv --axis X --period-mm 5";

pub(crate) const HELP: &str = "\
RECORD.csv is one of
  a scan: position_mm,error_um or position_mm,error_um,direction (1, + or fwd; -1, - or rev)
  a scan in both directions: position_mm,fwd_um,rev_um
  a ballbar's: angle_deg,deviation_um,direction, with --radius-mm and --centre-mm
The error is actual less commanded position; of a rotary axis position_deg and error_urad. Without a \
direction, falling positions are negative travel. Positions are machine coordinates, so the phase refers to machine \
zero. --centre-mm states where the circle was on the axes.

Periods are known beforehand: the pitch of the screw, of the motor's poles (pitch over pole pairs; of a stepper: \
four full steps), of a gear's or rack's teeth, of the scale. Give --period-mm once for each.

The model:
  e(q) = S(q) + Σ_P Σ_h a_h cos(2πhq/P) + b_h sin(2πhq/P)
S is the slow error, a cubic spline for each direction whose bends are at least 2 P apart, as many as the readings \
justify. A harmonic is kept if noise would give one as large in fewer than 3 of 1000 records, and the directions \
get their own harmonics if they differ by as much. Uncertainties come from the residual: its mean square, or its \
power near the harmonic where drift or vibration raises it. On a circle the errors of both axes are fitted, as \
chirps over the angle; readings within 3° of a reversal are left out.

Refused, with what is needed: fewer than three periods in the scan, fewer than four points in a period of a harmonic \
(and what it looks like at that spacing), two periods that the length does not separate.

The record needs points at most P/4 apart, better P/24 for six harmonics, and does not need equal distances: a laser \
or a scale read at slow feed, a grid encoder, a dial gauge every 0.2 mm over twenty turns of the screw.

-o writes the periods into [[axis.X.periodic]] of a machine, if they differ from those there by more than two combined \
standard uncertainties; coefficients that agree become weighted means. Each section has the harmonics of one or of \
both directions and their standard uncertainty. Harmonics that were not tried keep their stated values. What another \
table or section already contains of a period is refused.

More examples:
  # A rehearsal, see its own help:
  trueaxis periodic simulate --machine mymill --axis X -o scan.csv
  trueaxis periodic scan.csv --axis X --period-mm 5 --period-mm 1.25 --report out
  trueaxis periodic scan.csv --axis X --period-mm 5 -o mymill --dry-run
  trueaxis periodic circle.csv --axis Y --period-mm 10 --radius-mm 150 \\
      --centre-mm 300,200,50";

/// A record to evaluate, or the rehearsal.
pub(crate) type Periodic = OrSimulate<PeriodicArgs, simulate::SimulateArgs>;

#[derive(Args)]
#[command(group(clap::ArgGroup::new("period").args(["period_mm", "period_deg"]).required(true)))]
#[command(group(clap::ArgGroup::new("into").args(["output", "dry_run"]).multiple(true)))]
pub(crate) struct PeriodicArgs {
    /// Recorded scan or circles.
    #[arg(value_name = "RECORD.csv")]
    record: PathBuf,
    /// The axis.
    #[arg(long, value_name = "X", value_parser = axis)]
    axis: Axis,
    /// A period of a linear axis (may be given several times).
    #[arg(long, value_name = "P", value_parser = number, allow_negative_numbers = true)]
    period_mm: Vec<f64>,
    /// A period of a rotary axis (may be given several times).
    #[arg(long, value_name = "P", value_parser = number, allow_negative_numbers = true)]
    period_deg: Vec<f64>,
    /// Harmonics of each period, 1 to 6 [default: as many as the points permit].
    #[arg(long, value_name = "N")]
    harmonics: Option<usize>,
    /// Nominal radius of a ballbar's circle.
    #[arg(long, value_name = "R", requires = "centre_mm", help_heading = "A ballbar's record")]
    radius_mm: Option<f64>,
    /// Axis positions of the circle's centre.
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = triple,
        allow_hyphen_values = true,
        requires = "radius_mm",
        help_heading = "A ballbar's record"
    )]
    centre_mm: Option<[f64; 3]>,
    /// The two axes of the circle's plane, in its sense: X,Y, Z,X or Y,Z, or a pair the other way round.
    #[arg(long, value_name = "X,Y", value_parser = pair, default_value = "X,Y", help_heading = "A ballbar's record")]
    axes: [Axis; 2],
    /// The machine that was measured [default: that of -o].
    #[arg(long, value_name = "M", requires = "into", help_heading = "Writing into a machine")]
    machine: Option<PathBuf>,
    /// The machine's figures corrected it during the record: add what it shows to them instead of replacing them.
    #[arg(long, requires = "into", help_heading = "Writing into a machine")]
    compensated: bool,
    /// Folder to write the machine into: its own, or a new one.
    #[arg(short, long, value_name = "MACHINE_DIR", help_heading = "Writing into a machine")]
    output: Option<PathBuf>,
    #[command(flatten)]
    writing: Writing,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write periodic.html with the error folded to each period, the residual and the spectrum into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Periodic) -> Result<()> {
    match arguments {
        OrSimulate::Evaluate(arguments) => evaluate(arguments),
        OrSimulate::Simulate(arguments) => simulate::run(arguments),
    }
}

/// An axis by its letter.
fn axis(text: &str) -> Result<Axis, String> {
    let mut letters = text.trim().chars();
    let axis = letters.next().and_then(|letter| Axis::from_letter(letter.to_ascii_uppercase()));
    let axis = axis.filter(|_| letters.next().is_none());
    axis.ok_or_else(|| format!("found {text:?}, needed X, Y, Z, A, B or C"))
}

/// What the arguments say of the record.
fn options(arguments: &PeriodicArgs) -> Result<Options> {
    let axis = arguments.axis;
    let [own, other] = if axis.is_rotary() { ["--period-deg", "--period-mm"] } else { ["--period-mm", "--period-deg"] };
    let (periods, none) = if axis.is_rotary() {
        (&arguments.period_deg, &arguments.period_mm)
    } else {
        (&arguments.period_mm, &arguments.period_deg)
    };
    if !none.is_empty() {
        bail!("{other}: found axis {}, needed {own}", axis.letter());
    }
    let circle = arguments.radius_mm.zip(arguments.centre_mm);
    let circle = circle.map(|(radius_mm, centre_mm)| Circle { radius_mm, axes: arguments.axes, centre_mm });
    let options = Options { axis, periods: periods.clone(), harmonics: arguments.harmonics, circle };
    options.check()?;
    Ok(options)
}

fn evaluate(arguments: &PeriodicArgs) -> Result<()> {
    let options = options(arguments)?;
    let into = arguments.writing.output(arguments.output.as_deref());
    let machine = arguments.machine.as_ref().or(arguments.output.as_ref());
    let decides = arguments.writing.decides(into)?;
    let _alone = into.map(machine_folder::alone).transpose()?;
    let record = &arguments.record;
    let rows = csv_in::open(record, &COLUMNS, "readings")?;
    let test = Test::of(Recording::read(rows, &options)?, &options)?;
    let document = test.document();
    let files = machine.into_iter().flat_map(|machine| machine_folder::inputs(machine, into));
    let mut outputs = Outputs::of(files.chain([record.clone()]));
    let mut done = machine_folder::Done::default();
    match machine {
        Some(machine) if decides => {
            let additions = (arguments.writing, test.additions(arguments.compensated));
            done = machine_folder::decide(&mut outputs, machine, into, record, additions)?;
        }
        None if decides => bail!("--dry-run: found no machine, needed --machine M or -o MACHINE_DIR"),
        _ => {}
    }
    if arguments.writing.dry_run {
        return done.dry_run(&document, arguments.json);
    }
    let shown = document.shown(&test);
    if let Some(directory) = &arguments.report {
        report::stage(&mut outputs, (directory, "periodic.html"), record, &shown, report::NO_FIGURES)?;
    }
    outputs.commit()?;
    done.print_notes();
    if arguments.json { done.json(&document) } else { print(&shown.text()) }
}
