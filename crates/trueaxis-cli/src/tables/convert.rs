//! `trueaxis tables import` and `export`.

use crate::output::report_line;
use crate::{machine_folder, model};
use anyhow::{Result, anyhow, bail};
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis_tables::files::{Folder, Memory};
use trueaxis_tables::formats::columns::{Mapping, Unit};
use trueaxis_tables::formats::linuxcnc::CompFileType;
use trueaxis_tables::formats::marlin::Area;
use trueaxis_tables::formats::{self, ExportOptions, Format, Imported};
use trueaxis_tables::output::Outputs;
use trueaxis_tables::{Edited, Machine, Table};

pub(super) const FORMATS: &str = "\
How each format stores an error E = actual − ideal:

  linuxcnc: COMP_FILE of type 0 (nominal + E, both directions) or type 1 (−E), mm and degrees. Import distinguishes \
  the types by the numbers and refuses a file that could be either; export writes type 0; --comp-file-type sets it. \
  Import needs --unit mm or inch, as the machine's LINEAR_UNITS.

  siemens: $AA_ENC_COMP, +E in one direction, mm and degrees. A file with AX1 needs --axis. Import needs --unit, and \
  also reads $AN_CEC: sag and angularity (Z over Y is EZY), one table for each direction of travel or for both.

  isg: volumetric CSV of ISG/Beckhoff, all six errors, mm and rad, rotary arguments in degrees; chain and offsets as \
  comments. Import takes a table over two or three linear axes as a grid.

  iso230-2: measured deviations, µm and µrad; one row for each approach, or one for each target with a column for \
  each run: X_mm,+1,-1,+2,-2,… or X_mm,fwd_1_um,rev_1_um,…

  columns: Position (mm),Forward,Reverse or Commanded,Reading, import only. Position, Commanded, Target, Nominal or the \
  axis; Forward and Reverse, or one of Reading, Measured, Actual. Other names: --columns position=NAME,forward=NAME and \
  ,reverse=NAME. Readings are positions or deviations, which the numbers tell. Unit in the name, as in Fwd (um): mm, um, \
  inch, deg, arcsec, urad; --unit mm, um or inch is that of readings that state none (with um, positions are in mm).

  rtl: linear measurement of Renishaw's laser software, µm, import only.

  bed-mesh: [bed_mesh NAME] of Klipper's printer.cfg, a grid over X and Y, import only. EZ = −height of the bed, \
  with the points that Klipper interpolates between the probed ones (mesh_x_pps, algo). fade_start, fade_end and \
  fade_target of [bed_mesh] (the mesh's mean unless given) become its fade. --mesh names one of several.

  heightmap: heightmap.csv of RepRapFirmware, a grid over X and Y, import only. EZ = −height. Points that were not \
  probed (0 without a decimal point) get the plane through the others, as there.

  marlin: a log with the mesh that M420 V or G29 T prints (UBL, bilinear), a grid over X and Y, import only. \
  EZ = −height. The positions are the printed corners or those of G29 V4 in the log, or --area X,Y,X,Y; Fade Height \
  becomes its fade.

  grid: X_mm,Y_mm[,Z_mm],EX_um,…,EC_urad, +E, a line for every node in any order, import only.";

/// A format by its name on the command line.
pub(super) fn format(option: &str, name: &str, comp_file_type: Option<u8>) -> Result<Format> {
    let format = match (name, comp_file_type) {
        ("linuxcnc", None | Some(0)) => Format::LinuxCnc(CompFileType::Positions),
        ("linuxcnc", Some(_)) => Format::LinuxCnc(CompFileType::Trims),
        _ => Format::from_name(name).ok_or_else(|| {
            anyhow!("{option}: found \"{name}\", needed linuxcnc, linuxcnc-0, linuxcnc-1, siemens, isg, iso230-2, columns, rtl, bed-mesh, heightmap, marlin or grid")
        })?,
    };
    Ok(format)
}

/// The unit with this name; µm is one of readings only.
pub(super) fn unit(name: &str, format: Format) -> Result<Unit> {
    let of_readings = format == Format::Columns;
    let unit = Unit::from_name(name).filter(|unit| of_readings || *unit != Unit::Micrometre);
    let needed = if of_readings { "mm, um or inch" } else { "mm or inch" };
    unit.ok_or_else(|| anyhow!("--unit: found \"{name}\", needed {needed}"))
}

