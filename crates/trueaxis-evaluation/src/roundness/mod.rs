//! Roundness and spindle error from three to six probes.

mod agreement;
mod document;
mod orbit;
mod polar;
mod radii;
mod shown;
mod trace;

pub use document::{
    AgreementEntry, Centres, Circles, Evaluation, HarmonicEntry, ProbeEntry, Revolution, RoundnessDocument, Spindle,
    SpindleDirection, Zones,
};
pub use orbit::orbit;
pub use polar::polar;
pub use radii::Radii;
pub use trace::{InterpolationError, Resampling};

use crate::probes::Probes;
use crate::record::{self, Channel};
use crate::rows::{Column, Row, Rows};
use anyhow::{Result, anyhow, bail};
use serde::{Deserialize, Serialize};
use trueaxis::error::Field;
use trueaxis::roundness::{Arm, Band, filter};
use trueaxis_metrology::cores::*;
use trueaxis_metrology::separation::{Agreement, Arrangement, NOISE_GAIN_LIMIT, Separation, Separator};
use trueaxis_tables::error::FileError;
use trueaxis_tables::text::counted;

/// Columns of the readings.
pub const COLUMNS: [Column; 7] = [
    Column { name: "h1_um", needed: true },
    Column { name: "h2_um", needed: true },
    Column { name: "h3_um", needed: true },
    Column { name: "h4_um", needed: false },
    Column { name: "h5_um", needed: false },
    Column { name: "h6_um", needed: false },
    Column { name: THETA, needed: false },
];
const THETA: &str = "theta_deg";
/// Place of [`THETA`] in [`COLUMNS`].
const THETA_AT: usize = 6;

/// A trace at N equidistant angles from 0, the mean of its whole revolutions; its rows must resolve a harmonic.
///
/// # Errors
/// Angles that do not increase, gaps wider than half a wave of the harmonic, less than a revolution.
fn resampled(trace: &[f64], theta_deg: &[f64], points: usize, harmonic: u16) -> Result<Vec<f64>> {
    let mut rows = trace::InMemory { readings: &[trace], theta_deg, next: 0, of_sensors: false };
    let (probes, _) = trace::read(&mut rows, 1, points, Band { first: 2, last: harmonic })?;
    let values = probes.first().map_or(&[][..], Vec::as_slice);
    let revolutions = values.len() / points;
    let mean = |i: usize| values.iter().skip(i).step_by(points).sum::<f64>() / revolutions as f64;
    Ok((0..points).map(mean).collect())
}

/// The probes' readings as channels.
fn channels(probes: &[Vec<f64>]) -> Vec<Channel<'_>> {
    COLUMNS.iter().zip(probes).map(|(column, values)| Channel { name: column.name, values, scale: 1.0 }).collect()
}

/// Settings of an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Points, band and angles.
    pub probes: Probes,
    /// Crank throw, wheel radius and pin radius of an arm that follows the pin, mm; if absent, the arm is fixed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm: Option<[f64; 3]>,
    /// Cut-off of the Gaussian filter, 15, 50, 150 or 500 undulations per revolution; if absent, no filter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upr: Option<u16>,
    /// Noise gain above which a harmonic is omitted.
    #[serde(default = "usual_limit")]
    pub noise_gain_limit: f64,
}

fn usual_limit() -> f64 {
    NOISE_GAIN_LIMIT
}

/// A checked request with its transforms planned.
pub struct Plan {
    separator: Separator,
    points: usize,
    band: Band,
    upr: Option<u16>,
    noise_gain_limit: f64,
}

/// The readings of each probe, all revolutions of N readings in sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// Three to six probes, µm.
    pub probes: Vec<Vec<f64>>,
    /// Resampling of readings that have their own angles.
    pub resampling: Option<Resampling>,
}

impl Request {
    /// Checks the request and plans the transforms.
    ///
    /// # Errors
    /// An invalid option, under its command-line name.
    pub fn plan(&self) -> Result<Plan> {
        let (points, band) = (self.probes.points()?, self.probes.band()?);
        let separator = self.separator(band)?;
        if let Some(cut_off) = self.upr {
            filter::check(cut_off).map_err(|error| anyhow!("--upr: found {cut_off}, needed {}", error.needed))?;
        }
        Ok(Plan { separator, points, band, upr: self.upr, noise_gain_limit: self.noise_gain_limit })
    }

