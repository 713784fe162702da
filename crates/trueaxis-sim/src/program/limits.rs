//! Limits of a program's length, checked before memory or time grows with it.

use super::error::Refusal;
use super::{Curve, Move, Program, ProgramError, Turn};

/// Largest file, bytes.
pub const MOST_BYTES: u64 = 256 * 1024 * 1024;

/// Most pieces that a program may have: 8 mm or 30° of a curve, 5° of a rotary axis, at least one per move.
pub const MOST_PIECES: u64 = 2_000_000;

/// Most turns of one arc or helix.
pub const MOST_TURNS: u32 = 1_000;

/// Most servo cycles of a run: 28 hours at 10 kHz.
pub const MOST_CYCLES: f64 = 1.0e9;

const PIECE_MM: f64 = 8.0;
const PIECE_DEG: f64 = 30.0;
const PIECE_TURN_DEG: f64 = 5.0;

/// Number of pieces of a move of the given length (mm).
pub(super) fn pieces(curve: &Curve, turn: &Turn, length: f64) -> u64 {
    let bends = match curve {
        Curve::Line { .. } => 1.0,
        Curve::Arc { turns, .. } => (f64::from(*turns) + 1.0) * 360.0 / PIECE_DEG,
        Curve::Nurbs { points, .. } => points.len() as f64,
    };
    bends.max(length / PIECE_MM).max(turn.angle() / PIECE_TURN_DEG).ceil() as u64
}

impl Program {
    /// Refuses a program whose moves alone take more than [`MOST_CYCLES`] at their speeds, mm/s or deg/s.
    ///
    /// # Errors
    /// The line in which the limit is exceeded.
    pub fn check_duration(&self, rate_hz: f64, speed: impl Fn(&Move) -> f64) -> Result<(), ProgramError> {
        let mut cycles = 0.0;
        for element in &self.moves {
            cycles += element.length() / speed(element) * rate_hz;
            if cycles > MOST_CYCLES {
                let found = format!("a program of more than {:.1} hours by its feeds", cycles / rate_hz / 3600.0);
                let needed = format!(
                    "at most {MOST_CYCLES:e} servo cycles, {:.1} hours at {rate_hz} Hz",
                    MOST_CYCLES / rate_hz / 3600.0
                );
                return Err(Refusal::new(element.line, found, needed).in_file(&self.file));
            }
        }
        Ok(())
    }
}
