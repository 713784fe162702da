//! The results of a diagonal test, as a document.

use crate::shown::Uncertainty;
use serde::Serialize;
use trueaxis_metrology::diagonal::{Term, Test, figures};
use trueaxis_tables::Additions;
use trueaxis_tables::finding::{Finding, Known};

/// A value with its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Value {
    /// The value.
    pub value: f64,
    /// Standard error, same unit.
    pub standard_error: f64,
    /// Degrees of freedom of the standard error; infinite if it is stated.
    #[serde(skip)]
    pub degrees_of_freedom: f64,
}

impl Value {
    /// The uncertainty as shown.
    pub fn uncertainty(&self) -> Uncertainty {
        Uncertainty::of(self.standard_error, self.degrees_of_freedom)
    }
}

/// Figures of one diagonal according to ISO 230-6.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DiagonalFigures {
    /// Number of the diagonal.
    pub diagonal: usize,
    /// Unit vector from the first to the last target.
    pub unit: [f64; 3],
    /// Length of the diagonal.
    pub length_mm: f64,
    /// Number of targets on it.
    pub targets: usize,
    /// E(D): systematic deviation of positioning.
    pub e_um: f64,
    /// B(D): reversal value; null with one direction.
    pub b_um: Option<f64>,
    /// M(D): range of the mean deviation.
    pub m_um: f64,
    /// R(D): repeatability; null with one run.
    pub r_um: Option<f64>,
    /// Slope of the deviation.
    pub slope_ppm: Value,
}

/// Errors of an axis at a position, slopes removed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Position of the axis.
    pub position_mm: f64,
    /// Errors along X, Y, Z.
    pub error_um: [f64; 3],
    /// Standard errors of these.
    pub standard_error_um: [f64; 3],
}

/// Shape of an axis' errors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shape {
    /// The axis that moves.
    pub axis: char,
    /// Errors by position.
    pub points: Vec<Point>,
}

/// Results that the vector method adds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Steps {
    /// Scales of X, Y, Z if the mirror was exactly square.
    pub scales_if_aligned_ppm: [f64; 3],
    /// Scales with the stated uncertainty of the alignment; null if none is stated.
    pub scales_ppm: Option<[Value; 3]>,
    /// Change of a scale for a mirror 10 µrad off on every diagonal.
    pub scale_per_10_urad_ppm: [f64; 3],
    /// EXX, EYX, EZX and so on, slopes removed.
    pub shapes: Vec<Shape>,
    /// Standard deviation of a step, from the redundant equation of each step.
    pub sigma_um: f64,
    /// Number of redundant equations.
    pub degrees_of_freedom: usize,
    /// Condition number of the equations of a step.
    pub condition: f64,
    /// Largest distance of a target from its diagonal.
    #[serde(rename = "beside_mm")]
    pub lateral_mm: f64,
}

/// The JSON document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DiagonalDocument {
    /// Number of readings in the record.
    pub readings: usize,
    /// "diagonal" or "step-diagonal".
    pub test: &'static str,
    /// Figures of every diagonal.
    pub diagonals: Vec<DiagonalFigures>,
    /// E_d: largest E(D).
    pub e_d_um: f64,
    /// B_d: largest B(D).
    pub b_d_um: Option<f64>,
    /// M_d: largest M(D).
    pub m_d_um: f64,
    /// R_d: largest R(D).
    pub r_d_um: Option<f64>,
    /// A0Z.
    #[serde(rename = "a0z_urad")]
    pub a0z: Value,
    /// B0Z.
    #[serde(rename = "b0z_urad")]
    pub b0z: Value,
    /// C0Y.
    #[serde(rename = "c0y_urad")]
    pub c0y: Value,
    /// Scale along a diagonal: Σ u_i² s_i.
    #[serde(rename = "diagonal_scale_ppm")]
    pub scale: Value,
    /// Rank of the four slopes.
    pub rank: usize,
    /// Condition number of the four equations.
    pub condition: f64,
    /// Standard deviation of a reading, from repeats; null without repeats.
    pub sigma_um: Option<f64>,
    /// Results of the steps; null without steps.
    pub steps: Option<Steps>,
    /// Limits of the method, one sentence each.
    pub limits: Vec<String>,
}

fn micro(term: Term, degrees_of_freedom: f64) -> Value {
    Value { value: 1e6 * term.value, standard_error: 1e6 * term.standard_error, degrees_of_freedom }
}

/// Degrees of freedom of the slope of a diagonal.
fn degrees_of_slope(test: &Test, diagonal: usize) -> f64 {
    test.on(diagonal).count().saturating_sub(2).max(1) as f64
}

/// Degrees of freedom of a squareness (Welch and Satterthwaite): the four slopes contribute equally to every one, apart from
/// the sign.
fn degrees_of_squareness(test: &Test, slopes: &[Term; 4]) -> f64 {
    let variances = slopes.map(|slope| slope.standard_error.powi(2));
    let parts: f64 =
        variances.iter().enumerate().map(|(k, variance)| variance.powi(2) / degrees_of_slope(test, k)).sum();
    let sum: f64 = variances.iter().sum();
    if parts > 0.0 { sum.powi(2) / parts } else { 1.0 }
}

