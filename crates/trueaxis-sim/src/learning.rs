//! Parts of one program after another, each with the correction learned from those before.
//!
//! Learned is from what the step itself estimates, by encoders with their noise and steps, or from what a grid encoder
//! measures.

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

/// Cycles between two looks at the progress.
const STRETCH: u64 = 4096;
/// Keeps the noise of the grid encoder apart from that of the others.
const GRID_SEED: u64 = 0x9e37_79b9_7f4a_7c15;

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

/// What measures the contour error that is learned from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Instrument {
    /// The step: the tip that it estimates from the encoders. It does not see what they do not, the errors between their
    /// lines above all, and is left out while lost motion is being taken up ([`SETTLING_S`]).
    #[default]
    Estimate,
    /// A grid encoder between table and spindle, read along with the encoders: the true tip with noise of [`GRID_NOISE_UM`].
    Grid,
}

/// After an axis was limited, the estimate is not learned from for this long, s: while lost motion is led in, the model
/// knows that the axis has turned, not how far its carriage has come.
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
    /// Of a scenario, measured by an instrument.
    ///
    /// # Errors
    /// A grid encoder for a program with rotary axes, along which it cannot be set up.
    pub fn new(scenario: &Scenario, instrument: Instrument) -> Result<Recorder> {
        if instrument == Instrument::Grid && scenario.five_axis {
            let (found, needed) = ("a program with rotary axes", "one of X, Y, Z alone");
            return Err(SimError::unsuited("grid encoder", found, needed));
        }
        let settling = (SETTLING_S * scenario.rate_hz()).ceil() as u64;
        let noise = ChaCha8Rng::seed_from_u64(scenario.settings.seed.wrapping_mul(GRID_SEED));
        Ok(Recorder { instrument, noise, settling, settled: settling })
    }

    /// The row of a cycle: nothing is measured in rapid motion.
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
