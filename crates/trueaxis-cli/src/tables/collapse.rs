//! `trueaxis tables collapse`.

use crate::numbers::{number, triple};
use crate::output::{json, print, report_line};
use crate::{machine_folder, model};
use anyhow::{Result, anyhow, bail};
use clap::Args;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis_evaluation::shown::{Cell, Table};
use trueaxis_tables::collapse::{CollapseError, CollapseOptions, Collapsed, Deviation, GridAdvice, collapse};
use trueaxis_tables::formats::machine_files;
use trueaxis_tables::limits::raise;
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis tables collapse compensation-tables/mill-5axis -o mill-nine";

pub(crate) const HELP: &str = "\
The tables are the least-squares ones over the working volume, for one tool and one pose of the rotary axes. The \
controller's own nine-term model evaluates the error that they leave, at other points. A grid of stated size is \
tried on that error, and the last line says whether it is needed. Grids of the machine stay.";

#[derive(Args)]
pub(crate) struct CollapseArgs {
    /// machine.toml, its folder, or a compiled .tcomp.
    #[arg(value_name = "M")]
    machine: PathBuf,
    /// Folder to write the machine with the nine tables into.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Tool tip from the last tool-side frame, mm [default: the machine's tool_mm].
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = triple,
        allow_hyphen_values = true,
        help_heading = "Working volume"
    )]
    tool_mm: Option<[f64; 3]>,
    /// Position at which the cross terms are zero, mm [default: the middle of the volume].
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = triple,
        allow_hyphen_values = true,
        help_heading = "Working volume"
    )]
    reference_mm: Option<[f64; 3]>,
    /// Working volume, mm; an empty entry: the declared travel, or the table's range.
    #[arg(
        long,
        value_name = "X0:X1,Y0:Y1,Z0:Z1",
        value_parser = volume,
        allow_hyphen_values = true,
        help_heading = "Working volume"
    )]
    volume: Option<Volume>,
    /// Angles of the rotary axes, degrees [default: zero].
    #[arg(
        long,
        value_name = "A=..,C=..",
        value_parser = pose,
        allow_hyphen_values = true,
        help_heading = "Working volume"
    )]
    pose: Option<Pose>,
    /// Nodes along X, Y, Z of the grid to try beside the tables; 0 or 1: not over that axis.
    #[arg(long, value_name = "NX,NY,NZ", value_parser = nodes, default_value = "5,5,5")]
    grid: [usize; 3],
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &CollapseArgs) -> Result<()> {
    let options = CollapseOptions {
        tool_mm: arguments.tool_mm,
        reference_mm: arguments.reference_mm,
        volume_mm: arguments.volume.unwrap_or_default(),
        pose_deg: arguments.pose.clone().unwrap_or_default(),
        grid: Some(arguments.grid),
    };
    let machine = model::machine(&arguments.machine)?;
    let collapsed = collapse(&machine, &options).map_err(|error| match error {
        CollapseError::Option { .. } => anyhow!("--{error}"),
        error => anyhow!("{}: {error}", arguments.machine.display()),
    })?;
    let mut written = collapsed.machine.clone();
    let limits = raise(&mut written);
    let files = machine_files(&written, &comment(&collapsed, &options));
    write(&arguments.machine, &arguments.output, &files)?;
    limits.iter().for_each(report_line);
    if arguments.json { json(&document(&collapsed)) } else { print(&report(&collapsed)) }
}

/// Low and high end of X, Y and Z, if given.
pub(crate) type Volume = [Option<[f64; 2]>; 3];
/// Rotary axes and their angles.
pub(crate) type Pose = Vec<(Axis, f64)>;

pub(crate) fn volume(text: &str) -> Result<Volume, String> {
    let range = |part: &str| -> Result<Option<[f64; 2]>, String> {
        if part.trim().is_empty() {
            return Ok(None);
        }
        let (low, high) =
            part.split_once(':').ok_or_else(|| format!("found \"{part}\", needed a range LOW:HIGH in mm"))?;
        Ok(Some([number(low)?, number(high)?]))
    };
    let parts: Vec<_> = text.split(',').map(range).collect::<Result<_, _>>()?;
    parts.try_into().map_err(|_| format!("found \"{text}\", needed three ranges X0:X1,Y0:Y1,Z0:Z1"))
}

