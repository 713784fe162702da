//! The contour error of one part, recorded over path length, from which the correction for the next part is learned.
//!
//! The mathematics is in [`trueaxis_metrology::learning`].

mod record;

pub use record::{COLUMNS, Record};
