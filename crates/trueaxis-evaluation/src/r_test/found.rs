//! Location errors from an R-test.

use super::Record;
use crate::response::{Unit, response, tip_errors, without_errors};
use anyhow::{Result, bail};
use trueaxis::Axis;
use trueaxis::machine::{AXES, links};
use trueaxis_metrology::linear_fit::LinearFit;
use trueaxis_tables::finding::{Finding, Fit, Known};
use trueaxis_tables::{Additions, Machine};

const ROTARY: [Axis; 3] = [Axis::A, Axis::B, Axis::C];
/// Minimum number of readings of a fit beyond its unknowns.
const LEAST_FREEDOM: usize = 3;

/// How to fit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Location errors that keep the machine's values, such as `EX0C`.
    pub without: Vec<String>,
    /// Whether the nest's zero relative to the spindle is unknown.
    pub free_sensor: bool,
}

/// Result of an R-test.
#[derive(Clone, Debug)]
pub struct RTestFit {
    /// The fitted location errors, with value and standard error in mm or rad.
    pub terms: Vec<((Axis, usize), f64, f64)>,
    /// Offsets of the balls from their commanded places, workpiece's frame, mm.
    pub balls_mm: Vec<[f64; 3]>,
    /// Zero of the nest, tool's frame, mm.
    pub sensor_mm: Option<[f64; 3]>,
    /// Contribution of the machine's tables and its other errors to every reading, mm.
    pub known_mm: Vec<[f64; 3]>,
    /// Residual of every reading, mm.
    pub left_mm: Vec<[f64; 3]>,
    /// Root mean square of a coordinate after only the places of the balls and the nest's zero are removed, mm: the part that
    /// the machine's errors have to explain.
    pub unexplained_mm: f64,
    /// Standard deviation of a coordinate, mm.
    pub sigma_mm: f64,
    /// Coordinates minus unknowns.
    pub degrees_of_freedom: usize,
    /// Rank: all unknowns.
    pub rank: usize,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Whether a linear axis was beyond its table.
    pub clamped: bool,
}

/// Name of a location error, such as `EX0C`.
pub fn name((axis, component): (Axis, usize)) -> String {
    format!("E{}0{}", Axis::ALL[component.min(5)].letter(), axis.letter())
}

/// The two offsets and two tilts across an axis.
fn across(axis: Axis) -> [usize; 4] {
    match axis {
        Axis::A => [1, 2, 4, 5],
        Axis::B => [0, 2, 3, 5],
        _ => [0, 1, 3, 4],
    }
}

