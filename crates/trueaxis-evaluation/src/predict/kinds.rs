//! Kinds of features, what tolerances limit, and how a form is associated.

use super::gear::FlankDeviation;

/// Where the tool is on a circle, or where the material is, seen along the path or from the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// A bore.
    Inside,
    /// A boss.
    Outside,
    /// Material to the left of the path.
    Left,
    /// Material to the right of the path.
    Right,
    /// Material on the tool's end.
    Below,
    /// Material between the tool's end and the spindle: an undercut.
    Above,
}

/// Kind of a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeatureKind {
    /// Arcs about one centre, or chords that end on one circle.
    Circle,
    /// A hole drilled along the plane's normal.
    Hole,
    /// An edge cut by the side of the tool along a straight line.
    Line,
    /// A surface cut by moves in one plane.
    Plane,
    /// A flank of a helical gear, cut point by point over a grid.
    Flank,
    /// A free form: one pass in a plane, or a surface of several passes side by side.
    Profile,
}

impl FeatureKind {
    /// All of them with their names in a file.
    pub const NAMES: [(&'static str, FeatureKind); 6] = [
        ("circle", FeatureKind::Circle),
        ("hole", FeatureKind::Hole),
        ("line", FeatureKind::Line),
        ("plane", FeatureKind::Plane),
        ("flank", FeatureKind::Flank),
        ("profile", FeatureKind::Profile),
    ];

    /// Name in a file.
    pub fn name(self) -> &'static str {
        FeatureKind::NAMES.iter().find(|(_, own)| *own == self).map_or("", |(name, _)| name)
    }
}

/// What a tolerance limits; names after ISO 1101, sizes and distances after ISO 14405.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Characteristic {
    /// Deviation of a circle's diameter.
    Size,
    /// Deviation of the distance from another feature.
    Distance,
    /// Diameter of the zone about the nominal centre that just contains the centre.
    Position,
    /// Width of a line's zone.
    Straightness,
    /// Width of a plane's zone.
    Flatness,
    /// Width of a circle's zone.
    Roundness,
    /// Width of the zone parallel to the datum.
    Parallelism,
    /// Width of the zone perpendicular to the datum.
    Perpendicularity,
    /// Width of the zone at the programmed angle to the datum.
    Angularity,
    /// Width of the zone with the true profile in its middle: twice the largest deviation along the normal.
    Profile,
    /// A deviation of a gear's flank.
    Flank(FlankDeviation),
}

impl Characteristic {
    /// All of them with their names in a file.
    pub const NAMES: [(&'static str, Characteristic); 16] = [
        ("size", Characteristic::Size),
        ("distance", Characteristic::Distance),
        ("position", Characteristic::Position),
        ("straightness", Characteristic::Straightness),
        ("flatness", Characteristic::Flatness),
        ("roundness", Characteristic::Roundness),
        ("parallelism", Characteristic::Parallelism),
        ("perpendicularity", Characteristic::Perpendicularity),
        ("angularity", Characteristic::Angularity),
        ("profile", Characteristic::Profile),
        ("profile total", Characteristic::Flank(FlankDeviation::ProfileTotal)),
        ("profile form", Characteristic::Flank(FlankDeviation::ProfileForm)),
        ("profile slope", Characteristic::Flank(FlankDeviation::ProfileSlope)),
        ("helix total", Characteristic::Flank(FlankDeviation::HelixTotal)),
        ("helix form", Characteristic::Flank(FlankDeviation::HelixForm)),
        ("helix slope", Characteristic::Flank(FlankDeviation::HelixSlope)),
    ];

    /// Name in a file.
    pub fn name(self) -> &'static str {
        Characteristic::NAMES.iter().find(|(_, own)| *own == self).map_or("", |(name, _)| name)
    }

    /// Whether two limits of a deviation are stated, not the width of a zone.
    pub fn has_limits(self) -> bool {
        match self {
            Characteristic::Size | Characteristic::Distance => true,
            Characteristic::Flank(deviation) => deviation.is_slope(),
            _ => false,
        }
    }

    /// Whether it is a form: the width of a zone about the feature itself, wherever that is.
    pub fn is_form(self) -> bool {
        matches!(self, Characteristic::Straightness | Characteristic::Flatness | Characteristic::Roundness)
    }

    /// Kinds of features that have it.
    pub(super) fn kinds(self) -> &'static [FeatureKind] {
        use FeatureKind::{Circle, Flank, Hole, Line, Plane, Profile};
        match self {
            Characteristic::Size | Characteristic::Roundness => &[Circle],
            Characteristic::Position => &[Circle, Hole],
            Characteristic::Straightness => &[Line],
            Characteristic::Flatness => &[Plane],
            Characteristic::Parallelism | Characteristic::Perpendicularity | Characteristic::Angularity => {
                &[Line, Plane]
            }
            Characteristic::Distance => &[Circle, Hole, Line, Plane],
            Characteristic::Profile => &[Profile],
            Characteristic::Flank(_) => &[Flank],
        }
    }

    /// Numbers of datums, least and most.
    pub(super) fn datums(self) -> [usize; 2] {
        match self {
            Characteristic::Position | Characteristic::Profile => [0, 3],
            Characteristic::Size
            | Characteristic::Roundness
            | Characteristic::Straightness
            | Characteristic::Flatness
            | Characteristic::Flank(_) => [0, 0],
            _ => [1, 1],
        }
    }
}

/// How a form is associated with its points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Association {
    /// The zone about the feature with the least squares of the distances.
    #[default]
    LeastSquares,
    /// The narrowest zone that contains all points.
    MinimumZone,
}

impl Association {
    /// Both with their names in a file.
    pub const NAMES: [(&'static str, Association); 2] =
        [("least squares", Association::LeastSquares), ("minimum zone", Association::MinimumZone)];

    /// Name in a file.
    pub fn name(self) -> &'static str {
        Association::NAMES.iter().find(|(_, own)| *own == self).map_or("", |(name, _)| name)
    }
}
