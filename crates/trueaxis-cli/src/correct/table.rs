//! The result as text and as JSON.

use super::arguments::Asked;
use serde_json::{Map, Value, json};
use std::fmt::Write;
use trueaxis::machine::{AXES, Axis};
use trueaxis_evaluation::correct::CorrectionAt;
use trueaxis_evaluation::model::name as model;
use trueaxis_evaluation::shown::{Cell, Table};
use trueaxis_tables::Machine;
use trueaxis_tables::text::{fixed, short};

fn linear(values: &[f64; AXES]) -> [f64; 3] {
    [values[0], values[1], values[2]]
}

fn command(found: &CorrectionAt) -> [f64; AXES] {
    std::array::from_fn(|index| found.at[index] + found.correction[index])
}

fn rotary_axes(found: &CorrectionAt) -> &[Axis] {
    found.axes.get(3..).unwrap_or_default()
}

pub(super) fn document(machine: &Machine, found: &CorrectionAt) -> Value {
    let um = |mm: [f64; 3]| mm.map(|mm| mm * 1e3);
    let letters = |axes: &[Axis]| axes.iter().map(|axis| axis.letter().to_string()).collect::<Vec<_>>();
    let contributions = found.contributions.iter();
    let mut document = json!({
        "machine": machine.settings.name.as_str(),
        "model": model(machine.settings.compensation.model),
        "at_mm": linear(&found.at),
        "error_um": um(found.tip),
        "correction_mm": linear(&found.correction),
        "command_mm": linear(&command(found)),
        "contributions": contributions
            .map(|(source, mm)| json!({ "source": source, "error_um": um(*mm) }))
            .collect::<Vec<_>>(),
        "clamped": letters(&found.clamped),
        "out_of_travel": letters(&found.out_of_travel),
        "clipped": letters(&found.clipped.axes().collect::<Vec<_>>()),
    });
    if let Some(rad) = found.orientation {
        document["error_urad"] = json!(rad.map(|rad| rad * 1e6));
    }
    if !rotary_axes(found).is_empty() {
        let values = [("at_deg", found.at), ("correction_deg", found.correction), ("command_deg", command(found))];
        for (key, values) in values {
            let by_letter: Map<String, Value> =
                rotary_axes(found).iter().map(|axis| (axis.letter().into(), json!(values[axis.index()]))).collect();
            document[key] = by_letter.into();
        }
    }
    document
}

pub(super) fn text(machine: &Machine, asked: &Asked, found: &CorrectionAt) -> String {
    let settings = &machine.settings;
    let mut text =
        format!("{}   {}, error model {}\n", settings.name, settings.chain, model(machine.settings.compensation.model));
    let list =
        |axes: &[Axis], of: &dyn Fn(Axis) -> String| axes.iter().map(|axis| of(*axis)).collect::<Vec<_>>().join(", ");
    let at = |axes| list(axes, &|axis| format!("{} {}", axis.letter(), short(found.at[axis.index()])));
    let slides = found.axes.get(..3).unwrap_or_default();
    let rotary =
        if rotary_axes(found).is_empty() { String::new() } else { format!("; {} degrees", at(rotary_axes(found))) };
    let middle = if asked.is_middle { " (middle of the travel)" } else { "" };
    let _ = writeln!(text, "at {} mm{rotary}{middle}", at(slides));
    let sign = |axis: Axis| if asked.query.reverse[axis.index()] { '-' } else { '+' };
    let _ = write!(text, "travel {}", list(&found.axes, &|axis| format!("{}{}", sign(axis), axis.letter())));
    let kelvin = if asked.query.kelvin == 0.0 { String::new() } else { format!(", {} K", short(asked.query.kelvin)) };
    let _ = writeln!(text, "{}", kelvin.replacen(", ", "; above the reference temperature by ", 1));
    text += &linear_axes(found).to_string();
    if !rotary_axes(found).is_empty() {
        let row = |name: &str, values: &[f64; AXES]| {
            let values = rotary_axes(found).iter().map(|axis| cell(values[axis.index()], 6));
            std::iter::once(name.into()).chain(values).collect()
        };
        let rows = [row("correction, °", &found.correction), row("command, °", &command(found))];
        let header = rotary_axes(found).iter().map(|axis| axis.letter().to_string());
        text += &Table::new("", std::iter::once(String::new()).chain(header), rows).to_string();
    }
    text
}

/// With a plain minus sign: commands are copied from here to a control.
fn cell(value: f64, decimals: usize) -> Cell {
    Cell::Number { text: fixed(value, decimals), value }
}

fn linear_axes(found: &CorrectionAt) -> Table {
    let row = |name: String, values: [f64; 3], decimals| {
        std::iter::once(name.into()).chain(values.map(|value| cell(value, decimals))).collect()
    };
    let um = |mm: [f64; 3]| mm.map(|mm| mm * 1e3);
    let sources = found.contributions.iter().map(|(source, share)| row(format!("  of {source}"), um(*share), 3));
    let rotation = found.orientation.map(|rad| row("rotation of the tool, µrad".into(), rad.map(|rad| rad * 1e6), 3));
    let rows = [row("error of the tip, µm".into(), um(found.tip), 3)].into_iter().chain(sources).chain(rotation);
    let commands = [
        row("correction, mm".into(), linear(&found.correction), 6),
        row("command, mm".into(), linear(&command(found)), 6),
    ];
    Table::new("", ["", "X", "Y", "Z"], rows.chain(commands))
}
