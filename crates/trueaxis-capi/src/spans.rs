//! The spans of a path in memory that the caller lends.

use crate::Real;
use crate::error::Refusal;
use crate::part::{TOOLPATH, need};
use crate::plugin::{CorePosition, PathSpan};
use crate::result::{ERROR_ARGUMENT, ERROR_PATH, ResultCode};
use crate::steps::{PathStep, path_step};
use trueaxis::contour::{self, PathBuilder, PathError, Segment, ToolPath, Turn};

/// Bytes of lent memory per span of a path. A line takes one span per 16 mm, an arc one per 30°, a spline one or more
/// per knot interval.
#[cfg(not(feature = "single"))]
pub const SPAN_BYTES: usize = 296;
/// Bytes of lent memory per span of a path. A line takes one span per 16 mm, an arc one per 30°, a spline one or more
/// per knot interval.
#[cfg(feature = "single")]
pub const SPAN_BYTES: usize = 168;
/// Bytes of lent memory per span of a tool path.
#[cfg(not(feature = "single"))]
pub const TOOL_SPAN_BYTES: usize = 376;
/// Bytes of lent memory per span of a tool path.
#[cfg(feature = "single")]
pub const TOOL_SPAN_BYTES: usize = 208;

type SpanTurn = Turn<Real>;

const _: () = assert!(size_of::<PathSpan>() <= SPAN_BYTES && align_of::<PathSpan>() <= align_of::<u64>());
const _: () = assert!(size_of::<PathSpan>() + size_of::<SpanTurn>() <= TOOL_SPAN_BYTES);
const _: () = assert!(align_of::<SpanTurn>() <= align_of::<PathSpan>());

/// Course of the tool's direction along the next segment.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Direction {
    /// Positions of A, B, C at start and end, degrees.
    Axes([f64; 3], [f64; 3]),
    /// Directions of the tool at start and end.
    Vectors([f64; 3], [f64; 3]),
}

impl Direction {
    /// `None` for two opposite directions, or for one without length.
    fn turn(&self, span: &PathSpan, domain: [f64; 2]) -> Option<SpanTurn> {
        match *self {
            Direction::Axes(start, end) => Some(Turn::axes(span, domain, start, end)),
            Direction::Vectors(start, end) => Turn::directions(span, domain, start, end),
        }
    }

    /// Whether the tool can turn in this way: directions need a length and must not be opposite.
    pub(crate) fn is_possible(&self) -> bool {
        let (Direction::Axes(start, end) | Direction::Vectors(start, end)) = self;
        let stationary = PathSpan::turning([CorePosition::default(); 3], 0, [0.0, 0.0, 1.0]);
        start.iter().chain(end).all(|x| x.abs() <= 1e9) && self.turn(&stationary, [0.0, 1.0]).is_some()
    }

    fn stays(self) -> Self {
        match self {
            Direction::Axes(_, end) => Direction::Axes(end, end),
            Direction::Vectors(_, end) => Direction::Vectors(end, end),
        }
    }
}

/// Content of a [`crate::Path`].
#[derive(Clone, Copy)]
pub(crate) struct Spans {
    pub(crate) path_step: PathStep,
    spans: *mut PathSpan,
    /// After the spans; null for a path without directions.
    turns: *mut SpanTurn,
    capacity: usize,
    count: usize,
    first: u32,
    builder: PathBuilder<CorePosition>,
    plane: [f64; 3],
    direction: Direction,
    closed: bool,
}

impl Spans {
    /// An empty path in memory of `bytes` bytes.
    pub(crate) fn new(memory: *mut u8, bytes: usize, first: u32, of_tool: bool) -> Self {
        let spans = memory.cast::<PathSpan>();
        let span_bytes = size_of::<PathSpan>() + if of_tool { size_of::<SpanTurn>() } else { 0 };
        let capacity = bytes / span_bytes;
        let turns = if of_tool { spans.wrapping_add(capacity).cast() } else { core::ptr::null_mut() };
        let mut path = Spans {
            path_step,
            spans,
            turns,
            capacity,
            count: 0,
            first,
            builder: PathBuilder::new(),
            plane: [0.0, 0.0, 1.0],
            direction: Direction::Axes([0.0; 3], [0.0; 3]),
            closed: false,
        };
        path.clear();
        path
    }

