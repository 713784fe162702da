//! `trueaxis tables accuracy`: ISO 230-2 before and after compensation.

use crate::model;
use crate::output::{json, print, tell};
use anyhow::Result;
use std::fmt::Write;
use std::path::Path;
use trueaxis::Axis;
use trueaxis_evaluation::accuracy::{Document, evaluate, read};
use trueaxis_metrology::accuracy::Accuracy;
use trueaxis_tables::text::counted;

pub(crate) fn run(file: &Path, axis: Option<Axis>, machine: Option<&Path>, as_json: bool) -> Result<()> {
    let text = model::text(file)?;
    let measurement = read(&text, file, axis, &mut |how| tell(format_args!("note: {how}")))?;
    // Errors in the measurement are reported before those in the machine.
    let Document { measured, .. } = evaluate(&measurement, file, None)?;
    let compensated = match machine {
        None => None,
        Some(path) => evaluate(&measurement, file, Some((&model::machine(path)?, path)))?.compensated,
    };
    if as_json {
        return json(&Document { measured, compensated });
    }
    print(&table(&measured, compensated.as_ref())?)
}

fn table(measured: &Accuracy, compensated: Option<&Accuracy>) -> Result<String> {
    let unit = if measured.unit == "um" { "µm" } else { "µrad" };
    let mut text = format!(
        "axis {}, {}, {}; ISO 230-2:2014, values in {unit}\n\n",
        measured.axis,
        counted(measured.positions.len(), "target position"),
        counted(measured.runs, "run")
    );
    writeln!(text, "{:<46}{:>10}{}", "", "measured", if compensated.is_some() { "  compensated" } else { "" })?;
    let mut line = |name: &str, value: &dyn Fn(&Accuracy) -> Option<f64>| -> Result<()> {
        if let Some(before) = value(measured) {
            let after = compensated.and_then(value).map_or(String::new(), |after| format!("{after:>13.2}"));
            writeln!(text, "{name:<46}{before:>10.2}{after}")?;
        }
        Ok(())
    };
    line("A    bidirectional accuracy", &|a| Some(a.both?.accuracy))?;
    line("A↑   accuracy, positive approach", &|a| Some(a.up?.accuracy))?;
    line("A↓   accuracy, negative approach", &|a| Some(a.down?.accuracy))?;
    line("E    bidirectional systematic error", &|a| Some(a.both?.systematic))?;
    line("E↑   systematic error, positive approach", &|a| Some(a.up?.systematic))?;
    line("E↓   systematic error, negative approach", &|a| Some(a.down?.systematic))?;
    line("R    bidirectional repeatability", &|a| Some(a.both?.repeatability))?;
    line("R↑   repeatability, positive approach", &|a| Some(a.up?.repeatability))?;
    line("R↓   repeatability, negative approach", &|a| Some(a.down?.repeatability))?;
    line("M    range of the mean bidirectional deviation", &|a| Some(a.both?.mean_range))?;
    line("B    reversal error", &|a| Some(a.both?.reversal))?;
    line("B̄    mean reversal error", &|a| Some(a.both?.mean_reversal))?;
    if measured.runs < 5 {
        writeln!(text, "\nISO 230-2 asks for five runs in each direction.")?;
    }
    Ok(text)
}
