//! The simulation.

mod common;
mod events;
mod friction;
mod full;
mod legs;
mod motion;
mod program;
mod run;
mod settings;
mod warming;
