//! The results as a document and as additions to the machine.

use super::artefact::Kind;
use super::solve::Calibration;
use super::task::Task;
use super::terms::Term;
use crate::uncertainty::{CovarianceDocument, Estimate};
use serde::Serialize;
use std::collections::BTreeMap;
use trueaxis::machine::{AXES, Axis};
use trueaxis_report::number::significant;
use trueaxis_tables::finding::OVERCOMPENSATED;
use trueaxis_tables::finding::{Finding, Fit, Known};
use trueaxis_tables::uncertainty::Correlation;
use trueaxis_tables::{Additions, Machine};

/// Steps of a table computed from curves.
const STEPS: usize = 40;
/// Warn if a found size differs from the stated one by more than this many standard uncertainties.
const PULLED: f64 = 4.0;
/// Warn if the standard error of a term's effect over the travel exceeds this, µm.
const POOR_UM: f64 = 20.0;
/// Lost motion below zero by no more than this many standard errors counts as none.
const SCATTER: f64 = 3.0;

/// A term with its value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SolvedTerm {
    /// Name of the term.
    pub name: String,
    /// Value of the term.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
    /// Unit of both.
    pub unit: &'static str,
}

/// Size of an artefact.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Name of the artefact, or of one of its several sizes.
    pub name: String,
    /// Size that the task states: mm, for an angle degrees.
    pub stated: f64,
    /// Size that the network finds.
    pub found: f64,
    /// Standard error, µm; for an angle, µrad.
    pub standard_error: f64,
}

/// Displacement of the reference at a visit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Drift {
    /// Time without pauses, s.
    pub time_s: f64,
    /// Displacement since the first visit, µm, in workpiece coordinates.
    pub um: [f64; 3],
}

/// The JSON document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CalibrationDocument {
    /// The machine's name.
    pub machine: String,
    /// Whether the machine was compensated during probing.
    pub compensated: bool,
    /// Number of touches.
    pub touches: usize,
    /// Number of unknowns, all distinguishable.
    pub rank: usize,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Touches less unknowns, as far as the touches determine these: the basis of `sigma_um`.
    pub degrees_of_freedom: usize,
    /// Standard deviation of a touch, from the residuals.
    pub sigma_um: f64,
    /// Standard deviation of a touch, as stated.
    pub repeatability_um: f64,
    /// Root mean square of the touch displacements that the terms cause.
    pub signal_um: f64,
    /// Every term, and the tilts of the spindle.
    pub terms: Vec<SolvedTerm>,
    /// Covariance of the terms; its diagonal has the squares of their standard errors.
    pub covariance: CovarianceDocument,
    /// Location errors found, `C0Y_urad`, `EX0C_um`.
    pub location: BTreeMap<String, f64>,
    /// For every linear axis `scale_ppm`, `backlash_um`, and the range (maximum less minimum) of its curves without the scale,
    /// `EXX_um`, `EAX_urad`.
    pub axes: BTreeMap<String, BTreeMap<String, f64>>,
    /// Standard errors under the same names, by `location` and by axis; for curves, the root mean square over the touched
    /// range.
    pub standard_errors: BTreeMap<String, BTreeMap<String, f64>>,
    /// Effective radius of the tip; 0 with dials.
    pub tip_radius_mm: f64,
    /// Standard error of the radius.
    pub tip_radius_standard_error_um: f64,
    /// Sizes of the artefacts.
    pub artefacts: Vec<Size>,
    /// Drift at the visits to the reference.
    pub drift: Vec<Drift>,
    /// Caveats on the result.
    pub warnings: Vec<String>,
}

