//! `trueaxis tables import` and `export`: files of other controls to a machine's folder and back.

use crate::model;
use anyhow::{Result, anyhow, bail};
use serde::Serialize;
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis_tables::files::{Folder, Memory};
use trueaxis_tables::formats::columns::{Mapping, Unit};
use trueaxis_tables::formats::linuxcnc::CompFileType;
use trueaxis_tables::formats::marlin::Area;
use trueaxis_tables::formats::{self, ExportOptions, Format, Imported};
use trueaxis_tables::output::{Alone, Outputs};
use trueaxis_tables::text::read_text;
use trueaxis_tables::{Edited, Machine, Table};

/// Result of an import or an export.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TransferDocument {
    /// Name of the format.
    pub format: &'static str,
    /// Sign and unit of the values in the format.
    pub meaning: String,
    /// The files written.
    pub written: Vec<PathBuf>,
    /// Settings that the format cannot store and that were left out.
    pub left_out: Vec<String>,
    /// Notes on what was read, set or changed.
    pub notes: Vec<String>,
}

/// A format to read, by its name on the command line.
///
/// # Errors
/// No such format.
pub fn format_to_read(name: &str, comp_file_type: Option<u8>) -> Result<Format> {
    let needed = "siemens, isg, iso230-2, columns, rtl, bed-mesh, heightmap, marlin or grid";
    format("--from", name, comp_file_type, needed)
}

/// A format to write, by its name on the command line.
///
/// # Errors
/// No such format.
pub fn format_to_write(name: &str, comp_file_type: Option<u8>) -> Result<Format> {
    format("--to", name, comp_file_type, "siemens, isg or iso230-2")
}

fn format(option: &str, name: &str, comp_file_type: Option<u8>, others: &str) -> Result<Format> {
    match (name, comp_file_type) {
        ("linuxcnc", None | Some(0)) => Ok(Format::LinuxCnc(CompFileType::Positions)),
        ("linuxcnc", Some(_)) => Ok(Format::LinuxCnc(CompFileType::Trims)),
        _ => Format::from_name(name)
            .ok_or_else(|| anyhow!("{option}: found \"{name}\", needed linuxcnc, linuxcnc-0, linuxcnc-1, {others}")),
    }
}

/// The unit with this name; µm is one of readings only.
///
/// # Errors
/// No such unit.
pub fn unit(name: &str, format: Format) -> Result<Unit> {
    let of_readings = format == Format::Columns;
    let unit = Unit::from_name(name).filter(|unit| of_readings || *unit != Unit::Micrometre);
    let needed = if of_readings { "mm, um or inch" } else { "mm or inch" };
    unit.ok_or_else(|| anyhow!("--unit: found \"{name}\", needed {needed}"))
}

/// The area `X,Y,X,Y`.
///
/// # Errors
/// Anything but four numbers that are one.
pub fn area(text: &str) -> Result<Area> {
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
pub struct ImportOptions<'o> {
    /// Format of the file.
    pub format: Format,
    /// Determine the type of a LinuxCNC file from its numbers.
    pub recognise: bool,
    /// Axis of the file, if the file does not name it.
    pub axis: Option<Axis>,
    /// Unit of lengths in a file that does not state it.
    pub unit: Option<Unit>,
    /// Names of the columns to read.
    pub columns: Option<&'o str>,
    /// Area of a mesh in the log of Marlin.
    pub area: Option<Area>,
    /// Name of a mesh to read.
    pub mesh: Option<&'o str>,
    /// Refuse a folder that already exists.
    pub new: bool,
}

/// Reads a file into the machine in the folder `output`, which may not exist yet; `say` receives the lines that the command
/// prints.
///
/// # Errors
/// A file that its format does not permit; a machine that the controller would refuse; a folder that cannot be written.
pub fn import(
    options: &ImportOptions<'_>,
    file: &Path,
    output: &Path,
    say: &mut dyn FnMut(String),
) -> Result<TransferDocument> {
    let ImportOptions { format, recognise, axis, unit, columns, area, mesh, new } = *options;
    let not_new = || anyhow!("--new: found {}, needed a folder that does not exist yet", output.display());
    if new && output.symlink_metadata().is_ok() {
        return Err(not_new());
    }
    let text = read_text(file, &['#', ';'])?;
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
    imported.notes.iter().for_each(|note| say(format!("note: {}: {note}", file.display())));
    let _alone = Alone::in_folder(output, &mut |note| say(format!("note: {note}")))?;
    let edited = if output.join("machine.toml").exists() {
        if new {
            return Err(not_new());
        }
        model::left(output).into_iter().for_each(|note| say(format!("note: {note}")));
        imported.edit(&Folder::new(output), Path::new("machine.toml"))?
    } else {
        new_machine(&imported, file, output)?
    };
    let mut outputs = Outputs::of([file]);
    for (name, text) in &edited.files {
        outputs.put(&output.join(name), text.as_bytes())?;
    }
    outputs.commit()?;
    let written: Vec<PathBuf> = edited.files.iter().map(|(name, _)| output.join(name)).collect();
    edited.notes.iter().for_each(|note| say(note.clone()));
    written.iter().for_each(|file| say(format!("written {}", file.display())));
    let meaning = meaning(format);
    let meaning = match unit {
        Some(Unit::Inch) if format != Format::Columns => meaning.replace("mm", "inches"),
        _ => meaning.to_owned(),
    };
    say(format!("{}: {meaning}", format.name()));
    let notes = imported.notes.into_iter().chain(edited.notes).collect();
    Ok(TransferDocument { format: format.name(), meaning, written, left_out: Vec::new(), notes })
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

/// Writes a machine's tables in another control's format, never over one of the `inputs`; `say` receives the lines that the
/// command prints.
///
/// # Errors
/// Data that the format cannot store, unless the options permit to leave it out; a file that cannot be written.
pub fn export(
    format: Format,
    machine: &Machine,
    inputs: impl IntoIterator<Item = PathBuf>,
    options: &ExportOptions,
    output: &Path,
    say: &mut dyn FnMut(String),
) -> Result<TransferDocument> {
    let exported = formats::export(format, machine, options)?;
    let alone = exported.files.len() == 1;
    let mut outputs = Outputs::of(inputs);
    let mut written = Vec::new();
    let mut notes = exported.notes;
    for (name, text) in &exported.files {
        let file = if alone { output.to_path_buf() } else { file_of_axis(output, name) };
        outputs.put(&file, text.as_bytes())?;
        if let Some(own) = file.file_name() {
            notes.iter_mut().for_each(|note| *note = note.replace(name, &own.to_string_lossy()));
        }
        written.push(file);
    }
    outputs.commit()?;
    written.iter().for_each(|file| say(format!("written {}", file.display())));
    exported.dropped.iter().for_each(|dropped| say(format!("left out: {dropped}")));
    notes.iter().for_each(|note| say(format!("note: {note}")));
    let meaning = meaning(format).to_owned();
    say(format!("{}: {meaning}", format.name()));
    let left_out = exported.dropped.iter().map(ToString::to_string).collect();
    Ok(TransferDocument { format: format.name(), meaning, written, left_out, notes })
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
