//! Pages of `trueaxis evaluate`.

pub(crate) mod points;
pub(crate) mod probing;
pub(crate) mod r_test;
pub(crate) mod step_diagonal;
pub(crate) mod thermal;
