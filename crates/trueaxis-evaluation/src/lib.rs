#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// print! and its like panic when the other end of a pipe is closed.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod accuracy;
pub mod ballbar;
pub mod batch;
pub mod calibrate;
pub mod check;
pub mod circle;
pub mod compensate;
pub mod contributions;
pub mod correct;
pub mod curve;
pub mod diagonal;
pub mod field;
pub mod friction;
pub mod helicoid;
pub mod identify;
pub mod inverse;
pub mod keep;
pub mod learn;
pub mod model;
pub mod path;
pub mod points;
pub mod positions;
pub mod probe_angles;
pub mod probes;
pub mod probing;
pub mod r_test;
pub mod response;
pub mod roundness;
pub mod rows;
pub mod stuck;
pub mod thermal;
pub mod thermal_test;
pub mod uncertainty;
