//! What a probing move touches: solids in machine coordinates, and where a ball that moves along a line trips.
//!
//! ```text
//! tip(s) = start + s · way        s = 0 to 1
//! g(s)   = distance of the ball from a solid, negative where they overlap
//! ```
//!
//! G38.2 and G38.3 end at the first s with g = 0, G38.4 and G38.5 where g is positive for every solid. Planes, boxes and balls
//! are convex, so g is convex in s: Newton's method from outside never passes the root. Over a height map, which is bilinear
//! between its points, g is a quadratic polynomial in every cell.

use super::height_map::HeightMap;
use super::way::{CONTACT, Way};
use crate::calibration::artefact::Artefact;
use glam::DVec3;

/// Accuracy of a trip along the normal, mm.
const CLOSED: f64 = 1e-10;
/// Steps of Newton's method. It doubles the digits, and where the way is a tangent adds one bit.
const STEPS: usize = 64;

/// What a probing move can touch, and the ball that touches it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Radius of the ball whose centre is the programmed point, mm.
    pub(super) tip_radius_mm: f64,
    pub(super) solids: Vec<Solid>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Solid {
    /// Everything below a height Z, mm.
    Plane(f64),
    Artefact(Artefact),
    /// Everything below a map.
    Map(HeightMap),
}

impl Solid {
    fn gap(&self, tip: DVec3, radius: f64) -> (f64, DVec3) {
        match self {
            Solid::Plane(height) => (tip.z - height - radius, DVec3::Z),
            Solid::Artefact(artefact) => artefact.gap(tip, radius),
            Solid::Map(map) => (map.gap(tip, radius), DVec3::Z),
        }
    }

    /// Share of the way at which the ball, outside at its start, touches first.
    fn entry(&self, way: &Way, radius: f64) -> Option<f64> {
        match self {
            Solid::Map(map) => map.entry(way, radius),
            _ => self.root(way, radius, 0.0),
        }
    }

    /// Share of the way, from `from` on, at which the ball, in contact there, is free.
    fn exit(&self, way: &Way, radius: f64, from: f64) -> Option<f64> {
        match self {
            Solid::Map(map) => map.exit(way, radius, from),
            _ if self.gap(way.at(1.0), radius).0 <= CLOSED => None,
            _ => Some(self.root(way, radius, 1.0).unwrap_or(from).max(from)),
        }
    }

    /// The root of the gap of a convex solid that is nearest to `from` (0 or 1), where the gap is positive.
    fn root(&self, way: &Way, radius: f64, from: f64) -> Option<f64> {
        let mut share = from;
        for _ in 0..STEPS {
            let (gap, normal) = self.gap(way.at(share), radius);
            if gap <= CLOSED {
                return Some(share);
            }
            let slope = normal.dot(way.change);
            // Away from the other end the solid recedes.
            if slope * (0.5 - from) >= 0.0 {
                return None;
            }
            let next = (share - gap / slope).clamp(0.0, 1.0);
            if next == share {
                return None;
            }
            share = next;
        }
        None
    }
}

impl Surface {
    fn touches(&self, tip: DVec3, within: f64) -> impl Iterator<Item = &Solid> {
        self.solids.iter().filter(move |solid| solid.gap(tip, self.tip_radius_mm).0 <= within)
    }

    /// Whether a ball at `tip` is in contact.
    pub(super) fn in_contact(&self, tip: DVec3) -> bool {
        self.touches(tip, CONTACT).next().is_some()
    }

    /// Share of the way at which the ball, free at its start, touches first.
    pub(super) fn contact(&self, way: &Way) -> Option<f64> {
        self.solids.iter().filter_map(|solid| solid.entry(way, self.tip_radius_mm)).min_by(f64::total_cmp)
    }

    /// Share of the way at which the ball, in contact at its start, is free.
    pub(super) fn free(&self, way: &Way) -> Option<f64> {
        let (mut share, mut within) = (0.0, CONTACT);
        // Where it leaves one solid it may be in another: at most once for each, and as often as a map has hills.
        loop {
            let mut touched = self.touches(way.at(share), within).peekable();
            if touched.peek().is_none() {
                return Some(share);
            }
            let exits = touched.map(|solid| solid.exit(way, self.tip_radius_mm, share));
            let next = exits.collect::<Option<Vec<_>>>()?.into_iter().fold(share, f64::max);
            if next <= share && within < 0.0 {
                return Some(share);
            }
            (share, within) = (next, -CONTACT);
        }
    }
}
