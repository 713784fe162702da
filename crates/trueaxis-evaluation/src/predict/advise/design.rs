//! What measurements tell about the uncertain quantities of a machine.

use super::candidate::{Candidate, Shop, grouped};
use super::sights::{FOUND, RESULTS, Sights};
use super::text::task_text;
use crate::calibrate::{Ideal, Plan, Pose, Task, observe, planned};
use crate::predict::unknowns::{Model, Unknown};
use crate::uncertainty::monte_carlo::machine_of;
use anyhow::{Result, anyhow};
use std::path::Path;
use trueaxis_metrology::cores::*;
use trueaxis_metrology::linear_fit::LinearFit;
use trueaxis_metrology::uncertainty::condensed;
use trueaxis_tables::exact::Geometry;

/// Readings of unit variance: derivatives with respect to the unknowns.
pub(super) type Readings = Vec<Vec<f64>>;

/// A measurement, or several artefacts of one task.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) readings: Readings,
    /// Time of the probing program.
    pub(super) minutes: f64,
}

/// Movement of the tip by each unknown alone at poses of the machine, workpiece coordinates, mm: `[unknown][pose]`.
pub(super) fn moved(model: &Model<'_>, unknowns: &[Unknown], poses: &[Pose]) -> Result<Vec<Vec<[f64; 3]>>> {
    let base = Geometry::new(model.machine, 0.0).map_err(|error| anyhow!("{error}"))?;
    let base: Vec<[f64; 3]> = poses.iter().map(|pose| base.actual_pose(&pose.position, &pose.reverse).tip_mm).collect();
    let of = |unknown: &Unknown| -> Result<Vec<[f64; 3]>> {
        if unknown.squared || model.is_approach(unknown.term) {
            return Ok(vec![[0.0; 3]; poses.len()]);
        }
        let (machine, along) = machine_of(model.machine, model.terms, model.alone(unknown, 1.0).common());
        let geometry = Geometry::new(&machine, 0.0).map_err(|error| anyhow!("{error}"))?;
        let tip = |pose: &Pose| {
            let mut position = pose.position;
            for one in &along {
                let slot = model.machine.settings.axes.iter().position(|own| own.axis == one.axis);
                let Some(slot) = slot else { continue };
                position[slot] += one.moves(pose.position[slot], pose.reverse[slot]);
            }
            geometry.actual_pose(&position, &pose.reverse).tip_mm
        };
        let moved = |(pose, base): (&Pose, &[f64; 3])| {
            let tip = tip(pose);
            std::array::from_fn(|k| tip[k] - base[k])
        };
        Ok(poses.iter().zip(&base).map(moved).collect())
    };
    (0..unknowns.len()).into_par_iter().map(|k| of(&unknowns[k])).collect()
}

/// What the readings of an instrument say.
pub(super) fn of_sights(model: &Model<'_>, unknowns: &[Unknown], sights: &Sights) -> Result<Block> {
    if let Some(refused) = &sights.refused {
        return Err(anyhow!("found {refused}"));
    }
    let moved = moved(model, unknowns, &sights.poses)?;
    let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let row = |reading: usize| moved.iter().map(|of| dot(&sights.along[reading], &of[reading])).collect();
    let count = sights.poses.len();
    let design: Vec<Vec<f64>> = (0..count).map(row).collect();
    let (design, noise) = if sights.found.is_empty() { direct(sights, design) } else { evaluated(sights, &design) };
    let readings = condensed(&design, &noise).ok_or_else(|| anyhow!("found readings that say nothing"))?;
    Ok(Block { readings, minutes: 0.0 })
}

/// Each reading by itself, with what is common to them.
fn direct(sights: &Sights, design: Vec<Vec<f64>>) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let count = design.len();
    let noise = |one: usize, other: usize| {
        let common: f64 = sights.others.iter().map(|column| column[one] * column[other]).sum();
        common + if one == other { sights.noise_mm * sights.noise_mm } else { 0.0 }
    };
    (design, (0..count).map(|one| (0..count).map(|other| noise(one, other)).collect()).collect())
}

/// The results of a least-squares evaluation of the readings, and their covariance.
fn evaluated(sights: &Sights, design: &[Vec<f64>]) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let fit = |values: &dyn Fn(usize) -> f64| {
        let mut fit = LinearFit::new(FOUND);
        for (reading, row) in sights.found.iter().enumerate() {
            fit.add(row, values(reading), 1.0 / sights.noise_mm);
        }
        fit.solve()
    };
    let count = design.first().map_or(0, Vec::len);
    let found: Vec<Vec<f64>> = (0..count).map(|k| fit(&|reading| design[reading][k]).values).collect();
    let terms = (0..RESULTS).map(|term| found.iter().map(|values| values[term]).collect());
    let solved = fit(&|_| 0.0);
    let entry = |one| (0..RESULTS).map(|other| solved.covariance_factor(one, other)).collect();
    (terms.collect(), (0..RESULTS).map(entry).collect())
}

/// What the terms say that a task finds.
///
/// # Errors
/// A task that the machine cannot do, or whose artefacts cannot separate its terms.
pub(super) fn of_task(model: &Model<'_>, unknowns: &[Unknown], task: &Task) -> Result<Block> {
    let nominal = model.machine;
    let plan = Plan::new(task, nominal)?;
    let positions = planned(task, &plan);
    let corrected = Task { compensated: true, ..task.clone() };
    let observed = observe(&corrected, nominal, &plan, &positions)?;
    let ideal = Ideal::new(nominal)?;
    let pose = |(touch, position): (&crate::calibrate::Planned, &_)| {
        let [x, y, z] = touch.reverse;
        Pose { position: ideal.ordered(position), reverse: ideal.ordered(&[x, y, z, 0.0, 0.0, 0.0]) }
    };
    let poses: Vec<Pose> = plan.touches.iter().zip(&positions).map(pose).collect();
    let observed = crate::calibrate::foresee_observed(&corrected, &plan, observed)?.observed;
    let moved: Vec<_> = moved(model, unknowns, &poses)?.iter().map(|of| observed.at_network(of)).collect();
    let shown = observed.network.shown(&moved).map_err(|refused| anyhow!("{refused}"))?;
    let readings = if shown.design.is_empty() { None } else { condensed(&shown.design, &shown.covariance) };
    Ok(Block { readings: readings.unwrap_or_default(), minutes: plan.minutes() })
}

/// The task of these artefacts; its machine is the predicted one, whatever the text names.
///
/// # Errors
/// As [`Task::read`].
pub(super) fn task_of<'a>(shop: &Shop<'_>, chosen: impl Iterator<Item = &'a Candidate>) -> Result<Task> {
    let text = task_text("machine", shop.probe, shop.scatter_mm, &grouped(chosen));
    Ok(Task::read(&text, Path::new("the advised task"))?)
}