impl DiagonalDocument {
    /// The document of a test; `alignment_urad`: standard uncertainty of the mirror's alignment, if known.
    pub fn new(test: &Test, alignment_urad: Option<f64>) -> DiagonalDocument {
        let volume = test.volume();
        let diagonals: Vec<DiagonalFigures> = figures(test)
            .into_iter()
            .enumerate()
            .map(|(k, of)| DiagonalFigures {
                diagonal: k + 1,
                unit: test.diagonals[k].unit,
                length_mm: test.diagonals[k].length_mm,
                targets: test.on(k).count(),
                e_um: 1e3 * of.systematic,
                b_um: of.reversal.map(|mm| 1e3 * mm),
                m_um: 1e3 * of.mean_range,
                r_um: of.repeatability.map(|mm| 1e3 * mm),
                slope_ppm: micro(volume.slopes[k], degrees_of_slope(test, k)),
            })
            .collect();
        let steps = test.vector(alignment_urad.map(|urad| 1e-6 * urad)).map(|found| Steps {
            scales_if_aligned_ppm: found.scales_if_aligned.map(|scale| 1e6 * scale),
            scales_ppm: found.scales.map(|scales| scales.map(|scale| micro(scale, f64::INFINITY))),
            scale_per_10_urad_ppm: found.scale_per_alignment.map(|share| 10.0 * share),
            shapes: found.shapes.iter().map(shape).collect(),
            sigma_um: 1e3 * found.sigma_mm,
            degrees_of_freedom: found.degrees_of_freedom,
            condition: found.condition,
            lateral_mm: found.lateral_mm,
        });
        let largest = |of: &dyn Fn(&DiagonalFigures) -> Option<f64>| diagonals.iter().filter_map(of).reduce(f64::max);
        let degrees = degrees_of_squareness(test, &volume.slopes);
        let [a0z, b0z, c0y] = volume.squareness.map(|term| micro(term, degrees));
        DiagonalDocument {
            readings: test.readings.len(),
            test: if test.steps { "step-diagonal" } else { "diagonal" },
            e_d_um: largest(&|d| Some(d.e_um)).unwrap_or(0.0),
            b_d_um: largest(&|d| d.b_um),
            m_d_um: largest(&|d| Some(d.m_um)).unwrap_or(0.0),
            r_d_um: largest(&|d| d.r_um),
            a0z,
            b0z,
            c0y,
            scale: micro(volume.scale, degrees),
            rank: volume.rank,
            condition: volume.condition,
            sigma_um: test.sigma_mm.map(|mm| 1e3 * mm),
            limits: limits(test, steps.as_ref()),
            diagonals,
            steps,
        }
    }
}

/// The squareness errors that a test finds, for a machine that was uncorrected during the measurement.
///
/// A slope is not a model of its readings: its standard error includes its residuals, and nothing is compared with a noise.
pub fn additions(test: &Test) -> Additions {
    let volume = test.volume();
    let degrees = degrees_of_squareness(test, &volume.slopes);
    let finding = |(term, name): (Term, &str)| Finding {
        key: format!("location.{name}_urad"),
        found: Known {
            value: 1e6 * term.value,
            uncertainty: Some(1e6 * term.standard_error),
            degrees_of_freedom: Some(degrees),
        },
        ..Finding::default()
    };
    let findings = volume.squareness.into_iter().zip(["A0Z", "B0Z", "C0Y"]).map(finding);
    Additions { findings: findings.collect(), ..Additions::default() }
}

fn shape(of: &trueaxis_metrology::diagonal::Shape) -> Shape {
    let points = of.points.iter().map(|([position_mm, x, y, z], errors)| Point {
        position_mm: *position_mm,
        error_um: [*x, *y, *z].map(|mm| 1e3 * mm),
        standard_error_um: errors.map(|mm| 1e3 * mm),
    });
    Shape { axis: ['X', 'Y', 'Z'][of.axis.min(2)], points: points.collect() }
}

fn limits(test: &Test, steps: Option<&Steps>) -> Vec<String> {
    let mut limits = vec![
        "slopes of straightness, and angular errors with their levers, are inside the squarenesses: along a body diagonal they \
         cannot be separated"
            .to_owned(),
    ];
    match steps {
        None if test.steps => limits.push(
            "the steps are not evaluated: not every interval of every axis was measured on all four diagonals".into(),
        ),
        None => limits.push(
            "four diagonals determine three squarenesses and one scale; separate scales of X, Y, Z need steps".into(),
        ),
        Some(steps) => {
            let worst = steps.scale_per_10_urad_ppm.iter().copied().fold(0.0, f64::max);
            limits.push(format!(
                "a step carries the mirror up to {:.0} mm beside the beam: 10 µrad off square on every diagonal change a scale by \
                 {worst:.1} ppm (Chapman 2003, Svoboda 2006)",
                steps.lateral_mm
            ));
            if steps.scales_ppm.is_none() {
                limits.push(
                    "scales of X, Y, Z are not known without the mirror's alignment (--alignment-urad); squarenesses and shapes \
                     do not need it"
                        .into(),
                );
            }
            limits.push(
                "angular errors enter the shapes through the mirror's travel beside the beam (Soons 2005)".into(),
            );
        }
    }
    limits
}
