//! Height maps of RepRapFirmware: the `heightmap.csv` that `G29` and `M374` write.
//!
//! ```text
//! RepRapFirmware height map file v2 generated at 2025-01-31 10:00, min error -0.050, max error 0.100, …
//! axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1
//! X,Y,20.00,220.00,20.00,120.00,-1.00,100.00,100.00,3,2
//!   0.050,  0.040,      0
//!   0.045, -0.010,  0.020
//! ```
//!
//! Heights of the bed in mm, one line for every Y upwards, along it X upwards: EZ = −height, and the correction lifts the
//! nozzle where the bed is high. The surface is bilinear between the points, which stand at minimum + number · spacing. The
//! spacing is rounded to 0.01 mm: where the range divided by the number of intervals is the same to 0.01 mm, it is used.
//!
//! A point that was not probed is a `0` without a decimal point, and no height. RepRapFirmware gives such points the height of
//! the plane that fits the probed ones best (least squares along Z); so does this module.
//!
//! The first line has version 1 or 2; the second is one of three: `xmin,xmax,ymin,ymax,radius,spacing,xnum,ynum` (one spacing
//! for both axes), `…,xspacing,yspacing,…`, or that above, with the letters of the axes. The height over which the map tapers
//! off (M376) is not in the file. A map over other axes than X and Y is refused.
//!
//! Source: RepRapFirmware, src/Movement/BedProbing/Grid.cpp, and the maps of public configurations.

use super::Imported;
use super::surface::{Surface, equidistant, height};
use crate::error::FileError;
use crate::origin::{Origin, numbered};
use crate::text::counted;
use trueaxis::error::Figure;
use trueaxis::machine::GRID_NODES;

/// Start of the first line, before the version.
const COMMENT: &str = "RepRapFirmware height map file v";
/// The labels of the third line, in the order in which RepRapFirmware introduced them.
const LABELS: [&str; 3] = [
    "xmin,xmax,ymin,ymax,radius,spacing,xnum,ynum",
    "xmin,xmax,ymin,ymax,radius,xspacing,yspacing,xnum,ynum",
    "axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1",
];

pub(super) fn import(text: &str, origin: &Origin) -> Result<Imported, FileError> {
    let mut lines = numbered(text.trim_start_matches('\u{feff}')).map(|(line, text)| (line, text.trim()));
    let mut next = |needed: &str| lines.next().ok_or_else(|| origin.whole("the end of the file", needed));
    let (line, comment) = next("a first line RepRapFirmware height map file v2")?;
    let version = comment.strip_prefix(COMMENT).map(|rest| rest.split([' ', ',']).next().unwrap_or_default());
    if !matches!(version, Some("1" | "2")) {
        return Err(origin.at(
            line,
            "",
            format!("{comment:?}"),
            format!("{COMMENT}1 or v2, as RepRapFirmware writes it"),
        ));
    }
    let (line, label) = next("the names of the figures in the third line")?;
    let Some(labels) = LABELS.iter().find(|known| label.starts_with(**known)) else {
        return Err(origin.at(line, "", format!("{label:?}"), format!("one of {}", LABELS.join("; "))));
    };
    let (line, figures) = next("the figures of the grid")?;
    let names: Vec<&str> = labels.split(',').collect();
    let figures: Vec<&str> = figures.split(',').map(str::trim).collect();
    if figures.len() != names.len() {
        return Err(origin.at(
            line,
            "",
            counted(figures.len(), "value"),
            format!("{} as in the line above", names.len()),
        ));
    }
    let text = |name: &str| names.iter().position(|own| *own == name).and_then(|index| figures.get(index)).copied();
    for (name, letter) in [("axis0", "X"), ("axis1", "Y")] {
        if let Some(found) = text(name).filter(|found| *found != letter) {
            return Err(origin.at(line, name, format!("{found:?}"), format!("{letter}: a map over X and Y")));
        }
    }
    let mut nodes: [Vec<f64>; 2] = Default::default();
    for (index, nodes) in nodes.iter_mut().enumerate() {
        *nodes = along(index, &text, line, origin)?;
    }
    let [columns, count] = [nodes[0].len(), nodes[1].len()];
    let mut rows: Vec<Vec<Option<f64>>> = Vec::new();
    for (line, text) in lines {
        if text.is_empty() {
            continue;
        }
        if rows.len() == count {
            return Err(origin.at(line, "", format!("{text:?}"), format!("the end after {count} lines of heights")));
        }
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        if fields.len() != columns {
            let needed = format!("{columns}, as {} says", names.get(names.len() - 2).unwrap_or(&"xnum"));
            return Err(origin.at(line, "", format!("{} heights", fields.len()), needed));
        }
        let read = |field: &&str| (*field != "0").then(|| height(line, "", field, origin)).transpose();
        rows.push(fields.iter().map(read).collect::<Result<_, _>>()?);
    }
    if rows.len() != count {
        let needed = format!("{count}, as {} says", names.last().unwrap_or(&"ynum"));
        return Err(origin.whole(format!("{} of heights", counted(rows.len(), "line")), needed));
    }
    let probed = rows.iter().flatten().flatten().count();
    let mut notes = vec![format!("EZ = −height; bilinear between the {} points", columns * count)];
    let heights = filled(&nodes, &rows).ok_or_else(|| {
        let found = format!("{} heights, the others a 0 without a decimal point", probed);
        origin.whole(found, "three probed points that are not on a line")
    })?;
    if probed != columns * count {
        notes.push(format!(
            "{} of the points were not probed: they are in the plane that fits the others best, as in RepRapFirmware",
            columns * count - probed
        ));
    }
    let probed: Vec<Vec<f64>> = rows.iter().map(|row| row.iter().flatten().copied().collect()).collect();
    Surface { nodes, heights, fade: None }.imported(&probed, notes, origin)
}

