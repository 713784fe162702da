//! Errors of a rotary axis from readings of a ball while RTCP holds the tool at it: reads the file, and presents the result as
//! a document and as the axis' table.
//!
//! ```text
//! MEASURED.csv ─► Readings ─► identify ─► Identification: document, table, additions to a machine
//! ```
//!
//! The mathematics is in [`trueaxis_metrology::identification`].

mod document;
mod linear_axes;
mod machine;
mod readings;
mod shown;
mod table;

pub use document::{Angle, IdentificationDocument, SetUp, micro, names};
pub use readings::{COLUMNS, Readings, SAME_ANGLE_DEG};
pub use table::table;

use anyhow::{Context, Result, anyhow};
use trueaxis::Axis;
use trueaxis_metrology::identification::{
    AngleReadings, Ball, Identified, IdentifiedAngle, Offsets, identify as solve, lever,
};
use trueaxis_tables::{Machine, Table};

/// Condition number from which the set-ups are doubtful: a gauge error of 0.2 µm then gives errors of 20 µm.
const DOUBTFUL_CONDITION: f64 = 100.0;

/// A known machine: the sense of its axis is used, and its linear axes' own errors are removed.
#[derive(Clone, Copy, Debug)]
pub struct Known<'m> {
    /// The machine.
    pub machine: &'m Machine,
    /// Name in messages.
    pub file: &'m str,
    /// Position of X, Y, Z in the first set-up at the first angle, mm; RTCP moves them from there.
    pub start_mm: [f64; 3],
}

/// Result of [`identify`].
#[derive(Debug)]
pub struct Identification {
    /// Document to print.
    pub document: IdentificationDocument,
    readings: Readings,
    offsets: Offsets,
    direction: f64,
    errors: Identified,
}

/// The six errors of an axis at every angle of the readings; errors about the readings begin with `name`.
///
/// Cost: [`solve`], a least-squares fit of six unknowns per angle.
///
/// # Errors
/// A machine without that axis or with tables that the model refuses; readings that do not determine the errors.
pub fn identify(
    mut readings: Readings,
    name: &str,
    axis: Axis,
    offsets: Offsets,
    known: Option<Known<'_>>,
) -> Result<Identification> {
    let mut warnings = Vec::new();
    let mut direction = 1.0;
    if let Some(Known { machine, file, start_mm }) = known {
        let settings = machine
            .settings
            .axis(axis)
            .ok_or_else(|| anyhow!("{file}: found no axis {}, needed the axis that was measured", axis.letter()))?;
        direction = f64::from(settings.direction);
        let [x, y, z] = start_mm;
        warnings.push(format!(
            "the linear axes' own errors are removed, as {} predicts them from X {x}, Y {y}, Z {z} mm at the start",
            machine.settings.name
        ));
        let beyond = linear_axes::remove(&mut readings, machine, axis, direction, start_mm);
        if beyond.with_context(|| file.to_owned())? {
            warnings.push("RTCP takes a linear axis beyond its table, where the edge value is used".into());
        }
        let mut own = machine.settings.location.rotary.iter().zip([Axis::A, Axis::B, Axis::C]);
        if offsets == Offsets::Known && own.any(|(errors, of)| of == axis && *errors != [0.0; 6]) {
            let letter = axis.letter();
            warnings.push(format!(
                "{} has location errors of {letter}, which the errors found contain: set EX0{letter} to EC0{letter} to zero with a table of these",
                machine.settings.name
            ));
        }
    }
    let errors = solve(&readings.test(axis, direction), offsets).map_err(|refused| anyhow!("{name}: {refused}"))?;
    let worst = errors.angles.iter().map(|angle| angle.condition).fold(0.0, f64::max);
    if worst > DOUBTFUL_CONDITION {
        warnings.push(format!(
            "condition number {worst:.0}: the set-ups are nearly on one line, so the errors are that many times less accurate than the readings"
        ));
    }
    let document = IdentificationDocument::new(&readings, &errors, warnings);
    Ok(Identification { document, readings, offsets, direction, errors })
}

impl Identification {
    /// Reading minus model along X, Y, Z, µm: d − (e + ω × p + offset), by angle, then by set-up.
    pub fn residuals_um(&self) -> Vec<[f64; 3]> {
        let test = self.readings.test(self.errors.axis, self.direction);
        let of_angle = |(angle, readings): (&IdentifiedAngle, &AngleReadings)| {
            let [x, y, z, alpha, beta, gamma] = angle.errors;
            let of_set_up = |(set_up, (&ball, deviation)): (usize, (&Ball, &[f64; 3]))| {
                let [px, py, pz] = lever(test.axis, readings.angle_rad, ball).unwrap_or_default();
                let offset = self.errors.offsets_mm.get(set_up).copied().unwrap_or_default();
                let model = [x + beta * pz - gamma * py, y + gamma * px - alpha * pz, z + alpha * py - beta * px];
                [0, 1, 2].map(|i| 1e3 * (deviation[i] - model[i] - offset[i]))
            };
            test.balls.iter().zip(&readings.deviations_mm).enumerate().map(of_set_up).collect::<Vec<_>>()
        };
        self.errors.angles.iter().zip(&test.angles).flat_map(of_angle).collect()
    }

    /// The errors as the axis' table; adds remarks on it to the document's warnings.
    ///
    /// # Errors
    /// Angles from which no table can be built.
    pub fn table(&mut self) -> Result<Table> {
        let (table, note) = table::table(&self.readings.angles_deg, &self.errors)?;
        self.document.warnings.extend(note);
        Ok(table)
    }
}
