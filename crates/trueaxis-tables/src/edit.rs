//! Imports into an existing machine: tables and settings of the imported axes change, everything else stays.

use crate::document::{Edited, editable, same, section, set};
use crate::error::FileError;
use crate::files::{Entry, Source};
use crate::formats::grid_csv::grid_section;
use crate::formats::{Imported, axis_csv_name, grid_csv_name, stated, write_axis_csv, write_grid_csv};
use crate::limits::widened;
use crate::origin::Origin;
use crate::read::{Current, path_from};
use crate::{Grid, Machine, Table};
use std::path::Path;
use toml_edit::{DocumentMut, Item, Value};
use trueaxis::machine::links;
use trueaxis::machine::{Axis, AxisSettings, ErrorModel, LocationErrors, MachineSettings, Row};

impl Imported {
    /// The changes that import these tables into an existing machine; `name` is that of its `machine.toml`.
    ///
    /// A table is added or replaced; a grid is added, or replaced with [`Imported::replaces_grids`]. Settings that the file
    /// states for its axes are set; every other setting, the order and the comments of `machine.toml` stay. The result is
    /// checked as [`Machine::read`] does. Nothing is written.
    ///
    /// # Errors
    /// A machine that cannot be read, or whose chain lacks the axis; a table outside the machine's folder with the name of the
    /// new one; a result that the controller would refuse.
    pub fn edit(&self, machine: &dyn Source, name: &Path) -> Result<Edited, FileError> {
        let current = Current::read(machine, name)?;
        let origin = Origin::new(&machine.path(name));
        in_chain(self, &current, &origin)?;
        let mut document = editable(&current.text, &origin)?;
        let mut edited = Edited { files: Vec::new(), notes: Vec::new() };
        for (axis, table) in &self.tables {
            let csv = table_name(*axis, &current, &origin)?;
            edited.notes.push(change(*axis, table, &current));
            if current.uncertainties.of(*axis).is_some_and(|own| own.columns.iter().any(Option::is_some)) {
                let letter = axis.letter();
                edited.notes.push(format!(
                    "axis {letter}: [axis.{letter}.uncertainty] stays, though it was stated for the previous table"
                ));
            }
            let section = section(&mut document, *axis, &origin)?;
            let is_new = section.iter().all(|(key, _)| key == "limits");
            let mut settings = vec![(String::from("table"), Value::from(csv.as_str()))];
            if is_new {
                settings.extend(stated::of_new_axis(*axis, table));
            }
            settings.extend(self.stated_otherwise(*axis, &current));
            settings.extend(outdated(*axis, table, &current, &mut edited.notes));
            for (key, value) in settings {
                set(section, &key, value);
            }
            edited.files.push((path_from(name, &csv), write_axis_csv(table, *axis)));
        }
        let before = Machine::read_from(machine, name, &mut |_| {}).ok();
        let mut replaced = self.take_out_grids(&current, before.as_ref(), &mut document, &mut edited.notes);
        for grid in &self.grids {
            add_grid(grid, &current, &mut replaced, &mut document, &origin, &mut edited)?;
        }
        location(self, &current, &mut document, &origin, &mut edited.notes)?;
        if let Some(stated) = &self.settings {
            edited.notes.extend(left(stated, &current.settings));
        }
        let Edited { files, notes } = &mut edited;
        let text =
            widened(&document, &current.text, files, (machine, name), before.as_ref(), notes).map_err(|error| {
                let needed = format!("{} (in the machine with the import; nothing is written)", error.needed);
                FileError { needed, ..error }
            })?;
        if text == current.text {
            edited.notes.push(format!("{} stays as it is", origin.file().display()));
        } else {
            edited.files.push((name.into(), text));
        }
        Ok(edited)
    }

    /// Removes from the document the grids that the file's grids replace.
    fn take_out_grids(
        &self,
        current: &Current<'_>,
        before: Option<&Machine>,
        document: &mut DocumentMut,
        notes: &mut Vec<String>,
    ) -> Replaced {
        let mut replaced = Replaced::default();
        let list = document.get_mut("grid").and_then(Item::as_array_of_tables_mut);
        let (true, Some(before), Some(list)) = (self.replaces_grids, before, list) else { return replaced };
        let same = |old: &Grid, new: &Grid| {
            old.header().letters().eq(new.header().letters()) && old.source().given == new.source().given
        };
        for (index, (old, grid)) in current.grids.iter().zip(&before.grids).enumerate() {
            if self.grids.iter().any(|new| same(grid, new)) {
                notes.push(format!("the grid {:?} is replaced", old.file));
                replaced.numbers.push(index);
                replaced.files.insert(0, old.file.clone());
            }
        }
        for index in replaced.numbers.iter().rev() {
            list.remove(*index);
        }
        replaced
    }

