//! Calibration of a machine with a touch probe: a network of touches on artefacts of known size, and the terms that explain
//! them.
//!
//! A touch is the position p, in workpiece coordinates, that the machine reports for the centre of the probe's tip at the
//! trip. The terms x of the machine (squareness, scale, …) move it by J x to its actual position. With r the effective radius
//! of the tip (pre-travel included) and δ(t) the drift since the first touch:
//!
//! ```text
//! bore     |P (p + J x − δ − c)| + r − D/2        P: projection along the axis of the bore, c its centre
//! ball     |p + J x − δ − c| − d/2 − r
//! face     s (n · p′ − Σ u_j (a_j · p′ or 1) − known) − r,  p′ = p + J x − δ        s = ±1: the side that the probe comes from
//! centre   n · (p′ − c)                           p: middle of two touches on opposite sides of a ball or a hole
//! ```
//!
//! are zero except for the probe's repeatability. The unknowns are x, r, every artefact's position (c, u), the drift at its
//! knots, and the sizes, which are known within their standard uncertainty and enter as observations. One least-squares
//! problem covers all of them, solved by QR of scaled columns. It is refused, with the unknowns concerned, if the touches
//! cannot separate some of them ([`CalibrationRefusal::NotApart`]).
//!
//! A bore of known diameter, measured all around, shows the strain in its plane: both scales, and the sum of the shear from
//! squareness and straightness. The strain throughout a volume determines the error except for a rigid motion (Saint-Venant),
//! which depends on how the workpiece is set up. A ball determines the tip's radius, without which scale would not be
//! observable.
//!
//! Source: Golub and Van Loan, Matrix Computations, 4th ed., sections 5.3 and 6.1; ISO 230-1:2012 for the terms.

mod ball;
mod blocks;
mod information;
mod least_squares;
mod network;
mod selection;
mod surface;

pub use ball::{BallFit, fit_ball};
pub use information::Information;
pub use network::{Network, Shown, Solution, Unknown};
pub use selection::Selection;
pub use surface::{Centre, Part, Surface, Touch};

use std::fmt;
use std::vec::Vec;

/// Why the touches are refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum CalibrationRefusal {
    /// Fewer touches than unknowns.
    TooFew {
        /// Number of touches.
        found: usize,
        /// Least number needed.
        needed: usize,
    },
    /// A value is not finite.
    NotFinite {
        /// Index of the touch.
        touch: usize,
    },
    /// Combinations of unknowns that no touch observes: their indices with the share of each in the combination, the largest 1
    /// or −1, in units of the scaled columns.
    NotApart {
        /// The combinations.
        combinations: Vec<Vec<(usize, f64)>>,
    },
    /// The positions do not converge: some touches are not on the artefacts assigned to them.
    Unsettled {
        /// Touch with the largest residual.
        touch: usize,
        /// Residual of that touch, mm.
        residual_mm: f64,
    },
}

impl fmt::Display for CalibrationRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew { found, needed } => write!(f, "touches: found {found}, needed at least {needed}"),
            Self::NotFinite { touch } => write!(f, "found a value that is not finite in touch {touch}, needed numbers"),
            Self::NotApart { combinations } => {
                let count = combinations.len();
                write!(
                    f,
                    "combinations of unknowns that no touch separates: found {count}, needed none; probe other places"
                )
            }
            Self::Unsettled { touch, residual_mm } => {
                write!(f, "found touch {touch} {residual_mm:.3} mm off its artefact, needed touches on the artefacts")
            }
        }
    }
}

impl std::error::Error for CalibrationRefusal {}
