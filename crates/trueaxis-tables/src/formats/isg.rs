//! Volumetric compensation file of the ISG kernel and Beckhoff TwinCAT CNC (TF5280), "ISG CSV".
//!
//! ```text
//! // line comment
//! A0Z  B0Z  C0Y                               location errors, one line of values, rad
//! 2e-5 0    3e-5
//! #                                           begins another header
//! X    EXX  EYX  EZX  EAX  EBX  ECX           one argument and the six errors of its axis
//! 0    0.02 0.01 0.07 0    0.0042 0.003
//! ```
//!
//! Units: errors in mm and rad, arguments in mm and, for rotary axes, degrees (infosys.beckhoff.com, TF5280, "Units of
//! measure", "ISG CSV format", "List of parameters supported"). Columns are separated by blanks or tabs (written: tabs);
//! commas and semicolons are also read.
//!
//! Sign: both sides name the errors after ISO 230-1 and the values pass unchanged, error = actual − ideal. The tables of this
//! crate hold, for every axis, the error of the tool relative to the workpiece. Whether the other control treats an axis that
//! carries the workpiece in the same sense depends on its parameter `workpiece_axes`: check one known error on the machine.
//! The format calls a location error `X0C`, this crate `EX0C`. This crate knows only `A0Z`, `B0Z`, `C0Y` of the linear axes
//! and all six of the rotary ones; others must be 0.
//!
//! The errors apply to a tool of length zero, with the other linear and the rotary axes at zero. Tables measured elsewhere
//! (`measured_at_mm`) are converted to that, e = e_measured − w × l at every line.
//!
//! Chain, senses, tool, offsets, interpolation and `[compensation]` have no columns. Comments carry them and are read back:
//!
//! ```text
//! // trueaxis chain: w C' A' Y' b X Z t       w, axes that carry the workpiece, b, axes that carry the tool, t
//! // trueaxis tool_mm: 0 0 -250               also tool_axis, singular_cone_deg, reference_temperature_c,
//! // trueaxis model: volumetric               orientation, fade_deg
//! // trueaxis axis A direction: -1            also interpolation, lookup, cross_lookup, travel_mm (travel_deg)
//! // trueaxis axis A offset_mm: 0 0 150
//! ```
//!
//! The other control skips the comments; the settings that it needs in addition are in [`Exported::notes`]. A file with such
//! comments is refused if one of them cannot be read, or if an axis of a comment, table or location error is not in the chain.
//!
//! A table over two or three linear axes becomes a grid: its EX, EY and EZ, whichever axis they belong to, are those of the
//! nodes. Angles over several axes are refused, because their lever is defined by the other control. Read only: grids are not
//! written.
//!
//! The format has no direction of travel (the mean is written), backlash or thermal growth. Tables over several arguments of
//! which one is rotary, constant component errors and the kinematic parameters of the ISG model are refused.

use super::{ExportOptions, Exported, Imported, decimal, isg_notes, losses, measured_at, own_comments, positioning};
use crate::error::FileError;
use crate::grid::Grid;
use crate::origin::{Origin, numbered};
use crate::read::grid_table::{self, Node};
use crate::read::grid_toml::GridReference;
use crate::text::{counted, fixed};
use crate::{Machine, Table};
use std::collections::BTreeMap;
use std::fmt::Write;
use trueaxis::machine::{Axis, LocationErrors, MachineSettings, Row};
use trueaxis::range;

/// Name of the written file.
pub const FILE_NAME: &str = "volcomp.csv";

/// A header with its lines of values.
struct Block {
    line: u32,
    names: Vec<String>,
    lines: Vec<(u32, Vec<f64>)>,
}

pub(super) fn import(text: &str, origin: &Origin, only: Option<Axis>) -> Result<Imported, FileError> {
    let mut tables: BTreeMap<Axis, Table> = BTreeMap::new();
    let mut location = LocationErrors::default();
    let mut grids: Vec<Grid> = Vec::new();
    let mut settings = own_comments::read(text, origin)?;
    for block in blocks(text, origin)? {
        in_chain(&block, settings.as_ref(), origin)?;
        let arguments: Vec<Axis> = block.names.iter().filter_map(|name| axis_named(name)).collect();
        match arguments.as_slice() {
            [] => location_errors(&block, origin, &mut location)?,
            [axis] => {
                let table = component_errors(&block, *axis, origin)?;
                if only.is_none_or(|only| only == *axis) && tables.insert(*axis, table).is_some() {
                    let found = format!("a second table of axis {}", axis.letter());
                    return Err(origin.at(block.line, "", found, "one per axis"));
                }
            }
            // A grid does not belong to any single axis.
            _ if only.is_some() => {}
            axes => {
                let grid = grid(&block, axes, origin)?;
                if grids.iter().any(|other: &Grid| other.header().letters().eq(grid.header().letters())) {
                    let needed = "one over the same axes, with the errors of all of them";
                    return Err(origin.at(block.line, "", "a second table over these axes", needed));
                }
                grids.push(grid);
            }
        }
    }
    if tables.is_empty() && grids.is_empty() {
        let found = match only {
            Some(axis) => format!("no component errors of axis {}", axis.letter()),
            None => String::from("no component errors"),
        };
        return Err(origin.whole(found, "a header such as X EXX EYX EZX EAX EBX ECX and its values"));
    }
    if let Some(settings) = &mut settings {
        settings.location = location;
    }
    Ok(Imported { tables: tables.into_iter().collect(), grids, location, settings, ..Imported::default() })
}

