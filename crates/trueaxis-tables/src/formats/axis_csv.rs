//! Writes the crate's own files.

use super::decimal::{shortest, toml_value};
use super::grid_csv::{grid_csv_name, grid_section, write_grid_csv};
use super::{Imported, own_comments, stated};
use crate::Table;
use crate::document::Edited;
use crate::files::Memory;
use crate::limits::widened;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use toml_edit::DocumentMut;
use trueaxis::machine::{Axis, LocationErrors, MachineSettings, NAME_CAPACITY};

/// File name of an axis' table, `x.csv`.
pub fn axis_csv_name(axis: Axis) -> String {
    format!("{}.csv", axis.letter().to_ascii_lowercase())
}

/// An axis table as CSV: `X_mm,EXX_um,…,ECX_urad`, only the given columns; a column whose directions differ becomes the pair
/// `EXX_fwd_um,EXX_rev_um`.
///
/// Positions in mm (degrees), errors actual − ideal in µm and µrad. Every number is the shortest decimal that reads back
/// (micro value divided by 1e6 for µrad, by 1e3 for µm) as the same double. A double that no decimal of µm reproduces
/// (possible only for values that did not come from such a file) is written as the nearest, 1 unit in the last place away.
pub fn write_axis_csv(table: &Table, axis: Axis) -> String {
    write_axis_csv_known(table, axis, &Default::default())
}

/// [`write_axis_csv`] with columns `EXX_u_um` for the standard uncertainties of single points, if given: mm and rad, one per
/// row.
pub(crate) fn write_axis_csv_known(table: &Table, axis: Axis, uncertainty: &[Option<Vec<f64>>; 6]) -> String {
    let unit = if axis.is_rotary() { "deg" } else { "mm" };
    let letter = axis.letter();
    let mut text = format!("{letter}_{unit}");
    let mut columns: Vec<(usize, bool)> = Vec::new();
    for (component, moved) in Axis::ALL.into_iter().enumerate() {
        if !table.given.get(component).copied().unwrap_or(false) {
            continue;
        }
        let micro = if component < 3 { "um" } else { "urad" };
        let direction = moved.letter();
        if table.rows.iter().any(|row| value(&row.forward, component) != value(&row.reverse, component)) {
            let _ = write!(text, ",E{direction}{letter}_fwd_{micro},E{direction}{letter}_rev_{micro}");
            columns.extend([(component, true), (component, false)]);
        } else {
            let _ = write!(text, ",E{direction}{letter}_{micro}");
            columns.push((component, true));
        }
    }
    let mut known = Vec::new();
    for ((component, moved), own) in Axis::ALL.into_iter().enumerate().zip(uncertainty) {
        let Some(own) = own.as_ref().filter(|_| table.given.get(component).copied().unwrap_or(false)) else { continue };
        let _ = write!(text, ",E{}{letter}_u_{}", moved.letter(), if component < 3 { "um" } else { "urad" });
        known.push((own, if component < 3 { 1e3 } else { 1e6 }));
    }
    text.push('\n');
    for (index, row) in table.rows.iter().enumerate() {
        let _ = write!(text, "{}", row.position);
        for &(component, forward) in &columns {
            let twist = if forward { &row.forward } else { &row.reverse };
            let scale = if component < 3 { 1e3 } else { 1e6 };
            let _ = write!(text, ",{}", shortest(value(twist, component), scale));
        }
        for (own, scale) in &known {
            let _ = write!(text, ",{}", shortest(own.get(index).copied().unwrap_or_default(), *scale));
        }
        text.push('\n');
    }
    text
}

fn value(twist: &[f64; 6], component: usize) -> f64 {
    twist.get(component).copied().unwrap_or(0.0)
}