fn nodes(text: &str) -> Result<[usize; 3], String> {
    let counts: Option<Vec<usize>> =
        text.split(',').map(|part| part.trim().parse().ok().filter(|count| *count <= 50)).collect();
    let needed = || format!("found \"{text}\", needed three numbers of nodes from 0 to 50, like 9,7,0");
    counts.and_then(|counts| counts.try_into().ok()).ok_or_else(needed)
}

pub(crate) fn pose(text: &str) -> Result<Pose, String> {
    let one = |part: &str| {
        let entry = part.split_once('=').and_then(|(letter, angle)| {
            let mut letters = letter.trim().chars();
            let axis = Axis::from_letter(letters.next()?.to_ascii_uppercase())?;
            letters.next().is_none().then_some((axis, angle))
        });
        let (axis, angle) =
            entry.ok_or_else(|| format!("found \"{part}\", needed a rotary axis and its angle like A=30"))?;
        Ok((axis, number(angle)?))
    };
    text.split(',').map(one).collect()
}

/// First line of a machine.toml written by this command, which may overwrite it.
const MARK: &str = "# Collapsed:";

/// Writes the tables first, so that a machine.toml never exists without all of them.
fn write(input: &Path, output: &Path, files: &[(String, String)]) -> Result<()> {
    let source = if input.is_dir() { input.to_path_buf() } else { input.parent().unwrap_or(Path::new("")).into() };
    let source = if source.as_os_str().is_empty() { PathBuf::from(".") } else { source };
    if let (Ok(source), Ok(target)) = (source.canonicalize(), output.canonicalize())
        && source == target
    {
        bail!("--output: found {}, needed another folder than the machine's own", output.display());
    }
    let _alone = machine_folder::alone(output)?;
    let old = output.join("machine.toml");
    if old.exists() && !std::fs::read_to_string(&old).is_ok_and(|text| text.starts_with(MARK)) {
        bail!("--output: found {}, which is not from this command, needed another folder", old.display());
    }
    let mut outputs = Outputs::of(model::files(input));
    for (name, text) in files {
        outputs.put(&output.join(name), text.as_bytes())?;
    }
    outputs.commit()?;
    for (name, _) in files {
        report_line(format_args!("written {}", output.join(name).display()));
    }
    Ok(())
}

/// The machine's linear axes with the ends of the volume.
fn ranges(collapsed: &Collapsed) -> impl Iterator<Item = (char, [f64; 2])> {
    let ends = collapsed.volume_mm.into_iter().zip(['X', 'Y', 'Z']);
    ends.filter(|([low, high], _)| low < high).map(|(ends, letter)| (letter, ends))
}

fn volume_text(collapsed: &Collapsed) -> String {
    let parts: Vec<String> = ranges(collapsed).map(|(axis, [low, high])| format!("{axis} {low} … {high}")).collect();
    parts.join(", ")
}

fn comment(collapsed: &Collapsed, options: &CollapseOptions) -> String {
    let [x, y, z] = collapsed.machine.settings.tool_mm;
    let pose: Vec<String> = options.pose_deg.iter().map(|(axis, deg)| format!("{} {deg}", axis.letter())).collect();
    let pose = if pose.is_empty() { String::new() } else { format!(", rotary axes at {} degrees", pose.join(", ")) };
    format!(
        "{} the best nine tables over {} mm, tool {x}, {y}, {z} mm{pose}.\n{}",
        MARK.trim_start_matches("# "),
        volume_text(collapsed),
        verdict(collapsed)
    )
}

