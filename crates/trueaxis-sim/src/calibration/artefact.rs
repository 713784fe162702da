//! Surfaces as they really are.

use glam::DVec3;

/// A surface in workpiece coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Artefact {
    /// Inside of a ring.
    Ring {
        /// Its centre.
        centre: DVec3,
        /// Unit vector along its axis.
        axis: DVec3,
        /// Diameter.
        diameter: f64,
    },
    /// A ball.
    Ball {
        /// Its centre.
        centre: DVec3,
        /// Diameter.
        diameter: f64,
    },
    /// A plane face of some extent.
    Face {
        /// Its middle.
        centre: DVec3,
        /// Unit vector out of the material.
        outward: DVec3,
        /// Half of its extent, about.
        half: f64,
    },
}

/// Height of a ring, mm.
const HEIGHT: f64 = 25.0;

impl Artefact {
    /// Way from a tip of radius `radius` to the surface, mm, and the direction out of the material there.
    pub(super) fn gap(&self, tip: DVec3, radius: f64) -> (f64, DVec3) {
        match *self {
            Artefact::Ring { centre, axis, diameter } => {
                let from = tip - centre;
                let along = from.dot(axis);
                let across = from - along * axis;
                let away = across.length();
                let inwards = if away > 0.0 { -across / away } else { DVec3::ZERO };
                if along.abs() > 0.5 * HEIGHT {
                    // Above or below it: at most as near as its faces.
                    return ((along.abs() - 0.5 * HEIGHT).max(1.0), axis * along.signum());
                }
                (0.5 * diameter - radius - away, inwards)
            }
            Artefact::Ball { centre, diameter } => {
                let from = tip - centre;
                let away = from.length().max(f64::MIN_POSITIVE);
                (away - 0.5 * diameter - radius, from / away)
            }
            Artefact::Face { centre, outward, half } => {
                let from = tip - centre;
                let away = from.dot(outward);
                let beside = (from - away * outward).length() - half;
                if beside > 0.0 { (away.abs().max(beside).max(0.5), outward) } else { (away - radius, outward) }
            }
        }
    }
}
