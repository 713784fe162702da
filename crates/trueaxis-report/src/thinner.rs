use crate::number::drawable_point;

/// Keeps the extremes of a series of unknown length, in memory of fixed size.
///
/// The series is cut into buckets of equal count. Each bucket keeps the items at which one of `K` values is lowest or
/// highest; the thinner also keeps the first and the last item of all. A spike of one cycle survives, while a mean
/// would hide it. When all buckets are full, neighbours are merged. Cost: one pass.
#[derive(Clone, Debug)]
pub struct Thinner<T, const K: usize> {
    buckets: Vec<[[Extreme<T>; 2]; K]>,
    most: u64,
    /// Number of items per bucket.
    size: u64,
    count: u64,
    ends: Option<[Extreme<T>; 2]>,
}

/// An item with its number and the value that makes it an extreme.
#[derive(Clone, Copy, Debug)]
struct Extreme<T> {
    number: u64,
    value: f64,
    item: T,
}

/// Merges the lowest and highest of two runs; among equals the first lowest and the last highest.
fn merge<T: Copy>([low, high]: &mut [Extreme<T>; 2], next: [Extreme<T>; 2]) {
    if next[0].value < low.value {
        *low = next[0];
    }
    if next[1].value >= high.value {
        *high = next[1];
    }
}

/// Thins a curve to at most `2·buckets + 2` points, in order; omits points that cannot be drawn.
#[must_use]
pub fn decimate(points: &[[f64; 2]], buckets: usize) -> Vec<[f64; 2]> {
    let drawable: Vec<[f64; 2]> = points.iter().copied().filter(drawable_point).collect();
    thin(&drawable, buckets, |point| [point[1]])
}

/// Thins items by the extremes of `K` finite values to at most `2·K·buckets + 2`, in order.
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
    /// Uses between half of `most` and `most` buckets once the series is longer than that; `most` is even and at least 2.
    #[must_use]
    pub fn new(most: usize) -> Thinner<T, K> {
        let most = most.max(2).next_multiple_of(2) as u64;
        Thinner { buckets: Vec::new(), most, size: 1, count: 0, ends: None }
    }

    /// Adds an item; ignores one with a value that is not finite.
    pub fn add(&mut self, item: T, values: [f64; K]) {
        if !values.iter().all(|value| value.is_finite()) {
            return;
        }
        let number = self.count;
        self.count += 1;
        if number / self.size == self.most {
            self.halve();
        }
        let kept = |value| Extreme { number, value, item };
        let last = kept(0.0);
        match &mut self.ends {
            Some(ends) => ends[1] = last,
            None => self.ends = Some([last; 2]),
        }
        match self.buckets.get_mut((number / self.size) as usize) {
            None => self.buckets.push(values.map(|value| [kept(value); 2])),
            Some(bucket) => {
                bucket.iter_mut().zip(values).for_each(|(ends, value)| merge(ends, [kept(value); 2]));
            }
        }
    }

    /// Merges every two buckets into one.
    fn halve(&mut self) {
        self.size *= 2;
        for i in 0..self.buckets.len() / 2 {
            let (mut bucket, next) = (self.buckets[2 * i], self.buckets[2 * i + 1]);
            bucket.iter_mut().zip(next).for_each(|(ends, next)| merge(ends, next));
            self.buckets[i] = bucket;
        }
        self.buckets.truncate(self.buckets.len() / 2);
    }

    /// The items kept, in order.
    #[must_use]
    pub fn items(&self) -> Vec<T> {
        let mut kept: Vec<&Extreme<T>> =
            self.buckets.iter().flatten().flatten().chain(self.ends.iter().flatten()).collect();
        kept.sort_unstable_by_key(|kept| kept.number);
        kept.dedup_by_key(|kept| kept.number);
        kept.into_iter().map(|kept| kept.item).collect()
    }
}