    /// Settings of an axis in which the file differs from the machine.
    fn stated_otherwise(&self, axis: Axis, current: &Current<'_>) -> Vec<(String, Value)> {
        let of_axis = |all: &MachineSettings| all.axis(axis).map(stated::of_axis);
        let own = of_axis(&current.settings).unwrap_or_default();
        let unchanged = |stated: &(String, Value)| own.iter().any(|own| own.0 == stated.0 && same(&own.1, &stated.1));
        let stated = self.settings.as_ref().and_then(of_axis).unwrap_or_default();
        stated.into_iter().filter(|stated| !unchanged(stated)).collect()
    }
}

/// Grids of a machine that are being replaced.
#[derive(Default)]
struct Replaced {
    /// Their numbers in the machine.
    numbers: Vec<usize>,
    /// Their files that no new grid has reused yet, the first last.
    files: Vec<String>,
}

/// Adds a grid if the machine has none over the same axes, apart from replaced ones, since grids add up.
fn add_grid(
    grid: &Grid,
    current: &Current<'_>,
    replaced: &mut Replaced,
    document: &mut DocumentMut,
    origin: &Origin,
    edited: &mut Edited,
) -> Result<(), FileError> {
    let axes: Vec<Axis> = grid.header().letters().collect();
    let mut stays = current.grids.iter().enumerate().filter(|(index, _)| !replaced.numbers.contains(index));
    if let Some((_, old)) = stays.find(|(_, old)| old.axes == axes) {
        let needed = "a machine without a grid over these axes, as the two would add up: remove the old one from this file first";
        return Err(origin.at(old.line, &old.key, format!("the grid {:?}", old.file), needed));
    }
    let free = |number: &usize| {
        let csv = path_from(&current.name, &grid_csv_name(*number));
        current.files.entry(&csv) == Entry::Absent && edited.files.iter().all(|(own, _)| *own != csv)
    };
    let csv = replaced.files.pop().unwrap_or_else(|| grid_csv_name((0..).find(free).unwrap_or(0)));
    let mut text = String::new();
    grid_section(&mut text, grid, &csv);
    let no_section = || origin.whole("a grid that is not a list of sections", "sections [[grid]]");
    let new = text.parse::<DocumentMut>().map_err(|error| origin.whole(error.message().to_owned(), "a grid"))?;
    let new = new.get("grid").and_then(Item::as_array_of_tables).and_then(|list| list.get(0)).ok_or_else(no_section)?;
    let mut section = toml_edit::Table::new();
    for (key, item) in new {
        section.insert(key, item.clone());
    }
    let list = document.entry("grid").or_insert_with(|| Item::ArrayOfTables(toml_edit::ArrayOfTables::new()));
    list.as_array_of_tables_mut().ok_or_else(no_section)?.push(section);
    let letters: Vec<String> = axes.iter().map(|axis| axis.letter().to_string()).collect();
    let count = grid.source().values.len();
    edited.notes.push(format!("grid over {} added, {count} nodes", letters.join(" and ")));
    edited.files.push((path_from(&current.name, &csv), write_grid_csv(grid)));
    Ok(())
}

/// Checks that every axis is in the machine and that a chain stated by the file is the machine's.
fn in_chain(imported: &Imported, current: &Current<'_>, origin: &Origin) -> Result<(), FileError> {
    let chain = current.settings.chain.as_str();
    let at = |needed: String| origin.at(line_of(&current.text, "chain"), "chain", format!("{chain:?}"), needed);
    let has = |axis: Axis| current.settings.axis(axis).is_some();
    for (axis, _) in &imported.tables {
        if !has(*axis) {
            let letter = axis.letter();
            return Err(at(format!(
                "axis {letter} in the chain, where it is in the machine ({letter}' on the workpiece's side); or --new and \
                 another folder"
            )));
        }
    }
    let stated = imported.settings.as_ref().map(|settings| settings.chain.as_str());
    if let Some(stated) = stated.filter(|stated| links(stated) != links(chain)) {
        return Err(at(format!("the chain that the imported file states, {stated:?}; or --new and another folder")));
    }
    if let Some((axis, names)) = stated::of_no_axis(&imported.location, has) {
        let letter = axis.letter();
        return Err(at(format!("axis {letter} in the chain, of which the file states {names}; or 0 there")));
    }
    Ok(())
}

/// Line of a key at the top of the file.
fn line_of(text: &str, key: &str) -> u32 {
    let is_key =
        |line: &str| line.trim_start().strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('='));
    (1..).zip(text.lines()).find(|(_, line)| is_key(line)).map_or(0, |(number, _)| number)
}

/// Name of the new table beside `machine.toml`: the old name if it is a file of this folder that only this axis uses.
pub(crate) fn table_name(axis: Axis, current: &Current<'_>, origin: &Origin) -> Result<String, FileError> {
    let files = current.files;
    let at = |name: &str| path_from(&current.name, name);
    let of_others = |name: &str| {
        let mut others = current.tables.iter().filter(|other| other.axis != axis).map(|other| at(&other.name));
        others.any(|other| files.entry(&other).is_file() && files.same(&at(name), &other))
    };
    let old = current.tables.iter().find(|table| table.axis == axis);
    if let Some(old) = old {
        let is_inside = Path::new(&old.name).components().count() == 1;
        let own = matches!(files.entry(&at(&old.name)), Entry::File | Entry::Absent);
        if is_inside && own && !of_others(&old.name) {
            return Ok(old.name.clone());
        }
    }
    let name = axis_csv_name(axis);
    if files.entry(&at(&name)) != Entry::Absent {
        let found = format!("{name} beside it, which is not the table of axis {} alone", axis.letter());
        let (line, key) = old.map_or((0, ""), |old| (old.line, old.key.as_str()));
        let needed = "another name here, or that file moved, so that the imported table can be written";
        return Err(origin.at(line, key, found, needed));
    }
    Ok(name)
}

