//! The simulation.

mod common;
mod events;
mod friction;
mod full;
mod legs;
mod motion;
mod program;
mod readings;
mod run;
mod settings;
mod warming;
