//! Tables out of flash into the form for the step, or the reason why not.

use crate::scalars::{GaugePlan, Loop, Scalar};
use defmt::Format;
use trueaxis::error::Field;
use trueaxis::roundness::GaugeSettings;
use trueaxis::tcomp::{Tcomp, TcompError};
use trueaxis::{ConfigError, Fault};

/// Memory of one set of tables, in scalars. The machine of `../machine` takes 2,116 (`trueaxis tables show`); the rest is
/// room for its tables in the dearest form, volumetric and cubic: 6,084.
pub const MEMORY: usize = 6 * 1024;

/// Why tables are not taken.
#[derive(Clone, Copy, Debug, Format)]
pub enum Refused {
    /// Defect of the file.
    File(TcompError),
    /// Scalars that the tables need; there are [`MEMORY`].
    Capacity { needed: usize },
    /// The gauge is made for another number of points.
    Points(ConfigError),
    /// The cycles' period, ns, is not the configured one.
    Period { found: u32, configured: u32 },
    /// Settings from which the step cannot be built.
    Config(ConfigError),
}

impl Refused {
    /// Fault reported in every record.
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

/// A step, ready to run, and the other contents of its file.
pub struct Tables {
    /// The step.
    pub servo: Loop,
    /// The file, for its settings.
    pub file: Tcomp<'static>,
    /// Memory taken.
    pub used: usize,
}

/// Reads and checks a table file, and builds its step.
///
/// # Errors
/// Why the tables are not taken.
pub fn build(
    bytes: &'static [u8],
    machine_id: u32,
    period_ns: u32,
    memory: &'static mut [Scalar; MEMORY],
) -> Result<Tables, Refused> {
    let file = Tcomp::parse(bytes).map_err(Refused::File)?;
    file.expect_machine(machine_id).map_err(Refused::File)?;
    let used = file.requirement();
    if used > MEMORY {
        return Err(Refused::Capacity { needed: used });
    }
    let servo = Loop::load(&file, period_ns, memory)?;
    Ok(Tables { servo, file, used })
}

/// The gauge that a file describes, if it does.
///
/// # Errors
/// Another number of points than this image's, or settings that it cannot be built from.
pub fn gauge(settings: Option<&GaugeSettings>, period_ns: u32) -> Result<Option<GaugePlan>, Refused> {
    Ok(settings.map(|settings| GaugePlan::build(settings, period_ns)).transpose()?)
}
