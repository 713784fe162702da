//! Details of a refusal, for the operator's screen and the log.

use crate::part::LeftOut;
use crate::pointer::{Sized32, check_sized};
use crate::result::{
    ERROR_CONFIG, ERROR_LEARNED, ERROR_LEFT_OUT, ERROR_MACHINE, ERROR_MEMORY, ERROR_PATH, ERROR_POSE, ERROR_TABLES,
    ERROR_THERMAL, ResultCode,
};
use crate::text::{TEXT, Text};
use core::ffi::c_char;
use core::fmt;
use trueaxis::ConfigError;
use trueaxis::contour::PathError;
use trueaxis::error::Field;
use trueaxis::kinematics::InverseError;
use trueaxis::learned::LearnedError;
use trueaxis::tcomp::TcompError;
use trueaxis::temperature::ThermalError;

/// Details of a refusal, ready to print.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Error {
    /// `sizeof(trueaxis_error_t)`.
    pub size: u32,
    /// Result that the function returned.
    pub result: ResultCode,
    /// Detail of `result`, 0 if it has none:
    /// - Table file: 1 too short, 2 too long, 3 not a `.tcomp`, 4 other format version, 5 wrong CRC-32, 6 settings not
    ///   readable, 7 table header not readable, 8 table too long, 9 payload too long, 10 machine id does not match the
    ///   name, 11 contents out of range (see `field`), 12 other machine, 13 grid header not readable, 14 grid too long.
    /// - Learned correction: 1 too short, 2 too long, 3 not a learned correction, 4 other format version, 5 wrong
    ///   CRC-32, 6 spacing, 7 resolution, 8 parts, 9 number of nodes, 10 not 0 at its ends, 11 other program, 12 other
    ///   path length, 13 other machine.
    /// - Thermal growth: 1 to 5 as for a learned correction, 6 sensors, 7 axes, 8 number of knots, 9 order of knots, 10
    ///   a time, 11 plausible readings, 12 an axis, 13 not 0, 14 a slope, 15 other machine.
    /// - Part left out: 1 grids, 2 volumetric, 3 rotary, 4 dynamic, 5 gauge, 6 curves, 7 toolpath, 8 growth.
    pub code: u32,
    /// Index of the element, from 0 (row of a table, knot of a spline); `UINT32_MAX` if the value is not in a list.
    pub index: u32,
    /// Value found, in mm, degrees or seconds; for lent memory in bytes.
    pub found: f64,
    /// Letter of the axis, or 0.
    pub axis: c_char,
    /// Name of the setting, or of the part of a segment; may be empty. In a library without texts `#` and the number of
    /// the setting: `trueaxis explain setting NUMBER`.
    pub field: [c_char; 31],
    /// Requirement that the value does not meet; may be empty.
    pub needed: [c_char; 128],
    /// The whole refusal in one line of UTF-8.
    pub text: [c_char; 256],
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for Error {}

/// Reason why a function refuses.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Refusal {
    /// A result code without further details.
    Code(ResultCode),
    /// The table file.
    Tables(TcompError),
    /// The configuration.
    Config(ConfigError),
    /// Memory in bytes: lent, needed.
    Memory(usize, usize),
    /// A function of a part that this build leaves out.
    LeftOut(LeftOut),
    /// A segment of a path.
    Path(PathError),
    /// A pose of the tool.
    Pose(InverseError),
    /// A learned correction.
    Learned(LearnedError),
    /// Thermal growth.
    Thermal(ThermalError),
}

impl From<ResultCode> for Refusal {
    fn from(code: ResultCode) -> Self {
        Refusal::Code(code)
    }
}

impl From<LeftOut> for Refusal {
    fn from(part: LeftOut) -> Self {
        Refusal::LeftOut(part)
    }
}

impl From<TcompError> for Refusal {
    fn from(error: TcompError) -> Self {
        Refusal::Tables(error)
    }
}

impl From<ConfigError> for Refusal {
    fn from(error: ConfigError) -> Self {
        Refusal::Config(error)
    }
}

impl From<LearnedError> for Refusal {
    fn from(error: LearnedError) -> Self {
        Refusal::Learned(error)
    }
}

