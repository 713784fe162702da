//! Reads the CSV of one axis.

use super::uncertainty_toml::{Bounds, UM, URAD};
use crate::Table;
use crate::error::FileError;
use crate::origin::Origin;
use crate::sheet::Sheet;
use trueaxis::machine::{Axis, Row};

/// A table with the line of each row and the names of its columns, for errors found only after all of it is read.
pub(super) struct TableFile {
    pub(super) table: Table,
    pub(super) lines: Vec<u32>,
    pub(super) columns: Vec<Column>,
    /// Standard uncertainties of single points, mm and rad, if given.
    pub(super) uncertainty: [Option<Vec<f64>>; 6],
    /// Separators and decimals, if unusual.
    pub(super) dialect: Option<&'static str>,
}

/// Content of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    Position,
    /// Component, and the directions of travel: forward, reverse.
    Error(usize, [bool; 2]),
    /// Component.
    Uncertainty(usize),
}

/// A column, with its name.
pub(super) struct Column {
    pub(super) name: String,
    content: Content,
}

impl Column {
    /// Whether the column gives this component (`None`: the position) in this direction.
    pub(super) fn holds(&self, component: Option<usize>, reverse: bool) -> bool {
        match (self.content, component) {
            (Content::Position, None) => true,
            (Content::Error(own, [forward, backward]), Some(component)) => {
                own == component && if reverse { backward } else { forward }
            }
            _ => false,
        }
    }

    /// The component whose standard uncertainty the column gives.
    pub(super) fn uncertainty(&self) -> Option<usize> {
        if let Content::Uncertainty(component) = self.content { Some(component) } else { None }
    }
}

/// Range of a standard uncertainty of a component.
fn bounds(component: usize) -> &'static Bounds {
    if component < 3 { &UM } else { &URAD }
}

/// Every permitted column name, with its content.
fn known(axis: Axis) -> Vec<Column> {
    let letter = axis.letter();
    let unit = if axis.is_rotary() { "deg" } else { "mm" };
    let mut columns = vec![Column { name: format!("{letter}_{unit}"), content: Content::Position }];
    for (component, direction) in Axis::ALL.into_iter().enumerate() {
        let (error, unit) = (format!("E{}{letter}", direction.letter()), if component < 3 { "um" } else { "urad" });
        for (travel, directions) in [("", [true, true]), ("_fwd", [true, false]), ("_rev", [false, true])] {
            let content = Content::Error(component, directions);
            columns.push(Column { name: format!("{error}{travel}_{unit}"), content });
        }
        columns.push(Column { name: format!("{error}_u_{unit}"), content: Content::Uncertainty(component) });
    }
    columns
}

fn column(axis: Axis, name: &str, line: u32, origin: &Origin) -> Result<Column, FileError> {
    let mut known = known(axis);
    if let Some(index) = known.iter().position(|column| column.name == name) {
        return Ok(known.swap_remove(index));
    }
    let stem = |name: &str| name.rsplit_once('_').map_or(name.to_owned(), |(stem, _)| stem.to_owned());
    let without_unit = known.iter().find(|column| stem(&column.name) == name);
    let meant = without_unit.or_else(|| known.iter().find(|column| stem(&column.name) == stem(name)));
    let needed = match meant {
        Some(column) => format!("{} (the unit is part of the name)", column.name),
        None => {
            let plain: Vec<&str> = known
                .iter()
                .filter(|column| matches!(column.content, Content::Position | Content::Error(_, [true, true])))
                .map(|column| column.name.as_str())
                .collect();
            format!("one of {}, or a pair like {} and {}", plain.join(" "), known[2].name, known[3].name)
        }
    };
    Err(origin.at(line, name, format!("{name:?}"), needed))
}

