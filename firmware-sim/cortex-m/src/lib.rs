//! Board support shared by the images.

#![no_std]

pub mod device;
pub mod growth;
pub mod regions;
pub mod settings;
pub mod timer;
