//! Runs of a part program through the real step, in slices.
