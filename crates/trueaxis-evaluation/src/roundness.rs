//! Roundness and spindle error from three probes.
