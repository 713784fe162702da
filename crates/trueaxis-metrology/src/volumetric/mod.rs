//! The 21 errors of three linear axes from points that an instrument measured all over the volume.
//!
//! Every error E_ci of axis i is a chain of straight lines over nodes q_1 < … < q_n; an observation at the position q reads
//!
//! ```text
//! d = Σ_i Σ_c E_ci(q_i) r_ci + Σ squareness + t + ρ × p + o_tool
//! ```
//!
//! r_ci is what one unit of the error makes of the tip there (a unit vector of a translation, a lever arm of a rotation), given by
//! the caller's model of the machine; t and ρ are where the instrument stands and how it is turned, o_tool what the offset of every
//! reflector but the first is off. All are unknowns of one least-squares fit.
//!
//! **Conventions.** A constant of any error, and the slopes of straightness, cannot be told from t, ρ, squareness and one another. They are
//! fixed by as many conditions as there are such freedoms, which changes no residual: every error is zero at the reference position,
//! and straightnesses have no slope (least squares over their nodes), so that squareness stands apart and X is the first axis.
//!
//! **Unseen.** A rotation whose lever does not vary with anything but its own axis' position moves the tip as a translation of that
//! axis does. It is left at zero; the translation holds it, for that tool.
//!
//! **Smoothing.** Second differences of neighbouring nodes are zero with a thousandth of the weight of a reading: it binds nodes that no
//! point touches, and moves the others by a millionth of their standard error.
//!
//! Sources: ISO 230-1:2012 (names and signs), ISO/TR 16907:2015 (numerical compensation), K. Umetsu et al., Precis. Eng. 29 (2005) 425 and
//! H. Schwenke et al., CIRP Annals 57 (2008) 660 (errors from multilateration).

mod design;
mod solve;

pub use solve::fit;

use core::fmt;
use std::string::String;
use std::vec::Vec;

/// Letters of the linear axes.
pub const AXES: [char; 3] = ['X', 'Y', 'Z'];
/// Letters of the components of a twist.
pub const COMPONENTS: [char; 6] = ['X', 'Y', 'Z', 'A', 'B', 'C'];
/// Weight of a second difference against that of a reading.
pub const SMOOTHING: f64 = 1e-3;
/// Lever below which a rotation does not move the tip, mm.
pub const LEAST_LEVER_MM: f64 = 1e-3;

/// A measured point.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Commanded position, mm.
    pub position_mm: [f64; 3],
    /// Actual less commanded position, mm.
    pub deviation_mm: [f64; 3],
    /// Standard deviation of a coordinate, mm; relative to the others'.
    pub sigma_mm: f64,
    /// Which reflector offset it was measured with, from 0.
    pub tool: usize,
    /// Tip error for one unit (mm, rad) of each of the six errors of X, Y, Z there, mm.
    pub responses: [[[f64; 3]; 6]; 3],
    /// Tip error for one unit (rad) of A0Z, B0Z, C0Y there, mm.
    pub squareness: [[f64; 3]; 3],
}

/// What is fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    /// Nodes of every axis, mm, increasing, at least two.
    pub nodes_mm: [Vec<f64>; 3],
    /// Where the errors are zero, mm.
    pub reference_mm: [f64; 3],
    /// Which rotations the points see, by axis and component (translations always true).
    pub seen: [[bool; 6]; 3],
    /// Reflector offsets.
    pub tools: usize,
    /// A length for scaling rotations, mm.
    pub length_mm: f64,
}

/// What was found. mm and rad.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Found {
    /// By axis, component and node.
    pub errors: [[Vec<f64>; 6]; 3],
    /// Their standard errors.
    pub standard_errors: [[Vec<f64>; 6]; 3],
    /// A0Z, B0Z, C0Y, rad.
    pub squareness: [f64; 3],
    /// Their standard errors, rad.
    pub squareness_errors: [f64; 3],
    /// Shift of the instrument, mm, and its turn, rad.
    pub placement: [f64; 6],
    /// What the reflector offsets are off, from the second, mm.
    pub offsets_mm: Vec<[f64; 3]>,
    /// What is left of every observation, mm.
    pub left_mm: Vec<[f64; 3]>,
    /// Standard deviation of a coordinate of unit weight, times its own `sigma_mm` that of a coordinate.
    pub sigma: f64,
    /// Coordinates less determined unknowns.
    pub degrees_of_freedom: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Conditions that fix what no point tells.
    pub conventions: usize,
    /// Rank, with the conditions: all unknowns.
    pub rank: usize,
    /// Condition number of the scaled columns.
    pub condition: f64,
}

/// Why points do not determine the errors.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Refused {
    /// More unknowns than coordinates.
    TooFew {
        /// Coordinates, three a point.
        found: usize,
        /// Unknowns that they have to determine.
        needed: usize,
    },
    /// Errors that cannot be told apart.
    Indistinct {
        /// Their names.
        names: Vec<String>,
        /// Rank of the fit.
        rank: usize,
        /// Unknowns.
        unknowns: usize,
    },
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refused::TooFew { found, needed } => {
                write!(f, "found {found} coordinates for {needed} unknowns, needed more points or fewer nodes")
            }
            Refused::Indistinct { names, rank, unknowns } => write!(
                f,
                "found points that cannot tell apart {} (rank {rank} of {unknowns}), needed points all over the volume, not on lines \
                 or planes only, or these errors left out",
                names.join(", ")
            ),
        }
    }
}

impl core::error::Error for Refused {}
