//! Unknowns of an R-test: which there are, and their order in the fit.

use super::Record;
use anyhow::{Result, bail};
use trueaxis::Axis;
use trueaxis_tables::Machine;

const ROTARY: [Axis; 3] = [Axis::A, Axis::B, Axis::C];

/// A location error: the rotary axis, and the component 0 to 5 for X, Y, Z, A, B, C.
pub(super) type LocationError = (Axis, usize);

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

/// Columns of the fit, in this order: location errors, three coordinates of each ball, three of the nest's zero.
pub(super) struct Unknowns {
    /// The location errors.
    pub(super) errors: Vec<LocationError>,
    balls: usize,
    free_sensor: bool,
}

impl Unknowns {
    pub(super) fn new(errors: Vec<LocationError>, balls: usize, free_sensor: bool) -> Unknowns {
        Unknowns { errors, balls, free_sensor }
    }

    /// First column after the location errors: there the positions of the balls and of the nest begin.
    pub(super) fn places(&self) -> usize {
        self.errors.len()
    }

    /// First of the three columns of a ball.
    pub(super) fn ball(&self, ball: usize) -> usize {
        self.places() + 3 * ball
    }

    /// First of the three columns of the nest's zero; `None` if the nest is calibrated to the spindle.
    pub(super) fn sensor(&self) -> Option<usize> {
        self.free_sensor.then_some(self.ball(self.balls))
    }

    /// Number of columns.
    pub(super) fn count(&self) -> usize {
        self.ball(self.balls) + if self.free_sensor { 3 } else { 0 }
    }

    /// Names of columns, each once; `balls` are the numbers of the balls.
    pub(super) fn names(&self, columns: &[usize], balls: &[i64]) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for &column in columns {
            let own = match column {
                error if error < self.places() => name(self.errors[error]),
                place if place < self.ball(self.balls) => {
                    format!("the place of ball {}", balls[(place - self.places()) / 3])
                }
                _ => "the zero of the nest".into(),
            };
            if !names.contains(&own) {
                names.push(own);
            }
        }
        names
    }
}

/// Location errors to fit: two offsets and two tilts across every rotary axis that turns in the record, less those of
/// `without`; `file` is named in refusals.
///
/// # Errors
/// The record has angles of an axis that the machine lacks, no rotary axis turns, or `without` names another error.
pub(super) fn location_errors(
    record: &Record,
    file: &str,
    machine: &Machine,
    without: &[String],
) -> Result<Vec<LocationError>> {
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
    let mut without = without.to_vec();
    let mut fitted: Vec<LocationError> = Vec::new();
    for axis in moving {
        for component in across(axis) {
            let own = name((axis, component));
            match without.iter().position(|asked| asked.eq_ignore_ascii_case(&own)) {
                Some(at) => drop(without.remove(at)),
                None => fitted.push((axis, component)),
            }
        }
    }
    if let Some(unknown) = without.first() {
        bail!("{file}: --without {unknown}: needed a location error that is fitted, such as EX0C of a C that turns");
    }
    Ok(fitted)
}
