//! From the tool to axis positions, row by row: each solution near the one before.

use anyhow::{Result, bail};
use trueaxis::kinematics::{BranchTracker, Choice, InverseError, Kinematics, Solution, Solutions, Tool};
use trueaxis::machine::{AXES, Axis};

/// Largest angle to start from, degrees.
const MOST_DEG: f64 = 1e6;

/// What was found for a row.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// The pose that was chosen.
    pub chosen: Solution<f64>,
    /// Both poses; none where a limit of steps holds the branch.
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
    /// From zero; `max_step_deg` refuses a change of branch, and a larger step of a rotary axis from row to row.
    ///
    /// # Errors
    /// A step that is not positive: what was found and what is needed.
    pub fn new(choice: Choice, max_step_deg: Option<f64>) -> Result<Walk> {
        if let Some(step) = max_step_deg.filter(|step| step.is_nan() || *step <= 0.0) {
            bail!("found {step}, needed a positive number of degrees");
        }
        Ok(Walk { choice, max_step_deg, near: [0.0; AXES], tracker: None })
    }

    /// From these angles of the machine's rotary axes in the order A, B, C, degrees.
    ///
    /// # Errors
    /// Another number of angles than of axes, or one above 1e6 degrees.
    pub fn from_angles(mut self, kinematics: &Kinematics<f64>, angles: &[f64]) -> Result<Walk> {
        let rotary = || Axis::ALL.into_iter().filter(|axis| axis.is_rotary() && kinematics.has(*axis));
        if rotary().count() != angles.len() {
            let letters: String = rotary().map(Axis::letter).collect();
            bail!("found {} angles, needed one for each rotary axis ({letters})", angles.len());
        }
        for (axis, &angle) in rotary().zip(angles) {
            if angle.is_nan() || angle.abs() > MOST_DEG {
                bail!("found {angle}, needed an angle of at most 1e6 degrees");
            }
            self.near[axis.index()] = angle;
        }
        Ok(self)
    }

    /// The next tool.
    ///
    /// # Errors
    /// Those of [`Kinematics::inverse`], [`Kinematics::solutions`], [`Solutions::choose`] and [`BranchTracker::next`].
    pub fn next(&mut self, kinematics: &Kinematics<f64>, tool: &Tool<f64>) -> Result<Found, InverseError> {
        if let Some(tracker) = &mut self.tracker {
            return Ok(Found { chosen: tracker.next(kinematics, tool)?, both: None });
        }
        let both = kinematics.solutions(tool, &self.near)?;
        // In the singular cone the nearest is led to neither branch before it has to be.
        let chosen = match self.choice {
            Choice::Nearest => kinematics.inverse(tool, &self.near)?,
            choice => both.choose(choice)?,
        };
        self.near = chosen.axes;
        self.tracker = self.max_step_deg.map(|step| BranchTracker::new(&chosen, step));
        Ok(Found { chosen, both: Some(both) })
    }
}