pub(super) fn new_machine(imported: &Imported, name: &str) -> Edited {
    let mut end = name.len().min(NAME_CAPACITY);
    while !name.is_char_boundary(end) {
        end -= 1;
    }
    let name = toml::Value::from(name.get(..end).unwrap_or_default());
    let mut text = match &imported.settings {
        Some(settings) => described(settings, imported, &name),
        None => undescribed(imported, &name),
    };
    let mut grids = Vec::new();
    for (number, grid) in imported.grids.iter().enumerate() {
        let csv = grid_csv_name(number);
        grid_section(&mut text, grid, &csv);
        grids.push((csv, write_grid_csv(grid)));
    }
    let location = location_lines(&imported.location);
    if !location.is_empty() {
        let _ = write!(text, "\n[location]\n{location}");
    }
    let tables = imported.tables.iter().map(|(axis, table)| (axis_csv_name(*axis), write_axis_csv(table, *axis)));
    let mut files: Vec<(PathBuf, String)> = tables.chain(grids).map(|(name, text)| (name.into(), text)).collect();
    let mut notes = Vec::new();
    let (no_files, toml) = (Memory::default(), Path::new("machine.toml"));
    // An invalid text stays unchanged: the reader of the machine refuses it.
    let wide = text
        .parse::<DocumentMut>()
        .ok()
        .and_then(|document| widened(&document, &text, &files, (&no_files, toml), None, &mut notes).ok());
    files.push((toml.into(), wide.unwrap_or(text)));
    Edited { files, notes }
}

/// A machine of which only the tables are known.
fn undescribed(imported: &Imported, name: &toml::Value) -> String {
    let of_grids = |axis: Axis| !imported.grids.is_empty() && !axis.is_rotary();
    // An error along an axis is corrected by that axis.
    let moves = |table: &Table, k: usize| {
        k < 3 && table.rows.iter().any(|row| value(&row.forward, k) != 0.0 || value(&row.reverse, k) != 0.0)
    };
    let of_tables = |axis: Axis| imported.tables.iter().any(|(own, table)| *own == axis || moves(table, axis.index()));
    let used = |axis: &Axis| of_tables(*axis) || of_grids(*axis);
    let letters: String = Axis::ALL.into_iter().filter(used).map(|axis| format!(" {}", axis.letter())).collect();
    let mut text = format!(
        "# Imported. The file does not say which axes carry the workpiece: set the chain of your machine.\n\
         name = {name}\nchain = \"w b{letters} t\"\n"
    );
    for (axis, table) in &imported.tables {
        let _ = write!(text, "\n[axis.{}]\ntable = \"{}\"\n", axis.letter(), axis_csv_name(*axis));
        for (key, value) in stated::of_new_axis(*axis, table) {
            let _ = writeln!(text, "{key} = {value}");
        }
    }
    text
}

/// A machine that its file describes.
fn described(settings: &MachineSettings, imported: &Imported, name: &toml::Value) -> String {
    let chain = toml::Value::from(settings.chain.as_str());
    let mut text =
        format!("# Imported, with the chain that the file states in its comments.\nname = {name}\nchain = {chain}\n");
    let mut section = "";
    for (of, key, value) in own_comments::machine_items(settings) {
        if of != section {
            let _ = write!(text, "\n[{of}]\n");
            section = of;
        }
        let _ = writeln!(text, "{key} = {}", toml_value(key, &value));
    }
    for axis in &settings.axes {
        let _ = write!(text, "\n[axis.{}]\n", axis.axis.letter());
        if imported.tables.iter().any(|(with_table, _)| *with_table == axis.axis) {
            let _ = writeln!(text, "table = \"{}\"", axis_csv_name(axis.axis));
        }
        for (key, value) in own_comments::axis_items(axis) {
            let _ = writeln!(text, "{key} = {}", toml_value(key, &value));
        }
    }
    text
}

pub(super) fn location_lines(location: &LocationErrors) -> String {
    stated::location(location).iter().fold(String::new(), |lines, (key, value)| format!("{lines}{key} = {value}\n"))
}
