//! A program run at the servo rate by whatever drives the axes, and how far the tip is off the programmed curve.

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
    /// Where the motion is.
    pub setpoint: Setpoint,
    /// The same for the step.
    pub reference: Reference<f64>,
    /// Not in rapid motion.
    pub cutting: bool,
}

/// The program, its commands and the path that the step takes. The origin of the program is that of the machine.
#[derive(Debug)]
pub struct Course {
    /// Servo period, s.
    pub period_s: f64,
    /// The program.
    pub program: Program,
    /// Every cycle.
    pub commands: Vec<Command>,
    path: PlannedPath,
}

impl Course {
    /// Plans the motion of a program of X, Y, Z.
    ///
    /// # Panics
    /// Program or settings are refused.
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

    /// The path as the step takes it.
    pub fn path(&self) -> Path<'_, f64, f64> {
        self.path.view()
    }

    /// Vector from the programmed curve to the tip, mm, found without the plugin.
    pub fn deviation(&self, truth: &mut Truth, command: &Command, tip: [f64; 3]) -> DVec3 {
        let Setpoint { move_index, u, position, .. } = command.setpoint;
        truth.deviation(&self.program, DVec3::ZERO, (move_index, u), position.into(), tip.into())
    }
}
