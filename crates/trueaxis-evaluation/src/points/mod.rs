//! Determines the 21 errors of the linear axes from coordinates that an instrument measured throughout the volume.
//!
//! ```text
//! POINTS.csv ─► Points ─► fit ─► PointsFit: document, machine
//! ```
//!
//! Points in a plane or along lines show fewer errors: [`identify_plane`] compares models of them by held-out points.
//!
//! The mathematics is in [`trueaxis_metrology::volumetric`]; the effect of a unit error on the tip comes from the machine's
//! own volumetric model.

mod document;
mod found;
mod plane;
mod record;
mod shown;

pub use document::{Function, Left, PointsDocument, Squareness};
pub use found::{Options, PointsFit, identify, nodes};
pub use plane::{
    CandidateDocument, Grid, LEVEL, PlaneDocument, PlaneErrors, PlaneFit, PlaneTerm, Tables, Transfer, identify_plane,
};
pub use record::{COLUMNS, Point, Points};
