//! `trueaxis tables …`.

mod collapse;

use crate::accuracy;
use crate::model::{self, parsed};
use crate::output::{json, put, put_bytes, tell};
use anyhow::{Context, Result, anyhow, bail};
use clap::Subcommand;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::formats::linuxcnc::CompFileType;
use trueaxis_tables::formats::{self, ExportOptions, Format, Loss};
use trueaxis_tables::text::counted;
use trueaxis_tables::{LostMotion, check, compile, lost_motion, summary};

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
        /// Folder that the machine is written into.
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
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
        Command::Compile { machine, output } => run_compile(&machine, &output),
        Command::Show { file, json } => run_show(&file, json),
        Command::Collapse(arguments) => collapse::run(&arguments),
        Command::Import { from, file, axis, comp_file_type, output } => {
            let recognise = from == "linuxcnc" && comp_file_type.is_none();
            let format = format_of("--from", &from, comp_file_type)?;
            run_import(format, recognise, &file, axis_of(axis.as_deref())?, &output)
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
    if !(rate_hz.is_finite() && rate_hz > 0.0) {
        bail!("--rate-hz: found {rate_hz}, needed a positive number");
    }
    let machine = model::source(path)?;
    let bytes = compile(&machine).map_err(|error| anyhow!("{}: {error}", path.display()))?;
    let tables = parsed(&bytes, path)?;
    let warnings = check(&machine, rate_hz);
    let lost = lost_motion(&machine);
    if as_json {
        let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        let lost: Vec<Value> = lost.iter().map(lost_motion_json).collect();
        return json(&json!({ "ok": true, "warnings": warnings, "lost_motion": lost, "summary": summary(&tables) }));
    }
    put(&format!("{}\n", summary(&tables)), None)?;
    for lost in &lost {
        put(&format!("{lost}\n"), None)?;
    }
    for warning in &warnings {
        tell(format_args!("warning: {warning}"));
    }
    put(&format!("{}: no errors, {}\n", path.display(), counted(warnings.len(), "warning")), None)
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

fn run_compile(path: &Path, output: &Path) -> Result<()> {
    let machine = model::source(path)?;
    let bytes = compile(&machine).map_err(|error| anyhow!("{}: {error}", path.display()))?;
    for warning in check(&machine, 10_000.0) {
        tell(format_args!("warning: {warning}"));
    }
    put_bytes(&bytes, output)?;
    let tables = parsed(&bytes, output)?;
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
    if as_json { json(&summary(&tables)) } else { put(&format!("{}\n", summary(&tables)), None) }
}

fn run_import(format: Format, recognise: bool, file: &Path, axis: Option<Axis>, output: &Path) -> Result<()> {
    let text = model::text(file)?;
    let format = if recognise { Format::LinuxCnc(formats::linuxcnc::recognise(&text, file)?) } else { format };
    let imported = formats::import(format, &text, file, axis)?;
    for note in &imported.notes {
        tell(format_args!("note: {}: {note}", file.display()));
    }
    let name = file.file_stem().map_or_else(|| "imported".into(), |stem| stem.to_string_lossy().into_owned());
    std::fs::create_dir_all(output).with_context(|| format!("cannot create {}", output.display()))?;
    for (name, text) in imported.machine_files(&name) {
        let path = output.join(name);
        put_bytes(text.as_bytes(), &path)?;
        tell(format_args!("written {}", path.display()));
    }
    tell(format_args!("{}: {}", format.name(), meaning(format)));
    Ok(())
}

fn run_export(format: Format, path: &Path, options: &ExportOptions, output: &Path) -> Result<()> {
    let machine = model::source(path)?;
    let exported = formats::export(format, &machine, options)?;
    let alone = exported.files.len() == 1;
    for (name, text) in &exported.files {
        let file = if alone { output.to_path_buf() } else { beside(output, name) };
        put_bytes(text.as_bytes(), &file)?;
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
