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
//! `points`: heights of the bed, mm, one line for every Y from `min_y` up, along it X from `min_x` up. Where the bed is high
//! by m, the nozzle is m too low relative to it, so
//!
//! ```text
//! EZ = −m
//! ```
//!
//! and the correction +m lifts the nozzle, as Klipper does. With a fade (`fade_start`, `fade_end` of the section `[bed_mesh]`)
//! the mesh fades not to zero but to the height t = `fade_target`, by default the mean of Klipper's interpolated mesh to
//! 0.01 mm, so that a part is not scaled in Z:
//!
//! ```text
//! correction = t + f(z) (m − t)        f = 1 up to fade_start, 0 from fade_end on
//! ```
//!
//! This becomes two grids, −(m − t) with the fade and −t without. Klipper fades by the commanded height z, grids by the axis
//! position z + t + f(z) (m − t), which is linear in z from m above fade_start to t above fade_end. The heights of the fade
//! are raised by these amounts, with the mean for m. Between the probed points Klipper interpolates `mesh_x_pps` and
//! `mesh_y_pps` more, with the Lagrange polynomial or cardinal spline that `algo` selects, and is bilinear between all of
//! them: these points are the nodes.
//!
//! Source: Klipper, docs/Bed_Mesh.md and klippy/extras/bed_mesh.py.

use super::Imported;
use super::decimal::to_six_places;
use super::surface::{Fade, Surface, height};
use crate::error::FileError;
use crate::origin::{Origin, numbered};
use crate::text::counted;
use std::path::Path;
use trueaxis::error::Figure;
use trueaxis::machine::GRID_NODES;
use trueaxis::range;

/// Klipper's limits of `bicubic_tension`.
const TENSION: std::ops::RangeInclusive<f64> = 0.0..=2.0;

/// A value of a section with its line.
struct Item<'t> {
    key: &'t str,
    line: u32,
    /// The value, and any continuation lines.
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

/// The sections of a configuration, including those of SAVE_CONFIG without their `#*#` prefix.
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
        let continues = content.starts_with([' ', '\t']);
        match (continues, section.items.last_mut(), bare.split_once(['=', ':'])) {
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

/// The mesh with this name; without a name the only mesh, or `default`.
fn mesh<'s, 't>(
    sections: &'s [Section<'t>],
    wanted: Option<&str>,
    origin: &Origin,
) -> Result<&'s Section<'t>, FileError> {
    let profile = |section: &Section<'t>| section.name.strip_prefix("bed_mesh ").map(str::trim);
    let meshes: Vec<_> = sections.iter().filter(|section| profile(section).is_some()).collect();
    let named = |name: &str| meshes.iter().find(|section| profile(section) == Some(name)).copied();
    let names = || meshes.iter().filter_map(|section| profile(section)).collect::<Vec<_>>().join(", ");
    match (wanted, &meshes[..]) {
        (_, []) => Err(origin.whole("no [bed_mesh NAME]", "a mesh, as SAVE_CONFIG writes it after BED_MESH_CALIBRATE")),
        (Some(name), _) => named(name).ok_or_else(|| {
            origin.whole(format!("no [bed_mesh {name}]"), format!("the name of one of its meshes: {}", names()))
        }),
        (None, [only]) => Ok(only),
        (None, [first, second, ..]) => named("default").ok_or_else(|| {
            let found = format!("[{}] beside [{}]", second.name, first.name);
            origin.at(second.line, "", found, format!("[bed_mesh default], or --mesh with one of {}", names()))
        }),
    }
}

/// Reads a mesh of a `printer.cfg`: the one with this name, without a name the only mesh or `default`; `file` is only named in
/// errors.
///
/// # Errors
/// No such mesh, several of which none is `default`, or one that a grid cannot hold: file, line, key, found, needed.
pub fn import(text: &str, file: &Path, name: Option<&str>) -> Result<Imported, FileError> {
    let origin = &Origin::new(file);
    let sections = sections(text);
    let mesh = mesh(&sections, name, origin)?;
    let mut nodes: [Vec<f64>; 2] = Default::default();
    for (nodes, letter) in nodes.iter_mut().zip(["x", "y"]) {
        *nodes = along(mesh, letter, origin)?;
    }
    let [columns, rows] = [nodes[0].len(), nodes[1].len()];
    let probed = heights(mesh, [columns, rows], origin)?;
    let Laid { heights, between, by } = laid(mesh, &probed, origin)?;
    let mut how = format!("[{}]: EZ = −height; bilinear between the {} points", mesh.name, columns * rows);
    for (nodes, between) in nodes.iter_mut().zip(between) {
        *nodes = divided(nodes, between);
    }
    if between != [0, 0] {
        how += &format!(
            " and those that Klipper interpolates between them, {} and {} along X and Y, {by}",
            between[0], between[1]
        );
    }
    let fade = fade(&sections, &probed, origin)?;
    Surface { nodes, heights, fade }.imported(&probed, vec![how], origin)
}

/// Nodes along an axis.
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

/// Heights, one row for every Y.
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
            values.push(height(*line, "points", text, origin)?);
        }
        heights.push(values);
    }
    if heights.len() != rows {
        let needed = format!("{rows}, as y_count says");
        return Err(origin.at(points.line, "points", format!("{} of heights", counted(heights.len(), "line")), needed));
    }
    Ok(heights)
}

/// The mesh as Klipper interpolates it.
struct Laid {
    /// One row for every Y.
    heights: Vec<Vec<f64>>,
    /// Points added in every interval along X and Y.
    between: [usize; 2],
    /// Method of interpolation.
    by: &'static str,
}

