//! `trueaxis telemetry`.

use crate::output::report_line;
use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use std::io::Write;
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis::telemetry::{AxisFrame, ContourFrame, DynamicFrame, Frame, RoundnessFrame};
use trueaxis_columnar::{Column, Form, Kind, Value, Writer};
use trueaxis_evaluation::received::notes;
use trueaxis_recording::Received;
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::{self, counted};

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis tables compile compensation-tables/mill-3axis -o mill.tcomp
  firmware-sim record --program short-tour --rate-hz 1000 -o run.rec
  firmware-sim replay run.rec mill.tcomp --telemetry frames.bin -o run.csv
  trueaxis telemetry frames.bin -o telemetry.parquet";

pub(crate) const HELP: &str = "\
FRAMES is telemetry of a controller, COBS frames as in docs/telemetry.md, in one file or several of one machine.

The columns are the record's fields:
  sequence, machine_id, tables_crc, fault (code), fault_axis, status
  limited, at_edge
  x_command_mm, x_feedback_mm, x_correction_mm, and so on for every axis
  tip_error_mm, tip_normal_mm, tip_binormal_mm, tip_lag_mm, tip_flags
  encoder_error_mm, and so on: the same from the encoders alone
  orientation_rad, orientation_flags
Rotary axes are in degrees. If any record has a dynamic correction, its parts are columns of every axis too. With \
several files the column `file` names the one that a row is from.

Damaged frames are skipped. Notes give their number, and the number of records that are missing by the sequence.

