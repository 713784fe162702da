//! The tip over the volume.

use super::turns::{poses, turning};
use crate::calibrate::kinematics::Ideal;
use crate::calibrate::stylus::{Stylus, with_stylus};
use crate::calibrate::task::Task;
use crate::calibrate::terms::{Pose, Terms, perfect};
use anyhow::Result;
use trueaxis::machine::{AXES, Axis};
use trueaxis_tables::Machine;

/// Points along each axis, and where rotary axes turn at each of them.
const POINTS: usize = 7;
const TURNED: usize = 4;

/// Gram matrix of the tip's movements by the terms over the volume, without the best-fitting rigid motion, per point.
pub(super) struct Volume {
    pub(super) gram: Vec<Vec<f64>>,
}

impl Volume {
    /// 7 × 7 × 7 points of the travels, in positive and in negative travel, rotary axes at zero; where balls are turned,
    /// 4 × 4 × 4 points with all combinations of their angles.
    pub(super) fn new(task: &Task, machine: &Machine, terms: &Terms) -> Result<Volume> {
        let mut tools: Vec<Stylus> = task.wishes.tools_mm.iter().copied().map(Some).collect();
        if tools.is_empty() {
            tools.push(None);
        }
        let mut gram = vec![vec![0.0; terms.terms.len()]; terms.terms.len()];
        let turns = poses(task, machine, &turning(task, machine));
        for tool in &tools {
            let own = with_tool(&with_stylus(&perfect(machine), *tool), terms, &turns)?;
            for (sum, row) in gram.iter_mut().flatten().zip(own.into_iter().flatten()) {
                *sum += row / tools.len() as f64;
            }
        }
        Ok(Volume { gram })
    }

    /// Mean square of the tip's error, mm², with a covariance of the terms.
    pub(super) fn of(&self, covariance: &[Vec<f64>]) -> f64 {
        self.gram.iter().zip(covariance).map(|(g, c)| dot(g, c)).sum()
    }

    /// The same with terms that are independent.
    pub(super) fn of_ranges(&self, ranges: &[f64]) -> f64 {
        ranges.iter().enumerate().map(|(k, range)| self.gram[k][k] * range * range).sum()
    }
}

/// Gram matrix of the tip's movements by the terms.
fn with_tool(machine: &Machine, terms: &Terms, turns: &[[f64; 3]]) -> Result<Vec<Vec<f64>>> {
    let ideal = Ideal::new(machine)?;
    let travel = [Axis::X, Axis::Y, Axis::Z].map(|axis| machine.settings.axis(axis).map_or([0.0; 2], |own| own.travel));
    let points = if turns.len() > 1 { TURNED } else { POINTS };
    let mut poses = Vec::new();
    for index in 0..points.pow(3) {
        let mut position = [0.0; AXES];
        for k in 0..3 {
            let share = (index / points.pow(k as u32) % points) as f64 / (points - 1) as f64;
            position[k] = travel[k][0] + share * (travel[k][1] - travel[k][0]);
        }
        for turn in turns {
            position[3..].copy_from_slice(turn);
            for side in [0.0, 1.0] {
                let reverse = ideal.ordered(&[side, side, side, 0.0, 0.0, 0.0]);
                poses.push((ideal.tip(&position), Pose { position: ideal.ordered(&position), reverse }));
            }
        }
    }
    let only: Vec<Pose> = poses.iter().map(|(_, pose)| *pose).collect();
    let moved = terms.responses(machine, &only)?;
    // One column for each term, one row for each component of each point.
    let mut columns: Vec<Vec<f64>> =
        (0..terms.terms.len()).map(|term| moved.iter().flat_map(|of| of[term]).collect()).collect();
    let rigid = rigid(&poses.iter().map(|(tip, _)| *tip).collect::<Vec<_>>());
    for column in &mut columns {
        for direction in &rigid {
            let along = dot(column, direction);
            column.iter_mut().zip(direction).for_each(|(value, part)| *value -= along * part);
        }
    }
    let count = poses.len() as f64;
    let row = |one: &Vec<f64>| columns.iter().map(|other| dot(one, other) / count).collect();
    Ok(columns.iter().map(row).collect())
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Orthonormal movements of points by shifts and turns.
fn rigid(points: &[[f64; 3]]) -> Vec<Vec<f64>> {
    let movement = |k: usize, [x, y, z]: [f64; 3]| match k {
        0 => [1.0, 0.0, 0.0],
        1 => [0.0, 1.0, 0.0],
        2 => [0.0, 0.0, 1.0],
        3 => [0.0, -z, y],
        4 => [z, 0.0, -x],
        _ => [-y, x, 0.0],
    };
    let mut all: Vec<Vec<f64>> = Vec::new();
    for k in 0..6 {
        let mut own: Vec<f64> = points.iter().flat_map(|point| movement(k, *point)).collect();
        // Twice, against rounding.
        for _ in 0..2 {
            for before in &all {
                let along = dot(&own, before);
                own.iter_mut().zip(before).for_each(|(value, part)| *value -= along * part);
            }
        }
        let length = dot(&own, &own).sqrt();
        if length > 1e-9 {
            own.iter_mut().for_each(|value| *value /= length);
            all.push(own);
        }
    }
    all
}
