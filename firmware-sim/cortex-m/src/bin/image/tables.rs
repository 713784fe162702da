//! Tables out of flash into the form for the step, or the reason why not.

use crate::scalars::{AXES, GaugePlan, Loop, Place, Scalar};
use defmt::Format;
use trueaxis::compensation::{Requirement, Storage};
use trueaxis::error::Field;
use trueaxis::roundness::GaugeSettings;
use trueaxis::tcomp::{Tcomp, TcompError};
use trueaxis::{Config, ConfigError, Fault};

/// Lines of numbers that fit: cubic tables of 3 × 1024 points with one direction, or half as many with both; four
/// contributions of four coefficients a point.
pub const LINES: usize = 3 * 1024 * 16;
/// Positions of free grids that fit: 3 × 1024 points.
pub const KNOTS: usize = 3 * 1024;
/// Entries of search guides that fit.
pub const GUIDE: usize = 2 * KNOTS;

/// Memory of one set of tables.
pub struct Memory {
    lines: [Scalar; LINES],
    knots: [Scalar; KNOTS],
    guide: [u16; GUIDE],
}

impl Memory {
    /// Nothing in it: zeros, so that a static of it takes no flash.
    pub const EMPTY: Memory = Memory { lines: [0.0; LINES], knots: [0.0; KNOTS], guide: [0; GUIDE] };

    fn lend(&'static mut self) -> Storage<'static, Scalar> {
        Storage { lines: &mut self.lines, knots: &mut self.knots, guide: &mut self.guide }
    }
}

/// Why tables are not taken.
#[derive(Clone, Copy, Debug, Format)]
pub enum Refused {
    /// What is wrong with the file.
    File(TcompError),
    /// Lines and positions of free grids that the tables need; there are [`LINES`] and [`KNOTS`].
    Capacity { lines: usize, knots: usize },
    /// The gauge is made for another number of points.
    Points(ConfigError),
    /// The cycles' period, ns, is not the configured one.
    Period { found: u32, configured: u32 },
    /// What the step cannot be built from.
    Config(ConfigError),
}

impl Refused {
    /// What every record says of it.
    pub fn fault(&self) -> Fault {
        match self {
            Refused::Capacity { .. } | Refused::Points(_) => Fault::CapacityTooSmall,
            Refused::Period { .. } => Fault::PeriodMismatch,
            Refused::File(_) | Refused::Config(_) => Fault::TablesRefused,
        }
    }

    /// The file's code (see the format's table of refusals), 0 if the file is not to blame.
    pub fn code(&self) -> u8 {
        match self {
            Refused::File(error) => error.code(),
            _ => 0,
        }
    }
}

impl From<ConfigError> for Refused {
    fn from(error: ConfigError) -> Self {
        match error.field {
            Field::Points => Refused::Points(error),
            _ => Refused::Config(error),
        }
    }
}

/// A step, ready to run, and what its file says besides.
pub struct Tables {
    /// The step.
    pub servo: Loop,
    /// The file, for its settings.
    pub file: Tcomp<'static>,
    /// Memory taken.
    pub used: Requirement,
}

/// Reads and checks a table file, and builds its step.
///
/// # Errors
/// Why the tables are not taken.
pub fn build(
    bytes: &'static [u8],
    machine_id: u32,
    period_ns: u32,
    memory: &'static mut Memory,
) -> Result<Tables, Refused> {
    let file = Tcomp::parse(bytes).map_err(Refused::File)?;
    file.expect_machine(machine_id).map_err(Refused::File)?;
    let config = Config::of(&file, period_ns);
    let used = config.requirement(|axis| file.table(axis));
    let Requirement { lines, knots, guide } = used;
    if lines > LINES || knots > KNOTS || guide > GUIDE {
        return Err(Refused::Capacity { lines, knots });
    }
    let servo = config.build::<Scalar, Place, AXES, _>(|axis| file.table(axis), &mut memory)?;
    Ok(Tables { servo, file, used })
}

/// The gauge that a file describes, if it does.
///
/// # Errors
/// Another number of points than this image's, or settings that it cannot be built from.
pub fn gauge(settings: Option<&GaugeSettings>, period_ns: u32) -> Result<Option<GaugePlan>, Refused> {
    Ok(settings.map(|settings| GaugePlan::build(settings, period_ns)).transpose()?)
}
