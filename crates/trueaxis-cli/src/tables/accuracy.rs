//! `trueaxis tables accuracy`: ISO 230-2 before and after compensation.

use crate::model;
use crate::output::{json, print, report_line};
use anyhow::{Result, bail};
use std::path::Path;
use trueaxis::Axis;
use trueaxis_evaluation::accuracy::{bands, evaluate, judge, read};
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
    if as_json { json(&document) } else { print(&document.shown().text()) }
}
