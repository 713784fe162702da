//! Probing tests after ISO 230-10: points measured by the machine's own probe on a reference ring, sphere or surface, and
//! their figures.
//!
//! Every run of points on a ring or sphere gives its least-squares centre and diameter, and P_FTU, the range of the points'
//! distances from that centre. Several runs together show the repeatability of a location and, with the spindle oriented
//! differently, the offset e of the stylus tip from the spindle's axis: centre(θ) = c + R(θ) e.

mod document;
mod record;
mod shown;

pub use document::{Offset, ProbingDocument, Run, Spread};
pub use record::{COLUMNS, Feature, Record, check};