/// The area `X,Y,X,Y`.
pub(super) fn area(text: &str) -> Result<Area> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    let area = numbers.and_then(|numbers| Area::try_from(numbers).ok());
    area.ok_or_else(|| anyhow!("--area: found \"{text}\", needed X,Y,X,Y: the lowest X and Y and the highest, mm"))
}

/// Converts the content of a file to mm. A format that does not state its unit is read in the given one.
fn in_millimetres(imported: Imported, format: Format, unit: Option<Unit>, file: &Path) -> Result<Imported> {
    if !matches!(format, Format::LinuxCnc(_) | Format::Siemens) {
        if unit.is_some() && format != Format::Columns {
            bail!("--unit: found it with {}, whose files state their units; needed none", format.name());
        }
        return Ok(imported);
    }
    let lengths = |(axis, table): &&(Axis, Table)| !axis.is_rotary() || table.given.iter().take(3).any(|given| *given);
    let linear = imported.tables.iter().find(lengths);
    match (unit, linear) {
        (None, Some((axis, _))) => bail!(
            "{}: found lengths of axis {} without a unit, needed --unit mm or --unit inch, that of the control",
            file.display(),
            axis.letter()
        ),
        (Some(Unit::Inch), _) => Ok(imported.read_as_inches()),
        _ => Ok(imported),
    }
}

/// Options for reading a file.
pub(super) struct ImportOptions<'o> {
    pub(super) format: Format,
    /// Determine the type of a LinuxCNC file from its numbers.
    pub(super) recognise: bool,
    pub(super) axis: Option<Axis>,
    pub(super) unit: Option<Unit>,
    /// Names of the columns to read.
    pub(super) columns: Option<&'o str>,
    /// Area of a mesh in the log of Marlin.
    pub(super) area: Option<Area>,
    /// Name of a mesh to read.
    pub(super) mesh: Option<&'o str>,
    /// Refuse a folder that already exists.
    pub(super) new: bool,
}

pub(super) fn import(options: &ImportOptions<'_>, file: &Path, output: &Path) -> Result<()> {
    let ImportOptions { format, recognise, axis, unit, columns, area, mesh, new } = *options;
    let not_new = || anyhow!("--new: found {}, needed a folder that does not exist yet", output.display());
    if new && output.symlink_metadata().is_ok() {
        return Err(not_new());
    }
    let text = model::text(file)?;
    let format = if recognise { Format::LinuxCnc(formats::linuxcnc::recognise(&text, file)?) } else { format };
    if columns.is_some() && format != Format::Columns {
        bail!("--columns: found it with {}, needed --from columns", format.name());
    }
    if area.is_some() && format != Format::Marlin {
        bail!("--area: found it with {}, needed --from marlin", format.name());
    }
    let imported = match (format, mesh) {
        (Format::BedMesh, name) => formats::bed_mesh::import(&text, file, name)?,
        (Format::Columns, None) => {
            let mapping = columns.map(Mapping::parse).transpose().map_err(|error| anyhow!("--columns: {error}"))?;
            formats::columns::import(&text, file, axis, &Mapping { unit, ..mapping.unwrap_or_default() })?
        }
        (Format::Marlin, None) => formats::marlin::import(&text, file, area)?,
        (_, None) => formats::import(format, &text, file, axis)?,
        _ => bail!("--mesh: found it with {}, needed --from bed-mesh", format.name()),
    };
    let imported = in_millimetres(imported, format, unit, file)?;
    for note in &imported.notes {
        report_line(format_args!("note: {}: {note}", file.display()));
    }
    let _alone = machine_folder::alone(output)?;
    let edited = if output.join("machine.toml").exists() {
        if new {
            return Err(not_new());
        }
        model::report_interrupted(output);
        imported.edit(&Folder::new(output), Path::new("machine.toml"))?
    } else {
        new_machine(&imported, file, output)?
    };
    let mut outputs = Outputs::of([file]);
    for (name, text) in &edited.files {
        outputs.put(&output.join(name), text.as_bytes())?;
    }
    outputs.commit()?;
    for note in &edited.notes {
        report_line(note);
    }
    for (name, _) in &edited.files {
        report_line(format_args!("written {}", output.join(name).display()));
    }
    let read_as = meaning(format);
    let read_as = if unit == Some(Unit::Inch) && format != Format::Columns {
        read_as.replace("mm", "inches")
    } else {
        read_as.to_owned()
    };
    report_line(format_args!("{}: {read_as}", format.name()));
    Ok(())
}

