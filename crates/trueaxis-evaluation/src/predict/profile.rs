//! Free forms: their points and normals as programmed, and how far the cut surface is from them.
//!
//! A pass in one plane has its normals in that plane, across the direction of the pass. In space, a surface is cut by passes
//! side by side: its normal is across the pass and across the way to the neighbouring passes. The programmed path may be that
//! of the tool's centre: the normals of an offset curve or surface are those of the workpiece, and deviations along them are
//! equal.
//!
//! Where short moves approximate a curve, their ends are evaluated, with the mean direction of the two moves that meet: the
//! difference between chords and curve is the programming's, and excluded.

use super::circle::{NEAR, apart};
use super::cut::{Cut, Point};
use super::kinds::Side;
use glam::DVec3;

/// Points of a profile: mm between them, least and most of them.
const SPACING: f64 = 1.0;
const POINTS: [f64; 2] = [17.0, 400.0];
/// Cosine of the largest angle at which two moves approximate a smooth curve: 20°.
const SMOOTH: f64 = 0.94;
/// Sine of the angle to the pass below which a move is one into the material or out of it.
const PLUNGE: f64 = 1e-9;
/// Farthest neighbouring pass, as a share of the profile's extent.
const NEIGHBOUR: f64 = 0.25;
/// Directions of the six motions that are less than this share independent of the others are not determined.
const DETERMINED: f64 = 1e-4;
/// Length by which rotations are scaled, mm.
const LENGTH: f64 = 100.0;

/// Least distance of the second pass from a point at the end of a surface, as a multiple of that of the first.
const BEYOND: f64 = 1.2;
/// Distance below which a pass runs along an earlier one of a profile in a plane, mm: above the height of an arc between two
/// points, below any step beside it.
const RETRACED: f64 = 0.05;
/// Cosine of the angle between a normal and the direction towards the material beyond which that is on neither side: 89°.
const ASIDE: f64 = 0.017;

/// What is wrong with the lines of a profile: found and needed.
pub(super) type Wrong = (&'static str, &'static str);

/// Leaves a profile as many points as its evaluation needs, equally spaced, with their normals.
///
/// # Errors
/// A profile that is a straight line, or a pass in space without another beside it; a side that does not say where the
/// material is.
pub(super) fn settle(cut: &mut Cut) -> Result<(), Wrong> {
    let straight = ("a straight line", "a curve; kind = \"line\" is an edge");
    let mut places: Vec<DVec3> = cut.points.iter().map(|point| point.nominal).collect();
    let normal = cut.normal;
    let mut across = plane_of(&places).ok_or(straight)?;
    if across.is_none() {
        // Between passes the tool plunges, unless all of them are strokes along the tool.
        let plunges = |point: &Point| point.tangent.cross(normal).length() < PLUNGE;
        if !cut.points.iter().all(plunges) {
            cut.points.retain(|point| !plunges(point));
            places = cut.points.iter().map(|point| point.nominal).collect();
            across = plane_of(&places).ok_or(straight)?;
        }
    }
    let tangents = smoothed(&cut.points);
    let chosen = spaced(&places, &tangents);
    let extent = places.iter().map(|place| (*place - places[0]).length()).fold(0.0, f64::max);
    let rows = Rows { places: &places, tangents: &tangents, farthest: NEIGHBOUR * extent, is_parallel: true };
    let is_flat = across.is_some();
    let normal = |k: &usize| match across {
        Some(across) => across.cross(tangents[*k]).try_normalize(),
        None => {
            let way = rows.beside(*k).or_else(|| Rows { is_parallel: false, ..rows }.beside(*k));
            way.and_then(|way| tangents[*k].cross(way).try_normalize())
        }
    };
    let single = (
        "one pass that is in no plane",
        "a pass in one plane, or passes side by side, closer than a quarter of their extent",
    );
    let normals = chosen.iter().map(normal).collect::<Option<Vec<DVec3>>>();
    let normals = normals.ok_or(if is_flat { ("moves without a length", "a curve") } else { single })?;
    cut.points = chosen.iter().map(|k| Point { tangent: tangents[*k], ..cut.points[*k].clone() }).collect();
    cut.normals = normals;
    match cut.side {
        Some(side) => larger(cut, side, is_flat),
        None => Ok(()),
    }
}

