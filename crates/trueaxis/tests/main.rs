//! Tests of the core through its public interface.

mod allocation;
mod bits;
mod direction;
mod kinematics;
mod tcomp;
