//! Figures of a calibration.

use super::curves::{Curves, Residuals};
use super::plan::Plan;
use super::solve::Calibration;
use super::task::Task;
use crate::shown::half_width;
use trueaxis::machine::Axis;
use trueaxis_report::{BARS, Figure, Scale, Stroke, colour, error_bars};

/// Residual of every touch, in program order.
pub fn residuals(task: &Task, plan: &Plan, calibration: &Calibration) -> Figure {
    let Residuals { residual_um, sigma_um: sigma, visits } = Residuals::of(task, plan, calibration);
    let left: Vec<[f64; 2]> = (1..).zip(residual_um).map(|(id, residual)| [f64::from(id), residual]).collect();
    let y = Scale::linear("residual in µm", left.iter().map(|point| point[1]).chain([0.0])).margin(0.08);
    let x = Scale::linear("touch", [1.0, left.len() as f64]);
    let mut figure = Figure::full("Residuals of all touches", 300, x, y);
    figure.across(2.0 * sigma, colour::LIMIT).across(-2.0 * sigma, colour::LIMIT);
    let stroke = Stroke::new(colour::COMPENSATED, 1.0);
    figure.line(left.iter().copied(), stroke.opacity(0.5)).dots(left.iter().copied(), colour::COMPENSATED);
    figure.key("residual of a touch, positive outside the surface", stroke);
    figure.key("two standard deviations of a touch", Stroke::new(colour::LIMIT, 1.2).dashed());
    figure.labels_above(visits.into_iter().map(|(first, name)| (first as f64, name)));
    figure.caption("Residual of every touch after the machine's terms, the places of the artefacts and the drift.");
    figure
}

/// The curves found for an axis, including its scale, with bars of the expanded uncertainty; `None` if it has none.
pub fn curves(calibration: &Calibration, axis: Axis) -> Option<Figure> {
    let Curves { axis: letter, position_mm, error_um, expanded_um } = Curves::of(calibration, axis)?;
    let x = Scale::linear(&format!("{letter} in mm"), position_mm.iter().copied());
    let names = ['X', 'Y', 'Z'].map(|direction| format!("E{direction}{letter}"));
    let curve = |k: usize| {
        let values = error_um[k].iter().zip(&expanded_um[k]);
        position_mm.iter().zip(values).map(|(q, (value, half_width))| [*q, *value, *half_width]).collect::<Vec<_>>()
    };
    let curves = [0, 1, 2].map(|k| (names[k].as_str(), curve(k)));
    let mut figure = error_bars(&format!("Errors found of axis {letter}"), x, "µm", &curves);
    figure.caption(format!("Errors of {letter} added to its table. {BARS}"));
    Some(figure)
}

/// Drift of the reference over time; `None` without a reference.
pub fn drift(calibration: &Calibration) -> Option<Figure> {
    let knots = &calibration.observed.knots;
    if knots.len() < 2 {
        return None;
    }
    let (values, errors) = (&calibration.solution.values, &calibration.solution.standard_errors);
    let curve = |k: usize| {
        let at = |list: &[f64], knot: Option<usize>| knot.map_or(0.0, |index| 1e3 * list[index + k]);
        let bar = |knot| half_width(at(errors, knot), calibration.solution.degrees_of_freedom as f64);
        knots.iter().map(|&(time, knot)| [time / 60.0, at(values, knot), bar(knot)]).collect::<Vec<_>>()
    };
    let x = Scale::linear("time in minutes, without pauses", knots.iter().map(|(time, _)| time / 60.0));
    let curves = [("X", curve(0)), ("Y", curve(1)), ("Z", curve(2))];
    let mut figure = error_bars("Drift of the reference", x, "µm", &curves);
    figure.caption(format!("Movement of the reference since its first probing. {BARS}"));
    Some(figure)
}
