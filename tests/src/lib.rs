//! End-to-end tests and cross-checks of trueaxis; the tests live in `tests/`, here what several of them run on.

pub mod course;
pub mod walk;
