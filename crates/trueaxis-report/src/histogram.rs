/// Adds fine buckets of whole numbers up into columns of equal width in the logarithm: `(low, high, count)`.
///
/// `buckets` ascend, each `(lowest, highest, count)`; `per_decade` columns make a factor of ten. Empty buckets make no
/// column.
#[must_use]
pub fn columns(buckets: impl IntoIterator<Item = (u64, u64, u64)>, per_decade: u32) -> Vec<(f64, f64, u64)> {
    let per_decade = f64::from(per_decade);
    let mut columns: Vec<(f64, f64, u64)> = Vec::new();
    for (lowest, highest, count) in buckets.into_iter().filter(|bucket| bucket.2 > 0) {
        let middle = lowest.midpoint(highest).max(1) as f64;
        let number = (middle.log10() * per_decade).floor();
        // Edges between whole numbers are moved up to the next one.
        let edge = |number: f64| 10_f64.powf(number / per_decade).ceil();
        let (low, high) = (edge(number), edge(number + 1.0).max(edge(number) + 1.0));
        match columns.last_mut() {
            Some(last) if middle < last.1 => last.2 = last.2.saturating_add(count),
            _ => columns.push((low.min(middle.floor()), high, count)),
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_hold_every_count_once_and_do_not_overlap() {
        // Buckets as a histogram of three significant digits has them.
        let mut buckets = Vec::new();
        let mut low = 0_u64;
        while low < 9_000_000 {
            let width = (low / 1000).max(1).next_power_of_two();
            buckets.push((low, low + width - 1, low % 7));
            low += width;
        }
        let columns = columns(buckets.iter().copied(), 24);
        assert_eq!(columns.iter().map(|column| column.2).sum::<u64>(), buckets.iter().map(|b| b.2).sum::<u64>());
        assert!(columns.iter().all(|column| column.0 < column.1 && column.2 > 0));
        assert!(columns.windows(2).all(|pair| pair[0].1 <= pair[1].0), "{columns:?}");
        assert_eq!(super::columns([(u64::MAX, u64::MAX, u64::MAX)], 24).len(), 1);
    }
}
