//! Recordings.

mod digest;
mod round_trip;
