//! Keeps a machine accurate: its probe touches balls that stay in place again every so many parts, and the balls' positions
//! yield updates of the machine's location errors and growth.
//!
//! ```text
//! keep.toml ─► KeepTask ─► plan ─► program ─► (control, between parts) ─► log ─► Reprobing ─► verdicts ─► files of the machine
//!                                                                                ▲                             │
//!                                                 places of the balls at the beginning, totals ◄─ History ◄────┘
//! ```
//!
//! The machine's tables correct it during probing: a probing measures the residual that they leave, and the update adds it to
//! them.
//!
//! A ball that no rotary axis turns is a single point: it determines the three offsets of the tool at its position, but not
//! their cause. Two balls apart along an axis determine its scale, two apart across it a squareness, as long as their support
//! keeps its shape. A ball turned by a rotary axis determines the position and tilt of that axis, even if no ball's position
//! is known.
//!
//! The mathematics is [`trueaxis_metrology::calibration`].

mod document;
mod entry;
mod evaluated;
mod figures;
mod folder;
mod foreseen;
mod growth;
mod history;
mod reprobing;
mod shown;
mod state;

mod task;
mod undo;
mod update;
mod words;
mod written;

pub use document::{ReprobingDocument, TermDocument};
pub use entry::{BallPlace, Changed, Entry, EntryKind, LogFile, Measured};
pub use evaluated::{EvaluatedLog, Log, Overrides, time};
pub use figures::figures;
pub use foreseen::{Expected, Foreseen, Planning};
pub use history::{History, sum};
pub use reprobing::{Before, Decision, Reprobing, Verdict, begin, evaluate, foreseen, plan};
pub use shown::listed;
pub use state::{HISTORY, State};
pub use task::{Bounds, Home, KeepTask, KeptTerm};
pub use undo::Undone;
pub use update::{Changes, changes};
pub use words::descriptions;
pub use written::{FileChanges, Written};