fn header(axis: Axis, names: &[String], line: u32, origin: &Origin) -> Result<Vec<Column>, FileError> {
    let mut columns: Vec<Column> = Vec::new();
    for name in names {
        let next = column(axis, name, line, origin)?;
        for before in &columns {
            let clash = match (before.content, next.content) {
                (Content::Position, Content::Position) => true,
                (Content::Error(a, [af, ar]), Content::Error(b, [bf, br])) => a == b && (af && bf || ar && br),
                (Content::Uncertainty(a), Content::Uncertainty(b)) => a == b,
                _ => false,
            };
            if clash {
                let found = format!("both {} and {name}", before.name);
                return Err(origin.at(line, name, found, "every error once: one column, or one for each direction"));
            }
        }
        columns.push(next);
    }
    if !columns.iter().any(|column| column.content == Content::Position) {
        let needed = format!("a column {}", known(axis)[0].name);
        return Err(origin.at(line, "", "no column with the position", needed));
    }
    if !columns.iter().any(|column| matches!(column.content, Content::Error(..))) {
        return Err(origin.at(
            line,
            "",
            "no column with an error",
            format!("at least one, like {}", known(axis)[1].name),
        ));
    }
    for column in &columns {
        if let Some(component) = column.uncertainty()
            && !columns.iter().any(|other| other.holds(Some(component), false))
        {
            let error = column.name.replace("_u_", "_");
            return Err(origin.at(
                line,
                &column.name,
                "an uncertainty without its error",
                format!("a column {error} as well"),
            ));
        }
        let Content::Error(component, directions) = column.content else { continue };
        for (reverse, given) in [(false, directions[0]), (true, directions[1])] {
            if !given && !columns.iter().any(|other| other.holds(Some(component), reverse)) {
                let partner =
                    if reverse { column.name.replace("_fwd_", "_rev_") } else { column.name.replace("_rev_", "_fwd_") };
                return Err(origin.at(line, &column.name, "one direction only", format!("a column {partner} as well")));
            }
        }
    }
    Ok(columns)
}

/// Reads a table: `X_mm,EXX_um,…`, `#` comments and blank lines anywhere; separators and decimals as for [`Sheet`].
///
/// Errors are µm / 1e3 and µrad / 1e6, so that a value is the double nearest to the decimal in mm or rad.
pub(super) fn read(text: &[u8], origin: &Origin, axis: Axis) -> Result<TableFile, FileError> {
    let mut sheet = Sheet::new(text, origin.file()).map_err(|error| match error.found.as_str() {
        "no header" => origin.whole("nothing but comments", format!("a header line, like {}", example(axis))),
        _ => error,
    })?;
    let columns = header(axis, sheet.header(), sheet.header_line(), origin)?;
    let mut given = [false; 6];
    for column in &columns {
        if let Content::Error(component, _) = column.content {
            given[component] = true;
        }
    }
    let (mut rows, mut lines) = (Vec::new(), Vec::new());
    let mut uncertainty: [Option<Vec<f64>>; 6] = Default::default();
    while sheet.next_row()? {
        let mut row = Row { position: 0.0, forward: [0.0; 6], reverse: [0.0; 6] };
        for (index, column) in columns.iter().enumerate() {
            let value = sheet.number(index)?;
            match column.content {
                Content::Position => row.position = value,
                Content::Uncertainty(component) => {
                    let bounds = bounds(component);
                    if !bounds.contains(value) {
                        return Err(origin.at(sheet.line(), &column.name, value, bounds.needed));
                    }
                    let value = value / if component < 3 { 1e3 } else { 1e6 };
                    uncertainty[component].get_or_insert_default().push(value);
                }
                Content::Error(component, [forward, reverse]) => {
                    let value = value / if component < 3 { 1e3 } else { 1e6 };
                    if forward {
                        row.forward[component] = value;
                    }
                    if reverse {
                        row.reverse[component] = value;
                    }
                }
            }
        }
        rows.push(row);
        lines.push(sheet.line());
    }
    let bidirectional = rows.iter().any(|row| row.forward != row.reverse);
    let dialect = sheet.dialect();
    let table = Table { given, bidirectional, rows };
    Ok(TableFile { table, lines, columns, uncertainty, dialect })
}

fn example(axis: Axis) -> String {
    let known = known(axis);
    format!("{},{}", known[0].name, known[1].name)
}
