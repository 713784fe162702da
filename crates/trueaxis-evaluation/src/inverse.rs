//! Converts tool poses to axis positions, row by row, each solution near the previous one.

use anyhow::{Result, bail};
use trueaxis::kinematics::{BranchTracker, Choice, InverseError, Kinematics, Solution, Solutions, Tool};
use trueaxis::machine::{AXES, Axis};
use trueaxis_tables::text::counted;

/// Largest starting angle, degrees.
const MOST_DEG: f64 = 1e6;

/// Result for a row.
#[derive(Clone, Copy, Debug)]
pub struct Poses {
    /// The chosen pose.
    pub chosen: Solution<f64>,
    /// Both poses; `None` if a step limit fixes the branch.
    pub both: Option<Solutions<f64>>,
}

/// The inverse transformation along a list of tools.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    choice: Choice,
    max_step_deg: Option<f64>,
    near: [f64; AXES],
    tracker: Option<BranchTracker<f64>>,
}

impl Walk {
    /// Starts from zero; `max_step_deg` refuses a change of branch and any larger step of a rotary axis from row to row.
    ///
    /// # Errors
    /// A step that is not positive; the error states the value found and the value needed.
    pub fn new(choice: Choice, max_step_deg: Option<f64>) -> Result<Walk> {
        if let Some(step) = max_step_deg.filter(|step| step.is_nan() || *step <= 0.0) {
            bail!("found {step}, needed a positive number of degrees");
        }
        Ok(Walk { choice, max_step_deg, near: [0.0; AXES], tracker: None })
    }

    /// Starts from these angles of the machine's rotary axes in the order A, B, C, degrees.
    ///
    /// # Errors
    /// A number of angles other than that of the axes, or an angle above 1e6 degrees.
    pub fn from_angles(mut self, kinematics: &Kinematics<f64>, angles: &[f64]) -> Result<Walk> {
        let rotary = || Axis::ALL.into_iter().filter(|axis| axis.is_rotary() && kinematics.has(*axis));
        if rotary().count() != angles.len() {
            let letters: String = rotary().map(Axis::letter).collect();
            bail!("found {}, needed one for each rotary axis ({letters})", counted(angles.len(), "angle"));
        }
        for (axis, &angle) in rotary().zip(angles) {
            if angle.is_nan() || angle.abs() > MOST_DEG {
                bail!("found {angle}, needed an angle of at most 1e6 degrees");
            }
            self.near[axis.index()] = angle;
        }
        Ok(self)
    }

    /// The pose for the next tool.
    ///
    /// # Errors
    /// As [`Kinematics::inverse`], [`Kinematics::solutions`], [`Solutions::choose`] and [`BranchTracker::next`].
    pub fn next(&mut self, kinematics: &Kinematics<f64>, tool: &Tool<f64>) -> Result<Poses, InverseError> {
        if let Some(tracker) = &mut self.tracker {
            return Ok(Poses { chosen: tracker.next(kinematics, tool)?, both: None });
        }
        let both = kinematics.solutions(tool, &self.near)?;
        // In the singular cone, `inverse` commits to neither branch before it must.
        let chosen = match self.choice {
            Choice::Nearest => kinematics.inverse(tool, &self.near)?,
            choice => both.choose(choice)?,
        };
        self.near = chosen.axes;
        self.tracker = self.max_step_deg.map(|step| BranchTracker::new(&chosen, step));
        Ok(Poses { chosen, both: Some(both) })
    }
}