    fn separator(&self, band: Band) -> Result<Separator> {
        let ratio = match self.arm {
            None => 0.0,
            Some([crank_mm, wheel_mm, pin_mm]) => Arm { crank_mm, wheel_mm, pin_mm }.ratio().map_err(|error| {
                let name = match error.field {
                    Field::ArmWheel => "RS",
                    Field::ArmPin => "RW",
                    _ => "R",
                };
                anyhow!("--arm {name}: found {} mm, needed {}", error.found, error.needed)
            })?,
        };
        let limit = self.noise_gain_limit;
        if !(limit.is_finite() && limit > 0.0) {
            bail!("--noise-gain-limit: found {limit}, needed a number above 0");
        }
        let separator = match self.probes.places()? {
            Some(places) => Separator::of_places(&places, self.probes.points()?, band, limit, ratio)?,
            None => Separator::new(self.probes.gain()?, band, limit, ratio)?,
        };
        if separator.suppressed().count() == band.iter().count() {
            bail!("--noise-gain-limit: found {limit}, which leaves out every harmonic, needed a limit that keeps some");
        }
        Ok(separator)
    }
}

impl Plan {
    /// Number of points per revolution.
    pub fn points(&self) -> usize {
        self.points
    }

    /// The arrangement of the probes.
    pub fn arrangement(&self) -> &Arrangement {
        self.separator.arrangement()
    }

    /// Reads all rows of [`COLUMNS`]; resamples rows with angles.
    ///
    /// # Errors
    /// A row that cannot be read, a partial revolution, a probe that stops changing half-way, or angles that cannot be
    /// resampled.
    pub fn read(&self, rows: &mut Rows<'_, 7>) -> Result<Readings> {
        self.check_columns(rows)?;
        let count = self.arrangement().probes();
        if rows.present[THETA_AT] {
            let (probes, resampling) = trace::read(rows, count, self.points, self.band)?;
            return Ok(Readings { probes, resampling: Some(resampling) });
        }
        let mut probes = vec![Vec::new(); count];
        let mut lines = Vec::new();
        while let Some(Row { line, values }) = rows.next()? {
            for (probe, value) in probes.iter_mut().zip(values) {
                probe.push(value);
            }
            lines.push(line);
        }
        let (points, count) = (self.points, rows.count);
        if !count.is_multiple_of(points) {
            return Err(FileError {
                file: rows.file.clone(),
                line: lines.last().copied(),
                column: None,
                found: format!(
                    "{} ({} and {})",
                    counted(count, "row"),
                    counted(count / points, "revolution"),
                    counted(count % points, "row")
                ),
                needed: format!("whole revolutions of {points} rows, or a column theta_deg with the angle of each row"),
            }
            .into());
        }
        record::alive(rows, &lines, &channels(&probes))?;
        Ok(Readings { probes, resampling: None })
    }

    /// Refuses a file whose probes are not those of the request.
    fn check_columns(&self, rows: &Rows<'_, 7>) -> Result<()> {
        let count = self.arrangement().probes();
        let columns = COLUMNS.iter().zip(rows.present).take(THETA_AT).enumerate();
        for (probe, (column, present)) in columns {
            if present != (probe < count) {
                let found = if present { "a column" } else { "no column" };
                return Err(FileError {
                    file: rows.file.clone(),
                    line: Some(1),
                    column: None,
                    found: format!("{found} {}", column.name),
                    needed: format!(
                        "the readings of {count} probes, as many as angles are given (--angles-deg for four to six)"
                    ),
                }
                .into());
            }
        }
        Ok(())
    }

    /// Resamples readings, one of each probe per angle and at least one, as [`Plan::read`] resamples rows with angles.
    ///
    /// # Errors
    /// Angles that cannot be resampled; rows are named by index.
    pub fn resample(&self, readings: &[&[f64]], theta_deg: &[f64]) -> Result<Readings> {
        let mut rows = trace::InMemory { readings, theta_deg, next: 0, of_sensors: true };
        let (probes, resampling) = trace::read(&mut rows, readings.len(), self.points, self.band)?;
        Ok(Readings { probes, resampling: Some(resampling) })
    }

