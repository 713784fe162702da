//! `trueaxis tables …`.

mod collapse;

use crate::accuracy;
use crate::model::{self, parsed};
use crate::output::{json, print, tell};
use anyhow::{Context, Result, anyhow, bail};
use clap::Subcommand;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::formats::linuxcnc::CompFileType;
use trueaxis_tables::formats::{self, ExportOptions, Format, Imported, Loss};
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::counted;
use trueaxis_tables::{LostMotion, Machine, build, check, compile, lost_motion, summary};

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Read a machine and its tables, and say what is wrong or doubtful.
    Check {
        /// machine.toml or its folder.
        #[arg(value_name = "M")]
        machine: PathBuf,
        /// Servo rate for which slope and acceleration are judged.
        #[arg(long, value_name = "HZ", default_value_t = 10_000.0)]
        rate_hz: f64,
        /// Print one JSON document.
        #[arg(long)]
        json: bool,
    },
    /// Compile a machine into the file that a controller loads.
    #[command(after_help = "Example: trueaxis tables compile compensation-tables/mill-3axis -o mill.tcomp")]
    Compile {
        /// machine.toml or its folder.
        #[arg(value_name = "M")]
        machine: PathBuf,
        /// Servo rate of the controller, for which slope and acceleration are judged.
        #[arg(long, value_name = "HZ", default_value_t = 10_000.0)]
        rate_hz: f64,
        /// The compiled file.
        #[arg(short, long, value_name = "T.tcomp")]
        output: PathBuf,
    },
    /// Show what is in a compiled file.
    Show {
        /// The compiled file.
        #[arg(value_name = "T.tcomp")]
        file: PathBuf,
        /// Print one JSON document.
        #[arg(long)]
        json: bool,
    },
    /// The best nine tables of a machine with angular errors, and what they leave.
    #[command(after_help = collapse::HELP)]
    Collapse(collapse::Arguments),
    /// Read another control's compensation file into machine.toml and axis tables.
    #[command(after_help = FORMATS)]
    Import {
        /// Its format.
        #[arg(long, value_name = "FORMAT")]
        from: String,
        /// The file.
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Axis that the file is for, where it does not say so itself.
        #[arg(long, value_name = "AXIS")]
        axis: Option<String>,
        /// COMP_FILE_TYPE of a LinuxCNC file.
        #[arg(long, value_name = "0|1", value_parser = clap::value_parser!(u8).range(0..=1))]
        comp_file_type: Option<u8>,
        /// Folder of the machine; where one stands, its tables of these axes are added or replaced and the rest stays.
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
        /// Make a new machine; a folder that exists is refused.
        #[arg(long)]
        new: bool,
    },
    /// Write a machine's tables in another control's format.
    #[command(after_help = FORMATS)]
    Export {
        /// The format.
        #[arg(long, value_name = "FORMAT")]
        to: String,
        /// machine.toml or its folder.
        #[arg(value_name = "M")]
        machine: PathBuf,
        /// Only this axis.
        #[arg(long, value_name = "AXIS")]
        axis: Option<String>,
        /// COMP_FILE_TYPE of a LinuxCNC file.
        #[arg(long, value_name = "0|1", value_parser = clap::value_parser!(u8).range(0..=1))]
        comp_file_type: Option<u8>,
        /// Leave out what the format cannot hold, and say so, instead of refusing.
        #[arg(long)]
        drop: bool,
        /// Resample onto points this far apart, mm or degrees (Siemens, for free grids).
        #[arg(long, value_name = "STEP")]
        step: Option<f64>,
        /// The file (where the format needs one per axis: the axis letter is put before its ending).
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
    },
    /// Evaluate a measured axis after ISO 230-2: A, E, R, M, B.
    #[command(after_help = "MEASURED.csv: X_mm,run,direction,deviation_um; one row per approach, direction + or −.\n\
        Or a row per target and a column per run: X_mm,+1,-1,+2,-2,… or X_mm,fwd_1_um,rev_1_um,… (µm; of a rotary axis µrad).\n\n\
        Example: trueaxis tables accuracy compensation-tables/mill-3axis/x-iso230-2.csv --machine compensation-tables/mill-3axis")]
    Accuracy {
        /// Measured deviations.
        #[arg(value_name = "MEASURED.csv")]
        measured: PathBuf,
        /// Also evaluate what this machine's tables would leave.
        #[arg(long, value_name = "M")]
        machine: Option<PathBuf>,
        /// Axis measured, where the file does not say so.
        #[arg(long, value_name = "AXIS")]
        axis: Option<String>,
        /// Print one JSON document.
        #[arg(long)]
        json: bool,
    },
}

