//! Why a record cannot be evaluated.

use std::fmt;
use std::string::String;
use trueaxis::Axis;

/// Why a record cannot be evaluated, with the values found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FrictionRefusal {
    /// The record has fewer samples than a fit needs.
    TooFewSamples {
        /// Samples found.
        found: usize,
        /// Samples needed.
        needed: usize,
    },
    /// The time stamps are not evenly spaced: a gap, a repeated row, or a wrong order.
    Uneven {
        /// Index of the sample whose interval to the next one is wrong, from 0.
        index: usize,
        /// The interval, s.
        found_s: f64,
        /// The record's period, s.
        period_s: f64,
    },
    /// The period is too long for the drive's dynamics, or too short to be in seconds.
    Period {
        /// The period, s.
        found_s: f64,
    },
    /// A magnitude is impossible for a circle in millimetres and seconds.
    Unit {
        /// Axis.
        axis: Axis,
        /// The quantity with its value and unit.
        found: String,
        /// Required value of the quantity.
        needed: &'static str,
    },
    /// An axis has too few reversals in motion.
    Reversals {
        /// Axis.
        axis: Axis,
        /// Reversals found.
        found: usize,
        /// Reversals needed.
        needed: usize,
    },
    /// The circles were travelled in one direction only.
    OneDirection {
        /// Axis whose reversals show it.
        axis: Axis,
        /// Reversals of clockwise circles.
        clockwise: usize,
        /// Reversals of counterclockwise circles.
        counterclockwise: usize,
    },
    /// The record has only one radius at one feed.
    OneSize {
        /// Axis.
        axis: Axis,
        /// Smallest acceleration at a reversal, mm/s².
        low_mm_per_s2: f64,
        /// Largest acceleration at a reversal, mm/s².
        high_mm_per_s2: f64,
    },
    /// The readings show no friction.
    NoFriction {
        /// Axis.
        axis: Axis,
        /// Friction F_c/K_vp found, mm/s.
        found_mm_per_s: f64,
        /// Standard error of the friction, mm/s.
        standard_error_mm_per_s: f64,
    },
    /// The record does not determine a figure.
    NotExcited {
        /// Axis.
        axis: Axis,
        /// Name of the figure.
        figure: &'static str,
        /// Standard error as a share of the figure.
        relative_error: f64,
        /// What would determine the figure.
        needed: &'static str,
    },
    /// Position gain and reset time are interchangeable: friction excites both alike.
    GainOrResetTime {
        /// Axis.
        axis: Axis,
        /// Position gain found, 1/s.
        position_gain_per_s: f64,
        /// Reset time found, s.
        reset_time_s: f64,
        /// Residual with these values, µm.
        residual_um: f64,
        /// Residual with position gain and 1/reset time exchanged, µm.
        exchanged_um: f64,
    },
    /// The record cannot separate the parameters.
    RankShort {
        /// Axis.
        axis: Axis,
        /// Number of combinations that the record determines.
        rank: usize,
        /// Number of parameters.
        of: usize,
        /// Condition number of the scaled columns.
        condition: f64,
    },
    /// The model leaves too much of the following error unexplained.
    NotExplained {
        /// Axis.
        axis: Axis,
        /// Share of the glitches' mean square that the model explains.
        share: f64,
        /// Share needed.
        needed: f64,
    },
    /// The fit did not converge.
    NoConvergence {
        /// Axis.
        axis: Axis,
        /// Steps tried.
        steps: usize,
    },
}