/// Location errors of the machine's rotary axes; `file` is named in refusals.
///
/// The unknowns are the two offsets and two tilts across every rotary axis that turns in the record; the offset along an axis
/// belongs to the work or the tool, and the error of its zero is a setting.
///
/// # Errors
/// A machine without a rotary axis that turns, `without` errors that are not unknowns, too few readings, errors that the poses
/// cannot distinguish.
pub fn identify(record: &Record, file: &str, machine: &Machine, options: &Options) -> Result<RTestFit> {
    let turns = |axis: Axis| {
        let at = |i: usize| record.readings[i].place[axis.index()];
        record.readings.iter().any(|reading| (reading.place[axis.index()] - at(0)).abs() > 1e-6)
    };
    for axis in ROTARY.into_iter().filter(|axis| machine.settings.axis(*axis).is_none()) {
        if let Some(reading) = record.readings.iter().find(|reading| reading.place[axis.index()] != 0.0) {
            let letter = axis.letter().to_ascii_lowercase();
            bail!("{file}:{}: column {letter}_deg: found an angle, needed an axis that the machine has", reading.line);
        }
    }
    let moving: Vec<Axis> =
        ROTARY.into_iter().filter(|axis| machine.settings.axis(*axis).is_some() && turns(*axis)).collect();
    if moving.is_empty() {
        bail!("{file}: found no rotary axis that turns, needed at least one");
    }
    let mut without = options.without.clone();
    let mut sought: Vec<(Axis, usize)> = Vec::new();
    for axis in moving {
        for component in across(axis) {
            let own = name((axis, component));
            match without.iter().position(|asked| asked.eq_ignore_ascii_case(&own)) {
                Some(at) => drop(without.remove(at)),
                None => sought.push((axis, component)),
            }
        }
    }
    if let Some(unknown) = without.first() {
        bail!("{file}: --without {unknown}: needed a location error that is fitted, such as EX0C of a C that turns");
    }
    let mut known = machine.clone();
    for &(axis, component) in &sought {
        known.settings.location.rotary[axis.index() - 3][component] = 0.0;
    }
    known.settings.axes.iter_mut().for_each(|own| own.backlash = 0.0);
    let places: Vec<[f64; AXES]> = record.readings.iter().map(|reading| reading.place).collect();
    let (known_mm, clamped) = tip_errors(&known, &places)?;
    let bare = without_errors(machine);
    let responses: Vec<Vec<[f64; 3]>> = sought
        .iter()
        .map(|&(axis, component)| response(&bare, Unit::Rotary(axis, component), &places))
        .collect::<Result<_>>()?;
    let first_ball = sought.len();
    let first_sensor = first_ball + 3 * record.balls.len();
    let unknowns = first_sensor + if options.free_sensor { 3 } else { 0 };
    let coordinates = 3 * record.readings.len();
    if coordinates < unknowns + LEAST_FREEDOM {
        bail!(
            "{file}: found {coordinates} coordinates for {unknowns} unknowns, needed at least {LEAST_FREEDOM} more coordinates than unknowns"
        );
    }
    // The columns are scaled: angles enter by their effect at a typical lever, so that the rank does not depend on units.
    let mut fit = LinearFit::new(unknowns);
    let mut places_alone = LinearFit::new(unknowns - first_ball);
    let mut rows = Vec::new();
    for (i, reading) in record.readings.iter().enumerate() {
        let workpiece = turned(machine, &reading.place, true);
        let tool = turned(machine, &reading.place, false);
        for c in 0..3 {
            let mut row = vec![0.0; unknowns];
            for (k, of) in responses.iter().enumerate() {
                row[k] = of[i][c];
            }
            for k in 0..3 {
                row[first_ball + 3 * reading.ball + k] = -workpiece[c][k];
                if options.free_sensor {
                    row[first_sensor + k] = tool[c][k];
                }
            }
            let value = reading.displacement_mm[c] - known_mm[i][c];
            fit.add(&row, value, 1.0);
            places_alone.add(&row[first_ball..], reading.displacement_mm[c], 1.0);
            rows.push((row, value));
        }
    }
    let solution = fit.solve();
    if !solution.unseen.is_empty() {
        let mut names: Vec<String> = Vec::new();
        for &unknown in &solution.unseen {
            let own = match unknown {
                k if k < first_ball => name(sought[k]),
                k if k < first_sensor => format!("the place of ball {}", record.balls[(k - first_ball) / 3]),
                _ => "the zero of the nest".into(),
            };
            if !names.contains(&own) {
                names.push(own);
            }
        }
        bail!(
            "{file}: found poses that cannot separate {} (rank {} of {unknowns}), needed other angles of the axes that carry them, or some of \
             them left as they are (--without)",
            names.join(", "),
            solution.rank
        );
    }
    let left: Vec<f64> = rows
        .iter()
        .map(|(row, value)| value - row.iter().zip(&solution.values).map(|(a, x)| a * x).sum::<f64>())
        .collect();
    let alone = places_alone.solve();
    let squares = rows.iter().enumerate().map(|(i, (row, _))| {
        let explained: f64 = row[first_ball..].iter().zip(&alone.values).map(|(a, x)| a * x).sum();
        (record.readings[i / 3].displacement_mm[i % 3] - explained).powi(2)
    });
    let unexplained_mm = (squares.sum::<f64>() / coordinates as f64).sqrt();
    let sigma_mm = solution.sigma();
    let mut terms = Vec::new();
    for (k, &(axis, component)) in sought.iter().enumerate() {
        let value = solution.values[k];
        terms.push(((axis, component), value, sigma_mm * solution.error_factors[k]));
    }
    let three = |from: usize| [0, 1, 2].map(|k| solution.values[from + k]);
    Ok(RTestFit {
        terms,
        balls_mm: (0..record.balls.len()).map(|ball| three(first_ball + 3 * ball)).collect(),
        sensor_mm: options.free_sensor.then(|| three(first_sensor)),
        known_mm,
        left_mm: left.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
        unexplained_mm,
        sigma_mm,
        degrees_of_freedom: solution.degrees_of_freedom(),
        rank: solution.rank,
        condition: solution.condition,
        clamped,
    })
}

impl RTestFit {
    /// The location errors found, for a machine that was not corrected while it was measured.
    pub fn additions(&self) -> Additions {
        let finding = |&((axis, component), value, error): &((Axis, usize), f64, f64)| {
            let (unit, scale) = if component < 3 { ("um", 1e3) } else { ("urad", 1e6) };
            Finding {
                key: format!("location.{}_{unit}", name((axis, component))),
                found: Known::new(scale * value, scale * error, self.degrees_of_freedom),
                ..Finding::default()
            }
        };
        let squares: f64 = self.left_mm.iter().flatten().map(|left| left * left).sum();
        let left_mm = (squares / (3 * self.left_mm.len()).max(1) as f64).sqrt();
        let fit = Fit { before_mm: self.unexplained_mm, left_mm, noise_mm: None };
        Additions { findings: self.terms.iter().map(finding).collect(), fit: Some(fit), ..Additions::default() }
    }
}

/// Nominal orientation of the workpiece (or of the tool) at a pose, from the bed outwards.
fn turned(machine: &Machine, place: &[f64; AXES], workpiece: bool) -> [[f64; 3]; 3] {
    let mut at = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let Ok(chain) = links(&machine.settings.chain) else { return at };
    let own: Vec<Axis> = chain.iter().filter(|l| l.carries_workpiece == workpiece).map(|l| l.axis).collect();
    // The structural code runs from the workpiece through the bed to the tool.
    let outwards: Vec<Axis> = if workpiece { own.into_iter().rev().collect() } else { own };
    for axis in outwards.into_iter().filter(|axis| axis.is_rotary()) {
        let direction = machine.settings.axis(axis).map_or(1.0, |own| f64::from(own.direction));
        let (sin, cos) = (direction * place[axis.index()]).to_radians().sin_cos();
        let (i, j) = match axis {
            Axis::A => (1, 2),
            Axis::B => (2, 0),
            _ => (0, 1),
        };
        for row in &mut at {
            let (a, b) = (row[i], row[j]);
            row[i] = a * cos + b * sin;
            row[j] = b * cos - a * sin;
        }
    }
    at
}
