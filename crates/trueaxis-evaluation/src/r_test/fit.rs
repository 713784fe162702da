//! Location errors from an R-test.

use super::Record;
use super::unknowns::{LocationError, Unknowns, location_errors, name};
use crate::response::{Unit, response, tip_errors, without_errors};
use anyhow::{Result, bail};
use trueaxis::Axis;
use trueaxis::machine::{AXES, links};
use trueaxis_metrology::linear_fit::LinearFit;
use trueaxis_tables::finding::{Finding, Fit, Known};
use trueaxis_tables::{Additions, Machine};

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
    /// Covariance of the location errors, row by row, in products of mm and rad.
    pub covariance: Vec<Vec<f64>>,
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

/// Location errors of the machine's rotary axes; `file` is named in refusals.
///
/// The unknowns are the two offsets and two tilts across every rotary axis that turns in the record; the offset along an axis
/// belongs to the work or the tool, and the error of its zero is a setting.
///
/// # Errors
/// A machine without a rotary axis that turns, `without` errors that are not unknowns, too few readings, errors that the poses
/// cannot distinguish.
pub fn identify(record: &Record, file: &str, machine: &Machine, options: &Options) -> Result<RTestFit> {
    let errors = location_errors(record, file, machine, &options.without)?;
    let unknowns = Unknowns::new(errors, record.balls.len(), options.free_sensor);
    let places: Vec<[f64; AXES]> = record.readings.iter().map(|reading| reading.place).collect();
    let (known_mm, clamped) = tip_errors(&known(machine, &unknowns.errors), &places)?;
    let bare = without_errors(machine);
    let responses =
        unknowns.errors.iter().map(|&(axis, component)| response(&bare, Unit::Rotary(axis, component), &places));
    let responses: Vec<Vec<[f64; 3]>> = responses.collect::<Result<_>>()?;
    let (coordinates, count) = (3 * record.readings.len(), unknowns.count());
    if coordinates < count + LEAST_FREEDOM {
        bail!(
            "{file}: found {coordinates} coordinates for {count} unknowns, needed at least {LEAST_FREEDOM} more coordinates than unknowns"
        );
    }
    let equations = equations(record, machine, &unknowns, &responses, &known_mm);
    let mut fit = LinearFit::new(count);
    equations.iter().for_each(|equation| fit.add(&equation.coefficients, equation.value, 1.0));
    let solution = fit.solve();
    if !solution.unseen.is_empty() {
        bail!(
            "{file}: found poses that cannot separate {} (rank {} of {count}), needed other angles of the axes that carry them, or some of \
             them left as they are (--without)",
            unknowns.names(&solution.unseen, &record.balls).join(", "),
            solution.rank
        );
    }
    let sigma_mm = solution.sigma();
    let errors = 0..unknowns.errors.len();
    let of_row = |i| errors.clone().map(|j| sigma_mm * sigma_mm * solution.covariance_factor(i, j)).collect();
    let covariance = errors.clone().map(of_row).collect();
    let terms = unknowns.errors.iter().zip(&solution.values).zip(&solution.error_factors);
    let left: Vec<f64> =
        equations.iter().map(|equation| equation.value - dot(&equation.coefficients, &solution.values)).collect();
    let three = |from: usize| [0, 1, 2].map(|k| solution.values[from + k]);
    Ok(RTestFit {
        terms: terms.map(|((error, value), factor)| (*error, *value, sigma_mm * factor)).collect(),
        covariance,
        balls_mm: (0..record.balls.len()).map(|ball| three(unknowns.ball(ball))).collect(),
        sensor_mm: unknowns.sensor().map(three),
        known_mm,
        left_mm: left.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
        unexplained_mm: unexplained_mm(record, &equations, unknowns.places()),
        sigma_mm,
        degrees_of_freedom: solution.degrees_of_freedom(),
        rank: solution.rank,
        condition: solution.condition,
        clamped,
    })
}

/// The machine without the fitted errors and without lost motion: what it contributes to the readings is known.
fn known(machine: &Machine, fitted: &[LocationError]) -> Machine {
    let mut known = machine.clone();
    for &(axis, component) in fitted {
        known.settings.location.rotary[axis.index() - 3][component] = 0.0;
    }
    known.settings.axes.iter_mut().for_each(|own| own.backlash = 0.0);
    known
}

/// Equation of one coordinate of a reading: `coefficients` · unknowns = `value`, mm.
struct Equation {
    coefficients: Vec<f64>,
    value: f64,
}

/// Three equations per reading. [`LinearFit`] scales the columns: angles enter by their effect at a typical lever, so that the
/// rank does not depend on units.
fn equations(
    record: &Record,
    machine: &Machine,
    unknowns: &Unknowns,
    responses: &[Vec<[f64; 3]>],
    known_mm: &[[f64; 3]],
) -> Vec<Equation> {
    let mut equations = Vec::new();
    for (i, reading) in record.readings.iter().enumerate() {
        let workpiece = turned(machine, &reading.place, true);
        let tool = turned(machine, &reading.place, false);
        for c in 0..3 {
            let mut coefficients = vec![0.0; unknowns.count()];
            for (k, of) in responses.iter().enumerate() {
                coefficients[k] = of[i][c];
            }
            for k in 0..3 {
                coefficients[unknowns.ball(reading.ball) + k] = -workpiece[c][k];
                if let Some(sensor) = unknowns.sensor() {
                    coefficients[sensor + k] = tool[c][k];
                }
            }
            equations.push(Equation { coefficients, value: reading.displacement_mm[c] - known_mm[i][c] });
        }
    }
    equations
}

fn dot(coefficients: &[f64], values: &[f64]) -> f64 {
    coefficients.iter().zip(values).map(|(a, x)| a * x).sum()
}

/// Root mean square of the displacements after a fit of the unknowns from `places` on alone, mm.
fn unexplained_mm(record: &Record, equations: &[Equation], places: usize) -> f64 {
    let displacements = record.readings.iter().flat_map(|reading| reading.displacement_mm);
    let of_places: Vec<(&[f64], f64)> =
        equations.iter().map(|equation| &equation.coefficients[places..]).zip(displacements).collect();
    let mut fit = LinearFit::new(of_places.first().map_or(0, |(coefficients, _)| coefficients.len()));
    of_places.iter().for_each(|(coefficients, displacement)| fit.add(coefficients, *displacement, 1.0));
    let solution = fit.solve();
    let squares = of_places
        .iter()
        .map(|(coefficients, displacement)| (displacement - dot(coefficients, &solution.values)).powi(2));
    (squares.sum::<f64>() / equations.len() as f64).sqrt()
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
        let fit = Fit { before_mm: self.unexplained_mm, left_mm, noise_mm: None, is_angle: false };
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