impl Calibration {
    /// The document.
    pub fn document(&self, task: &Task, machine: &Machine) -> CalibrationDocument {
        let (solution, observed) = (&self.solution, &self.observed);
        let terms = &observed.terms;
        let found = terms.terms.iter().enumerate().map(|(index, term)| {
            let (unit, factor) = term.unit();
            let (value, error) = (factor * solution.values[index], factor * solution.standard_errors[index]);
            SolvedTerm { name: term.name(), value, standard_error: error, unit }
        });
        // The machine's files have no key for them.
        let tilts = observed.tilts().map(|index| SolvedTerm {
            name: observed.names[index].clone(),
            value: 1e6 * solution.values[index],
            standard_error: 1e6 * solution.standard_errors[index],
            unit: "µrad",
        });
        let mut location = BTreeMap::new();
        let mut axes: BTreeMap<String, BTreeMap<String, f64>> = BTreeMap::new();
        let mut errors: BTreeMap<String, BTreeMap<String, f64>> = BTreeMap::new();
        for value in self.values() {
            let to = if value.of == "location" { &mut location } else { axes.entry(value.of.clone()).or_default() };
            to.insert(value.key.clone(), value.value);
            errors.entry(value.of).or_default().insert(value.key, value.standard_error);
        }
        let sizes = task.artefacts.iter().zip(&observed.sizes).flat_map(|(artefact, sizes)| {
            // A block that is the same as another one has the other's lengths.
            let sizes = match &artefact.kind {
                Kind::Block(block) if block.like.is_some() => &sizes[block.measured..],
                _ => sizes,
            };
            let several = sizes.len() > 1;
            sizes.iter().map(move |&index| {
                let (start, value) = (observed.network.unknowns[index].start, solution.values[index]);
                let angle = observed.angles.contains(&index);
                let shown = |value: f64| if angle { 90.0 + value.to_degrees() } else { value };
                let error = solution.standard_errors[index] * if angle { 1e6 } else { 1e3 };
                let name = if several { &observed.names[index] } else { &artefact.name };
                Size { name: name.clone(), stated: shown(start), found: shown(value), standard_error: error }
            })
        });
        let first_tip = observed.network.tip;
        let tips = observed.tips.iter().filter(|tip| **tip != first_tip).map(|&tip| Size {
            name: observed.names[tip].clone(),
            stated: observed.network.unknowns[tip].start,
            found: solution.values[tip],
            standard_error: 1e3 * solution.standard_errors[tip],
        });
        let at = |knot: Option<usize>, k: usize| knot.map_or(0.0, |index| 1e3 * solution.values[index + k]);
        let drift = observed.knots.iter().map(|&(time_s, knot)| Drift { time_s, um: [0, 1, 2].map(|k| at(knot, k)) });
        let tip = observed.network.tip;
        CalibrationDocument {
            machine: machine.settings.name.to_string(),
            compensated: task.compensated,
            touches: self.lines.len(),
            rank: solution.rank,
            condition: solution.condition,
            degrees_of_freedom: solution.degrees_of_freedom,
            sigma_um: 1e3 * solution.sigma_mm,
            repeatability_um: 1e3 * task.probe.repeatability_mm,
            signal_um: 1e3 * solution.signal_mm,
            terms: found.chain(tilts).collect(),
            covariance: self.covariance(),
            location,
            axes,
            standard_errors: errors,
            tip_radius_mm: solution.values[tip],
            tip_radius_standard_error_um: 1e3 * solution.standard_errors[tip],
            artefacts: sizes.chain(tips).collect(),
            drift: drift.collect(),
            warnings: self.warnings(task),
        }
    }

    fn covariance(&self) -> CovarianceDocument {
        let of = |(term, value): (&Term, &f64)| {
            let (unit, factor) = term.unit();
            Estimate { name: term.name(), unit, factor, value: *value }
        };
        let terms = self.observed.terms.terms.iter().zip(&self.solution.values).map(of).collect();
        CovarianceDocument::of(terms, |i, j| self.solution.covariance[i][j])
    }

    fn warnings(&self, task: &Task) -> Vec<String> {
        let (solution, terms) = (&self.solution, &self.observed.terms);
        let mut warnings = Vec::new();
        if task.reference.is_none() && !task.is_read() {
            warnings.push(String::from("no reference was touched again: a drift would be in the results"));
        }
        if solution.sigma_mm > 2.0 * task.probe.repeatability_mm {
            warnings.push(format!(
                "{} scatter by {:.2} µm, {:.2} µm is stated: form errors that the terms do not model, or a less repeatable probe",
                task.words(),
                1e3 * solution.sigma_mm,
                1e3 * task.probe.repeatability_mm
            ));
        }
        for (index, unknown) in self.observed.network.unknowns.iter().enumerate() {
            let away = solution.values[index] - unknown.start;
            if let Some(stated) = unknown.uncertainty.filter(|stated| away.abs() > PULLED * stated) {
                let (factor, unit) = match terms.terms.get(index) {
                    Some(term) => {
                        let (unit, factor) = term.unit();
                        (factor, unit)
                    }
                    None if self.observed.angles.contains(&index) => (1e6, "µrad"),
                    None if self.observed.lengths.contains(&Some(index)) => (1e6, "ppm"),
                    None => (1e3, "µm"),
                };
                let name = &self.observed.names[index];
                warnings.push(format!(
                    "{name} differs by {:.1} {unit} from the stated value, whose uncertainty is {:.1} {unit}",
                    factor * away,
                    factor * stated
                ));
            }
        }
        for (index, term) in terms.terms.iter().enumerate() {
            let error = solution.standard_errors[index];
            if let Term::Backlash(_) = term
                && solution.values[index] < -SCATTER * error
            {
                let um = significant(1e3 * solution.values[index], 3);
                warnings.push(format!("{} is {um} µm: {OVERCOMPENSATED}", term.name()));
            }
            let travel = |axis: Axis| terms.travel_mm[axis.index() % 3];
            let effect = match *term {
                // Those that no touch sees are named.
                Term::Curve { component: 3.., .. } => 0.0,
                Term::Curve { axis, component, degree } => {
                    travel(axis).map(|q| terms.curve(axis, component, degree, q).abs()).into_iter().fold(0.0, f64::max)
                        * error
                }
                Term::Squareness(which) => {
                    let [low, high] = travel(if which == 0 { Axis::Y } else { Axis::Z });
                    (high - low) * error
                }
                _ => error,
            };
            if 1e3 * effect > POOR_UM {
                let name = term.name();
                warnings.push(format!(
                    "{name} is known to {:.0} µm only over the travel: a longer measuring base would determine it better",
                    1e3 * effect
                ));
            }
        }
        warnings.extend(self.unseen_words(task));
        warnings
    }

