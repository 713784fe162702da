//! Dear parts of a target that only one input in so many goes through.

use std::hash::{DefaultHasher, Hash, Hasher};

/// Whether these bytes are one in `count`: always the same for the same bytes.
pub fn one_in(count: u64, bytes: &[u8]) -> bool {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    hasher.finish().is_multiple_of(count)
}
