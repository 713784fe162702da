//! Tables and plots of a thermal test.

use super::{Test, ThermalTestDocument, document::NAMES};
use crate::shown::{Cell, Curve, Plot, Shown, Table, unit};
use trueaxis_report::number::significant;
use trueaxis_tables::text::counted;

impl ThermalTestDocument {
    /// Tables and plots of the document's test.
    pub fn shown(&self, test: &Test) -> Shown {
        let several = self.positions.len() > 1;
        let channels = self.positions.iter().flat_map(|place| {
            place.channels.iter().map(move |of| {
                let name = if several { format!("{}, position {}", of.name, place.position) } else { of.name.clone() };
                let numbers = [of.range, of.first_period, of.worst_period, of.worst_from_min, of.end];
                std::iter::once(name.into())
                    .chain(numbers.map(|value| Cell::number(value, 4)))
                    .chain([unit(of.unit).into()])
                    .collect()
            })
        });
        let head = ["ISO 230-3", "range", "first period", "worst period", "from, min", "end", "unit"];
        let mut tables = vec![Table::new("Figures of ISO 230-3", head, channels)];
        let temperatures = self.temperatures.iter().map(|of| {
            let [low, high] = of.range_c.map(|c| Cell::number(c, 4));
            vec![of.name.into(), low, high, Cell::number(of.worst_period_k, 3), Cell::number(of.end_k, 3)]
        });
        if !self.temperatures.is_empty() {
            let head = ["", "lowest, °C", "highest, °C", "worst period, K", "end, K"];
            tables.push(Table::new("Temperatures", head, temperatures));
        }
        let [duration, period] = [self.duration_min, self.period_min].map(|minutes| significant(minutes, 4));
        let readings = self.positions.iter().map(|place| {
            let readings = counted(place.readings, "reading");
            if several { format!("{readings} at position {}", place.position) } else { readings }
        });
        let summary = [format!("{} test", self.test), format!("{duration} min, period {period} min")];
        Shown {
            title: "Thermal test".into(),
            summary: summary.into_iter().chain(readings).collect(),
            notes: self.notes.clone(),
            tables,
            plots: distortions(test).chain(temperatures_of(test)).collect(),
            ..Shown::default()
        }
    }
}

/// Displacements over time, one plot per position.
fn distortions(test: &Test) -> impl Iterator<Item = Plot> {
    let places = test.positions.iter().zip(&test.times_s).zip(&test.displacements_um);
    places.map(|((position, times), of)| {
        let from_zero = of.each_ref().map(|values| {
            let first = values.first().copied().unwrap_or(0.0);
            values.iter().map(|value| value - first).collect()
        });
        let title = if test.positions.len() > 1 {
            format!("Distortion over time, position {position}")
        } else {
            "Distortion over time".into()
        };
        over_time(
            "Distortion",
            title,
            ("distortion", "µm"),
            "From the first reading.",
            times,
            NAMES.into_iter().zip(from_zero),
        )
    })
}

/// Temperatures over time, if any were recorded.
fn temperatures_of(test: &Test) -> Option<Plot> {
    let series = ["ambient", "spindle", "machine"].into_iter().zip(test.temperatures_c.iter().cloned());
    let plot = over_time("Temperature", "Temperatures".into(), ("temperature", "°C"), "", &test.all_times_s, series);
    (!plot.curves.is_empty()).then_some(plot)
}

/// The recorded series, over minutes.
fn over_time<'n>(
    section: &'static str,
    title: String,
    y: (&'static str, &'static str),
    caption: &'static str,
    times_s: &[f64],
    series: impl Iterator<Item = (&'n str, Vec<f64>)>,
) -> Plot {
    let curves = series.enumerate().filter(|(_, (_, values))| !values.is_empty());
    Plot {
        section,
        title,
        x: ("time".into(), "min"),
        y,
        caption,
        at: times_s.iter().map(|t| t / 60.0).collect(),
        curves: curves.map(|(k, (name, values))| Curve::new(name, k, values)).collect(),
        ..Plot::default()
    }
}
