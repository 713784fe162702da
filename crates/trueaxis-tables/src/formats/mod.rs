//! Reads and writes compensation data of other controls.
//!
//! Inside this crate a table holds the *error*, actual − ideal, of the tool relative to the workpiece (mm, rad; ISO 230-1).
//! The module of each format states the data that the format stores, and their conversion:
//!
//! | format | data | value for an error E |
//! |---|---|---|
//! | [`linuxcnc`] type 0 | positioning, both directions | nominal + E (mm, degrees) |
//! | [`linuxcnc`] type 1 | positioning, both directions | −E (mm, degrees) |
//! | [`siemens`] `$AA_ENC_COMP` | positioning, one direction, equidistant | +E (mm, degrees) |
//! | [`isg`] volumetric CSV | all six errors, location errors; as comments chain, offsets, tool | +E (mm, rad) |
//! | [`iso230_2`] measurement | deviations of single approaches | +E (µm, µrad) |
//! | [`columns`] of any name, read only | positioning, measured once in each direction | position + E, or E |
//! | `.rtl` of Renishaw, read only | deviations of single approaches | +E (µm) |
//! | [`bed_mesh`] of Klipper, read only | a surface over X and Y | EZ = −height (mm) |
//! | `heightmap.csv` of RepRapFirmware, read only | a surface over X and Y | EZ = −height (mm) |
//! | [`marlin`]'s printed meshes, read only | a surface over X and Y | EZ = −height (mm) |
//! | grid CSV, read only | errors over two or three linear axes | +E (µm, µrad) |
//!
//! Import refuses data that it would have to ignore. Export refuses data that the format cannot store, unless [`Loss::Drop`]
//! permits dropping it; the result then lists every loss.

mod axis_csv;
pub mod bed_mesh;
pub mod columns;
mod decimal;
pub(crate) mod grid_csv;
mod heightmap;
pub mod isg;
mod isg_notes;
pub mod iso230_2;
pub mod linuxcnc;
mod losses;
mod machine_toml;
pub mod marlin;
mod measured_at;
mod own_comments;
mod positioning;
mod rtl;
mod servo_toml;
pub mod siemens;
pub(crate) mod stated;
mod surface;
mod toml_lines;

pub(crate) use axis_csv::write_axis_csv_known;
pub use axis_csv::{axis_csv_name, write_axis_csv};
pub use grid_csv::{grid_csv_name, write_grid_csv};
pub use machine_toml::machine_files;
pub use stated::location_values;

use crate::document::Edited;
use crate::error::FileError;
use crate::origin::Origin;
use crate::sheet::Sheet;
use crate::{Grid, Machine, Table};
use linuxcnc::CompFileType;
use std::path::{Path, PathBuf};
use trueaxis::error::Figure;
use trueaxis::machine::{Axis, LocationErrors, MachineSettings, Row};
use trueaxis::range::{self, Range};

/// A format of another control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// LinuxCNC `COMP_FILE`, one axis per file.
    LinuxCnc(CompFileType),
    /// Siemens `$AA_ENC_COMP`, any number of axes per file.
    Siemens,
    /// ISG and Beckhoff volumetric compensation, the whole machine in a file.
    Isg,
    /// Measured deviations for an ISO 230-2 evaluation, one axis per file.
    Iso230_2,
    /// Positions or deviations of one axis in columns of any name; read only.
    Columns,
    /// Linear measurement of Renishaw's laser software, one axis per file; read only.
    Rtl,
    /// Bed mesh of Klipper, a surface over X and Y; read only.
    BedMesh,
    /// Height map of RepRapFirmware, a surface over X and Y; read only.
    HeightMap,
    /// Bed mesh in a log of Marlin, a surface over X and Y; read only.
    Marlin,
    /// Grid CSV, `X_mm,Y_mm,EX_um,…`; read only.
    Grid,
}

