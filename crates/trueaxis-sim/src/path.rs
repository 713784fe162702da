//! The program as the plugin's path: spans, and where on them the interpolator is.

use crate::error::{Result, SimError};
use crate::placement::Placement;
use crate::program::{Curve, Move, Program};
use crate::scenario::Scenario;
use glam::DVec3;
use std::collections::VecDeque;
use trueaxis::contour::{Path, Reference, Segment, Span, ToolPath, Turn, convert, span_count};

/// Largest distance of a cubic piece from the curve that the tip describes, at the same parameter, mm.
const TOLERANCE_MM: f64 = 1.0e-6;
/// Most pieces of a program.
pub const MOST_SPANS: usize = 50_000_000;
/// A move is halved at most this often.
const DEEPEST_HALVING: u32 = 16;

/// The path of a whole program, converted once.
///
/// A program of X, Y, Z alone: in machine coordinates. One with rotary axes: the tip in workpiece coordinates.
#[derive(Debug)]
pub struct PlannedPath {
    /// All spans in path order.
    pub spans: Vec<Span<f64, f64>>,
    /// Rotary axes along each span; none for a program of X, Y, Z alone.
    pub turns: Vec<Turn<f64>>,
    /// First span of every move, and one past the last.
    first: Vec<u32>,
}

impl PlannedPath {
    /// Converts a program whose zero lies at `origin_mm` in machine coordinates.
    ///
    /// # Errors
    /// A move that is no path (the program reader refuses those before), more than [`MOST_SPANS`] pieces.
    pub fn new(program: &Program, origin_mm: [f64; 3], machine: &Placement) -> Result<PlannedPath> {
        let five_axis = program.is_five_axis();
        let mut path = PlannedPath { spans: Vec::new(), turns: Vec::new(), first: Vec::new() };
        for (index, step) in program.moves.iter().enumerate() {
            path.first.push(path.spans.len() as u32);
            add_move(program, (index, step), origin_mm, machine, five_axis, (&mut path.spans, &mut path.turns))?;
            if path.spans.len() > MOST_SPANS {
                return Err(too_many_spans(program, step));
            }
        }
        path.first.push(path.spans.len() as u32);
        Ok(path)
    }

    /// The path as the step takes it.
    pub fn view(&self) -> Path<'_, f64, f64> {
        Path::new(&self.spans, 0, false)
    }

    /// The path with its directions, for a program with rotary axes.
    pub fn tool_view(&self) -> ToolPath<'_, f64, f64> {
        ToolPath::new(self.view(), &self.turns)
    }

    /// Span and local parameter of a place in the program. `near` carries the span from call to call.
    pub fn reference(&self, move_index: usize, u: f64, near: &mut u32) -> Reference<f64> {
        let (first, last) = match self.first.get(move_index..move_index + 2) {
            Some([first, end]) => (*first, end.saturating_sub(1)),
            _ => (0, 0),
        };
        place(&self.spans, 0, [first, last], u, near)
    }
}

/// Whether a whole program is a path, before anything of it is run.
///
/// # Errors
/// As [`PlannedPath::new`].
pub fn check(scenario: &Scenario) -> Result<()> {
    let (mut spans, mut turns, mut count) = (Vec::new(), Vec::new(), 0);
    for place @ (_, step) in scenario.program.moves.iter().enumerate() {
        spans.clear();
        turns.clear();
        let into = (&mut spans, &mut turns);
        add_move(&scenario.program, place, scenario.origin_mm, &scenario.placement, scenario.five_axis, into)?;
        count += spans.len();
        if count > MOST_SPANS {
            return Err(too_many_spans(&scenario.program, step));
        }
    }
    Ok(())
}

/// The stretch of a program's path around the place where it is run, converted when the motion comes to it.
///
/// Its pieces have the numbers that they have in the [`PlannedPath`], and it reaches as far as the step ever looks, so that
/// the step gives the same with either.
#[derive(Debug)]
pub struct SlidingPath {
    /// Way that is kept behind and ahead, mm.
    reach_mm: f64,
    spans: Vec<Span<f64, f64>>,
    turns: Vec<Turn<f64>>,
    /// So many of the first spans are not needed any more; they are taken out when they are half of all.
    spent: usize,
    /// The moves held.
    moves: VecDeque<Held>,
    /// Index of the first of them.
    first_move: usize,
    /// Where the last of them ends.
    end: Held,
}

/// Where a move begins.
#[derive(Clone, Copy, Debug)]
struct Held {
    /// Number of its first span.
    span: u32,
    /// Length of all spans before it, mm.
    length_mm: f64,
}

impl Held {
    /// Whether the stretch from here to `other` is as long as the step can ask for.
    fn is_far_from(&self, other: &Held, reach_mm: f64) -> bool {
        other.length_mm - self.length_mm >= reach_mm || other.span - self.span >= MOST_AHEAD
    }
}

