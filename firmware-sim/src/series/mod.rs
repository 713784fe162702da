//! Curves for the report's figures, collected from the runs in memory of fixed size.

mod circle;
mod reversals;

use crate::report::{AxisReport, CircleReport, ContourSeries, OrientationSeries, PathPoint, ReversalReport};
use circle::CircleSeries;
use reversals::Reversals;
use trueaxis::machine::AxisSettings;
use trueaxis_report::Thinner;
use trueaxis_sim::Scenario;
use trueaxis_sim::run::{CorrectionLimits, Kind, Moment, Sample, Sink};

/// Buckets of a curve over the path or over time, and of the path itself: one to two times the resolution of its figure.
const CURVE: usize = 1400;
const PATH: usize = 600;

/// A point of a curve over the path length.
#[derive(Clone, Copy, Debug)]
struct OnPath {
    at: [f64; 2],
    /// Path length at which this point's cut began.
    began: f64,
}

type Curve = Thinner<OnPath, 1>;

/// Correction of an axis over time.
#[derive(Debug)]
struct AxisCurves {
    settings: AxisSettings,
    correction: Thinner<[f64; 2], 1>,
    slope: Thinner<[f64; 2], 1>,
    last: Option<f64>,
}

/// Collects the curves of the runs of [`Kind::of`], in that order.
#[derive(Debug)]
pub struct Series {
    period_s: f64,
    five_axis: bool,
    contour: Vec<Curve>,
    orientation: Vec<Curve>,
    /// Rotary axes: index among A, B, C, letter, position.
    rotary: Vec<(usize, char, Curve)>,
    axes: Vec<AxisCurves>,
    path: Thinner<PathPoint, 4>,
    /// Present for a program with a full circle.
    circle: Option<CircleSeries>,
    /// Present for a machine with dynamic parts.
    reversals: Option<Reversals>,
    /// Number of the cut, path length at which it began, and whether the previous cycle was cutting.
    cut: u32,
    began: f64,
    was_cutting: bool,
}

impl Series {
    /// The curves of a scenario, without points.
    pub fn new(scenario: &Scenario) -> Series {
        let settings = &scenario.machine.settings.axes;
        let rotary = settings.iter().filter(|a| a.axis.is_rotary());
        let mut axes: Vec<AxisCurves> = settings
            .iter()
            .map(|a| AxisCurves {
                settings: *a,
                correction: Thinner::new(CURVE),
                slope: Thinner::new(CURVE),
                last: None,
            })
            .collect();
        axes.sort_by_key(|a| a.settings.axis.index());
        let kinds = Kind::of(&scenario.machine.settings);
        let curves = || kinds.iter().map(|_| Thinner::new(CURVE)).collect();
        Series {
            period_s: scenario.period_s(),
            five_axis: scenario.five_axis,
            contour: curves(),
            orientation: curves(),
            rotary: rotary.map(|a| (a.axis.index() - 3, a.axis.letter(), Thinner::new(CURVE))).collect(),
            axes,
            path: Thinner::new(PATH),
            circle: CircleSeries::of(scenario, kinds.len()),
            reversals: (kinds.len() == Kind::ALL.len()).then(|| Reversals::new(scenario)),
            cut: 0,
            began: f64::NEG_INFINITY,
            was_cutting: true,
        }
    }

    fn cutting(&mut self, moment: &Moment, runs: &[Option<&Sample>]) {
        let at = |value: f64| OnPath { at: [moment.length_mm, value], began: self.began };
        for (run, (contour, orientation)) in runs.iter().zip(self.contour.iter_mut().zip(&mut self.orientation)) {
            let Some(sample) = run else { continue };
            let error = f64::from(sample.error_um());
            contour.add(at(error), [error]);
            if self.five_axis {
                let angle = f64::from(sample.orientation_urad);
                orientation.add(at(angle), [angle]);
            }
        }
        if self.five_axis {
            for (place, _, curve) in &mut self.rotary {
                let position = moment.rotary_deg.get(*place).copied().unwrap_or_default();
                curve.add(at(position), [position]);
            }
        }
        if let [Some(before), Some(after), ..] = runs {
            let point = PathPoint {
                run: self.cut,
                nominal_mm: moment.nominal_mm,
                uncompensated_um: before.deviation_um.map(f64::from),
                compensated_um: after.deviation_um.map(f64::from),
            };
            let [x, y, _] = moment.nominal_mm;
            self.path.add(point, [x, y, before.error_um().into(), after.error_um().into()]);
        }
    }

