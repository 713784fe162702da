//! Errors in the bench's inputs.

use core::fmt;
use trueaxis::Axis;

/// A wrong quantity, with the value found and the value required.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InputError {
    /// The quantity.
    pub quantity: Quantity,
    /// The axis, if the quantity belongs to one.
    pub axis: Option<Axis>,
    /// Index in a list, from 0.
    pub index: Option<usize>,
    /// The value found, in the quantity's unit at the interface.
    pub found: f64,
    /// The value required.
    pub needed: &'static str,
}

impl InputError {
    /// Creates an error of a single quantity.
    pub fn new(quantity: Quantity, found: f64, needed: &'static str) -> Self {
        InputError { quantity, axis: None, index: None, found, needed }
    }

    /// Assigns the error to an axis.
    pub fn on(self, axis: Axis) -> Self {
        InputError { axis: Some(axis), ..self }
    }

    /// Assigns the error to an element of a list.
    pub fn at(self, index: usize) -> Self {
        InputError { index: Some(index), ..self }
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(axis) = self.axis {
            write!(f, "axis {}: ", axis.letter())?;
        }
        write!(f, "{:?}", self.quantity)?;
        if let Some(index) = self.index {
            write!(f, " [{index}]")?;
        }
        write!(f, ": found {}, needed {}", self.found, self.needed)
    }
}

impl core::error::Error for InputError {}

/// A quantity that can be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// Normal module of a gear.
    GearModule,
    /// Number of teeth of a gear.
    Teeth,
    /// Normal pressure angle of a gear.
    PressureAngle,
    /// Helix angle of a gear.
    HelixAngle,
    /// Radius of a base cylinder.
    BaseRadius,
    /// Lead parameter of a helicoid.
    LeadParameter,
    /// Side of a tooth.
    Flank,
    /// Roll angle u of an involute.
    RollAngle,
    /// Angle θ along a helix.
    LeadAngle,
    /// Pivot length, tool tip to rotary axis.
    Pivot,
    /// Travel of an edge finder.
    EdgeFinder,
    /// Ball radius of an edge finder.
    EdgeFinderRadius,
    /// Position of the workpiece on the table.
    WorkOffset,
    /// Sense of a rotary axis.
    Direction,
}
