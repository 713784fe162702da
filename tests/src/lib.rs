//! End-to-end tests and cross-checks of trueaxis: the tests are in `tests/`, their shared code is here.

pub mod course;
pub mod trial;
pub mod walk;
