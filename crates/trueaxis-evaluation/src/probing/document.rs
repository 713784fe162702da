//! Figures of a probing test, as a document.

use super::record::{Feature, Measured, Record};
use crate::diagonal::Value;
use serde::Serialize;
use trueaxis_metrology::linear_fit::LinearFit;
use trueaxis_tables::text::counted;

/// A run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// Number of the run.
    pub run: i64,
    /// Number of points.
    pub points: usize,
    /// Orientation of the spindle; null if not recorded.
    pub spindle_deg: Option<f64>,
    /// Centre, or mean of the points.
    pub centre_mm: [f64; 3],
    /// Diameter of the least-squares circle or sphere through the tip's centres.
    pub diameter_mm: Option<f64>,
    /// P_FTU,2D for a ring, P_FTU,3D for a sphere.
    pub form_um: Option<f64>,
}

/// Scatter of places along X, Y, Z.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Number of places.
    pub count: usize,
    /// Largest minus smallest.
    pub range_um: [f64; 3],
    /// Standard deviation; null for a single place.
    pub standard_deviation_um: Option<[f64; 3]>,
}

/// Offset of the stylus tip from the spindle's axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Offset {
    /// Along X at spindle orientation 0.
    pub x_um: Value,
    /// Along Y at spindle orientation 0.
    pub y_um: Value,
    /// Length of the offset.
    pub length_um: f64,
}

/// The JSON document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProbingDocument {
    /// "ring", "sphere" or "point".
    pub feature: &'static str,
    /// Results by run.
    pub runs: Vec<Run>,
    /// Largest P_FTU over the runs; null for points.
    pub p_ftu_um: Option<f64>,
    /// `P_FTU,2D` or `P_FTU,3D`.
    pub p_ftu_name: Option<&'static str>,
    /// Repeatability of a single point, over all points of a feature `point`.
    pub point_repeatability: Option<Spread>,
    /// Repeatability of a location: the runs' centres, corrected for spindle orientation.
    pub location_repeatability: Option<Spread>,
    /// Offset of the stylus tip; null without orientations.
    pub tip_offset: Option<Offset>,
    /// Effective diameter of the tip from the calibrated diameter; null without one.
    pub effective_tip_diameter_mm: Option<f64>,
    /// Range of the diameters over the runs.
    pub diameter_range_um: Option<f64>,
    /// Remarks on the figures.
    pub notes: Vec<String>,
}

/// Angles closer than this are the same orientation, degrees.
const SAME_DEG: f64 = 1.0;

