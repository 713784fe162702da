//! Contour error: the true distance of the tool from the programmed path, computed every servo period.
//!
//! The foot point is where the derivative of the distance changes from − to +. `g(u) = (P(u) − P_a)·P'(u)` has the same zeros
//! as the derivative of |P − P_a|, needs no root and is defined when the tool lies on the path. A change from + to − is a
//! maximum and is never accepted.
//!
//! - [`Segment`]s (lines, arcs in any plane, helices, splines to degree 5) are converted once into [`Span`]s;
//! - in each cycle the search starts at the last foot plus the reference's progress. Usually one call of the kernel is enough;
//!   otherwise the search descends, brackets and refines, across borders and corners, within a window of
//!   `5 µm + 4 × progress`. A search that needs more than a cycle's share continues in the next one and is flagged
//!   ([`Flags::SEARCHING`]). A cycle covers at most eight spans between a foot or the reference and its position in the last
//!   cycle: after a larger jump the search starts cold;
//! - the step has two points, estimated tip and encoder position, and searches for both feet together
//!   (`ContourSearch::update_pair`): it follows the tip's foot, and the encoder's foot is the minimum of its distance
//!   downhill from there. In a hairpin both are on the same leg;
//! - where the path turns back by almost 180°, order along the path and lag decide the foot, not distance alone, and a second
//!   minimum is flagged while both legs are near;
//! - with no foot known (first cycle, after a fault, lost) the search samples the path around the reference over
//!   thirteen cycles, first behind it, then ahead, and measures no error meanwhile;
//! - a host whose planner is closed can use its own commands as the path ([`CommandWindow`]);
//! - a [`ToolPath`] adds a direction to every span ([`Turn`]). The orientation error is the angle at the tip's foot or,
//!   where the tip stays in place while the tool turns ([`Segment::Turning`]), the angle to the nearest orientation.
//!
//! Source: Han Jiang et al., CN110161966A, bracket and bisect the derivative of the distance. Corrected here: the published
//! rule also accepts maxima, compares signed derivatives where distances count, and searches around the reference instead of
//! the last foot, which loses the path behind a narrow bend.

mod buffer;
mod command_window;
mod convert;
mod kernel;
mod legs;
mod nearest;
mod offline;
mod orientation;
mod pair;
mod refine;
mod search;
mod span;
mod way;

pub use buffer::{JOINED_WITHIN_MM, PathBuffer};
pub use command_window::CommandWindow;
pub use convert::{PathError, Segment};
pub use orientation::{OrientationError, ToolPath, Turn};
pub use span::{OnPath, Path, Reference, Span};

bench!(use buffer::PathBuilder);
bench!(use convert::{convert, span_count});
bench!(use offline::NearFoot);
bench!(use pair::PairState);
bench!(use search::{ContourSearch, ContourState, Method});
bench!(use span::Form);

use crate::real::Real;
use serde::{Deserialize, Serialize};

/// Flags of the search for a contour error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Flags(u8);

impl Flags {
    /// The foot is a minimum of the distance, bracketed by − and +.
    pub const BRACKETED: Flags = Flags(1);
    /// The foot is an end of an open path.
    pub const AT_END: Flags = Flags(2);
    /// The foot is a corner between two spans.
    pub const AT_CORNER: Flags = Flags(4);
    /// A second minimum may be nearby.
    pub const SECOND_MINIMUM: Flags = Flags(8);
    /// No foot was known from the last cycle; the search is sampling the path around the reference.
    pub const COLD: Flags = Flags(16);
    /// No error was measured: the path is empty, or the readings are not trusted.
    pub const NOT_FOUND: Flags = Flags(32);
    /// The reference lay outside its span and was clamped to the nearer end; if it was infinite or not a number, no error was
    /// measured.
    pub const REFERENCE: Flags = Flags(64);
    /// The search continues in the next cycle. With [`Flags::NOT_FOUND`] it has no foot yet; otherwise the error is measured
    /// from the best point of the path so far, not from the foot.
    pub const SEARCHING: Flags = Flags(128);

    /// Whether all bits of `other` are set.
    pub const fn has(self, other: Flags) -> bool {
        self.0 & other.0 == other.0
    }

    /// Union of both sets of flags.
    #[must_use]
    pub const fn and(self, other: Flags) -> Flags {
        Flags(self.0 | other.0)
    }

    /// The flags as bits.
    pub const fn bits(self) -> u8 {
        self.0
    }
}

/// Contour error in a cycle; lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct ContourError<R: Real> {
    /// Span on which the foot lies.
    pub span: u32,
    /// Parameter of the foot on the span.
    pub t: R,
    /// Distance from the path: |actual − foot|.
    pub error: R,
    /// Actual − foot, in machine axes; at ends and corners this vector is authoritative.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub vector: R::Vec3,
    /// Component along n = b × t: positive to the left of the path, seen against the plane's normal b. Where the path runs
    /// along b, n is machine X.
    pub normal: R,
    /// Component along t × n: out of the plane.
    pub binormal: R,
    /// Component along the tangent t: zero except at ends and corners.
    pub tangential: R,
    /// Arc length from the foot to the reference; positive while the tool lags.
    pub lag: R,
    /// Remaining width of the bracket, mm of arc length.
    pub width: R,
    /// Evaluations of the path used (the kernel counts as two).
    pub evaluations: u8,
    /// Flags of the search.
    pub flags: Flags,
}

impl<R: Real> ContourError<R> {
    /// No error measured yet.
    pub(crate) fn searching() -> Self {
        ContourError { flags: Flags::NOT_FOUND.and(Flags::COLD).and(Flags::SEARCHING), ..ContourError::none() }
    }

    /// No error measured.
    pub fn none() -> Self {
        ContourError {
            span: 0,
            t: R::ZERO,
            error: R::ZERO,
            vector: R::Vec3::default(),
            normal: R::ZERO,
            binormal: R::ZERO,
            tangential: R::ZERO,
            lag: R::ZERO,
            width: R::ZERO,
            evaluations: 0,
            flags: Flags::NOT_FOUND,
        }
    }

    /// Whether an error was measured.
    pub fn is_measured(&self) -> bool {
        !self.flags.has(Flags::NOT_FOUND)
    }
}

#[cfg(test)]
mod tests;
