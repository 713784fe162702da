//! Parts of a frame.

use serde::{Deserialize, Serialize};

/// One axis in a [`super::Frame`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisFrame {
    /// Command, mm (deg).
    pub command: f64,
    /// Raw feedback, mm (deg).
    pub feedback: f64,
    /// Correction sent, mm (deg); only the geometric part if a dynamic one is configured.
    pub correction: f32,
    /// The dynamic correction, if any part is configured.
    pub dynamic: Option<DynamicFrame>,
}

/// The dynamic correction of an axis in a [`super::Frame`], mm (deg).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DynamicFrame {
    /// Sent in addition to the geometric correction.
    pub sent: f32,
    /// Wanted for friction, lag and acceleration.
    pub feed_forward: f32,
    /// Wanted by the contour feedback.
    pub feedback: f32,
    /// Wanted against cross-talk.
    pub crosstalk: f32,
    /// Wanted by the learned correction.
    pub learned: f32,
}

/// Contour error in a [`super::Frame`], mm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ContourFrame {
    /// Distance from the path.
    pub error: f32,
    /// Component in the plane, positive to the left of the path.
    pub normal: f32,
    /// Component along the plane's normal.
    pub binormal: f32,
    /// Arc length from the foot to the reference.
    pub lag: f32,
    /// Flags of the search ([`crate::contour::Flags`]).
    pub flags: u8,
}
