//! Coordinates that an instrument measured all over the volume, and the 21 errors that they tell.
//!
//! ```text
//! POINTS.csv ─► Points ─► fit ─► Found: document, machine
//! ```
//!
//! The mathematics is [`trueaxis_metrology::volumetric`]; what a unit of an error makes of the tip comes from the machine's
//! own volumetric model.

mod document;
mod found;
mod record;
mod shown;

pub use document::{Document, Function, Left, Squareness};
pub use found::{Found, Options, identify, nodes};
pub use record::{COLUMNS, Point, Points};