/// How a larger tool moves the surface at the points. The side of a tool moves it along the normal. A ball, whose length ends
/// at its tip, leaves it there and moves it the more, the steeper it is.
fn larger(cut: &mut Cut, side: Side, is_flat: bool) -> Result<(), Wrong> {
    let is_along = matches!(side, Side::Left | Side::Right);
    let other = ("a pass in the other direction", "one direction, since left and right are seen along the path");
    if is_along && is_flat && is_retraced(&cut.points) {
        return Err(other);
    }
    let mut before: Option<DVec3> = None;
    for (point, normal) in cut.points.iter_mut().zip(&cut.normals) {
        let left = cut.normal.cross(point.tangent).normalize_or_zero();
        let material = match side {
            Side::Right => -left,
            Side::Above => point.pointing,
            Side::Below => -point.pointing,
            Side::Left | Side::Inside | Side::Outside => left,
        };
        let share = normal.dot(material);
        if share.abs() < ASIDE {
            return Err(if is_along {
                ("a normal across both sides of the path", "side = \"below\" or \"above\": on the tool's end")
            } else {
                (
                    "a wall along the tool, which is neither below nor above it",
                    "side = \"left\" or \"right\" of the path",
                )
            });
        }
        let into = *normal * share.signum();
        if is_along && !is_flat && before.is_some_and(|before| before.dot(into) < -SMOOTH) {
            return Err(other);
        }
        before = Some(into);
        point.larger = if is_along { into } else { point.pointing + into };
    }
    Ok(())
}

/// Whether a pass goes back along itself.
fn is_retraced(points: &[Point]) -> bool {
    let is_back = |k: usize, pair: &[Point]| {
        let (from, way) = (pair[0].nominal, pair[1].nominal - pair[0].nominal);
        let away = points[k].nominal - from;
        let share = (away.dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        points[k].tangent.dot(way) < -SMOOTH * way.length() && away.distance(share * way) < RETRACED
    };
    (2..points.len()).any(|k| points[..k].windows(2).any(|pair| is_back(k, pair)))
}

/// The normal of the plane that all points are in; `Some(None)` if they are in none, `None` if they are on a line.
fn plane_of(places: &[DVec3]) -> Option<Option<DVec3>> {
    let [first, other, third] = apart(places)?;
    let along = (other - first).try_normalize()?;
    let aside = (third - first).reject_from_normalized(along);
    let across = along.cross(aside.try_normalize().filter(|_| aside.length() > NEAR)?);
    let is_flat = places.iter().all(|place| (*place - first).dot(across).abs() <= NEAR);
    Some(is_flat.then_some(across))
}

/// Directions of the pass at the points. Where two chords of a curve meet it is that of both; at the end of the last one the
/// curve goes on turning as between it and the chord before.
fn smoothed(points: &[Point]) -> Vec<DVec3> {
    let goes_on = |k: usize| {
        let pair = points.get(k).zip(points.get(k + 1)).filter(|(one, _)| one.joint);
        pair.is_some_and(|(one, next)| one.tangent.dot(next.tangent) > SMOOTH)
    };
    let length = |k: usize| points[k].nominal.distance(points[k - 1].nominal);
    let of = |k: usize| {
        let own = points[k].tangent;
        if goes_on(k) {
            return (own + points[k + 1].tangent).normalize();
        }
        match k.checked_sub(1).filter(|before| *before > 0 && goes_on(*before) && length(k) < 2.0 * length(*before)) {
            Some(before) => {
                let share = length(k) / (length(k) + length(before));
                (own + share * (own - points[before].tangent)).normalize()
            }
            None => own,
        }
    };
    (0..points.len()).map(of).collect()
}

/// Indices of points that are about equally spaced along the pass, and of those at its end and at corners, where deviations
/// are often largest.
fn spaced(places: &[DVec3], tangents: &[DVec3]) -> Vec<usize> {
    let steps: Vec<f64> =
        std::iter::once(0.0).chain(places.windows(2).map(|pair| (pair[1] - pair[0]).length())).collect();
    let length: f64 = steps.iter().sum();
    let spacing = length / (length / SPACING).clamp(POINTS[0], POINTS[1]);
    let (mut at, mut next) = (0.0, 0.0);
    let mut chosen = Vec::new();
    for (k, step) in steps.iter().enumerate() {
        at += step;
        let is_end = tangents.get(k + 1).is_none_or(|next| next.dot(tangents[k]) < SMOOTH);
        if is_end || at >= next * (1.0 - 1e-9) {
            chosen.push(k);
            next = (next + spacing).max(at + 0.5 * spacing);
        }
    }
    chosen
}

/// Passes side by side.
#[derive(Clone, Copy)]
struct Rows<'p> {
    places: &'p [DVec3],
    tangents: &'p [DVec3],
    /// Farthest neighbour, mm.
    farthest: f64,
    /// Whether a neighbour has to be on a pass in about the same direction, not on the way from one to the next.
    is_parallel: bool,
}

