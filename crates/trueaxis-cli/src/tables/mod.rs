//! `trueaxis tables …`.

mod accuracy;
pub(crate) mod collapse;
mod compile;
mod convert;

use crate::model;
use crate::output::report_line;
use anyhow::{Result, bail};
use clap::Subcommand;
use std::path::PathBuf;
use trueaxis::Axis;
use trueaxis_evaluation::transfer;
use trueaxis_tables::formats::{ExportOptions, Loss};

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis tables check compensation-tables/mill-3axis";

const COMPILE: &str = "\
Example:
  trueaxis tables compile compensation-tables/mill-3axis -o mill.tcomp";

const SHOW: &str = "\
Example:
  trueaxis tables show crates/trueaxis/mill-3axis.tcomp";

const IMPORT: &str = "\
Example:
  trueaxis tables import --from iso230-2 --axis X \\
      compensation-tables/mill-3axis/x-iso230-2.csv -o mymill";

const EXPORT: &str = "\
Example:
  trueaxis tables export --to isg compensation-tables/head-5axis -o head.csv";

const ACCURACY: &str = "\
Example:
  trueaxis tables accuracy compensation-tables/mill-3axis/x-iso230-2.csv";

const MEASURED: &str = "\
MEASURED.csv has the columns X_mm,run,direction,deviation_um: one row for each approach, direction + or −. Or it has \
a row for each target and a column for each run: X_mm,+1,-1,+2,-2,… or X_mm,fwd_1_um,rev_1_um,… (µm; µrad for a \
rotary axis).

--instrument M gives the figures bands, from the keys of [uncertainty] in M (ISO/TR 230-9):
  device_um_per_m, device_um, misalignment_mm, temperature_k, eve_um
  expansion_um_per_m_k, temperature_difference_k";

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Check a machine and its tables: refuse errors, warn of doubtful settings.
    #[command(before_help = EXAMPLE)]
    Check {
        /// machine.toml or its folder.
        #[arg(value_name = "M")]
        machine: PathBuf,
        /// Servo rate for which slope and acceleration are checked.
        #[arg(long, value_name = "HZ", default_value_t = 10_000.0)]
        rate_hz: f64,
        /// Print one JSON document.
        #[arg(long)]
        json: bool,
    },
    /// Compile a machine into the file that a controller loads.
    #[command(before_help = COMPILE)]
    Compile {
        /// machine.toml or its folder.
        #[arg(value_name = "M")]
        machine: PathBuf,
        /// Servo rate of the controller, for which slope and acceleration are checked.
        #[arg(long, value_name = "HZ", default_value_t = 10_000.0)]
        rate_hz: f64,
        /// The compiled file.
        #[arg(short, long, value_name = "T.tcomp")]
        output: PathBuf,
    },
    /// Show the content of a compiled file.
    #[command(before_help = SHOW)]
    Show {
        /// The compiled file.
        #[arg(value_name = "T.tcomp")]
        file: PathBuf,
        /// Print one JSON document.
        #[arg(long)]
        json: bool,
    },
    /// Find the best nine tables of a machine with angular errors, and the error that they leave.
    #[command(before_help = collapse::EXAMPLE, after_help = collapse::HELP)]
    Collapse(collapse::CollapseArgs),
    /// Read another control's compensation file into machine.toml and axis tables.
    #[command(before_help = IMPORT, after_help = convert::FORMATS)]
    Import {
        /// Format of the file.
        #[arg(long, value_name = "FORMAT")]
        from: String,
        /// The file.
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Axis of the file, if the file does not name it.
        #[arg(long, value_name = "AXIS")]
        axis: Option<String>,
        /// COMP_FILE_TYPE of a LinuxCNC file.
        #[arg(long, value_name = "0|1", value_parser = clap::value_parser!(u8).range(0..=1))]
        comp_file_type: Option<u8>,
        /// Unit of lengths in the file, mm or inch, with columns also um: needed with linuxcnc and siemens, whose files do not
        /// state it, and with columns that do not.
        #[arg(long, value_name = "UNIT")]
        unit: Option<String>,
        /// Columns of a file with other names, with --from columns: position=Pos,forward=Fwd,reverse=Rev.
        #[arg(long, value_name = "NAMES")]
        columns: Option<String>,
        /// Lowest X and Y and highest X and Y of the mesh's points, mm, with --from marlin and a log that does not have them.
        #[arg(long, value_name = "X,Y,X,Y", allow_hyphen_values = true)]
        area: Option<String>,
        /// Name of the mesh in a file of several, with bed-mesh; the one called default unless given.
        #[arg(long, value_name = "NAME")]
        mesh: Option<String>,
        /// Folder of the machine. An existing machine gets these axes' tables, added or replaced, and keeps the rest. A bed mesh
        /// replaces an earlier one. Limits that the corrections need above the defaults are set.
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
        /// Make a new machine; refuse an existing folder.
        #[arg(long)]
        new: bool,
    },
    /// Write a machine's tables in another control's format.
    #[command(before_help = EXPORT, after_help = convert::FORMATS)]
    Export {
        /// The format.
        #[arg(long, value_name = "FORMAT")]
        to: String,
        /// machine.toml or its folder.
        #[arg(value_name = "M")]
        machine: PathBuf,
        /// Write only this axis.
        #[arg(long, value_name = "AXIS")]
        axis: Option<String>,
        /// COMP_FILE_TYPE of a LinuxCNC file.
        #[arg(long, value_name = "0|1", value_parser = clap::value_parser!(u8).range(0..=1))]
        comp_file_type: Option<u8>,
        /// Omit and list settings that the format cannot store, instead of refusing.
        #[arg(long)]
        drop: bool,
        /// Resample onto points this far apart, mm or degrees (Siemens, for free grids).
        #[arg(long, value_name = "STEP")]
        step: Option<f64>,
        /// File to write (if the format needs one per axis, the axis letter goes before the extension).
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
    },
    /// Evaluate a measured axis after ISO 230-2: A, E, R, M, B.
    #[command(before_help = ACCURACY, after_help = MEASURED)]
    Accuracy {
        /// Measured deviations.
        #[arg(value_name = "MEASURED.csv")]
        measured: PathBuf,
        /// Also evaluate the deviations that this machine's tables would leave.
        #[arg(long, value_name = "M")]
        machine: Option<PathBuf>,
        /// Measured axis, if the file does not name it.
        #[arg(long, value_name = "AXIS")]
        axis: Option<String>,
        /// Machine whose section uncertainty states the instrument and the set-up; every figure gets its band.
        #[arg(long, value_name = "M")]
        instrument: Option<PathBuf>,
        /// Largest permitted accuracy A: pass and fail only outside its band (ISO 14253-1).
        #[arg(long, value_name = "UM", requires = "instrument", allow_negative_numbers = true)]
        tolerance_um: Option<f64>,
        /// Coverage of the bands, percent.
        #[arg(long, value_name = "PERCENT", default_value_t = 95.0)]
        confidence: f64,
        /// Print one JSON document.
        #[arg(long)]
        json: bool,
    },
}

