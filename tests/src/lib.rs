//! End-to-end tests and cross-checks of trueaxis; the tests live in `tests/`.
