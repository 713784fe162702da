//! Temperatures of a predicted part: its record, and the machine's model of growth.

use crate::csv_in;
use anyhow::{Result, anyhow};
use clap::Args;
use std::path::{Path, PathBuf};
use trueaxis_evaluation::predict::{Part, Start, TEMPERATURES, TemperatureRecord, growth_model, thermal_beside};
use trueaxis_tables::Machine;

#[derive(Args)]
#[command(next_help_heading = "Temperature")]
pub(super) struct TemperatureArgs {
    /// Temperatures while the part is cut; they replace `machine_c` of the part's file.
    #[arg(long, value_name = "RECORD.csv")]
    thermal: Option<PathBuf>,
    /// Start of the program, seconds after the record's first row [default: 0].
    #[arg(long, value_name = "S", requires = "thermal", conflicts_with = "at")]
    start: Option<f64>,
    /// Start of the program on the clock, if t_s of the record counts from midnight.
    #[arg(long, value_name = "HH:MM", requires = "thermal", value_parser = clock)]
    at: Option<f64>,
}

/// Seconds since midnight.
fn clock(text: &str) -> Result<f64> {
    Start::clock(text).ok_or_else(|| anyhow!("needed hours and minutes, 00:00 to 23:59"))
}

impl TemperatureArgs {
    /// Files that a prediction of this part reads for the temperatures.
    pub(super) fn inputs(&self, part: &Part, machine: &Path) -> impl Iterator<Item = PathBuf> {
        let model = thermal_beside(machine).filter(|_| self.thermal.is_some() || part.temperature.machine_c.is_some());
        self.thermal.clone().into_iter().chain(model)
    }

    /// The part with the growth of the machine while it is cut.
    pub(super) fn apply(&self, part: Part, machine: &Machine, path: &Path) -> Result<Part> {
        let read = |record: &PathBuf| TemperatureRecord::read(csv_in::open(record, &TEMPERATURES, "rows")?);
        let record = self.thermal.as_ref().map(read).transpose()?;
        let start = self.at.map_or_else(|| Start::After(self.start.unwrap_or(0.0)), Start::At);
        part.warmed(record.as_ref().map(|record| (record, start)), || growth_model(machine, path))
    }
}