impl Format {
    /// Every format with its command-line name.
    pub const ALL: [(&'static str, Format); 11] = [
        ("linuxcnc-0", Format::LinuxCnc(CompFileType::Positions)),
        ("linuxcnc-1", Format::LinuxCnc(CompFileType::Trims)),
        ("siemens", Format::Siemens),
        ("isg", Format::Isg),
        ("iso230-2", Format::Iso230_2),
        ("columns", Format::Columns),
        ("rtl", Format::Rtl),
        ("bed-mesh", Format::BedMesh),
        ("heightmap", Format::HeightMap),
        ("marlin", Format::Marlin),
        ("grid", Format::Grid),
    ];

    /// Name of the format in [`Format::ALL`].
    pub fn name(self) -> &'static str {
        Format::ALL.iter().find(|(_, format)| *format == self).map_or("", |(name, _)| name)
    }

    /// The format with this name in [`Format::ALL`].
    pub fn from_name(name: &str) -> Option<Format> {
        Format::ALL.iter().find(|(known, _)| *known == name).map(|(_, format)| *format)
    }
}

/// Content of another control's file, as tables of this crate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Imported {
    /// The tables in the order X Y Z A B C.
    pub tables: Vec<(Axis, Table)>,
    /// Grids, which add to the tables.
    pub grids: Vec<Grid>,
    /// Location errors (zero unless the file gives them).
    pub location: LocationErrors,
    /// Chain, offsets, tool and use of the tables, from the comments of an [`isg`] file that this crate wrote. Settings that
    /// the comments do not give have their defaults, and the name is "imported". `None` for every other file.
    pub settings: Option<MachineSettings>,
    /// Unusual separators and decimals, and how the file was interpreted: to be reported once.
    pub notes: Vec<String>,
    /// Whether the grids replace existing ones over the same axes that give the same errors, as a re-probed bed mesh does.
    /// Otherwise such grids are refused.
    pub replaces_grids: bool,
}

impl Imported {
    /// Converts a file of an inch control to mm: positions of linear axes and translations times 25.4.
    ///
    /// [`import`] reads lengths as mm. [`linuxcnc`] and [`siemens`] files do not state their unit, and hold nothing but
    /// tables.
    #[must_use]
    pub fn read_as_inches(mut self) -> Imported {
        // Rounded to nine decimals: the product of two decimals leaves a rounding error beyond the ninth.
        let mm = |inches: &mut f64| *inches = (*inches * 25.4e9).round() / 1e9;
        for (axis, table) in &mut self.tables {
            for row in &mut table.rows {
                if !axis.is_rotary() {
                    mm(&mut row.position);
                }
                row.forward[..3].iter_mut().chain(&mut row.reverse[..3]).for_each(mm);
            }
        }
        self
    }

    /// The files of a machine that uses these tables, one CSV per axis and grid and, last, `machine.toml`, with notes on what
    /// else was set.
    ///
    /// With [`Imported::settings`], it is the machine that they describe. Otherwise the file does not state the order of the
    /// axes: `chain` puts all of them on the tool side and says so in a comment. The range of a table is the travel, and
    /// interpolation is cubic through four points or more, through fewer linear. Limits that the corrections need above the
    /// defaults are set ([`Edited::notes`]).
    pub fn new_machine(&self, name: &str) -> Edited {
        axis_csv::new_machine(self, name)
    }

    /// A rotary axis for which the file states nothing but location errors, and their names. [`Imported::new_machine`] leaves
    /// it out because the file does not state its place in the chain.
    pub fn axis_without_place(&self) -> Option<(Axis, String)> {
        let stated = |axis| self.settings.as_ref().is_some_and(|settings| settings.axis(axis).is_some());
        stated::of_no_axis(&self.location, |axis| stated(axis) || self.tables.iter().any(|(own, _)| *own == axis))
    }

    /// The files of [`Imported::new_machine`], `machine.toml` first, as (file name, text).
    pub fn machine_files(&self, name: &str) -> Vec<(String, String)> {
        let mut files = self.new_machine(name).files;
        files.rotate_right(1);
        files.into_iter().map(|(name, text)| (name.to_string_lossy().into_owned(), text)).collect()
    }
}

