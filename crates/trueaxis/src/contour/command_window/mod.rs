//! The last commands as the path, for a host whose planner does not reveal its path.

#![deny(clippy::indexing_slicing)]

use super::ContourError;
use super::span::{Path, Reference, Span};
use crate::error::{ConfigError, Field};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

mod nearest;

/// A short window of the last commanded points, joined into a smooth path that ends at the newest command.
///
/// Points lie about a *spacing* apart, closer where the path bends; a cubic joins two of them, with chord c. Its direction at
/// a point is that of the circle through the point and its two neighbours,
///
/// ```text
/// t ∝ |v| u/|u| + |u| v/|v|        u, v: chords before and after the point
/// ```
///
/// and its speed is 4|c|/(2 + cos α₀ + cos α₁), with α the angles between c and the directions. On a circle at 6° a
/// span the cubic is within 1e-10 of the radius; this error falls with the sixth power of the angle. If u and v differ
/// by more than 20°, the point is a corner, and the spans on either side are independent of each other.
///
/// Remaining error: where the curvature jumps, as from a line to an arc of radius R, c²/(27 R) (75 nm for 0.1 mm on 5 mm) in
/// the two spans beside it; corners and turning points between two commands are cut as the commands cut them, and by up to
/// spacing/200 more. If the tool is ahead of the newest command, its foot is the path's end, and `tangential` is the distance
/// ahead.
///
/// K is the number of spans in the window, with memory for 2 K. Span numbers are never reused, so the foot of the
/// last cycle stays valid. Nothing is allocated.
#[derive(Clone, Copy, Debug)]
pub struct CommandWindow<R, P, const K: usize> {
    /// Both halves contain every span: any K consecutive spans are contiguous somewhere, and no cycle has to move them.
    spans: [[Span<R, P>; K]; 2],
    /// Slot of the newest span in a half, and its number.
    place: usize,
    number: u32,
    /// Spans in the window; 0 before the first command.
    count: usize,
    /// Whether the window has been full since the motion began: its first point may then be anywhere on the path.
    cut: bool,
    /// The span before the open one.
    last: Option<Chord<R, P>>,
    /// Last fixed point.
    from: [P; 3],
    open: Open<R, P>,
    plane: [R; 3],
    spacing: R,
}

/// A span with fixed ends, whose direction at its end still depends on the next point.
#[derive(Clone, Copy, Debug)]
struct Chord<R, P> {
    from: [P; 3],
    way: V3<R>,
    unit: V3<R>,
    length: R,
    start: Option<V3<R>>,
}

/// The span from the last fixed point to the newest command.
#[derive(Clone, Copy, Debug)]
struct Open<R, P> {
    /// Newest command.
    to: [P; 3],
    /// The span, if it has a length.
    chord: Option<Chord<R, P>>,
    /// Initial direction, once it is known.
    heading: Option<V3<R>>,
    /// Distance that the span has reached in that direction.
    reach: R,
}

/// Shortest span, per spacing: below it, the newest command and the last point count as one.
const SHORTEST: f64 = 1.0 / 250.0;
/// Length from which a span's direction is used, per spacing.
const DIRECTED: f64 = 1.0 / 25.0;
/// Commands that leave the straight line by more than this, or go back, begin a new span: per spacing.
const TUBE: f64 = 1.0 / 250.0;
/// cos 20°: chords that differ by more meet in a corner.
const CORNER: f64 = 0.94;
/// A chord this many times shorter than its neighbour does not determine the direction between them: it may be noise.
const UNEVEN: f64 = 8.0;
/// Commands farther apart are a jump, not a motion, mm.
const JUMP: f64 = 8.0;

