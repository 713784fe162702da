//! NC programs: G-code in, curves out.
//!
//! The dialect is LinuxCNC's (RS274/NGC), the part of it that describes a path of three linear axes. A word is either
//! understood, or accepted with a note because it does not change the path, or an error with its line; none is skipped.
//!
//! | words | meaning |
//! |---|---|
//! | G0, G1 | straight line at rapid or programmed feed |
//! | G2, G3 | arc or helix about the centre I J K or with radius R; P: number of turns begun (P1, or none, is at most one) |
//! | G5.2, G5.3 | NURBS in XY: see [`Curve::Nurbs`] |
//! | G17, G18, G19 | plane of the arcs: XY, ZX, YZ |
//! | G20, G21 | inch, mm |
//! | G90, G91; G90.1, G91.1 | end points; centres: absolute, incremental |
//! | F, G94 | feed per minute |
//! | M2, M30, `%` | end, delimiter |
//! | N, S, T, M3–M9, G40, G49, G54, G61, G64 P, G80 | no effect on the path (G80 ends the motion mode) |
//!
//! A program starts at X0 Y0 Z0 in G17 G21 G90 G91.1 G94, without feed and without a motion mode.

mod arc;
mod builtin;
mod curve;
mod error;
mod interpreter;
mod nurbs;
mod nurbs_block;
mod words;

use std::path::Path;

pub use builtin::BUILTIN_NAMES;
pub use curve::{Curve, Derivatives};
pub use error::ProgramError;
pub use nurbs::MAX_DEGREE;

/// One programmed element.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Line of the program, from 1 (for a NURBS, the line of G5.3).
    pub line: u32,
    /// Whether it is a positioning move (G0), which has no programmed feed.
    pub rapid: bool,
    /// Programmed feed in mm/min; 0 where `rapid`.
    pub feed_mm_per_min: f64,
    /// Unit normal of the plane active at that line: Z for G17, Y for G18, X for G19.
    pub plane_normal: [f64; 3],
    /// The path, mm.
    pub curve: Curve,
}

/// A word that was accepted although it does nothing here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// Line, from 1.
    pub line: u32,
    /// The word and why it changes nothing.
    pub text: String,
}

/// A program as a sequence of connected curves: each move starts where the one before ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// Name for reports.
    pub name: String,
    /// The moves in order; moves without length are left out.
    pub moves: Vec<Move>,
    /// Words accepted without effect.
    pub notes: Vec<Note>,
}

impl Program {
    /// Reads a program; `file` appears in errors only.
    pub fn parse(name: &str, text: &str, file: &Path) -> Result<Program, ProgramError> {
        let mut interpreter = interpreter::Interpreter::default();
        let mut last = 0;
        for (line, text) in (1_u32..).zip(text.lines()) {
            last = line;
            words::read_line(line, text)
                .and_then(|block| interpreter.run(&block))
                .map_err(|refusal| refusal.in_file(file))?;
        }
        let (moves, notes) = interpreter.finish(last).map_err(|refusal| refusal.in_file(file))?;
        Ok(Program { name: name.to_owned(), moves, notes })
    }

    /// Length of the whole path in mm.
    pub fn length(&self) -> f64 {
        self.moves.iter().map(|m| m.curve.length()).sum()
    }
}
