//! Details of a refusal, for the operator's screen and the log.

use crate::pointer::{Sized32, check_sized};
use crate::status::{ERROR_CONFIG, ERROR_MACHINE, ERROR_MEMORY, ERROR_PATH, ERROR_TABLES, Status};
use crate::text::Text;
use core::ffi::c_char;
use core::fmt;
use trueaxis::ConfigError;
use trueaxis::contour::PathError;
use trueaxis::error::Field;
use trueaxis::tcomp::TcompError;

/// Why something was refused, ready to print.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Error {
    /// `sizeof(trueaxis_error_t)`, set by the caller once; stays as it is.
    pub size: u32,
    /// The status that the function returned.
    pub status: Status,
    /// Number of the table file's fault: 1 too short, 2 too long, 3 not a `.tcomp`, 4 other format version, 5 CRC-32
    /// wrong, 6 settings and 7 table header cannot be decoded, 8 table or 9 payload too long, 10 machine id contradicts
    /// the name, 11 contents make no sense (then `field`, `found` and `needed` tell which), 12 other machine. 0: not about
    /// a table file.
    pub code: u32,
    /// Element of the setting that is wrong, from 0 (row of a table, knot of a spline); `UINT32_MAX` if it is no list.
    pub index: u32,
    /// What was found, in mm, degrees or seconds.
    pub found: f64,
    /// Letter of the axis at fault, 0 if it is none's.
    pub axis: c_char,
    /// Name of the setting (of a segment: of the part) at fault; empty if it is none's.
    pub field: [c_char; 31],
    /// What is needed instead; empty if nothing can be said.
    pub needed: [c_char; 128],
    /// All of it in one line of UTF-8 without a line feed.
    pub text: [c_char; 256],
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for Error {}

/// Why a function refuses.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Refusal {
    /// Without further details.
    Status(Status),
    /// The table file.
    Tables(TcompError),
    /// The configuration.
    Config(ConfigError),
    /// Bytes of memory: lent, needed.
    Memory(usize, usize),
    /// A segment of a path.
    Path(PathError),
}

impl From<Status> for Refusal {
    fn from(status: Status) -> Self {
        Refusal::Status(status)
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

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::Status(status) => crate::status::text(*status).to_str().unwrap_or_default().fmt(f),
            Refusal::Tables(error) => write!(f, "table file: {error}"),
            Refusal::Config(error) => error.fmt(f),
            Refusal::Memory(lent, needed) => write!(f, "memory: found {lent} bytes, needed {needed} bytes"),
            Refusal::Path(error) => error.fmt(f),
        }
    }
}

impl Refusal {
    pub(crate) fn status(&self) -> Status {
        match self {
            Refusal::Status(status) => *status,
            Refusal::Tables(TcompError::WrongMachine) => ERROR_MACHINE,
            Refusal::Tables(_) => ERROR_TABLES,
            Refusal::Config(ConfigError { field: Field::Memory, .. }) | Refusal::Memory(..) => ERROR_MEMORY,
            Refusal::Config(_) => ERROR_CONFIG,
            Refusal::Path(_) => ERROR_PATH,
        }
    }

    fn details(&self) -> Error {
        let mut error = Error {
            size: size_of::<Error>() as u32,
            status: self.status(),
            code: 0,
            index: u32::MAX,
            found: 0.0,
            axis: 0,
            field: [0; _],
            needed: [0; _],
            text: Text::of(self),
        };
        match self {
            Refusal::Status(_) => {}
            Refusal::Tables(tables) => {
                error.code = tables.code().into();
                if let TcompError::Content(config) = tables {
                    error.add(config);
                }
            }
            Refusal::Config(config) => error.add(config),
            Refusal::Memory(lent, needed) => {
                error.found = *lent as f64;
                error.field = Text::of(&"Memory");
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

impl Error {
    fn add(&mut self, config: &ConfigError) {
        self.index = config.index.unwrap_or(u32::MAX);
        self.found = config.found;
        self.axis = config.axis.map_or(0, |axis| axis.letter() as c_char);
        self.field = Text::of(&format_args!("{:?}", config.field));
        self.needed = Text::of(&config.needed);
    }
}

/// Runs a function that can say what is wrong, and writes that where the caller wants it (nowhere if null).
///
/// # Safety
/// `error` is null, misaligned, or points to as many readable and writable bytes as its member `size` says.
pub(crate) unsafe fn explained(error: *mut Error, work: impl FnOnce() -> Result<(), Refusal>) -> Status {
    if !error.is_null() {
        // SAFETY: the caller's promise.
        if let Err(status) = unsafe { check_sized(error) } {
            return status;
        }
    }
    let Err(refusal) = work() else { return crate::status::OK };
    if !error.is_null() {
        // SAFETY: checked above: aligned, of the right size; writable by the caller's promise.
        unsafe { error.write(refusal.details()) };
    }
    refusal.status()
}
