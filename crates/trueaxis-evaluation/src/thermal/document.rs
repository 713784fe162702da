//! The document of a fit.

use super::FittedRecording;
use crate::uncertainty::{CovarianceDocument, Estimate};
use serde::Serialize;
use std::fmt;
use trueaxis_metrology::thermal::{Coefficient, Repeatability};

/// Output of `trueaxis thermal fit --json`.
#[derive(Clone, Debug, Serialize)]
pub struct ThermalDocument {
    /// Number of rows in the record.
    pub rows: usize,
    /// Temperature at which the curves are zero, °C.
    pub reference_c: f64,
    /// Sensors of the model with their lags, s.
    pub sensors: Vec<SensorDocument>,
    /// Lag of the spindle's response, s; `None` if the model does not use the speed.
    pub spindle_lag_s: Option<f64>,
    /// Curves of each axis.
    pub axes: Vec<AxisDocument>,
    /// Covariance of the curves of all axes, by names as `Z.nose.offset_um[0]`; its diagonal has the squares of their standard
    /// errors. Values without one are not in it. It is conditional on the sensors and bends chosen, and includes the lags.
    pub covariance: CovarianceDocument,
    /// Sensors that are not part of the model.
    pub left_out: Vec<LeftOutDocument>,
    /// Speeds that occur in only one fitted cycle.
    pub unconfirmed: Vec<UnconfirmedDocument>,
    /// Rows missing from the record.
    pub missing: Vec<MissingDocument>,
    /// Root mean square of the drift and of the residual, µm, when every fitted cycle is predicted from the others; parts that
    /// only one cycle determines are fitted in that prediction.
    pub predicted_um: [f64; 2],
    /// Drift and residual of the held-out cycles and of the others.
    pub cycles: Vec<CycleDocument>,
    /// How much of each axis's drift any model of these sensors could predict, beside the residual.
    pub repeatability: Vec<RepeatabilityDocument>,
    /// Largest drift of the held-out cycles, µm, and largest residual.
    pub held_out_um: [f64; 2],
}

/// A sensor.
#[derive(Clone, Debug, Serialize)]
pub struct SensorDocument {
    /// Name of the sensor.
    pub name: String,
    /// Lag of the sensor, s.
    pub lag_s: f64,
}

/// Curves of an axis.
#[derive(Clone, Debug, Serialize)]
pub struct AxisDocument {
    /// Letter of the axis.
    pub axis: char,
    /// Curves against each sensor and against the spindle's speed.
    pub curves: Vec<CurveDocument>,
    /// Root mean square of the fit's residuals in its own cycles, µm.
    pub rms_um: f64,
    /// Condition number of the fit.
    pub condition: f64,
}

/// A curve.
#[derive(Clone, Debug, Serialize)]
pub struct CurveDocument {
    /// Name of the sensor, or `spindle`.
    pub of: String,
    /// Knots, °C or rpm.
    pub knots: Vec<f64>,
    /// Offset or growth at the knots, µm.
    pub offset_um: Vec<f64>,
    /// Standard errors of `offset_um`.
    pub offset_error_um: Vec<f64>,
    /// Slope at the knots, µm/m, or tilt, µrad.
    pub slope: Vec<f64>,
    /// Standard errors of `slope`.
    pub slope_error: Vec<f64>,
}

/// A sensor omitted from the model.
#[derive(Clone, Debug, Serialize)]
pub struct LeftOutDocument {
    /// Name of the sensor.
    pub name: String,
    /// Range over which it moved, K or rpm.
    pub range: f64,
    /// Reason for the omission.
    pub reason: &'static str,
}

/// A speed that occurs in only one fitted cycle, so that no other predicts it.
#[derive(Clone, Debug, Serialize)]
pub struct UnconfirmedDocument {
    /// The speed.
    pub rpm: f64,
    /// Number of the cycle.
    pub cycle: u32,
}

/// Rows missing in an evenly sampled record.
#[derive(Clone, Debug, Serialize)]
pub struct MissingDocument {
    /// Line of the first row at or after the time of the first missing one.
    pub line: u32,
    /// Number of the cycle.
    pub cycle: u32,
    /// Number of missing rows at all measuring points together.
    pub rows: usize,
    /// Longest time without a row of one measuring point, s.
    pub found_s: f64,
    /// Interval between the point's rows elsewhere, s.
    pub interval_s: f64,
}

/// `line 57: 1 row of cycle 2 is missing, 600 s where rows are 300 s apart`.
impl fmt::Display for MissingDocument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let MissingDocument { line, cycle, rows, found_s, interval_s } = self;
        let are =
            if *rows == 1 { "row of cycle {} is" } else { "rows of cycle {} are" }.replace("{}", &cycle.to_string());
        write!(f, "line {line}: {rows} {are} missing, {found_s:.0} s where rows are {interval_s:.0} s apart")
    }
}

/// Drift of an axis in a cycle.
#[derive(Clone, Debug, Serialize)]
pub struct CycleDocument {
    /// Letter of the axis.
    pub axis: char,
    /// Number of the cycle.
    pub cycle: u32,
    /// Whether the cycle was excluded from the fit.
    pub held_out: bool,
    /// Largest drift since the cycle began, µm.
    pub drift_um: f64,
    /// Largest residual, µm.
    pub left_um: f64,
    /// Root mean square of the drift.
    pub drift_rms_um: f64,
    /// Root mean square of the residual.
    pub left_rms_um: f64,
}

