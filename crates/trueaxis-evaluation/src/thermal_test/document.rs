//! Figures of a thermal test, as a document.

use super::Test;
use serde::Serialize;
use trueaxis_metrology::drift::{Drift, drift};

/// Names of the displacements.
pub(super) const NAMES: [&str; 5] = ["X1", "Y1", "Z", "X2", "Y2"];

/// Drift of one displacement or tilt.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Channel {
    /// X1, Y1, Z, X2, Y2, A, B.
    pub name: String,
    /// `um` or `urad`.
    pub unit: &'static str,
    /// Range over the whole test.
    pub range: f64,
    /// Range within the first period.
    pub first_period: f64,
    /// Largest range within any period.
    pub worst_period: f64,
    /// Start of that period.
    pub worst_from_min: f64,
    /// Last minus first reading.
    pub end: f64,
}

/// Results at one position of the moving axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Number of the position; 0 if the record names none.
    pub position: i64,
    /// Number of readings.
    pub readings: usize,
    /// Displacements and tilts.
    pub channels: Vec<Channel>,
}

/// A temperature.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Temperature {
    /// `ambient`, `spindle`, `machine`.
    pub name: &'static str,
    /// Smallest and largest temperature, °C.
    pub range_c: [f64; 2],
    /// Largest range within any period, K.
    pub worst_period_k: f64,
    /// Last minus first, K.
    pub end_k: f64,
}

/// The JSON document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ThermalTestDocument {
    /// "etve", "spindle" or "axis".
    pub test: &'static str,
    /// Length of the record.
    pub duration_min: f64,
    /// The period.
    pub period_min: f64,
    /// Results by position.
    pub positions: Vec<Place>,
    /// Temperatures recorded.
    pub temperatures: Vec<Temperature>,
    /// Remarks on the figures.
    pub notes: Vec<String>,
}

fn channel(name: &str, unit: &'static str, of: Drift) -> Channel {
    Channel {
        name: name.into(),
        unit,
        range: of.range,
        first_period: of.first,
        worst_period: of.worst,
        worst_from_min: of.worst_from / 60.0,
        end: of.end,
    }
}

/// A and B in µrad; `None` unless both heights were recorded.
pub(super) fn tilts(of: &[Vec<f64>; 5], distance_mm: f64) -> [Option<Vec<f64>>; 2] {
    let between = |low: usize, high: usize, sign: f64| {
        let both = !of[low].is_empty() && !of[high].is_empty();
        // µm over mm is mrad; times 1e3 µrad.
        both.then(|| of[low].iter().zip(&of[high]).map(|(low, high)| sign * 1e3 * (high - low) / distance_mm).collect())
    };
    [between(1, 4, -1.0), between(0, 3, 1.0)]
}

impl ThermalTestDocument {
    /// The document of the test called `name`; `distance_mm` between the probes at both heights, if known.
    pub fn new(test: &Test, name: &'static str, period_min: f64, distance_mm: Option<f64>) -> ThermalTestDocument {
        let period = 60.0 * period_min;
        let places = test.positions.iter().zip(&test.times_s).zip(&test.displacements_um);
        let positions = places.map(|((&position, times), of)| {
            let mut channels: Vec<Channel> = NAMES
                .into_iter()
                .zip(of)
                .filter(|(_, values)| !values.is_empty())
                .map(|(name, values)| channel(name, "um", drift(times, values, period)))
                .collect();
            if let Some(distance) = distance_mm {
                for (name, tilt) in ["A", "B"].into_iter().zip(tilts(of, distance)) {
                    channels.extend(tilt.map(|values| channel(name, "urad", drift(times, &values, period))));
                }
            }
            Place { position, readings: times.len(), channels }
        });
        let temperatures = ["ambient", "spindle", "machine"].into_iter().zip(&test.temperatures_c);
        let temperatures = temperatures.filter(|(_, values)| !values.is_empty()).map(|(name, values)| {
            let of = drift(&test.all_times_s, values, period);
            let range = values.iter().fold([f64::MAX, f64::MIN], |[l, h], v| [l.min(*v), h.max(*v)]);
            Temperature { name, range_c: range, worst_period_k: of.worst, end_k: of.end }
        });
        let duration_min = test.all_times_s.last().copied().unwrap_or(0.0) / 60.0;
        let mut notes = Vec::new();
        if duration_min < period_min {
            notes.push(format!("the record lasts {duration_min:.1} min, less than the period of {period_min} min"));
        }
        let least = if name == "etve" { 4.0 * 60.0 } else { 60.0 };
        if duration_min < least {
            notes.push(format!("ISO 230-3 asks for at least {} h in this test", least / 60.0));
        }
        let typical = test.all_times_s.last().copied().unwrap_or(0.0) / test.all_times_s.len().max(2) as f64;
        if test.gap_s.0 > 10.0 * typical {
            notes.push(format!("no reading for {:.1} min after line {}", test.gap_s.0 / 60.0, test.gap_s.1));
        }
        if distance_mm.is_none() && test.displacements_um.iter().any(|of| !of[3].is_empty() || !of[4].is_empty()) {
            notes.push("tilts need the distance between the probes: --distance-mm".into());
        }
        ThermalTestDocument {
            test: name,
            duration_min,
            period_min,
            positions: positions.collect(),
            temperatures: temperatures.collect(),
            notes,
        }
    }
}
