//! Bed meshes that Marlin prints, in the log of a terminal: `M420 V`, `G29 T` of unified bed leveling (UBL), the grid of a
//! bilinear `G29`.
//!
//! ```text
//! Bed Topography Report:                        Bilinear Leveling Grid:
//!                                                      0      1      2
//!     ( 20,120)               (220,120)           0 +0.050 +0.040 +0.030
//!        0       1       2                        1 +0.045 -0.010 +0.020
//! 1 | +0.045  -0.010 [+0.020]
//!   |                                           Bed Topography Report for CSV:
//! 0 | +0.050  +0.040  +0.030
//!        0       1       2                      0.045⇥-0.010⇥0.020
//!     ( 20, 20)               (220, 20)         0.050⇥0.040⇥0.030
//! ```
//!
//! Heights of the bed in mm: EZ = −height. The map of UBL has the highest Y first, the bilinear grid the lowest. UBL prints the
//! corners of its map in whole mm; its older form has no labels, and the numbers of the corners outside their positions. The
//! positions of the other two are not in them: they are those of the lines `Bed X: … Y: …` of `G29 V4` in the same log, or
//! the caller gives the area. `Subdivided with CATMULL ROM Leveling Grid:` is the grid between whose points Marlin is linear,
//! and is read in place of the bilinear one above it.
//!
//! `Fade Height` in the log: Marlin's correction fades linearly from the bed to nothing at that height.
//!
//! Times, `Recv:`, `READ:`, `<-` and `<<<` before a line are skipped. A point that was not measured (`.`, `NAN`, `===`) is
//! refused: Marlin does not correct the cells around it. Refused are also two meshes that differ, and heights that differ in
//! their decimals, as in a log that was cut off.
//!
//! Source: Marlin, ubl.cpp, bedlevel.cpp, M420.cpp, and the logs of public issues.

use super::Imported;
use super::surface::{Fade, Surface, equidistant, height};
use crate::error::FileError;
use crate::origin::{Origin, numbered};
use std::path::Path;
use trueaxis::error::Figure;

/// Lowest X and Y, highest X and Y, mm.
pub type Area = [f64; 4];

/// A mesh of the log.
struct Mesh {
    line: u32,
    /// One row for every Y upwards.
    rows: Vec<Vec<f64>>,
    /// Whether it is the mesh above it, subdivided.
    is_subdivided: bool,
    /// The area that the mesh states, in whole mm.
    area: Option<Area>,
}

/// A line of a mesh with its fields.
struct Row<'t> {
    line: u32,
    fields: Vec<&'t str>,
}

/// Lines of a log without what the terminal put before them.
type Lines<'t> = std::iter::Peekable<std::vec::IntoIter<(u32, &'t str)>>;