/// How an export treats data that the format cannot hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Loss {
    /// Refuse to export, naming everything that would be lost.
    #[default]
    Refuse,
    /// Leave it out and list it in [`Exported::dropped`].
    Drop,
}

/// Options of an export.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportOptions {
    /// How to treat data that the format cannot hold.
    pub loss: Loss,
    /// Export only this axis; `None`: every axis with a table.
    pub axis: Option<Axis>,
    /// Resample a table onto points this far apart (mm or degrees), linearly, before writing it; [`Format::Siemens`] only,
    /// where free grids need it.
    pub step: Option<f64>,
    /// File to name in errors.
    pub source: PathBuf,
}

impl Default for ExportOptions {
    fn default() -> Self {
        ExportOptions { loss: Loss::Refuse, axis: None, step: None, source: PathBuf::from("machine.toml") }
    }
}

/// Result of an export.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exported {
    /// File names and their text.
    pub files: Vec<(String, String)>,
    /// Data that the format could not hold, one sentence each; empty with [`Loss::Refuse`].
    pub dropped: Vec<String>,
    /// Settings of the control that the files need to take effect.
    pub notes: Vec<String>,
}

/// Reads a file of another control; `file` is only named in errors.
///
/// `axis`: the axis that the file is for. Needed if the format does not state it (LinuxCNC; ISO 230-2 with a `position_mm`
/// column); if it does, only that axis is imported. Rotary errors have the sense of the axis' own positions.
///
/// ```
/// use std::path::Path;
/// use trueaxis::machine::Axis;
/// use trueaxis_tables::formats::{Format, import};
///
/// // At 10 mm, approached from below, the axis is at 10.002 mm: an error of +2 µm.
/// let format = Format::from_name("linuxcnc-0").unwrap();
/// let imported = import(format, "0 0 0\n10 10.002 10.003\n", Path::new("x.comp"), Some(Axis::X))?;
/// let files = imported.machine_files("my mill");
/// assert_eq!(files[1].0, "x.csv");
/// assert!(files[1].1.starts_with("X_mm,EXX_fwd_um,EXX_rev_um"));
///
/// let error = import(format, "# nominal forward reverse\n", Path::new("x.comp"), Some(Axis::X)).unwrap_err();
/// assert!(error.to_string().starts_with("x.comp:1: found"));
/// # Ok::<(), trueaxis_tables::error::FileError>(())
/// ```
///
/// # Errors
/// The first deviation from the format, or the first value that a table cannot hold: file, line, column, found, needed.
pub fn import(format: Format, text: &str, file: &Path, axis: Option<Axis>) -> Result<Imported, FileError> {
    let origin = Origin::new(file);
    let imported = match format {
        Format::LinuxCnc(file_type) => linuxcnc::import(text, &origin, axis, file_type),
        Format::Siemens => siemens::import(text, &origin, axis),
        Format::Isg => isg::import(text, &origin, axis),
        Format::Iso230_2 => iso230_2::import(text, &origin, axis),
        Format::Columns => return columns::import(text, file, axis, &columns::Mapping::default()),
        Format::Rtl => rtl::import(text, &origin, axis),
        Format::BedMesh => bed_mesh::import(text, file, None),
        Format::HeightMap => heightmap::import(text, &origin),
        Format::Marlin => marlin::import(text, file, None),
        Format::Grid => grid_csv::import(text, &origin),
    }?;
    // Positions and errors of these formats are sums and means of what the file states.
    Ok(finished(imported, matches!(format, Format::LinuxCnc(_) | Format::Siemens | Format::Iso230_2 | Format::Rtl)))
}

/// The import with rounded tables, if its numbers were calculated, and with notes on them.
fn finished(mut imported: Imported, calculated: bool) -> Imported {
    if calculated {
        imported.tables.iter_mut().for_each(|(_, table)| to_six_places(table));
    }
    imported.notes.extend(imported.tables.iter().filter_map(|(axis, table)| open_circle(*axis, table)));
    imported
}

