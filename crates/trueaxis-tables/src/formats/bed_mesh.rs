//! Bed meshes of Klipper: the `[bed_mesh NAME]` that `SAVE_CONFIG` writes at the end of `printer.cfg`.
//!
//! ```text
//! #*# [bed_mesh default]
//! #*# version = 1
//! #*# points =
//! #*#       0.052500, 0.042500, 0.030000
//! #*#       0.047500, 0.032500, 0.020000
//! #*# x_count = 3
//! #*# y_count = 2
//! #*# min_x = 20.0
//! #*# max_x = 220.0
//! #*# min_y = 20.0
//! #*# max_y = 120.0
//! ```
//!
//! `points`: heights of the bed, mm, a line for every Y from `min_y` up, along it X from `min_x` up. Where the bed is high by m
//! the nozzle stands m too low above it, so that
//!
//! ```text
//! EZ = −m
//! ```
//!
//! and the correction +m lifts the nozzle, as Klipper does. Of the section `[bed_mesh]` fade_start and fade_end become the heights
//! of the fade; it fades to nothing, where Klipper may fade to a `fade_target`. Klipper's own interpolation between the points
//! (`mesh_x_pps`, `algo`) is not taken over: between them the surface is bilinear.
//!
//! Source: Klipper, docs/Bed_Mesh.md and klippy/extras/bed_mesh.py.

use super::Imported;
use super::grid_csv::imported;
use crate::error::FileError;
use crate::grid::{Grid, GridSource};
use crate::origin::{Origin, numbered};
use trueaxis::error::Figure;
use trueaxis::machine::GRID_NODES;
use trueaxis::range;

/// A value of a section with its line.
struct Item<'t> {
    key: &'t str,
    line: u32,
    /// The value and the lines that go on with it.
    values: Vec<(u32, &'t str)>,
}

/// A section with its name.
struct Section<'t> {
    name: &'t str,
    line: u32,
    items: Vec<Item<'t>>,
}

impl<'t> Section<'t> {
    fn item(&self, key: &str) -> Option<&Item<'t>> {
        self.items.iter().find(|item| item.key == key)
    }

    fn number(&self, key: &str, origin: &Origin) -> Result<(u32, f64), FileError> {
        let found = self.item(key).and_then(|item| Some((item, item.values.first()?)));
        let Some((item, (line, text))) = found else {
            return Err(origin.at(self.line, key, "nothing", "a number in the section of the mesh"));
        };
        debug_assert!(item.line <= *line);
        origin.number(*line, key, text).map(|value| (*line, value))
    }
}

/// The sections of a configuration of which the mesh may be one, those of SAVE_CONFIG without their marks.
fn sections(text: &str) -> Vec<Section<'_>> {
    let mut sections: Vec<Section<'_>> = Vec::new();
    for (line, text) in numbered(text) {
        let own = text.strip_prefix("#*#").map_or(text, |saved| saved.strip_prefix(' ').unwrap_or(saved));
        let content = own.split(['#', ';']).next().unwrap_or_default();
        let bare = content.trim();
        if bare.is_empty() {
            continue;
        }
        if let Some(name) = bare.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            sections.push(Section { name: name.trim(), line, items: Vec::new() });
            continue;
        }
        let Some(section) = sections.last_mut() else { continue };
        let goes_on = content.starts_with([' ', '\t']);
        match (goes_on, section.items.last_mut(), bare.split_once(['=', ':'])) {
            (true, Some(item), _) => item.values.push((line, bare)),
            (_, _, Some((key, value))) => {
                let value = value.trim();
                let values = if value.is_empty() { Vec::new() } else { vec![(line, value)] };
                section.items.push(Item { key: key.trim(), line, values });
            }
            _ => {}
        }
    }
    sections
}

/// The only mesh, or that of the profile `default`.
fn mesh<'s, 't>(sections: &'s [Section<'t>], origin: &Origin) -> Result<&'s Section<'t>, FileError> {
    let profile = |section: &Section<'t>| section.name.strip_prefix("bed_mesh ").map(str::trim);
    let mut meshes = sections.iter().filter(|section| profile(section).is_some());
    let Some(first) = meshes.next() else {
        return Err(origin.whole("no [bed_mesh NAME]", "a mesh, as SAVE_CONFIG writes it after BED_MESH_CALIBRATE"));
    };
    let Some(second) = meshes.next() else { return Ok(first) };
    match sections.iter().find(|section| profile(section) == Some("default")) {
        Some(default) => Ok(default),
        None => Err(origin.at(
            second.line,
            "",
            format!("[{}] beside [{}]", second.name, first.name),
            "one mesh, or [bed_mesh default]",
        )),
    }
}