/// Reads the mesh of a log. `area` is that of the mesh, needed if the log does not state it; `file` is only named in errors.
///
/// # Errors
/// No mesh or two different ones, an incomplete one, an area that is missing or that the log contradicts, a height beyond its
/// range: file, line, found, needed.
pub fn import(text: &str, file: &Path, area: Option<Area>) -> Result<Imported, FileError> {
    let origin = &Origin::new(file);
    let all: Vec<(u32, &str)> = numbered(text).map(|(line, text)| (line, bare(text))).collect();
    let touched = touched(&all);
    let stated = all.iter().rev().find_map(|(line, text)| Some((*line, text.split_once("Fade Height ")?.1)));
    let fade = fade(stated, origin)?;
    let mut lines: Lines<'_> = all
        .iter()
        .filter(|(_, text)| !text.starts_with("echo:busy"))
        .copied()
        .collect::<Vec<_>>()
        .into_iter()
        .peekable();
    let mut meshes: Vec<Mesh> = Vec::new();
    while let Some((line, text)) = lines.next() {
        match text {
            "Bilinear Leveling Grid:" => meshes.push(bilinear(line, &mut lines, false, origin)?),
            "Subdivided with CATMULL ROM Leveling Grid:" => meshes.push(bilinear(line, &mut lines, true, origin)?),
            "Bed Topography Report for CSV:" => meshes.push(unified_csv(line, &mut lines, origin)?),
            _ => {
                if let Some(corners) = corners(text) {
                    meshes.push(unified(line, corners, &mut lines, origin)?);
                }
            }
        }
    }
    let mesh = chosen(meshes, origin)?;
    let (columns, count) = (mesh.rows.first().map_or(0, Vec::len), mesh.rows.len());
    let printed = mesh.area.or_else(|| of_touched(&touched, &mesh));
    let is_whole = mesh.area.is_some() && area.is_none();
    let area = match (area, printed) {
        (Some(given), Some(stated))
            if given.iter().zip(&stated).any(|(given, stated)| (given - stated).abs() >= 1.0) =>
        {
            let needed = format!("{}, as the log has it, to less than 1 mm", shown(&stated));
            return Err(origin.at(mesh.line, "", format!("the area {}", shown(&given)), needed));
        }
        (Some(area), _) | (None, Some(area)) => area,
        (None, None) => {
            let needed = "the positions of its points: the log of G29 V4 with its lines Bed X: Y: above the grid, or --area X,Y,X,Y \
                          with the lowest and the highest ones";
            return Err(origin.at(
                mesh.line,
                "",
                format!("a mesh of {columns} by {count} points without an area"),
                needed,
            ));
        }
    };
    let [low_x, low_y, high_x, high_y] = area;
    let nodes = [
        equidistant([low_x, high_x], columns, (mesh.line, "X"), origin)?,
        equidistant([low_y, high_y], count, (mesh.line, "Y"), origin)?,
    ];
    let mut notes =
        vec![format!("{columns} by {count} points over {}: EZ = −height; bilinear between them", shown(&area))];
    if is_whole {
        notes.push(String::from("Marlin prints the corners in whole mm: --area X,Y,X,Y states them better"));
    }
    let heights = mesh.rows.clone();
    Surface { nodes, heights, fade }.imported(&mesh.rows, notes, origin)
}

/// The heights of the fade that the log states.
fn fade(stated: Option<(u32, &str)>, origin: &Origin) -> Result<Option<Fade>, FileError> {
    let Some((line, text)) = stated.map(|(line, text)| (line, text.trim())) else { return Ok(None) };
    if text.eq_ignore_ascii_case("off") {
        return Ok(None);
    }
    let end = origin.number(line, "Fade Height", text)?;
    // 0: no fade.
    Ok((end > 0.0).then_some(Fade { heights: [0.0, end], target: Some(0.0) }))
}

fn shown([low_x, low_y, high_x, high_y]: &Area) -> String {
    format!("X {} to {}, Y {} to {}", Figure(*low_x), Figure(*high_x), Figure(*low_y), Figure(*high_y))
}

/// The mesh of the log: the last one, if all agree.
fn chosen(meshes: Vec<Mesh>, origin: &Origin) -> Result<Mesh, FileError> {
    let mut kept: Vec<Mesh> = Vec::new();
    for mesh in meshes {
        if mesh.is_subdivided {
            kept.pop();
        }
        kept.push(mesh);
    }
    if let [before, mesh] = kept.windows(2).find(|pair| matches!(pair, [a, b] if a.rows != b.rows)).unwrap_or_default()
    {
        let found = format!("a mesh that differs from that on line {}", before.line);
        return Err(origin.at(mesh.line, "", found, "one mesh, or the same one again"));
    }
    kept.pop().ok_or_else(|| {
        origin.whole(
            "no mesh",
            "what Marlin prints for M420 V: Bilinear Leveling Grid:, or the Bed Topography Report of G29 T",
        )
    })
}

/// A line without the time and the direction that a terminal writes before it.
fn bare(line: &str) -> &str {
    let mut rest = line.trim();
    loop {
        let before = rest;
        rest = without_time(rest).trim_start();
        for mark in ["Recv:", "READ:", "<<<", "<-"] {
            rest = rest.strip_prefix(mark).unwrap_or(rest).trim_start();
        }
        if rest == before {
            return rest;
        }
    }
}

/// A line without `21:29:13.047 :`, `[21:29:13]` or `2019-10-09 21:29:13,047 -`.
fn without_time(line: &str) -> &str {
    let open = line.strip_prefix('[').unwrap_or(line);
    let word = |text: &'_ str| text.find(|end: char| end.is_whitespace() || end == ']').unwrap_or(text.len());
    let is = |text: &str, separator: char, parts: usize| {
        text.split(separator).count() == parts
            && text.starts_with(|first: char| first.is_ascii_digit())
            && text.chars().all(|c| c.is_ascii_digit() || c == separator || c == '.' || c == ',')
    };
    let (date, after) = open.split_at(word(open));
    let (time, rest) = if is(date, '-', 3) {
        let after = after.trim_start();
        after.split_at(word(after))
    } else {
        (date, after)
    };
    if !is(time, ':', 3) {
        return line;
    }
    let rest = rest.trim_start_matches(']').trim_start();
    [": ", "- ", "> "].into_iter().find_map(|mark| rest.strip_prefix(mark)).unwrap_or(rest)
}

