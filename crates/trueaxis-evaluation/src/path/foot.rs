//! Foot point of a position on a programmed path.

use super::ProgrammedPath;
use crate::record::Followed;
use trueaxis::contour::{ContourSearch, Flags};

/// The nearest point of a path, and a position's distance from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Segment, from 0.
    pub segment: u32,
    /// Parameter of the segment.
    pub u: f64,
    /// Distance, µm.
    pub error_um: f64,
    /// Position − foot, µm.
    pub vector_um: [f64; 3],
    /// Number of path evaluations.
    pub evaluations: u8,
    /// Whether the search bracketed the foot between two points.
    pub bracketed: bool,
    /// Position of the reference, mm.
    pub reference_mm: [f64; 3],
}

/// A reference that is not on the path.
#[derive(Clone, Debug, PartialEq)]
pub struct NotOnPath {
    /// `segment` or `u`.
    pub field: &'static str,
    /// Value of the field.
    pub found: f64,
    /// Values allowed.
    pub needed: String,
}

impl ProgrammedPath {
    /// The foot of a position (mm) near the reference at parameter u of a segment.
    ///
    /// # Errors
    /// A segment that does not exist, or u outside it.
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
            reference_mm: self.spans[reference.span as usize].position(reference.t),
        })
    }
}

/// A coordinate that does not change while the path advances along it.
#[derive(Clone, Debug, PartialEq)]
pub struct StuckAxis {
    /// 0 to 2: X, Y, Z.
    pub axis: usize,
    /// Row or line of the first such reading.
    pub row: usize,
    /// The value, the number of readings, and the distance that the path advances along the axis.
    pub found: String,
}

impl StuckAxis {
    /// The requirement named in a refusal.
    pub const NEEDED: &'static str = "a position that follows the path";
}

/// The coordinates of a recorded contour, row after row, checked for one that does not follow the path ([`Followed`]).
#[derive(Clone, Debug, Default)]
pub struct Alive([Followed; 3]);

impl Alive {
    /// Adds a row: its number or line, its foot, and its position, mm.
    pub fn put(&mut self, row: usize, foot: &Foot, position: [f64; 3]) {
        for ((axis, command), reading) in self.0.iter_mut().zip(foot.reference_mm).zip(position) {
            axis.put(row, command, reading);
        }
    }

    /// Finds the first coordinate that does not follow the path.
    ///
    /// # Errors
    /// With axis and row. Neither a dwell nor an axis that does not move while others do is an error.
    pub fn check(&self) -> Result<(), StuckAxis> {
        let first = self.0.iter().enumerate().find_map(|(axis, followed)| Some((axis, followed.stuck()?)));
        first.map_or(Ok(()), |(axis, (stuck, way))| {
            let found =
                format!("{} for {} readings in a row while the path advances by {way:.3} mm", stuck.value, stuck.count);
            Err(StuckAxis { axis, row: stuck.from, found })
        })
    }
}
