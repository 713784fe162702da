//! Programs shipped with the simulator.

use super::{Program, ProgramError};

/// Names for [`Program::builtin`], the default one first.
pub const BUILTIN_NAMES: [&str; 5] = ["circle-diamond-square", "butterfly", "pocket-3d", "cone-5axis", "short-tour"];

impl Program {
    /// Text of a shipped program; `None` if there is none of that name (see [`BUILTIN_NAMES`]).
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        Some(match name {
            "circle-diamond-square" => include_str!("../../programs/circle-diamond-square.ngc"),
            "butterfly" => include_str!("../../programs/butterfly.ngc"),
            "pocket-3d" => include_str!("../../programs/pocket-3d.ngc"),
            "cone-5axis" => include_str!("../../programs/cone-5axis.ngc"),
            "short-tour" => include_str!("../../programs/short-tour.ngc"),
            _ => return None,
        })
    }

    /// Reads a shipped program; `None` if there is none of that name (see [`BUILTIN_NAMES`]).
    pub fn builtin(name: &str) -> Option<Result<Program, ProgramError>> {
        let text = Program::builtin_text(name)?;
        Some(Program::parse(name, text, &format!("{name}.ngc")))
    }
}
