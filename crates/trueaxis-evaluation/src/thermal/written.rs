//! Writing `thermal.toml`.

use super::FittedRecording;
use super::shown::DEGREES_OF_FREEDOM;
use crate::shown::half_width;
use std::fmt::Write;
use trueaxis::Axis;
use trueaxis_metrology::thermal::Coefficient;
use trueaxis_report::number::significant;
use trueaxis_tables::text::{acts, short};

/// The text of a `thermal.toml`: the fitted curves, each followed by `±` and expanded uncertainties, which are not read back.
pub fn written(found: &FittedRecording) -> String {
    let file = found.recording.file.file_name().unwrap_or_default().to_string_lossy().replace(acts, " ");
    let document = found.document();
    let [drift, left] = document.held_out_um;
    let mut text = format!(
        "# Thermal growth found in {file} by `trueaxis thermal fit`; the expanded uncertainties, 95 %, after ± are not read.\n\
         # Held-out cycles {:?}: largest drift {} µm, left {} µm.\n\
         reference_temperature_c = {}\n",
        found.fit.held_out,
        significant(drift, 3),
        significant(left, 3),
        short(found.reference_c)
    );
    let model = &found.fit.model;
    let list = |values: &[f64]| values.iter().map(|value| short(*value)).collect::<Vec<_>>().join(", ");
    for sensor in &model.sensors {
        let _ = write!(
            text,
            "\n[[sensor]]\nname = {:?}\nlag_s = {}\nplausible_c = [{}]\njump_k = {}\nrate_k_per_min = {}\nstuck_s = {}\n\
             elsewhere_k = {}\nknots_c = [{}]\n",
            sensor.name,
            short(sensor.lag_s),
            list(&sensor.plausible_c),
            short(sensor.jump_k[0]),
            short(sensor.jump_k[1]),
            short(sensor.stuck_s),
            short(sensor.elsewhere_k),
            list(&sensor.knots_c)
        );
    }
    if let Some(spindle) = &model.spindle {
        let _ = write!(
            text,
            "\n[spindle]\nlag_s = {}\nknots_rpm = [{}]\n",
            short((10.0 * spindle.lag_s).round() / 10.0),
            list(&spindle.knots_rpm)
        );
        for (rpm, cycle) in &found.fit.unconfirmed {
            let _ = writeln!(
                text,
                "# {} rpm was run in cycle {cycle} only: no other cycle confirms its values.",
                short(*rpm)
            );
        }
    }
    for (axis, of) in model.axes.iter().zip(&found.fit.axes) {
        let letter = axis.axis.letter();
        let _ = write!(text, "\n[axis.{letter}]\ndatum_mm = {}\n", short(axis.datum));
        if let Some(left) = left_um(found, axis.axis) {
            let _ = writeln!(text, "uncertainty_um = {}  # what the held-out cycles leave, RMS", short(left));
        }
        let mut put = |section: &str, [offset, slope]: [&str; 2], values: &[Coefficient]| {
            let _ = write!(text, "\n[axis.{letter}.{section}]\n");
            for (part, key, scale) in [(0, offset, 1e3), (1, slope, 1e6)] {
                let column = |take: fn(&Coefficient) -> [f64; 2]| -> Vec<f64> {
                    values.iter().map(|value| scale * take(value)[part]).collect()
                };
                let (own, errors) = (column(|at| at.value), column(|at| at.standard_error));
                if own.iter().any(|value| *value != 0.0) {
                    let errors = errors.iter().map(|error| significant(half_width(*error, DEGREES_OF_FREEDOM), 2));
                    let errors: Vec<String> = errors.collect();
                    let _ = writeln!(text, "{key} = [{}]  # ± {}", list(&own), errors.join(", "));
                }
            }
        };
        for (sensor, values) in model.sensors.iter().zip(&of.sensors) {
            if values.iter().any(|at| at.value != [0.0; 2]) {
                put(&format!("sensor.{}", sensor.name), ["offset_um", "slope_um_per_m"], values);
            }
        }
        if of.spindle.iter().any(|at| at.value != [0.0; 2]) {
            put("spindle", ["growth_um", "tilt_urad"], &of.spindle);
        }
    }
    text
}

/// Root mean square of what the cycles held out leave of an axis' drift, µm; `None` if no cycle was held out.
fn left_um(found: &FittedRecording, axis: Axis) -> Option<f64> {
    let out = || found.figures.iter().filter(|of| of.axis == axis && of.held_out);
    let count = out().count();
    let left = 1e3 * (out().map(|of| of.left_rms_mm.powi(2)).sum::<f64>() / count.max(1) as f64).sqrt();
    (count > 0).then(|| (100.0 * left).round() / 100.0)
}