/// Rounds positions to six decimals of mm (degrees), and translations of µm. Angles in degrees have no short decimals in µrad.
fn to_six_places(table: &mut Table) {
    for row in &mut table.rows {
        row.position = decimal::to_six_places(row.position, 1.0);
        for twist in [&mut row.forward, &mut row.reverse] {
            twist.iter_mut().take(3).for_each(|error| *error = decimal::to_six_places(*error, 1e3));
        }
    }
}

/// A note on the table of a rotary axis that is one line short of a full circle.
fn open_circle(axis: Axis, table: &Table) -> Option<String> {
    let (first, last) = (table.rows.first()?.position, table.rows.last()?.position);
    let widest = table.rows.windows(2).fold(0.0, |widest: f64, pair| match pair {
        [before, row] => widest.max(row.position - before.position),
        _ => widest,
    });
    let left = 360.0 - (last - first);
    (axis.is_rotary() && left >= 1e-9 && left <= widest).then(|| {
        format!(
            "axis {}: the table ends at {last} degrees and does not wrap, beyond its ends their values apply; a line at {} degrees with \
             the values of that at {first} closes it",
            axis.letter(),
            first + 360.0
        )
    })
}

/// Writes a machine's tables in another control's format.
///
/// # Errors
/// If the machine has nothing to write, if a table breaks a limit of the format, or if something would be lost and
/// [`ExportOptions::loss`] does not allow that.
pub fn export(format: Format, machine: &Machine, options: &ExportOptions) -> Result<Exported, FileError> {
    let origin = Origin::new(&options.source);
    let chosen = |axis: Axis| options.axis.is_none_or(|only| only == axis);
    if !machine.axes().any(|(settings, table)| chosen(settings.axis) && table.is_some()) {
        let found = match options.axis {
            Some(axis) => format!("no table for axis {}", axis.letter()),
            None => String::from("no axis with a table"),
        };
        return Err(origin.whole(found, "an axis with a table"));
    }
    let mut exported = Exported::default();
    match format {
        Format::LinuxCnc(file_type) => linuxcnc::export(machine, options, file_type, &origin, &mut exported)?,
        Format::Siemens => siemens::export(machine, options, &origin, &mut exported)?,
        Format::Isg => isg::export(machine, options, &mut exported),
        Format::Iso230_2 => iso230_2::export(machine, options, &mut exported),
        Format::Columns | Format::Rtl | Format::BedMesh | Format::HeightMap | Format::Marlin | Format::Grid => {
            let needed = "a format that is written: linuxcnc, siemens, isg or iso230-2";
            return Err(origin.whole(format!("the format {}, which is only read", format.name()), needed));
        }
    }
    for grid in &machine.grids {
        let letters: String = grid.header().letters().map(|axis| format!(" {}", axis.letter())).collect();
        exported.dropped.push(format!("the grid over{letters}"));
    }
    if options.loss == Loss::Refuse && !exported.dropped.is_empty() {
        return Err(origin.whole(
            format!("data that the format cannot hold: {}", exported.dropped.join("; ")),
            "permission to drop it, or a format that holds it",
        ));
    }
    Ok(exported)
}

/// Ends of a full circle that differ by less are one point measured twice: mm and rad.
const CLOSED: [f64; 2] = [5e-4, 1e-6];