/// Repeatability of an axis beside the residual of the held-out cycles; root mean squares, µm, each about the mean of its cycle.
#[derive(Clone, Debug, Serialize)]
pub struct RepeatabilityDocument {
    /// Letter of the axis.
    pub axis: char,
    /// Drift of the held-out cycles.
    pub drift_um: f64,
    /// Residual of the held-out cycles.
    pub left_um: f64,
    /// Deviation of a cycle from another one in which all sensors agree, now and in the past: no model of these sensors predicts
    /// it; `None` if no two cycles come to the same temperatures.
    pub repeat_um: Option<f64>,
    /// Residual without that deviation: the most that another model could remove.
    pub model_um: Option<f64>,
    /// Number of rows compared.
    pub rows: usize,
}

fn curve(of: &str, knots: &[f64], values: &[Coefficient]) -> CurveDocument {
    let column = |part: usize, scale: f64, take: fn(&Coefficient) -> [f64; 2]| {
        values.iter().map(|value| scale * take(value)[part]).collect()
    };
    CurveDocument {
        of: of.into(),
        knots: knots.to_vec(),
        offset_um: column(0, 1e3, |at| at.value),
        offset_error_um: column(0, 1e3, |at| at.standard_error),
        slope: column(1, 1e6, |at| at.value),
        slope_error: column(1, 1e6, |at| at.standard_error),
    }
}

fn repeatability(own: &Repeatability) -> RepeatabilityDocument {
    let model = |repeat: f64| 1e3 * (own.left_mm * own.left_mm - repeat * repeat).max(0.0).sqrt();
    RepeatabilityDocument {
        axis: own.axis.letter(),
        drift_um: 1e3 * own.drift_mm,
        left_um: 1e3 * own.left_mm,
        repeat_um: own.repeat_mm.map(|mm| 1e3 * mm),
        model_um: own.repeat_mm.map(model),
        rows: own.rows,
    }
}

impl FittedRecording {
    /// The document.
    pub fn document(&self) -> ThermalDocument {
        let model = &self.fit.model;
        let axes = self.fit.axes.iter().map(|of| {
            let sensors = model.sensors.iter().zip(&of.sensors);
            let sensors = sensors.map(|(sensor, values)| curve(&sensor.name, &sensor.knots_c, values));
            let spindle = model.spindle.iter().map(|spindle| curve("spindle", &spindle.knots_rpm, &of.spindle));
            AxisDocument {
                axis: of.axis.letter(),
                curves: sensors.chain(spindle).collect(),
                rms_um: 1e3 * of.rms_mm,
                condition: of.condition,
            }
        });
        let cycles: Vec<CycleDocument> = self
            .figures
            .iter()
            .map(|own| CycleDocument {
                axis: own.axis.letter(),
                cycle: own.cycle,
                held_out: own.held_out,
                drift_um: 1e3 * own.drift_mm,
                left_um: 1e3 * own.left_mm,
                drift_rms_um: 1e3 * own.drift_rms_mm,
                left_rms_um: 1e3 * own.left_rms_mm,
            })
            .collect();
        let most = |of: fn(&CycleDocument) -> f64| cycles.iter().filter(|own| own.held_out).map(of).fold(0.0, f64::max);
        let left_out = self.fit.left_out.iter().map(|out| LeftOutDocument {
            name: out.name.clone(),
            range: out.range,
            reason: if out.still { "it hardly moves" } else { "the others predict as well without it" },
        });
        ThermalDocument {
            rows: self.recording.record.samples.len(),
            reference_c: self.reference_c,
            sensors: model
                .sensors
                .iter()
                .map(|sensor| SensorDocument { name: sensor.name.clone(), lag_s: sensor.lag_s })
                .collect(),
            spindle_lag_s: model.spindle.as_ref().map(|spindle| spindle.lag_s),
            axes: axes.collect(),
            covariance: self.covariance(),
            left_out: left_out.collect(),
            unconfirmed: self.fit.unconfirmed.iter().map(|&(rpm, cycle)| UnconfirmedDocument { rpm, cycle }).collect(),
            missing: self.fit.missing.iter().map(|own| self.recording.missing(own)).collect(),
            predicted_um: self.fit.predicted_mm.map(|mm| 1e3 * mm),
            repeatability: self.repeatability.iter().map(repeatability).collect(),
            held_out_um: [most(|own| own.drift_um), most(|own| own.left_um)],
            cycles,
        }
    }

    fn covariance(&self) -> CovarianceDocument {
        let model = &self.fit.model;
        let names = || model.sensors.iter().map(|sensor| (sensor.name.as_str(), "um/m")).chain([("spindle", "urad")]);
        let mut estimates = Vec::new();
        for of in &self.fit.axes {
            for ((name, slope), knots) in names().zip(of.sensors.iter().chain([&of.spindle])) {
                for (k, at) in knots.iter().enumerate() {
                    let parts = [("offset_um", "um", 1e3), ("slope", slope, 1e6)].into_iter().zip(at.value);
                    estimates.extend(parts.map(|((key, unit, factor), value)| {
                        let name = format!("{}.{name}.{key}[{k}]", of.axis.letter());
                        Estimate { name, unit, factor, value }
                    }));
                }
            }
        }
        CovarianceDocument::of_fitted(estimates, |i, j| self.fit.covariance[i][j])
    }
}