impl<R: Real, P: Position, const K: usize> CommandWindow<R, P, K> {
    /// An empty window.
    ///
    /// `plane`: normal of the machining plane, for the signed components; any length. `spacing_mm`: distance between two
    /// points at slow feeds, 0.001 to 1 mm; 0.005 is a good value. At fast feeds every command is a point. The window must
    /// cover the largest lag: K ≥ lag / max(spacing, travel in a cycle).
    ///
    /// # Errors
    /// A `plane` without a direction; a spacing outside the range.
    pub fn new(plane: [f64; 3], spacing_mm: f64) -> Result<Self, ConfigError> {
        const { assert!(K >= 2, "a window of at least two pieces") };
        let size = libm::sqrt(plane.iter().map(|x| x * x).sum());
        if !(1e-6..1e9).contains(&size) {
            return Err(ConfigError::new(Field::CommandWindow, size, "a plane's normal of length 1e-6 to 1e9"));
        }
        if !(1e-3..=1.0).contains(&spacing_mm) {
            return Err(ConfigError::new(Field::CommandWindow, spacing_mm, "a spacing of 0.001 to 1 mm"));
        }
        let plane = plane.map(|x| R::of(x / size));
        let zero = [P::default(); 3];
        Ok(CommandWindow {
            spans: [[Span::turning(zero, 0, plane); K]; 2],
            place: 0,
            number: 0,
            count: 0,
            cut: false,
            last: None,
            from: zero,
            open: Open::at(zero),
            plane,
            spacing: R::of(spacing_mm),
        })
    }

    /// Takes the command of this cycle, mm; ignores one that is not a finite position.
    ///
    /// At standstill nothing changes; after a jump of more than 8 mm the window starts over. The cost is constant: two cubics,
    /// eight roots, four spans written.
    #[inline]
    pub fn append(&mut self, command: [P; 3]) {
        if !command.iter().all(|x| x.is_usable()) {
            return;
        }
        let step = way(&self.open.to, &command);
        let step = step.dot(step);
        if self.count == 0 || step > R::of(JUMP * JUMP) {
            return self.begin(command);
        }
        if self.is_complete(&command, step) {
            self.last = self.open.chord;
            self.from = self.open.to;
            self.open = Open::at(self.from);
        }
        self.draw(command);
    }

    /// Forgets all commands, as after homing: the next one starts a new window.
    pub fn restart(&mut self) {
        self.count = 0;
    }