const FORMATS: &str = "\
Formats, and what they hold for an error E = actual − ideal:
  linuxcnc    COMP_FILE, type 0 (nominal + E, both directions; mm, degrees) or type 1 (−E). Import tells them apart by the
              numbers and refuses a file that could be either; export writes type 0. --comp-file-type says which
  siemens     $AA_ENC_COMP, +E in one direction (mm, degrees); a file with AX1 needs --axis
  isg         ISG/Beckhoff volumetric CSV, all six errors (mm, rad; rotary arguments in degrees); chain and offsets as comments
  iso230-2    measured deviations (µm, µrad), one row per approach, or one per target with a column per run:
              X_mm,+1,-1,+2,-2,… or X_mm,fwd_1_um,rev_1_um,…";

pub(crate) fn run(command: Command) -> Result<()> {
    match command {
        Command::Check { machine, rate_hz, json } => run_check(&machine, rate_hz, json),
        Command::Compile { machine, rate_hz, output } => run_compile(&machine, rate_hz, &output),
        Command::Show { file, json } => run_show(&file, json),
        Command::Collapse(arguments) => collapse::run(&arguments),
        Command::Import { from, file, axis, comp_file_type, output, new } => {
            let recognise = from == "linuxcnc" && comp_file_type.is_none();
            let format = format_of("--from", &from, comp_file_type)?;
            run_import(format, recognise, &file, axis_of(axis.as_deref())?, &output, new)
        }
        Command::Export { to, machine, axis, comp_file_type, drop, step, output } => {
            let options = ExportOptions {
                loss: if drop { Loss::Drop } else { Loss::Refuse },
                axis: axis_of(axis.as_deref())?,
                step,
                source: machine.clone(),
            };
            run_export(format_of("--to", &to, comp_file_type)?, &machine, &options, &output)
        }
        Command::Accuracy { measured, machine, axis, json } => {
            accuracy::run(&measured, axis_of(axis.as_deref())?, machine.as_deref(), json)
        }
    }
}

fn axis_of(letter: Option<&str>) -> Result<Option<Axis>> {
    let Some(letter) = letter else { return Ok(None) };
    let mut letters = letter.chars();
    match (letters.next().and_then(|c| Axis::from_letter(c.to_ascii_uppercase())), letters.next()) {
        (Some(axis), None) => Ok(Some(axis)),
        _ => bail!("--axis: found \"{letter}\", needed one of X Y Z A B C"),
    }
}

fn format_of(option: &str, name: &str, comp_file_type: Option<u8>) -> Result<Format> {
    let format = match (name, comp_file_type) {
        ("linuxcnc", None | Some(0)) => Format::LinuxCnc(CompFileType::Positions),
        ("linuxcnc", Some(_)) => Format::LinuxCnc(CompFileType::Trims),
        _ => Format::from_name(name).ok_or_else(|| {
            anyhow!("{option}: found \"{name}\", needed linuxcnc, linuxcnc-0, linuxcnc-1, siemens, isg or iso230-2")
        })?,
    };
    Ok(format)
}

fn run_check(path: &Path, rate_hz: f64, as_json: bool) -> Result<()> {
    let (machine, bytes) = compiled(path, rate_hz)?;
    let tables = parsed(&bytes, path)?;
    let warnings = check(&machine, rate_hz);
    let lost = lost_motion(&machine);
    if as_json {
        let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        let lost: Vec<Value> = lost.iter().map(lost_motion_json).collect();
        return json(&json!({ "ok": true, "warnings": warnings, "lost_motion": lost, "summary": summary(&tables) }));
    }
    print(&format!("{}\n", summary(&tables)))?;
    for lost in &lost {
        print(&format!("{lost}\n"))?;
    }
    for warning in &warnings {
        tell(format_args!("warning: {warning}"));
    }
    print(&format!("{}: no errors, {}\n", path.display(), counted(warnings.len(), "warning")))
}

/// In the units of the files: µm and mm, of a rotary axis µrad and degrees.
fn lost_motion_json(lost: &LostMotion) -> Value {
    let ms = lost.lead_in_s * 1e3;
    if lost.axis.is_rotary() {
        json!({
            "axis": lost.axis.letter(), "play_urad": lost.play.to_radians() * 1e6, "lead_in_ms": ms,
            "feed_deg_per_s": lost.feed_per_s, "way_deg": lost.way
        })
    } else {
        json!({
            "axis": lost.axis.letter(), "play_um": lost.play * 1e3, "lead_in_ms": ms,
            "feed_mm_per_s": lost.feed_per_s, "way_mm": lost.way
        })
    }
}

/// A machine with its compiled form, accepted by what a controller runs at this rate.
fn compiled(path: &Path, rate_hz: f64) -> Result<(Machine, Vec<u8>)> {
    if !(10.0..=1e6).contains(&rate_hz) {
        bail!("--rate-hz: found {rate_hz}, needed 10 to 1000000");
    }
    let machine = model::source(path)?;
    let bytes = compile(&machine).map_err(|error| anyhow!("{}: {error}", path.display()))?;
    build(&machine, rate_hz).map_err(|error| anyhow!("{}: at {rate_hz} Hz: {error}", path.display()))?;
    Ok((machine, bytes))
}

