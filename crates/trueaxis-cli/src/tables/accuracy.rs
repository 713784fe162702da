//! `trueaxis tables accuracy`: ISO 230-2 before and after compensation.

use crate::model;
use crate::output::{json, print, report_line};
use anyhow::{Result, bail};
use std::fmt::Write;
use std::path::Path;
use trueaxis::Axis;
use trueaxis_evaluation::accuracy::{AccuracyDocument, bands, evaluate, judge, read};
use trueaxis_metrology::accuracy::Accuracy;
use trueaxis_metrology::uncertainty::Verdict;
use trueaxis_tables::text::counted;
use trueaxis_tables::uncertainty::Uncertainties;

/// Options for the uncertainty.
pub(crate) struct Bands<'m> {
    /// Machine whose section uncertainty states the instrument.
    pub(crate) machine: &'m Path,
    pub(crate) tolerance_um: Option<f64>,
    /// Percent.
    pub(crate) confidence: f64,
}

pub(crate) fn run(
    file: &Path,
    axis: Option<Axis>,
    machine: Option<&Path>,
    asked: Option<Bands<'_>>,
    as_json: bool,
) -> Result<()> {
    let text = model::text(file)?;
    let measurement = read(&text, file, axis, &mut |how| report_line(format_args!("note: {how}")))?;
    // Evaluate without the machine first, so that errors in the measurement are reported before those in the machine.
    let mut document = evaluate(&measurement, file, None)?;
    if let Some(path) = machine {
        document.compensated = evaluate(&measurement, file, Some((&model::machine(path)?, path)))?.compensated;
    }
    if let Some(Bands { machine, tolerance_um, confidence }) = asked {
        if !(50.0..=99.99).contains(&confidence) {
            bail!("--confidence: found {confidence}, needed 50 to 99.99 %");
        }
        if let Some(tolerance) = tolerance_um.filter(|tolerance| !(0.0..=1e6).contains(tolerance)) {
            bail!("--tolerance-um: found {tolerance}, needed 0 to 1e6 um");
        }
        let stated = Uncertainties::read(machine)?;
        let bands = bands(&measurement, &model::source(machine)?, &stated, confidence / 100.0)?;
        document.verdict = tolerance_um.and_then(|tolerance| judge(&bands, tolerance));
        document.uncertainty = Some(bands);
    }
    if as_json { json(&document) } else { print(&table(&document)?) }
}

/// Bands of the figures, and the verdict.
fn bands_text(text: &mut String, document: &AccuracyDocument) -> std::fmt::Result {
    let Some(bands) = &document.uncertainty else { return Ok(()) };
    writeln!(text, "\n{:<10}{:>12}{:>10}   {} %", "", "measured", "± U", 100.0 * bands.coverage)?;
    for band in &bands.figures {
        let name = band.figure.replace("_up", "↑").replace("_down", "↓").replace("B_mean", "B̄");
        writeln!(
            text,
            "{name:<10}{:>12.2}{:>10.2}   {:.2} … {:.2}",
            band.value, band.expanded, band.interval.low, band.interval.high
        )?;
    }
    if bands.drowned {
        writeln!(
            text,
            "note: the readings scatter no more than the instrument alone: the bands of A, R and B may be too narrow"
        )?;
    }
    if let Some(judged) = &document.verdict {
        let words = match judged.verdict {
            Verdict::Pass => "kept, uncertainty included: pass",
            Verdict::Fail => "exceeded, uncertainty included: fail",
            Verdict::Undecided => "within the uncertainty: no verdict",
        };
        writeln!(text, "{} of at most {} µm: {words}", judged.figure, judged.tolerance_um)?;
    }
    Ok(())
}

fn table(document: &AccuracyDocument) -> Result<String> {
    let (measured, compensated) = (&document.measured, document.compensated.as_ref());
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
    bands_text(&mut text, document)?;
    if measured.positions.len() < 5 {
        writeln!(text, "\nISO 230-2 asks for five target positions a metre, and five at least.")?;
    }
    if measured.runs < 5 {
        writeln!(text, "\nISO 230-2 asks for five runs in each direction.")?;
    }
    Ok(text)
}