/// The positions of `Bed X: 20.000 Y: 30.000 Z: 0.012`.
fn touched(lines: &[(u32, &str)]) -> [Vec<f64>; 2] {
    let mut touched: [Vec<f64>; 2] = Default::default();
    for (_, text) in lines {
        let fields: Vec<&str> = text.split_whitespace().collect();
        if let ["Bed", "X:", x, "Y:", y, "Z:", ..] = fields.as_slice()
            && let (Ok(x), Ok(y)) = (x.parse::<f64>(), y.parse::<f64>())
        {
            touched[0].push(x);
            touched[1].push(y);
        }
    }
    for positions in &mut touched {
        positions.sort_by(f64::total_cmp);
        positions.dedup();
    }
    touched
}

/// The area of the probed positions, if they are those of the mesh's points or, in a subdivided one, some of them.
fn of_touched([x, y]: &[Vec<f64>; 2], mesh: &Mesh) -> Option<Area> {
    let fits = |positions: &[f64], count: usize| {
        let cells = positions.len().checked_sub(1).filter(|cells| *cells > 0)?;
        let (low, high) = (*positions.first()?, *positions.last()?);
        let whole = if mesh.is_subdivided { (count - 1).is_multiple_of(cells) } else { count - 1 == cells };
        let even = |(index, at): (usize, &f64)| (low + (high - low) * index as f64 / cells as f64 - at).abs() < 0.02;
        (whole && positions.iter().enumerate().all(even)).then_some([low, high])
    };
    let [low_x, high_x] = fits(x, mesh.rows.first()?.len())?;
    let [low_y, high_y] = fits(y, mesh.rows.len())?;
    Some([low_x, low_y, high_x, high_y])
}

/// Whether the fields number the columns: 0, 1, 2, …
fn are_labels(fields: &[&str]) -> bool {
    !fields.is_empty() && fields.iter().enumerate().all(|(index, field)| *field == index.to_string())
}

/// A grid below `Bilinear Leveling Grid:`: the numbers of the columns, then rows after their number, the lowest Y first.
fn bilinear(start: u32, lines: &mut Lines<'_>, is_subdivided: bool, origin: &Origin) -> Result<Mesh, FileError> {
    let labels: Vec<&str> = lines.peek().map(|(_, text)| text.split_whitespace().collect()).unwrap_or_default();
    if !are_labels(&labels) {
        return Err(origin.at(
            start,
            "",
            "no numbers of the columns below it",
            "the grid as Marlin prints it, 0 1 2 …",
        ));
    }
    lines.next();
    let mut rows = Vec::new();
    while let Some((line, text)) = lines.peek().copied() {
        let mut fields: Vec<&str> = text.split_whitespace().collect();
        if fields.first() != Some(&rows.len().to_string().as_str()) {
            break;
        }
        fields.remove(0);
        rows.push(Row { line, fields });
        lines.next();
    }
    let rows = measured(start, labels.len(), rows, origin)?;
    Ok(Mesh { line: start, rows, is_subdivided, area: None })
}

/// A map below `Bed Topography Report for CSV:`, the highest Y first.
fn unified_csv(start: u32, lines: &mut Lines<'_>, origin: &Origin) -> Result<Mesh, FileError> {
    while lines.next_if(|(_, text)| text.is_empty()).is_some() {}
    let mut rows = Vec::new();
    let is_row = |text: &str| {
        !text.is_empty() && text.split_whitespace().all(|field| field == "NAN" || field.parse::<f64>().is_ok())
    };
    while let Some((line, text)) = lines.next_if(|(_, text)| is_row(text)) {
        rows.push(Row { line, fields: text.split_whitespace().collect() });
    }
    rows.reverse();
    let columns = rows.first().map_or(0, |row| row.fields.len());
    let rows = measured(start, columns, rows, origin)?;
    Ok(Mesh { line: start, rows, is_subdivided: false, area: None })
}

