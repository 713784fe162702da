//! The figures of a run as a table with one row per simulated machine.

use serde_json::{Map, Value as Json};
use std::io;
use trueaxis_columnar::{Column, Form, Kind, Value, Writer};

/// A value of the document.
#[derive(Clone)]
enum Figure {
    Number(f64),
    Whole(i64),
    Text(String),
}

/// The document of `run --json` as Parquet. A figure given per machine (`contour_error_um.compensated.max`) becomes a column
/// (`contour_error_um_max`) with one row each; a figure given once (settings, cycles, cost of the step) is repeated in every
/// row. The column `kind` names the machine; lists are JSON text, and a figure that a machine does not have is NaN.
///
/// # Errors
/// Only an error of the in-memory writer.
pub fn table(document: &Json) -> io::Result<Vec<u8>> {
    let empty = Map::new();
    let document = document.as_object().unwrap_or(&empty);
    // The machines are the keys of the one figure that each of them has.
    let kinds: Vec<&str> = match document.get("contour_error_um") {
        Some(Json::Object(of)) => of.keys().map(String::as_str).collect(),
        _ => Vec::new(),
    };
    let by_machine =
        |value: &Json| value.as_object().is_some_and(|of| of.keys().any(|key| kinds.contains(&key.as_str())));
    let rows: Vec<Vec<(String, Figure)>> = kinds
        .iter()
        .map(|kind| {
            let mut row = vec![("kind".to_owned(), Figure::Text((*kind).to_owned()))];
            for (name, value) in document {
                let of = if by_machine(value) { value.get(kind) } else { Some(value) };
                of.iter().for_each(|of| flat(name, of, &mut row));
            }
            row
        })
        .collect();
    let mut columns: Vec<Column> = Vec::new();
    for (name, _) in rows.iter().flatten() {
        if !columns.iter().any(|column| column.name == *name) {
            columns.push(Column::new(name, kind_of(name, &rows)));
        }
    }
    let mut table = Writer::new(Vec::new(), Form::Parquet, &columns)?;
    for row in &rows {
        table
            .row(columns.iter().map(|column| figure(row, &column.name).map_or(NOTHING, |of| of.value(column.kind))))?;
    }
    table.finish()
}

/// Placeholder for a figure that a machine does not have.
const NOTHING: Value<'static> = Value::Number(f64::NAN);

fn figure<'r>(row: &'r [(String, Figure)], name: &str) -> Option<&'r Figure> {
    row.iter().find(|(of, _)| of == name).map(|(_, figure)| figure)
}

/// Type of a column: numeric unless every machine has the same other type.
fn kind_of(name: &str, rows: &[Vec<(String, Figure)>]) -> Kind {
    let mut kinds = rows.iter().map(|row| figure(row, name).map_or(Kind::Number, Figure::kind));
    let first = kinds.next().unwrap_or(Kind::Number);
    if kinds.all(|kind| kind == first) { first } else { Kind::Number }
}

impl Figure {
    fn kind(&self) -> Kind {
        match self {
            Figure::Number(_) => Kind::Number,
            Figure::Whole(_) => Kind::Whole,
            Figure::Text(_) => Kind::Text,
        }
    }

    /// Converts to the type of the column.
    fn value(&self, kind: Kind) -> Value<'_> {
        match (self, kind) {
            (Figure::Number(value), Kind::Number) => Value::Number(*value),
            (Figure::Whole(value), Kind::Number) => Value::Number(*value as f64),
            (Figure::Whole(value), Kind::Whole) => Value::Whole(*value),
            (Figure::Text(value), Kind::Text) => Value::Text(value),
            _ => NOTHING,
        }
    }
}

/// Flattens every figure below a name to `name_key_key`.
fn flat(name: &str, value: &Json, into: &mut Vec<(String, Figure)>) {
    let figure = match value {
        Json::Object(of) => return of.iter().for_each(|(key, value)| flat(&format!("{name}_{key}"), value, into)),
        Json::Null => Figure::Number(f64::NAN),
        Json::Bool(is) => Figure::Whole((*is).into()),
        Json::Number(of) => of.as_i64().map_or(Figure::Number(of.as_f64().unwrap_or(f64::NAN)), Figure::Whole),
        Json::String(text) => Figure::Text(text.clone()),
        Json::Array(_) => Figure::Text(value.to_string()),
    };
    into.push((name.to_owned(), figure));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_for_every_machine_with_what_all_of_them_have() {
        let document = serde_json::json!({
            "machine": "mill", "cycles": 7, "faults": ["a"], "settings": {"drive": {"gain": 2.5}},
            "contour_error_um": {"plain": {"max": 4.0}, "full": {"max": null}},
            "digest": {"plain": "00ff", "full": "00fe"}, "reversals": {"full": {"X": 3}},
        });
        let row = |figures: &[(&str, Figure)]| -> Vec<(String, Figure)> {
            figures.iter().map(|(name, figure)| ((*name).to_owned(), figure.clone())).collect()
        };
        let rows = [
            row(&[
                ("a", Figure::Whole(1)),
                ("b", Figure::Text("x".into())),
                ("c", Figure::Whole(2)),
                ("d", Figure::Whole(3)),
            ]),
            row(&[("a", Figure::Whole(1)), ("b", Figure::Text("y".into())), ("d", Figure::Number(f64::NAN))]),
        ];
        assert_eq!(
            ["a", "b", "c", "d"].map(|name| kind_of(name, &rows)),
            [Kind::Whole, Kind::Text, Kind::Number, Kind::Number]
        );
        let bytes = table(&document).unwrap();
        assert_eq!(&bytes[..4], b"PAR1");
    }
}
