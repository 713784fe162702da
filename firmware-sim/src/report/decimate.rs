//! Thinning of long series for a plot, without losing their extremes.

/// Thins a series to at most two points per bucket, its lowest and its highest, in their original order.
///
/// The series is cut into `buckets` runs of equal count; the first and the last point are kept besides, so that at most
/// `2·buckets + 2` points remain. A spike of one cycle survives, a mean would hide it. Points that are not finite are
/// left out. Cost: one pass.
#[must_use]
pub fn decimate(points: &[[f64; 2]], buckets: usize) -> Vec<[f64; 2]> {
    let finite: Vec<[f64; 2]> = points.iter().copied().filter(|[x, y]| x.is_finite() && y.is_finite()).collect();
    pick(&finite, buckets, &[|point| point[1]])
}

/// Keeps per bucket the items at which one of the `values` is lowest or highest, and the first and last item.
///
/// The values must be finite; items are returned in their original order.
pub(super) fn pick<T: Copy>(items: &[T], buckets: usize, values: &[fn(&T) -> f64]) -> Vec<T> {
    let buckets = buckets.max(1);
    if items.len() <= buckets.saturating_mul(2 * values.len()).saturating_add(2) {
        return items.to_vec();
    }
    let last = items.len() - 1;
    let mut kept = vec![0, last];
    let size = items.len().div_ceil(buckets);
    for (number, bucket) in items.chunks(size).enumerate() {
        for value in values {
            let order = |a: &(usize, &T), b: &(usize, &T)| value(a.1).total_cmp(&value(b.1));
            let lowest = bucket.iter().enumerate().min_by(order);
            let highest = bucket.iter().enumerate().max_by(order);
            kept.extend(lowest.into_iter().chain(highest).map(|(index, _)| number * size + index));
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().filter_map(|index| items.get(index).copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_of_one_cycle_survives_and_the_order_is_kept() {
        let points: Vec<[f64; 2]> =
            (0..100_000).map(|k| [f64::from(k), if k == 54_321 { 7.0 } else { f64::from(k % 10) * 0.1 }]).collect();
        let thin = decimate(&points, 500);
        assert!(thin.len() <= 1_002);
        assert!(thin.contains(&[54_321.0, 7.0]));
        assert_eq!((thin.first(), thin.last()), (points.first(), points.last()));
        assert!(thin.windows(2).all(|pair| pair[0][0] < pair[1][0]));
        for bucket in points.chunks(200) {
            let range = bucket[0][0]..=bucket[199][0];
            let lowest = bucket.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
            assert!(thin.iter().any(|point| range.contains(&point[0]) && point[1] == lowest));
        }
    }

    #[test]
    fn short_empty_constant_and_undefined_series() {
        assert!(decimate(&[], 10).is_empty());
        assert_eq!(decimate(&[[1.0, 2.0]], 0), [[1.0, 2.0]]);
        assert_eq!(decimate(&[[0.0, f64::NAN], [1.0, 2.0], [f64::INFINITY, 1.0]], 10), [[1.0, 2.0]]);
        let constant: Vec<[f64; 2]> = (0..1_000).map(|k| [f64::from(k), 3.0]).collect();
        let thin = decimate(&constant, 10);
        assert!(thin.len() <= 22 && thin.iter().all(|point| point[1] == 3.0));
    }
}
