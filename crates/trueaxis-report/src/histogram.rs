/// Sums fine buckets of whole numbers into columns of equal logarithmic width: `(low, high, count)`.
///
/// `buckets` ascend, each `(lowest, highest, count)`; `per_decade` columns cover a factor of ten. Empty buckets give no
/// column.
#[must_use]
pub fn columns(buckets: impl IntoIterator<Item = (u64, u64, u64)>, per_decade: u32) -> Vec<(f64, f64, u64)> {
    let per_decade = f64::from(per_decade);
    let mut columns: Vec<(f64, f64, u64)> = Vec::new();
    for (lowest, highest, count) in buckets.into_iter().filter(|bucket| bucket.2 > 0) {
        let middle = lowest.midpoint(highest).max(1) as f64;
        let number = (middle.log10() * per_decade).floor();
        // Edges between whole numbers move up to the next one.
        let edge = |number: f64| 10_f64.powf(number / per_decade).ceil();
        let (low, high) = (edge(number), edge(number + 1.0).max(edge(number) + 1.0));
        match columns.last_mut() {
            Some(last) if middle < last.1 => last.2 = last.2.saturating_add(count),
            _ => columns.push((low.min(middle.floor()), high, count)),
        }
    }
    columns
}
