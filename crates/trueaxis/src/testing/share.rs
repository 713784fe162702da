//! How many of the cases a long test runs.

/// So many of `count` cases as `TRUEAXIS_TEST_SHARE` says: one in that many, at least one; all unless it is set. For those
/// who run the same test thousands of times.
pub fn share(count: usize) -> usize {
    let one_in = std::env::var("TRUEAXIS_TEST_SHARE").ok().and_then(|number| number.parse().ok()).unwrap_or(1);
    (count / usize::max(one_in, 1)).max(1)
}
