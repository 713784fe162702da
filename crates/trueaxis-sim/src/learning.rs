//! Parts of one program after another, each with the correction learned from those before.
//!
//! What is learned is what a controller could learn: the contour error of the tip that the step itself estimates, from
//! encoders with their noise, and never the plant's truth.

use crate::error::{Result, SimError};
use crate::motion::Motion;
use crate::run::{ErrorSize, Kind, Moment, Run, Sample, Sink};
use crate::scenario::Scenario;
use std::sync::Arc;
use trueaxis::learned::{POINTS_EVERY_MM, ProgramId};
use trueaxis::tcomp;

pub use crate::learned::LearnedTable;
pub use trueaxis_metrology::learning::{
    DEFAULT_CUTOFF_MM, DEFAULT_FORGET, DEFAULT_GAIN, Identity, Law, Lesson, MeasuredError,
};

/// Cycles between two looks at the progress.
const STRETCH: u64 = 4096;

/// What a record or a correction of a scenario belongs to; the path is that of the program from its zero in machine
/// coordinates.
pub fn identity(scenario: &Scenario, motion: &Motion) -> Identity {
    let settings = &scenario.machine.settings;
    let mut id = ProgramId::new(motion.length());
    motion.points(&scenario.program, f64::from(POINTS_EVERY_MM), |position, rotary| {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|i| position[i] + scenario.origin_mm[i]);
        let [a, b, c] = rotary;
        id.point([x, y, z, a, b, c]);
    });
    Identity {
        machine_id: tcomp::machine_id(&settings.name, &settings.chain),
        program_id: id.finish(),
        length_mm: motion.length(),
    }
}

/// Refuses a machine whose step adds nothing to a command but geometry.
fn takes_corrections(scenario: &Scenario) -> Result<()> {
    if Kind::of(&scenario.machine.settings).contains(&Kind::Full) {
        return Ok(());
    }
    let (found, needed) = ("a machine without dynamic correction", "[axis.X.dynamic] in its machine.toml");
    Err(SimError::unsuited("learned correction", found, needed))
}

impl Scenario {
    /// The scenario with a learned correction in its full run.
    ///
    /// # Errors
    /// A correction of another machine, program or path length; a machine without dynamic correction, whose step takes none.
    pub fn with_learned(self, table: Arc<LearnedTable>) -> Result<Scenario> {
        takes_corrections(&self)?;
        let identity = identity(&self, &self.motion()?);
        table.table().expect_machine(identity.machine_id)?;
        table.table().expect_program(identity.program_id, identity.length_mm)?;
        Ok(Scenario { learned: Some(table), ..self })
    }
}

/// Keeps the contour error of one machine of a run over path length, as a controller would record it.
#[derive(Clone, Debug, Default)]
pub struct ErrorRecord {
    /// Place of the machine in the run.
    machine: usize,
    /// Every cycle so far.
    pub rows: Vec<MeasuredError>,
}

impl ErrorRecord {
    /// Of the machine at this place in the run.
    pub fn of(machine: usize) -> ErrorRecord {
        ErrorRecord { machine, rows: Vec::new() }
    }
}

impl Sink for ErrorRecord {
    fn cycle(&mut self, moment: &Moment, machines: &[Option<&Sample>]) {
        let sample = machines.get(self.machine).copied().flatten();
        self.rows.extend(sample.map(|sample| measured(moment, sample)));
    }
}

/// A cycle as it is recorded: the error that the step reports, none in rapid motion.
pub fn measured(moment: &Moment, sample: &Sample) -> MeasuredError {
    let error = sample.contour_um.filter(|_| moment.cutting);
    let error_mm = error.map(|error| error.map(|component| 1e-3 * f64::from(component)));
    MeasuredError { length_mm: moment.length_mm, error_mm }
}

/// A part and what was learned from it.
#[derive(Debug)]
pub struct Part {
    /// True contour error while cutting.
    pub error: ErrorSize,
    /// The same as the step estimates it.
    pub estimated: ErrorSize,
    /// The step asked for a stop.
    pub stopped: bool,
    /// The correction for the next part.
    pub table: Arc<LearnedTable>,
}

/// Makes `parts` parts of a scenario by its full run, the first with the scenario's own learned correction if it has one,
/// each with noise of its own. `progress` gets the fraction done, 0 to 1.
///
/// # Errors
/// As [`Run::of`], [`Scenario::with_learned`] and [`Lesson::learn`].
pub fn parts(scenario: &Scenario, law: &Law, parts: u32, progress: &mut dyn FnMut(f64)) -> Result<Vec<Part>> {
    takes_corrections(scenario)?;
    let identity = identity(scenario, &scenario.motion()?);
    let mut made: Vec<Part> = Vec::new();
    for number in 0..parts {
        let mut this = scenario.clone();
        this.settings.seed = scenario.settings.seed.wrapping_add(number.into()) & i64::MAX as u64;
        let before = made.last().map(|part| Arc::clone(&part.table)).or_else(|| scenario.learned.clone());
        this.learned = before.clone();
        let mut run = Run::of(this, &[Kind::Full])?;
        let mut record = ErrorRecord::of(0);
        while run.advance(STRETCH, &mut record) {
            progress((f64::from(number) + run.cycle() as f64 / run.cycles() as f64) / f64::from(parts));
        }
        let lesson = Lesson::learn(law, &identity, before.as_deref().map(LearnedTable::table), &record.rows)?;
        let table = Arc::new(LearnedTable::read(lesson.to_bytes()?)?);
        for tallies in run.tallies() {
            let (error, estimated, stopped) = (tallies.error, tallies.estimated, tallies.stopped);
            made.push(Part { error, estimated, stopped, table: Arc::clone(&table) });
        }
    }
    Ok(made)
}
