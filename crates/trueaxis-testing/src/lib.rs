//! Test helpers of the workspace: machines, seeded noise, a control that runs probing programs, and programs run in a temporary folder.

pub mod command;
pub mod control;
#[path = "../../trueaxis/src/testing/machine.rs"]
pub mod machine;
#[path = "../../trueaxis/src/testing/noise.rs"]
pub mod noise;
#[path = "../../trueaxis/src/testing/share.rs"]
pub mod share;
