//! Helpers of the unit tests. `trueaxis-testing` compiles the same files for the tests of every other crate: a unit test
//! uses a different build of `trueaxis` than its dependents do, with different types.

pub(crate) mod machine;
pub(crate) mod noise;
pub(crate) mod share;
