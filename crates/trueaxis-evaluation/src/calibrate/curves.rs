//! The numbers in the figures of a calibration.

use super::plan::Plan;
use super::solve::Calibration;
use super::task::Task;
use super::terms::Term;
use serde::Serialize;
use trueaxis::machine::Axis;

/// Steps of a curve over what is touched.
const STEPS: usize = 20;

/// Residuals of all touches.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Residuals {
    /// Of every touch, in the order of the program, positive outside the surface.
    pub residual_um: Vec<f64>,
    /// Standard deviation of a touch.
    pub sigma_um: f64,
    /// Artefacts by name where their touches begin, from 1; without those of the reference.
    pub visits: Vec<(usize, String)>,
}

impl Residuals {
    /// Those of a calibration.
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

/// Translations of an axis, its scale included.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curves {
    /// Its letter.
    pub axis: char,
    /// Positions.
    pub position_mm: Vec<f64>,
    /// EX, EY, EZ there.
    pub error_um: [Vec<f64>; 3],
    /// Their standard errors.
    pub standard_error_um: [Vec<f64>; 3],
}

impl Curves {
    /// Those of an axis; none where a calibration has none.
    pub fn of(calibration: &Calibration, axis: Axis) -> Option<Curves> {
        let terms = &calibration.observed.terms;
        if !terms.terms.iter().any(|term| matches!(term, Term::Curve { axis: of, .. } if *of == axis)) {
            return None;
        }
        let position_mm = terms.grid(axis, STEPS);
        let part = |component: u8, part: usize| {
            let at = |q: &f64| calibration.shape(axis, component, *q, true).map(|mm| 1e3 * mm);
            position_mm.iter().map(|q| at(q)[part]).collect()
        };
        let [error_um, standard_error_um] = [0, 1].map(|of| [0, 1, 2].map(|component| part(component, of)));
        Some(Curves { axis: axis.letter(), error_um, standard_error_um, position_mm })
    }
}