    /// Curve of an axis at a position, without its scale unless `with_scale`, and its standard error, mm or rad.
    pub fn shape(&self, axis: Axis, component: u8, position: f64, with_scale: bool) -> [f64; 2] {
        let terms = &self.observed.terms;
        let own: Vec<(usize, f64)> = terms
            .terms
            .iter()
            .enumerate()
            .filter_map(|(index, term)| match *term {
                Term::Curve { axis: of, component: c, degree }
                    if of == axis && c == component && (with_scale || degree > 1 || component >= 3) =>
                {
                    Some((index, terms.curve(axis, component, degree, position)))
                }
                _ => None,
            })
            .collect();
        let value = own.iter().map(|(index, base)| base * self.solution.values[*index]).sum();
        let variance: f64 = own
            .iter()
            .flat_map(|(i, a)| own.iter().map(move |(j, b)| (*i, *j, a * b)))
            .map(|(i, j, product)| product * self.solution.covariance[i][j])
            .sum();
        [value, variance.max(0.0).sqrt()]
    }

    /// Values under the keys of documents and of `machine.toml`.
    fn values(&self) -> Vec<Keyed> {
        let (solution, terms) = (&self.solution, &self.observed.terms);
        let mut values = Vec::new();
        for (index, term) in terms.terms.iter().enumerate() {
            let (_, factor) = term.unit();
            let (value, standard_error) = (factor * solution.values[index], factor * solution.standard_errors[index]);
            if let Some((of, key)) = term.key() {
                values.push(Keyed { of, key, value, standard_error, curve: None, rms: None });
            } else if let Term::Curve { axis, component, .. } = *term {
                // One value for all degrees.
                if !values.iter().any(|value: &Keyed| value.curve == Some((axis, component))) {
                    values.push(self.curve(axis, component));
                }
            }
        }
        values
    }

    fn curve(&self, axis: Axis, component: u8) -> Keyed {
        let [low, high] = self.observed.terms.reach_mm[axis.index() % 3];
        let points = (0..=STEPS).map(|i| low + (high - low) * i as f64 / STEPS as f64);
        let shape: Vec<[f64; 2]> = points.map(|q| self.shape(axis, component, q, false)).collect();
        let most = shape.iter().map(|[value, _]| *value).fold(f64::NEG_INFINITY, f64::max);
        let least = shape.iter().map(|[value, _]| *value).fold(f64::INFINITY, f64::min);
        let squares: f64 = shape.iter().map(|[_, error]| error * error).sum();
        let direction = Axis::ALL[usize::from(component) % AXES].letter();
        let (unit, factor) = if component < 3 { ("um", 1e3) } else { ("urad", 1e6) };
        Keyed {
            of: axis.letter().to_string(),
            key: format!("E{direction}{}_{unit}", axis.letter()),
            value: factor * (most - least),
            standard_error: factor * (squares / shape.len() as f64).sqrt(),
            curve: Some((axis, component)),
            rms: Some(factor * (shape.iter().map(|[value, _]| value * value).sum::<f64>() / shape.len() as f64).sqrt()),
        }
    }

