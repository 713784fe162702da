//! Widths of minimum zones: the narrowest zone of the feature's form that contains all its points.

use super::fit::Nominal;
use super::kinds::FeatureKind;
use anyhow::{Result, anyhow};
use glam::DVec3;
use trueaxis_metrology::{circles, planes};

/// Roundness, straightness or flatness, mm.
pub(super) fn minimum_zone(nominal: &Nominal, points: &[DVec3]) -> Result<f64> {
    let local = nominal.local(points);
    let flat = || local.iter().map(|point| [point.x, point.y]).collect::<Vec<_>>();
    match nominal.kind {
        FeatureKind::Circle => Ok(circles::minimum_zone(&flat()).map_err(|error| anyhow!("{error}"))?.zone),
        FeatureKind::Line => Ok(circles::smallest_width(&flat())),
        FeatureKind::Plane => {
            let points: Vec<[f64; 3]> = local.iter().map(DVec3::to_array).collect();
            Ok(planes::minimum_zone(&points).map_err(|error| anyhow!("{error}"))?.width)
        }
        FeatureKind::Hole | FeatureKind::Flank | FeatureKind::Profile => {
            Err(anyhow!("found a {}, needed a form", nominal.kind.name()))
        }
    }
}
