/// Keeps the extremes of a series of unknown length, in memory of fixed size.
///
/// The series is cut into buckets of equal count. Of each bucket the items stay at which one of `K` values is lowest or
/// highest, and the first and the last item of all; a spike of one cycle survives, a mean would hide it. When all buckets
/// are full, neighbours are merged. Cost: one pass.
#[derive(Clone, Debug)]
pub struct Thinner<T, const K: usize> {
    buckets: Vec<[[Kept<T>; 2]; K]>,
    most: u64,
    /// Items of a bucket.
    size: u64,
    count: u64,
    ends: Option<[Kept<T>; 2]>,
}

/// An item with its number and the value that it is kept for.
#[derive(Clone, Copy, Debug)]
struct Kept<T> {
    number: u64,
    value: f64,
    item: T,
}

/// Thins a curve to at most `2·buckets + 2` points, in their order; points that are not finite are left out.
#[must_use]
pub fn decimate(points: &[[f64; 2]], buckets: usize) -> Vec<[f64; 2]> {
    let finite: Vec<[f64; 2]> = points.iter().copied().filter(|[x, y]| x.is_finite() && y.is_finite()).collect();
    thin(&finite, buckets, |point| [point[1]])
}

/// Thins items by the extremes of `K` finite values to at most `2·K·buckets + 2`, in their order.
#[must_use]
pub fn thin<T: Copy, const K: usize>(items: &[T], buckets: usize, values: impl Fn(&T) -> [f64; K]) -> Vec<T> {
    let buckets = buckets.max(1);
    if items.len() <= buckets.saturating_mul(2 * K).saturating_add(2) {
        return items.to_vec();
    }
    let size = items.len().div_ceil(buckets) as u64;
    let mut thinner = Thinner { size, ..Thinner::new(buckets) };
    items.iter().for_each(|item| thinner.add(*item, values(item)));
    thinner.items()
}

impl<T: Copy, const K: usize> Thinner<T, K> {
    /// With between half of `most` and `most` buckets once the series is longer than that; `most` is even and at least 2.
    #[must_use]
    pub fn new(most: usize) -> Thinner<T, K> {
        let most = most.max(2).next_multiple_of(2) as u64;
        Thinner { buckets: Vec::new(), most, size: 1, count: 0, ends: None }
    }

    /// Adds an item; one with a value that is not finite is left out.
    pub fn add(&mut self, item: T, values: [f64; K]) {
        if !values.iter().all(|value| value.is_finite()) {
            return;
        }
        let number = self.count;
        self.count += 1;
        if number / self.size == self.most {
            self.halve();
        }
        let kept = |value| Kept { number, value, item };
        let last = kept(0.0);
        match &mut self.ends {
            Some(ends) => ends[1] = last,
            None => self.ends = Some([last; 2]),
        }
        match self.buckets.get_mut((number / self.size) as usize) {
            None => self.buckets.push(values.map(|value| [kept(value); 2])),
            Some(bucket) => {
                for ([low, high], value) in bucket.iter_mut().zip(values) {
                    if value < low.value {
                        *low = kept(value);
                    }
                    if value >= high.value {
                        *high = kept(value);
                    }
                }
            }
        }
    }

    /// Makes one bucket of every two.
    fn halve(&mut self) {
        self.size *= 2;
        for i in 0..self.buckets.len() / 2 {
            let (mut bucket, other) = (self.buckets[2 * i], self.buckets[2 * i + 1]);
            for ([low, high], [other_low, other_high]) in bucket.iter_mut().zip(other) {
                if other_low.value < low.value {
                    *low = other_low;
                }
                if other_high.value >= high.value {
                    *high = other_high;
                }
            }
            self.buckets[i] = bucket;
        }
        self.buckets.truncate(self.buckets.len() / 2);
    }

    /// The items kept, in their order.
    #[must_use]
    pub fn items(&self) -> Vec<T> {
        let mut kept: Vec<&Kept<T>> =
            self.buckets.iter().flatten().flatten().chain(self.ends.iter().flatten()).collect();
        kept.sort_unstable_by_key(|kept| kept.number);
        kept.dedup_by_key(|kept| kept.number);
        kept.into_iter().map(|kept| kept.item).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_of_one_cycle_survives_at_any_length() {
        for length in [1_u32, 2, 99, 100, 101, 12_345, 1_000_000] {
            let mut thinner = Thinner::<u32, 1>::new(100);
            let spike = length / 3;
            for k in 0..length {
                thinner.add(k, [if k == spike { 7.0 } else { f64::from(k % 10) * 0.1 }]);
            }
            let items = thinner.items();
            assert!(items.contains(&spike) && items.contains(&0) && items.contains(&(length - 1)), "{length}");
            assert!(items.windows(2).all(|pair| pair[0] < pair[1]), "{length}");
            assert!(items.len() <= 202, "{length}: {}", items.len());
            if length <= 100 {
                assert_eq!(items.len(), length as usize);
            }
        }
    }

    #[test]
    fn it_keeps_the_extremes_of_every_bucket_of_every_value() {
        let mut state = 1_u32;
        let values: Vec<[f64; 2]> = (0..5000)
            .map(|_| {
                [(); 2].map(|()| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    f64::from(state >> 8)
                })
            })
            .collect();
        let mut thinner = Thinner::<usize, 2>::new(40);
        values.iter().enumerate().for_each(|(k, value)| thinner.add(k, *value));
        let items = thinner.items();
        // 5000 items in at most 40 buckets: 128 each.
        for (number, bucket) in values.chunks(128).enumerate() {
            for key in 0..2 {
                for sign in [1.0, -1.0] {
                    let most = bucket.iter().map(|v| sign * v[key]).fold(f64::MIN, f64::max);
                    let found = items.iter().any(|&k| k / 128 == number && sign * values[k][key] == most);
                    assert!(found, "bucket {number}, value {key}");
                }
            }
        }
    }

    #[test]
    fn undefined_values_are_left_out() {
        let mut thinner = Thinner::<u32, 1>::new(4);
        [f64::NAN, 1.0, f64::INFINITY].into_iter().zip(0..).for_each(|(value, k)| thinner.add(k, [value]));
        assert_eq!(thinner.items(), [1]);
        assert!(Thinner::<u32, 1>::new(0).items().is_empty());
    }

    #[test]
    fn a_spike_in_a_slice_survives_and_the_order_is_kept() {
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
    fn short_empty_constant_and_undefined_slices() {
        assert!(decimate(&[], 10).is_empty());
        assert_eq!(decimate(&[[1.0, 2.0]], 0), [[1.0, 2.0]]);
        assert_eq!(decimate(&[[0.0, f64::NAN], [1.0, 2.0], [f64::INFINITY, 1.0]], 10), [[1.0, 2.0]]);
        let constant: Vec<[f64; 2]> = (0..1_000).map(|k| [f64::from(k), 3.0]).collect();
        let thin = decimate(&constant, 10);
        assert!(thin.len() <= 22 && thin.iter().all(|point| point[1] == 3.0));
    }
}
