//! Probing tests after ISO 230-10: points of the machine's own probe on a reference ring, sphere or surface, and their figures.
//!
//! Every run of points on a ring or sphere gives its least-squares centre and diameter, and P_FTU, the range of the points' distances from
//! that centre. Runs together tell how well a location repeats, and, with the spindle oriented differently, how far the stylus tip stands
//! off the spindle's axis: centre(θ) = c + R(θ) e.

mod document;
mod record;
mod shown;

pub use document::{Document, Offset, Run, Spread};
pub use record::{COLUMNS, Feature, Record, check};