/// Klipper's mesh with interpolated points: `Σ u_i v_j m_ij`, with the weights of [`weights`] along X and Y.
fn laid(mesh: &Section<'_>, heights: &[Vec<f64>], origin: &Origin) -> Result<Laid, FileError> {
    let bicubic = mesh.item("algo").and_then(|item| item.values.first()).is_some_and(|(_, text)| *text == "bicubic");
    // Klipper's default.
    let mut tension = 0.2;
    if mesh.item("tension").is_some() {
        let (line, stated) = mesh.number("tension", origin)?;
        if !TENSION.contains(&stated) {
            let needed = format!("{} to {}, as Klipper accepts", TENSION.start(), TENSION.end());
            return Err(origin.at(line, "tension", Figure(stated), needed));
        }
        tension = stated;
    }
    let tension = bicubic.then_some(tension);
    let counts = [heights.first().map_or(0, Vec::len), heights.len()];
    let mut between = [0; 2];
    for ((between, count), key) in between.iter_mut().zip(counts).zip(["mesh_x_pps", "mesh_y_pps"]) {
        let Some(item) = mesh.item(key) else {
            // Klipper's default.
            *between = 2;
            continue;
        };
        let (line, points) = mesh.number(key, origin)?;
        debug_assert!(item.line <= line);
        let most = (GRID_NODES - count) / (count - 1);
        if points.fract() != 0.0 || !(0.0..=most as f64).contains(&points) {
            return Err(origin.at(line, key, Figure(points), format!("a whole number from 0 to {most}")));
        }
        *between = points as usize;
    }
    let [u, v] = [0, 1].map(|axis| weights(counts[axis], between[axis], tension));
    let sum = |weights: &[f64], of: &[f64]| weights.iter().zip(of).map(|(weight, height)| weight * height).sum::<f64>();
    let rows: Vec<Vec<f64>> = heights.iter().map(|row| u.iter().map(|weights| sum(weights, row)).collect()).collect();
    let columns = (0..u.len()).map(|x| rows.iter().map(|row| row[x]).collect::<Vec<f64>>());
    let columns: Vec<Vec<f64>> =
        columns.map(|column| v.iter().map(|weights| sum(weights, &column)).collect()).collect();
    let heights = (0..v.len()).map(|y| columns.iter().map(|column| column[y]).collect()).collect();
    let by = match tension {
        Some(_) => "by a cardinal spline (bicubic)",
        None if counts.iter().any(|count| *count > MOST_OF_LAGRANGE) => "on straight lines",
        None => "by Lagrange's polynomial",
    };
    Ok(Laid { heights, between, by })
}

/// Nodes with every interval divided into equal parts, to a nanometre.
fn divided(nodes: &[f64], between: usize) -> Vec<f64> {
    let parts = between + 1;
    let inner = nodes
        .windows(2)
        .flat_map(|ends| (0..parts).map(move |part| ends[0] + (ends[1] - ends[0]) * part as f64 / parts as f64))
        .map(|node| to_six_places(node, 1.0));
    inner.chain(nodes.last().copied()).collect()
}

/// Most points for which Klipper uses a Lagrange polynomial.
const MOST_OF_LAGRANGE: usize = 6;

/// Weights of `count` points at each of them and at the `between` points in every interval, by Lagrange's polynomial or a
/// cardinal spline with a tension.
fn weights(count: usize, between: usize, tension: Option<f64>) -> Vec<Vec<f64>> {
    let step = between + 1;
    let total = (count.max(1) - 1) * step + 1;
    let mut all = vec![vec![0.0; count]; total];
    for (place, weights) in all.iter_mut().enumerate() {
        let (index, t) = (place / step, (place % step) as f64 / step as f64);
        if t == 0.0 {
            weights[index] += 1.0;
        } else if let Some(tension) = tension {
            let (t2, t3) = (t * t, t * t * t);
            let (rise, fall) = (tension * (t3 - 2.0 * t2 + t), tension * (t3 - t2));
            // At the ends the outermost point counts twice.
            let of = [index.max(1) - 1, index, index + 1, (index + 2).min(count - 1)];
            let share = [-rise, 2.0 * t3 - 3.0 * t2 + 1.0 - fall, 3.0 * t2 - 2.0 * t3 + rise, fall];
            of.into_iter().zip(share).for_each(|(of, share)| weights[of] += share);
        } else if count <= MOST_OF_LAGRANGE {
            let at = index as f64 + t;
            for (own, weight) in weights.iter_mut().enumerate() {
                let others = (0..count).filter(|other| *other != own);
                *weight += others.map(|other| (at - other as f64) / (own as f64 - other as f64)).product::<f64>();
            }
        } else {
            weights[index] += 1.0 - t;
            weights[index + 1] += t;
        }
    }
    all
}

/// The fade, if `[bed_mesh]` has one.
fn fade(sections: &[Section<'_>], mesh: &[Vec<f64>], origin: &Origin) -> Result<Option<Fade>, FileError> {
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
    let mut target = None;
    if section.item("fade_target").is_some() {
        let (line, stated) = section.number("fade_target", origin)?;
        let [low, high] = mesh
            .iter()
            .flatten()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| [low.min(*height), high.max(*height)]);
        if stated != 0.0 && !(low..=high).contains(&stated) {
            let needed = format!("a height of the mesh, {} to {}, or 0", Figure(low), Figure(high));
            return Err(origin.at(line, "fade_target", Figure(stated), needed));
        }
        target = Some(stated);
    }
    Ok(Some(Fade { heights: [start, end], target }))
}
