//! A pose of a five-axis machine with offsets between its axes.

use trueaxis::kinematics::{InverseError, Kinematics, Solution, Tool};
use trueaxis::machine::AXES;
use trueaxis_testing::machine::Machine;

/// A machine, a pose, the pose's tool, and the pose of the previous cycle.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    kinematics: Kinematics<f64>,
    axes: [f64; AXES],
    before: [f64; AXES],
    tool: Tool<f64>,
}

impl Pose {
    /// Trunnion A on Y carrying table C, and the tool on Z on X.
    pub fn trunnion() -> Self {
        let machine = Machine::new("w C' A' Y' b X Z t").tool([0.0, 0.0, -120.0]).each(|axis| {
            axis.offset_mm = if axis.axis.is_rotary() { [0.1, 20.0, -35.0] } else { [0.0; 3] };
        });
        let machine = machine.settings();
        let kinematics = Kinematics::new(&machine).expect("a machine with five axes");
        let axes = [12.3, -45.6, 78.9, -33.3, 0.0, 211.1];
        let before = [12.2, -45.5, 78.8, -33.2, 0.0, 211.0];
        Pose { kinematics, axes, before, tool: kinematics.forward(&axes) }
    }

    /// Forward kinematics: from the axes to the tool.
    #[inline(always)]
    pub fn forward(&self) -> Tool<f64> {
        self.kinematics.forward(&self.axes)
    }

    /// Inverse kinematics: from the tool to the axes, near the previous cycle's pose.
    #[inline(always)]
    pub fn inverse(&self) -> Result<Solution<f64>, InverseError> {
        self.kinematics.inverse(&self.tool, &self.before)
    }
}