pub(crate) fn run(command: Command) -> Result<()> {
    match command {
        Command::Check { machine, rate_hz, json } => compile::check(&machine, rate_hz, json),
        Command::Compile { machine, rate_hz, output } => compile::compile(&machine, rate_hz, &output),
        Command::Show { file, json } => compile::show(&file, json),
        Command::Collapse(arguments) => collapse::run(&arguments),
        Command::Import { from, file, axis, comp_file_type, unit, columns, area, mesh, output, new } => {
            let format = transfer::format_to_read(&from, comp_file_type)?;
            let options = transfer::ImportOptions {
                format,
                recognise: from == "linuxcnc" && comp_file_type.is_none(),
                axis: axis_of(axis.as_deref())?,
                unit: unit.as_deref().map(|unit| transfer::unit(unit, format)).transpose()?,
                columns: columns.as_deref(),
                area: area.as_deref().map(transfer::area).transpose()?,
                mesh: mesh.as_deref(),
                new,
            };
            transfer::import(&options, &file, &output, &mut report_line).map(|_| ())
        }
        Command::Export { to, machine, axis, comp_file_type, drop, step, output } => {
            let options = ExportOptions {
                loss: if drop { Loss::Drop } else { Loss::Refuse },
                axis: axis_of(axis.as_deref())?,
                step,
                source: machine.clone(),
            };
            let format = transfer::format_to_write(&to, comp_file_type)?;
            let inputs = model::files(&machine);
            transfer::export(format, &model::source(&machine)?, inputs, &options, &output, &mut report_line).map(|_| ())
        }
        Command::Accuracy { measured, machine, axis, instrument, tolerance_um, confidence, json } => {
            let bands = instrument.as_deref().map(|machine| accuracy::Bands { machine, tolerance_um, confidence });
            accuracy::run(&measured, axis_of(axis.as_deref())?, machine.as_deref(), bands, json)
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
