//! Test helpers of the workspace: machines, seeded noise, and programs run in a temporary folder.

pub mod command;
#[path = "../../trueaxis/src/testing/machine.rs"]
pub mod machine;
#[path = "../../trueaxis/src/testing/noise.rs"]
pub mod noise;
