//! Builds the step from tables in flash, or returns the reason for refusing them.

use crate::scalars::{GaugePlan, Loop, Scalar};
use defmt::Format;
use trueaxis::error::Field;
use trueaxis::{ConfigError, Fault, Tcomp, TcompError};

/// Memory of one set of tables, in scalars. The machine of `../machine` uses 2,116 (`trueaxis tables show`); the most
/// expensive form of its tables, volumetric and cubic, would use 6,084.
pub const MEMORY: usize = 6 * 1024;

/// Reason for refusing tables.
#[derive(Clone, Copy, Debug, Format)]
pub enum TablesRefusal {
    /// Defect of the file.
    File(TcompError),
    /// The tables need more scalars than [`MEMORY`].
    Capacity { needed: usize },
    /// The gauge has another number of points.
    Points(ConfigError),
    /// The period of the cycles, ns, differs from the configured one.
    Period { found: u32, configured: u32 },
    /// The step cannot be built from the settings.
    Config(ConfigError),
}

impl TablesRefusal {
    /// Fault reported in every record.
    pub fn fault(&self) -> Fault {
        match self {
            TablesRefusal::Capacity { .. } | TablesRefusal::Points(_) => Fault::CapacityTooSmall,
            TablesRefusal::Period { .. } => Fault::PeriodMismatch,
            TablesRefusal::File(_) | TablesRefusal::Config(_) => Fault::TablesRefused,
        }
    }

    /// The file's code (see the format's table of refusals), 0 if the file is not to blame.
    pub fn code(&self) -> u8 {
        match self {
            TablesRefusal::File(error) => error.code(),
            _ => 0,
        }
    }
}

impl From<ConfigError> for TablesRefusal {
    fn from(error: ConfigError) -> Self {
        match error.field {
            Field::Points => TablesRefusal::Points(error),
            _ => TablesRefusal::Config(error),
        }
    }
}

/// A step that is ready to run, and the other contents of its file.
pub struct Tables {
    /// The step.
    pub servo: Loop,
    /// The file, for its settings.
    pub file: Tcomp<'static>,
    /// Memory used, in scalars.
    pub used: usize,
}

/// Reads and checks a table file, and builds its step.
///
/// # Errors
/// The reason for refusing the tables.
pub fn build(
    bytes: &'static [u8],
    machine_id: u32,
    period_ns: u32,
    memory: &'static mut [Scalar; MEMORY],
) -> Result<Tables, TablesRefusal> {
    let file = Tcomp::parse(bytes).map_err(TablesRefusal::File)?;
    file.expect_machine(machine_id).map_err(TablesRefusal::File)?;
    let used = file.requirement();
    if used > MEMORY {
        return Err(TablesRefusal::Capacity { needed: used });
    }
    let servo = Loop::load(&file, period_ns, memory)?;
    Ok(Tables { servo, file, used })
}

/// The gauge that a file describes, if any.
///
/// # Errors
/// The number of points differs from this image's, or the gauge cannot be built from the settings.
pub fn gauge(file: &Tcomp<'_>, period_ns: u32) -> Result<Option<GaugePlan>, TablesRefusal> {
    Ok(file.gauge(period_ns)?)
}
