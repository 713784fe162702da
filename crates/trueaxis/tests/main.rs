//! The core from outside.

mod allocation;
mod bits;
mod direction;
mod kinematics;
mod tcomp;
