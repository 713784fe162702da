//! A machine that keeps itself accurate: balls that stay in place, re-probed every so many parts, and the location errors and
//! growth of the machine that follow from their positions.
//!
//! ```text
//! keep.toml ─► Keep ─► plan ─► program ─► (control, between parts) ─► log ─► Reprobing ─► verdicts ─► files of the machine
//!                                                                            ▲                             │
//!                                             places of the balls at the beginning, totals ◄─ History ◄────┘
//! ```
//!
//! The machine's tables correct it during probing: a probing finds the residual that they leave, which is added to them.
//!
//! A ball that is not rotated is a point: it determines the three offsets of the tool at its position, but not their cause.
//! Two balls apart along an axis determine its scale, two apart across it a squareness, as long as their support keeps its
//! shape. A ball rotated by a rotary axis determines the position and tilt of that axis, without any ball's position being
//! known.
//!
//! The mathematics is [`trueaxis_metrology::calibration`].

mod document;
mod entry;
mod figures;
mod folder;
mod foreseen;
mod growth;
mod history;
mod reprobing;
mod state;
mod taken;
mod task;
mod undo;
mod update;
mod words;
mod written;

pub use document::{Document, TermDocument};
pub use entry::{BallPlace, Changed, Deed, Entry, LogFile, Measured};
pub use figures::figures;
pub use foreseen::{Expected, Foreseen, Planning};
pub use history::{History, sum};
pub use reprobing::{Before, Decision, Reprobing, Verdict, begin, evaluate, foreseen, plan};
pub use state::{HISTORY, State};
pub use taken::{Let, Log, Taken, time};
pub use task::{Bounds, Home, Keep, Kept};
pub use undo::Undone;
pub use update::{Changes, changes};
pub use words::deeds;
pub use written::{New, Written};
