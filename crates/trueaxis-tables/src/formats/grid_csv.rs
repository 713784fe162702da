//! Grids of errors: writes and imports the CSV of this crate.

use super::Imported;
use super::decimal::shortest;
use super::toml_lines::{Lines, section};
use crate::error::FileError;
use crate::grid::{Grid, LINEAR};
use crate::origin::Origin;
use crate::read::grid_table::{self, error_name, position_name};
use crate::read::grid_toml::GridReference;
use crate::sheet::Sheet;
use std::fmt::Write;
use trueaxis::machine::Axis;

/// File name of a grid's table by its number from 0: `grid.csv`, `grid-2.csv`.
pub fn grid_csv_name(number: usize) -> String {
    if number == 0 { String::from("grid.csv") } else { format!("grid-{}.csv", number + 1) }
}

/// A grid as CSV: `X_mm,Y_mm,EX_um,…`, only the given columns, one line per node.
///
/// Positions in mm, errors actual − ideal in µm and µrad, as given, without the rounding for the controller.
pub fn write_grid_csv(grid: &Grid) -> String {
    let source = grid.source();
    let axes: Vec<usize> = (0..3).filter(|axis| !source.nodes[*axis].is_empty()).collect();
    let components: Vec<usize> = (0..6).filter(|component| source.given[*component]).collect();
    let names = axes.iter().map(|axis| position_name(LINEAR[*axis]));
    let mut text = names.chain(components.iter().map(|component| error_name(*component))).collect::<Vec<_>>().join(",");
    text.push('\n');
    for (number, value) in source.values.iter().enumerate() {
        let (mut rest, mut at) = (number, [0.0; 3]);
        for axis in axes.iter().rev() {
            let nodes = &source.nodes[*axis];
            at[*axis] = nodes[rest % nodes.len()];
            rest /= nodes.len();
        }
        let positions = axes.iter().map(|axis| at[*axis].to_string());
        let errors = components
            .iter()
            .map(|component| shortest(value[*component], if *component < 3 { 1e3 } else { 1e6 }).to_string());
        let _ = writeln!(text, "{}", positions.chain(errors).collect::<Vec<_>>().join(","));
    }
    text
}

/// The axes of a grid as in `machine.toml`: `["X", "Y"]`.
fn axes_of(grid: &Grid) -> String {
    let letters: Vec<String> = grid.header().letters().map(|axis| format!("\"{}\"", axis.letter())).collect();
    format!("[{}]", letters.join(", "))
}

/// Writes a section `[[grid]]`.
pub(crate) fn grid_section(text: &mut String, grid: &Grid, csv: &str) {
    let source = grid.source();
    let mut lines = Lines::default();
    lines.put("axes", axes_of(grid));
    lines.put("table", format_args!("\"{csv}\""));
    if let Some([whole, none]) = source.fade_mm {
        lines.put("fade_mm", format_args!("[{whole:?}, {none:?}]"));
    }
    lines.numbers("measured_at_mm", &source.measured_at_mm, &[0.0; 3]);
    for (key, resolution, scale) in
        [("resolution_um", source.resolution[0], 1e3), ("resolution_urad", source.resolution[1], 1e6)]
    {
        if let Some(resolution) = resolution {
            lines.scaled(key, resolution, 0.0, scale);
        }
    }
    section(text, "[grid]", &lines.0);
}

/// Reads a grid: columns `X_mm`, `Y_mm`, `Z_mm`, two or three of them, and `EX_um` … `EC_urad`, at least one.
pub(super) fn import(text: &str, origin: &Origin) -> Result<Imported, FileError> {
    let sheet = Sheet::new(text.as_bytes(), origin.file())?;
    let axes: Vec<Axis> = LINEAR.into_iter().filter(|axis| sheet.header().contains(&position_name(*axis))).collect();
    if axes.len() < 2 {
        let needed = "the positions of a grid, two or three of X_mm Y_mm Z_mm";
        return Err(origin.at(sheet.header_line(), "", sheet.header().join(","), needed));
    }
    drop(sheet);
    let file = grid_table::read(text.as_bytes(), origin, &GridReference::of_axes(axes))?;
    let notes = file.dialect.map(String::from).into_iter().collect();
    Ok(Imported { grids: vec![file.grid], notes, ..Imported::default() })
}
