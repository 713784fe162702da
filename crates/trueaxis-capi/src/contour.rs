//! Contour error of a cycle.

use crate::Real;
use trueaxis::contour::ContourError;

/// A point on a path: a span and a parameter within it. `trueaxis_path_reference` computes it from a segment and its
/// parameter.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Reference {
    /// Number of the span.
    pub span: u32,
    /// Parameter in the span, 0 to 1.
    pub t: Real,
}

/// Contour error. Lengths in mm.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Contour {
    /// Span that contains the foot.
    pub span: u32,
    /// Number of evaluations of the path in this cycle.
    pub evaluations: u8,
    /// `TRUEAXIS_CONTOUR_…` bits.
    pub flags: u8,
    /// 0.
    pub reserved: u16,
    /// Parameter of the foot in the span, 0 to 1.
    pub t: Real,
    /// Distance from the path, |actual − foot|.
    pub error: Real,
    /// Actual − foot along X, Y, Z.
    pub vector: [Real; 3],
    /// Component in the machining plane, positive to the left of the path.
    pub normal: Real,
    /// Component along the plane's normal.
    pub binormal: Real,
    /// Component along the path; 0 except at ends and corners.
    pub tangential: Real,
    /// Arc length from the foot to the reference; positive while the tool lags.
    pub lag: Real,
    /// Remaining width of the bracket around the foot, as an arc length.
    pub width: Real,
}

impl Contour {
    pub(crate) fn of(error: &ContourError<Real>) -> Self {
        Contour {
            span: error.span,
            evaluations: error.evaluations,
            flags: error.flags.bits(),
            reserved: 0,
            t: error.t,
            error: error.error,
            vector: error.vector.into(),
            normal: error.normal,
            binormal: error.binormal,
            tangential: error.tangential,
            lag: error.lag,
            width: error.width,
        }
    }
}

/// The foot is a minimum of the distance, bracketed by − and +.
pub const CONTOUR_BRACKETED: u8 = 1;
/// The foot is an end of an open path.
pub const CONTOUR_AT_END: u8 = 2;
/// The foot is a corner between two spans.
pub const CONTOUR_AT_CORNER: u8 = 4;
/// A second minimum may be nearby.
pub const CONTOUR_SECOND_MINIMUM: u8 = 8;
/// No foot was known from the last cycle: the search is sampling the path around the reference.
pub const CONTOUR_COLD: u8 = 16;
/// Not measured (no path, or a faulty reading); all other members are 0.
pub const CONTOUR_NOT_FOUND: u8 = 32;
/// The reference was outside its span and was clamped to the nearer end. If it was not finite, no error was measured.
pub const CONTOUR_REFERENCE: u8 = 64;
/// The search continues in the next cycle. With `TRUEAXIS_CONTOUR_NOT_FOUND` it has no foot yet; otherwise the error is
/// measured from the best point of the path so far, not from the foot.
pub const CONTOUR_SEARCHING: u8 = 128;
