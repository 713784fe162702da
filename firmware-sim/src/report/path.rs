//! The programmed path with magnified deviations, uncorrected and corrected.

use super::{PathPoint, Report, Section};
use maud::html;
use trueaxis_report::{Deviated, Figure, View, colour, missing, number::drawable, side_by_side, thin};
use trueaxis_sim::run::Kind;

/// Buckets of the path; each keeps the extremes of four values.
const BUCKETS: usize = 300;
/// Deviation from its main plane above which the path counts as leaving it, in mm.
const FLAT_MM: f64 = 1e-3;
/// Compensated deviations below this share of the others get a separate figure.
const ENLARGE_BELOW: f64 = 0.4;
const AXES: [&str; 3] = ["X", "Y", "Z"];

pub(super) fn section(report: &Report) -> Option<Section> {
    let points: Vec<PathPoint> = report.path.iter().copied().filter(is_drawable).collect();
    let content = if points.len() < 2 {
        missing("No path was recorded.")
    } else {
        let points = thin(&points, BUCKETS, |point| {
            let [x, y, _] = point.nominal_mm;
            [x, y, length(point.uncompensated_um), length(point.compensated_um)]
        });
        let heights = || points.iter().map(|point| point.nominal_mm[2]);
        let extent = heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min);
        let planes: &[[usize; 2]] = if extent > FLAT_MM { &[[0, 1], [0, 2]] } else { &[[0, 1]] };
        html! { (side_by_side(planes.iter().flat_map(|plane| views(&points, *plane)))) }
    };
    Some(Section { heading: "Path with magnified deviations", content })
}

fn is_drawable(point: &PathPoint) -> bool {
    [point.nominal_mm, point.uncompensated_um, point.compensated_um].iter().flatten().all(|&value| drawable(value))
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

/// Before-and-after figure of a projection; a second one magnifies the residual further if it would be invisible.
fn views(points: &[PathPoint], plane: [usize; 2]) -> Vec<Figure> {
    let projected = |value: fn(&PathPoint) -> [f64; 3]| -> Vec<[f64; 2]> {
        points.iter().map(|point| plane.map(|axis| value(point)[axis])).collect()
    };
    let deviated = |name, colour, value| Deviated { name, colour, deviation_um: projected(value) };
    let before = deviated(Kind::Uncompensated.words(), colour::UNCOMPENSATED, |point| point.uncompensated_um);
    let after = deviated(Kind::Compensated.words(), colour::COMPENSATED, |point| point.compensated_um);
    let view = |caption, curves| View {
        caption,
        axes: plane.map(|axis| AXES[axis]),
        path_mm: projected(|point| point.nominal_mm),
        runs: points.iter().map(|point| point.run).collect(),
        curves,
    };
    let enlarged = after.largest_um() > 0.0 && after.largest_um() < ENLARGE_BELOW * before.largest_um();
    let mut figures = vec![view("Uncorrected and corrected", vec![before, after.clone()]).figure()];
    if enlarged {
        figures.push(view("Corrected", vec![after]).figure());
    }
    figures
}
