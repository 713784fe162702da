//! The data of the simulator's report.

use crate::latency::{LatencyBucket, LatencySummary};
use trueaxis_evaluation::shown::Shown;

pub use trueaxis_sim::run::{AngleSize, ErrorSize};

/// All data shown on the page.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// Summary, tables, faults and notes.
    pub shown: Shown,
    /// Contour error over the path.
    pub contour: ContourSeries,
    /// Tool direction over the path; empty for a program of X, Y, Z alone.
    pub orientation: OrientationSeries,
    /// The programmed path and the tip's deviations from it, in path order.
    pub path: Vec<PathPoint>,
    /// The first full circle of the program.
    pub circle: Option<CircleReport>,
    /// The worst reversal of each axis with the dynamic correction; empty for a machine without dynamic parts.
    pub reversals: Vec<ReversalReport>,
    /// Correction and limits of each axis.
    pub axes: Vec<AxisReport>,
    /// Percentiles and deadlines of the step.
    pub latency: LatencySummary,
    /// The latency histogram.
    pub latency_buckets: Vec<LatencyBucket>,
}

/// Contour error over the path: `[path length in mm, error in µm]`, without sign.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContourSeries {
    /// The machine uncorrected.
    pub uncompensated: Vec<[f64; 2]>,
    /// The machine corrected.
    pub compensated: Vec<[f64; 2]>,
    /// The servo alone: a machine without geometric errors.
    pub servo_only: Vec<[f64; 2]>,
    /// Everything on; empty for a machine without dynamic parts.
    pub full: Vec<[f64; 2]>,
    /// Path lengths at which the curves are interrupted, ascending, mm: the motion in between was not cutting.
    pub breaks: Vec<f64>,
    /// Start of each program line: path length in mm and line number.
    pub program_lines: Vec<(f64, u32)>,
}

/// Tool direction over the path; the first coordinate is the path length in mm.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OrientationSeries {
    /// Angle between the actual and the programmed direction, the machine uncorrected, µrad.
    pub uncompensated: Vec<[f64; 2]>,
    /// The machine corrected.
    pub compensated: Vec<[f64; 2]>,
    /// The servo alone: a machine without geometric errors.
    pub servo_only: Vec<[f64; 2]>,
    /// Everything on; empty for a machine without dynamic parts.
    pub full: Vec<[f64; 2]>,
    /// Rotary axes by name: commanded position in degrees.
    pub rotary: Vec<(String, Vec<[f64; 2]>)>,
}

/// Deviation of the true tip's radius along a full circle: `[angle in rad, µm]`, in the order of travel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CircleReport {
    /// Radius in mm.
    pub radius_mm: f64,
    /// Indices of the axes of the plane; angles count from the first to the second.
    pub plane: [usize; 2],
    /// Program line.
    pub line: u32,
    /// The machine uncorrected.
    pub uncompensated: Vec<[f64; 2]>,
    /// The machine corrected.
    pub compensated: Vec<[f64; 2]>,
    /// The servo alone: a machine without geometric errors.
    pub servo_only: Vec<[f64; 2]>,
    /// Everything on; empty for a machine without dynamic parts.
    pub full: Vec<[f64; 2]>,
}

/// One reversal of an axis: parts of the dynamic correction and contour errors, `[ms after the reversal, µm]`; the parts of a
/// rotary axis are in µrad.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReversalReport {
    /// Name of the axis, e.g. `X`.
    pub axis: String,
    /// Whether the axis is rotary.
    pub rotary: bool,
    /// Program line.
    pub line: u32,
    /// Time at which the command reversed, s.
    pub time_s: f64,
    /// Dynamic correction sent.
    pub sent: Vec<[f64; 2]>,
    /// Correction requested against friction, following error and the error of acceleration.
    pub feed_forward: Vec<[f64; 2]>,
    /// Correction requested by the contour feedback.
    pub feedback: Vec<[f64; 2]>,
    /// Correction requested against acceleration cross-talk.
    pub crosstalk: Vec<[f64; 2]>,
    /// Contour error with only the geometry corrected.
    pub compensated_um: Vec<[f64; 2]>,
    /// Contour error with the servo corrected too.
    pub full_um: Vec<[f64; 2]>,
}

/// A point of the programmed path and the true tip's deviation from it, actual − foot point.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PathPoint {
    /// Number of the uninterrupted cut that the point belongs to.
    pub run: u32,
    /// Programmed position in mm.
    pub nominal_mm: [f64; 3],
    /// Deviation of the uncorrected machine in µm.
    pub uncompensated_um: [f64; 3],
    /// Deviation of the corrected machine in µm.
    pub compensated_um: [f64; 3],
}

/// Correction of one axis over the corrected run, with its limits.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AxisReport {
    /// Name of the axis, e.g. `X`.
    pub name: String,
    /// Whether the axis is rotary: the units are then µrad for µm, mrad/s for mm/s, rad/s² for m/s².
    pub rotary: bool,
    /// Correction over time: `[s, µm]`.
    pub correction: Vec<[f64; 2]>,
    /// Slope of the correction over time: `[s, mm/s]`.
    pub slope: Vec<[f64; 2]>,
    /// Limit of the correction's magnitude in µm.
    pub magnitude_limit: f64,
    /// Limit of the correction's slope in mm/s.
    pub slope_limit: f64,
    /// Limit of the correction's acceleration in m/s².
    pub acceleration_limit: f64,
}