    /// Separates every revolution, on all cores; calls `done` after each.
    ///
    /// # Errors
    /// Readings with a partial revolution.
    pub fn separate(&self, readings: &Readings, done: impl Fn() + Sync) -> Result<Vec<Separation>> {
        let rows = readings.probes.first().map_or(0, Vec::len);
        (0..rows.div_ceil(self.points))
            .into_par_iter()
            .map_init(
                || self.separator.workspace(),
                |workspace, turn| {
                    done();
                    let revolution = turn * self.points..rows.min((turn + 1) * self.points);
                    let probes: Vec<&[f64]> =
                        readings.probes.iter().map(|probe| probe.get(revolution.clone()).unwrap_or_default()).collect();
                    Ok(self.separator.separate_in(workspace, &probes)?)
                },
            )
            .collect()
    }

    /// Doubts about the request, and contradictions in the readings.
    ///
    /// # Errors
    /// Readings with a partial revolution.
    pub fn warnings(&self, separations: &[Separation], readings: &Readings) -> Result<Vec<String>> {
        Ok(self.doubts(separations, readings, self.agreement(readings)?.as_ref()))
    }

    fn doubts(&self, separations: &[Separation], readings: &Readings, agreement: Option<&Agreement>) -> Vec<String> {
        let mut warnings = Vec::new();
        let suppressed: Vec<String> = self.separator.suppressed().map(|k| k.to_string()).collect();
        if !suppressed.is_empty() {
            let (numbers, limit) = (suppressed.join(", "), self.noise_gain_limit);
            warnings.push(if suppressed.len() == 1 {
                format!("harmonic {numbers} is omitted: its noise gain exceeds {limit}")
            } else {
                format!("harmonics {numbers} are omitted: their noise gain exceeds {limit}")
            });
        }
        if let Some(cut_off) = self.upr {
            let (points, last) = (self.points, self.band.last);
            if !filter::has_enough_points(points, cut_off) {
                let needed = 7 * u32::from(cut_off);
                warnings
                    .push(format!("{points} points are few for {cut_off} UPR: ISO 12181-2 asks for at least {needed}"));
            }
            if cut_off > last {
                warnings.push(format!("the band ends at harmonic {last}, below the cut-off of {cut_off} UPR"));
            }
        }
        warnings.extend(agreement.and_then(|found| agreement::disagreement(found, agreement::noise(&readings.probes))));
        let suppressed: Vec<u16> = self.separator.suppressed().collect();
        let kept = self.band.iter().filter(|k| !suppressed.contains(k));
        warnings.extend(agreement::contradictions(
            self.arrangement(),
            self.points,
            &readings.probes,
            separations,
            kept,
        ));
        warnings
    }

    /// How far four to six probes disagree.
    fn agreement(&self, readings: &Readings) -> Result<Option<Agreement>> {
        let probes: Vec<&[f64]> = readings.probes.iter().map(Vec::as_slice).collect();
        Ok(self.separator.agreement(&probes)?)
    }

    /// Zones, harmonics and error motion of separated revolutions, with the warnings.
    ///
    /// # Errors
    /// A profile without a reference circle.
    pub fn evaluate(&self, separations: &[Separation], readings: &Readings) -> Result<Evaluation> {
        let mut evaluation = Evaluation::new(&self.separator, separations, self.upr)?;
        evaluation.document.resampling = readings.resampling.clone();
        let agreement = self.agreement(readings)?;
        evaluation.document.warnings = self.doubts(separations, readings, agreement.as_ref());
        evaluation.document.agreement = agreement.map(|found| AgreementEntry::new(&found, self.arrangement()));
        Ok(evaluation)
    }
}

impl Readings {
    /// How readings with angles were resampled, in one line.
    pub fn note(&self, points: usize) -> Option<String> {
        let resampling = self.resampling.as_ref()?;
        let InterpolationError { max, rms } = resampling.interpolation_error_um;
        Some(format!(
            "{} rows resampled to {} revolutions of {points}; interpolation error at most {max:.2e} µm, {rms:.2e} µm RMS{}",
            resampling.rows,
            self.probes.first().map_or(0, Vec::len) / points,
            match resampling.unused_rows {
                0 => String::new(),
                unused => format!("; not used after the last whole revolution: {}", counted(unused, "row")),
            }
        ))
    }
}
