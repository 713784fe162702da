//! A machine that keeps itself true: balls that stay where they are, re-probed every so many parts, and what their places say
//! of the machine's location and growth.
//!
//! ```text
//! keep.toml ─► Keep ─► plan ─► program ─► (control, between parts) ─► log ─► Look ─► verdicts ─► files of the machine
//!                                                                            ▲                        │
//!                                             places of the balls at the beginning, totals ◄─ History ◄┘
//! ```
//!
//! The machine is corrected by its tables while it is probed: what a look finds is what they leave, and is added to them.
//!
//! A ball that is not turned is a point: it tells the three offsets of the tool at its place, and nothing of their cause. Two
//! balls apart along an axis tell its scale, two apart across it a squareness, as long as what they stand on keeps its shape.
//! A ball turned by a rotary axis tells where that axis lies and how it is tilted, without any place of a ball being known.
//!
//! The mathematics is [`trueaxis_metrology::calibration`].

mod document;
mod entry;
mod figures;
mod folder;
mod foreseen;
mod growth;
mod history;
mod look;
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
pub use look::{Before, Decision, Look, Verdict, begin, foreseen, look, plan};
pub use state::{HISTORY, State};
pub use taken::{Let, Log, Taken, time};
pub use task::{Bounds, Home, Keep, Kept};
pub use undo::Undone;
pub use update::{Changes, changes};
pub use words::deeds;
pub use written::{New, Written};