/// If a file gives the chain, every axis of a header and every rotary axis with a location error has to be in it.
fn in_chain(block: &Block, settings: Option<&MachineSettings>, origin: &Origin) -> Result<(), FileError> {
    let Some(settings) = settings else { return Ok(()) };
    let values = block.lines.first().map_or(&[][..], |(_, values)| values);
    for (column, name) in block.names.iter().enumerate() {
        let letters: Vec<char> = name.chars().collect();
        let axis = match letters.as_slice() {
            [axis] => Axis::from_letter(*axis),
            [_, '0', axis] if values.get(column) != Some(&0.0) => {
                Axis::from_letter(*axis).filter(|axis| axis.is_rotary())
            }
            _ => None,
        };
        if let Some(axis) = axis
            && !settings.axes.iter().any(|own| own.axis == axis)
        {
            let found = format!("axis {}, which is not in the chain {}", axis.letter(), settings.chain);
            return Err(origin.at(block.line, name, found, "an axis of the chain"));
        }
    }
    Ok(())
}

fn blocks(text: &str, origin: &Origin) -> Result<Vec<Block>, FileError> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut expect_header = true;
    for (line, content) in numbered(text) {
        let content = content.split_once("//").map_or(content, |(before, _)| before).trim();
        if content.starts_with('#') {
            expect_header = true;
            continue;
        }
        if content.is_empty() {
            continue;
        }
        let fields: Vec<&str> = content
            .split(|separator: char| separator.is_whitespace() || separator == ',' || separator == ';')
            .filter(|field| !field.is_empty())
            .collect();
        if expect_header {
            let names: Vec<String> = fields.iter().map(|&name| name.to_owned()).collect();
            if let Some(name) =
                names.iter().enumerate().find(|(k, name)| names.iter().take(*k).any(|before| before == *name))
            {
                return Err(origin.at(line, name.1, "the column twice", "it once"));
            }
            blocks.push(Block { line, names, lines: Vec::new() });
            expect_header = false;
            continue;
        }
        let Some(block) = blocks.last_mut() else { continue };
        if fields.len() != block.names.len() {
            let found = counted(fields.len(), "value");
            return Err(origin.at(
                line,
                "",
                found,
                format!("{}, as in the header of line {}", block.names.len(), block.line),
            ));
        }
        let values = block.names.iter().zip(&fields).map(|(name, text)| origin.number(line, name, text));
        let values = values.collect::<Result<Vec<f64>, FileError>>()?;
        block.lines.push((line, values));
    }
    Ok(blocks)
}

/// The axis that an argument X to C names.
fn axis_named(name: &str) -> Option<Axis> {
    let mut letters = name.chars();
    letters.next().and_then(Axis::from_letter).filter(|_| letters.next().is_none())
}

/// Component and axis of a name like `EXY`: (0, Y).
fn component_named(name: &str) -> Option<(usize, Axis)> {
    let letters: Vec<char> = name.chars().collect();
    match letters.as_slice() {
        ['E', direction, axis] => Some((Axis::from_letter(*direction)?.index(), Axis::from_letter(*axis)?)),
        _ => None,
    }
}

