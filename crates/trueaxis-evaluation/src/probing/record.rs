//! RECORD.csv of a probing test.

use crate::range::OutOfRange;
use crate::record;
use crate::rows::{Column, Rows};
use anyhow::{Result, anyhow};
use serde::Deserialize;
use std::collections::HashMap;
use trueaxis_metrology::circles::least_squares;
use trueaxis_metrology::sphere;
use trueaxis_tables::text::counted;

/// Columns of a record.
pub const COLUMNS: [Column; 5] = [
    Column { name: "x_mm", needed: true },
    Column { name: "y_mm", needed: true },
    Column { name: "z_mm", needed: false },
    Column { name: "run", needed: false },
    Column { name: "spindle_deg", needed: false },
];

/// Minimum number of points of a ring: any three fit a circle exactly.
const LEAST_ON_RING: usize = 4;
/// Largest share of the nominal diameter by which a measured one may differ.
const MOST_OFF: f64 = 0.25;

/// Largest distance of a point from its circle, sphere or mean, mm: a point farther off was not probed on the feature.
const MOST_FORM_MM: f64 = 0.5;

/// The feature probed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Feature {
    /// A ring, its points in X and Y.
    Ring,
    /// A sphere.
    Sphere,
    /// One point of a surface, probed repeatedly.
    Point,
}

/// Checks the diameter of a ring or sphere.
///
/// # Errors
/// A diameter outside 0.1 to 10000 mm.
pub fn check(diameter_mm: Option<f64>) -> Result<(), OutOfRange> {
    OutOfRange::check("diameter_mm", diameter_mm, 0.1..=1e4, "mm")
}

/// A run: the points of one measurement of the feature.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Measured {
    pub(super) run: i64,
    pub(super) spindle_deg: f64,
    pub(super) points: Vec<[f64; 3]>,
    pub(super) centre: [f64; 3],
    pub(super) diameter: Option<f64>,
    pub(super) form: Option<f64>,
}

/// The record of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// The feature probed.
    pub feature: Feature,
    /// Calibrated diameter of the feature, mm, if known.
    pub diameter_mm: Option<f64>,
    pub(super) runs: Vec<Measured>,
    /// Whether the spindle was oriented.
    pub(super) oriented: bool,
}