More examples:
  trueaxis telemetry night/*.bin --axes XYZAC -o night.parquet \\
      --revolutions rounds.parquet
  duckdb -c \"select max(abs(tip_error_mm)) from 'night.parquet' where fault = 0\"";

#[derive(Args)]
pub(crate) struct TelemetryArgs {
    /// Telemetry as it was received.
    #[arg(value_name = "FRAMES", required = true)]
    frames: Vec<PathBuf>,
    /// The table: .parquet or .csv.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Letters of the axes in the step's order; needed for more than three axes [default: XYZ].
    #[arg(long, value_name = "XYZAC")]
    axes: Option<String>,
    /// Also write a table of the gauge's revolutions.
    #[arg(long, value_name = "FILE")]
    revolutions: Option<PathBuf>,
}

pub(crate) fn run(arguments: &TelemetryArgs) -> Result<()> {
    let mut outputs = Outputs::of(&arguments.frames);
    let written = [Some(&arguments.output), arguments.revolutions.as_ref()];
    written.into_iter().flatten().try_for_each(|file| outputs.refuse_input(file))?;
    let mut all = Vec::new();
    for file in &arguments.frames {
        let bytes = std::fs::read(file).with_context(|| file.display().to_string())?;
        let received = Received::read(&bytes);
        notes(file, &received).iter().for_each(|note| report_line(format_args!("note: {note}")));
        all.push((file.display().to_string(), received));
    }
    let letters = axes(arguments.axes.as_deref(), &all)?;
    let several = all.len() > 1;
    let cycles = Cycles { dynamic: all.iter().any(|(_, of)| of.frames.iter().any(has_dynamic)), letters };
    let rows = all.iter().flat_map(|(file, of)| of.frames.iter().map(move |frame| (file.as_str(), frame)));
    put(
        &mut outputs,
        &arguments.output,
        several,
        &cycles.columns(),
        rows.map(|(file, frame)| (file, cycles.row(frame))),
    )?;
    if let Some(file) = &arguments.revolutions {
        let rows =
            all.iter().flat_map(|(file, of)| of.revolutions.iter().map(move |of| (file.as_str(), revolution(of))));
        put(&mut outputs, file, several, &REVOLUTION.map(|(name, kind)| Column::new(name, kind)), rows)?;
    }
    outputs.commit()?;
    let cycles: usize = all.iter().map(|(_, of)| of.frames.len()).sum();
    report_line(format_args!("written  {}  {}", arguments.output.display(), counted(cycles, "cycle")));
    if let Some(file) = &arguments.revolutions {
        let count: usize = all.iter().map(|(_, of)| of.revolutions.len()).sum();
        report_line(format_args!("written  {}  {}", file.display(), counted(count, "revolution")));
    }
    Ok(())
}

/// The axes that all records contain.
fn axes(given: Option<&str>, all: &[(String, Received)]) -> Result<Vec<Axis>> {
    let mut frames = all.iter().flat_map(|(file, of)| of.frames.iter().map(move |frame| (file, frame)));
    let Some((file, first)) = frames.next() else {
        let files: Vec<_> = all.iter().map(|(file, _)| file.as_str()).collect();
        bail!("{}: found no whole record of a cycle, needed telemetry as in docs/telemetry.md", files.join(", "));
    };
    let (count, machine) = (first.axes.len(), first.machine_id);
    for (other, frame) in frames {
        if frame.machine_id != machine || frame.axes.len() != count {
            bail!(
                "{other}: found a record of machine {:08x} with {}, needed machine {machine:08x} with {}, as at the start of {file}",
                frame.machine_id,
                text::axes(frame.axes.len()),
                text::axes(count)
            );
        }
    }
    let letters = match given {
        Some(letters) => letters,
        None if count == 3 => "XYZ",
        None => bail!("--axes: found records of {}, needed their letters, such as XYZAC", text::axes(count)),
    };
    let axes: Option<Vec<Axis>> =
        letters.chars().map(|letter| Axis::from_letter(letter.to_ascii_uppercase())).collect();
    let axes = axes.filter(|axes| axes.len() == count && axes.is_sorted_by(|a, b| a.index() < b.index()));
    axes.ok_or_else(|| anyhow!("--axes: found {letters:?}, needed {count} letters of XYZABC in that order"))
}

fn put<'f>(
    outputs: &mut Outputs,
    path: &Path,
    several: bool,
    columns: &[Column],
    rows: impl Iterator<Item = (&'f str, Vec<Value<'f>>)>,
) -> Result<()> {
    let Some(form) = Form::of(path) else {
        bail!("{}: found another ending, needed .parquet or .csv", path.display());
    };
    let mut all = columns.to_vec();
    if several {
        all.insert(0, Column::new("file", Kind::Text));
    }
    let cannot = || format!("cannot write {}", path.display());
    let mut table = Writer::new(std::io::BufWriter::new(outputs.begin(path)?), form, &all).with_context(cannot)?;
    for (file, row) in rows {
        let file = several.then_some(Value::Text(file));
        table.row(file.into_iter().chain(row)).with_context(cannot)?;
    }
    let mut file = table.finish().with_context(cannot)?;
    file.flush().with_context(cannot)?;
    let file = file.into_inner().map_err(|error| error.into_error()).with_context(cannot)?;
    outputs.add(path, file);
    Ok(())
}

fn has_dynamic(frame: &Frame) -> bool {
    frame.axes.iter().any(|axis| axis.dynamic.is_some())
}

/// Rows of the table of cycles.
struct Cycles {
    letters: Vec<Axis>,
    dynamic: bool,
}

const HEAD: [&str; 8] = ["sequence", "machine_id", "tables_crc", "fault", "fault_axis", "status", "limited", "at_edge"];
const DYNAMIC: [&str; 5] = ["dynamic", "feed_forward", "contour_feedback", "crosstalk", "learned"];

impl Cycles {
    fn columns(&self) -> Vec<Column> {
        let mut columns = HEAD.map(|name| Column::new(name, Kind::Whole)).to_vec();
        for axis in &self.letters {
            let (letter, unit) = (axis.letter().to_ascii_lowercase(), if axis.is_rotary() { "deg" } else { "mm" });
            let parts =
                ["command", "feedback", "correction"].into_iter().chain(DYNAMIC.into_iter().filter(|_| self.dynamic));
            columns.extend(parts.map(|part| Column::new(format!("{letter}_{part}_{unit}"), Kind::Number)));
        }
        for of in ["tip", "encoder"] {
            let lengths = ["error", "normal", "binormal", "lag"];
            columns.extend(lengths.map(|what| Column::new(format!("{of}_{what}_mm"), Kind::Number)));
            columns.push(Column::new(format!("{of}_flags"), Kind::Whole));
        }
        columns.push(Column::new("orientation_rad", Kind::Number));
        columns.push(Column::new("orientation_flags", Kind::Whole));
        columns
    }

    fn row(&self, frame: &Frame) -> Vec<Value<'static>> {
        let Frame { sequence, machine_id, tables_crc, fault, fault_axis, status, limited, at_edge, .. } = frame;
        let head = [*sequence, *machine_id, *tables_crc].map(i64::from).into_iter();
        let head = head.chain([u8::from(*fault), *fault_axis, status.0, *limited, *at_edge].map(i64::from));
        let mut row: Vec<_> = head.map(Value::Whole).collect();
        for AxisFrame { command, feedback, correction, dynamic } in &frame.axes {
            row.extend([*command, *feedback, f64::from(*correction)].map(Value::Number));
            if self.dynamic {
                let DynamicFrame { sent, feed_forward, feedback, crosstalk, learned } = dynamic.unwrap_or_default();
                row.extend([sent, feed_forward, feedback, crosstalk, learned].map(|part| Value::Number(part.into())));
            }
        }
        for ContourFrame { error, normal, binormal, lag, flags } in [&frame.tip, &frame.encoder] {
            row.extend([error, normal, binormal, lag].map(|part| Value::Number((*part).into())));
            row.push(Value::Whole((*flags).into()));
        }
        row.extend([Value::Number(frame.orientation.into()), Value::Whole(frame.orientation_flags.into())]);
        row
    }
}

const REVOLUTION: [(&str, Kind); 14] = [
    ("machine_id", Kind::Whole),
    ("revolution", Kind::Whole),
    ("evaluated", Kind::Whole),
    ("skipped", Kind::Whole),
    ("discarded", Kind::Whole),
    ("flags", Kind::Whole),
    ("peak_to_valley_um", Kind::Number),
    ("revolutions", Kind::Whole),
    ("x_synchronous_um", Kind::Number),
    ("x_asynchronous_um", Kind::Number),
    ("x_total_um", Kind::Number),
    ("y_synchronous_um", Kind::Number),
    ("y_asynchronous_um", Kind::Number),
    ("y_total_um", Kind::Number),
];

fn revolution(of: &RoundnessFrame) -> Vec<Value<'static>> {
    let counts = [of.machine_id, of.revolution, of.evaluated, of.skipped, of.discarded];
    let mut row: Vec<_> = counts.into_iter().map(|count| Value::Whole(count.into())).collect();
    row.push(Value::Whole(of.flags.0.into()));
    row.push(Value::Number(of.peak_to_valley_um.into()));
    row.push(Value::Whole(of.revolutions.into()));
    for motion in [&of.x, &of.y] {
        let parts = [motion.synchronous_um, motion.asynchronous_um, motion.total_um];
        row.extend(parts.map(|part| Value::Number(part.into())));
    }
    row
}