/// The search of the step looks this many times its largest lag around the reference, and a little.
const REACH_PER_LAG: f64 = 4.0;
const REACH_MM: f64 = 10.0;
/// Spans behind and ahead that are enough where they are very short.
const MOST_AHEAD: u32 = 1 << 14;

impl SlidingPath {
    /// Nothing of the path yet.
    pub fn new(scenario: &Scenario) -> SlidingPath {
        SlidingPath {
            reach_mm: REACH_MM + REACH_PER_LAG * scenario.machine.settings.contour.max_lag_mm,
            spans: Vec::new(),
            turns: Vec::new(),
            spent: 0,
            moves: VecDeque::new(),
            first_move: 0,
            end: Held { span: 0, length_mm: 0.0 },
        }
    }

    /// Moves on to where references lie in the moves `first` to `last`, neither of them before those of the last call;
    /// `scenario` is that of [`SlidingPath::new`].
    ///
    /// # Errors
    /// A move that is no path.
    pub fn cover(&mut self, scenario: &Scenario, [first, last]: [usize; 2]) -> Result<()> {
        while !self.beginning(last + 1).is_some_and(|at| at.is_far_from(&self.end, self.reach_mm)) {
            let index = self.first_move + self.moves.len();
            let Some(step) = scenario.program.moves.get(index) else { break };
            self.moves.push_back(self.end);
            let before = self.spans.len();
            let Scenario { program, placement, five_axis, origin_mm, .. } = scenario;
            let into = (&mut self.spans, &mut self.turns);
            add_move(program, (index, step), *origin_mm, placement, *five_axis, into)?;
            let added = self.spans.get(before..).unwrap_or_default();
            self.end.span += added.len() as u32;
            self.end.length_mm += added.iter().map(Span::length).sum::<f64>();
        }
        while let (Some(second), Some(here)) = (self.moves.get(1), self.beginning(first))
            && self.first_move < first
            && second.is_far_from(&here, self.reach_mm)
        {
            self.spent += (second.span - self.moves[0].span) as usize;
            self.moves.pop_front();
            self.first_move += 1;
        }
        if 2 * self.spent > self.spans.len() {
            self.spans.drain(..self.spent);
            self.turns.drain(..self.spent.min(self.turns.len()));
            self.spent = 0;
        }
        Ok(())
    }

    /// Where a move begins, or the last one held ends.
    fn beginning(&self, index: usize) -> Option<Held> {
        let place = index.checked_sub(self.first_move)?;
        if place == self.moves.len() { Some(self.end) } else { self.moves.get(place).copied() }
    }

    /// The stretch as the step takes it.
    pub fn view(&self) -> Path<'_, f64, f64> {
        Path::new(self.held(), self.number(), false)
    }

    /// The stretch with its directions, for a program with rotary axes.
    pub fn tool_view(&self) -> ToolPath<'_, f64, f64> {
        ToolPath::new(self.view(), self.turns.get(self.spent..).unwrap_or_default())
    }

    /// As [`PlannedPath::reference`], in a move that is covered.
    pub fn reference(&self, move_index: usize, u: f64, near: &mut u32) -> Reference<f64> {
        let ends = match (self.beginning(move_index), self.beginning(move_index + 1)) {
            (Some(first), Some(end)) => [first.span, end.span.saturating_sub(1)],
            _ => [self.number(); 2],
        };
        place(self.held(), self.number(), ends, u, near)
    }

    fn held(&self) -> &[Span<f64, f64>] {
        self.spans.get(self.spent..).unwrap_or_default()
    }

    /// Number of the first span held.
    fn number(&self) -> u32 {
        self.moves.front().map_or(0, |first| first.span)
    }
}

/// Appends the spans of a move, and what its rotary axes do along them.
fn add_move(
    program: &Program,
    (index, step): (usize, &Move),
    origin_mm: [f64; 3],
    machine: &Placement,
    five_axis: bool,
    (spans, turns): (&mut Vec<Span<f64, f64>>, &mut Vec<Turn<f64>>),
) -> Result<()> {
    let first = spans.len();
    let mut add = |segment: &Segment<'_>| {
        // Before there is any: what is too much is refused without having been held.
        span_count(segment)
            .and_then(|_| {
                convert(segment, index as u32, step.plane_normal, |span| {
                    spans.push(span);
                    Ok(())
                })
            })
            .map_err(|error| SimError::Path { program: program.name.clone(), line: step.line, error })
    };
    if !five_axis {
        return programmed(step, origin_mm, &mut add);
    }
    tip_path(step, machine, &mut add)?;
    let (begin, end) = step.curve.domain();
    let turn = |span: &Span<f64, f64>| Turn::axes(span, [begin, end], step.turn.start, step.turn.end());
    turns.extend(spans.iter().skip(first).map(turn));
    Ok(())
}

