//! Least-squares features through the points that are cut (ISO 14405-1, ISO 12180 to 12781: association by least squares).

use super::chords::{FEWEST, MOST_TURN};
use super::circle::{Circle, NEAR, circle_through};
use super::cut::Cut;
use super::gear::Traces;
use super::kinds::FeatureKind;
use super::profile::Outline;
use anyhow::{Result, anyhow};
use glam::{DMat3, DVec3};
use trueaxis_metrology::circles::least_squares;

/// Smallest part of a circle, degrees: the points on a quarter of it span less.
const LEAST_ARC: f64 = 75.0;

/// Directions and place of a feature as programmed.
#[derive(Clone, Debug)]
pub(super) struct Nominal {
    pub(super) kind: FeatureKind,
    /// Centre of a circle or hole, middle of the points of a line or plane.
    pub(super) centre: DVec3,
    /// Of a circle, hole or line: of the plane it is in; of a plane: its own.
    pub(super) normal: DVec3,
    /// Direction of a line; else any direction in the plane.
    pub(super) along: DVec3,
    /// Radius of a circle; of a line or plane half of its extent, mm.
    pub(super) size: f64,
    /// What is evaluated on a gear's flank.
    pub(super) flank: Option<Traces>,
    /// Points and normals of a profile.
    pub(super) outline: Outline,
}

impl Nominal {
    /// The third direction: across a line in its plane, from which the edge is measured.
    pub(super) fn across(&self) -> DVec3 {
        self.normal.cross(self.along)
    }

    /// Direction in which a line or plane is measured.
    pub(super) fn facing(&self) -> DVec3 {
        if self.kind == FeatureKind::Plane { self.normal } else { self.across() }
    }

