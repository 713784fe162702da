//! The compiled table file.
