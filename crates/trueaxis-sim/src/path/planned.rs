//! The path of a whole program.

use super::reference::reference;
use super::spans::{MOST_SPANS, add_move, too_many_spans};
use crate::error::Result;
use crate::placement::Placement;
use crate::program::Program;
use crate::scenario::Scenario;
use trueaxis::contour::{Path, Reference, Span, ToolPath, Turn};

/// The path of a whole program, converted once.
///
/// In machine coordinates for a program of X, Y, Z alone; otherwise the tip's path in workpiece coordinates.
#[derive(Debug)]
pub struct PlannedPath {
    /// All spans in path order.
    pub spans: Vec<Span<f64, f64>>,
    /// Rotary axes along each span; empty for a program of X, Y, Z alone.
    pub turns: Vec<Turn<f64>>,
    /// First span of every move, and one past the last.
    first: Vec<u32>,
}

impl PlannedPath {
    /// Converts a program whose zero is at `origin_mm` in machine coordinates.
    ///
    /// # Errors
    /// A move that is not a valid path (the program reader refuses those earlier), or more than [`MOST_SPANS`] spans.
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

    /// The path as the step reads it.
    pub fn view(&self) -> Path<'_, f64, f64> {
        Path::new(&self.spans, 0, false)
    }

    /// The path with its directions, for a program with rotary axes.
    pub fn tool_view(&self) -> ToolPath<'_, f64, f64> {
        ToolPath::new(self.view(), &self.turns)
    }

    /// Span and local parameter of a point of the program. `near` carries the span from call to call.
    pub fn reference(&self, move_index: usize, u: f64, near: &mut u32) -> Reference<f64> {
        let (first, last) = match self.first.get(move_index..move_index + 2) {
            Some([first, end]) => (*first, end.saturating_sub(1)),
            _ => (0, 0),
        };
        reference(&self.spans, 0, [first, last], u, near)
    }
}

/// Checks that a whole program is a valid path, before any of it is run.
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
