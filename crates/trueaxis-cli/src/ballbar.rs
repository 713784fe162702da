//! `trueaxis ballbar`.

use crate::csv_in;
use crate::output::{json, print};
use crate::report;
use anyhow::{Result, bail};
use clap::Args;
use std::fmt::Write;
use std::path::PathBuf;
use trueaxis_evaluation::ballbar::{COLUMNS, Document, Test, values};
use trueaxis_report::number::significant;
use trueaxis_tables::output::Outputs;

pub(crate) const HELP: &str = "\
RECORD.csv: angle_deg,deviation_um,direction, one row a reading: angle of the command on its circle from +X towards +Y,
actual less nominal radius, 1 counterclockwise or -1 clockwise. Whole circles, best in both directions.

G(b), G, F, H: circular, radial deviation and hysteresis after ISO 230-4, about the least-squares centre. One fit tells the
causes apart, each with its standard error (d = +1 counterclockwise, -1 clockwise):
  scale mismatch  (R/2)(s_x − s_y) cos 2θ         squareness      −(R/2) C0Y sin 2θ
  servo mismatch  (d/2)(l_x − l_y) sin 2θ         straightness    q_x cos²θ sin θ + q_y sin²θ cos θ
  backlash        (d/2)(b_x sgn(sin θ) cos θ − b_y sgn(cos θ) sin θ)
  lateral play    (d/2)(p_x |sin θ| − p_y |cos θ|)
  reversal        spikes of height h after an axis' reversals; cyclic: periodic errors, their pitch searched or given
One direction cannot tell servo mismatch and lateral play; they are null then.

Example: trueaxis ballbar record.csv --radius-mm 100 --report out";

#[derive(Args)]
pub(crate) struct Arguments {
    /// Recorded circles.
    #[arg(value_name = "RECORD.csv")]
    record: PathBuf,
    /// Nominal radius of the circle.
    #[arg(long, value_name = "R")]
    radius_mm: f64,
    /// Pitch of the periodic error of X, of its screw or encoder [default: searched].
    #[arg(long, value_name = "P")]
    pitch_x_mm: Option<f64>,
    /// Pitch of the periodic error of Y [default: searched].
    #[arg(long, value_name = "P")]
    pitch_y_mm: Option<f64>,
    /// One JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write ballbar.html with polar plots into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let pitches = [arguments.pitch_x_mm, arguments.pitch_y_mm];
    let lengths =
        [("--radius-mm", Some(arguments.radius_mm)), ("--pitch-x-mm", pitches[0]), ("--pitch-y-mm", pitches[1])];
    for (name, value) in lengths {
        if let Some(value) = value.filter(|value| !(1e-3..=1e5).contains(value)) {
            bail!("{name}: found {value}, needed 0.001 to 100000 mm");
        }
    }
    let mut rows = csv_in::open(&arguments.record, &COLUMNS, "readings")?;
    let test = Test::read(&mut rows, arguments.radius_mm, pitches)?;
    let document = test.document();
    if let Some(directory) = &arguments.report {
        let source = arguments.record.file_name().unwrap_or_default().to_string_lossy();
        let mut outputs = Outputs::of([&arguments.record]);
        report::write(&mut outputs, &report::ballbar::page(&source, &test, &document), directory, "ballbar.html")?;
        outputs.commit()?;
    }
    if arguments.json { json(&document) } else { print(&table(&document)?) }
}

fn table(d: &Document) -> Result<String> {
    let mut text = format!("{} readings, radius {} mm; ISO 230-4\n\n", d.readings, d.radius_mm);
    let um = |value: Option<f64>| value.map_or_else(|| "–".into(), |um| significant(um, 4));
    writeln!(text, "G(b) {} µm   H {} µm", um(d.g_b_um), um(d.h_um))?;
    for (name, take) in [("counterclockwise", 0), ("clockwise", 1)] {
        let of = |ways: trueaxis_evaluation::ballbar::Ways| um(if take == 0 { ways.ccw } else { ways.cw });
        writeln!(text, "{name:<17} G {} µm   F max {} µm   F min {} µm", of(d.g_um), of(d.f_max_um), of(d.f_min_um))?;
    }
    let [x, y] = d.centre_um.map(|um| significant(um, 4));
    writeln!(text, "centre {x}, {y} µm   radius {} µm\n", significant(d.radius_deviation_um, 4))?;
    for [name, value, error] in values(d) {
        writeln!(text, "{name:<22} {value:>14} {error}")?;
    }
    writeln!(text, "\nshares")?;
    for share in &d.shares {
        writeln!(
            text,
            "  {:<20} {:>5.1} %  {} µm RMS",
            share.cause,
            100.0 * share.share,
            significant(share.rms_um, 3)
        )?;
    }
    writeln!(
        text,
        "\nsigma of a reading {} µm, {} degrees of freedom",
        significant(d.sigma_um, 3),
        d.degrees_of_freedom
    )?;
    for warning in &d.warnings {
        writeln!(text, "note: {warning}")?;
    }
    Ok(text)
}
