//! Circular test of two axes: ISO 230-4 figures and the separated causes of the deviation.
//!
//! The machine runs a circle of radius R about the ballbar's pivot. Δr(θ) is the bar's reading at the commanded angle θ,
//! actual − nominal; d = +1 counterclockwise, −1 clockwise. To first order Δr = e · (cos θ, sin θ), with e the error of the
//! tip in the plane:
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
//! One linear least-squares fit covers all causes. A search determines the pitches p, and w if spikes are significant. If the
//! spikes have another shape, the fit models the difference as a random function, which widens the standard errors of similar
//! causes. Servo mismatch and lateral play need both directions: from one direction they are indistinguishable from squareness
//! and scale mismatch, and the fit omits them.
//!
//! An axis rests at its reversal and takes up its play only over the travel b that follows; the fit omits the readings in
//! between. Arcs of 200° and more show the same causes as whole circles, with less certainty.

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
    /// Angle of the commanded position on its circle, from +X towards +Y, rad.
    pub angle_rad: f64,
    /// Actual − nominal radius, mm.
    pub deviation_mm: f64,
    /// Whether the circle runs counterclockwise.
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
    /// Scale of X − scale of Y.
    ScaleMismatch,
    /// C0Y, rad.
    Squareness,
    /// Lag of X − lag of Y, mm.
    ServoMismatch,
    /// Lost motion of an axis, mm.
    Backlash(u8),
    /// Sideways shift at the reversals of an axis, mm.
    LateralPlay(u8),
    /// Deviation of an axis across its travel at x = ±R, relative to the middle, mm.
    Straightness(u8),
    /// Height of the spike after the reversals of an axis, mm, positive outwards.
    Reversal(u8),
    /// Amplitude of an axis' periodic error, mm.
    Cyclic(u8),
}

/// A cause and its magnitude.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Term {
    /// The cause.
    pub cause: Cause,
    /// Magnitude, mm, rad or 1.
    pub value: f64,
    /// Standard error of `value`.
    pub standard_error: f64,
    /// Root mean square of the deviation due to this cause, mm.
    pub rms_mm: f64,
}

/// Result of a circular test.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Evaluation {
    /// All fitted causes; periodic errors only if detected.
    pub terms: Vec<Term>,
    /// Covariance of the terms, in their order and units; its diagonal has the squares of their standard errors.
    ///
    /// Like these, it is an average over the widths and shapes of spikes that the readings allow: the covariance within each
    /// fit, and that between the fits. It is conditional on the pitches and on the readings left out for play. Spikes of another
    /// shape have zeros: their height is that of one curve, which such an average does not have.
    pub covariance: Vec<Vec<f64>>,
    /// Width w of the spikes at reversals, rad; without visible spikes, the fixed width with which the fit determines their
    /// height.
    pub spike_width_rad: f64,
    /// Whether some spikes are too narrow for the spacing of the readings: they are then higher than the fitted value.
    pub spikes_unresolved: bool,
    /// Whether the spikes' shape differs from h (u/w) exp(1 − u/w): the standard errors allow for it.
    pub spikes_of_another_shape: bool,
    /// Pitch of each axis' periodic error, mm.
    pub pitches_mm: [Option<f64>; 2],
    /// Standard deviation of a reading, from the residuals, mm.
    pub sigma_mm: f64,
    /// Number of readings − number of parameters.
    pub degrees_of_freedom: usize,
    /// Condition number of the fit with scaled columns.
    pub condition: f64,
    /// Whether both directions were recorded.
    pub both_directions: bool,
    /// Whether the circles are whole, not arcs.
    pub whole_circles: bool,
    /// Number of readings left out of the fit: after a reversal, before the axis has taken up its play.
    pub left_out: usize,
    /// Figures after ISO 230-4.
    pub figures: Figures,
    /// Readings about the fitted centre, and their residuals, mm, in the order given.
    pub centred: Vec<[f64; 2]>,
}

impl Evaluation {
    /// Returns the term of a cause.
    pub fn term(&self, cause: Cause) -> Option<&Term> {
        self.terms.iter().find(|term| term.cause == cause)
    }
}

/// Why the readings are refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BallbarRefusal {
    /// Fewer readings than a fit needs.
    TooFew {
        /// Readings of the record.
        found: usize,
    },
    /// A reading is not finite, or as large as the circle.
    NotAReading {
        /// Index of the reading.
        index: usize,
    },
    /// The angles cover neither a closed circle nor an arc of [`LEAST_ARC_DEG`].
    Gap {
        /// Counterclockwise or clockwise.
        counterclockwise: bool,
        /// Start of the gap, degrees.
        from_deg: f64,
        /// Width of the gap, degrees.
        width_deg: f64,
    },
    /// The commands contain no circle of the given radius.
    NoCircle {
        /// The given radius, mm.
        radius_mm: f64,
        /// Median radius of the commanded curve; `None` if it is straight.
        found_mm: Option<f64>,
    },
}

/// Least number of readings for a fit.
pub const LEAST: usize = 72;
/// Widest permitted gap between neighbouring angles of one direction, degrees, apart from the gap that an arc leaves.
pub const WIDEST_GAP_DEG: f64 = 10.0;
/// Shortest arc accepted, degrees.
pub const LEAST_ARC_DEG: f64 = 200.0;

impl fmt::Display for BallbarRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew { found } => write!(f, "readings: found {found}, needed at least {LEAST}"),
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

impl std::error::Error for BallbarRefusal {}
