//! Latency of the servo step: a high dynamic range histogram, its percentiles and the missed deadlines.

use hdrhistogram::Histogram;
use std::time::Instant;

/// Upper end of the histogram in ns (10 s); longer steps count in its last bucket, the exact maximum is stored separately.
const HIGHEST_NS: u64 = 10_000_000_000;

/// Significant decimal digits of a bucket: percentiles are within 0.1 % of the recorded value.
const DIGITS: u8 = 3;

/// Runs a function and returns its result and duration in ns: the only clock of the simulation.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, u64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_nanos() as u64)
}

/// Records the duration of each servo step.
///
/// A step that takes more than `budget_ns` is *over budget*; one that takes more than `period_ns` has *missed its
/// deadline*, because the next period begins before it is done. All memory is allocated by [`Latency::new`]; a
/// recording costs a few nanoseconds and allocates nothing. Percentiles are high by at most 0.1 %; minimum, maximum and
/// the counts are exact.
#[derive(Debug, Clone)]
pub struct Latency {
    histogram: Histogram<u64>,
    budget_ns: u64,
    period_ns: u64,
    min_ns: u64,
    max_ns: u64,
    over_budget: u64,
    missed_deadlines: u64,
}

/// The percentiles of a [`Latency`], in ns; all zero when nothing was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LatencySummary {
    /// Number of steps recorded.
    pub steps: u64,
    /// Shortest step in ns, exact.
    pub min_ns: u64,
    /// Median in ns.
    pub p50_ns: u64,
    /// 99th percentile in ns.
    pub p99_ns: u64,
    /// 99.99th percentile in ns.
    pub p99_99_ns: u64,
    /// Longest step in ns, exact.
    pub max_ns: u64,
    /// Time a step may take, in ns.
    pub budget_ns: u64,
    /// Servo period in ns.
    pub period_ns: u64,
    /// Steps longer than the budget.
    pub over_budget: u64,
    /// Steps longer than the period.
    pub missed_deadlines: u64,
}

/// One bucket of the histogram: `count` steps took between `low_ns` and `high_ns`, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LatencyBucket {
    /// Shortest time that falls into the bucket, in ns.
    pub low_ns: u64,
    /// Longest time that falls into the bucket, in ns.
    pub high_ns: u64,
    /// Number of steps in the bucket.
    pub count: u64,
}

impl Latency {
    /// An empty record for a step that may take `budget_ns` within a servo period of `period_ns`.
    #[must_use]
    pub fn new(budget_ns: u64, period_ns: u64) -> Self {
        let histogram = Histogram::new_with_bounds(1, HIGHEST_NS, DIGITS).expect("constant bounds are valid");
        Self { histogram, budget_ns, period_ns, min_ns: u64::MAX, max_ns: 0, over_budget: 0, missed_deadlines: 0 }
    }

    /// Records one step that took `ns` nanoseconds.
    pub fn record(&mut self, ns: u64) {
        self.histogram.saturating_record(ns);
        self.min_ns = self.min_ns.min(ns);
        self.max_ns = self.max_ns.max(ns);
        self.over_budget += u64::from(ns > self.budget_ns);
        self.missed_deadlines += u64::from(ns > self.period_ns);
    }

    /// Minimum, percentiles, maximum and missed deadlines so far.
    #[must_use]
    pub fn summary(&self) -> LatencySummary {
        let limits =
            LatencySummary { budget_ns: self.budget_ns, period_ns: self.period_ns, ..LatencySummary::default() };
        if self.histogram.is_empty() {
            return limits;
        }
        // A bucket reports its upper edge, which may be slightly above the longest recorded step.
        let quantile = |q| self.histogram.value_at_quantile(q).max(self.min_ns).min(self.max_ns);
        LatencySummary {
            steps: self.histogram.len(),
            min_ns: self.min_ns,
            p50_ns: quantile(0.5),
            p99_ns: quantile(0.99),
            p99_99_ns: quantile(0.9999),
            max_ns: self.max_ns,
            over_budget: self.over_budget,
            missed_deadlines: self.missed_deadlines,
            ..limits
        }
    }

    /// The buckets that hold at least one step, from short to long.
    pub fn buckets(&self) -> impl Iterator<Item = LatencyBucket> + '_ {
        self.histogram.iter_recorded().map(|entry| {
            let value = entry.value_iterated_to();
            LatencyBucket {
                low_ns: self.histogram.lowest_equivalent(value),
                high_ns: self.histogram.highest_equivalent(value),
                count: entry.count_at_value(),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_a_known_distribution() {
        let mut latency = Latency::new(9_000, 9_990);
        // 1 … 10 000 ns, each once, in an order that is not sorted (7 919 is prime to 10 000).
        for k in 0..10_000_u64 {
            latency.record(k * 7_919 % 10_000 + 1);
        }
        let summary = latency.summary();
        assert_eq!(summary.steps, 10_000);
        assert_eq!((summary.min_ns, summary.max_ns), (1, 10_000));
        for (found, exact) in [(summary.p50_ns, 5_000), (summary.p99_ns, 9_900), (summary.p99_99_ns, 9_999)] {
            assert!(found >= exact && found - exact <= exact / 1_000 + 1, "{found} instead of {exact}");
        }
        assert_eq!(summary.over_budget, 1_000);
        assert_eq!(summary.missed_deadlines, 10);
    }

    #[test]
    fn the_deadline_itself_is_met() {
        let mut latency = Latency::new(100, 200);
        for ns in [100, 101, 200, 201] {
            latency.record(ns);
        }
        assert_eq!(latency.summary().over_budget, 3);
        assert_eq!(latency.summary().missed_deadlines, 1);
    }

    #[test]
    fn buckets_hold_every_step_once_and_do_not_overlap() {
        let mut latency = Latency::new(1, 1);
        for k in 0..5_000_u64 {
            latency.record(k * k);
        }
        let buckets: Vec<_> = latency.buckets().collect();
        assert_eq!(buckets.iter().map(|bucket| bucket.count).sum::<u64>(), 5_000);
        assert!(buckets.iter().all(|bucket| bucket.low_ns <= bucket.high_ns && bucket.count > 0));
        assert!(buckets.windows(2).all(|pair| pair[0].high_ns < pair[1].low_ns));
    }

    #[test]
    fn a_stalled_host_and_an_empty_record() {
        let mut latency = Latency::new(1_000, 100_000);
        assert_eq!(latency.summary().steps, 0);
        assert_eq!(latency.summary().period_ns, 100_000);
        assert_eq!(latency.buckets().count(), 0);
        latency.record(u64::MAX);
        latency.record(0);
        let summary = latency.summary();
        assert_eq!((summary.min_ns, summary.max_ns, summary.missed_deadlines), (0, u64::MAX, 1));
    }
}
