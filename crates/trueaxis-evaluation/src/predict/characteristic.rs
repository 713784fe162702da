//! Values of the toleranced characteristics, mm.
//!
//! Orientations and positions are those of the part aligned to its datums: the small motion (t, ω) that brings the fitted
//! datums to their programmed places, the first datum first (ISO 5459). A direction that the datums leave free stays that of
//! the program.

use super::fit::{Fitted, Nominal, range};
use super::part::{Association, Characteristic, FeatureKind, Part, Tolerance};
use super::zone::minimum_zone;
use anyhow::Result;
use glam::DVec3;
use trueaxis_metrology::linear_fit::LinearFit;
use trueaxis_tables::error::FileError;

/// Weights of the first, the second and the third datum: what the first determines, the others change by 1e-4 at most.
const WEIGHTS: [f64; 3] = [1.0, 1e-2, 1e-4];
/// Weights that hold free translations and rotations at zero.
const FREE: [f64; 2] = [1e-7, 1e-6];
/// Length by which rotations are scaled, mm.
const LENGTH: f64 = 100.0;
/// Largest deviation of programmed directions from parallel or perpendicular, rad.
const SQUARE: f64 = 1e-6;

/// Refuses orientations that the programmed features do not have, and datums that another kind of feature would need.
pub(super) fn check(part: &Part, nominal: &[Nominal]) -> Result<(), FileError> {
    for tolerance in &part.tolerances {
        let (own, name) = (&nominal[tolerance.feature], &part.features[tolerance.feature].name);
        let Some(datum) = tolerance.datums.first().copied() else { continue };
        let (other, datum) = (&nominal[datum], &part.features[datum].name);
        let refuse = |found: String, needed: &str| Err(part.wrong(tolerance.line, found, needed));
        let cosine = own.facing().dot(other.facing()).abs();
        let parallel = (1.0 - cosine).max(0.0).sqrt() < SQUARE;
        let is_edge = |of: &Nominal| matches!(of.kind, FeatureKind::Line | FeatureKind::Plane);
        match tolerance.characteristic {
            Characteristic::Parallelism | Characteristic::Perpendicularity | Characteristic::Angularity => {
                let same = own.kind == other.kind
                    && (own.kind == FeatureKind::Plane || own.normal.cross(other.normal).length() < SQUARE);
                if !same {
                    let found = format!("{name} with the datum {datum}");
                    return refuse(found, "two planes, or two lines cut in the same of G17, G18 and G19");
                }
                let (is_so, needed) = match tolerance.characteristic {
                    Characteristic::Parallelism => (parallel, "0 degrees as programmed"),
                    Characteristic::Perpendicularity => (cosine < SQUARE, "90 degrees as programmed"),
                    _ => (!parallel, "another angle as programmed, or parallelism"),
                };
                if !is_so {
                    let degrees = cosine.clamp(0.0, 1.0).acos().to_degrees();
                    return refuse(format!("{degrees:.4} degrees between {name} and {datum}"), needed);
                }
            }
            Characteristic::Distance if is_edge(own) && is_edge(other) && !parallel => {
                return refuse(format!("{name} and {datum}, not parallel"), "parallel lines or planes");
            }
            Characteristic::Distance if apart(own, other) < 1e-3 => {
                return refuse(format!("{name} and {datum} in the same place"), "features apart from each other");
            }
            _ => {}
        }
    }
    Ok(())
}

/// Programmed distance, as it is measured.
fn apart(own: &Nominal, other: &Nominal) -> f64 {
    let between = own.centre - other.centre;
    let edge = [other, own].into_iter().find(|of| matches!(of.kind, FeatureKind::Line | FeatureKind::Plane));
    match edge {
        Some(edge) => between.dot(edge.facing()).abs(),
        None => between.reject_from_normalized(own.normal).length(),
    }
}

