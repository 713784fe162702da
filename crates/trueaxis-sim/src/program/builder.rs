//! Collects the moves of a program, in machine coordinates, within the limits of length.

use super::curve::Curve;
use super::error::Refusal;
use super::limits;
use super::notes::Notes;
use super::{FirstWords, Move, Turn};

/// Shorter moves are dropped, mm or degrees: they are residues of adding and subtracting offsets.
const SHORTEST: f64 = 1.0e-9;

/// Speed of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pace {
    Rapid,
    /// Feed per minute: mm for lengths, degrees for angles.
    PerMinute {
        mm: f64,
        degrees: f64,
    },
    /// Inverse of the duration in minutes.
    InverseTime(f64),
}

/// Moves so far, and the position they end at.
#[derive(Debug)]
pub(super) struct Builder {
    /// X Y Z A B C of the machine, mm and degrees.
    pub(super) at: [f64; 6],
    pub(super) tool_center: bool,
    pub(super) moves: Vec<Move>,
    pub(super) notes: Notes,
    pub(super) first: FirstWords,
    pieces: u64,
    strokes: f64,
    most_pieces: u64,
    /// Whether the program was refused because it is too long.
    pub(super) full: bool,
}

impl Builder {
    /// An empty builder for at most `most_pieces` pieces.
    pub(super) fn new(most_pieces: u64) -> Builder {
        Builder {
            at: [0.0; 6],
            tool_center: false,
            moves: Vec::new(),
            notes: Notes::default(),
            first: FirstWords::default(),
            pieces: 0,
            strokes: 0.0,
            most_pieces,
            full: false,
        }
    }

    /// X Y Z.
    pub(super) fn point(&self) -> [f64; 3] {
        let [x, y, z, ..] = self.at;
        [x, y, z]
    }

    /// Turn of the rotary axes to `angles` (A B C).
    pub(super) fn turn_to(&self, angles: [f64; 3]) -> Turn {
        let [.., a, b, c] = self.at;
        let start = [a, b, c];
        Turn { start, change: std::array::from_fn(|k| angles[k] - start[k]) }
    }

    /// Adds a straight line to a position; returns whether it was long enough to count.
    pub(super) fn line_to(
        &mut self,
        line: u32,
        pace: Pace,
        end: [f64; 6],
        plane_normal: [f64; 3],
    ) -> Result<bool, Refusal> {
        let [x, y, z, a, b, c] = end;
        let turn = self.turn_to([a, b, c]);
        self.push(line, pace, Curve::Line { start: self.point(), end: [x, y, z] }, turn, plane_normal)
    }

    /// Appends a move and goes to its end; returns whether it was long enough to count.
    pub(super) fn push(
        &mut self,
        line: u32,
        pace: Pace,
        curve: Curve,
        turn: Turn,
        plane_normal: [f64; 3],
    ) -> Result<bool, Refusal> {
        let (length, angle) = (curve.length(), turn.angle());
        if length < SHORTEST && angle < SHORTEST {
            return Ok(false);
        }
        self.pieces += limits::pieces(&curve, &turn, length);
        if self.pieces > self.most_pieces {
            self.full = true;
            let needed = format!("at most {} (8 mm or 30° of a curve, 5° of a rotary axis each)", self.most_pieces);
            return Err(Refusal::new(line, format!("a program of {} pieces up to here", self.pieces), needed));
        }
        let [x, y, z] = match &curve {
            Curve::Line { end, .. } | Curve::Arc { end, .. } => *end,
            Curve::Nurbs { points, .. } => points.last().copied().unwrap_or_default(),
        };
        let [a, b, c] = turn.end();
        self.at = [x, y, z, a, b, c];
        let along = length >= SHORTEST;
        let feed_per_min = match pace {
            Pace::Rapid => 0.0,
            Pace::PerMinute { mm, degrees } => {
                if along {
                    mm
                } else {
                    degrees
                }
            }
            Pace::InverseTime(number) => number * if along { length } else { angle },
        };
        let rapid = pace == Pace::Rapid;
        let tool_center = self.tool_center;
        self.moves.push(Move {
            line,
            rapid,
            feed_per_min,
            plane_normal,
            curve,
            turn,
            tool_center,
            stop: false,
            probe: false,
        });
        Ok(true)
    }

    /// Counts the strokes of a line of canned cycles before making any, because strokes without length add no piece of path
    /// but take time.
    pub(super) fn count_strokes(&mut self, line: u32, strokes: f64) -> Result<(), Refusal> {
        self.strokes += strokes;
        if self.strokes > self.most_pieces as f64 {
            self.full = true;
            let needed = format!("at most {}", self.most_pieces);
            return Err(Refusal::new(line, format!("{:.0} strokes of canned cycles up to here", self.strokes), needed));
        }
        Ok(())
    }

    /// Marks the last move as a probing move.
    pub(super) fn probe(&mut self) {
        if let Some(last) = self.moves.last_mut() {
            (last.probe, last.stop) = (true, true);
        }
    }

    /// Makes the axes come to rest at the end of the last move.
    pub(super) fn stop(&mut self) {
        if let Some(last) = self.moves.last_mut() {
            last.stop = true;
        }
    }
}
