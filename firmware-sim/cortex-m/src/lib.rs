//! What the images share: the board.

#![no_std]

pub mod device;
pub mod regions;
pub mod timer;