fn run_compile(path: &Path, rate_hz: f64, output: &Path) -> Result<()> {
    let (machine, bytes) = compiled(path, rate_hz)?;
    for warning in check(&machine, rate_hz) {
        tell(format_args!("warning: {warning}"));
    }
    let tables = parsed(&bytes, output)?;
    let mut outputs = Outputs::of(model::files(path));
    outputs.put(output, &bytes)?;
    outputs.commit()?;
    tell(format_args!(
        "{}: {} bytes, machine {} (id {:08x}), CRC {:08x}",
        output.display(),
        bytes.len(),
        machine.settings.name,
        tables.machine_id(),
        tables.crc()
    ));
    Ok(())
}

fn run_show(file: &Path, as_json: bool) -> Result<()> {
    let bytes = std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
    let tables: Tcomp<'_> = parsed(&bytes, file)?;
    if as_json { json(&summary(&tables)) } else { print(&format!("{}\n", summary(&tables))) }
}

fn run_import(
    format: Format,
    recognise: bool,
    file: &Path,
    axis: Option<Axis>,
    output: &Path,
    new: bool,
) -> Result<()> {
    if new && output.symlink_metadata().is_ok() {
        bail!("--new: found {}, needed a folder that does not exist yet", output.display());
    }
    let text = model::text(file)?;
    let format = if recognise { Format::LinuxCnc(formats::linuxcnc::recognise(&text, file)?) } else { format };
    let imported = formats::import(format, &text, file, axis)?;
    for note in &imported.notes {
        tell(format_args!("note: {}: {note}", file.display()));
    }
    let (files, notes) = if output.join("machine.toml").exists() {
        let edited = imported.edit(output)?;
        (edited.files, edited.notes)
    } else {
        (new_machine(&imported, file, output)?, Vec::new())
    };
    let mut outputs = Outputs::of([file]);
    outputs.folder(output)?;
    for (path, text) in &files {
        outputs.put(path, text.as_bytes())?;
    }
    outputs.commit()?;
    for note in &notes {
        tell(note);
    }
    for (path, _) in &files {
        tell(format_args!("written {}", path.display()));
    }
    tell(format_args!("{}: {}", format.name(), meaning(format)));
    Ok(())
}

/// A machine with the imported axes alone; existing files are never overwritten.
fn new_machine(imported: &Imported, file: &Path, output: &Path) -> Result<Vec<(PathBuf, String)>> {
    let name = file.file_stem().map_or_else(|| "imported".into(), |stem| stem.to_string_lossy().into_owned());
    let mut files: Vec<(PathBuf, String)> =
        imported.machine_files(&name).into_iter().map(|(name, text)| (output.join(name), text)).collect();
    // A machine.toml is only there with all of its tables.
    files.rotate_left(1);
    if let Some((path, _)) = files.iter().find(|(path, _)| path.symlink_metadata().is_ok()) {
        bail!("{}: found a file and no machine.toml beside it, needed another folder", path.display());
    }
    Machine::read_with(&output.join("machine.toml"), &files, |_| {})
        .map_err(|error| anyhow!("{}: as a machine: {error} (nothing is written)", file.display()))?;
    Ok(files)
}

fn run_export(format: Format, path: &Path, options: &ExportOptions, output: &Path) -> Result<()> {
    let machine = model::source(path)?;
    let exported = formats::export(format, &machine, options)?;
    let alone = exported.files.len() == 1;
    let mut outputs = Outputs::of(model::files(path));
    let mut written = Vec::new();
    for (name, text) in &exported.files {
        let file = if alone { output.to_path_buf() } else { beside(output, name) };
        outputs.put(&file, text.as_bytes())?;
        written.push(file);
    }
    outputs.commit()?;
    for file in written {
        tell(format_args!("written {}", file.display()));
    }
    for dropped in &exported.dropped {
        tell(format_args!("left out: {dropped}"));
    }
    for note in &exported.notes {
        tell(format_args!("note: {note}"));
    }
    tell(format_args!("{}: {}", format.name(), meaning(format)));
    Ok(())
}

/// The file of one axis: `OUT.comp` and `x.comp` make `OUT-x.comp`.
fn beside(output: &Path, name: &str) -> PathBuf {
    let stem = output.file_stem().map_or(String::new(), |s| s.to_string_lossy().into_owned());
    let part = Path::new(name).file_stem().map_or(String::new(), |s| s.to_string_lossy().into_owned());
    let ending = output.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
    output.with_file_name(format!("{stem}-{part}{ending}"))
}

/// Sign and unit of a conversion.
fn meaning(format: Format) -> &'static str {
    match format {
        Format::LinuxCnc(CompFileType::Positions) => {
            "nominal, forward and reverse positions = nominal + E, mm or degrees"
        }
        Format::LinuxCnc(CompFileType::Trims) => "nominal, forward and reverse trims = −E, mm or degrees",
        Format::Siemens => "values = +E, mm or degrees, one direction",
        Format::Isg => "values = +E, mm and rad, rotary arguments in degrees",
        Format::Iso230_2 => "deviations = +E, µm or µrad",
    }
}
