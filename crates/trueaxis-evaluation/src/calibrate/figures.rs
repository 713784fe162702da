//! The figure of the residuals of a calibration.

use super::plan::Plan;
use super::solve::Calibration;
use super::task::Task;
use serde::Serialize;
use trueaxis_report::{Figure, Scale, Stroke, colour};

/// Residuals of all touches.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Residuals {
    /// Residual of every touch in program order, positive outside the surface.
    pub residual_um: Vec<f64>,
    /// Standard deviation of a touch.
    pub sigma_um: f64,
    /// First touch of each visit, from 1, with the artefact's name; visits to the reference are excluded.
    pub visits: Vec<(usize, String)>,
}

impl Residuals {
    /// The residuals of a calibration.
    pub fn of(task: &Task, plan: &Plan, calibration: &Calibration) -> Residuals {
        let starts = plan.visits.iter().enumerate().filter(|(_, visit)| !visit.reference);
        let visits = starts.filter_map(|(index, visit)| {
            let of = &calibration.observed.planned;
            let first = of.iter().position(|touch| plan.touches[*touch].visit == index)?;
            Some((first + 1, task.artefacts.get(visit.artefact)?.name.clone()))
        });
        Residuals {
            residual_um: calibration.solution.residuals_mm.iter().map(|mm| 1e3 * mm).collect(),
            sigma_um: 1e3 * calibration.solution.sigma_mm,
            visits: visits.collect(),
        }
    }
}

/// Residual of every touch, in program order.
pub fn residuals(task: &Task, plan: &Plan, calibration: &Calibration) -> Figure {
    let Residuals { residual_um, sigma_um: sigma, visits } = Residuals::of(task, plan, calibration);
    let left: Vec<[f64; 2]> = (1..).zip(residual_um).map(|(id, residual)| [f64::from(id), residual]).collect();
    let y = Scale::linear("residual in µm", left.iter().map(|point| point[1]).chain([0.0])).margin(0.08);
    let word = if task.plate().is_some() { "centre" } else { task.word() };
    let x = Scale::linear(word, [1.0, left.len() as f64]);
    let mut figure = Figure::full(&format!("Residual of every {word}"), 300, x, y);
    figure.across(2.0 * sigma, colour::LIMIT).across(-2.0 * sigma, colour::LIMIT);
    let stroke = Stroke::new(colour::COMPENSATED, 1.0);
    figure.line(left.iter().copied(), stroke.opacity(0.5)).dots(left.iter().copied(), colour::COMPENSATED);
    let sense = if task.plate().is_some() { "along its axis" } else { "positive outside the surface" };
    figure.key(format!("residual of a {word}, {sense}"), stroke);
    figure.key(format!("two standard deviations of a {word}"), Stroke::new(colour::LIMIT, 1.2).dashed());
    figure.labels_above(visits.into_iter().map(|(first, name)| (first as f64, name)));
    figure.caption(format!(
        "Residual of every {word} after the machine's terms, the places of the artefacts and the drift."
    ));
    figure
}
