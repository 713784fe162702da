//! Reads the CSV of a grid: one line per node, in any order.

use super::grid_toml::GridReference;
use crate::error::FileError;
use crate::grid::{Grid, GridSource, LINEAR, TooFine};
use crate::origin::Origin;
use crate::sheet::Sheet;
use std::collections::BTreeMap;
use trueaxis::error::Figure;
use trueaxis::machine::{Axis, GRID_NODES, Twist};
use trueaxis::range;

/// A grid, with its separators and decimals if unusual.
pub(crate) struct GridFile {
    pub(crate) grid: Grid,
    pub(crate) dialect: Option<&'static str>,
}

/// Content of a column.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Content {
    Position(usize),
    Error(usize),
}

/// Every permitted column name.
fn known() -> Vec<(String, Content)> {
    let positions = LINEAR.into_iter().enumerate().map(|(k, axis)| (position_name(axis), Content::Position(k)));
    let errors = (0..6).map(|component| (error_name(component), Content::Error(component)));
    positions.chain(errors).collect()
}

pub(crate) fn position_name(axis: Axis) -> String {
    format!("{}_mm", axis.letter())
}

/// Name of an error's column, `EX_um` to `EC_urad`.
pub(crate) fn error_name(component: usize) -> String {
    let letter = Axis::ALL.get(component).map_or('?', |axis| axis.letter());
    format!("E{letter}_{}", if component < 3 { "um" } else { "urad" })
}

fn column(name: &str, line: u32, origin: &Origin) -> Result<Content, FileError> {
    let known = known();
    if let Some((_, content)) = known.iter().find(|(known, _)| known == name) {
        return Ok(*content);
    }
    let stem = |name: &str| name.split_once('_').map_or(name.to_owned(), |(stem, _)| stem.to_owned());
    let needed = match known.iter().find(|(known, _)| stem(known) == stem(name)) {
        Some((meant, _)) => format!("{meant} (the unit is part of the name)"),
        None => format!("one of {}", known.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(" ")),
    };
    Err(origin.at(line, name, format!("{name:?}"), needed))
}

/// The columns: every axis of the grid, at least one error, no duplicates.
fn header(sheet: &Sheet<'_>, axes: &[Axis], origin: &Origin) -> Result<Vec<Content>, FileError> {
    let line = sheet.header_line();
    let mut columns = Vec::new();
    for name in sheet.header() {
        let content = column(name, line, origin)?;
        if columns.contains(&content) {
            return Err(origin.at(line, name, "this column twice", "every column once"));
        }
        if let Content::Position(k) = content
            && !axes.contains(&LINEAR[k])
        {
            let needed = format!("the positions of {} only, the axes of the grid", letters(axes));
            return Err(origin.at(line, name, "an axis that the grid does not have", needed));
        }
        columns.push(content);
    }
    for axis in axes {
        if !columns.iter().any(|content| *content == Content::Position(axis.index())) {
            return Err(origin.at(line, "", "no column with a position", format!("a column {}", position_name(*axis))));
        }
    }
    if !columns.iter().any(|content| matches!(content, Content::Error(_))) {
        return Err(origin.at(line, "", "no column with an error", "at least one, like EZ_um"));
    }
    Ok(columns)
}

fn letters(axes: &[Axis]) -> String {
    axes.iter().map(|axis| axis.letter().to_string()).collect::<Vec<_>>().join(" and ")
}

/// A node as read: mm and rad.
#[derive(Clone, Copy, Default)]
pub(crate) struct Node {
    pub(crate) at: [f64; 3],
    pub(crate) errors: Twist,
    pub(crate) line: u32,
}

/// Reads a grid: `X_mm,Y_mm,EX_um,…`, one line per node in any order, `#` comments and blank lines anywhere.
pub(crate) fn read(text: &[u8], origin: &Origin, reference: &GridReference) -> Result<GridFile, FileError> {
    let mut sheet = Sheet::new(text, origin.file())?;
    let columns = header(&sheet, &reference.axes, origin)?;
    let mut lines = Vec::new();
    while sheet.next_row()? {
        let mut line = Node { at: [0.0; 3], errors: [0.0; 6], line: sheet.line() };
        for (index, content) in columns.iter().enumerate() {
            let given = sheet.number(index)?;
            let name = sheet.header()[index].clone();
            let (range, value) = match content {
                Content::Position(k) => {
                    // Turns −0 into 0.
                    line.at[*k] = given + 0.0;
                    (&range::POSITION.linear, given)
                }
                Content::Error(component) => {
                    let value = given / if *component < 3 { 1e3 } else { 1e6 };
                    line.errors[*component] = value;
                    (if *component < 3 { &range::GRID_TRANSLATION } else { &range::ROTATION }, value)
                }
            };
            if !range.contains(value) {
                return Err(sheet.error(&name, Figure(given), range.needed));
            }
        }
        lines.push(line);
    }
    let given = std::array::from_fn(|component| columns.contains(&Content::Error(component)));
    let grid = of_nodes(&lines, given, reference, position_name, origin)?;
    Ok(GridFile { grid, dialect: sheet.dialect() })
}

