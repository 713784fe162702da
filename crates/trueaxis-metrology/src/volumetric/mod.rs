//! The 21 errors of three linear axes from points measured throughout the volume.
//!
//! Each error E_ci of axis i is piecewise linear over nodes q_1 < … < q_n; an observation at the position q reads
//!
//! ```text
//! d = Σ_i Σ_c E_ci(q_i) r_ci + Σ squareness + t + ρ × p + o_tool
//! ```
//!
//! r_ci is the tip's response to one unit of the error there (a unit vector for a translation, a lever arm for a rotation),
//! from the caller's model of the machine; t and ρ are the instrument's shift and rotation, o_tool is the offset error of each
//! reflector except the first. All of these are unknowns of one least-squares fit.
//!
//! **Conventions.** Constants of the errors and slopes of straightness are inseparable from t, ρ, squareness and one another.
//! The fit therefore adds one condition per such freedom, which changes no residual: every error is zero at the reference
//! position, and straightnesses have no slope (least squares over their nodes), so that squareness is a separate term and X is
//! the primary axis. Conditions are exact and add nothing to the standard errors: those of an error are zero at the reference.
//!
//! **Unobserved.** A rotation whose lever varies only with its own axis' position moves the tip as a translation of that axis
//! does. The fit leaves it at zero; the translation includes its effect, for that tool.
//!
//! **Smoothing.** The fit adds second differences of neighbouring nodes as observations of zero with a thousandth of a
//! reading's weight: they constrain nodes that no point determines, and move the others by a millionth of their standard
//! error.
//!
//! Sources: ISO 230-1:2012 (names and signs), ISO/TR 16907:2015 (numerical compensation), K. Umetsu et al., Precis. Eng. 29
//! (2005) 425 and H. Schwenke et al., CIRP Annals 57 (2008) 660 (errors from multilateration).

mod design;
mod solve;

pub use design::hats;
pub use solve::fit;

use core::fmt;
use std::string::String;
use std::vec::Vec;

/// Letters of the linear axes.
pub const AXES: [char; 3] = ['X', 'Y', 'Z'];
/// Letters of the components of a twist.
pub const COMPONENTS: [char; 6] = ['X', 'Y', 'Z', 'A', 'B', 'C'];
/// Weight of a second difference relative to a reading.
pub const SMOOTHING: f64 = 1e-3;
/// Lever below which a rotation counts as not moving the tip, mm.
pub const LEAST_LEVER_MM: f64 = 1e-3;

/// A measured point.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Commanded position, mm.
    pub position_mm: [f64; 3],
    /// Actual − commanded position, mm.
    pub deviation_mm: [f64; 3],
    /// Standard deviation of a coordinate, mm, relative to the others'.
    pub sigma_mm: f64,
    /// Index of the reflector offset used, from 0.
    pub tool: usize,
    /// Tip error at this position per unit (mm, rad) of each of the six errors of X, Y, Z, mm.
    pub responses: [[[f64; 3]; 6]; 3],
    /// Tip error at this position per unit (rad) of A0Z, B0Z, C0Y, mm.
    pub squareness: [[f64; 3]; 3],
}

/// Basis of the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    /// Nodes of each axis, mm, increasing, at least two.
    pub nodes_mm: [Vec<f64>; 3],
    /// Position at which the errors are zero, mm.
    pub reference_mm: [f64; 3],
    /// Which rotations the points observe, by axis and component (translations always true).
    pub seen: [[bool; 6]; 3],
    /// Number of reflector offsets.
    pub tools: usize,
    /// Length for scaling rotations, mm.
    pub length_mm: f64,
}

/// Result of the fit, mm and rad.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct VolumetricFit {
    /// Errors by axis, component and node.
    pub errors: [[Vec<f64>; 6]; 3],
    /// Standard errors of `errors`.
    pub standard_errors: [[Vec<f64>; 6]; 3],
    /// A0Z, B0Z, C0Y, rad.
    pub squareness: [f64; 3],
    /// Standard errors of `squareness`, rad.
    pub squareness_errors: [f64; 3],
    /// Covariance of `squareness`, rad²: given the nodes, and with everything else that the fit determines free.
    pub squareness_covariance: [[f64; 3]; 3],
    /// Shift of the instrument, mm, and its rotation, rad.
    pub placement: [f64; 6],
    /// Errors of the reflector offsets, from the second on, mm.
    pub offsets_mm: Vec<[f64; 3]>,
    /// Residual of each observation, mm.
    pub left_mm: Vec<[f64; 3]>,
    /// Standard deviation of unit weight: a coordinate's is this times its `sigma_mm`.
    pub sigma: f64,
    /// Number of coordinates − determined unknowns.
    pub degrees_of_freedom: usize,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Number of conditions that fix freedoms the points do not determine.
    pub conventions: usize,
    /// Rank including the conditions: all unknowns.
    pub rank: usize,
    /// Condition number of the scaled columns.
    pub condition: f64,
}

/// Why points do not determine the errors.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum VolumetricRefusal {
    /// There are more unknowns than coordinates.
    TooFew {
        /// Number of coordinates, three per point.
        found: usize,
        /// Number of unknowns that they have to determine.
        needed: usize,
    },
    /// Some errors are inseparable.
    Indistinct {
        /// Names of the errors.
        names: Vec<String>,
        /// Rank of the fit.
        rank: usize,
        /// Number of unknowns.
        unknowns: usize,
    },
}

impl fmt::Display for VolumetricRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            VolumetricRefusal::TooFew { found, needed } => {
                write!(f, "found {found} coordinates for {needed} unknowns, needed more points or fewer nodes")
            }
            VolumetricRefusal::Indistinct { names, rank, unknowns } => write!(
                f,
                "found points that cannot separate {} (rank {rank} of {unknowns}), needed points all over the volume, not on lines \
                 or planes only, or these errors left out",
                names.join(", ")
            ),
        }
    }
}

impl core::error::Error for VolumetricRefusal {}
