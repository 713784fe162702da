//! Data of the figures of a calibration.

use super::plan::Plan;
use super::solve::Calibration;
use super::task::Task;
use super::terms::Term;
use crate::shown::half_width;
use serde::Serialize;
use trueaxis::machine::Axis;

/// Steps of a curve over the travel.
const STEPS: usize = 20;

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
            let first = plan.touches.iter().position(|touch| touch.visit == index)?;
            Some((first + 1, task.artefacts.get(visit.artefact)?.name.clone()))
        });
        Residuals {
            residual_um: calibration.solution.residuals_mm.iter().map(|mm| 1e3 * mm).collect(),
            sigma_um: 1e3 * calibration.solution.sigma_mm,
            visits: visits.collect(),
        }
    }
}

/// Translational errors of an axis, including its scale.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curves {
    /// Letter of the axis.
    pub axis: char,
    /// Positions.
    pub position_mm: Vec<f64>,
    /// EX, EY, EZ there.
    pub error_um: [Vec<f64>; 3],
    /// Expanded uncertainties of EX, EY, EZ, 95 %.
    pub expanded_um: [Vec<f64>; 3],
}

impl Curves {
    /// The curves of an axis; `None` if the calibration found none.
    pub fn of(calibration: &Calibration, axis: Axis) -> Option<Curves> {
        let terms = &calibration.observed.terms;
        if !terms.terms.iter().any(|term| matches!(term, Term::Curve { axis: of, .. } if *of == axis)) {
            return None;
        }
        let position_mm = terms.grid(axis, STEPS);
        let freedom = calibration.solution.degrees_of_freedom as f64;
        let at = |q: &f64, component: u8| calibration.shape(axis, component, *q, true).map(|mm| 1e3 * mm);
        let column = |of: &dyn Fn([f64; 2]) -> f64| {
            [0, 1, 2].map(|component| position_mm.iter().map(|q| of(at(q, component))).collect())
        };
        Some(Curves {
            axis: axis.letter(),
            error_um: column(&|[value, _]| value),
            expanded_um: column(&|[_, error]| half_width(error, freedom)),
            position_mm: position_mm.clone(),
        })
    }
}