impl Rows<'_> {
    /// The way to the neighbouring passes, across the pass: the direction at the point of the parabola through it and a pass
    /// on each side, at the end of the surface the next two. With one neighbour alone, the way to that.
    fn beside(&self, of: usize) -> Option<DVec3> {
        let (next, one) = self.nearest(of, of, None)?;
        let other = self.nearest(of, of, Some(-one)).or_else(|| {
            let beyond = self.nearest(of, next, Some(one)).filter(|_| self.is_parallel)?;
            (beyond.1.length() > BEYOND * one.length()).then_some(beyond)
        });
        Some(other.map_or(one, |(_, other)| {
            let ratio = other.length() / one.length();
            one * ratio - other / ratio
        }))
    }

    /// The point nearest to `from` on a pass beside it, on the side of a direction if there is one, and the way from `of` to
    /// that pass, across the one of `of`.
    fn nearest(&self, of: usize, from: usize, side: Option<DVec3>) -> Option<(usize, DVec3)> {
        let along = self.tangents[of];
        let mut best: Option<(usize, f64)> = None;
        for (k, place) in self.places.iter().enumerate() {
            let away = *place - self.places[from];
            // Within 45° of the direction across: the points of the own pass are along it.
            let across = away.reject_from_normalized(along);
            let (square, way) = (away.length_squared(), across.length_squared());
            let is_near = best.is_none_or(|(_, best)| square < best) && way > 0.5 * square && way > NEAR * NEAR;
            let is_side = side.is_none_or(|side| across.dot(side) > 0.7 * across.length() * side.length());
            if is_near && is_side && (!self.is_parallel || self.tangents[k].dot(along).abs() > 0.7) {
                best = Some((k, square));
            }
        }
        let (k, _) = best.filter(|(_, square)| *square <= self.farthest * self.farthest)?;
        let (away, tangent) = (self.places[k] - self.places[of], self.tangents[k]);
        // Opposite the point, where the pass is straight between its points.
        let opposite = if self.is_parallel { tangent * (away.dot(along) / tangent.dot(along)) } else { DVec3::ZERO };
        Some((k, (away - opposite).reject_from_normalized(along)))
    }
}

/// A profile as programmed.
#[derive(Clone, Debug, Default)]
pub(super) struct Outline {
    /// Points and their normals.
    pub(super) at: Vec<DVec3>,
    pub(super) normals: Vec<DVec3>,
    /// Deviations by the motions of the part that the profile determines, orthonormal.
    motions: Vec<Vec<f64>>,
}

impl Outline {
    pub(super) fn of(cut: &Cut) -> Outline {
        let at: Vec<DVec3> = cut.points.iter().map(|point| point.nominal).collect();
        let middle = at.iter().sum::<DVec3>() / at.len().max(1) as f64;
        let (mut motions, mut squares) = (Vec::<Vec<f64>>::new(), 0.0_f64);
        for k in 0..6 {
            let by = |(at, normal): (&DVec3, &DVec3)| {
                if k < 3 { normal[k] } else { (*at - middle).cross(*normal)[k - 3] / LENGTH }
            };
            let mut motion: Vec<f64> = at.iter().zip(&cut.normals).map(by).collect();
            let whole = dot(&motion, &motion).sqrt();
            squares = squares.max(whole);
            // Twice: the first time leaves rounding along the others.
            for _ in 0..2 {
                for other in &motions {
                    let share = dot(&motion, other);
                    motion.iter_mut().zip(other).for_each(|(value, other)| *value -= share * other);
                }
            }
            let left = dot(&motion, &motion).sqrt();
            if left > DETERMINED * squares {
                motion.iter_mut().for_each(|value| *value /= left);
                motions.push(motion);
            }
        }
        Outline { at, normals: cut.normals.clone(), motions }
    }

    /// Twice the largest deviation of the points along the normals, mm; `aligned`: a point of the part, cut and programmed,
    /// brought to the datums.
    pub(super) fn width(&self, points: &[DVec3], aligned: impl Fn(DVec3, DVec3) -> DVec3) -> f64 {
        zone(self.deviations(points, aligned))
    }

    /// [`width`](Outline::width) after the motion of the part that makes the sum of the squared deviations smallest.
    pub(super) fn best_width(&self, points: &[DVec3]) -> f64 {
        let mut off: Vec<f64> = self.deviations(points, |is, _| is).collect();
        for motion in &self.motions {
            let share = dot(&off, motion);
            off.iter_mut().zip(motion).for_each(|(value, motion)| *value -= share * motion);
        }
        zone(off.into_iter())
    }

    fn deviations(&self, points: &[DVec3], aligned: impl Fn(DVec3, DVec3) -> DVec3) -> impl Iterator<Item = f64> {
        let places = self.at.iter().zip(&self.normals);
        places.zip(points).map(move |((at, normal), is)| (aligned(*is, *at) - *at).dot(*normal))
    }
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

fn zone(deviations: impl Iterator<Item = f64>) -> f64 {
    2.0 * deviations.fold(0.0, |most: f64, off| most.max(off.abs()))
}
