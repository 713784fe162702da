//! Number of cases that a sweep runs.

/// One case in ten of `count`, at least one. `TRUEAXIS_TEST_SHARE=1` runs all of them, as the campaign does; another
/// number runs one in that many. The other nine are further cases of the same kind, from the same generator: they find
/// rarer defects.
pub fn share(count: usize) -> usize {
    let one_in = std::env::var("TRUEAXIS_TEST_SHARE").ok().and_then(|number| number.parse().ok()).unwrap_or(10);
    (count / usize::max(one_in, 1)).max(1)
}
