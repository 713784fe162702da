//! What a circular test tells of two axes: ISO 230-4 figures, and its causes apart.
//!
//! The machine runs a circle of radius R about the ballbar's pivot; Δr(θ) is what the bar reads where it is sent to the angle θ,
//! actual − nominal, d = +1 counterclockwise, −1 clockwise. To first order Δr = e · (cos θ, sin θ), the error e of the tip in the plane:
//!
//! ```text
//! set-up            Δr = r₀ + c_x cos θ + c_y sin θ
//! scale mismatch    Δr = (R/2)(s_x − s_y) cos 2θ
//! squareness C0Y    Δr = −(R/2) C0Y sin 2θ                       (EXY −= C0Y y)
//! servo mismatch    Δr = (d/2)(l_x − l_y) sin 2θ                 l: lag behind the command
//! backlash          Δr = (d/2)(b_x sgn(sin θ) cos θ − b_y sgn(cos θ) sin θ)
//! lateral play      Δr = (d/2)(p_x |sin θ| − p_y |cos θ|)        sideways shift at reversals of X, of Y
//! straightness      Δr = q_x cos²θ sin θ + q_y sin²θ cos θ       bow over a radius: EYX = q_x x²/R²
//! reversal          Δr = h (u/w) exp(1 − u/w)                    u: angle since the axis' reversal
//! cyclic            Δr = cos θ (a cos(2πx/p) + b sin(2πx/p))     x = R cos θ; Y likewise
//! ```
//!
//! One linear least-squares fit for all; w and the pitches p are searched, w where spikes are seen. Spikes of another shape are
//! fitted as a random function beside it, which widens the standard errors of what they are like. Servo mismatch and lateral play
//! need both directions: with one they cannot be told from squareness and scale mismatch, and are left out.
//!
//! Where an axis turns it stands, and its play is taken up only after the way b; readings from the reversal to there are left out of
//! the fit. Arcs of 200° and more in place of circles tell the same causes, less well.

mod figures;
mod fit;
mod positions;
mod shape;

pub use figures::Figures;
pub use fit::evaluate;
pub use positions::{Position, readings};

use std::fmt;
use std::vec::Vec;

/// A reading of the bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Angle of the commanded place on its circle, from +X towards +Y, rad.
    pub angle_rad: f64,
    /// Actual less nominal radius, mm.
    pub deviation_mm: f64,
    /// Counterclockwise.
    pub counterclockwise: bool,
}

/// A cause of a circle's deviation. Axes: 0 for X, 1 for Y of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Cause {
    /// Mean deviation of the radius, mm: the bar's length, the mean scale and lag.
    Radius,
    /// Offset of the circle's centre along an axis, mm: how the bar was set up.
    Centre(u8),
    /// Scale of X less that of Y.
    ScaleMismatch,
    /// C0Y, rad.
    Squareness,
    /// Lag of X less that of Y, mm.
    ServoMismatch,
    /// Lost motion of an axis, mm.
    Backlash(u8),
    /// Sideways shift at the reversals of an axis, mm.
    LateralPlay(u8),
    /// Deviation of an axis across itself at x = ±R from that in the middle, mm.
    Straightness(u8),
    /// Height of the spike after the reversals of an axis, mm, outwards.
    Reversal(u8),
    /// Amplitude of an axis' periodic error, mm.
    Cyclic(u8),
}

/// A cause and how much of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Term {
    /// What it is.
    pub cause: Cause,
    /// How much, mm, rad or 1.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Root mean square of the deviation that it makes, mm.
    pub rms_mm: f64,
}

/// What a circular test tells.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Evaluation {
    /// Every cause that was looked for; of the periodic ones those that were found.
    pub terms: Vec<Term>,
    /// Width w of the spikes at reversals, rad; where none are seen, the one that their height is given for.
    pub spike_width_rad: f64,
    /// Whether there are spikes too narrow for readings so far apart: they are higher than is found.
    pub spikes_unresolved: bool,
    /// Whether the spikes are of another shape than h (u/w) exp(1 − u/w): the standard errors allow for it.
    pub spikes_of_another_shape: bool,
    /// Pitch of the periodic error of either axis, mm.
    pub pitches_mm: [Option<f64>; 2],
    /// Standard deviation of a reading, from what the causes leave, mm.
    pub sigma_mm: f64,
    /// Readings less parameters.
    pub degrees_of_freedom: usize,
    /// Condition number of the fit, its columns scaled.
    pub condition: f64,
    /// Whether both directions were recorded.
    pub both_directions: bool,
    /// Whether the circles are whole; else they are arcs.
    pub whole_circles: bool,
    /// Readings that are left out of the fit: where an axis turns, before its play is taken up.
    pub left_out: usize,
    /// After ISO 230-4.
    pub figures: Figures,
    /// Readings about the centre that was found, and what the causes leave of them, mm, in the order given.
    pub centred: Vec<[f64; 2]>,
}

impl Evaluation {
    /// A term by its cause.
    pub fn term(&self, cause: Cause) -> Option<&Term> {
        self.terms.iter().find(|term| term.cause == cause)
    }
}

/// Readings that tell nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Refused {
    /// Fewer readings than a fit needs.
    TooFew {
        /// Readings of the record.
        found: usize,
    },
    /// A reading that is no finite number, or as large as the circle.
    NotAReading {
        /// Index of the reading.
        index: usize,
    },
    /// The circle is not closed, and no arc of [`LEAST_ARC_DEG`] either.
    Gap {
        /// Counterclockwise or clockwise.
        counterclockwise: bool,
        /// Where the gap begins, degrees.
        from_deg: f64,
        /// How wide it is, degrees.
        width_deg: f64,
    },
    /// Commands that hold no circle of the radius.
    NoCircle {
        /// The radius that was asked for, mm.
        radius_mm: f64,
        /// Radius of what the commands do hold, in the middle; none where they are straight.
        found_mm: Option<f64>,
    },
}

/// Readings that a fit needs at least.
pub const LEAST: usize = 72;
/// Widest gap between neighbouring angles of one direction, degrees, but for the one that an arc leaves.
pub const WIDEST_GAP_DEG: f64 = 10.0;
/// Shortest arc that is evaluated, degrees.
pub const LEAST_ARC_DEG: f64 = 200.0;

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew { found } => write!(f, "found {found} readings, needed at least {LEAST}"),
            Self::NotAReading { index } => {
                write!(f, "found a reading at index {index} that is not finite or as large as the radius")
            }
            Self::NoCircle { radius_mm, found_mm } => {
                match found_mm {
                    Some(found) => write!(f, "found commands that turn with a radius of {found:.4} mm")?,
                    None => f.write_str("found commands that do not turn")?,
                }
                write!(f, ", needed circles of {radius_mm} mm about one centre")
            }
            Self::Gap { counterclockwise, from_deg, width_deg } => {
                let way = if *counterclockwise { "counterclockwise" } else { "clockwise" };
                write!(
                    f,
                    "found no {way} reading over {width_deg:.1}° from {from_deg:.1}° on, needed whole circles or arcs of \
                     {LEAST_ARC_DEG}° and more without a gap above {WIDEST_GAP_DEG}°"
                )
            }
        }
    }
}

impl std::error::Error for Refused {}