/// Nodes along X (0) or Y (1).
fn along<'t>(
    index: usize,
    text: &impl Fn(&str) -> Option<&'t str>,
    line: u32,
    origin: &Origin,
) -> Result<Vec<f64>, FileError> {
    let letter = ["x", "y"][index];
    // Under the name that the labels of this file have.
    let number = |figure: &str| {
        let names = [format!("{letter}{figure}"), format!("{figure}{index}"), figure.to_owned()];
        let (name, text) = names.into_iter().find_map(|name| text(&name).map(|text| (name, text))).unwrap_or_default();
        origin.number(line, &name, text).map(|value| (name, value))
    };
    let (_, low) = number("min")?;
    let (high_name, high) = number("max")?;
    let (spacing_name, spacing) = number("spacing")?;
    let (count_name, count) = number("num")?;
    if count.fract() != 0.0 || !(2.0..=GRID_NODES as f64).contains(&count) {
        return Err(origin.at(line, &count_name, Figure(count), format!("a whole number from 2 to {GRID_NODES}")));
    }
    let cells = count - 1.0;
    // The file has two decimals.
    let divided = (high - low) / cells;
    let last = if (divided - spacing).abs() <= 0.005 + 1e-9 { high } else { low + spacing * cells };
    if spacing <= 0.0 || last > high + 0.005 * count || last + spacing < high {
        let needed = format!("{count} points from {} to {high_name} = {}", Figure(low), Figure(high));
        return Err(origin.at(line, &spacing_name, Figure(spacing), needed));
    }
    equidistant([low, last], count as usize, (line, &high_name), origin)
}

/// The heights with those of points that were not probed; `None` if the probed points determine no plane.
fn filled(nodes: &[Vec<f64>; 2], rows: &[Vec<Option<f64>>]) -> Option<Vec<Vec<f64>>> {
    let points = nodes[1].iter().zip(rows).flat_map(|(y, row)| {
        nodes[0].iter().zip(row).filter_map(move |(x, height)| height.map(|height| [*x, *y, height]))
    });
    let points: Vec<[f64; 3]> = points.collect();
    let count = points.len() as f64;
    if points.len() == nodes[0].len() * nodes[1].len() {
        return Some(rows.iter().map(|row| row.iter().flatten().copied().collect()).collect());
    }
    let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / count;
    let centre = [mean(0), mean(1), mean(2)];
    let sum = |a: usize, b: usize| points.iter().map(|p| (p[a] - centre[a]) * (p[b] - centre[b])).sum::<f64>();
    let [xx, xy, yy, xz, yz] = [sum(0, 0), sum(0, 1), sum(1, 1), sum(0, 2), sum(1, 2)];
    let determinant = xx * yy - xy * xy;
    if points.len() < 3 || determinant <= 1e-9 * xx * yy {
        return None;
    }
    let [along_x, along_y] = [(xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant];
    let plane = |x: f64, y: f64| centre[2] + along_x * (x - centre[0]) + along_y * (y - centre[1]);
    let row = |(y, row): (&f64, &Vec<Option<f64>>)| {
        nodes[0].iter().zip(row).map(|(x, height)| height.unwrap_or_else(|| plane(*x, *y))).collect()
    };
    Some(nodes[1].iter().zip(rows).map(row).collect())
}