    /// The window as a path: empty before the first command, a point before the first motion.
    #[inline]
    pub fn path(&self) -> Path<'_, R, P> {
        let end = self.place + K + 1;
        let spans = self.spans.as_flattened().get(end.saturating_sub(self.count)..end).unwrap_or_default();
        Path::new(spans, self.number.wrapping_sub(self.count.saturating_sub(1) as u32), false)
    }

    /// Position of the newest command: the end of the path.
    #[inline]
    pub fn reference(&self) -> Reference<R> {
        // A single point becomes the start of the first span.
        let moved = self.last.is_some() || self.open.chord.is_some();
        Reference { span: self.number, t: if moved { R::ONE } else { R::ZERO } }
    }

    /// Contour error of `point` (mm): its distance from the nearest point of the whole window.
    ///
    /// Memoryless, unlike the search in the step, which follows one foot on a path of long spans: here a span is often
    /// shorter than the tool's motion in a cycle. If the window passes the same point twice, the later pass counts; the chords
    /// decide which of two spans is nearer. Without [`super::Flags::BRACKETED`] the tool is farther behind than the window
    /// reaches. Bounded: K distances from a line, twice the kernel, and at corners four evaluations more.
    #[inline]
    pub fn contour_error(&self, point: [P; 3]) -> ContourError<R> {
        nearest::contour_error(&self.path(), self.reference(), !self.cut, &point)
    }

    /// Starts a window of one point.
    #[cold]
    fn begin(&mut self, command: [P; 3]) {
        // Skips a number: on the next one, a foot of the old window would be a neighbour, and a search would cross the
        // jump.
        self.number = self.number.wrapping_add(2);
        (self.from, self.open, self.last, self.count) = (command, Open::at(command), None, 1);
        self.cut = false;
        self.put(self.place, Span::turning(command, self.number, self.plane));
    }

    /// Whether the open span ends at its current point, so that the command begins a new one.
    #[inline(always)]
    fn is_complete(&self, command: &[P; 3], step: R) -> bool {
        let Some(chord) = &self.open.chord else { return false };
        let spacing = self.spacing;
        // A long step would stretch the open span, and a foot on it, farther than a search reaches.
        if chord.length >= spacing || step >= spacing * spacing {
            return true;
        }
        let Some(heading) = self.open.heading else { return false };
        let tube = spacing * R::of(TUBE);
        let way = way(&self.from, command);
        let along = way.dot(heading);
        let aside = way - heading * along;
        along < self.open.reach - tube || aside.dot(aside) > tube * tube
    }

    /// Updates the span from the last point to the command, and the span before it, which depends on the direction between
    /// them.
    #[inline(always)]
    fn draw(&mut self, command: [P; 3]) {
        let was_open = self.open.chord.is_some();
        self.open.to = command;
        let way = way(&self.from, &command);
        let length = way.norm();
        if length < self.spacing * R::of(SHORTEST) {
            self.open.chord = None;
            if was_open {
                self.withdraw();
            }
            return;
        }
        let unit = way * (R::ONE / length);
        let joint = self.last.as_ref().and_then(|last| self.joint(last, unit, length));
        let chord = Chord { from: self.from, way, unit, length, start: joint };
        // The window's first span keeps the number of its first point.
        let first = self.last.is_none();
        if !was_open && !first {
            self.number = self.number.wrapping_add(1);
            self.place = if self.place + 1 < K { self.place + 1 } else { 0 };
            self.count = if self.count < K { self.count + 1 } else { K };
            self.cut |= self.count == K;
        }
        self.put(self.place, chord.span(None, self.number, self.plane));
        if let Some(last) = &self.last {
            let span = last.span(joint, self.number.wrapping_sub(1), self.plane);
            self.put(self.before(), span);
        }
        self.open.chord = Some(chord);
        if self.open.heading.is_none() && length >= self.spacing * R::of(DIRECTED) {
            self.open.heading = Some(unit);
        }
        let along = self.open.heading.map_or(R::ZERO, |heading| way.dot(heading));
        self.open.reach = self.open.reach.max(along);
    }

    /// Direction at the last point; `None` at a corner, or if the new span is too short to determine it.
    #[inline(always)]
    fn joint(&self, last: &Chord<R, P>, unit: V3<R>, length: R) -> Option<V3<R>> {
        let (shorter, longer) = if length < last.length { (length, last.length) } else { (last.length, length) };
        let determined = shorter >= self.spacing * R::of(DIRECTED) && shorter * R::of(UNEVEN) >= longer;
        if !determined || last.unit.dot(unit) < R::of(CORNER) {
            return None;
        }
        let direction = last.unit * length + unit * last.length;
        Some(direction * (R::ONE / direction.norm()))
    }

    /// Handles a command that returns to the last point: the previous span becomes the newest again or, without one,
    /// the first point.
    #[cold]
    fn withdraw(&mut self) {
        if self.last.is_none() {
            return self.put(self.place, Span::turning(self.from, self.number, self.plane));
        }
        self.place = self.before();
        self.number = self.number.wrapping_sub(1);
        self.count = self.count.saturating_sub(1);
    }

    #[inline(always)]
    fn before(&self) -> usize {
        if self.place > 0 { self.place - 1 } else { K - 1 }
    }

    #[inline(always)]
    fn put(&mut self, place: usize, span: Span<R, P>) {
        for half in &mut self.spans {
            if let Some(slot) = half.get_mut(place) {
                *slot = span;
            }
        }
    }
}

impl<R: Real, P: Position> Open<R, P> {
    fn at(point: [P; 3]) -> Self {
        Open { to: point, chord: None, heading: None, reach: R::ZERO }
    }
}

impl<R: Real, P: Position> Chord<R, P> {
    /// Forms the cubic. An unknown direction at one end is that of an arc with the known one; if neither is known, the
    /// span is a line.
    #[inline(always)]
    fn span(&self, end: Option<V3<R>>, number: u32, plane: [R; 3]) -> Span<R, P> {
        let mirrored = |t: V3<R>| self.unit * (R::TWO * self.unit.dot(t)) - t;
        let (start, end) = match (self.start, end) {
            (Some(start), Some(end)) => (start, end),
            (Some(start), None) => (start, mirrored(start)),
            (None, Some(end)) => (mirrored(end), end),
            (None, None) => (self.unit, self.unit),
        };
        let speed = R::of(4.0) * self.length / (R::TWO + self.unit.dot(start) + self.unit.dot(end));
        Span::hermite(&self.from, self.way, start * speed, end * speed, number, plane)
    }
}

#[inline(always)]
fn way<R: Real, P: Position>([x, y, z]: &[P; 3], [tx, ty, tz]: &[P; 3]) -> V3<R> {
    V3::new(tx.since_near(*x), ty.since_near(*y), tz.since_near(*z))
}

#[cfg(test)]
mod tests;