fn component_errors(block: &Block, axis: Axis, origin: &Origin) -> Result<Table, FileError> {
    let mut given = [false; 6];
    let mut columns: Vec<Option<usize>> = Vec::new();
    for name in &block.names {
        if axis_named(name).is_some() {
            columns.push(None);
            continue;
        }
        let Some((component, _)) = component_named(name).filter(|(_, moved)| *moved == axis) else {
            let needed = format!("errors of axis {0}, EX{0} to EC{0}, in a table over {0}", axis.letter());
            return Err(origin.at(block.line, name, format!("column {name:?}"), needed));
        };
        if let Some(flag) = given.get_mut(component) {
            *flag = true;
        }
        columns.push(Some(component));
    }
    if given == [false; 6] {
        return Err(origin.at(block.line, "", "no error beside the position", "at least one column"));
    }
    let mut lines = Vec::with_capacity(block.lines.len());
    for (line, values) in &block.lines {
        let mut position = 0.0;
        let mut errors = [0.0; 6];
        for (column, value) in columns.iter().zip(values) {
            match column {
                None => position = *value,
                Some(component) => {
                    if let Some(error) = errors.get_mut(*component) {
                        *error = decimal::as_in_a_table(*value, if *component < 3 { 1e3 } else { 1e6 });
                    }
                }
            }
        }
        lines.push((*line, Row { position, forward: errors, reverse: errors }));
    }
    super::table(axis, given, lines, origin)
}

/// A table over several arguments: nodes and their translations.
fn grid(block: &Block, arguments: &[Axis], origin: &Origin) -> Result<Grid, FileError> {
    let mut axes = arguments.to_vec();
    axes.sort_by_key(|axis| axis.index());
    if axes.iter().any(|axis| axis.is_rotary()) {
        let letters: Vec<String> = axes.iter().map(|axis| axis.letter().to_string()).collect();
        let found = format!("a table over {}", letters.join(" and "));
        return Err(origin.at(block.line, "", found, "linear axes alone, or one argument: the axis' own position"));
    }
    let mut given = [false; 6];
    let mut nodes: Vec<Node> = block.lines.iter().map(|(line, _)| Node { line: *line, ..Node::default() }).collect();
    for (column, name) in block.names.iter().enumerate() {
        let values = block.lines.iter().filter_map(|(line, values)| Some((*line, *values.get(column)?)));
        if let Some(axis) = axis_named(name) {
            for (node, (line, value)) in nodes.iter_mut().zip(values) {
                super::within(origin, line, name, value, &range::POSITION.linear)?;
                // Turns −0 into 0.
                if let Some(at) = node.at.get_mut(axis.index()) {
                    *at = value + 0.0;
                }
            }
            continue;
        }
        let Some((component, _)) = component_named(name).filter(|(_, moved)| !moved.is_rotary()) else {
            let needed = "an error of X, Y or Z, such as EXX, in a table over several axes";
            return Err(origin.at(block.line, name, format!("column {name:?}"), needed));
        };
        if component >= 3 {
            if let Some((line, angle)) = values.into_iter().find(|(_, angle)| *angle != 0.0) {
                let needed =
                    "0, or a table over one axis: over several, only EX, EY and EZ are read, as they act at the tool";
                return Err(origin.at(line, name, angle, needed));
            }
            continue;
        }
        if let Some(flag) = given.get_mut(component) {
            *flag = true;
        }
        for (node, (line, value)) in nodes.iter_mut().zip(values) {
            let value = decimal::as_in_a_table(value, 1e3);
            super::within(origin, line, name, value, &range::GRID_TRANSLATION)?;
            if let Some(error) = node.errors.get_mut(component) {
                *error += value;
            }
        }
    }
    if given == [false; 6] {
        return Err(origin.at(block.line, "", "no error beside the positions", "at least one of EX, EY and EZ"));
    }
    grid_table::of_nodes(&nodes, given, &GridReference::of_axes(axes), |axis| axis.letter().to_string(), origin)
}

fn location_errors(block: &Block, origin: &Origin, location: &mut LocationErrors) -> Result<(), FileError> {
    let [(line, values)] = block.lines.as_slice() else {
        let found = format!("{} of values without an argument", counted(block.lines.len(), "line"));
        return Err(origin.at(block.line, "", found, "one line of location errors"));
    };
    for (name, value) in block.names.iter().zip(values) {
        match location_entry(location, name) {
            Some(entry) => *entry = *value,
            None if component_named(name).is_some() => {
                let needed = "the axis position as the first column";
                return Err(origin.at(block.line, name, "a component error without an argument", needed));
            }
            None if is_location_error(name) && *value == 0.0 => {}
            None => {
                let needed = "A0Z, B0Z, C0Y, or X0r to C0r of a rotary axis r; other parameters 0 or absent";
                return Err(origin.at(*line, name, value, needed));
            }
        }
    }
    Ok(())
}

/// Whether the name is a location error, like `X0Y`.
fn is_location_error(name: &str) -> bool {
    let letters: Vec<char> = name.chars().collect();
    matches!(letters.as_slice(), [direction, '0', axis]
        if Axis::from_letter(*direction).is_some() && Axis::from_letter(*axis).is_some())
}