    /// The results, to be added to the values in the machine's files.
    pub fn additions(&self, task: &Task) -> Additions {
        let (solution, terms) = (&self.solution, &self.observed.terms);
        let finding = |keyed: Keyed| {
            let axis = Axis::ALL.into_iter().find(|axis| keyed.of == axis.letter().to_string());
            // Terms in the finding's curve: the scale alone, or the shape of a component without it.
            let is_own = |term: &Term| match (*term, keyed.curve) {
                (Term::Curve { axis: of, component, degree: 1 }, None) => {
                    keyed.key == "scale_ppm" && Some(of) == axis && usize::from(component) == of.index()
                }
                (Term::Curve { axis: of, component, degree }, Some(curve)) => {
                    (of, component) == curve && (degree > 1 || usize::from(component) != of.index())
                }
                _ => false,
            };
            let own = terms.terms.iter().zip(&solution.values);
            let own: Vec<f64> = own.map(|(term, value)| if is_own(term) { *value } else { 0.0 }).collect();
            let is_curve = keyed.curve.is_some() || keyed.key == "scale_ppm";
            let curve = axis.filter(|_| is_curve).map_or_else(Vec::new, |axis| {
                terms.grid(axis, STEPS).into_iter().map(|q| (q, terms.error(&own, axis, q))).collect()
            });
            let value = keyed.rms.unwrap_or(keyed.value);
            // With rotary axes or angular errors the terms are known much better jointly than singly: applying one without the
            // others does harm.
            let moved = terms.terms.iter().any(|term| matches!(term, Term::Location(..)) || term.is_angle());
            let section = if keyed.of == "location" { keyed.of } else { format!("axis.{}", keyed.of) };
            Finding {
                key: format!("{section}.{}", keyed.key),
                found: Known::new(value, keyed.standard_error, solution.degrees_of_freedom),
                on_top: true,
                moved,
                curve,
                ..Finding::default()
            }
        };
        let fit = Fit {
            before_mm: solution.sigma_mm.hypot(solution.signal_mm),
            left_mm: solution.sigma_mm,
            noise_mm: Some(task.probe.repeatability_mm),
            is_angle: false,
        };
        let unseen = self.unseen();
        let is_seen = |keyed: &Keyed| keyed.curve.is_none_or(|curve| !unseen.contains(&curve));
        let findings: Vec<Finding> = self.values().into_iter().filter(is_seen).map(finding).collect();
        let correlations = self.correlations(&findings);
        // A range pulls a value towards zero, so that a second look at one log would find the rest of it.
        let compensated = task.compensated || terms.terms.iter().any(|term| term.is_angle());
        Additions { findings, correlations, fit: Some(fit), compensated, ..Additions::default() }
    }

    /// Coefficients of correlation between the findings of one term each; a shape has several terms.
    fn correlations(&self, findings: &[Finding]) -> Vec<Correlation> {
        let (terms, covariance) = (&self.observed.terms.terms, &self.solution.covariance);
        let key = |term: &Term| {
            let (of, key) = term.key()?;
            let key = if of == "location" { format!("{of}.{key}") } else { format!("axis.{of}.{key}") };
            findings.iter().any(|own| own.key == key).then_some(key)
        };
        let single: Vec<(usize, String)> =
            terms.iter().enumerate().filter_map(|(index, term)| Some((index, key(term)?))).collect();
        let mut found = Vec::new();
        for (place, (i, one)) in single.iter().enumerate() {
            for (j, other) in &single[place + 1..] {
                let coefficient = covariance[*i][*j] / (covariance[*i][*i] * covariance[*j][*j]).sqrt();
                if coefficient.is_finite() {
                    found.push(Correlation { between: [one.clone(), other.clone()], coefficient });
                }
            }
        }
        found
    }
}

impl Term {
    /// `location` or the axis' letter, and the key of a term that is a value by itself; `None`: a part of a shape.
    fn key(&self) -> Option<(String, String)> {
        Some(match *self {
            Term::Squareness(which) => {
                ("location".into(), format!("{}_urad", ["C0Y", "B0Z", "A0Z"][usize::from(which) % 3]))
            }
            Term::Location(_, component) => {
                let unit = if component < 3 { "um" } else { "urad" };
                ("location".into(), format!("{}_{unit}", self.name()))
            }
            Term::Backlash(axis) => (axis.letter().to_string(), "backlash_um".into()),
            Term::Curve { axis, component, degree: 1 } if usize::from(component) == axis.index() => {
                (axis.letter().to_string(), "scale_ppm".into())
            }
            Term::Curve { .. } => return None,
        })
    }
}

/// A value with its key.
struct Keyed {
    /// `location`, or the axis' letter.
    of: String,
    key: String,
    value: f64,
    standard_error: f64,
    curve: Option<(Axis, u8)>,
    /// Root mean square of a curve.
    rms: Option<f64>,
}
