//! Centre lines of the rotary axes of the table, relative to the linear axes that move along and across them.
//!
//! With the tip on the line while the axis turns by half a turn, everything that turns with the workpiece cancels
//! (ISO 10791-6):
//!
//! ```text
//! d(s) = ½ [E(s, 0°) + E(s, 180°)]       E: error of the tip at s along the line, in machine directions
//! ```
//! The least-squares line of d has the place in its middle and the tilt as its slope.

use super::volume::dot;
use crate::calibrate::kinematics::Ideal;
use crate::calibrate::stylus::{Stylus, tool_mm, with_stylus};
use crate::calibrate::task::Task;
use crate::calibrate::terms::{Pose, Term, Terms, perfect};
use anyhow::Result;
use serde::Serialize;
use trueaxis::machine::{AXES, Axis};
use trueaxis_tables::Machine;

/// Points of a line, and most of its length that counts, mm.
const POINTS: usize = 9;
const LENGTH: f64 = 200.0;
/// Largest distance of a point of the line from itself after half a turn, mm.
const ON_LINE: f64 = 1e-6;

/// How well a centre line is known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CentreLine {
    /// Letter of the axis.
    pub axis: char,
    /// Standard error of its place, of the two directions across it the larger, µm.
    pub place_um: f64,
    /// Standard error of its tilt, of the two directions across it the larger, µrad.
    pub tilt_urad: f64,
}

/// The rotary axes whose location is among the terms; those that carry the tool have no point that stays where it is.
pub(super) fn centre_lines(
    task: &Task,
    machine: &Machine,
    shortest: Stylus,
    terms: &Terms,
    covariance: &[Vec<f64>],
) -> Result<Vec<CentreLine>> {
    let tool = task.wishes.tools_mm.first().copied();
    let machine = with_stylus(&perfect(machine), tool);
    let ideal = Ideal::new(&machine)?;
    let mut all = Vec::new();
    for axis in [Axis::A, Axis::B, Axis::C] {
        if !terms.terms.iter().any(|term| matches!(term, Term::Location(of, _) if *of == axis)) {
            continue;
        }
        let along = axis.index() % 3;
        let Some(through) = on_line(&ideal, axis) else { continue };
        let [low, high] = stretch(task, &machine, shortest, along);
        let at = |i: usize| low + (high - low) * i as f64 / (POINTS - 1) as f64;
        let mut positions = Vec::new();
        for s in (0..POINTS).map(at) {
            for degrees in [0.0, 180.0] {
                let mut position = through;
                position[along] = s;
                position[axis.index()] = degrees;
                positions.push(position);
            }
        }
        let poses: Vec<Pose> =
            positions.iter().map(|position| Pose { position: ideal.ordered(position), reverse: [0.5; AXES] }).collect();
        let moved = terms.responses(&machine, &poses)?;
        // Deviation of the line by every term, in machine directions.
        let error = |pose: usize, term: usize| ideal.turned(&positions[pose], moved[pose][term]);
        let middle = 0.5 * (low + high);
        let squares: f64 = (0..POINTS).map(|i| (at(i) - middle).powi(2)).sum();
        let mut line = CentreLine { axis: axis.letter(), place_um: 0.0, tilt_urad: 0.0 };
        for across in (0..3).filter(|k| *k != along) {
            let of_term = |term: usize| {
                let d = |i: usize| 0.5 * (error(2 * i, term)[across] + error(2 * i + 1, term)[across]);
                let place = (0..POINTS).map(d).sum::<f64>() / POINTS as f64;
                let tilt = (0..POINTS).map(|i| (at(i) - middle) * d(i)).sum::<f64>() / squares;
                [place, tilt]
            };
            let both: Vec<[f64; 2]> = (0..terms.terms.len()).map(of_term).collect();
            let [place, tilt] = [0, 1].map(|k| {
                let of: Vec<f64> = both.iter().map(|of| of[k]).collect();
                covariance.iter().zip(&of).map(|(row, value)| value * dot(row, &of)).sum::<f64>().max(0.0).sqrt()
            });
            line.place_um = line.place_um.max(1e3 * place);
            line.tilt_urad = line.tilt_urad.max(1e6 * tilt);
        }
        all.push(line);
    }
    Ok(all)
}

/// A position at which the tip is on the line of an axis.
fn on_line(ideal: &Ideal, axis: Axis) -> Option<[f64; AXES]> {
    let tip = |position: &[f64; AXES], degrees: f64| {
        let mut position = *position;
        position[axis.index()] = degrees;
        ideal.tip(&position)
    };
    let mut position = [0.0; AXES];
    let [one, other] = [0.0, 180.0].map(|degrees| tip(&position, degrees));
    for k in (0..3).filter(|k| *k != axis.index() % 3) {
        position[k] = 0.5 * (other[k] - one[k]);
    }
    let [one, other] = [0.0, 180.0].map(|degrees| tip(&position, degrees));
    (0..3).all(|k| (one[k] - other[k]).abs() < ON_LINE).then_some(position)
}

/// Positions of a linear axis between which a line along it counts: where artefacts may stand.
fn stretch(task: &Task, machine: &Machine, shortest: Stylus, along: usize) -> [f64; 2] {
    let axis = [Axis::X, Axis::Y, Axis::Z][along];
    let settings = &machine.settings;
    let [shortest, own] = [shortest, task.wishes.tools_mm.first().copied()].map(|of| tool_mm(settings, of));
    let free = task.wishes.free_mm.map(|free| free[along].map(|q| q + shortest[along] - own[along]));
    let [low, high] = free.unwrap_or_else(|| settings.axis(axis).map_or([0.0; 2], |own| own.travel));
    let (middle, half) = (0.5 * (low + high), (0.5 * (high - low)).min(0.5 * LENGTH));
    [middle - half, middle + half]
}
