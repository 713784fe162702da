//! Paths built segment by segment.

use super::convert::{PathError, Segment, convert};
use super::span::{OnPath, Path, Span};
use crate::position::Position;
use crate::real::Real;
use glam::DVec3;

/// Largest gap between the end of a segment and the start of the next, mm; rounded programs leave such gaps.
pub const JOINED_WITHIN_MM: f64 = 0.02;

/// Converts segments one after the other: numbers them from 0 and checks that each begins where the previous one ends.
///
/// The caller stores the spans; [`PathBuffer`] contains its own memory.
#[derive(Clone, Copy, Debug)]
pub struct PathBuilder<P> {
    segments: u32,
    plane: [f64; 3],
    /// End of the last segment.
    end: Option<[P; 3]>,
}

impl<P: Position> PathBuilder<P> {
    /// A builder without segments; the machining plane is XY (G17).
    pub const fn new() -> Self {
        PathBuilder { segments: 0, plane: [0.0, 0.0, 1.0], end: None }
    }

    /// Number of segments so far.
    pub fn segments(&self) -> u32 {
        self.segments
    }

    /// Sets the normal of the machining plane for subsequent segments (G17 to G19), of any length above 1e-6; it determines
    /// the signs of the contour error's components.
    pub fn set_plane(&mut self, normal: [f64; 3]) {
        self.plane = normal;
    }

    /// Converts a segment (mm) and hands its spans to `sink` in path order. Not for a servo cycle.
    ///
    /// # Errors
    /// As [`convert`]; a segment that begins more than [`JOINED_WITHIN_MM`] from the end of the previous one. The builder is
    /// then unchanged, whatever `sink` has received.
    pub fn append<R: Real>(
        &mut self,
        segment: &Segment<'_>,
        mut sink: impl FnMut(Span<R, P>) -> Result<(), PathError>,
    ) -> Result<(), PathError> {
        let mut end = self.end;
        let mut begins = true;
        convert(segment, self.segments, self.plane, |span: Span<R, P>| {
            if let (true, Some(before)) = (begins, end) {
                joined("start", before, span.position(R::ZERO))?;
            }
            (begins, end) = (false, Some(span.position(R::ONE)));
            sink(span)
        })?;
        self.end = end;
        self.segments = self.segments.wrapping_add(1);
        Ok(())
    }
}

impl<P: Position> Default for PathBuilder<P> {
    fn default() -> Self {
        Self::new()
    }
}

/// Refuses two points that do not coincide.
fn joined<P: Position>(field: &'static str, before: [P; 3], after: [P; 3]) -> Result<(), PathError> {
    let squared = before.into_iter().zip(after).fold(0.0, |sum, (a, b)| {
        let difference: f64 = a.since(b);
        sum + difference * difference
    });
    if squared <= JOINED_WITHIN_MM * JOINED_WITHIN_MM {
        return Ok(());
    }
    let needed = "at most 0.02 mm from the end of the segment before";
    Err(PathError { field, index: None, found: libm::sqrt(squared), needed })
}

/// A programmed path of at most `SPANS` spans, stored in the value itself.
///
/// A line takes one span per 16 mm, an arc one per 30°, a spline one or more for each knot interval.
///
/// ```
/// # use trueaxis::HostPath;
/// let mut path = HostPath::<16>::new();
/// path.line([0.0; 3], [20.0, 0.0, 0.0])?;
/// path.arc([20.0, 0.0, 0.0], [30.0, 10.0, 0.0], [20.0, 10.0, 0.0], [0.0, 0.0, 1.0])?;
/// let foot = path.path().nearest([28.0, 2.0, 0.0]);
/// assert!((foot.error - (8.0 * f64::sqrt(2.0) - 10.0)).abs() < 1e-9);
/// # Ok::<(), trueaxis::contour::PathError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PathBuffer<R, P, const SPANS: usize> {
    builder: PathBuilder<P>,
    spans: heapless::Vec<Span<R, P>, SPANS>,
    closed: bool,
}

