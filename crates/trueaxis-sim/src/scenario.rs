//! What is simulated: machine, program, rate, seed, faults.

use crate::error::{Result, SimError};
use crate::motion::{Motion, MotionSettings, Setpoint};
use crate::placement::Placement;
use crate::plant::fault::FaultScript;
use crate::program::Program;
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::AXES;
use trueaxis_tables::Machine;

/// One simulation.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The machine, whose tables the plant has as its true errors and the plugin as its knowledge of them.
    pub machine: Machine,
    /// The part program.
    pub program: Program,
    /// Program zero in machine coordinates, mm.
    pub origin_mm: [f64; 3],
    /// Where the axes stand for a programmed place.
    pub placement: Placement,
    /// Rotary axes or the tool centre point are programmed: errors are those of tip and direction in workpiece coordinates.
    pub five_axis: bool,
    /// Servo rate.
    pub rate_hz: f64,
    /// Seed of the encoders' noise.
    pub seed: u64,
    /// Injected faults.
    pub faults: FaultScript,
    /// Kelvin above the reference temperature that the plugin is told.
    pub kelvin: f64,
    /// Time a step may take, ns.
    pub budget_ns: u64,
}

impl Scenario {
    /// The step's own transformation to workpiece coordinates, where the program needs it.
    ///
    /// # Errors
    /// The machine has none: a linear axis missing, or more than two rotary ones.
    pub fn kinematics(&self) -> Result<Option<Kinematics<f64>>> {
        let build = || Kinematics::new(&self.machine.settings).map_err(SimError::Config);
        self.five_axis.then(build).transpose()
    }

    /// Plans the motion of the program on the machine.
    ///
    /// # Errors
    /// As [`Motion::plan_on`].
    pub fn motion(&self) -> Result<Motion> {
        let settings = MotionSettings { period_s: self.period_s(), ..MotionSettings::default() };
        Motion::plan_on(&self.program, settings, &self.placement)
            .map_err(|error| SimError::Motion { program: self.program.name.clone(), error })
    }

    /// Servo period, s.
    pub fn period_s(&self) -> f64 {
        1.0 / self.rate_hz
    }

    /// Commanded positions of X, Y, Z, A, B, C, mm and degrees.
    pub fn axis_positions(&self, setpoint: &Setpoint) -> [f64; AXES] {
        match self.program.moves.get(setpoint.move_index) {
            Some(step) if self.five_axis => self.placement.axes(step, setpoint.u),
            _ => {
                let [x, y, z]: [f64; 3] = std::array::from_fn(|k| setpoint.position[k] + self.origin_mm[k]);
                [x, y, z, 0.0, 0.0, 0.0]
            }
        }
    }

    /// Servo period, ns.
    pub fn period_ns(&self) -> u32 {
        (1e9 / self.rate_hz).round() as u32
    }
}

/// Program zero unless it is given: the middle of the declared travels.
pub fn middle_of_travel(machine: &Machine) -> [f64; 3] {
    let mut middle = [0.0; 3];
    for settings in machine.settings.axes.iter().filter(|a| !a.axis.is_rotary()) {
        let [low, high] = settings.travel;
        middle[settings.axis.index()] = 0.5 * (low + high);
    }
    middle
}

/// How many axes the step of a machine has: X, Y, Z, and its rotary ones.
pub fn axis_count(machine: &Machine) -> usize {
    3 + machine.settings.axes.iter().filter(|a| a.axis.is_rotary()).count()
}
