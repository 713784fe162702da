//! A machine as displayed by its view.

use crate::files::{DESCRIPTION, memory, texts};
use anyhow::Result;
use serde::Serialize;
use std::path::Path;
use trueaxis::machine::{AxisSettings, Interpolation, Twist};
use trueaxis::tcomp::Tcomp;
use trueaxis_evaluation::accuracy;
use trueaxis_evaluation::check::{CheckDocument, compiled, findings};
use trueaxis_evaluation::shown::{self as description, Table};
use trueaxis_tables::text::decode;
use trueaxis_tables::uncertainty::Uncertainties;
use trueaxis_tables::{DriveRate, GridSource, Machine, TableText, rates, table_texts};

/// The full description of a machine.
#[derive(Debug, Serialize)]
pub(crate) struct Shown {
    /// Detected separators.
    notes: Vec<String>,
    /// The document printed by `trueaxis tables check --json`.
    check: CheckDocument,
    reference_temperature_c: f64,
    axes: Vec<AxisShown>,
    grids: Vec<GridShown>,
    measurements: Vec<Measured>,
    /// The tables' own figures after ISO 230-2.
    accuracy: Table,
}

/// An axis in the units of the files.
#[derive(Debug, Serialize)]
struct AxisShown {
    axis: char,
    /// mm or deg.
    unit: &'static str,
    /// um or urad.
    micro: &'static str,
    /// µm or µrad.
    backlash: f64,
    /// µm per m and K, µrad per rad and K.
    expansion: f64,
    interpolation: &'static str,
    max_feed_per_min: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    table: Option<TableShown>,
    #[serde(skip_serializing_if = "Option::is_none")]
    correction: Option<Correction>,
}

#[derive(Debug, Serialize)]
struct TableShown {
    file: String,
    columns: Vec<Column>,
    rows: Vec<Vec<f64>>,
}

#[derive(Debug, Serialize)]
struct Column {
    name: String,
    component: Option<usize>,
    forward: bool,
    reverse: bool,
}

/// A grid of errors as in its file.
#[derive(Debug, Serialize)]
struct GridShown {
    /// Along X, Y, Z; empty for an axis that the grid does not depend on.
    nodes_mm: [Vec<f64>; 3],
    /// Which of the six errors the grid contains.
    given: [bool; 6],
    /// Errors of the nodes, µm and µrad: X varies slowest, Z fastest.
    micro: Vec<[f64; 6]>,
    fade_mm: Option<[f64; 2]>,
}

/// Rate of change of a drive's correction at a feed; mm or degrees per s and s².
#[derive(Debug, Serialize)]
struct Correction {
    rate: f64,
    rate_limit: f64,
    moving: char,
    acceleration: Option<f64>,
    acceleration_limit: f64,
}

/// A file of measured deviations.
#[derive(Debug, Serialize)]
struct Measured {
    file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    figures: Option<description::Shown>,
    /// Reason why the figures are missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<String>,
}

/// The document; errors as on the command line.
pub(crate) fn shown(files: &str, rate_hz: f64, feed_per_min: f64) -> Result<Shown> {
    let (source, name) = (memory(files)?, Path::new(DESCRIPTION));
    let mut notes = Vec::new();
    trueaxis_evaluation::check::rate(rate_hz)?;
    let machine = Machine::read_from(&source, name, &mut |note| notes.push(note))?;
    let known = Uncertainties::read_from(&source, name)?;
    let bytes = compiled(&machine, &source, name, rate_hz)?;
    let tables = Tcomp::parse(&bytes).map_err(|error| anyhow::anyhow!("{error}"))?;
    let rates = rates(&machine, (feed_per_min > 0.0).then_some(feed_per_min / 60.0));
    let written = table_texts(&source, name)?;
    let measurements = measurements(files, &machine, &written)?;
    let mut written = written.into_iter().peekable();
    let axis = |own: &AxisSettings| {
        let table = written.next_if(|table| table.axis == own.axis);
        let correction = rates.iter().find(|rate| rate.axis == own.axis);
        axis_shown(own, table, correction)
    };
    Ok(Shown {
        notes,
        axes: machine.settings.axes.iter().map(axis).collect(),
        grids: machine.grids.iter().map(|grid| grid_shown(grid.source())).collect(),
        check: findings(&machine, &known, &tables, rate_hz).into(),
        reference_temperature_c: machine.settings.reference_temperature_c,
        accuracy: accuracy::of_tables(&machine),
        measurements,
    })
}

fn grid_shown(grid: &GridSource) -> GridShown {
    let micro = |errors: &Twist| std::array::from_fn(|k| if k < 3 { 1e3 } else { 1e6 } * errors[k]);
    GridShown {
        nodes_mm: grid.nodes.clone(),
        given: grid.given,
        micro: grid.values.iter().map(micro).collect(),
        fade_mm: grid.fade_mm,
    }
}

fn axis_shown(own: &AxisSettings, table: Option<TableText>, correction: Option<&DriveRate>) -> AxisShown {
    let rotary = own.axis.is_rotary();
    let correction = correction.map(|of| Correction {
        rate: of.rate,
        rate_limit: of.limit,
        moving: of.moving.letter(),
        acceleration: of.acceleration,
        acceleration_limit: of.acceleration_limit,
    });
    AxisShown {
        axis: own.axis.letter(),
        unit: if rotary { "deg" } else { "mm" },
        micro: if rotary { "urad" } else { "um" },
        backlash: if rotary { own.backlash.to_radians() * 1e6 } else { own.backlash * 1e3 },
        expansion: own.thermal.expansion_per_k * 1e6,
        interpolation: if own.interpolation == Interpolation::Cubic { "cubic" } else { "linear" },
        max_feed_per_min: own.max_feed_per_s * 60.0,
        table: table.map(table_shown),
        correction,
    }
}

fn table_shown(table: TableText) -> TableShown {
    let columns = table.columns.into_iter().map(|column| Column {
        name: column.name,
        component: column.component,
        forward: column.forward,
        reverse: column.reverse,
    });
    TableShown { file: table.file, columns: columns.collect(), rows: table.rows }
}

/// Files that `machine.toml` does not name, read as measurements.
fn measurements(files: &str, machine: &Machine, tables: &[TableText]) -> Result<Vec<Measured>> {
    let mut measured = Vec::new();
    for (file, text) in texts(files)? {
        if file == DESCRIPTION || !file.ends_with(".csv") || tables.iter().any(|table| table.file == file) {
            continue;
        }
        let path = Path::new(&file);
        let figures = decode(text.into_bytes(), path, &['#', ';'])
            .map_err(Into::into)
            .and_then(|text| accuracy::read(&text, path, None, &mut |_| {}))
            .and_then(|read| {
                let tables = machine.rows(read.axis).map(|_| (machine, Path::new(DESCRIPTION)));
                accuracy::evaluate(&read, path, tables)
            });
        let (figures, refused) = match figures {
            Ok(figures) => (Some(figures.shown()), None),
            Err(error) => (None, Some(format!("{error:#}"))),
        };
        measured.push(Measured { file, figures, refused });
    }
    Ok(measured)
}
