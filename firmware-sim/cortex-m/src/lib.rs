//! What the images share: the board.

#![no_std]

pub mod timer;
