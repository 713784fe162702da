//! Reasons why a tool pose has no axis positions.

use super::branch::Branch;
use crate::machine::Axis;
use core::fmt;

/// Reason why an inverse was refused, with the values; mm and degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum InverseError {
    /// The tip has a coordinate that is infinite or NaN.
    TipNotFinite,
    /// The tool axis is not a unit vector (to 1e-3).
    NotADirection {
        /// Length of the vector.
        length: f64,
    },
    /// No rotary axis can turn the tool there.
    Unreachable {
        /// Angle to the nearest direction within reach.
        by_deg: f64,
    },
    /// The pose is within the singular cone, and an end of a rotary travel keeps the tool farther off than the cone.
    SingularPose {
        /// Distance from the singular pose.
        margin_deg: f64,
        /// The cone.
        cone_deg: f64,
    },
    /// At these rotary positions the linear axes between the rotary ones no longer span space.
    LinearAxes {
        /// Volume of the three unit directions of travel.
        volume: f64,
    },
    /// Every solution leaves the travel of an axis.
    OutsideTravel {
        /// The axis.
        axis: Axis,
        /// Position that the solution needs.
        found: f64,
        /// Low end of the axis's travel.
        low: f64,
        /// High end of the axis's travel.
        high: f64,
    },
    /// The other branch was requested, but only one solution exists.
    OneBranch,
    /// Only the other branch continues the path without a jump.
    BranchChange {
        /// The branch that the path was on.
        from: Branch,
        /// Rotary step needed to stay on that branch; infinite if it leaves the travel.
        step_deg: f64,
        /// Largest permitted step.
        limit_deg: f64,
    },
    /// A rotary axis would have to take too large a step.
    TooFast {
        /// The axis.
        axis: Axis,
        /// Step of the axis.
        step_deg: f64,
        /// Largest permitted step.
        limit_deg: f64,
    },
}

impl fmt::Display for InverseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            InverseError::TipNotFinite => write!(f, "found a tip that is not finite, needed numbers"),
            InverseError::NotADirection { length } => {
                write!(f, "found a tool axis of length {length}, needed a unit vector within 1e-3")
            }
            InverseError::Unreachable { by_deg } => {
                write!(f, "found a tool axis {by_deg} degrees beyond reach, needed one that the rotary axes can reach")
            }
            InverseError::SingularPose { margin_deg, cone_deg } => {
                write!(
                    f,
                    "found a tool axis {margin_deg} degrees from the singular pose, where a rotary travel ends more than \
                     the cone of {cone_deg} before it; needed one outside the cone"
                )
            }
            InverseError::LinearAxes { volume } => {
                write!(
                    f,
                    "found directions of travel that span a volume of {volume}, needed three independent directions"
                )
            }
            InverseError::OutsideTravel { axis, found, low, high } => {
                write!(f, "axis {}: found {found}, needed the travel, {low} to {high}", axis.letter())
            }
            InverseError::OneBranch => write!(f, "found one solution, needed a machine with two branches"),
            InverseError::BranchChange { from, step_deg, limit_deg } => write!(
                f,
                "found a path that leaves branch {} (a step of {step_deg} degrees on it), needed steps of at most {limit_deg}",
                from as u8
            ),
            InverseError::TooFast { axis, step_deg, limit_deg } => {
                write!(f, "axis {}: found a step of {step_deg} degrees, needed at most {limit_deg}", axis.letter())
            }
        }
    }
}

impl core::error::Error for InverseError {}
