//! The foot of a position on a programmed path.

use super::ProgrammedPath;
use trueaxis::contour::{ContourSearch, Flags};

/// The nearest point of a path, and how far from it a position is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Segment, from 0.
    pub segment: u32,
    /// Its parameter.
    pub u: f64,
    /// Distance, µm.
    pub error_um: f64,
    /// Position − foot, µm.
    pub vector_um: [f64; 3],
    /// Evaluations of the path.
    pub evaluations: u8,
    /// Whether the search had the foot between two points.
    pub bracketed: bool,
}

/// A reference that is not on the path.
#[derive(Clone, Debug, PartialEq)]
pub struct NotOnPath {
    /// `segment` or `u`.
    pub field: &'static str,
    /// Its value.
    pub found: f64,
    /// What it must be.
    pub needed: String,
}

impl ProgrammedPath {
    /// The foot of a position (mm) near the reference at the parameter u of a segment.
    ///
    /// # Errors
    /// There is no such segment, or u is not on it.
    pub fn foot(
        &self,
        search: &ContourSearch<f64>,
        [segment, u]: [f64; 2],
        position: [f64; 3],
    ) -> Result<Foot, NotOnPath> {
        let last = self.segments() - 1;
        if segment.fract() != 0.0 || !(0.0..=last as f64).contains(&segment) {
            let needed = format!("a whole number from 0 to {last}");
            return Err(NotOnPath { field: "segment", found: segment, needed });
        }
        let reference = self.reference(segment as usize, u).map_err(|[low, high]| NotOnPath {
            field: "u",
            found: u,
            needed: format!("{low} to {high} on this segment"),
        })?;
        let found = search.nearest(&self.view(), reference, position);
        let span = &self.spans[found.span as usize];
        Ok(Foot {
            segment: span.segment(),
            u: span.u_of(found.t),
            error_um: found.error * 1e3,
            vector_um: found.vector.to_array().map(|mm| mm * 1e3),
            evaluations: found.evaluations,
            bracketed: found.flags.has(Flags::BRACKETED),
        })
    }
}
