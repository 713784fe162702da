//! The walk: one model of the step's contract, checked on random sequences.
//!
//! A *leg* runs one [`Combination`] with machines of its own: plausible motion with events in between, every cycle seen by
//! the `Contract`. It is drawn from a seed and its number alone, so that any failure is repeated by both.

mod beside;
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

pub use combination::{Combination, Measured, Numbers};
pub use event::{Event, Events};
pub use leg::{Failure, Leg, Walked};
pub use planted::Planted;
pub use rule::{Broken, Rule, Tally};
pub use soak::{Report, Soak, Spoilt};