/// The value of a characteristic, mm.
pub(super) fn value(
    tolerance: &Tolerance,
    nominal: &[Nominal],
    fitted: &[Fitted],
    points: &[Vec<DVec3>],
) -> Result<f64> {
    let own = tolerance.feature;
    let (is, was) = (&fitted[own], &nominal[own]);
    let datum = tolerance.datums.first().copied().unwrap_or(own);
    Ok(match tolerance.characteristic {
        Characteristic::Size => is.diameter - 2.0 * was.size,
        Characteristic::Roundness | Characteristic::Straightness | Characteristic::Flatness => {
            match tolerance.association {
                Association::LeastSquares => is.form,
                Association::MinimumZone => minimum_zone(was, &points[own])?,
            }
        }
        Characteristic::Profile if tolerance.datums.is_empty() => was.outline.best_width(&points[own]),
        Characteristic::Profile => {
            let motion = Alignment::to(&tolerance.datums, nominal, fitted);
            was.outline.width(&points[own], |is, was| motion.of(is, was))
        }
        Characteristic::Distance => distance(nominal, fitted, [datum, own]),
        Characteristic::Flank(of) => was.flank.as_ref().map_or(f64::NAN, |traces| traces.value(of, &points[own])),
        Characteristic::Position => {
            let aligned = Alignment::to(&tolerance.datums, nominal, fitted).of(is.centre, was.centre);
            2.0 * (aligned - was.centre).reject_from_normalized(was.normal).length()
        }
        Characteristic::Parallelism | Characteristic::Perpendicularity | Characteristic::Angularity => {
            let (datum, cosine) = (fitted[datum].facing, was.facing().dot(nominal[datum].facing()));
            // At the programmed angle to the datum, else as close to the feature's own normal as that allows.
            let across = is.facing.reject_from_normalized(datum).normalize_or_zero();
            let direction = match tolerance.characteristic {
                Characteristic::Parallelism => datum,
                Characteristic::Perpendicularity => across,
                _ => cosine * datum + (1.0 - cosine * cosine).max(0.0).sqrt() * across,
            };
            range(points[own].iter().map(|point| point.dot(direction)))
        }
    })
}

/// Deviation of the distance: along the normal of the first line or plane, or between two centres.
fn distance(nominal: &[Nominal], fitted: &[Fitted], [from, to]: [usize; 2]) -> f64 {
    let edge = [from, to].into_iter().find(|one| matches!(nominal[*one].kind, FeatureKind::Line | FeatureKind::Plane));
    let (was, is) = (nominal[to].centre - nominal[from].centre, fitted[to].centre - fitted[from].centre);
    match edge {
        Some(edge) => {
            let (was, is) = (was.dot(nominal[edge].facing()), is.dot(fitted[edge].facing));
            if was < 0.0 { was - is } else { is - was }
        }
        // Holes and circles are apart in their plane, whatever their depth.
        None => {
            let normal = nominal[from].normal;
            is.reject_from_normalized(normal).length() - was.reject_from_normalized(normal).length()
        }
    }
}

/// Motion of the part that aligns it to its datums.
struct Alignment {
    shift: DVec3,
    turn: DVec3,
    about: DVec3,
}

impl Alignment {
    fn to(datums: &[usize], nominal: &[Nominal], fitted: &[Fitted]) -> Alignment {
        let Some(first) = datums.first() else {
            return Alignment { shift: DVec3::ZERO, turn: DVec3::ZERO, about: DVec3::ZERO };
        };
        let about = nominal[*first].centre;
        let mut fit = LinearFit::new(6);
        for (datum, weight) in datums.iter().zip(WEIGHTS) {
            let (was, is) = (&nominal[*datum], &fitted[*datum]);
            let mut row = |shift: DVec3, turn: DVec3, value: f64| {
                let [x, y, z] = (turn / LENGTH).to_array();
                fit.add(&[shift.x, shift.y, shift.z, x, y, z], value, weight);
            };
            let lever = was.centre - about;
            let mut place = |along: DVec3| row(along, lever.cross(along), (was.centre - is.centre).dot(along));
            match was.kind {
                FeatureKind::Circle | FeatureKind::Hole | FeatureKind::Flank => {
                    [was.along, was.across()].into_iter().for_each(&mut place)
                }
                FeatureKind::Line | FeatureKind::Plane => {
                    let facing = was.facing();
                    place(facing);
                    let [first, second] = [was.along, facing.cross(was.along)];
                    let tilts = if was.kind == FeatureKind::Plane { vec![first, second] } else { vec![first] };
                    for along in tilts {
                        // The facing turns by ω × facing; its part along this direction is to vanish.
                        row(DVec3::ZERO, LENGTH * facing.cross(along), -LENGTH * is.facing.dot(along));
                    }
                }
                // No datum.
                FeatureKind::Profile => {}
            }
        }
        for k in 0..6 {
            let mut row = [0.0; 6];
            row[k] = 1.0;
            fit.add(&row, 0.0, FREE[k / 3]);
        }
        let found = fit.solve().values;
        let part = |from: usize| DVec3::new(found[from], found[from + 1], found[from + 2]);
        Alignment { shift: part(0), turn: part(3) / LENGTH, about }
    }

    /// A point of the part after the motion; its lever is that of the programmed point.
    fn of(&self, is: DVec3, was: DVec3) -> DVec3 {
        is + self.shift + self.turn.cross(was - self.about)
    }
}