fn verdict(collapsed: &Collapsed) -> String {
    let um = |mm: f64| format!("{:.1}", mm * 1e3);
    let (before, after) = (&collapsed.before, &collapsed.after);
    let mut text = format!(
        "nine tables leave {} um at most, {} um RMS, of {} um",
        um(after.max_mm),
        um(after.rms_mm),
        um(before.max_mm)
    );
    let total = collapsed.causes.iter().map(|cause| cause.rms_mm.powi(2)).sum::<f64>().sqrt();
    if let Some(cause) = collapsed.causes.first().filter(|cause| cause.rms_mm > 1e-9) {
        let share = 100.0 * (cause.rms_mm / total).powi(2);
        let _ = write!(
            text,
            "; angular errors of {} cause most of the rest ({} um RMS alone, {share:.0} %)",
            cause.axis.letter(),
            um(cause.rms_mm)
        );
    }
    text
}

/// The effect of adding a grid to the tables.
fn advice(collapsed: &Collapsed) -> Option<String> {
    let GridAdvice { nodes, bytes, left, needed } = collapsed.grid?;
    let over: Vec<String> =
        ["X", "Y", "Z"].iter().zip(nodes).filter(|(_, n)| *n > 0).map(|(axis, n)| format!("{axis} {n}")).collect();
    let verdict = if needed { "a grid is needed" } else { "no grid is needed" };
    Some(format!(
        "{verdict}: one of {} nodes ({bytes} bytes) beside the tables would leave {:.1} um at most, {:.1} um RMS",
        over.join(", "),
        left.max_mm * 1e3,
        left.rms_mm * 1e3
    ))
}

fn report(collapsed: &Collapsed) -> String {
    let [x, y, z] = collapsed.reference_mm;
    let row = |(name, of): (&str, &Deviation)| {
        let um = [of.max_mm, of.rms_mm].into_iter().chain(of.rms_along_mm).map(|mm| Cell::fixed(mm * 1e3, 2));
        let [x, y, z] = of.at_mm;
        std::iter::once(name.into()).chain(um).chain([format!("{x:.1}, {y:.1}, {z:.1}").into()]).collect()
    };
    let rows = [
        ("error of the tip", &collapsed.before),
        ("left, tables as they are", &collapsed.original),
        ("left, collapsed tables", &collapsed.after),
    ];
    let header = ["µm", "max", "RMS", "RMS along X", "along Y", "along Z", "worst at, mm"];
    let table = Table::new(format!("{} points", collapsed.evaluated), header, rows.map(row));
    let lines = std::iter::once(verdict(collapsed)).chain(advice(collapsed)).map(|line| line + "\n");
    format!(
        "working volume {} mm\ncross terms zero at {x}, {y}, {z} mm\n\n{table}\n{}",
        volume_text(collapsed),
        lines.collect::<String>()
    )
}

fn document(collapsed: &Collapsed) -> Value {
    let deviation = |of: &Deviation| {
        json!({
            "max_um": of.max_mm * 1e3,
            "rms_um": of.rms_mm * 1e3,
            "max_along_um": of.max_along_mm.map(|mm| mm * 1e3),
            "rms_along_um": of.rms_along_mm.map(|mm| mm * 1e3),
            "at_mm": of.at_mm,
        })
    };
    let volume: serde_json::Map<String, Value> =
        ranges(collapsed).map(|(axis, ends)| (axis.to_string(), json!(ends))).collect();
    let causes: Vec<Value> = collapsed
        .causes
        .iter()
        .map(|cause| json!({ "axis": cause.axis.letter().to_string(), "rms_um": cause.rms_mm * 1e3 }))
        .collect();
    json!({
        "volume_mm": volume,
        "reference_mm": collapsed.reference_mm,
        "tool_mm": collapsed.machine.settings.tool_mm,
        "points": collapsed.evaluated,
        "before": deviation(&collapsed.before),
        "original_tables": deviation(&collapsed.original),
        "collapsed_tables": deviation(&collapsed.after),
        "angular_errors_alone": causes,
        "grid": collapsed.grid.map(|grid| json!({
            "nodes": grid.nodes,
            "bytes": grid.bytes,
            "left": deviation(&grid.left),
            "needed": grid.needed,
        })),
        "verdict": verdict(collapsed),
    })
}
