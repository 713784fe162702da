//! Temperatures of a predicted part, as a document.

use super::{Growth, Warm, between};
use crate::predict::Part;
use serde::Serialize;
use trueaxis::machine::{AXES, Axis};

/// Temperatures while a part is cut.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TemperatureDocument {
    /// The record; absent at a constant temperature.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub record: Option<String>,
    /// Start of the program after the record's first row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_s: Option<f64>,
    /// Starts of the further set-ups after the record's first row; none at a constant temperature.
    pub setups: Vec<SetupStart>,
    /// First and last cut of a feature after the start of the program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut_s: Option<[f64; 2]>,
    /// Temperatures of the machine at the first and last cut; none if only the part's counts.
    pub sensors: Vec<SensorTemperature>,
    /// Growth of the machine at the first and last cut.
    pub growth: Vec<AxisGrowth>,
    /// Temperature of the part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part_c: Option<f64>,
    /// Expansion of the part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part_expansion_um_per_m_k: Option<f64>,
}

/// When a further set-up starts in a record.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SetupStart {
    /// Its name.
    pub name: String,
    /// Start of its program after the record's first row.
    pub start_s: f64,
}

/// Temperatures of a sensor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SensorTemperature {
    /// Its name; `machine` if the temperature is constant.
    pub name: String,
    /// At the first and last cut.
    pub celsius: [f64; 2],
}

/// Growth of an axis where the part is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisGrowth {
    /// Letter of the axis.
    pub axis: char,
    /// `um` or `urad`.
    pub unit: &'static str,
    /// At the first and last cut.
    pub growth: [f64; 2],
}

/// The document of a growth between two times with the axes at these positions, and of the part's temperature; `None` if there
/// is neither.
pub(in crate::predict) fn document(
    warm: Option<(&Warm<'_>, [f64; 2])>,
    part: &Part,
    at: [[f64; AXES]; 2],
) -> Option<TemperatureDocument> {
    let expansion = part.temperature.part;
    let part_c = expansion.map(|part| part.celsius);
    if warm.is_none() && part_c.is_none() {
        return None;
    }
    let mut document = TemperatureDocument {
        record: None,
        start_s: None,
        setups: Vec::new(),
        cut_s: None,
        sensors: Vec::new(),
        growth: Vec::new(),
        part_c,
        part_expansion_um_per_m_k: expansion.map(|part| 1e6 * part.per_k),
    };
    let Some((warm, cut_s)) = warm else { return Some(document) };
    let growth = warm.growth;
    let mut names = vec![String::from("machine")];
    if let Some(record) = &growth.record {
        document.record = Some(record.file.display().to_string());
        document.start_s = Some(record.start_s);
        let starts = part.setups.iter().zip(warm.starts_s());
        document.setups = starts
            .map(|(setup, start_s)| SetupStart { name: setup.name.clone(), start_s: record.start_s + start_s })
            .collect();
        document.cut_s = Some(cut_s);
        names.clone_from(&record.sensors);
    }
    let temperatures = cut_s.map(|time| growth.temperatures(time));
    document.sensors = names
        .into_iter()
        .enumerate()
        .map(|(index, name)| SensorTemperature { name, celsius: [0, 1].map(|end| temperatures[end][index]) })
        .collect();
    let lines = cut_s.map(|time| growth.at(time));
    for axis in Axis::ALL {
        let index = axis.index();
        let (unit, micro) = if axis.is_rotary() { ("urad", 1e6_f64.to_radians()) } else { ("um", 1e3) };
        let ends = [0, 1].map(|end| micro * lines[end][index].at(at[end][index]));
        if ends != [0.0; 2] {
            document.growth.push(AxisGrowth { axis: axis.letter(), unit, growth: ends });
        }
    }
    Some(document)
}

impl Growth {
    /// Temperatures of the sensors at a time since the program's start, s.
    pub(super) fn temperatures(&self, t_s: f64) -> Vec<f64> {
        let of = |index: usize| self.readings[index].temperatures_c.clone();
        between(&self.readings, t_s, of, |early, late, share| {
            early.iter().zip(&late).map(|(early, late)| early + share * (late - early)).collect()
        })
    }
}

impl TemperatureDocument {
    /// What a reader has to know of the temperatures.
    pub(in crate::predict) fn summary(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let range = |[first, last]: [f64; 2], unit: &str, digits: usize| {
            let [from, to] = [first, last].map(|value| format!("{value:.digits$}").replace('-', "−"));
            if from == to { format!("{from} {unit}") } else { format!("{from} to {to} {unit}") }
        };
        if let (Some(record), Some(start), Some([first, last])) = (&self.record, self.start_s, self.cut_s) {
            lines.push(format!("temperatures of {record}; the program starts {start} s into it"));
            lines.push(format!("features cut {first:.0} to {last:.0} s after that"));
            lines.extend(self.setups.iter().map(|of| format!("set-up {} starts {:.0} s into it", of.name, of.start_s)));
        }
        if !self.sensors.is_empty() {
            let sensors = self.sensors.iter().map(|of| format!("{} {}", of.name, range(of.celsius, "°C", 1)));
            lines.push(sensors.collect::<Vec<_>>().join(", "));
            let growth = self
                .growth
                .iter()
                .map(|of| format!("{} {}", of.axis, range(of.growth, if of.unit == "um" { "µm" } else { "µrad" }, 1)));
            let growth: Vec<String> = growth.collect();
            let growth = if growth.is_empty() { String::from("none") } else { growth.join(", ") };
            lines.push(format!("growth where the part is: {growth}"));
        }
        if let (Some(celsius), Some(expansion)) = (self.part_c, self.part_expansion_um_per_m_k) {
            lines.push(format!("part cut at {celsius} °C, {expansion} µm/(m K), measured at 20 °C"));
        }
        lines
    }
}
