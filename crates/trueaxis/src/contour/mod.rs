//! Contour error: the true distance of the tool from the programmed path, every servo period.
//!
//! The foot point is where the derivative of the distance changes from − to +: `g(u) = (P(u) − P_a)·P'(u)`, which has the
//! same zeros as the derivative of |P − P_a|, needs no root and is defined when the tool lies on the path. A change from
//! + to − is a maximum and never taken.
//!
//! - [`Segment`]s (lines, arcs in any plane, helices, splines to degree 5) are converted once into [`Span`]s;
//! - in a cycle, the search starts at the last foot plus the reference's progress. As a rule one call of the kernel
//!   ends it; else it descends, brackets and refines, across borders and corners, within a window of
//!   `5 µm + 4 × progress`. At most eight evaluations of the path in all, and eight spans between a foot or the
//!   reference and where it was in the last cycle: what leaps farther is searched afresh;
//! - the step has two points, estimated tip and encoder position, and searches them together
//!   ([`ContourSearch::update_pair`]): the tip's foot is followed, and the encoder's is the minimum of its distance
//!   downhill from there. In a hairpin both are on the same leg;
//! - where the path turns back by almost 180°, the foot goes by order along the path and lag, not by distance alone, and a
//!   second minimum is flagged while both legs are near;
//! - with no foot known (first cycle, after a fault, lost) the path around the reference is searched over several cycles,
//!   first behind it, then ahead;
//! - a host whose planner is closed lets its own commands be the path ([`CommandWindow`]);
//! - a [`ToolPath`] adds a direction to every span ([`Turn`]): its error is the angle at the tip's foot, and where the
//!   tip stands while the tool turns ([`Segment::Turning`]), that to the nearest orientation.
//!
//! Source: Han Jiang et al., CN110161966A, bracket and bisect the derivative of the distance. Corrected: the published rule
//! takes maxima too, compares signed derivatives where distances count, and searches around the reference instead of the
//! last foot, which loses the path behind a narrow bend.

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

pub use buffer::{JOINED_WITHIN_MM, PathBuffer, PathBuilder};
pub use command_window::CommandWindow;
pub use convert::{PathError, Segment, convert, span_count};
pub use offline::NearFoot;
pub use orientation::{OrientationError, ToolPath, Turn};
pub use pair::PairState;
pub use search::{ContourSearch, ContourState, Method};
pub use span::{Form, OnPath, Path, Reference, Span};

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
    /// A second minimum may be near.
    pub const SECOND_MINIMUM: Flags = Flags(8);
    /// No foot was known from the last cycle; the path around the reference is being searched.
    pub const COLD: Flags = Flags(16);
    /// There is no path, or the readings are not trusted: nothing was measured.
    pub const NOT_FOUND: Flags = Flags(32);
    /// The reference lay outside its span and was taken at the nearer end; infinite or not a number, nothing was
    /// measured.
    pub const REFERENCE: Flags = Flags(64);

    /// Whether all bits of `other` are set.
    pub const fn has(self, other: Flags) -> bool {
        self.0 & other.0 == other.0
    }

    /// Both.
    #[must_use]
    pub const fn and(self, other: Flags) -> Flags {
        Flags(self.0 | other.0)
    }

    /// The bits.
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
    /// Parameter of the foot in the span.
    pub t: R,
    /// Distance from the path: |actual − foot|.
    pub error: R,
    /// Actual − foot, in machine axes; at ends and corners this is the authority.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub vector: R::Vec3,
    /// Component along n = b × t: positive to the left of the path, seen against the plane's normal b. Where the path
    /// runs along b, n is machine X.
    pub normal: R,
    /// Component along t × n: out of the plane.
    pub binormal: R,
    /// Component along the tangent t: zero but at ends and corners.
    pub tangential: R,
    /// Arc length from the foot to the reference, positive while the tool lags.
    pub lag: R,
    /// Remaining width of the bracket, arc length.
    pub width: R,
    /// Evaluations of the path used (the kernel counts as two).
    pub evaluations: u8,
    /// Flags of the search.
    pub flags: Flags,
}

impl<R: Real> ContourError<R> {
    /// Nothing measured.
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

    /// Whether there is a value.
    pub fn is_measured(&self) -> bool {
        !self.flags.has(Flags::NOT_FOUND)
    }
}

#[cfg(test)]
mod tests;
