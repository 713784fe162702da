//! `trueaxis tables accuracy`: ISO 230-2 before and after compensation.

use crate::model::{self, by_axes, with_compensation};
use crate::output::{json, print, tell};
use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;
use trueaxis::Axis;
use trueaxis::compensation::{Direction as Travel, Query, ThermalLine};
use trueaxis::machine::{AxisOrder, ErrorModel};
use trueaxis_metrology::accuracy::{Accuracy, Direction, Measurement, evaluate, evaluate_compensated};
use trueaxis_tables::Machine;
use trueaxis_tables::formats::iso230_2::{MeasurementFile, read_measurement};
use trueaxis_tables::text::counted;

#[derive(Serialize)]
struct Document {
    measured: Accuracy,
    #[serde(skip_serializing_if = "Option::is_none")]
    compensated: Option<Accuracy>,
}

pub(crate) fn run(file: &Path, axis: Option<Axis>, machine: Option<&Path>, as_json: bool) -> Result<()> {
    let text = model::text(file)?;
    let MeasurementFile { measurement, dialect } = read_measurement(&text, file, axis)?;
    if let Some(how) = dialect {
        tell(format_args!("note: {}: {how}", file.display()));
    }
    let measured = evaluate(&measurement).map_err(|error| anyhow!("{}: {error}", file.display()))?;
    let compensated = match machine {
        None => None,
        Some(path) => {
            let mut tables = model::machine(path)?;
            // A measurement along one axis knows no levers.
            tables.settings.compensation.model = ErrorModel::Nine;
            if tables.rows(measurement.axis).is_none() {
                bail!("{}: found no table of axis {}, needed one", path.display(), measurement.axis.letter());
            }
            Some(by_axes!(tables.settings.step_axes().count(), after(&tables, &measurement))?)
        }
    };
    if as_json {
        return json(&Document { measured, compensated });
    }
    print(&table(&measured, compensated.as_ref())?)
}

/// The deviations less what the machine's own look-up says of the axis alone, in the direction of the approach.
fn after<const N: usize>(tables: &Machine, measurement: &Measurement) -> Result<Accuracy> {
    let axes = AxisOrder::<N>::of(&tables.settings).map_err(|error| anyhow!("{error}"))?.axes();
    let slot = axes.iter().position(|a| *a == measurement.axis).context("the axis is not in the machine")?;
    with_compensation::<N, _>(tables, 1, |compensation| {
        let own = |position: f64, direction: Direction| {
            let travel = if direction == Direction::Down { Travel::NEGATIVE } else { Travel::POSITIVE };
            let error = |q: f64| {
                let mut at = [0.0; N];
                at[slot] = q;
                let (at, thermal) = (compensation.coordinates(&at), [ThermalLine::default(); N]);
                let mut directions = [Travel::POSITIVE; N];
                directions[slot] = travel;
                compensation.errors(&Query::at(&at, &directions, &thermal), &mut 0)[slot]
            };
            // The other axes stand still: what they add is the same everywhere.
            let constant = {
                let first = tables.rows(measurement.axis).and_then(<[_]>::first);
                let own = first.map_or(0.0, |row| row.forward[measurement.axis.index()]);
                let start = first.map_or(0.0, |row| row.position);
                let mut at = [0.0; N];
                at[slot] = start;
                let forward = compensation.errors(
                    &Query::at(&compensation.coordinates(&at), &[Travel::POSITIVE; N], &[ThermalLine::default(); N]),
                    &mut 0,
                )[slot];
                let own = if measurement.axis.is_rotary() { own.to_degrees() } else { own };
                forward - own
            };
            let value = error(position) - constant;
            if measurement.axis.is_rotary() { value.to_radians() * 1e6 } else { value * 1e3 }
        };
        evaluate_compensated(measurement, own).map_err(|error| anyhow!("{error}"))
    })
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