fn spread(places: &[[f64; 3]]) -> Spread {
    let n = places.len() as f64;
    let of = |c: usize| places.iter().map(move |place| 1e3 * place[c]);
    // Relative to the first, so that a micrometre in a metre keeps its digits.
    let first = places.first().copied().unwrap_or_default();
    let range_um = [0, 1, 2].map(|c| of(c).fold(f64::MIN, f64::max) - of(c).fold(f64::MAX, f64::min));
    let deviation = [0, 1, 2].map(|c| {
        let mean = of(c).map(|v| v - 1e3 * first[c]).sum::<f64>() / n;
        (of(c).map(|v| (v - 1e3 * first[c] - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
    });
    Spread { count: places.len(), range_um, standard_deviation_um: (places.len() > 1).then_some(deviation) }
}

/// Tip offset from centres at several orientations; every centre corrected for it.
fn offset(runs: &[Measured]) -> Option<(Offset, Vec<[f64; 3]>)> {
    let turned = runs.iter().any(|run| (run.spindle_deg - runs[0].spindle_deg).abs() > SAME_DEG);
    if !turned {
        return None;
    }
    let first = runs[0].centre;
    let mut fit = LinearFit::new(4);
    let row = |run: &Measured| {
        let (sin, cos) = run.spindle_deg.to_radians().sin_cos();
        [[1.0, 0.0, cos, -sin], [0.0, 1.0, sin, cos]]
    };
    for run in runs {
        for (c, row) in row(run).into_iter().enumerate() {
            fit.add(&row, run.centre[c] - first[c], 1.0);
        }
    }
    let found = fit.solve();
    if found.rank < 4 {
        return None;
    }
    let [_, _, x, y] = found.values[..] else { return None };
    let (sigma, factors) = (found.sigma(), &found.error_factors);
    let degrees_of_freedom = found.degrees_of_freedom() as f64;
    let value = |value: f64, k: usize| Value {
        value: 1e3 * value,
        standard_error: 1e3 * sigma * factors[k],
        degrees_of_freedom,
    };
    let left = runs.iter().map(|run| {
        let [of_x, of_y] = row(run).map(|row| row.iter().zip(&found.values).skip(2).map(|(a, v)| a * v).sum::<f64>());
        [run.centre[0] - of_x, run.centre[1] - of_y, run.centre[2]]
    });
    Some((Offset { x_um: value(x, 2), y_um: value(y, 3), length_um: 1e3 * x.hypot(y) }, left.collect()))
}

impl ProbingDocument {
    /// The document of a record.
    pub fn new(record: &Record) -> ProbingDocument {
        let (name, p_ftu_name) = match record.feature {
            Feature::Ring => ("ring", Some("P_FTU,2D")),
            Feature::Sphere => ("sphere", Some("P_FTU,3D")),
            Feature::Point => ("point", None),
        };
        let runs = &record.runs;
        let oriented = if record.oriented && record.feature != Feature::Point { offset(runs) } else { None };
        let centres: Vec<[f64; 3]> = match &oriented {
            Some((_, left)) => left.clone(),
            None => runs.iter().map(|run| run.centre).collect(),
        };
        let diameters = || runs.iter().filter_map(|run| run.diameter);
        let mean = diameters().sum::<f64>() / diameters().count().max(1) as f64;
        let tip = record.diameter_mm.filter(|_| diameters().count() > 0).map(|nominal| match record.feature {
            Feature::Ring => nominal - mean,
            _ => mean - nominal,
        });
        let mut notes = Vec::new();
        let usual = match record.feature {
            Feature::Ring => 36,
            Feature::Sphere => 25,
            Feature::Point => 10,
        };
        if let Some(few) = runs.iter().map(|run| run.points.len()).min().filter(|count| *count < usual) {
            notes.push(format!("a run has {}; ISO 230-10 takes {usual}", counted(few, "point")));
        }
        if tip.is_none() && record.feature != Feature::Point {
            notes.push("the tip's effective diameter needs the calibrated one of the artefact: --diameter-mm".into());
        }
        if tip.is_some_and(|tip| tip <= 0.0) {
            notes.push("the tip's effective diameter is negative: a ring is probed inside, a sphere outside".into());
        }
        if record.oriented && oriented.is_none() && record.feature != Feature::Point {
            notes.push(
                "one orientation of the spindle does not determine the tip's offset: turn it by 180°, or by 90° four times"
                    .into(),
            );
        }
        ProbingDocument {
            feature: name,
            runs: runs
                .iter()
                .map(|run| Run {
                    run: run.run,
                    points: run.points.len(),
                    spindle_deg: record.oriented.then_some(run.spindle_deg),
                    centre_mm: run.centre,
                    diameter_mm: run.diameter,
                    form_um: run.form.map(|mm| 1e3 * mm),
                })
                .collect(),
            p_ftu_um: runs.iter().filter_map(|run| run.form).reduce(f64::max).map(|mm| 1e3 * mm),
            p_ftu_name,
            point_repeatability: (record.feature == Feature::Point)
                .then(|| spread(&runs.iter().flat_map(|run| run.points.iter().copied()).collect::<Vec<_>>())),
            location_repeatability: (record.feature != Feature::Point && runs.len() > 1).then(|| spread(&centres)),
            tip_offset: oriented.map(|(offset, _)| offset),
            effective_tip_diameter_mm: tip,
            diameter_range_um: (diameters().count() > 1)
                .then(|| 1e3 * (diameters().fold(f64::MIN, f64::max) - diameters().fold(f64::MAX, f64::min))),
            notes,
        }
    }
}