impl Record {
    /// Reads all rows of [`COLUMNS`]; `diameter_mm` of the ring or sphere.
    ///
    /// # Errors
    /// A row that cannot be read, too few points, points that do not form a circle or sphere or form one of another size, a
    /// point repeated or half a millimetre off the others, a run with fewer points than the others, a spindle that turns
    /// within a run.
    pub fn read(rows: &mut Rows<'_, 5>, feature: Feature, diameter_mm: Option<f64>) -> Result<Record> {
        if feature != Feature::Ring && !rows.present[2] {
            return Err(rows.error(1, "z_mm", "no such column", "z_mm for a sphere or a point"));
        }
        let oriented = rows.present[4];
        let mut runs: Vec<Measured> = Vec::new();
        let mut seen = HashMap::new();
        let (mut lines, mut readings) = (Vec::new(), Vec::new());
        while let Some(row) = rows.next()? {
            let [x, y, z, run, spindle_deg] = row.values;
            if run.fract() != 0.0 {
                return Err(rows.error(row.line, "run", run, "the number of a run"));
            }
            let key = [x, y, z, run].map(|value| (value + 0.0).to_bits());
            if let Some(first) = seen.insert(key, row.line).filter(|_| feature != Feature::Point) {
                let found = format!("the same point as in line {first}");
                return Err(rows.error(row.line, "x_mm", found, "each point once a run"));
            }
            lines.push(row.line);
            readings.push([x, y, z]);
            match runs.iter_mut().find(|known| known.run == run as i64) {
                Some(known) if known.spindle_deg != spindle_deg => {
                    let needed = format!("{} as in the run's first line", known.spindle_deg);
                    return Err(rows.error(row.line, "spindle_deg", spindle_deg, needed));
                }
                Some(known) => known.points.push([x, y, z]),
                None => runs.push(Measured {
                    run: run as i64,
                    spindle_deg,
                    points: vec![[x, y, z]],
                    centre: [0.0; 3],
                    diameter: None,
                    form: None,
                }),
            }
        }
        if feature == Feature::Point {
            let sums: Vec<f64> = readings.iter().map(|[x, y, z]| x + y + z).collect();
            if let Some(stuck) = record::longest(&sums) {
                return Err(stuck.error(rows, &lines, "x_mm", 1.0));
            }
        }
        let file = rows.file.display().to_string();
        let counts: Vec<Vec<usize>> = runs.iter().map(|run| (0..run.points.len()).collect()).collect();
        if let Some(missing) = record::missing(&counts, |one, other| one == other) {
            let ([run, like], [found, needed]) = ([missing.part, missing.like[0]].map(|k| runs[k].run), missing.rows);
            return Err(anyhow!(
                "{file}: run {run}: found {}, needed {needed} as in run {like}",
                counted(found, "point")
            ));
        }
        for run in &mut runs {
            solve(run, feature, diameter_mm).map_err(|why| anyhow!("{file}: run {}: {why}", run.run))?;
            let radius = 0.5 * run.diameter.unwrap_or(0.0);
            let off = |point: &[f64; 3]| {
                let flat = feature == Feature::Ring;
                let [x, y, z] = [0, 1, 2].map(|c| if flat && c == 2 { 0.0 } else { point[c] - run.centre[c] });
                (x.hypot(y).hypot(z) - radius).abs()
            };
            let worst = run.points.iter().max_by(|one, other| off(one).total_cmp(&off(other)));
            if let Some(worst) = worst.filter(|worst| off(worst) > MOST_FORM_MM) {
                let line = readings.iter().position(|own| own == worst).map_or(1, |k| lines[k]);
                let found =
                    format!("a point {:.3} mm off the feature through the others of run {}", off(worst), run.run);
                return Err(rows.error(
                    line,
                    "x_mm",
                    found,
                    format!("at most {MOST_FORM_MM} mm, a point of the feature"),
                ));
            }
        }
        Ok(Record { feature, diameter_mm, runs, oriented })
    }
}

fn solve(run: &mut Measured, feature: Feature, nominal: Option<f64>) -> Result<(), String> {
    let count = run.points.len();
    match feature {
        Feature::Ring => {
            if count < LEAST_ON_RING {
                return Err(format!("found {}, needed {LEAST_ON_RING} (36 in ISO 230-10)", counted(count, "point")));
            }
            let flat: Vec<[f64; 2]> = run.points.iter().map(|[x, y, _]| [*x, *y]).collect();
            let circle = least_squares(&flat).map_err(|error| {
                format!("found points that do not form a circle ({error}), needed points all round a ring")
            })?;
            let heights = run.points.iter().map(|point| point[2]).sum::<f64>() / count as f64;
            run.centre = [circle.centre[0], circle.centre[1], heights];
            (run.diameter, run.form) = (Some(2.0 * circle.radius), Some(circle.zone));
        }
        Feature::Sphere => {
            let sphere = sphere::least_squares(&run.points).map_err(|error| error.to_string())?;
            run.centre = sphere.centre;
            (run.diameter, run.form) = (Some(2.0 * sphere.radius), Some(sphere.zone));
        }
        Feature::Point => {
            run.centre = [0, 1, 2].map(|c| run.points.iter().map(|point| point[c]).sum::<f64>() / count as f64);
        }
    }
    if let (Some(found), Some(nominal)) = (run.diameter, nominal)
        && (found / nominal - 1.0).abs() > MOST_OFF
    {
        return Err(format!(
            "found a diameter of {found:.3} mm, needed within {:.0} % of {nominal} mm (the artefact, or its unit, is another)",
            100.0 * MOST_OFF
        ));
    }
    Ok(())
}