impl<R: Real, P: Position, const SPANS: usize> PathBuffer<R, P, SPANS> {
    /// An empty path in the machining plane XY (G17).
    pub const fn new() -> Self {
        PathBuffer { builder: PathBuilder::new(), spans: heapless::Vec::new(), closed: false }
    }

    /// Appends a straight line, mm; u = 0..1 proportional to length.
    ///
    /// # Errors
    /// As [`PathBuffer::append`].
    pub fn line(&mut self, start: impl Into<DVec3>, end: impl Into<DVec3>) -> Result<(), PathError> {
        self.append(&Segment::Line { start: start.into(), end: end.into() })
    }

    /// Appends a circular arc about an axis through `center` along `normal` (right hand), mm; u = 0..1 proportional to the
    /// angle. It is a helix if start and end differ along the axis; start and end at the same angle make a full circle.
    ///
    /// # Errors
    /// As [`PathBuffer::append`].
    pub fn arc(
        &mut self,
        start: impl Into<DVec3>,
        end: impl Into<DVec3>,
        center: impl Into<DVec3>,
        normal: impl Into<DVec3>,
    ) -> Result<(), PathError> {
        self.append(&Segment::Arc {
            start: start.into(),
            end: end.into(),
            center: center.into(),
            normal: normal.into(),
            turns: 0,
        })
    }

    /// Appends a spline of degree 1 to 5, mm; u over `knots[degree] ..= knots[points.len()]`. An empty `weights` means weights
    /// of one.
    ///
    /// # Errors
    /// As [`PathBuffer::append`].
    pub fn nurbs(&mut self, degree: usize, knots: &[f64], points: &[DVec3], weights: &[f64]) -> Result<(), PathError> {
        self.append(&Segment::Nurbs { degree, knots, points, weights })
    }

    /// Appends a segment; this reopens a closed path. Not for a servo cycle.
    ///
    /// # Errors
    /// A segment that is not a valid path, or that starts more than [`JOINED_WITHIN_MM`] from the end of the one before,
    /// or no room for all of its spans; the path is then unchanged.
    pub fn append(&mut self, segment: &Segment<'_>) -> Result<(), PathError> {
        let before = self.spans.len();
        let spans = &mut self.spans;
        let full = PathError { field: "path", index: None, found: SPANS as f64, needed: "room for more spans" };
        let appended = self.builder.append(segment, |span| spans.push(span).map_err(|_| full));
        match appended {
            Ok(()) => self.closed = false,
            Err(_) => self.spans.truncate(before),
        }
        appended
    }

    /// Sets the normal of the machining plane for subsequent segments, initially 0, 0, 1 (G17); the signs of the contour
    /// error's components depend on it.
    pub fn set_plane(&mut self, normal: [f64; 3]) {
        self.builder.set_plane(normal);
    }

    /// Closes the path: the first segment follows the last one.
    ///
    /// # Errors
    /// The last segment does not end where the first one begins, within [`JOINED_WITHIN_MM`].
    pub fn close(&mut self) -> Result<(), PathError> {
        if let ([first, ..], [.., last]) = (&self.spans[..], &self.spans[..]) {
            joined("start", last.position(R::ONE), first.position(R::ZERO))?;
            self.closed = true;
        }
        Ok(())
    }

    /// Removes all segments; the plane stays.
    pub fn clear(&mut self) {
        self.builder = PathBuilder { segments: 0, end: None, ..self.builder };
        self.spans.clear();
        self.closed = false;
    }

    /// The path, for the step and for searches.
    #[inline(always)]
    pub fn path(&self) -> Path<'_, R, P> {
        Path::new(&self.spans, 0, self.closed)
    }

    /// Point at parameter `u` of a segment, for the step: see [`Path::at`].
    #[inline]
    pub fn at(&self, segment: u32, u: f64) -> OnPath<'_, R, P> {
        self.path().at(segment, u)
    }
}

impl<R: Real, P: Position, const SPANS: usize> Default for PathBuffer<R, P, SPANS> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
