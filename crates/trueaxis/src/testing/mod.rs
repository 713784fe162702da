//! Helpers of the unit tests. `trueaxis-testing` compiles the same files for the tests of every other crate: a unit
//! test sees another build of `trueaxis` than its dependents, whose types differ.

pub(crate) mod machine;
pub(crate) mod noise;
pub(crate) mod share;