    /// Contour error over the path; the caller fills in `program_lines`.
    pub fn contour(&self) -> ContourSeries {
        let [uncompensated, compensated, servo_only, full] = four(&self.contour);
        let mut breaks: Vec<f64> =
            self.contour.iter().flat_map(Thinner::items).map(|p| p.began).filter(|b| b.is_finite()).collect();
        breaks.sort_unstable_by(f64::total_cmp);
        breaks.dedup();
        ContourSeries { uncompensated, compensated, servo_only, full, breaks, program_lines: Vec::new() }
    }

    /// Tool direction over the path; empty for a program of X, Y, Z alone.
    pub fn orientation(&self) -> OrientationSeries {
        if !self.five_axis {
            return OrientationSeries::default();
        }
        let [uncompensated, compensated, servo_only, full] = four(&self.orientation);
        let rotary = self.rotary.iter().map(|(_, letter, curve)| (letter.to_string(), points(curve))).collect();
        OrientationSeries { uncompensated, compensated, servo_only, full, rotary }
    }

    /// The programmed path and the tip's deviations, uncorrected and corrected.
    pub fn path(&self) -> Vec<PathPoint> {
        self.path.items()
    }

    /// The first full circle of the program.
    pub fn circle(&self) -> Option<CircleReport> {
        self.circle.as_ref().and_then(CircleSeries::report)
    }

    /// The worst reversal of every axis, with its dynamic correction.
    pub fn reversals(&self) -> Vec<ReversalReport> {
        self.reversals.as_ref().map(Reversals::report).unwrap_or_default()
    }

    /// Correction of every axis in the corrected run, with its limits.
    pub fn axes(&self) -> Vec<AxisReport> {
        let report = |axis: &AxisCurves| {
            let limits = CorrectionLimits::of(&axis.settings);
            let letter = axis.settings.axis;
            AxisReport {
                name: letter.letter().into(),
                rotary: letter.is_rotary(),
                correction: axis.correction.items(),
                slope: axis.slope.items(),
                magnitude_limit: limits.magnitude,
                slope_limit: limits.slope,
                acceleration_limit: limits.acceleration,
            }
        };
        self.axes.iter().map(report).collect()
    }
}

/// The points of each run's curve; empty for a missing run.
fn four(curves: &[Curve]) -> [Vec<[f64; 2]>; 4] {
    std::array::from_fn(|run| curves.get(run).map(points).unwrap_or_default())
}

fn points(curve: &Curve) -> Vec<[f64; 2]> {
    curve.items().into_iter().map(|point| point.at).collect()
}

impl Sink for Series {
    fn cycle(&mut self, moment: &Moment, runs: &[Option<&Sample>]) {
        if moment.cutting && !self.was_cutting {
            self.cut += 1;
            self.began = moment.length_mm;
        }
        self.was_cutting = moment.cutting;
        if moment.cutting {
            self.cutting(moment, runs);
            if let Some(circle) = &mut self.circle {
                circle.add(moment, runs);
            }
        }
        if let Some(reversals) = &mut self.reversals {
            reversals.add(moment, runs);
        }
        let [_, Some(compensated), ..] = runs else { return };
        for axis in &mut self.axes {
            let correction = compensated.correction.get(axis.settings.axis.index()).copied().map_or(0.0, f64::from);
            axis.correction.add([moment.time_s, correction], [correction]);
            if let Some(last) = axis.last {
                let slope = 1e-3 * (correction - last) / self.period_s;
                axis.slope.add([moment.time_s, slope], [slope]);
            }
            axis.last = Some(correction);
        }
    }
}
