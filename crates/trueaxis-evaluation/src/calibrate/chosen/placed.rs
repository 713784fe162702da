//! Writes the chosen places into the text of a task.

use super::candidate::Candidate;
use crate::calibrate::artefact::Kind;
use crate::calibrate::task::Task;
use anyhow::{Result, anyhow};
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, Value, value};
use trueaxis::machine::Axis;

/// The task with these places; comments, order and all other keys stay.
pub(super) fn placed(text: &str, task: &Task, chosen: &[&Candidate]) -> Result<String> {
    let file = task.file.display();
    let mut document: DocumentMut = text.parse().map_err(|error| anyhow!("{file}: {error}"))?;
    let list = document.get_mut("artefact").and_then(Item::as_array_of_tables_mut);
    let list = list.ok_or_else(|| anyhow!("{file}: found artefacts in a list, needed sections [[artefact]]"))?;
    for one in chosen {
        let Some(artefact) = list.get_mut(one.artefact) else { continue };
        let places = artefact.entry("place").or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
        if let Some(places) = places.as_array_of_tables_mut() {
            places.push(section(task, one));
        }
    }
    // The file may lack an artefact's section that the choice leaves out: it would be refused without places.
    let without: Vec<usize> =
        (0..list.len()).rev().filter(|k| !list.get(*k).is_some_and(|of| of.contains_key("place"))).collect();
    without.into_iter().for_each(|k| drop(list.remove(k)));
    Ok(document.to_string())
}

fn section(task: &Task, one: &Candidate) -> Table {
    let (mut table, place) = (Table::new(), &one.place);
    let mut at = Array::new();
    place.at_mm.iter().for_each(|q| at.push(*q));
    table.insert("at_mm", value(at));
    let letter = |axis: Axis| value(axis.letter().to_string());
    let kind = &task.artefacts[one.artefact].kind;
    if !matches!(kind, Kind::Ball { .. }) {
        table.insert("normal", letter(place.normal));
    }
    if matches!(kind, Kind::Gauge { .. } | Kind::Square { .. }) {
        table.insert("along", letter(place.along));
    }
    if place.rotary_deg.len() > 1 {
        let pose = |angles: &[f64; 3]| Value::Array(angles.iter().copied().collect());
        table.insert("rotary_deg", value(place.rotary_deg.iter().map(pose).collect::<Array>()));
    }
    if place.reversed {
        table.insert("reversed", value(true));
    }
    if let Some(stylus) = place.stylus_mm {
        table.insert("stylus_mm", value(stylus));
    }
    table
}
