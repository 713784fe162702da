//! Error and correction at one position, as the servo step computes them.

use crate::contributions::{Source, shares};
use crate::model::{passes, thermal, with_compensation};
use anyhow::{Result, anyhow};
use trueaxis::compensation::{Direction, PoseError, Query};
use trueaxis::machine::{AXES, Axis, AxisOrder, ErrorModel};
use trueaxis_tables::Machine;
use trueaxis_tables::limits::Clipped;
use trueaxis_tables::text::counted;

/// A query. Lists are in the order X, Y, Z, A, B, C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Commanded position, mm and degrees.
    pub at: [f64; AXES],
    /// Axes that travel in negative direction.
    pub reverse: [bool; AXES],
    /// Kelvin above the reference temperature.
    pub kelvin: f64,
}

/// Largest coordinate accepted, mm or degrees.
const MOST: f64 = 1e6;

/// X, Y, Z, optionally followed by the machine's rotary axes, by [`Axis::index`].
///
/// # Errors
/// Another number of coordinates, or a coordinate that is not a number or above 1e6; the text states the value found and the
/// value needed.
pub fn position(found: &[f64], machine: &Machine) -> Result<[f64; AXES], String> {
    let axes: Vec<Axis> = machine.settings.step_axes().collect();
    if found.len() != 3 && found.len() != axes.len() {
        let rotary: String = axes.iter().skip(3).map(|axis| format!(",{}", axis.letter())).collect();
        let or = if rotary.is_empty() { String::new() } else { format!(", or {} with X,Y,Z{rotary}", axes.len()) };
        return Err(format!("found {}, needed three, X,Y,Z{or}", counted(found.len(), "number")));
    }
    let mut at = [0.0; AXES];
    for (axis, &value) in axes.into_iter().zip(found) {
        if value.is_nan() || value.abs() > MOST {
            return Err(format!("found {value} for axis {}, needed at most {MOST:e}", axis.letter()));
        }
        at[axis.index()] = value;
    }
    Ok(at)
}

/// Error and correction at a position. Lists are in the order X, Y, Z, A, B, C.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CorrectionAt {
    /// Axes of the step.
    pub axes: Vec<Axis>,
    /// Commanded position, mm and degrees.
    pub at: [f64; AXES],
    /// Error of the tip, actual − ideal, mm.
    pub tip: [f64; 3],
    /// Error of the tool's orientation, rad; only in the volumetric model.
    pub orientation: Option<[f64; 3]>,
    /// Correction added to the command, mm and degrees.
    pub correction: [f64; AXES],
    /// Shares of the tip's error, mm: one per axis, by its letter, and one of the location errors.
    pub contributions: Vec<(String, [f64; 3])>,
    /// Axes beyond the end of their table.
    pub clamped: Vec<Axis>,
    /// Axes outside their declared travel.
    pub out_of_travel: Vec<Axis>,
    /// Axes whose correction the magnitude limit reduces.
    pub clipped: Clipped,
}

/// Error and correction under the machine's own model at a position; `N` slots of the step.
///
/// # Errors
/// More axes than `N`; anything that the model refuses.
pub fn at<const N: usize>(machine: &Machine, asked: &Asked) -> Result<CorrectionAt> {
    let axes = AxisOrder::<N>::with_spare_slots(&machine.settings).map_err(|error| anyhow!("{error}"))?.axes();
    let own = &axes[..machine.settings.step_axes().count()];
    let (whole, correction, clamped) = look_up(machine, &axes, asked, passes(machine, None)?)?;
    let error = |without: &Machine| Ok(look_up(without, &axes, asked, 1)?.0.tip.into());
    let (found, rest) = shares(machine, Source::axes(machine), whole.tip.into(), error)?;
    let mut contributions: Vec<_> = found.into_iter().map(|(source, share)| (source.name(), share)).collect();
    contributions.push((String::from("location errors"), rest));
    let mut found = CorrectionAt {
        at: asked.at,
        tip: whole.tip.into(),
        orientation: (own.len() > 3 && machine.settings.compensation.model == ErrorModel::Volumetric)
            .then_some(whole.orientation.into()),
        correction: [0.0; AXES],
        contributions,
        clamped: (0..own.len()).filter(|slot| clamped >> slot & 1 == 1).map(|slot| own[slot]).collect(),
        out_of_travel: Vec::new(),
        clipped: Clipped::default(),
        axes: own.to_vec(),
    };
    for (axis, correction) in axes.into_iter().zip(correction) {
        found.correction[axis.index()] = correction;
    }
    found.clipped.add(&machine.settings, &found.at, &found.correction);
    for own in &machine.settings.axes {
        let (q, [low, high]) = (asked.at[own.axis.index()], own.travel);
        if q < low || q > high {
            found.out_of_travel.push(own.axis);
        }
    }
    Ok(found)
}

/// Error, correction, and a bit for every axis beyond the end of its table.
fn look_up<const N: usize>(
    machine: &Machine,
    axes: &[Axis; N],
    asked: &Asked,
    passes: u8,
) -> Result<(PoseError<f64>, [f64; N], u8)> {
    let thermal = thermal(machine, axes, asked.kelvin);
    let directions = axes.map(|axis| Direction::of(asked.reverse[axis.index()]));
    with_compensation::<N, _>(machine, passes, |compensation| {
        let mut clamped = 0;
        let at = compensation.coordinates(&axes.map(|axis| asked.at[axis.index()]));
        let error = compensation.pose_error(&Query::at(&at, &directions, &thermal), &mut clamped);
        let correction = compensation.correction(&Query::at(&at, &directions, &thermal), &mut 0);
        Ok((error, correction, clamped))
    })
}
