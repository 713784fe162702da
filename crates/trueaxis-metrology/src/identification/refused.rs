//! Why measurements cannot be solved.

use core::fmt;
use trueaxis::Axis;

/// Why measurements cannot be solved, with the values found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum IdentificationRefusal {
    /// The axis is not rotary.
    NotRotary(Axis),
    /// A value is infinite or not a number.
    NotFinite {
        /// Index of the set-up, from 0.
        set_up: usize,
    },
    /// There are fewer than three set-ups.
    TooFewSetUps {
        /// Number of set-ups.
        found: usize,
    },
    /// The points (L, H) are on one line, or so close to one that the six errors are inseparable: rotation about that line
    /// moves no ball.
    Collinear {
        /// Extent of the points along the line, mm.
        along_mm: f64,
        /// Largest distance from the line, mm.
        off_mm: f64,
        /// Number of errors observed, of six.
        rank: u8,
        /// Condition number of the scaled columns; infinite if the columns are exactly dependent.
        condition: f64,
    },
    /// The number of readings at an angle differs from the number of set-ups.
    Readings {
        /// Index of the angle, from 0.
        angle: usize,
        /// Number of readings.
        found: usize,
        /// Number of set-ups.
        needed: usize,
    },
    /// No angles.
    NoAngles,
    /// With free offsets: the angles are too few, or span too little, to separate the errors from the offsets.
    Offsets {
        /// Number of combinations of errors and offsets that no reading observes.
        found: usize,
        /// Number of such combinations that always exist and that the gauge fixes.
        needed: usize,
    },
    /// The singular values did not converge.
    NoConvergence,
}

impl fmt::Display for IdentificationRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            IdentificationRefusal::NotRotary(axis) => write!(f, "found axis {}, needed A, B or C", axis.letter()),
            IdentificationRefusal::NotFinite { set_up } => {
                write!(f, "set-up {}: found a value that is not finite, needed finite numbers", set_up + 1)
            }
            IdentificationRefusal::TooFewSetUps { found } => {
                write!(f, "set-ups (L, H): found {found}, needed at least 3")
            }
            IdentificationRefusal::Collinear { along_mm, off_mm, rank, condition } => {
                write!(
                    f,
                    "found collinear set-ups: points (L, H) over {along_mm:.4} mm at most {off_mm:.4} mm off one line, \
                     rank {rank} of 6, condition number "
                )?;
                if condition.is_finite() {
                    write!(f, "{condition:.3e}")?;
                } else {
                    f.write_str("infinite")?;
                }
                f.write_str("; needed points that are not on one line: turning about it moves no ball")
            }
            IdentificationRefusal::Readings { angle, found, needed } => {
                write!(f, "readings at angle {}: found {found}, needed one for each of {needed} set-ups", angle + 1)
            }
            IdentificationRefusal::NoAngles => f.write_str("found no angles, needed at least one"),
            IdentificationRefusal::Offsets { found, needed } => write!(
                f,
                "found {found} combinations of errors and free offsets that no reading sees, needed {needed}: more \
                 angles, over more of the circle"
            ),
            IdentificationRefusal::NoConvergence => {
                f.write_str("found singular values that do not converge, needed other readings")
            }
        }
    }
}

impl core::error::Error for IdentificationRefusal {}
