//! The figures of a run as a table: a row for every machine that was simulated.

use serde_json::{Map, Value as Json};
use std::io;
use trueaxis_columns::{Column, Form, Kind, Value, Writer};

/// A value of the document, under the name of its column.
enum Figure {
    Number(f64),
    Whole(i64),
    Text(String),
}

/// The document of `run --json` as Parquet. A figure that it has for every machine (`contour_error_um.compensated.max`) is a
/// column (`contour_error_um_max`) with a row for each; what it has once (settings, cycles, cost of the step) stands in every
/// row. The machine's column is `kind`; lists are texts in JSON, and a figure that a machine has not is a NaN.
///
/// # Errors
/// None but of the memory that it is written to.
pub fn table(document: &Json) -> io::Result<Vec<u8>> {
    let empty = Map::new();
    let document = document.as_object().unwrap_or(&empty);
    // What has a figure of each machine, and who they are.
    let kinds: Vec<&str> = match document.get("contour_error_um") {
        Some(Json::Object(of)) => of.keys().map(String::as_str).collect(),
        _ => Vec::new(),
    };
    let by_machine =
        |value: &Json| value.as_object().is_some_and(|of| of.keys().any(|key| kinds.contains(&key.as_str())));
    let mut columns = vec![Column::new("kind", Kind::Text)];
    let mut rows: Vec<Vec<Figure>> = kinds.iter().map(|kind| vec![Figure::Text((*kind).to_owned())]).collect();
    for (name, value) in document {
        let mut found: Vec<Vec<(String, Figure)>> = Vec::new();
        for kind in &kinds {
            let of = if by_machine(value) { value.get(kind) } else { Some(value) };
            let mut figures = Vec::new();
            of.iter().for_each(|of| flat(name, of, &mut figures));
            found.push(figures);
        }
        let mut names: Vec<(String, Kind)> = Vec::new();
        for (name, figure) in found.iter().flatten() {
            match names.iter_mut().find(|(of, _)| of == name) {
                None => names.push((name.clone(), figure.kind())),
                // Whole for one machine and nothing for another.
                Some((_, kind)) if *kind != figure.kind() => *kind = Kind::Number,
                Some(_) => {}
            }
        }
        for (name, mut kind) in names {
            if kind == Kind::Whole && !found.iter().all(|found| found.iter().any(|(of, _)| *of == name)) {
                kind = Kind::Number;
            }
            for (row, found) in rows.iter_mut().zip(&found) {
                row.push(figure_of(found.iter().find(|(of, _)| *of == name).map(|(_, figure)| figure), kind));
            }
            columns.push(Column { name, kind });
        }
    }
    let mut table = Writer::new(Vec::new(), Form::Parquet, &columns)?;
    for row in &rows {
        table.row(row.iter().map(Figure::value))?;
    }
    table.finish()
}

impl Figure {
    fn kind(&self) -> Kind {
        match self {
            Figure::Number(_) => Kind::Number,
            Figure::Whole(_) => Kind::Whole,
            Figure::Text(_) => Kind::Text,
        }
    }

    fn value(&self) -> Value<'_> {
        match self {
            Figure::Number(value) => Value::Number(*value),
            Figure::Whole(value) => Value::Whole(*value),
            Figure::Text(value) => Value::Text(value),
        }
    }
}

/// A figure as a column of that kind holds it.
fn figure_of(found: Option<&Figure>, kind: Kind) -> Figure {
    match (kind, found) {
        (Kind::Text, Some(Figure::Text(text))) => Figure::Text(text.clone()),
        (Kind::Text, _) => Figure::Text(String::new()),
        (Kind::Whole, Some(Figure::Whole(value))) => Figure::Whole(*value),
        (Kind::Number, Some(Figure::Number(value))) => Figure::Number(*value),
        (Kind::Number, Some(Figure::Whole(value))) => Figure::Number(*value as f64),
        (Kind::Whole | Kind::Number, _) => Figure::Number(f64::NAN),
    }
}

/// Every figure below a name, `name_key_key`.
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
