//! Helpers of the unit tests: those of `trueaxis-testing`.
//!
//! That crate compiles `machine.rs` too, for the tests of every other crate: a unit test uses a different build of `trueaxis`
//! than its dependents do, with different types.

use crate as trueaxis;
pub(crate) use trueaxis_testing::{noise, share};

pub(crate) mod machine;
