//! The features as a picture: programmed points with their deviations.

use super::part::FeatureKind;
use super::unknowns::Model;
use super::{PredictDocument, Predicted, Shape};
use glam::DVec3;

/// Most points of a feature in a picture.
const MOST: usize = 73;

/// The shapes from the points of all features, uncorrected, corrected and with everything on.
pub(super) fn drawn(model: &Model<'_>, cut: [&[Vec<DVec3>]; 3], document: &PredictDocument) -> Vec<Shape> {
    let of_feature = |index: usize| {
        let (feature, own) = (&model.part.features[index], &model.cuts[index]);
        let nominal = |k: usize| own.points[k].nominal;
        let shown = decimated(own.points.len());
        let deviations = |points: &[Vec<DVec3>]| {
            shown.iter().map(|k| (1e3 * (points[index][*k] - nominal(*k))).to_array()).collect::<Vec<_>>()
        };
        let tolerances = document.features.iter().zip(&model.part.tolerances);
        let own_tolerances: Vec<&Predicted> =
            tolerances.filter(|(_, of)| of.feature == index).map(|(found, _)| found).collect();
        let verdicts = own_tolerances.iter().filter_map(|of| Some(of.known.as_ref()?.verdict));
        Shape {
            feature: feature.name.clone(),
            kind: feature.kind.name(),
            closed: feature.kind == FeatureKind::Circle
                && is_closed(&own.points.iter().map(|of| of.nominal).collect::<Vec<_>>()),
            points_mm: shown.iter().map(|k| nominal(*k).to_array()).collect(),
            uncorrected_um: deviations(cut[0]),
            corrected_um: deviations(cut[1]),
            everything_um: document.servo.as_ref().map(|_| deviations(cut[2])),
            verdict: verdicts.max_by_key(|verdict| {
                ["conforms", "undecided", "does not conform"].iter().position(|of| of == verdict)
            }),
            used: own_tolerances.iter().map(|of| of.used()).max_by(f64::total_cmp),
        }
    };
    (0..model.part.features.len()).map(of_feature).collect()
}

/// Indices of at most [`MOST`] points, the first and the last among them.
fn decimated(count: usize) -> Vec<usize> {
    let most = count.min(MOST);
    (0..most).map(|k| if most < 2 { 0 } else { k * (count - 1) / (most - 1) }).collect()
}

/// Whether the ends of a circle's points are as close to each other as their neighbours.
fn is_closed(points: &[DVec3]) -> bool {
    match points {
        [first, second, .., last] => (*first - *last).length() < 1.5 * (*second - *first).length(),
        _ => false,
    }
}
