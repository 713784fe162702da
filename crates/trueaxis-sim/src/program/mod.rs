//! NC programs: G-code in, curves out.
//!
//! The dialect is LinuxCNC's (RS274/NGC), as far as it describes a path of up to six axes: with parameters, expressions, loops
//! and subprograms. The reader executes a word, accepts it with a note because it does not change the path, or refuses it with
//! its line; it skips no word.
//!
//! | words | meaning |
//! |---|---|
//! | G0, G1 | straight line at rapid or programmed feed |
//! | G2, G3 | arc or helix about the centre I J K or with radius R; P: number of turns begun (P1, or none, is at most one) |
//! | A, B, C | with G0 to G3: rotary axes in degrees, in proportion to the parameter of the line or the angle of the arc |
//! | G5, G5.1; G5.2, G5.3 | cubic, quadratic curve; NURBS; in XY: see [`Curve::Nurbs`] |
//! | @, ^ | with G0 to G3: radius and angle instead of X and Y |
//! | G38.2 to G38.5 | probing move: a line at the programmed feed, to where the probe trips on [`ReadOptions::surface`], else to its end; [`crate::calibration`] stops it on a machine with errors |
//! | G73, G81 to G86, G89 | canned cycles, with R P Q L, G98 and G99 |
//! | G17, G18, G19 | plane of the arcs and cycles: XY, ZX, YZ |
//! | G20, G21 | inch, mm |
//! | G90, G91; G90.1, G91.1 | end points; centres: absolute, incremental |
//! | F, G94 | feed per minute along X Y Z, or in degrees if only rotary axes move |
//! | F, G93 | inverse time: the move takes 1/F minutes; F in every line of a feed motion |
//! | G54 to G59.3, G10 L2 L20, G52, G92 to G92.3 | origin of the coordinates: [`Offsets`] |
//! | G53, G28, G30, G28.1, G30.1 | machine coordinates of a line; stored positions |
//! | G43 H, G43.1, G43.2, G49 | tool length: [`ToolTable`] |
//! | G43.4 H, G49 | tool centre point mode on, off: X Y Z are the tip in workpiece coordinates |
//! | G61.1, G4, M0, M1, M6, M60 | the axes come to rest |
//! | G7, G8 | X is a diameter, a radius |
//! | M70 to M73 | modes saved and restored |
//! | `#1`, `#<name>`, `[ ]`, functions | parameters; expressions behind every letter |
//! | O1 sub, call, if, while, do, repeat; M98, M99 | subprograms, also from files ([`ReadOptions::folder`]), and loops |
//! | M2, M30, a second `%` | end; the rest is not read |
//! | `/`, O1234, N | block delete ([`ReadOptions`]), program number, line number |
//! | S, T, M3 to M9, M19, M48 to M53, M61 to M65, M67, M68, G40, G61, G64 P, G96, G97 | no effect on the path: [`Note`] |
//!
//! A program starts at X0 Y0 Z0 A0 B0 C0 of the machine in G17 G21 G49 G90 G91.1 G94 G99, without a feed or a motion mode.
//! Moves are in machine coordinates, which are the program's as long as no offset is active.
//!
//! Without G43.4, X Y Z are positions of the linear axes. With it they are coordinates of the tool tip in a system that turns
//! with the workpiece: the linear axes move so that the tip follows the line or arc while the rotary axes turn. With the
//! rotary axes at zero both are equal, and the mode can be switched only there.

mod arc;
mod block;
mod builder;
mod builtin;
pub mod canonical;
mod curve;
mod cycles;
mod error;
mod expression;
mod files;
mod flow;
mod frame;
mod height_map;
mod interpreter;
mod language;
pub mod limits;
mod modal;
mod modes;
mod moves;
mod notes;
mod numbered;
mod nurbs;
mod nurbs_block;
mod o_word;
mod offsets;
mod options;
mod parameters;
mod places;
mod probing_move;
mod repeated;
mod saved;
mod spline;
mod state;
mod surface;
mod surface_file;
mod text;
mod tool_table;
mod way;
mod words;

use trueaxis::machine::MachineSettings;

