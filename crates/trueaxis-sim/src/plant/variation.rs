//! Differences from axis to axis, as on real machines.

use super::drive::{DriveSettings, Variant};
use crate::range::Range;
use serde::{Deserialize, Serialize};
use trueaxis::machine::Axis;

/// Differences of an axis from the others. For a rotary axis, read degree for mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variation {
    /// Drive of the axis, `None` for that of all axes (in settings `"common"`); the factors below apply to it.
    #[serde(with = "drive_name")]
    pub drive: Option<Variant>,
    /// Gains of position and velocity loop divided by the common ones.
    pub gain_factor: f64,
    /// Coulomb friction divided by the common one.
    pub friction_factor: f64,
    /// Lost motion that is not in the tables, mm: in negative travel the carriage stays behind by this amount.
    pub lost_motion_mm: f64,
}

impl Variation {
    /// Default differences: gains and friction vary by a few per cent from axis to axis; no lost motion except that of the
    /// tables.
    pub fn of(axis: Axis) -> Variation {
        let (gain_factor, friction_factor) = match axis {
            Axis::X => (1.0, 1.0),
            Axis::Y => (0.97, 1.12),
            Axis::Z => (1.02, 1.25),
            Axis::A => (0.94, 0.9),
            Axis::B => (0.95, 0.95),
            Axis::C => (1.01, 0.8),
        };
        Variation { drive: None, gain_factor, friction_factor, lost_motion_mm: 0.0 }
    }

    /// Name, value and range of every number.
    pub(crate) fn ranges(&self) -> [Range<'static>; 3] {
        let range = |key, found, low, high, unit| Range { key, found, low, high, unit };
        [
            range("gain_factor", self.gain_factor, 0.2, 4.0, ""),
            range("friction_factor", self.friction_factor, 0.0, 20.0, ""),
            range("lost_motion_mm", self.lost_motion_mm, 0.0, 1.0, "mm"),
        ]
    }
}

impl DriveSettings {
    /// The default drive of an axis.
    pub fn of(axis: Axis) -> DriveSettings {
        DriveSettings::default().varied(&Variation::of(axis))
    }

    /// The drive of an axis whose gains and friction differ from the common ones.
    pub fn varied(&self, by: &Variation) -> DriveSettings {
        DriveSettings {
            position_gain_per_s: self.position_gain_per_s * by.gain_factor,
            velocity_gain_per_s: self.velocity_gain_per_s * by.gain_factor,
            coulomb_mm_per_s2: self.coulomb_mm_per_s2 * by.friction_factor,
            ..*self
        }
    }
}

/// Name in settings of the drive that all axes share.
const COMMON: &str = "common";

/// Names in settings of an axis' drive.
pub(crate) const DRIVES: [&str; 1 + Variant::ALL.len()] = {
    let [stiff, usual, soft, worn] = Variant::ALL;
    [COMMON, stiff.name(), usual.name(), soft.name(), worn.name()]
};

mod drive_name {
    use super::{COMMON, Variant};
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub(super) fn serialize<S: Serializer>(drive: &Option<Variant>, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(drive.map_or(COMMON, Variant::name))
    }

    pub(super) fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<Option<Variant>, D::Error> {
        let name = String::deserialize(from)?;
        if name == COMMON { Ok(None) } else { Variant::named(&name).map(Some).map_err(D::Error::custom) }
    }
}

/// Variations of all axes, keyed by letter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "UPPERCASE")]
#[allow(missing_docs)]
pub struct Variations {
    pub x: Variation,
    pub y: Variation,
    pub z: Variation,
    pub a: Variation,
    pub b: Variation,
    pub c: Variation,
}

impl Default for Variations {
    fn default() -> Variations {
        let [x, y, z, a, b, c] = Axis::ALL.map(Variation::of);
        Variations { x, y, z, a, b, c }
    }
}

impl Variations {
    /// The variations in the order X, Y, Z, A, B, C.
    pub fn all(&self) -> [Variation; 6] {
        [self.x, self.y, self.z, self.a, self.b, self.c]
    }
}
