//! Thinning of a series while it comes, in memory of fixed size.

/// Keeps of a series of unknown length the items at which one of `K` values is lowest or highest in its bucket, and the
/// first and the last item.
///
/// There are at most so many buckets; when they are full, neighbours become one. A spike of one cycle survives. A short
/// series is kept whole.
#[derive(Clone, Debug)]
pub struct Thinner<T, const K: usize> {
    buckets: Vec<[[Kept<T>; 2]; K]>,
    most: usize,
    /// Items of a bucket are 2 to the power of this.
    size_bits: u32,
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

impl<T: Copy, const K: usize> Thinner<T, K> {
    /// Between half of `most` and `most` buckets, an even number of at least two.
    pub fn new(most: usize) -> Thinner<T, K> {
        Thinner { buckets: Vec::new(), most: most.max(2).next_multiple_of(2), size_bits: 0, count: 0, ends: None }
    }

    /// Adds an item; one with a value that is not finite is left out.
    pub fn add(&mut self, item: T, values: [f64; K]) {
        if !values.iter().all(|value| value.is_finite()) {
            return;
        }
        let number = self.count;
        self.count += 1;
        if number >> self.size_bits == self.most as u64 {
            self.halve();
        }
        let kept = |value| Kept { number, value, item };
        let last = kept(0.0);
        match &mut self.ends {
            Some(ends) => ends[1] = last,
            None => self.ends = Some([last; 2]),
        }
        let place = (number >> self.size_bits) as usize;
        match self.buckets.get_mut(place) {
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
        self.size_bits += 1;
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

    /// What is kept, in its order.
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
}