/// Names of a table's errors, like `EXX EYX`.
fn errors_of(axis: Axis, table: &Table) -> String {
    let given = Axis::ALL.into_iter().zip(table.given).filter(|(_, given)| *given);
    let names: Vec<String> = given.map(|(moved, _)| format!("E{}{}", moved.letter(), axis.letter())).collect();
    format!("{} lines of {}", table.rows.len(), names.join(" "))
}

fn change(axis: Axis, table: &Table, current: &Current<'_>) -> String {
    let (letter, new) = (axis.letter(), errors_of(axis, table));
    match current.tables.iter().find(|old| old.axis == axis) {
        None => format!("axis {letter}: table added, {new}"),
        Some(old) => {
            let before = old.table.as_ref().map_or(String::from("no readable table"), |table| errors_of(axis, table));
            format!("axis {letter}: table replaced, {new} instead of {before}")
        }
    }
}

/// Settings of the old table that would falsify the new one.
fn outdated(axis: Axis, table: &Table, current: &Current<'_>, notes: &mut Vec<String>) -> Vec<(String, Value)> {
    let Some(own) = current.settings.axis(axis) else { return Vec::new() };
    let mut set = Vec::new();
    let (letter, component) = (axis.letter(), axis.index());
    let both = |row: &Row| row.forward.get(component) != row.reverse.get(component);
    let alike = table.rows.iter().all(|row| row.forward == row.reverse);
    if own.backlash != 0.0 && (table.rows.iter().any(both) || (table.bidirectional && alike)) {
        let key = if axis.is_rotary() { "backlash_urad" } else { "backlash_um" };
        notes.push(format!("axis {letter}: {key} set to 0, as both directions of the table contain the lost motion"));
        set.push((String::from(key), Value::from(0.0)));
    }
    let cross = table.given.iter().enumerate().any(|(other, given)| *given && other != component);
    if cross && own.measured_at_mm != [0.0; 3] {
        notes.push(format!("axis {letter}: measured_at_mm set to zero, where the file's errors are valid"));
        set.push((String::from("measured_at_mm"), [0.0; 3].into_iter().collect()));
    }
    set
}

/// Applies the location errors that the file gives.
fn location(
    imported: &Imported,
    current: &Current<'_>,
    document: &mut DocumentMut,
    origin: &Origin,
    notes: &mut Vec<String>,
) -> Result<(), FileError> {
    let given = stated::location(&imported.location);
    if imported.location == LocationErrors::default() || imported.location == current.settings.location {
        return Ok(());
    }
    let section = document.entry("location").or_insert_with(toml_edit::table).as_table_like_mut();
    let section = section.ok_or_else(|| origin.whole("a location that is not a section", "[location]"))?;
    let names: Vec<&str> = given.iter().map(|(key, _)| key.as_str()).collect();
    notes.push(format!("location errors set: {}", names.join(" ")));
    for (key, value) in &given {
        set(section, key, value.clone());
    }
    let kept: Vec<String> = stated::location(&current.settings.location)
        .into_iter()
        .filter(|(key, _)| !given.iter().any(|(own, _)| own == key))
        .map(|(key, _)| key)
        .collect();
    if !kept.is_empty() {
        notes.push(format!("location errors that the file does not give stay: {}", kept.join(" ")));
    }
    Ok(())
}

/// Settings of the machine as a whole in which the file differs.
fn left(stated: &MachineSettings, current: &MachineSettings) -> Vec<String> {
    let model = |settings: &MachineSettings| settings.compensation.model == ErrorModel::Volumetric;
    let differs = [
        ("tool_mm", stated.tool_mm != current.tool_mm),
        ("reference_temperature_c", stated.reference_temperature_c != current.reference_temperature_c),
        ("[compensation] model", model(stated) != model(current)),
        ("[kinematics]", stated.kinematics != current.kinematics),
    ];
    let mut notes: Vec<String> = differs
        .into_iter()
        .filter(|(_, differs)| *differs)
        .map(|(name, _)| format!("{name} stays, though the file states another"))
        .collect();
    let without =
        |axis: &&AxisSettings| current.axes.iter().any(|own| own.axis == axis.axis && own.offset_mm != axis.offset_mm);
    notes.extend(
        stated
            .axes
            .iter()
            .filter(without)
            .filter(|axis| axis.offset_mm == [0.0; 3])
            .map(|axis| format!("axis {}: offset_mm stays, though the file states none", axis.axis.letter())),
    );
    notes
}
