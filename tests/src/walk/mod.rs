//! The walk: a single model of the step's contract, checked on random sequences.
//!
//! A *leg* runs one [`Combination`] with machines drawn for it: plausible motion with events in between, every cycle checked
//! by the `Contract`. It is drawn only from a seed and its number, so that these two reproduce any failure.

mod combination;
mod contract;
mod course;
mod device;
mod dice;
mod digest;
mod disturb;
mod drawn;
mod event;
mod facts;
mod gauge;
mod home;
mod host;
mod leg;
mod machines;
mod motion;
mod planted;
mod rule;
mod sample;
mod scalar;
mod servo;
mod soak;
mod spindle;
mod through;
mod walker;
mod without_cycles;

pub use combination::{Combination, Measured, Numbers};
pub use event::{Event, Events};
pub use leg::{Failure, Leg, Walked};
pub use planted::Planted;
pub use rule::{Broken, Rule, Tally};
pub use soak::{Report, Soak, Spoilt};
