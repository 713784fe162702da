//! Programs shipped with the simulator.

use super::{Program, ProgramError};

/// Names for [`Program::builtin`], the default one first.
pub const BUILTIN_NAMES: [&str; 6] =
    ["circle-diamond-square", "butterfly", "pocket-3d", "cone-5axis", "s-shape", "short-tour"];

impl Program {
    /// One-line description of a shipped program; `None` if no program has that name.
    pub fn builtin_description(name: &str) -> Option<&'static str> {
        Some(match name {
            "circle-diamond-square" => {
                "circle, diamond, square and turned square in the manner of NAS 979 (ISO 10791-7)"
            }
            "butterfly" => "the butterfly of Hu et al. 2023, a rational spline of 51 control points",
            "pocket-3d" => "a small pocket in space with a helical entry",
            "cone-5axis" => "a tilted cone frustum in the manner of NAS 979 (ISO 10791-7), flank-milled on five axes",
            "s-shape" => {
                "an S-shaped flank in the manner of ISO 10791-7:2020 (its control points are ours), flank-milled on five axes"
            }
            "short-tour" => {
                "lines with corners and reversals, arcs, a helix, a spline and a rapid in some fifteen seconds"
            }
            _ => return None,
        })
    }

    /// Text of a shipped program; `None` if no program has that name (see [`BUILTIN_NAMES`]).
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        Some(match name {
            "circle-diamond-square" => include_str!("../../programs/circle-diamond-square.ngc"),
            "butterfly" => include_str!("../../programs/butterfly.ngc"),
            "pocket-3d" => include_str!("../../programs/pocket-3d.ngc"),
            "cone-5axis" => include_str!("../../programs/cone-5axis.ngc"),
            "s-shape" => include_str!("../../programs/s-shape.ngc"),
            "short-tour" => include_str!("../../programs/short-tour.ngc"),
            _ => return None,
        })
    }

    /// Reads a shipped program; `None` if no program has that name (see [`BUILTIN_NAMES`]).
    pub fn builtin(name: &str) -> Option<Result<Program, ProgramError>> {
        let text = Program::builtin_text(name)?;
        Some(Program::parse(name, text, &format!("{name}.ngc")))
    }
}