fn location_entry<'a>(location: &'a mut LocationErrors, name: &str) -> Option<&'a mut f64> {
    match name {
        "A0Z" => return Some(&mut location.a0z),
        "B0Z" => return Some(&mut location.b0z),
        "C0Y" => return Some(&mut location.c0y),
        _ => {}
    }
    let letters: Vec<char> = name.chars().collect();
    let [direction, '0', axis] = letters.as_slice() else { return None };
    let axis = Axis::from_letter(*axis)?.index().checked_sub(Axis::A.index())?;
    let component = Axis::from_letter(*direction)?.index();
    location.rotary.get_mut(axis)?.get_mut(component)
}

pub(super) fn export(machine: &Machine, options: &ExportOptions, exported: &mut Exported) {
    let mut text = own_comments::written(machine);
    let mut location = machine.settings.location;
    if options.axis.is_some() {
        // The location errors belong to the machine, so a file of one axis does not carry them.
        losses::location_losses(machine, &mut exported.dropped);
        location = LocationErrors::default();
    }
    let entries = location_table(&mut location);
    let mut begun = !entries.is_empty();
    if !entries.is_empty() {
        let (names, values): (Vec<String>, Vec<String>) =
            entries.into_iter().map(|(name, value)| (name, format!("{value}"))).unzip();
        let _ = writeln!(text, "// location errors, mm and rad\n{}\n{}", names.join("\t"), values.join("\t"));
    }
    for (settings, table) in positioning::chosen(machine, options.axis) {
        if begun {
            text.push_str("#\n");
        }
        begun = true;
        let moved = measured_at::at_zero(machine, settings, table);
        let table = moved.as_ref();
        if settings.measured_at_mm != [0.0; 3] {
            exported.notes.push(isg_notes::measured(settings));
        }
        one_way(machine, settings, table, &mut exported.dropped);
        // From the unit of the axis' positions to that of its error table, mm or rad.
        let backlash = settings.backlash / positioning::to_position_unit(machine, settings);
        axis_block(settings.axis, backlash, table, &mut text);
    }
    losses::settings_losses(machine, options.axis, &mut exported.dropped);
    exported.notes.push(format!("file_format of {FILE_NAME}: ISG CSV; workpiece_axes as the tables were measured"));
    isg_notes::machine(&machine.settings, &mut exported.notes);
    exported.files.push((String::from(FILE_NAME), text));
}

fn location_table(location: &mut LocationErrors) -> Vec<(String, f64)> {
    let mut names = vec![String::from("A0Z"), String::from("B0Z"), String::from("C0Y")];
    for axis in ['A', 'B', 'C'] {
        names.extend(Axis::ALL.into_iter().map(|direction| format!("{}0{axis}", direction.letter())));
    }
    names
        .into_iter()
        .filter_map(|name| {
            let value = location_entry(location, &name).map_or(0.0, |entry| *entry);
            (value != 0.0).then_some((name, value))
        })
        .collect()
}

/// Lists the losses of the mean of both directions: in the own error with its backlash, and in the others.
fn one_way(machine: &Machine, settings: &trueaxis::machine::AxisSettings, table: &Table, dropped: &mut Vec<String>) {
    let points = positioning::points(machine, settings, table);
    positioning::mean_of_directions(settings, &points, dropped);
    let names: Vec<String> = (0..6)
        .filter(|component| *component != settings.axis.index())
        .filter(|component| table.rows.iter().any(|row| row.forward.get(*component) != row.reverse.get(*component)))
        .map(|component| positioning::error_name(settings.axis, component))
        .collect();
    if !names.is_empty() {
        dropped.push(format!("difference between the directions of {} (the mean is written)", names.join(", ")));
    }
}

fn axis_block(axis: Axis, backlash: f64, table: &Table, text: &mut String) {
    let _ = write!(
        text,
        "// axis {}: {}, errors in mm and rad\n{}",
        axis.letter(),
        if axis.is_rotary() { "degrees" } else { "mm" },
        axis.letter()
    );
    let columns: Vec<usize> = (0..6).filter(|component| table.given.get(*component) == Some(&true)).collect();
    for component in &columns {
        let _ = write!(text, "\t{}", positioning::error_name(axis, *component));
    }
    text.push('\n');
    for row in &table.rows {
        let _ = write!(text, "{}", row.position);
        for component in &columns {
            let half_backlash = if *component == axis.index() { 0.5 * backlash } else { 0.0 };
            let (forward, reverse) = (row.forward.get(*component), row.reverse.get(*component));
            let mean = 0.5 * (forward.unwrap_or(&0.0) + reverse.unwrap_or(&0.0)) + half_backlash;
            let decimals = if *component < 3 { 6 } else { 9 };
            let _ = write!(text, "\t{}", fixed(mean, decimals));
        }
        text.push('\n');
    }
}
