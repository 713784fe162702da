//! The simulation.

mod common;
mod events;
mod friction;
mod full;
mod motion;
mod program;
mod run;
mod settings;
mod warming;
