//! Reasons why something cannot be simulated.

use crate::motion::MotionError;
use crate::plant::PlantError;
use crate::program::ProgramError;
use crate::settings::SettingError;
use trueaxis::contour::PathError;
use trueaxis::learned::LearnedError;
use trueaxis::tcomp::TcompError;
use trueaxis::{ConfigError, Fault};
use trueaxis_metrology::identification::IdentificationRefusal;
use trueaxis_metrology::learning::NotLearned;
use trueaxis_tables::exact::GeometryError;

/// A machine, a program or settings that cannot be simulated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// The program, with its line.
    #[error(transparent)]
    Program(#[from] ProgramError),
    /// A program's file.
    #[error("cannot read the program {file}: {error}")]
    Unread {
        /// The file.
        file: String,
        /// The reason.
        error: std::io::Error,
    },
    /// The machine's structure.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A setting.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The plant.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// The machine's settings or tables.
    #[error("{0}")]
    Config(#[from] ConfigError),
    /// The machine's kinematics.
    #[error("kinematics: {0}")]
    Kinematics(ConfigError),
    /// The gauge's settings.
    #[error("[roundness]: {0}")]
    Gauge(ConfigError),
    /// The tables as compiled.
    #[error("compiled tables: {0}")]
    Tables(#[from] TcompError),
    /// A learned correction.
    #[error("learned correction: {0}")]
    Learned(#[from] LearnedError),
    /// A record from which no correction can be learned.
    #[error("learning: {0}")]
    NotLearned(#[from] NotLearned),
    /// A record from which thermal growth cannot be identified.
    #[error("thermal growth: {0}")]
    Thermal(#[from] trueaxis_metrology::thermal::ThermalRefusal),
    /// The program's motion.
    #[error("{program}: {error}")]
    Motion {
        /// Name of the program.
        program: String,
        /// The planner's reason.
        error: MotionError,
    },
    /// A move that is not a valid path.
    #[error("{program}, line {line}: {error}")]
    Path {
        /// Name of the program.
        program: String,
        /// Line, from 1.
        line: u32,
        /// The reason.
        error: PathError,
    },
    /// A line of the program that the machine cannot run.
    #[error("{program}, line {line}: {found}, needed {needed}")]
    Line {
        /// Name of the program.
        program: String,
        /// Line, from 1.
        line: u32,
        /// Target of the line.
        found: String,
        /// Accepted alternative.
        needed: String,
    },
    /// An unsuitable machine or setting.
    #[error("{what}: found {found}, needed {needed}")]
    Unsuited {
        /// The machine or setting.
        what: String,
        /// State found.
        found: String,
        /// Accepted alternative.
        needed: String,
    },
    /// Tables for an exchange that the plugin cannot use.
    #[error("exchange:{name}: {error}")]
    Exchange {
        /// Name of the machine in the event.
        name: String,
        /// The reason.
        error: Box<SimError>,
    },
    /// A fault that the step reports where none may occur.
    #[error("the step reports {fault:?} after {turns:.2} turns")]
    Fault {
        /// Fault code.
        fault: Fault,
        /// Turns of the spindle until the fault.
        turns: f64,
    },
    /// A spindle that does not complete its turns.
    #[error("the spindle has not turned {revolutions} times within {cycles} cycles")]
    Spindle {
        /// Turns required.
        revolutions: u32,
        /// Cycles simulated.
        cycles: u64,
    },
    /// Recorded circles from which friction cannot be identified.
    #[error("{of}: {error}")]
    Friction {
        /// The record.
        of: &'static str,
        /// The reason.
        error: trueaxis_metrology::friction::FrictionRefusal,
    },
    /// Errors that cannot be identified from readings.
    #[error("{at}: {error}")]
    Identification {
        /// Axis or pose.
        at: String,
        /// The reason.
        error: IdentificationRefusal,
    },
}

impl SimError {
    pub(crate) fn unsuited(what: impl Into<String>, found: impl Into<String>, needed: impl Into<String>) -> SimError {
        SimError::Unsuited { what: what.into(), found: found.into(), needed: needed.into() }
    }
}

/// Result with a [`SimError`].
pub type Result<T, E = SimError> = std::result::Result<T, E>;
