//! The C interface.

#![allow(unsafe_code)]

mod combinations;
mod dynamics;
mod encoder;
#[cfg(not(miri))]
mod flipped_bits;
mod friction;
mod gauge;
mod grid;
#[cfg(not(feature = "single"))]
mod header;
mod learned;
mod machines;
mod no_output;
mod paths;
mod query;
mod refusals;
mod same_as_rust;
#[cfg(not(feature = "three"))]
mod storage;
mod thermal;
#[cfg(feature = "three")]
mod three;
mod tool;
mod trial;
