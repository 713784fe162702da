//! `[[grid]]` of `machine.toml`: errors over two or three linear axes.

use super::section::Section;
use super::units::{from_um, from_urad};
use crate::error::FileError;
use crate::grid::LINEAR;
use trueaxis::machine::{Axis, GRIDS};
use trueaxis::range;

/// A grid that the file names.
pub(crate) struct GridReference {
    /// In the order X Y Z.
    pub(crate) axes: Vec<Axis>,
    /// As written in `machine.toml`, relative to it.
    pub(crate) file: String,
    pub(crate) line: u32,
    pub(crate) key: String,
    pub(super) fade_mm: Option<[f64; 2]>,
    pub(super) measured_at_mm: [f64; 3],
    pub(super) resolution: [Option<f64>; 2],
}

impl GridReference {
    /// A grid over these axes, everything else at its default; not named in any file.
    pub(crate) fn of_axes(axes: Vec<Axis>) -> GridReference {
        GridReference {
            axes,
            file: String::new(),
            line: 0,
            key: String::new(),
            fade_mm: None,
            measured_at_mm: [0.0; 3],
            resolution: [None; 2],
        }
    }
}

/// All sections, in the order of the file.
pub(super) fn read(root: &Section<'_>) -> Result<Vec<GridReference>, FileError> {
    let mut all = Vec::new();
    for section in root.sections("grid")? {
        if all.len() == GRIDS {
            let needed = format!("at most {GRIDS}");
            return Err(root.at(section.first_line(), "grid", "another section [[grid]]", needed));
        }
        all.push(read_one(section)?);
    }
    Ok(all)
}

fn read_one(section: Section<'_>) -> Result<GridReference, FileError> {
    let needed = "two or three linear axes, like [\"X\", \"Y\"]";
    let given = section.axes("axes")?.ok_or_else(|| section.missing_here("axes", needed))?;
    let axes: Vec<Axis> = LINEAR.into_iter().filter(|axis| given.value.contains(axis)).collect();
    if axes.len() != given.value.len() || axes.len() < 2 {
        return Err(section.wrong(&given, needed));
    }
    let needed = "the CSV of the grid, relative to this file";
    let table = section.string("table")?.ok_or_else(|| section.missing_here("table", needed))?;
    let fade_mm = section.numbers("fade_mm")?.map(|found| found.value);
    let mut measured_at_mm = [0.0; 3];
    section.store_all(&mut measured_at_mm, "measured_at_mm")?;
    let mut resolution = [None; 2];
    let keys = [
        ("resolution_um", from_um as fn(f64) -> f64, range::GRID_STEP),
        ("resolution_urad", from_urad, range::GRID_TURN),
    ];
    for (resolution, (key, convert, range)) in resolution.iter_mut().zip(keys) {
        if let Some(found) = section.number(key)? {
            *resolution = Some(convert(found.value)).filter(|step| range.contains(*step));
            if resolution.is_none() {
                return Err(section.wrong(&found, range.needed));
            }
        }
    }
    section.finish(None)?;
    Ok(GridReference {
        axes,
        file: table.value.to_owned(),
        line: table.line,
        key: table.key,
        fade_mm,
        measured_at_mm,
        resolution,
    })
}