/// A table from its lines, with the checks of every imported table: two lines or more, positions strictly increasing, and the
/// two ends of a full circle equal, because such a table wraps. Ends that differ by up to 0.5 µm or 1 µrad both become their
/// mean.
fn table(axis: Axis, given: [bool; 6], mut lines: Vec<(u32, Row)>, origin: &Origin) -> Result<Table, FileError> {
    let name = format!("{} position", axis.letter());
    for (line, row) in &lines {
        within(origin, *line, &name, row.position, range::POSITION.of(axis))?;
        for (component, (forward, reverse)) in row.forward.iter().zip(&row.reverse).enumerate() {
            let range = if component < 3 { &range::TRANSLATION } else { &range::ROTATION };
            for value in [forward, reverse] {
                within(origin, *line, &positioning::error_name(axis, component), *value, range)?;
            }
        }
    }
    for pair in lines.windows(2) {
        let [(_, before), (line, row)] = pair else { continue };
        if row.position <= before.position {
            return Err(origin.at(*line, &name, row.position, format!("more than {} (increasing)", before.position)));
        }
    }
    let (Some((_, first)), Some((last_line, last))) = (lines.first(), lines.last()) else {
        return Err(origin.whole("no points", "at least two"));
    };
    if lines.len() < 2 {
        return Err(origin.whole("one point", "at least two"));
    }
    if axis.is_rotary() && (last.position - first.position - 360.0).abs() < 1e-9 {
        let ends = [(first.forward, last.forward), (first.reverse, last.reverse)];
        let ends = ends.iter().flat_map(|(low, high)| low.iter().zip(high).enumerate());
        let closed = |component: usize| if component < 3 { CLOSED[0] } else { CLOSED[1] };
        let apart = |(component, (low, high)): &(usize, (&f64, &f64))| (*low - *high).abs() > closed(*component);
        if let Some((component, (low, high))) = ends.into_iter().find(apart) {
            let (scale, unit) = if component < 3 { (1e3, "um") } else { (1e6, "urad") };
            return Err(origin.at(
                *last_line,
                &name,
                format!(
                    "{} {unit} at the end of the full circle, {} at its start",
                    Figure(high * scale),
                    Figure(low * scale)
                ),
                format!("values within {} {unit} of each other: a full circle wraps", closed(component) * scale),
            ));
        }
        let mean = |one: [f64; 6], other: [f64; 6]| std::array::from_fn(|k| 0.5 * (one[k] + other[k]));
        let (forward, reverse) = (mean(first.forward, last.forward), mean(first.reverse, last.reverse));
        if let [(_, first), .., (_, last)] = lines.as_mut_slice() {
            for row in [first, last] {
                (row.forward, row.reverse) = (forward, reverse);
            }
        }
    }
    let rows: Vec<Row> = lines.into_iter().map(|(_, row)| row).collect();
    let bidirectional = rows.iter().any(|row| row.forward != row.reverse);
    Ok(Table { given, bidirectional, rows })
}

/// The axis of `X`, `x`.
fn axis_of(name: &str) -> Option<Axis> {
    let mut letters = name.chars();
    let axis = letters.next().and_then(|letter| Axis::from_letter(letter.to_ascii_uppercase()))?;
    letters.next().is_none().then_some(axis)
}

/// A value (mm, degrees, rad) in its physical range.
fn within(origin: &Origin, line: u32, name: &str, value: f64, range: &Range) -> Result<(), FileError> {
    if range.contains(value) { Ok(()) } else { Err(origin.at(line, name, figure(value, range), range.needed)) }
}

/// [`within`] for the row of a sheet that is being read.
fn within_sheet(sheet: &Sheet<'_>, column: usize, value: f64, range: &Range) -> Result<(), FileError> {
    let name = sheet.header().get(column).map_or("", String::as_str);
    if range.contains(value) { Ok(()) } else { Err(sheet.error(name, figure(value, range), range.needed)) }
}

/// A value with the unit of its range.
fn figure(value: f64, range: &Range) -> String {
    let unit = if *range == range::ROTATION {
        " rad"
    } else if *range == range::TRANSLATION {
        " mm"
    } else {
        ""
    };
    format!("{}{unit}", Figure(value))
}

/// `given` with one component only.
fn only(component: usize) -> [bool; 6] {
    std::array::from_fn(|k| k == component)
}

/// A row with one component only, mm or rad.
fn single(position: f64, component: usize, forward: f64, reverse: f64) -> Row {
    Row {
        position,
        forward: std::array::from_fn(|k| if k == component { forward } else { 0.0 }),
        reverse: std::array::from_fn(|k| if k == component { reverse } else { 0.0 }),
    }
}