pub use builtin::BUILTIN_NAMES;
pub(crate) use curve::Polar;
pub use curve::{Curve, Derivatives};
pub use error::ProgramError;
pub use files::Source;
pub use notes::Note;
pub use numbered::numbered;
pub use nurbs::MAX_DEGREE;
pub use offsets::{Offsets, System};
pub use options::ReadOptions;
pub use repeated::CannotRepeat;
pub use surface::Surface;
pub use tool_table::ToolTable;

use error::Refusal;

/// One programmed element.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Line of the program, from 1 (for a NURBS, the line of G5.3).
    pub line: u32,
    /// Whether it is a positioning move (G0), which has no programmed feed.
    pub rapid: bool,
    /// Programmed feed in mm/min, in deg/min where only rotary axes move; 0 where `rapid`.
    pub feed_per_min: f64,
    /// Unit normal of the plane active at that line: Z for G17, Y for G18, X for G19.
    pub plane_normal: [f64; 3],
    /// The path of X Y Z, mm: of the tool tip where `tool_center`, else of the linear axes; a line from a point to itself
    /// where only rotary axes move.
    pub curve: Curve,
    /// Rotary axes along it.
    pub turn: Turn,
    /// Whether X Y Z are the tool tip in workpiece coordinates.
    pub tool_center: bool,
    /// Whether the axes come to rest at its end: G61.1, or G4, M0, M1, M6, M60 after it, or a probing move.
    pub stop: bool,
    /// Whether it probes towards a surface (G38.2, G38.3). Its end is the trip, or without a surface the programmed end.
    pub probe: bool,
}

/// Letters of the rotary axes, in the order used everywhere.
pub const ROTARY_LETTERS: [char; 3] = ['A', 'B', 'C'];

/// Rotation per length above which a move is measured in degrees.
const DEGREES_PER_MM: f64 = 5.0;

/// Motion of A, B, C along a move: start + f · change, f = 0 to 1 in proportion to the curve's parameter; degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turn {
    /// At the start of the move.
    pub start: [f64; 3],
    /// Change from the start to the end of the move.
    pub change: [f64; 3],
}

impl Turn {
    /// Angles at f, 0 to 1.
    pub fn at(&self, f: f64) -> [f64; 3] {
        std::array::from_fn(|k| self.start[k] + f * self.change[k])
    }

    /// Angles at the end of the move.
    pub fn end(&self) -> [f64; 3] {
        self.at(1.0)
    }

    /// √(ΔA² + ΔB² + ΔC²), the path of the rotary axes in degrees.
    pub fn angle(&self) -> f64 {
        self.change.iter().map(|c| c * c).sum::<f64>().sqrt()
    }
}

impl Move {
    /// Length for planning: mm along the curve, or degrees of the rotary axes' path ([`Move::in_degrees`]).
    pub fn length(&self) -> f64 {
        if self.in_degrees() { self.turn.angle() } else { self.curve.length() }
    }

    /// Whether the move is measured in degrees: only rotary axes move, or they turn by more than 5° per millimetre. In
    /// millimetres, the acceleration of such a move would be too much for them.
    pub fn in_degrees(&self) -> bool {
        // Called in every cycle, and the length of a spline is an integral: the angle is tested first.
        let angle = self.turn.angle();
        angle > 0.0 && angle > DEGREES_PER_MM * self.curve.length()
    }

    /// Feed along [`Move::length`] per minute, if programmed.
    pub fn planned_feed_per_min(&self) -> f64 {
        let along = self.curve.length();
        if self.in_degrees() && along > 0.0 { self.feed_per_min * self.turn.angle() / along } else { self.feed_per_min }
    }

    /// Completed share of the move at parameter u; the rotary axes turn in proportion to it.
    pub fn share(&self, u: f64) -> f64 {
        let (first, last) = self.curve.domain();
        (u - first) / (last - first)
    }

    /// A, B, C at parameter u, degrees.
    pub fn rotary(&self, u: f64) -> [f64; 3] {
        self.turn.at(self.share(u))
    }

    /// Whether the tip's path on the workpiece is [`Move::curve`], there or turned: no rotary axis turns the workpiece during the
    /// move, or the tool centre point follows it.
    pub fn keeps_its_curve(&self) -> bool {
        self.tool_center || self.turn.change == [0.0; 3]
    }