/// Reads the mesh of a `printer.cfg`.
pub(super) fn import(text: &str, origin: &Origin) -> Result<Imported, FileError> {
    let sections = sections(text);
    let mesh = mesh(&sections, origin)?;
    let mut nodes: [Vec<f64>; 3] = Default::default();
    for (nodes, letter) in nodes.iter_mut().zip(["x", "y"]) {
        *nodes = along(mesh, letter, origin)?;
    }
    let heights = heights(mesh, [nodes[0].len(), nodes[1].len()], origin)?;
    // Lines of one Y each become nodes with Y innermost.
    let values =
        (0..nodes[0].len()).flat_map(|x| heights.iter().map(move |row| [0.0, 0.0, 0.0 - row[x], 0.0, 0.0, 0.0]));
    let mut notes =
        vec![format!("[{}]: EZ = −height; bilinear between the {} points", mesh.name, nodes[0].len() * nodes[1].len())];
    let fade_mm = fade(&sections, origin, &mut notes)?;
    let source = GridSource {
        values: values.collect(),
        nodes,
        given: [false, false, true, false, false, false],
        fade_mm,
        ..GridSource::default()
    };
    match Grid::new(source) {
        Ok(grid) => Ok(imported(grid, notes)),
        Err(error) => Err(origin.whole(format!("{error:?}"), "heights that 16 bits hold")),
    }
}

/// The nodes along an axis.
fn along(mesh: &Section<'_>, letter: &str, origin: &Origin) -> Result<Vec<f64>, FileError> {
    let [count, low, high] = [format!("{letter}_count"), format!("min_{letter}"), format!("max_{letter}")];
    let (line, points) = mesh.number(&count, origin)?;
    if points.fract() != 0.0 || !(2.0..=GRID_NODES as f64).contains(&points) {
        return Err(origin.at(line, &count, Figure(points), format!("a whole number from 2 to {GRID_NODES}")));
    }
    let (_, from) = mesh.number(&low, origin)?;
    let (line, to) = mesh.number(&high, origin)?;
    for (key, value) in [(&low, from), (&high, to)] {
        if !range::POSITION.linear.contains(value) {
            return Err(origin.at(line, key, Figure(value), range::POSITION.linear.needed));
        }
    }
    let cells = points - 1.0;
    if to - from < cells * range::LEAST_PITCH {
        return Err(origin.at(line, &high, Figure(to), format!("more than {low} = {}", Figure(from))));
    }
    let node = |index: usize| if index as f64 == cells { to } else { from + (to - from) / cells * index as f64 };
    Ok((0..points as usize).map(node).collect())
}

/// Heights, a row for every Y.
fn heights(mesh: &Section<'_>, [columns, rows]: [usize; 2], origin: &Origin) -> Result<Vec<Vec<f64>>, FileError> {
    let Some(points) = mesh.item("points") else {
        return Err(origin.at(mesh.line, "points", "nothing", "the heights of the mesh"));
    };
    let mut heights = Vec::new();
    for (line, row) in &points.values {
        let row: Vec<&str> = row.split(',').map(str::trim).filter(|text| !text.is_empty()).collect();
        if row.len() != columns {
            let needed = format!("{columns}, as x_count says");
            return Err(origin.at(*line, "points", format!("{} heights", row.len()), needed));
        }
        let mut values = Vec::new();
        for text in row {
            let height = origin.number(*line, "points", text)?;
            if !range::TRANSLATION.contains(height) {
                return Err(origin.at(*line, "points", format!("{} mm", Figure(height)), range::TRANSLATION.needed));
            }
            values.push(height);
        }
        heights.push(values);
    }
    if heights.len() != rows {
        let needed = format!("{rows}, as y_count says");
        return Err(origin.at(points.line, "points", format!("{} lines of heights", heights.len()), needed));
    }
    Ok(heights)
}

/// Heights of the fade, where `[bed_mesh]` has one.
fn fade(sections: &[Section<'_>], origin: &Origin, notes: &mut Vec<String>) -> Result<Option<[f64; 2]>, FileError> {
    let Some(section) = sections.iter().find(|section| section.name == "bed_mesh") else { return Ok(None) };
    if section.item("fade_end").is_none() {
        return Ok(None);
    }
    let (line, end) = section.number("fade_end", origin)?;
    // Klipper's default.
    let start = if section.item("fade_start").is_some() { section.number("fade_start", origin)?.1 } else { 1.0 };
    if end == 0.0 {
        return Ok(None);
    }
    if end - start < range::LEAST_PITCH || !range::POSITION.linear.contains(end) {
        return Err(origin.at(
            line,
            "fade_end",
            Figure(end),
            format!("more than fade_start = {}, or 0", Figure(start)),
        ));
    }
    notes.push(format!("fades from Z {} to nothing at Z {}, whatever fade_target says", Figure(start), Figure(end)));
    Ok(Some([start, end]))
}
