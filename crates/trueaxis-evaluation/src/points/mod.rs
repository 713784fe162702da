//! Determines the 21 errors of the linear axes from coordinates that an instrument measured throughout the volume.
//!
//! ```text
//! POINTS.csv ─► Points ─► fit ─► Found: document, machine
//! ```
//!
//! The mathematics is in [`trueaxis_metrology::volumetric`]; the effect of a unit error on the tip comes from the machine's
//! own volumetric model.

mod document;
mod found;
mod record;
mod shown;

pub use document::{Document, Function, Left, Squareness};
pub use found::{Found, Options, identify, nodes};
pub use record::{COLUMNS, Point, Points};
