//! Makes consecutive parts of one program, each with the correction learned from those before it.
//!
//! The error to learn from comes from the step's own estimate, with the encoders' noise and resolution, or from a grid
//! encoder.

use crate::error::{Result, SimError};
use crate::motion::Motion;
use crate::run::{ErrorSize, Kind, Moment, Run, Sample, Sink};
use crate::scenario::Scenario;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::sync::Arc;
use trueaxis::learned::{POINTS_EVERY_MM, ProgramId};
use trueaxis::tcomp;

pub use crate::learned::LearnedTable;
pub use trueaxis_metrology::learning::{
    DEFAULT_CUTOFF_MM, DEFAULT_FORGET, DEFAULT_GAIN, Identity, Law, Lesson, MeasuredError,
};

/// Cycles between two reports of progress.
const STRETCH: u64 = 4096;
/// Separates the grid encoder's noise from the other noise.
const GRID_SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// Identity of a scenario's records and corrections; the path is the program's, from its zero, in machine coordinates.
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

/// Refuses a machine whose step adds only the geometric correction to a command.
fn takes_corrections(scenario: &Scenario) -> Result<()> {
    if Kind::of(&scenario.machine.settings).contains(&Kind::Full) {
        return Ok(());
    }
    let (found, needed) = ("a machine without dynamic correction", "[axis.X.dynamic] in its machine.toml");
    Err(SimError::unsuited("learned correction", found, needed))
}

impl Scenario {
    /// Returns the scenario with a learned correction in its full run.
    ///
    /// # Errors
    /// A correction of another machine, program or path length; a machine without dynamic correction, whose step accepts none.
    pub fn with_learned(self, table: Arc<LearnedTable>) -> Result<Scenario> {
        takes_corrections(&self)?;
        let identity = identity(&self, &self.motion()?);
        table.table().expect_machine(identity.machine_id)?;
        table.table().expect_program(identity.program_id, identity.length_mm)?;
        Ok(Scenario { learned: Some(table), ..self })
    }
}

/// Instrument that measures the contour error to learn from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Instrument {
    /// The step: the tip that it estimates from the encoders. It misses the errors that they miss, above all those
    /// between their lines, and is not used while lost motion is being taken up ([`SETTLING_S`]).
    #[default]
    Estimate,
    /// A grid encoder between table and spindle, read in the same cycles as the encoders: the true tip with noise of
    /// [`GRID_NOISE_UM`].
    Grid,
}

/// Time after an axis was limited during which the estimate is not learned from, s: while the correction of lost motion ramps
/// in, the model knows that the axis has reversed, but not how far its carriage has followed.
pub const SETTLING_S: f64 = 0.04;
/// Noise of a grid encoder in each direction, RMS, µm.
pub const GRID_NOISE_UM: f64 = 0.005;

/// Turns the cycles of a run into rows of a record.
#[derive(Clone, Debug)]
pub struct Recorder {
    instrument: Instrument,
    noise: ChaCha8Rng,
    settling: u64,
    /// Cycles since an axis was limited.
    settled: u64,
}

impl Recorder {
    /// Creates a recorder for a scenario, measured by an instrument.
    ///
    /// # Errors
    /// A grid encoder for a program with rotary axes, for which it cannot be set up.
    pub fn new(scenario: &Scenario, instrument: Instrument) -> Result<Recorder> {
        if instrument == Instrument::Grid && scenario.five_axis {
            let (found, needed) = ("a program with rotary axes", "one of X, Y, Z alone");
            return Err(SimError::unsuited("grid encoder", found, needed));
        }
        let settling = (SETTLING_S * scenario.rate_hz()).ceil() as u64;
        let noise = ChaCha8Rng::seed_from_u64(scenario.settings.seed.wrapping_mul(GRID_SEED));
        Ok(Recorder { instrument, noise, settling, settled: settling })
    }

    /// The row of a cycle; rapid motion is not measured.
    pub fn row(&mut self, moment: &Moment, sample: &Sample) -> MeasuredError {
        self.settled = if sample.limited == 0 { self.settled.saturating_add(1) } else { 0 };
        let error_um = match self.instrument {
            Instrument::Estimate => sample.contour_um.filter(|_| self.settled >= self.settling),
            Instrument::Grid => Some(sample.deviation_um),
        };
        let error = error_um.filter(|_| moment.cutting).map(|error| error.map(|component| 1e-3 * f64::from(component)));
        let error_mm = error.map(|error| match self.instrument {
            Instrument::Estimate => error,
            Instrument::Grid => error.map(|component| {
                let noise: f64 = StandardNormal.sample(&mut self.noise);
                component + 1e-3 * GRID_NOISE_UM * noise
            }),
        });
        MeasuredError { length_mm: moment.length_mm, error_mm }
    }
}

/// Keeps the rows of a run's only machine.
struct ErrorRecord {
    recorder: Recorder,
    rows: Vec<MeasuredError>,
}

impl Sink for ErrorRecord {
    fn cycle(&mut self, moment: &Moment, machines: &[Option<&Sample>]) {
        let samples = machines.iter().flatten();
        self.rows.extend(samples.map(|sample| self.recorder.row(moment, sample)));
    }
}

/// A part and the correction learned from it.
#[derive(Debug)]
pub struct Part {
    /// True contour error while cutting.
    pub error: ErrorSize,
    /// Contour error while cutting, as the step estimates it.
    pub estimated: ErrorSize,
    /// Whether the step requested a stop.
    pub stopped: bool,
    /// The correction for the next part.
    pub table: Arc<LearnedTable>,
}

/// Makes `parts` parts of a scenario by its full run, the first with the scenario's own learned correction if it has one, each
/// with different noise. `progress` gets the fraction done, 0 to 1.
///
/// # Errors
/// As [`Run::of`], [`Scenario::with_learned`] and [`Lesson::learn`].
pub fn parts(
    scenario: &Scenario,
    law: &Law,
    instrument: Instrument,
    parts: u32,
    progress: &mut dyn FnMut(f64),
) -> Result<Vec<Part>> {
    takes_corrections(scenario)?;
    let identity = identity(scenario, &scenario.motion()?);
    let mut made: Vec<Part> = Vec::new();
    for number in 0..parts {
        let mut this = scenario.clone();
        this.settings.seed = scenario.settings.seed.wrapping_add(number.into()) & i64::MAX as u64;
        let before = made.last().map(|part| Arc::clone(&part.table)).or_else(|| scenario.learned.clone());
        this.learned = before.clone();
        let mut record = ErrorRecord { recorder: Recorder::new(&this, instrument)?, rows: Vec::new() };
        let mut run = Run::of(this, &[Kind::Full])?;
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
