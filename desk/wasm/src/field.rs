//! Volumetric error over the working volume.
