//! Readings with individual angles, resampled to N equidistant angles per revolution.

use super::{THETA, THETA_AT, channels};
use crate::record;
use crate::rows::{Row, Rows};
use anyhow::{Result, anyhow};
use serde::Serialize;
use trueaxis::roundness::Band;
use trueaxis_tables::error::FileError;

/// Result of resampling a trace.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Resampling {
    /// Number of rows in the file.
    pub rows: usize,
    /// Rows before or after the whole revolutions.
    pub unused_rows: usize,
    /// Widest step between two rows.
    pub largest_gap_deg: f64,
    /// Error that interpolation adds.
    pub interpolation_error_um: InterpolationError,
}

/// Difference between interpolation by six and by four readings: the error of the poorer one, which is not used.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InterpolationError {
    /// Largest.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
}

/// Number of readings on either side of an angle.
const SIDE: usize = 3;
/// Angles closer than this are one angle written twice, degrees: no encoder resolves them, and interpolation divides by their
/// difference.
const FINEST_DEG: f64 = 1e-9;

/// A trace: increasing, unwrapped angles and the readings of each probe.
struct Trace {
    angles_deg: Vec<f64>,
    probes: Vec<Vec<f64>>,
}

/// Rows of [`COLUMNS`](super::COLUMNS), from a file or from memory.
pub(super) trait Given {
    /// The next row.
    fn next(&mut self) -> Result<Option<Row<7>>>;

    /// Refuses a probe that stops changing half-way; `lines` are those of the rows.
    fn alive(&self, lines: &[u32], probes: &[Vec<f64>]) -> Result<()>;

    /// Refusal of the angle of a row, or of all angles.
    fn refused(&self, line: Option<u32>, found: String, needed: String) -> anyhow::Error;
}

impl Given for Rows<'_, 7> {
    fn next(&mut self) -> Result<Option<Row<7>>> {
        Rows::next(self)
    }

    fn alive(&self, lines: &[u32], probes: &[Vec<f64>]) -> Result<()> {
        record::alive(self, lines, &channels(probes))
    }

    fn refused(&self, line: Option<u32>, found: String, needed: String) -> anyhow::Error {
        FileError { file: self.file.clone(), line, column: Some(THETA.into()), found, needed }.into()
    }
}

/// Rows in memory; errors name a row by its index.
pub(super) struct InMemory<'r> {
    pub(super) readings: &'r [&'r [f64]],
    pub(super) theta_deg: &'r [f64],
    pub(super) next: usize,
    /// Whether a sensor that stops changing is refused.
    pub(super) of_sensors: bool,
}

impl Given for InMemory<'_> {
    fn next(&mut self) -> Result<Option<Row<7>>> {
        let at = self.next;
        let Some(angle) = self.theta_deg.get(at) else { return Ok(None) };
        self.next += 1;
        let mut values = [0.0; 7];
        for (value, readings) in values.iter_mut().zip(self.readings) {
            *value = readings[at];
        }
        values[THETA_AT] = *angle;
        Ok(Some(Row { line: at as u32, values }))
    }

    fn alive(&self, _: &[u32], probes: &[Vec<f64>]) -> Result<()> {
        if !self.of_sensors {
            return Ok(());
        }
        record::dead(&channels(probes)).map_or(Ok(()), |(channel, stuck)| {
            let (name, record::Stuck { from, count, value }) = (channel.name, stuck);
            Err(anyhow!(
                "{name}[{from}]: found {value} for {count} readings in a row, needed a sensor whose readings change"
            ))
        })
    }

    fn refused(&self, line: Option<u32>, found: String, needed: String) -> anyhow::Error {
        let place = line.map(|line| format!("[{line}]")).unwrap_or_default();
        anyhow!("theta_deg{place}: found {found}, needed {needed}")
    }
}