impl fmt::Display for FrictionRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FrictionRefusal::TooFewSamples { found, needed } => {
                write!(f, "samples: found {found}, needed at least {needed}: several circles at 500 Hz or more")
            }
            FrictionRefusal::Uneven { index, found_s, period_s } => write!(
                f,
                "found {found_s:.6} s from sample {index} to sample {}, needed {period_s:.6} s as everywhere else: a \
                 record without gaps at an even rate",
                index + 1
            ),
            FrictionRefusal::Period { found_s } => {
                write!(f, "found a period of {found_s} s, needed 0.00001 to 0.002 s: t_s in seconds, at 500 Hz or more")
            }
            FrictionRefusal::Unit { axis, found, needed } => {
                write!(f, "axis {}: found {found}, needed {needed}", axis.letter())
            }
            FrictionRefusal::Reversals { axis, found, needed } => write!(
                f,
                "axis {}, reversals in motion: found {found}, needed at least {needed}: whole circles",
                axis.letter()
            ),
            FrictionRefusal::OneDirection { axis, clockwise, counterclockwise } => write!(
                f,
                "axis {}: found {clockwise} reversals clockwise and {counterclockwise} counterclockwise, needed at \
                 least 2 of each: circles in both directions",
                axis.letter()
            ),
            FrictionRefusal::OneSize { axis, low_mm_per_s2, high_mm_per_s2 } => write!(
                f,
                "axis {}: found reversals at {low_mm_per_s2:.3} to {high_mm_per_s2:.3} mm/s², needed accelerations \
                 that differ by 1.5 or more: circles of two radii or at two feeds",
                axis.letter()
            ),
            _ => self.fmt_of_fit(f),
        }
    }
}

impl FrictionRefusal {
    /// Formats the refusals that follow a fit.
    fn fmt_of_fit(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FrictionRefusal::NoFriction { axis, found_mm_per_s, standard_error_mm_per_s } => write!(
                f,
                "axis {}: found friction of {found_mm_per_s:.5} mm/s with a standard error of \
                 {standard_error_mm_per_s:.5} mm/s, needed more than 3 standard errors: spikes at the reversals that \
                 exceed the noise of the readings",
                axis.letter()
            ),
            FrictionRefusal::NotExcited { axis, figure, relative_error, needed } => write!(
                f,
                "axis {}: found {figure} with a standard error of {:.0} % of it, needed {needed}",
                axis.letter(),
                100.0 * relative_error
            ),
            FrictionRefusal::GainOrResetTime { axis, position_gain_per_s, reset_time_s, residual_um, exchanged_um } => {
                write!(
                    f,
                    "axis {}: found position gain {position_gain_per_s:.1} 1/s and reset time {reset_time_s:.5} s no better \
                 ({residual_um:.4} µm left) than position gain {:.1} 1/s and reset time {:.5} s ({exchanged_um:.4} µm): \
                 friction excites both alike; needed a record that starts and stops, or the drive's figures \
                 ([axis.{}.drive] of --machine)",
                    axis.letter(),
                    1.0 / reset_time_s,
                    1.0 / position_gain_per_s,
                    axis.letter()
                )
            }
            FrictionRefusal::RankShort { axis, rank, of, condition } => write!(
                f,
                "axis {}: found {rank} of {of} parameters excited, condition number {condition:.2e}, needed all: circles \
                 of other radii or feeds, or the drive's figures ([axis.{}.drive] of --machine)",
                axis.letter(),
                axis.letter()
            ),
            FrictionRefusal::NotExplained { axis, share, needed } => write!(
                f,
                "axis {}: found a model that explains {:.0} % of the spikes at reversals, needed {:.0} %: other \
                 disturbances outweigh friction, or commands and readings do not belong together",
                axis.letter(),
                100.0 * share,
                100.0 * needed
            ),
            FrictionRefusal::NoConvergence { axis, steps } => write!(
                f,
                "axis {}: found a fit that does not settle in {steps} steps, needed a record that the model of the drive fits \
                 and that starts and stops, or the drive's figures ([axis.{}.drive] of --machine)",
                axis.letter(),
                axis.letter()
            ),
            // `fmt` writes all refusals that precede a fit.
            _ => Ok(()),
        }
    }
}

impl std::error::Error for FrictionRefusal {}
