//! True surfaces of artefacts.

use glam::{DMat3, DVec3};

/// A surface in workpiece coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Artefact {
    /// Inside of a ring.
    Ring {
        /// Centre.
        centre: DVec3,
        /// Unit vector along its axis.
        axis: DVec3,
        /// Diameter.
        diameter: f64,
    },
    /// A ball.
    Ball {
        /// Centre.
        centre: DVec3,
        /// Diameter.
        diameter: f64,
    },
    /// A block with plane faces: a step of a gauge, an arm of a square.
    Block {
        /// Centre.
        centre: DVec3,
        /// Unit vectors normal to the faces, one per column.
        directions: DMat3,
        /// Half the extent along them.
        half: DVec3,
    },
}

/// Height of a ring, mm.
const HEIGHT: f64 = 25.0;
/// Wall of a ring, mm.
const WALL: f64 = 3.0;

impl Artefact {
    /// Distance from a tip of radius `radius` to the surface, mm, and the direction out of the material there.
    pub(crate) fn gap(&self, tip: DVec3, radius: f64) -> (f64, DVec3) {
        match *self {
            Artefact::Ring { centre, axis, diameter } => {
                let from = tip - centre;
                let along = from.dot(axis);
                let across = from - along * axis;
                let away = across.length();
                if away > 0.5 * diameter + WALL {
                    // Beyond its wall: in another hole of a plate, or beside the ring.
                    return ((away - 0.5 * diameter - WALL).max(1.0), across / away);
                }
                let inwards = if away > 0.0 { -across / away } else { DVec3::ZERO };
                if along.abs() > 0.5 * HEIGHT {
                    // Above or below the ring: at least as far away as its faces.
                    return ((along.abs() - 0.5 * HEIGHT).max(1.0), axis * along.signum());
                }
                (0.5 * diameter - radius - away, inwards)
            }
            Artefact::Ball { centre, diameter } => {
                let from = tip - centre;
                let away = from.length().max(f64::MIN_POSITIVE);
                (away - 0.5 * diameter - radius, from / away)
            }
            Artefact::Block { centre, directions, half } => {
                let from = directions.transpose() * (tip - centre);
                let beyond = from.abs() - half;
                let outside = beyond.max(DVec3::ZERO);
                let away = outside.length();
                let side = |part: DVec3| directions * (part * from.signum());
                if away > 0.0 {
                    return (away - radius, side(outside / away));
                }
                // Inside: out through the nearest face.
                let nearest = beyond.max_element();
                let across = DVec3::from([0, 1, 2].map(|k| if beyond[k] == nearest { 1.0 } else { 0.0 }));
                (nearest - radius, side(across).normalize_or_zero())
            }
        }
    }
}
