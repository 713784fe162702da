//! Figures of a calibration.

use super::plan::Plan;
use super::solve::Calibration;
use super::task::Task;
use super::terms::Term;
use trueaxis::machine::Axis;
use trueaxis_report::{Figure, Scale, Stroke, colour, error_bars};

/// What is left of every touch, in the order of the program.
pub fn residuals(task: &Task, plan: &Plan, calibration: &Calibration) -> Figure {
    let left: Vec<[f64; 2]> =
        (1..).zip(&calibration.solution.residuals_mm).map(|(id, residual)| [f64::from(id), 1e3 * residual]).collect();
    let y = Scale::linear("residual in µm", left.iter().map(|point| point[1]).chain([0.0])).margin(0.08);
    let x = Scale::linear("touch", [1.0, left.len() as f64]);
    let mut figure = Figure::full("Residuals of all touches", 300, x, y);
    let sigma = 1e3 * calibration.solution.sigma_mm;
    figure.across(2.0 * sigma, colour::LIMIT).across(-2.0 * sigma, colour::LIMIT);
    let stroke = Stroke::new(colour::COMPENSATED, 1.0);
    figure.line(left.iter().copied(), stroke.opacity(0.5)).dots(left.iter().copied(), colour::COMPENSATED);
    figure.key("what is left of a touch, positive outside the surface", stroke);
    figure.key("two standard deviations of a touch", Stroke::new(colour::LIMIT, 1.2).dashed());
    let starts = plan.visits.iter().enumerate().filter(|(_, visit)| !visit.reference);
    let labels = starts.filter_map(|(index, visit)| {
        let first = plan.touches.iter().position(|touch| touch.visit == index)?;
        Some(((first + 1) as f64, task.artefacts[visit.artefact].name.clone()))
    });
    figure.labels_above(labels);
    figure.caption("What the machine's terms, the places of the artefacts and the drift leave of every touch.");
    figure
}

/// The curves found for an axis, its scale included, with bars of two standard errors; none where it has none.
pub fn curves(calibration: &Calibration, axis: Axis) -> Option<Figure> {
    let terms = &calibration.observed.terms;
    let has = terms.terms.iter().any(|term| matches!(term, Term::Curve { axis: of, .. } if *of == axis));
    if !has {
        return None;
    }
    let letter = axis.letter();
    let points = terms.grid(axis, 20);
    let x = Scale::linear(&format!("{letter} in mm"), points.iter().copied());
    let names = ['X', 'Y', 'Z'].map(|direction| format!("E{direction}{letter}"));
    let curve = |component: u8| {
        let at = |q: f64| {
            let [value, error] = calibration.shape(axis, component, q, true);
            [q, 1e3 * value, 1e3 * error]
        };
        points.iter().map(|q| at(*q)).collect::<Vec<_>>()
    };
    let curves = [(names[0].as_str(), curve(0)), (names[1].as_str(), curve(1)), (names[2].as_str(), curve(2))];
    let mut figure = error_bars(&format!("Errors found of axis {letter}"), x, "µm", curves);
    figure.caption(format!(
        "Errors of {letter} that are added to its table, with bars of two standard errors to either side."
    ));
    Some(figure)
}

/// The reference over time; none without one.
pub fn drift(calibration: &Calibration) -> Option<Figure> {
    let knots = &calibration.observed.knots;
    if knots.len() < 2 {
        return None;
    }
    let (values, errors) = (&calibration.solution.values, &calibration.solution.standard_errors);
    let curve = |k: usize| {
        let at = |list: &[f64], knot: Option<usize>| knot.map_or(0.0, |index| 1e3 * list[index + k]);
        knots.iter().map(|&(time, knot)| [time / 60.0, at(values, knot), at(errors, knot)]).collect::<Vec<_>>()
    };
    let x = Scale::linear("time in minutes, without pauses", knots.iter().map(|(time, _)| time / 60.0));
    let mut figure = error_bars("Drift of the reference", x, "µm", [("X", curve(0)), ("Y", curve(1)), ("Z", curve(2))]);
    figure.caption("The reference against its first look, with bars of two standard errors to either side.");
    Some(figure)
}
