//! `trueaxis ballbar`.

mod simulate;

use crate::machine_folder::{self, Writing};
use crate::output::{print, report_line};
use crate::report;
use crate::simulate::OrSimulate;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use trueaxis::Axis;
use trueaxis_evaluation::ballbar::{Options, Test};
use trueaxis_evaluation::friction::pair;
use trueaxis_evaluation::model::bytes;
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis ballbar records/ballbar.csv --radius-mm 100";

pub(crate) const HELP: &str = "\
RECORD has whole circles about one centre, or arcs of 200° and more, best in both directions, in one of four \
formats, detected automatically:
  a bar's CSV: angle_deg,deviation_um,direction
  positions: CSV x_cmd_mm,x_mm,y_cmd_mm,y_mm (or with z_cmd_mm,z_mm)
  halsampler: LinuxCNC's lines without a header, with or without -t
  telemetry: COBS frames of a controller, with commands and encoders
In a bar's CSV the angle is that of the command on its circle, from the first axis of --axes towards the second; the \
deviation is actual less nominal radius; the direction is 1 (+, ccw) counterclockwise or -1 (-, cw) clockwise. \
Positions are from a grid encoder or record-circles.py. A line of halsampler has command and position of the first \
axis, then of the second. In positions, the approach to the circle and the exit from it are left out.

After ISO 230-4, G is the circular deviation and G(b) the bidirectional one, both by minimum zone circles (MZC); F \
is the radial deviation about the least-squares centre (LSC) of its direction; H is the circular hysteresis. One fit \
separates the causes, each with half of its interval of 95 % (d = +1 counterclockwise, -1 clockwise):
  scale mismatch: (R/2)(s_x − s_y) cos 2θ
  squareness: −(R/2) C0Y sin 2θ (Y,Z: A0Z; Z,X: −B0Z)
  servo mismatch: (d/2)(l_x − l_y) sin 2θ
  straightness: q_x cos²θ sin θ + q_y sin²θ cos θ
  backlash: (d/2)(b_x sgn(sin θ) cos θ − b_y sgn(cos θ) sin θ)
  lateral play: (d/2)(p_x |sin θ| − p_y |cos θ|)
  reversal: spikes of height h after an axis' reversals
  cyclic: periodic errors, their pitch searched or given
One direction cannot show servo mismatch and lateral play: they are null then. F of an arc is null too. Readings \
from an axis' reversal until its play is taken up are left out of the fit. Spikes of another shape than u/w exp(1 − \
u/w) widen the intervals of similar causes, and a note says so.

-o writes squareness and backlash into a machine, with their uncertainties, if they differ from its values by more \
than two combined standard uncertainties; values that agree become their weighted mean. Tables do not store the \
other causes.

More examples:
  # A rehearsal, see its own help:
  trueaxis ballbar simulate --machine mymill --radius-mm 100 -o record.csv
  trueaxis ballbar samples.txt --radius-mm 50 --axes Z,X
  trueaxis ballbar frames.bin --radius-mm 50
  trueaxis ballbar record.csv --radius-mm 100 --machine mymill -o mymill";

/// A record to evaluate, or the rehearsal.
pub(crate) type Ballbar = OrSimulate<BallbarArgs, simulate::SimulateArgs>;

#[derive(Args)]
#[command(group(clap::ArgGroup::new("decided").args(["dry_run", "force"]).multiple(true).requires("machine")))]
#[command(group(clap::ArgGroup::new("into").args(["output", "dry_run"]).multiple(true)))]
pub(crate) struct BallbarArgs {
    /// Recorded circles.
    #[arg(value_name = "RECORD")]
    record: PathBuf,
    /// Nominal radius of the circle.
    #[arg(long, value_name = "R")]
    radius_mm: f64,
    /// The two axes of the circles' plane, in its sense: X,Y, Z,X or Y,Z, or a pair the other way round.
    #[arg(long, value_name = "X,Y", value_parser = pair, default_value = "X,Y")]
    axes: [Axis; 2],
    /// Pitch of the periodic error of X, of its screw or encoder [default: searched].
    #[arg(long, value_name = "P")]
    pitch_x_mm: Option<f64>,
    /// Pitch of the periodic error of Y [default: searched].
    #[arg(long, value_name = "P")]
    pitch_y_mm: Option<f64>,
    /// Pitch of the periodic error of Z [default: searched].
    #[arg(long, value_name = "P")]
    pitch_z_mm: Option<f64>,
    /// The machine that was measured, for -o.
    #[arg(long, value_name = "M", requires = "into", help_heading = "Writing into a machine")]
    machine: Option<PathBuf>,
    /// The machine's tables corrected it during the circles: add the errors found to them instead of replacing them.
    #[arg(long, requires = "machine", help_heading = "Writing into a machine")]
    compensated: bool,
    /// Folder to write the machine into: its own, or a new one.
    #[arg(short, long, value_name = "MACHINE_DIR", requires = "machine", help_heading = "Writing into a machine")]
    output: Option<PathBuf>,
    #[command(flatten)]
    writing: Writing,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write ballbar.html with polar plots into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Ballbar) -> Result<()> {
    match arguments {
        OrSimulate::Evaluate(arguments) => evaluate(arguments),
        OrSimulate::Simulate(arguments) => simulate::run(arguments),
    }
}

fn evaluate(arguments: &BallbarArgs) -> Result<()> {
    let into = arguments.writing.output(arguments.output.as_deref());
    let _alone = into.map(machine_folder::alone).transpose()?;
    let pitches_mm = [arguments.pitch_x_mm, arguments.pitch_y_mm, arguments.pitch_z_mm];
    let options = Options::new(arguments.radius_mm, arguments.axes, pitches_mm).map_err(|wrong| wrong.option())?;
    let record = &arguments.record;
    let bytes = bytes(record)?;
    let test = Test::read(&bytes, record, &options, |note| report_line(format_args!("note: {note}")))?;
    let document = test.document();
    let files = arguments.machine.iter().flat_map(|machine| machine_folder::inputs(machine, into));
    let mut outputs = Outputs::of(files.chain([arguments.record.clone()]));
    let mut done = machine_folder::Done::default();
    if let Some(machine) = &arguments.machine {
        let additions = test.additions(arguments.compensated);
        done = machine_folder::decide(&mut outputs, machine, into, record, (arguments.writing, additions))?;
    }
    if arguments.writing.dry_run {
        return done.dry_run(&document, arguments.json);
    }
    let shown = document.shown(&test);
    if let Some(directory) = &arguments.report {
        report::stage(&mut outputs, (directory, "ballbar.html"), &arguments.record, &shown, report::NO_FIGURES)?;
    }
    outputs.commit()?;
    done.print_notes();
    if arguments.json { done.json(&document) } else { print(&shown.text()) }
}
