//! The result as text and as JSON.

use super::arguments::Asked;
use serde_json::{Map, Value, json};
use std::fmt::Write;
use trueaxis::machine::{AXES, Axis};
use trueaxis_evaluation::correct::CorrectionAt;
use trueaxis_evaluation::model::name as model;
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
    let _ = writeln!(text, "{}\n", kelvin.replacen(", ", "; above the reference temperature by ", 1));

    let _ = writeln!(text, "{:26}{:>12}{:>12}{:>12}", "", "X", "Y", "Z");
    let mut row = |name: &str, [x, y, z]: [f64; 3], decimals: usize| {
        let [x, y, z] = [x, y, z].map(|value| fixed(value, decimals));
        let _ = writeln!(text, "{name:26}{x:>12}{y:>12}{z:>12}");
    };
    let um = |mm: [f64; 3]| mm.map(|mm| mm * 1e3);
    row("error of the tip, µm", um(found.tip), 3);
    for (source, share) in &found.contributions {
        row(&format!("  of {source}"), um(*share), 3);
    }
    if let Some(rad) = found.orientation {
        row("rotation of the tool, µrad", rad.map(|rad| rad * 1e6), 3);
    }
    row("correction, mm", linear(&found.correction), 6);
    row("command, mm", linear(&command(found)), 6);
    if rotary_axes(found).is_empty() {
        return text;
    }
    text.push('\n');
    let mut row = |name: &str, of: &dyn Fn(Axis) -> String| {
        let cells: String = rotary_axes(found).iter().map(|axis| format!("{:>12}", of(*axis))).collect();
        let _ = writeln!(text, "{name:26}{cells}");
    };
    row("", &|axis| axis.letter().to_string());
    row("correction, °", &|axis| fixed(found.correction[axis.index()], 6));
    row("command, °", &|axis| fixed(command(found)[axis.index()], 6));
    text
}
