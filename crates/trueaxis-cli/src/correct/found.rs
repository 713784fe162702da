//! The model at a position, as a whole and axis by axis.

use super::arguments::Asked;
use crate::model::{passes, thermal, with_compensation};
use anyhow::{Result, anyhow};
use trueaxis::compensation::{Direction, PoseError, Query};
use trueaxis::machine::{AXES, Axis, AxisOrder, ErrorModel};
use trueaxis_tables::Machine;

/// Error and correction at a position. Lists are in the order X, Y, Z, A, B, C.
pub(super) struct Found {
    /// Axes of the step.
    pub(super) axes: Vec<Axis>,
    pub(super) at: [f64; AXES],
    /// Of the tip, mm.
    pub(super) tip: [f64; 3],
    /// Of the tool, rad; only the volumetric model has it.
    pub(super) orientation: Option<[f64; 3]>,
    /// mm, degrees.
    pub(super) correction: [f64; AXES],
    /// Shares of the tip's error, mm: of each axis by its letter, of the location errors.
    pub(super) contributions: Vec<(String, [f64; 3])>,
    /// Axes beyond the end of their table.
    pub(super) clamped: Vec<Axis>,
    pub(super) out_of_travel: Vec<Axis>,
}

pub(super) fn at<const N: usize>(machine: &Machine, asked: &Asked) -> Result<Found> {
    let axes = AxisOrder::<N>::of(&machine.settings).map_err(|error| anyhow!("{error}"))?.axes();
    let (whole, correction, clamped) = look_up(machine, &axes, asked, passes(machine, None)?)?;
    let mut contributions = Vec::new();
    let mut rest = whole.tip.to_array();
    for (own, table) in machine.axes() {
        let mut without = machine.clone();
        let settings =
            without.settings.axes.iter_mut().zip(&mut without.tables).find(|(other, _)| other.axis == own.axis);
        if let Some((settings, table)) = settings {
            (settings.backlash, settings.thermal, *table) = (0.0, Default::default(), None);
        }
        if without == *machine && table.is_none() {
            continue;
        }
        let (others, ..) = look_up(&without, &axes, asked, 1)?;
        let share = std::array::from_fn(|i| whole.tip[i] - others.tip[i]);
        rest = std::array::from_fn(|i| rest[i] - share[i]);
        contributions.push((own.axis.letter().to_string(), share));
    }
    contributions.push((String::from("location errors"), rest));
    let mut found = Found {
        at: asked.at,
        tip: whole.tip.into(),
        orientation: (N > 3 && machine.settings.compensation.model == ErrorModel::Volumetric)
            .then_some(whole.orientation.into()),
        correction: [0.0; AXES],
        contributions,
        clamped: (0..N).filter(|slot| clamped >> slot & 1 == 1).map(|slot| axes[slot]).collect(),
        out_of_travel: Vec::new(),
        axes: axes.to_vec(),
    };
    for (axis, correction) in axes.into_iter().zip(correction) {
        found.correction[axis.index()] = correction;
    }
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
