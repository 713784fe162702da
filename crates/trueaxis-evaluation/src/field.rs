//! Volumetric error over the working volume, before and after compensation.