/// Reads all rows of `count` probes and resamples them: the readings of each probe at 360°·i/N, whole revolutions in sequence.
///
/// # Errors
/// Angles that do not increase by [`FINEST_DEG`], gaps too wide for the band, less than a revolution.
pub(super) fn read(
    rows: &mut impl Given,
    count: usize,
    points: usize,
    band: Band,
) -> Result<(Vec<Vec<f64>>, Resampling)> {
    let widest = 180.0 / f64::from(band.last);
    let mut trace = Trace { angles_deg: Vec::new(), probes: vec![Vec::new(); count] };
    let mut lines = Vec::new();
    let mut turns = 0.0;
    let mut gap: f64 = 0.0;
    while let Some(Row { line, values }) = rows.next()? {
        let angle = values[THETA_AT];
        if let Some(before) = trace.angles_deg.last().copied() {
            // An angle that drops by more than half a turn starts the next revolution.
            if angle + turns < before - 180.0 {
                turns += 360.0 * ((before - 180.0 - angle - turns) / 360.0).ceil();
            }
            let step = angle + turns - before;
            if step < FINEST_DEG {
                let needed = format!("more than {} of the row before by {FINEST_DEG:e}", before - turns);
                return Err(rows.refused(Some(line), angle.to_string(), needed));
            }
            if step > widest {
                let found = format!("a gap of {step:.4} degrees before {angle}");
                let needed = format!("at most {widest:.4}, half a wave of harmonic {}", band.last);
                return Err(rows.refused(Some(line), found, needed));
            }
            gap = gap.max(step);
        }
        trace.angles_deg.push(angle + turns);
        lines.push(line);
        for (probe, value) in trace.probes.iter_mut().zip(values) {
            probe.push(value);
        }
    }
    rows.alive(&lines, &trace.probes)?;
    let rows_read = trace.angles_deg.len();
    let (first, last) = (trace.angles_deg[0], trace.angles_deg[rows_read - 1]);
    let step = 360.0 / points as f64;
    let (begin, end) = ((first / step - 1e-9).ceil() as i64, ((last + gap) / step + 1e-9).floor() as i64);
    let revolutions = usize::try_from(end - begin + 1).unwrap_or(0) / points;
    if revolutions == 0 || last - first + widest < 360.0 {
        let found = format!("{:.4} degrees in {rows_read} rows", last - first);
        let is_radians = record::radians(&trace.angles_deg).is_some();
        let needed = if is_radians { record::DEGREES } else { "a whole revolution" };
        return Err(rows.refused(None, found, needed.into()));
    }
    trace.close();
    let mut readings = vec![vec![0.0; revolutions * points]; count];
    let (mut max, mut sum) = (0.0_f64, 0.0);
    for (turn, i) in (begin..).take(revolutions * points).enumerate() {
        // A revolution may begin at any angle; each point goes to its index.
        let slot = turn / points * points + i.rem_euclid(points as i64) as usize;
        let (six, four) = trace.at(i as f64 * step);
        for ((readings, six), four) in readings.iter_mut().zip(six).zip(four) {
            readings[slot] = six;
            max = max.max((six - four).abs());
            sum += (six - four).powi(2);
        }
    }
    let used_to = (begin + (revolutions * points) as i64 - 1) as f64 * step;
    let unused_rows = trace.angles_deg[SIDE..SIDE + rows_read].iter().filter(|angle| **angle > used_to + gap).count();
    let rms = (sum / (count * revolutions * points) as f64).sqrt();
    let interpolation_error_um = InterpolationError { max, rms };
    Ok((readings, Resampling { rows: rows_read, unused_rows, largest_gap_deg: gap, interpolation_error_um }))
}

impl Trace {
    /// Prepends readings from a turn later and appends readings from a turn earlier.
    fn close(&mut self) {
        let (first, last) = (self.angles_deg[0], self.angles_deg[self.angles_deg.len() - 1]);
        let before = self.angles_deg.partition_point(|angle| *angle <= first + 360.0 - FINEST_DEG);
        let behind = self.angles_deg.partition_point(|angle| *angle < last - 360.0 + FINEST_DEG);
        for (list, turn) in
            [(&mut self.angles_deg, 360.0)].into_iter().chain(self.probes.iter_mut().map(|list| (list, 0.0)))
        {
            let head = list[before.saturating_sub(SIDE)..before].iter().map(|value| value - turn);
            let tail = list[behind..].iter().take(SIDE).map(|value| value + turn);
            *list = head.chain(list.iter().copied()).chain(tail).collect();
        }
    }

    /// Readings at an angle, by polynomials through the six and the four readings around it.
    fn at(&self, angle: f64) -> (Vec<f64>, Vec<f64>) {
        let after = self.angles_deg.partition_point(|known| *known < angle).clamp(SIDE, self.angles_deg.len() - SIDE);
        let by = |side: usize| {
            let nodes = &self.angles_deg[after - side..after + side];
            let mut sums = vec![0.0; self.probes.len()];
            for (i, node) in nodes.iter().enumerate() {
                let others = nodes.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other);
                let weight: f64 = others.map(|other| (angle - other) / (node - other)).product();
                for (sum, probe) in sums.iter_mut().zip(&self.probes) {
                    *sum += weight * probe[after - side + i];
                }
            }
            sums
        };
        (by(SIDE), by(SIDE - 1))
    }
}
