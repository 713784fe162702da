//! Tables and plots of thermal growth.

use super::{CurveDocument, FittedRecording, ThermalDocument, worst};
use crate::shown::{Cell, Curve, Plot, Quantity, Shown, Table, Uncertainty};
use trueaxis::Axis;
use trueaxis_report::number::{percent, significant};

/// Standard errors come from thousands of rows: their degrees of freedom count as infinite.
pub(super) const DEGREES_OF_FREEDOM: f64 = f64::INFINITY;

/// The values of a curve at its knots; without a part that is zero.
fn quantities(axis: char, curve: &CurveDocument) -> Vec<Quantity> {
    let [knot, slope] = if curve.of == "spindle" { ["rpm", "µrad"] } else { ["°C", "µm/m"] };
    let parts = [("µm", &curve.offset_um, &curve.offset_error_um), (slope, &curve.slope, &curve.slope_error)];
    let parts = parts.into_iter().filter(|(_, values, _)| values.iter().any(|value| *value != 0.0));
    let at = |unit, ((at, value), error): ((&f64, &f64), &f64)| {
        let name = format!("E{axis}{axis}, {} at {} {knot}", curve.of, significant(*at, 3));
        Quantity::new(name, unit, *value, Uncertainty::of(*error, DEGREES_OF_FREEDOM))
    };
    let all = parts.flat_map(|(unit, values, errors)| {
        curve.knots.iter().zip(values).zip(errors).map(move |known| at(unit, known))
    });
    all.collect()
}

impl ThermalDocument {
    /// Tables of the document: drift and remainder, lags, curves, and omitted terms. Plots of the drift of held-out cycles.
    pub fn shown(&self, found: &FittedRecording) -> Shown {
        let um = |um: f64| Cell::number(um, 3);
        let cycles = self.cycles.iter().map(|own| {
            let share = Cell::percent(own.left_um / own.drift_um.max(f64::MIN_POSITIVE));
            let used = if own.held_out { "held out" } else { "fitted" };
            let name = format!("E{0}{0}, cycle {1}", own.axis, own.cycle);
            vec![name.into(), um(own.drift_um), um(own.left_um), um(own.left_rms_um), share, used.into()]
        });
        let head = ["", "largest drift, µm", "left, µm", "left RMS, µm", "left, %", "use"];
        let spindle = self.spindle_lag_s.map(|lag| ("spindle", lag));
        let lags = self.sensors.iter().map(|sensor| (sensor.name.as_str(), sensor.lag_s)).chain(spindle);
        let curves = self.axes.iter().flat_map(|of| of.curves.iter().flat_map(|curve| quantities(of.axis, curve)));
        let fits = self
            .axes
            .iter()
            .map(|of| vec![format!("E{0}{0}", of.axis).into(), um(of.rms_um), Cell::number(of.condition, 3)]);
        let mut tables = vec![
            Table::new("Drift and remainder", head, cycles),
            self.predictable(),
            Table::new("Lags", ["sensor", "lag, s"], lags.map(|(name, lag)| vec![name.into(), um(lag)])),
            Table::quantities("Curves", curves),
            Table::new("Fit", ["", "left, RMS, µm", "condition number"], fits),
        ];
        let left_out = self.left_out.iter().map(|out| vec![out.name.as_str().into(), out.reason.into()]);
        tables.push(Table::new("Left out", ["sensor", "why"], left_out));
        let unconfirmed = self.unconfirmed.iter().map(|own| {
            let why = format!("run in cycle {} only, so that no other cycle predicts it", own.cycle);
            vec![format!("{} rpm", own.rpm).into(), why.into()]
        });
        tables.push(Table::new("Unconfirmed", ["speed", "why"], unconfirmed));
        let missing = self.missing.iter().map(|own| {
            let times = [own.found_s, own.interval_s].map(|s| Cell::fixed(s, 0));
            [own.line as usize, own.cycle as usize, own.rows].map(Cell::count).into_iter().chain(times).collect()
        });
        let head = ["before line", "cycle", "rows", "without a row, s", "interval elsewhere, s"];
        tables.push(Table::new("Missing rows", head, missing));
        tables.retain(|table| !table.rows.is_empty());
        let [drift, left] = self.held_out_um.map(|um| significant(um, 3));
        let cycles = if found.fit.turns.is_empty() {
            "cycles that took no part in the fit"
        } else {
            "cycles each predicted by the curves of the others, sensors and lags chosen for all"
        };
        let share = percent(self.held_out_um[1], self.held_out_um[0]);
        Shown {
            title: "Thermal growth".into(),
            summary: vec![
                format!("{} rows", self.rows),
                format!("zero at {} °C", self.reference_c),
                format!("{left} µm ({share}) left of a largest drift of {drift} µm in {cycles}"),
            ],
            tables,
            plots: found.recording.record.axes.iter().filter_map(|axis| held_out(found, *axis)).collect(),
            ..Shown::default()
        }
    }
}

impl ThermalDocument {
    /// Of each axis: the residual of the held-out cycles, and how much of it no model of these sensors predicts.
    fn predictable(&self) -> Table {
        let rows = self.repeatability.iter().map(|own| {
            let um = |um: Option<f64>| um.map_or_else(|| Cell::from("unknown"), |um| Cell::number(um, 3));
            let share = |um: f64| Cell::percent(um / own.drift_um.max(f64::MIN_POSITIVE));
            let most = own.repeat_um.map_or_else(|| Cell::from("unknown"), share);
            let name = format!("E{0}{0}", own.axis).into();
            let [drift, left] = [own.drift_um, own.left_um].map(|um| Cell::number(um, 3));
            vec![
                name,
                drift,
                left,
                share(own.left_um),
                um(own.repeat_um),
                most,
                um(own.model_um),
                Cell::count(own.rows),
            ]
        });
        let head = [
            "",
            "drift RMS, µm",
            "left RMS, µm",
            "left, %",
            "cycles differ by, µm",
            "of drift, %",
            "due to the model, µm",
            "rows compared",
        ];
        Table::new("What these sensors can predict", head, rows)
    }
}

/// Drift of an axis in a held-out cycle at the point where it is largest: measured, computed by the task, and the difference.
fn held_out(found: &FittedRecording, axis: Axis) -> Option<Plot> {
    let series = worst(found, axis)?;
    let um = |name: &str, colour: usize, of: fn(&[f64; 3]) -> f64| {
        Curve::new(name, colour, series.rows.iter().map(|row| 1e3 * of(row)).collect())
    };
    let ([x, y, z, tool], letter) = (series.point_mm, axis.letter());
    Some(Plot {
        section: "Held-out cycles",
        title: format!("Drift of {letter} in cycle {} at X {x}, Y {y}, Z {z}, tool {tool} mm", series.cycle),
        x: ("time since the cycle began".into(), "h"),
        y: ("drift", "µm"),
        caption: "This cycle took no part in the fit.",
        at: series.rows.iter().map(|row| row[0] / 3600.0).collect(),
        curves: vec![
            um("measured", 5, |row| row[1]),
            um("by the task", 6, |row| row[2]),
            um("left", 7, |row| row[1] - row[2]),
        ],
        ..Plot::default()
    })
}
