//! Limits of quotations from files in messages.

/// Most characters quoted from a program or settings.
pub(crate) const LONGEST_FOUND: usize = 160;
