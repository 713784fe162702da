//! `trueaxis learn`.

use crate::csv_in;
use crate::output::{json, print};
use crate::report;
use anyhow::{Context, Result, anyhow};
use clap::Args;
use std::fs::File;
use std::path::PathBuf;
use trueaxis_evaluation::learn::{COLUMNS, Record, learned};
use trueaxis_evaluation::model;
use trueaxis_metrology::learning::{DEFAULT_CUTOFF_MM, DEFAULT_FORGET, DEFAULT_GAIN, Law};
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  firmware-sim run --program short-tour --record part1.csv
  trueaxis learn part1.csv -o part1.tlearn";

pub(crate) const HELP: &str = "\
RECORD.csv is one part, cycle by cycle, with three comments before the header:
  # program_id = 1a2b3c4d
  # machine_id = 5e6f7a8b
  # length_mm = 1234.567890
  s_mm,ex_um,ey_um,ez_um,measured
The identifiers are CRC-32, hexadecimal: of the path (docs/learning.md), and of name and chain, as in a .tcomp. The \
length is that of the program's path. s_mm is the path length of the reference; ex_um … the contour error, tip − \
foot, in machine directions; measured (may be left out) is 1, or 0 if no error was measured (rapid motion, search of the \
foot, fault).

The law:
  u <- f u − L Q e
f is --forget, L is --gain, Q is a Gaussian low-pass without phase, half at --cutoff-mm. u is the correction over \
path length for the next part; --table gives that of the part before. The remainder of an error falls by |f − L Q P| \
a part, with P the response of drives and contour feedback; this is below 1 for 0 < L P < 2. `predicted` takes P for \
1.";

#[derive(Args)]
pub(crate) struct LearnArgs {
    /// Contour error of a part over path length.
    #[arg(value_name = "RECORD.csv")]
    record: PathBuf,
    /// Correction that acted on the part [default: none].
    #[arg(long, value_name = "OLD.tlearn")]
    table: Option<PathBuf>,
    /// Gain L, above 0 and below 2.
    #[arg(long, value_name = "L", default_value_t = DEFAULT_GAIN, allow_negative_numbers = true)]
    gain: f64,
    /// Forgetting f, above 0 to 1.
    #[arg(long, value_name = "F", default_value_t = DEFAULT_FORGET, allow_negative_numbers = true)]
    forget: f64,
    /// Cut-off along the path: errors of longer wavelength are learned.
    #[arg(long, value_name = "MM", default_value_t = DEFAULT_CUTOFF_MM, allow_negative_numbers = true)]
    cutoff_mm: f64,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write a page with plots: a folder (learn.html) or a file that ends in .html.
    #[arg(long, value_name = "DIR|FILE")]
    report: Option<PathBuf>,
    /// The correction for the next part.
    #[arg(short, long, value_name = "NEW.tlearn")]
    output: PathBuf,
}

pub(crate) fn run(arguments: &LearnArgs) -> Result<()> {
    let LearnArgs { gain, forget, cutoff_mm, .. } = *arguments;
    let law = Law { gain, forget, cutoff_mm };
    law.check().map_err(|error| anyhow!("--{error}"))?;
    let record = {
        let file = &arguments.record;
        let input = File::open(file).with_context(|| format!("cannot read {}", file.display()))?;
        Record::read(input, file, || csv_in::open(file, &COLUMNS, "cycles"))?
    };
    let bytes = arguments.table.as_ref().map(|table| model::bytes(table).context("--table"));
    let bytes = bytes.transpose()?;
    let old = arguments.table.as_deref().zip(bytes.as_deref());
    let (document, lesson, file) = learned(law, &record, old)?;
    let shown = document.shown(&lesson);
    let mut outputs = Outputs::of([&arguments.record].into_iter().chain(&arguments.table));
    if let Some(to) = &arguments.report {
        let source = arguments.record.file_name().unwrap_or_default().to_string_lossy();
        let page = shown.page(&source, report::NO_FIGURES);
        report::write_to(&mut outputs, &page, to, "learn.html")?;
    }
    outputs.put(&arguments.output, &file)?;
    outputs.commit()?;
    if arguments.json { json(&document) } else { print(&shown.text()) }
}