    /// The place of a feature.
    ///
    /// # Errors
    /// Points of a hole, line or plane that are not on one.
    pub(super) fn of(cut: &Cut) -> Result<Nominal, &'static str> {
        let points: Vec<DVec3> = cut.points.iter().map(|point| point.nominal).collect();
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let farthest =
            |from: DVec3| points.iter().copied().max_by(|a, b| (*a - from).length().total_cmp(&(*b - from).length()));
        let end = farthest(middle).unwrap_or(middle);
        let other = farthest(end).unwrap_or(middle);
        let along = (end - other).normalize_or(cut.normal.any_orthonormal_vector());
        let size = 0.5 * (end - other).length();
        let from_line = |point: &DVec3| (*point - middle).reject_from_normalized(along);
        let widest =
            points.iter().map(from_line).max_by(|a, b| a.length().total_cmp(&b.length())).unwrap_or(DVec3::ZERO);
        let outline = if cut.kind == FeatureKind::Profile { Outline::of(cut) } else { Outline::default() };
        let (kind, centre, normal) = (cut.kind, middle, cut.normal);
        let mut nominal = Nominal { kind, centre, normal, along, size, flank: None, outline };
        match cut.kind {
            FeatureKind::Circle => {
                let refused = "arcs of one circle, or chords with their ends on one";
                let (Circle { centre, radius }, normal) = match cut.circle {
                    Some(circle) => (circle, cut.normal),
                    None => circle_through(&points).ok_or(refused)?,
                };
                let normal = if normal.dot(cut.normal) < 0.0 { -normal } else { normal };
                let off = |point: &DVec3| {
                    let from = *point - centre;
                    from.dot(normal).abs().max((from.reject_from_normalized(normal).length() - radius).abs())
                };
                let [arc, chord] = angles(&points, centre, normal);
                if arc < LEAST_ARC || cut.circle.is_none() && chord > MOST_TURN.to_degrees() {
                    return Err("a quarter of a circle or more, of arcs, or of chords of 30 degrees at most");
                }
                if points.len() < FEWEST || points.iter().map(off).fold(0.0, f64::max) > 2.0 * NEAR {
                    return Err(refused);
                }
                nominal = Nominal { centre, size: radius, normal, along: normal.any_orthonormal_vector(), ..nominal };
            }
            FeatureKind::Hole => {
                if points.iter().any(|point| (*point - middle).reject_from_normalized(cut.normal).length() > NEAR) {
                    return Err("one hole");
                }
                nominal.along = cut.normal.any_orthonormal_vector();
            }
            FeatureKind::Flank => {
                let gear = cut.gear.as_ref().ok_or("a gear")?;
                nominal.flank = Some(Traces::of(gear, points, (cut.to_part, cut.zero))?);
            }
            FeatureKind::Line => {
                if widest.length() > NEAR || size <= NEAR {
                    return Err("one straight line");
                }
                if along.dot(cut.normal).abs() > 1e-6 {
                    return Err("a line in the plane of G17, G18 or G19");
                }
            }
            FeatureKind::Plane => {
                if widest.length() <= 1.0 {
                    return Err("lines that span a plane, at least 1 mm apart");
                }
                let normal = along.cross(widest).normalize();
                let normal = if normal.dot(DVec3::ONE) < 0.0 { -normal } else { normal };
                if points.iter().any(|point| (*point - middle).dot(normal).abs() > NEAR) {
                    return Err("lines in one plane");
                }
                nominal.normal = normal;
            }
            FeatureKind::Profile => {}
        }
        Ok(nominal)
    }

    /// Points along its directions, from its centre.
    pub(super) fn local(&self, points: &[DVec3]) -> Vec<DVec3> {
        let of = |point: &DVec3| {
            let from = *point - self.centre;
            DVec3::new(from.dot(self.along), from.dot(self.across()), from.dot(self.normal))
        };
        points.iter().map(of).collect()
    }

    /// Fits the feature to its points; a profile has no other than its points.
    pub(super) fn fit(&self, points: &[DVec3]) -> Result<Fitted> {
        let local = self.local(points);
        let mean = local.iter().sum::<DVec3>() / local.len().max(1) as f64;
        let to_part = |local: DVec3| local.x * self.along + local.y * self.across() + local.z * self.normal;
        let mut fitted =
            Fitted { centre: self.centre + to_part(mean), facing: self.facing(), diameter: 0.0, form: 0.0 };
        match self.kind {
            FeatureKind::Hole | FeatureKind::Flank | FeatureKind::Profile => {}
            FeatureKind::Circle => {
                let flat: Vec<[f64; 2]> = local.iter().map(|point| [point.x, point.y]).collect();
                let circle = least_squares(&flat).map_err(|error| anyhow!("{error}"))?;
                let [x, y] = circle.centre;
                fitted.centre = self.centre + to_part(DVec3::new(x, y, mean.z));
                (fitted.diameter, fitted.form) = (2.0 * circle.radius, circle.zone);
            }
            FeatureKind::Line => {
                let (mut squares, mut product) = (0.0, 0.0);
                for point in &local {
                    squares += (point.x - mean.x).powi(2);
                    product += (point.x - mean.x) * (point.y - mean.y);
                }
                let slope = product / squares;
                fitted.facing = (self.across() - slope * self.along).normalize();
                fitted.form = range(local.iter().map(|point| point.y - slope * point.x));
            }
            FeatureKind::Plane => {
                let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
                for point in &local {
                    let row = DVec3::new(point.x - mean.x, point.y - mean.y, 1.0);
                    matrix += DMat3::from_cols(row * row.x, row * row.y, row);
                    right += row * (point.z - mean.z);
                }
                let slopes = matrix.inverse() * right;
                fitted.facing = (self.normal - slopes.x * self.along - slopes.y * self.across()).normalize();
                fitted.form = range(local.iter().map(|point| point.z - slopes.x * point.x - slopes.y * point.y));
            }
        }
        Ok(fitted)
    }
}

/// Angle of a circle that points are on, and the largest between one and the next, degrees.
fn angles(points: &[DVec3], centre: DVec3, normal: DVec3) -> [f64; 2] {
    let along = normal.any_orthonormal_vector();
    let across = normal.cross(along);
    let angle = |point: &DVec3| {
        let from = *point - centre;
        from.dot(across).atan2(from.dot(along)).to_degrees()
    };
    let mut sorted: Vec<f64> = points.iter().map(angle).collect();
    let turned = |pair: &[f64]| (pair[1] - pair[0] + 540.0).rem_euclid(360.0) - 180.0;
    let chord = sorted.windows(2).map(|pair| turned(pair).abs()).fold(0.0, f64::max);
    sorted.sort_unstable_by(f64::total_cmp);
    let around = sorted.first().zip(sorted.last()).map_or(360.0, |(first, last)| first + 360.0 - last);
    let gap = sorted.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max);
    [360.0 - gap, chord]
}

/// A feature fitted by least squares.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fitted {
    /// Centre of a circle or hole, a point of a line or plane.
    pub(super) centre: DVec3,
    /// Direction in which a line or plane is measured: its normal.
    pub(super) facing: DVec3,
    /// Diameter of a circle, mm.
    pub(super) diameter: f64,
    /// Width of the zone about it, mm: roundness, straightness, flatness.
    pub(super) form: f64,
}

/// Largest minus smallest value; 0 without values.
pub(super) fn range(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
    (high - low).max(0.0)
}
