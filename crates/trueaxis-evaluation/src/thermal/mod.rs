//! Thermal growth: reads a recorded warm-up, presents the fit as a document, as figures and as a text, and compiles that text
//! into the task's file.
//!
//! The mathematics is in [`trueaxis_metrology::thermal`].

mod document;
mod figures;
mod record;
mod shown;
mod text;
mod written;

pub use document::{
    AxisDocument, CurveDocument, CycleDocument, LeftOutDocument, MissingDocument, RepeatabilityDocument,
    SensorDocument, ThermalDocument, UnconfirmedDocument,
};
pub use figures::residuals;
pub use record::{COLUMNS, Recording, with_temperatures};
pub use text::model;
#[cfg(feature = "simulation")]
pub(crate) use text::with_uncertainties;
pub use written::written;

use anyhow::{Result, anyhow, bail};
use figures::worst;
use trueaxis::Axis;
use trueaxis::machine::MachineSettings;
use trueaxis_metrology::thermal::{
    Fit, HeldOut, Repeatability, Sample, Series, Settings, fit, held_out, repeatability,
};

/// A record with its fit.
#[derive(Clone, Debug)]
pub struct FittedRecording {
    /// The recording.
    pub recording: Recording,
    /// The fit.
    pub fit: Fit,
    /// Drift and residual, by axis and cycle.
    pub figures: Vec<HeldOut>,
    /// Drift and residual over time, by measuring point.
    pub series: Vec<Series>,
    /// Repeatability of each axis between cycles.
    pub repeatability: Vec<Repeatability>,
    /// Temperature at which the curves are zero, °C.
    pub reference_c: f64,
}

/// Reference temperature and datums of a machine; 20 °C and 0 without one.
pub fn settings(machine: Option<&MachineSettings>, held_out: Vec<u32>) -> Settings {
    let datum = |axis| machine.and_then(|machine| machine.axis(axis)).map_or(0.0, |axis| axis.thermal.datum);
    Settings {
        reference_c: machine.map_or(20.0, |machine| machine.reference_temperature_c),
        datum_mm: [Axis::X, Axis::Y, Axis::Z].map(datum),
        held_out,
        rate_k_per_min: None,
    }
}

/// The settings with the largest rate at which a sensor warms or cools, K/min, if it is stated, under its command-line name in
/// errors.
///
/// # Errors
/// A rate outside 0.1 to 1000.
pub fn with_rate(settings: Settings, rate_k_per_min: Option<f64>) -> Result<Settings> {
    if let Some(rate) = rate_k_per_min.filter(|rate| !(0.1..=1000.0).contains(rate)) {
        bail!("--rate-k-per-min: found {rate}, needed 0.1 to 1000");
    }
    Ok(Settings { rate_k_per_min, ..settings })
}

impl FittedRecording {
    /// Measured minus predicted drift, µm: a row for each row of the record, a value for each of its axes, relative to the first
    /// row of the cycle at the same measuring point.
    ///
    /// Cost: the number of rows times that of measuring points.
    pub fn residuals_um(&self) -> Vec<Vec<f64>> {
        let record = &self.recording.record;
        let mut left: Vec<_> = self.series.iter().map(|own| own.rows.iter()).collect();
        let mut of_row = |sample: &Sample| {
            let [x, y, z] = sample.position_mm;
            let point = [x, y, z, sample.tool_mm].map(f64::to_bits);
            let mut of_axis = |axis: &Axis| {
                let own = |own: &Series| {
                    own.axis == *axis && own.cycle == sample.cycle && own.point_mm.map(f64::to_bits) == point
                };
                let row = self.series.iter().position(own).and_then(|place| left[place].next());
                row.map_or(f64::NAN, |[_, measured, predicted]| 1e3 * (measured - predicted))
            };
            record.axes.iter().map(&mut of_axis).collect()
        };
        record.samples.iter().map(&mut of_row).collect()
    }

    /// Fits a model and runs the task over the record with it; reports every cause that enters the model to the callback.
    ///
    /// # Errors
    /// A record that determines nothing, with file, line and column if known.
    pub fn of(recording: Recording, settings: &Settings, on_cause: &mut dyn FnMut(&str)) -> Result<FittedRecording> {
        let fit = fit(&recording.record, settings, on_cause).map_err(|refused| recording.refused(&refused))?;
        let bytes = fit.model.encode(0).map_err(|error| anyhow!("{}: {error}", recording.file.display()))?;
        let (figures, series) = held_out(&recording.record, &fit, &bytes);
        let repeatability = repeatability(&recording.record, &fit, &bytes, &series);
        Ok(FittedRecording { recording, fit, figures, series, repeatability, reference_c: settings.reference_c })
    }
}