    /// Whether rotary axes move or are away from zero, or the tool centre point is programmed.
    pub fn is_five_axis(&self) -> bool {
        self.tool_center || self.turn != Turn::default()
    }
}

/// Lines in which a program first requires more than three linear axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FirstWords {
    /// First A, B, C word of a motion.
    pub rotary: [Option<u32>; 3],
    /// First G43.4.
    pub tool_center: Option<u32>,
}

/// A program as a sequence of connected curves: each move starts where the previous one ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// Name for reports.
    pub name: String,
    /// File that the program was read from; appears in errors.
    pub file: String,
    /// The moves in order, without those of zero length.
    pub moves: Vec<Move>,
    /// Words accepted without effect, once per kind.
    pub notes: Vec<Note>,
    /// Lines in which the program first needs rotary axes.
    pub first: FirstWords,
}

impl Program {
    /// Reads a program without offsets and tools; `file` appears in errors only.
    ///
    /// # Errors
    /// As [`Program::read`].
    pub fn parse(name: &str, text: &str, file: &str) -> Result<Program, ProgramError> {
        Program::read(name, text.as_bytes(), file, &ReadOptions::default())
    }

    /// Reads a program: UTF-8 or Latin-1, with or without a byte order mark, any line endings; `file` appears in errors only.
    ///
    /// # Errors
    /// Text that is not understood, or a program beyond the [`limits`]; with its line.
    pub fn read(name: &str, bytes: &[u8], file: &str, options: &ReadOptions) -> Result<Program, ProgramError> {
        Program::read_within(name, bytes, file, options, limits::MOST_PIECES)
    }

    /// Like [`Program::read`], for a program of at most `most_pieces` pieces ([`limits::MOST_PIECES`]).
    ///
    /// # Errors
    /// As [`Program::read`].
    pub fn read_within(
        name: &str,
        bytes: &[u8],
        file: &str,
        options: &ReadOptions,
        most_pieces: u64,
    ) -> Result<Program, ProgramError> {
        Ok(Program::of(name, file, flow::read(bytes, file, options, most_pieces)?))
    }

    fn of(name: &str, file: &str, builder: builder::Builder) -> Program {
        let notes = builder.notes.into_vec();
        Program { name: name.to_owned(), file: file.to_owned(), moves: builder.moves, notes, first: builder.first }
    }

    /// Length of the whole path: mm, or degrees in moves measured in degrees ([`Move::in_degrees`]).
    pub fn length(&self) -> f64 {
        self.moves.iter().map(Move::length).sum()
    }

    /// Whether rotary axes or the tool centre point are programmed at all.
    pub fn is_five_axis(&self) -> bool {
        self.moves.iter().any(Move::is_five_axis)
    }

    /// Refuses a program that needs axes that `machine` does not have.
    ///
    /// # Errors
    /// A word for a rotary axis that the machine does not have; G43.4 without X, Y, Z and a rotary axis.
    pub fn check_axes(&self, machine: &MachineSettings) -> Result<(), ProgramError> {
        let has = |letter| machine.axes.iter().any(|a| a.axis.letter() == letter);
        let axes = || machine.axes.iter().map(|a| a.axis.letter().to_string()).collect::<Vec<_>>().join(", ");
        for (letter, line) in ROTARY_LETTERS.into_iter().zip(self.first.rotary) {
            if let Some(line) = line.filter(|_| !has(letter)) {
                let needed = format!("an axis of {}: {}", machine.name, axes());
                return Err(Refusal::new(line, format!("a word of axis {letter}"), needed).in_file(&self.file));
            }
        }
        let able = ['X', 'Y', 'Z'].into_iter().all(has) && ROTARY_LETTERS.into_iter().any(has);
        if let Some(line) = self.first.tool_center.filter(|_| !able) {
            let needed = format!("a machine with X, Y, Z and a rotary axis; {} has {}", machine.name, axes());
            return Err(Refusal::new(line, "G43.4", needed).in_file(&self.file));
        }
        Ok(())
    }
}
