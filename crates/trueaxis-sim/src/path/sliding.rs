//! The stretch of a path around the current position.

use super::reference::reference;
use super::spans::add_move;
use crate::error::Result;
use crate::scenario::Scenario;
use std::collections::VecDeque;
use trueaxis::contour::{Path, Reference, Span, ToolPath, Turn};

/// The stretch of a program's path around the reference, converted when the motion reaches it.
///
/// Spans have the same numbers as in the [`PlannedPath`](super::PlannedPath), and the stretch extends as far as the step ever
/// searches, so that the step gives the same results with either.
#[derive(Debug)]
pub struct SlidingPath {
    /// Distance kept behind and ahead, mm.
    reach_mm: f64,
    spans: Vec<Span<f64, f64>>,
    turns: Vec<Turn<f64>>,
    /// Number of leading spans no longer needed; they are removed once they are half of all.
    spent: usize,
    /// The moves kept.
    moves: VecDeque<Held>,
    /// Index of the first move kept.
    first_move: usize,
    /// End of the last move kept.
    end: Held,
}

/// Beginning of a move.
#[derive(Clone, Copy, Debug)]
struct Held {
    /// Number of the move's first span.
    span: u32,
    /// Length of all spans before the move, mm.
    length_mm: f64,
}

impl Held {
    /// Whether the distance from here to `other` is as long as the step can require.
    fn is_far_from(&self, other: &Held, reach_mm: f64) -> bool {
        other.length_mm - self.length_mm >= reach_mm || other.span - self.span >= MOST_AHEAD
    }
}

/// The step searches this many times its largest lag around the reference, plus a margin.
const REACH_PER_LAG: f64 = 4.0;
const REACH_MM: f64 = 10.0;
/// Spans behind and ahead that suffice if they are very short.
const MOST_AHEAD: u32 = 1 << 14;

impl SlidingPath {
    /// Nothing of the path is converted yet.
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

    /// Advances to references in the moves `first` to `last`, neither of them before those of the last call; `scenario` must
    /// be that of [`SlidingPath::new`].
    ///
    /// # Errors
    /// A move that is not a valid path.
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

    /// Beginning of a move, or the end of the last one kept.
    fn beginning(&self, index: usize) -> Option<Held> {
        let slot = index.checked_sub(self.first_move)?;
        if slot == self.moves.len() { Some(self.end) } else { self.moves.get(slot).copied() }
    }

    /// The stretch as the step reads it.
    pub fn view(&self) -> Path<'_, f64, f64> {
        Path::new(self.held(), self.number(), false)
    }

    /// The stretch with its directions, for a program with rotary axes.
    pub fn tool_view(&self) -> ToolPath<'_, f64, f64> {
        ToolPath::new(self.view(), self.turns.get(self.spent..).unwrap_or_default())
    }

    /// As [`PlannedPath::reference`](super::PlannedPath::reference), for a move that is covered.
    pub fn reference(&self, move_index: usize, u: f64, near: &mut u32) -> Reference<f64> {
        let ends = match (self.beginning(move_index), self.beginning(move_index + 1)) {
            (Some(first), Some(end)) => [first.span, end.span.saturating_sub(1)],
            _ => [self.number(); 2],
        };
        reference(self.held(), self.number(), ends, u, near)
    }

    fn held(&self) -> &[Span<f64, f64>] {
        self.spans.get(self.spent..).unwrap_or_default()
    }

    /// Number of the first span kept.
    fn number(&self) -> u32 {
        self.moves.front().map_or(0, |first| first.span)
    }
}
