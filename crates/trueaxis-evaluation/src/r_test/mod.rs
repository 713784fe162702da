//! R-test: the displacement of a ball at angles of the rotary axes, and the location errors of these axes that it determines.
//!
//! ```text
//! RECORD.csv ─► Record ─► identify ─► RTestFit: document, location errors
//! ```
//!
//! Under RTCP the control keeps the tool at a ball on the table while rotary axes turn (ISO 10791-6, tests BK); a nest of
//! three probes measures the displacement of the tool from the ball. With the location errors of the rotary axes, the ball's
//! place b in the workpiece's frame and the nest's zero s in the tool's frame,
//!
//! ```text
//! d(q) = known(q) + Σ EX0A … EB0C · r(q) − R_w(q) b + R_t(q) s
//! ```
//!
//! r(q) is the response of the machine's own volumetric model to a unit error, known(q) the contribution of its tables and of
//! the errors that are not fitted. b is always an unknown, s only if the nest was not calibrated to the spindle.
//!
//! Sources: ISO 10791-6:2014, Annex A; ISO 230-7:2015 (names); S. Weikert, CIRP Annals 53 (2004) 429 (the R-test); B. Bringmann,
//! W. Knapp, CIRP Annals 55 (2006) 531.

mod document;
mod fit;
mod record;
mod shown;
mod unknowns;

pub use document::{RTestDocument, Term};
pub use fit::{Options, RTestFit, identify};
pub use record::{COLUMNS, Reading, Record};
pub use unknowns::name;

use crate::range::OutOfRange;

/// Checks the nest's centre from the last tool-side frame, if it is not the machine's tool.
///
/// # Errors
/// A coordinate outside -10000 to 10000 mm.
pub fn check(tool_mm: Option<[f64; 3]>) -> Result<(), OutOfRange> {
    tool_mm.iter().flatten().try_for_each(|mm| OutOfRange::check("tool_mm", *mm, -1e4..=1e4, "mm"))
}
