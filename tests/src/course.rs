//! Runs a program at the servo rate with any control of the axes, and measures the tip's deviation from the programmed curve.

use trueaxis::contour::{Path, Reference};
use trueaxis::glam::DVec3;
use trueaxis::machine::MachineSettings;
use trueaxis_sim::motion::Setpoint;
use trueaxis_sim::path::PlannedPath;
use trueaxis_sim::program::Program;
use trueaxis_sim::truth::Truth;
use trueaxis_sim::{Scenario, Settings};
use trueaxis_tables::Machine;

/// Command of a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Command {
    /// Commanded position, mm.
    pub at: [f64; 3],
    /// Set-point of the motion.
    pub setpoint: Setpoint,
    /// The set-point as the step's reference.
    pub reference: Reference<f64>,
    /// Whether the motion is not rapid.
    pub cutting: bool,
}

/// The program, its commands and the step's path. The program's origin is the machine's.
#[derive(Debug)]
pub struct Course {
    /// Servo period, s.
    pub period_s: f64,
    /// Part program.
    pub program: Program,
    /// Commands of every cycle.
    pub commands: Vec<Command>,
    path: PlannedPath,
}

impl Course {
    /// Plans the motion of a program of X, Y, Z.
    ///
    /// # Panics
    /// The program or the settings are refused.
    pub fn new(program: &str, settings: Settings, machine: &MachineSettings) -> Course {
        let program = Program::parse("course", program, "course.ngc").unwrap();
        let machine = Machine {
            settings: machine.clone(),
            tables: machine.axes.iter().map(|_| None).collect(),
            grids: Vec::new(),
        };
        let settings = Settings { origin_mm: Some([0.0; 3]), ..settings };
        let scenario = Scenario::new(machine, program.clone(), settings).unwrap();
        let path = PlannedPath::new(&program, [0.0; 3], &scenario.placement).unwrap();
        let motion = scenario.motion().unwrap();
        let mut span = 0;
        let commands = motion.setpoints(&program).map(|setpoint| Command {
            at: setpoint.position,
            reference: path.reference(setpoint.move_index, setpoint.u, &mut span),
            cutting: !program.moves[setpoint.move_index].rapid,
            setpoint,
        });
        Course { period_s: scenario.period_s(), commands: commands.collect(), program, path }
    }

    /// The path in the step's form.
    pub fn path(&self) -> Path<'_, f64, f64> {
        self.path.view()
    }

    /// Vector from the programmed curve to the tip, mm, computed independently of the plugin.
    pub fn deviation(&self, truth: &mut Truth, command: &Command, tip: [f64; 3]) -> DVec3 {
        let Setpoint { move_index, u, position, .. } = command.setpoint;
        truth.deviation(&self.program, DVec3::ZERO, (move_index, u), position.into(), tip.into())
    }
}