fn too_many_spans(program: &Program, step: &Move) -> SimError {
    SimError::Line {
        program: program.name.clone(),
        line: step.line,
        found: format!("found more than {MOST_SPANS} pieces of path up to here"),
        needed: "at most so many".into(),
    }
}

/// The place at parameter `u` of a move whose first and last span have the given numbers; `spans` begins with `number`.
fn place(spans: &[Span<f64, f64>], number: u32, [first, last]: [u32; 2], u: f64, near: &mut u32) -> Reference<f64> {
    *near = (*near).clamp(first, last);
    let at = |near: u32| spans.get((near - number) as usize);
    while *near < last && at(*near).is_some_and(|span| span.u_range()[1] < u) {
        *near += 1;
    }
    while *near > first && at(*near).is_some_and(|span| span.u_range()[0] > u) {
        *near -= 1;
    }
    Reference { span: *near, t: at(*near).map_or(0.0, |span| span.t_of(u)) }
}

/// The programmed curve itself, shifted.
fn programmed(step: &Move, shift_mm: [f64; 3], add: &mut impl FnMut(&Segment<'_>) -> Result<()>) -> Result<()> {
    let shift = |p: &[f64; 3]| std::array::from_fn(|k| p[k] + shift_mm[k]);
    match &step.curve {
        Curve::Line { start, end } => add(&Segment::Line { start: shift(start), end: shift(end) }),
        Curve::Arc { start, end, center, normal, turns } => add(&Segment::Arc {
            start: shift(start),
            end: shift(end),
            center: shift(center),
            normal: *normal,
            turns: *turns,
        }),
        Curve::Nurbs { degree, knots, points, weights } => {
            let shifted: Vec<[f64; 3]> = points.iter().map(shift).collect();
            add(&Segment::Nurbs { degree: *degree, knots, points: &shifted, weights })
        }
    }
}

/// The way of the tip in workpiece coordinates: what is programmed there as it is, everything else as cubics with parameter u.
fn tip_path(step: &Move, machine: &Placement, add: &mut impl FnMut(&Segment<'_>) -> Result<()>) -> Result<()> {
    let (first, last) = step.curve.domain();
    let standing = Segment::Turning { point: machine.place(step, first).tip.to_array() };
    if step.tool_center {
        let moves = step.curve.length() > 0.0;
        return if moves { programmed(step, machine.zero().to_array(), add) } else { add(&standing) };
    }
    if let (Curve::Line { .. }, [0.0, 0.0, 0.0]) = (&step.curve, step.turn.change) {
        let [start, end] = [first, last].map(|u| machine.place(step, u).tip.to_array());
        return add(&Segment::Line { start, end });
    }
    let mut any = false;
    for piece in step.curve.breaks().windows(2) {
        any |= add_cubics(step, machine, [piece[0], piece[1]], DEEPEST_HALVING, add)?;
    }
    if any { Ok(()) } else { add(&standing) }
}

/// Whether there was anything to add.
fn add_cubics(
    step: &Move,
    machine: &Placement,
    [a, b]: [f64; 2],
    depth: u32,
    add: &mut impl FnMut(&Segment<'_>) -> Result<()>,
) -> Result<bool> {
    let third = (b - a) / 3.0;
    // At a knot, the derivative of the piece inside.
    let inside = 1.0e-9 * (b - a);
    let (p, q) = (machine.place(step, a).tip, machine.place(step, b).tip);
    let points =
        [p, p + third * machine.tip_velocity(step, a + inside), q - third * machine.tip_velocity(step, b - inside), q];
    let off = (1..8).any(|i| {
        let t = f64::from(i) / 8.0;
        machine.place(step, a + t * (b - a)).tip.distance(bezier(&points, t)) > TOLERANCE_MM
    });
    if off && depth > 0 {
        let middle = 0.5 * (a + b);
        let before = add_cubics(step, machine, [a, middle], depth - 1, add)?;
        return Ok(add_cubics(step, machine, [middle, b], depth - 1, add)? || before);
    }
    if points.iter().all(|point| point.distance(p) < TOLERANCE_MM) {
        return Ok(false);
    }
    let points = points.map(|point| point.to_array());
    add(&Segment::Nurbs { degree: 3, knots: &[a, a, a, a, b, b, b, b], points: &points, weights: &[] })?;
    Ok(true)
}

fn bezier(points: &[DVec3; 4], t: f64) -> DVec3 {
    let s = 1.0 - t;
    let [p, q, r, e] = points;
    *p * (s * s * s) + *q * (3.0 * s * s * t) + *r * (3.0 * s * t * t) + *e * (t * t * t)
}