    pub(crate) fn clear(&mut self) {
        (self.count, self.builder, self.closed) = (0, PathBuilder::new(), false);
        self.builder.set_plane(self.plane);
    }

    pub(crate) fn set_plane(&mut self, normal: [f64; 3]) {
        self.plane = normal;
        self.builder.set_plane(normal);
    }

    /// Whether the spans have directions.
    pub(crate) fn is_of_tool(&self) -> bool {
        need(TOOLPATH).is_ok() && !self.turns.is_null()
    }

    pub(crate) fn set_direction(&mut self, direction: Direction) -> Result<(), ResultCode> {
        if !(self.is_of_tool() && direction.is_possible()) {
            return Err(ERROR_ARGUMENT);
        }
        self.direction = direction;
        Ok(())
    }

    pub(crate) fn segments(&self) -> u32 {
        self.builder.segments()
    }

    #[inline(always)]
    pub(crate) fn spans(&self) -> &[PathSpan] {
        // SAFETY: `count` spans were written there by `append`, and the caller of `trueaxis_path_start` lent the memory.
        unsafe { core::slice::from_raw_parts(self.spans, self.count) }
    }

    #[inline(always)]
    pub(crate) fn path(&self) -> contour::Path<'_, Real, CorePosition> {
        contour::Path::new(self.spans(), self.first, self.closed)
    }

    #[inline(always)]
    pub(crate) fn tool_path(&self) -> ToolPath<'_, Real, CorePosition> {
        let turns: &[SpanTurn] = if self.is_of_tool() {
            // SAFETY: as for the spans.
            unsafe { core::slice::from_raw_parts(self.turns, self.count) }
        } else {
            &[]
        };
        ToolPath::new(self.path(), turns)
    }

    /// Appends the spans of a segment; the path is unchanged if it is refused.
    pub(crate) fn append(&mut self, segment: &Segment<'_>) -> Result<(), Refusal> {
        let domain = match segment {
            Segment::Nurbs { degree, knots, points, .. } => {
                [knots.get(*degree), knots.get(points.len())].map(|knot| knot.copied().unwrap_or_default())
            }
            _ => [0.0, 1.0],
        };
        let Spans { spans, turns, capacity, direction, mut count, .. } = *self;
        let mut full = false;
        let appended = self.builder.append(segment, |span: PathSpan| {
            let of_tool = need(TOOLPATH).is_ok() && !turns.is_null();
            let turn = if of_tool { direction.turn(&span, domain) } else { None };
            if of_tool && turn.is_none() {
                return Err(PathError { field: "direction", index: None, found: f64::NAN, needed: "a turn" });
            }
            if count == capacity {
                full = true;
                return Err(PathError { field: "memory", index: None, found: count as f64, needed: "more spans" });
            }
            // SAFETY: within the lent memory, which is aligned for both.
            unsafe {
                spans.add(count).write(span);
                if let Some(turn) = turn {
                    turns.add(count).write(turn);
                }
            }
            count += 1;
            Ok(())
        });
        if full {
            let each = if self.is_of_tool() { TOOL_SPAN_BYTES } else { SPAN_BYTES };
            return Err(Refusal::Memory(capacity * each, (capacity + 1) * each));
        }
        appended.map_err(Refusal::Path)?;
        (self.count, self.closed, self.direction) = (count, false, direction.stays());
        Ok(())
    }

    pub(crate) fn close(&mut self) -> Result<(), ResultCode> {
        let ([first, ..], [.., last]) = (self.spans(), self.spans()) else { return Err(ERROR_PATH) };
        let squared = first.position(0.0).into_iter().zip(last.position(1.0)).fold(0.0, |sum, (a, b)| {
            let difference: f64 = trueaxis::Position::since(a, b);
            sum + difference * difference
        });
        if squared > contour::JOINED_WITHIN_MM * contour::JOINED_WITHIN_MM {
            return Err(ERROR_PATH);
        }
        self.closed = true;
        Ok(())
    }
}