impl From<ThermalError> for Refusal {
    fn from(error: ThermalError) -> Self {
        Refusal::Thermal(error)
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::Code(code) => crate::result::text(*code).to_str().unwrap_or_default().fmt(f),
            Refusal::Tables(error) => write!(f, "table file: {error}"),
            Refusal::Config(error) => error.fmt(f),
            Refusal::Memory(lent, needed) => write!(f, "memory: found {lent} bytes, needed {needed} bytes"),
            Refusal::LeftOut(LeftOut(part)) => {
                let name = part.name;
                write!(f, "the function needs the part {name}, which this build of the library leaves out")
            }
            Refusal::Path(error) => error.fmt(f),
            Refusal::Pose(error) => write!(f, "pose: {error}"),
            Refusal::Learned(error) => write!(f, "learned correction: {error}"),
            Refusal::Thermal(error) => write!(f, "thermal growth: {error}"),
        }
    }
}

impl Refusal {
    pub(crate) fn code(&self) -> ResultCode {
        match self {
            Refusal::Code(code) => *code,
            Refusal::Tables(TcompError::WrongMachine) => ERROR_MACHINE,
            Refusal::Tables(TcompError::Content(ConfigError { left_out: Some(_), .. }))
            | Refusal::Config(ConfigError { left_out: Some(_), .. })
            | Refusal::LeftOut(_) => ERROR_LEFT_OUT,
            Refusal::Tables(_) => ERROR_TABLES,
            Refusal::Config(ConfigError { field: Field::Memory, .. }) | Refusal::Memory(..) => ERROR_MEMORY,
            Refusal::Config(_) => ERROR_CONFIG,
            Refusal::Path(_) => ERROR_PATH,
            Refusal::Pose(_) => ERROR_POSE,
            Refusal::Learned(LearnedError::WrongMachine { .. }) => ERROR_MACHINE,
            Refusal::Learned(_) => ERROR_LEARNED,
            Refusal::Thermal(ThermalError::WrongMachine { .. }) => ERROR_MACHINE,
            Refusal::Thermal(_) => ERROR_THERMAL,
        }
    }

    fn details(&self) -> Error {
        let mut error = Error {
            size: size_of::<Error>() as u32,
            result: self.code(),
            code: 0,
            index: u32::MAX,
            found: 0.0,
            axis: 0,
            field: [0; _],
            needed: [0; _],
            text: Text::of(self),
        };
        match self {
            Refusal::Code(_) | Refusal::Pose(_) => {}
            Refusal::Tables(tables) => {
                error.code = tables.code().into();
                if let TcompError::Content(config) = tables {
                    error.add(config);
                }
            }
            Refusal::Config(config) => error.add(config),
            Refusal::LeftOut(LeftOut(part)) => {
                error.code = part.code.into();
                error.needed = Text::of(&part.name);
            }
            Refusal::Learned(learned) => error.code = learned.code().into(),
            Refusal::Thermal(thermal) => error.code = thermal.code().into(),
            Refusal::Memory(lent, needed) => {
                error.found = *lent as f64;
                error.field = named(Field::Memory);
                error.needed = Text::of(&format_args!("{needed} bytes"));
            }
            Refusal::Path(path) => {
                error.index = path.index.and_then(|index| u32::try_from(index).ok()).unwrap_or(u32::MAX);
                error.found = path.found;
                error.field = Text::of(&path.field);
                error.needed = Text::of(&path.needed);
            }
        }
        error
    }
}

/// The name of a setting, or its number in a build without texts.
fn named<const N: usize>(field: Field) -> [c_char; N] {
    if TEXT { Text::of(&format_args!("{field:?}")) } else { Text::numbered(field.code()) }
}

impl Error {
    fn add(&mut self, config: &ConfigError) {
        if let Some(part) = config.left_out {
            self.code = part as u32;
        }
        self.index = config.index.unwrap_or(u32::MAX);
        self.found = config.found;
        self.axis = config.axis.map_or(0, |axis| axis.letter() as c_char);
        self.field = named(config.field);
        self.needed = Text::of(&config.needed);
    }
}

/// Runs `work` and, if it refuses, writes the details to `error` (nowhere if that is null).
///
/// # Safety
/// `error` is null, misaligned, or points to as many readable and writable bytes as its member `size` says.
pub(crate) unsafe fn explained(error: *mut Error, work: impl FnOnce() -> Result<(), Refusal>) -> ResultCode {
    if !error.is_null() {
        // SAFETY: the caller's promise.
        if let Err(code) = unsafe { check_sized(error) } {
            return code;
        }
    }
    let Err(refusal) = work() else { return crate::result::OK };
    if !error.is_null() {
        // SAFETY: checked above: aligned, of the right size; writable by the caller's promise.
        unsafe { error.write(refusal.details()) };
    }
    refusal.code()
}
