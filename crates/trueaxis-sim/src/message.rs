//! What messages repeat of a file.

/// Most characters of a program or of settings.
pub(crate) const LONGEST_FOUND: usize = 160;