/// A grid from its nodes in any order; `column` names the column of an axis' positions.
pub(crate) fn of_nodes(
    nodes: &[Node],
    given: [bool; 6],
    reference: &GridReference,
    column: fn(Axis) -> String,
    origin: &Origin,
) -> Result<Grid, FileError> {
    let source = GridSource {
        given,
        fade_mm: reference.fade_mm,
        measured_at_mm: reference.measured_at_mm,
        resolution: reference.resolution,
        ..complete(nodes, &reference.axes, column, origin)?
    };
    Grid::new(source).map_err(|error| too_fine(origin, &error))
}

/// The error for a resolution that is too fine for 16 bits.
fn too_fine(origin: &Origin, error: &TooFine) -> FileError {
    let (key, unit, scale) =
        if error.component < 3 { ("resolution_um", "um", 1e3) } else { ("resolution_urad", "urad", 1e6) };
    let found = format!("errors of up to {} {unit}", Figure(error.largest * scale));
    let needed =
        format!("errors within 32767 steps of the stated resolution, or {key} = {}", Figure(error.needed * scale));
    origin.at(0, &error_name(error.component), found, needed)
}

/// Nodes along every axis, and the errors of each node, which must occur once.
fn complete(
    lines: &[Node],
    axes: &[Axis],
    column: fn(Axis) -> String,
    origin: &Origin,
) -> Result<GridSource, FileError> {
    let mut source = GridSource::default();
    for axis in axes {
        let k = axis.index();
        let mut at: Vec<(f64, u32)> = lines.iter().map(|line| (line.at[k], line.line)).collect();
        at.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        at.dedup_by_key(|(at, _)| *at);
        let name = column(*axis);
        for pair in at.windows(2) {
            if pair[1].0 - pair[0].0 < range::LEAST_PITCH * (1.0 - 1e-6) {
                let needed =
                    format!("{} as in line {}, or a node at least 0.001 mm from it", Figure(pair[0].0), pair[0].1);
                return Err(origin.at(pair[1].1, &name, Figure(pair[1].0), needed));
            }
        }
        if !(2..=GRID_NODES).contains(&at.len()) {
            let found = format!("{} different positions", at.len());
            return Err(origin.at(0, &name, found, format!("2 to {GRID_NODES} nodes along each axis")));
        }
        source.nodes[k] = at.into_iter().map(|(at, _)| at).collect();
    }
    let number = |at: &[f64; 3]| {
        (0..3).filter(|k| !source.nodes[*k].is_empty()).fold(0, |number, k| {
            let index = source.nodes[k].partition_point(|node| *node < at[k]);
            number * source.nodes[k].len() + index
        })
    };
    let mut known: BTreeMap<usize, &Node> = BTreeMap::new();
    for line in lines {
        if let Some(before) = known.insert(number(&line.at), line) {
            let needed = format!("every node once: line {} already has it", before.line);
            return Err(origin.at(line.line, "", place(&line.at, axes), needed));
        }
    }
    let count = axes.iter().map(|axis| source.nodes[axis.index()].len()).product();
    if let Some(missing) = (0..count).find(|number| !known.contains_key(number)) {
        let (mut rest, mut at) = (missing, [0.0; 3]);
        for axis in axes.iter().rev() {
            let nodes = &source.nodes[axis.index()];
            at[axis.index()] = nodes[rest % nodes.len()];
            rest /= nodes.len();
        }
        let found = format!("{} of {count} nodes, none at {}", known.len(), place(&at, axes));
        return Err(origin.whole(found, "a line for every node of the grid"));
    }
    source.values = known.into_values().map(|line| line.errors).collect();
    Ok(source)
}

/// Position of a node, like `X 10, Y 20`.
fn place(at: &[f64; 3], axes: &[Axis]) -> String {
    axes.iter().map(|axis| format!("{} {}", axis.letter(), Figure(at[axis.index()]))).collect::<Vec<_>>().join(", ")
}
