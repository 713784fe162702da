//! The simulation.

mod common;
mod events;
mod friction;
mod full;
mod interpreter;
mod legs;
mod motion;
mod periodic;
mod probing_moves;
mod program;
mod readings;
mod run;
mod settings;
mod warming;