/// The two pairs of numbers of a line with nothing else, `( 20,120)   (220,120)`.
fn corners(text: &str) -> Option<[[f64; 2]; 2]> {
    let pair = |text: &str| {
        let (x, y) = text.trim().strip_prefix('(')?.split_once(',')?;
        Some([x.trim().parse().ok()?, y.trim().parse().ok()?])
    };
    let (left, right) = text.split_once(')')?;
    Some([pair(left)?, pair(right.trim().strip_suffix(')')?)?])
}

/// A map between the lines of its corners, the highest Y first.
fn unified(start: u32, mut top: [[f64; 2]; 2], lines: &mut Lines<'_>, origin: &Origin) -> Result<Mesh, FileError> {
    let mut rows: Vec<Row<'_>> = Vec::new();
    let mut numbers: Vec<&str> = Vec::new();
    let bottom = loop {
        let Some((line, text)) = lines.next() else {
            return Err(origin.at(start, "", "a map without its lower corners", "the map to its end"));
        };
        if let Some(pair) = corners(text) {
            if rows.is_empty() {
                // In the older form the numbers of the corners come first.
                top = pair;
                continue;
            }
            lines.next_if(|(_, text)| corners(text).is_some());
            break pair;
        }
        let (number, fields) =
            text.split_once('|').map_or((None, text), |(number, fields)| (Some(number.trim()), fields));
        let fields: Vec<&str> = fields
            .split(|c: char| c.is_whitespace() || c == '[' || c == ']')
            .filter(|field| !field.is_empty())
            .collect();
        if fields.is_empty() || (number.is_none() && are_labels(&fields)) {
            continue;
        }
        if fields.iter().any(|field| *field != "." && field.parse::<f64>().is_err()) {
            return Err(origin.at(line, "", format!("{text:?}"), "a row of the map, or its lower corners"));
        }
        numbers.extend(number);
        rows.push(Row { line, fields });
    };
    let counted_down = (0..rows.len()).rev().map(|number| number.to_string());
    if !numbers.is_empty() && !counted_down.eq(numbers.iter().map(|number| (*number).to_owned())) {
        let needed = format!("{} to 0, as the rows are numbered", rows.len() - 1);
        return Err(origin.at(start, "", format!("rows {}", numbers.join(" ")), needed));
    }
    let [[left, high], [right, high_right]] = top;
    let [[left_below, low], [right_below, low_right]] = bottom;
    if left != left_below || right != right_below || high != high_right || low != low_right {
        let found = format!("corners {top:?} above and {bottom:?} below");
        return Err(origin.at(start, "", found, "the four corners of a rectangle"));
    }
    rows.reverse();
    let columns = rows.first().map_or(0, |row| row.fields.len());
    let rows = measured(start, columns, rows, origin)?;
    Ok(Mesh { line: start, rows, is_subdivided: false, area: Some([left, low, right, high]) })
}

/// The heights of complete rows.
fn measured(start: u32, columns: usize, rows: Vec<Row<'_>>, origin: &Origin) -> Result<Vec<Vec<f64>>, FileError> {
    if rows.is_empty() {
        return Err(origin.at(start, "", "no heights below it", "the rows of the mesh"));
    }
    let decimals = |field: &str| field.split_once('.').map(|(_, decimals)| decimals.len());
    let first = rows.first().and_then(|row| row.fields.first()).and_then(|field| decimals(field));
    let read = |row: &Row<'_>| {
        if row.fields.len() != columns {
            let found = format!("{} heights", row.fields.len());
            return Err(origin.at(row.line, "", found, format!("{columns}, as in the other rows")));
        }
        let of = |field: &&str| {
            if *field == "." || *field == "NAN" || field.trim_matches('=').is_empty() {
                let needed =
                    "every point measured: Marlin does not correct the cells around it (G29 P3 of UBL fills them)";
                return Err(origin.at(row.line, "", format!("{field:?}, a point without a height"), needed));
            }
            let height = height(row.line, "", field, origin)?;
            if decimals(field) != first {
                let needed = format!("{} decimals, as in the first", first.unwrap_or_default());
                return Err(origin.at(row.line, "", format!("{field:?}"), needed));
            }
            Ok(height)
        };
        row.fields.iter().map(of).collect()
    };
    rows.iter().map(read).collect()
}
