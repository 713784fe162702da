//! A machine, a program and settings, checked against each other.

use crate::error::{Result, SimError};
use crate::learned::LearnedTable;
use crate::motion::{Motion, MotionSettings, Setpoint};
use crate::placement::Placement;
use crate::program::Program;
use crate::settings::Settings;
use std::collections::BTreeMap;
use std::sync::Arc;
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::{AXES, Axis, ErrorModel};
use trueaxis_tables::Machine;

/// One simulation.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The machine: its tables are the plant's true errors and the plugin's knowledge of them.
    pub machine: Machine,
    /// The part program.
    pub program: Program,
    /// All other settings.
    pub settings: Settings,
    /// Program zero in machine coordinates, mm.
    pub origin_mm: [f64; 3],
    /// Positions of the axes for programmed points.
    pub placement: Placement,
    /// Whether rotary axes or the tool centre point are programmed: errors are then those of tip and direction in workpiece
    /// coordinates.
    pub five_axis: bool,
    /// Kelvin above the reference temperature, as reported to the plugin.
    pub kelvin: f64,
    /// Machines whose tables the events exchange for the plugin's, by their names in the events.
    pub exchanges: BTreeMap<String, Machine>,
    /// Correction over path length in the full run ([`Scenario::with_learned`]).
    pub learned: Option<Arc<LearnedTable>>,
}

impl Scenario {
    /// Puts a program on a machine.
    ///
    /// # Errors
    /// Settings out of range; a move, with its line, that needs axes that the machine does not have, takes too long or leaves
    /// the declared travel; a structural code that cannot be read.
    pub fn new(machine: Machine, program: Program, settings: Settings) -> Result<Scenario> {
        settings.check()?;
        check_drives(&settings, &machine)?;
        program.check_axes(&machine.settings)?;
        program.check_duration(settings.rate_hz, |element| settings.motion.speed(element))?;
        let origin_mm = settings.origin_mm.unwrap_or_else(|| middle_of_travel(&machine));
        let scenario = Scenario {
            five_axis: program.is_five_axis(),
            placement: Placement::new(&machine, origin_mm)?,
            kelvin: settings.temperature_c.map_or(0.0, |t| t - machine.settings.reference_temperature_c),
            origin_mm,
            exchanges: BTreeMap::new(),
            learned: None,
            machine,
            program,
            settings,
        };
        scenario.stays_in_travel()?;
        Ok(scenario)
    }

    /// Returns the scenario with the machines that its events name.
    #[must_use]
    pub fn with_exchanges(self, exchanges: BTreeMap<String, Machine>) -> Scenario {
        Scenario { exchanges, ..self }
    }

    /// The step's transformation to workpiece coordinates, if the program needs it.
    ///
    /// # Errors
    /// The machine has none: it lacks a linear axis, or has more than two rotary ones.
    pub fn kinematics(&self) -> Result<Option<Kinematics<f64>>> {
        self.kinematics_of(&self.machine)
    }

    /// Like [`Scenario::kinematics`], by the tables of another machine.
    pub(crate) fn kinematics_of(&self, machine: &Machine) -> Result<Option<Kinematics<f64>>> {
        let build = || Kinematics::new(&machine.settings).map_err(SimError::Kinematics);
        self.five_axis.then(build).transpose()
    }

    /// Plans the motion of the program on the machine.
    ///
    /// # Errors
    /// As [`Motion::plan_on`].
    pub fn motion(&self) -> Result<Motion> {
        let settings = MotionSettings { period_s: self.period_s(), ..self.settings.motion };
        Motion::plan_on(&self.program, settings, &self.placement)
            .map_err(|error| SimError::Motion { program: self.program.name.clone(), error })
    }

    /// Servo rate, Hz.
    pub fn rate_hz(&self) -> f64 {
        self.settings.rate_hz
    }

    /// Servo period, s.
    pub fn period_s(&self) -> f64 {
        1.0 / self.settings.rate_hz
    }

    /// Time of a cycle from the start of the program, s: the time to state for a fault or an event that acts from there on.
    pub fn time_s(&self, cycle: u64) -> f64 {
        cycle as f64 / self.rate_hz()
    }

    /// Servo period, ns.
    pub fn period_ns(&self) -> u32 {
        (1e9 / self.settings.rate_hz).round() as u32
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

    /// Checks the travel in advance: a program that leaves it would only trigger the plugin's stop request.
    fn stays_in_travel(&self) -> Result<()> {
        for step in &self.program.moves {
            let (first, last) = step.curve.domain();
            for i in 0..=64 {
                let point = self.placement.axes(step, first + (last - first) * f64::from(i) / 64.0);
                let counted = self.machine.settings.axes.iter().filter(|a| self.five_axis || !a.axis.is_rotary());
                for settings in counted {
                    let (q, [low, high]) = (point[settings.axis.index()], settings.travel);
                    if q < low || q > high {
                        let (unit, hint) =
                            if settings.axis.is_rotary() { ("°", "") } else { (" mm", " (see --origin-mm)") };
                        return Err(SimError::Line {
                            program: self.program.name.clone(),
                            line: step.line,
                            found: format!("axis {} goes to {q:.3}{unit}", settings.axis.letter()),
                            needed: format!("within its travel {low} to {high}{unit}{hint}"),
                        });
                    }
                }
            }
        }
        Ok(())
    }
}

/// Applies options that replace the machine file's `[compensation]`: the error model that the step corrects by, and whether
/// the tool's direction is corrected too.
///
/// # Errors
/// Direction correction with the nine-term model.
pub fn choose_model(machine: &mut Machine, model: Option<ErrorModel>, orientation: Option<bool>) -> Result<()> {
    let settings = &mut machine.settings.compensation;
    match model {
        Some(ErrorModel::Nine) => (settings.model, settings.orientation) = (ErrorModel::Nine, false),
        Some(model) => settings.model = model,
        None => {}
    }
    if let Some(orientation) = orientation {
        settings.orientation = orientation;
    }
    if settings.orientation && settings.model == ErrorModel::Nine {
        return Err(SimError::unsuited("--orientation", "on with the nine-term model", "--model volumetric"));
    }
    Ok(())
}

/// Refuses a drive for an axis that the machine does not have.
fn check_drives(settings: &Settings, machine: &Machine) -> Result<()> {
    for (axis, own) in Axis::ALL.into_iter().zip(settings.axis.all()) {
        if own.drive.is_some() && machine.settings.axis(axis).is_none() {
            let letters: Vec<String> = machine.axes().map(|(own, _)| own.axis.letter().to_string()).collect();
            let found = format!("a drive of axis {}", axis.letter());
            return Err(SimError::unsuited("settings", found, format!("one of {}", letters.join(", "))));
        }
    }
    Ok(())
}

/// Middle of the declared travels of X, Y, Z, mm.
pub fn middle_of_travel(machine: &Machine) -> [f64; 3] {
    let mut middle = [0.0; 3];
    for settings in machine.settings.axes.iter().filter(|a| !a.axis.is_rotary()) {
        let [low, high] = settings.travel;
        middle[settings.axis.index()] = 0.5 * (low + high);
    }
    middle
}
