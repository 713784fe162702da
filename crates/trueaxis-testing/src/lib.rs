//! Test helpers of the workspace: machines, seeded noise, a control that runs probing programs, and programs run in a temporary folder.

pub mod command;
pub mod control;
pub mod covariance;
// `trueaxis` compiles this file too: its unit tests need machines of the types of that build.
#[path = "../../trueaxis/src/testing/machine.rs"]
pub mod machine;
pub mod noise;
pub mod scatter;
pub mod share;

// `machine.rs` names the core by its parent's `trueaxis`, which in the core's own unit tests is the crate itself.
extern crate trueaxis;