/// A machine with only the imported axes; existing files are never overwritten.
fn new_machine(imported: &Imported, file: &Path, output: &Path) -> Result<Edited> {
    if let Some((axis, names)) = imported.axis_without_place() {
        let letter = axis.letter();
        bail!(
            "{}: found location errors of axis {letter} ({names}) and no chain that it is in, needed a comment \
             // trueaxis chain: w b X Y Z {letter} t, that of the machine, in the file; or -o with a machine whose chain has it (nothing \
             is written)",
            file.display()
        );
    }
    let name = file.file_stem().map_or_else(|| "imported".into(), |stem| stem.to_string_lossy().into_owned());
    // machine.toml is written last, so it never exists without all of its tables.
    let made = imported.new_machine(&name);
    let mut paths = made.files.iter().map(|(name, _)| output.join(name));
    if let Some(path) = paths.find(|path| path.symlink_metadata().is_ok()) {
        bail!("{}: found a file and no machine.toml beside it, needed another folder", path.display());
    }
    let files = made.files.iter().map(|(name, text)| (name, text.as_str()));
    Machine::read_from(&Memory::new(files), Path::new("machine.toml"), &mut |_| {})
        .map_err(|error| anyhow!("{}: as a machine: {error} (nothing is written)", file.display()))?;
    Ok(made)
}

pub(super) fn export(format: Format, path: &Path, options: &ExportOptions, output: &Path) -> Result<()> {
    let machine = model::source(path)?;
    let exported = formats::export(format, &machine, options)?;
    let alone = exported.files.len() == 1;
    let mut outputs = Outputs::of(model::files(path));
    let mut written = Vec::new();
    for (name, text) in &exported.files {
        let file = if alone { output.to_path_buf() } else { file_of_axis(output, name) };
        outputs.put(&file, text.as_bytes())?;
        written.push(file);
    }
    outputs.commit()?;
    for file in written {
        report_line(format_args!("written {}", file.display()));
    }
    for dropped in &exported.dropped {
        report_line(format_args!("left out: {dropped}"));
    }
    for note in &exported.notes {
        report_line(format_args!("note: {note}"));
    }
    report_line(format_args!("{}: {}", format.name(), meaning(format)));
    Ok(())
}

/// The file for one axis: `OUT.comp` and `x.comp` make `OUT-x.comp`.
fn file_of_axis(output: &Path, name: &str) -> PathBuf {
    let stem = output.file_stem().map_or(String::new(), |s| s.to_string_lossy().into_owned());
    let part = Path::new(name).file_stem().map_or(String::new(), |s| s.to_string_lossy().into_owned());
    let ending = output.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
    output.with_file_name(format!("{stem}-{part}{ending}"))
}

/// Sign and unit of values in a format.
fn meaning(format: Format) -> &'static str {
    match format {
        Format::LinuxCnc(CompFileType::Positions) => {
            "nominal, forward and reverse positions = nominal + E, mm or degrees"
        }
        Format::LinuxCnc(CompFileType::Trims) => "nominal, forward and reverse trims = −E, mm or degrees",
        Format::Siemens => "values = +E, mm or degrees, one direction",
        Format::Isg => "values = +E, mm and rad, rotary arguments in degrees",
        Format::Iso230_2 => "deviations = +E, µm or µrad",
        Format::Columns => "positions = commanded + E, or deviations = +E",
        Format::Rtl => "deviations = +E, µm",
        Format::BedMesh | Format::HeightMap | Format::Marlin => {
            "heights = −EZ, mm: where the bed is high, the correction lifts the tool"
        }
        Format::Grid => "values = +E, µm and µrad",
    }
}
