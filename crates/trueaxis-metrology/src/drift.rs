//! Drift of a reading over stated periods, as required by the thermal tests of ISO 230-3.
//!
//! ```text
//! range          max − min over the whole test
//! first period   max − min from the start to T (60 min in ISO 230-3)
//! worst period   max of max − min over every span of length T within the test
//! end            last − first reading
//! ```
//!
//! Source: ISO 230-3:2020, clauses 5 to 7.

use std::collections::VecDeque;

/// Drift of one reading, in its unit; times in the unit of the given times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Drift {
    /// Range over the whole test.
    pub range: f64,
    /// Range from the start to one period after it.
    pub first: f64,
    /// Largest range within any span of one period.
    pub worst: f64,
    /// Time of the first reading of that span.
    pub worst_from: f64,
    /// Last − first reading.
    pub end: f64,
}

/// Computes the drift of `values` read at `times`, which increase; `period` has the unit of the times.
///
/// Cost: each reading enters and leaves two queues once.
pub fn drift(times: &[f64], values: &[f64], period: f64) -> Drift {
    let mut found = Drift::default();
    let (Some(&start), Some(&first), Some(&last)) = (times.first(), values.first(), values.last()) else {
        return found;
    };
    found.end = last - first;
    let (mut low, mut high) = (first, first);
    // Indices within the span, with ascending values (for the minimum) and descending values (for the maximum).
    let (mut least, mut most): (VecDeque<usize>, VecDeque<usize>) = (VecDeque::new(), VecDeque::new());
    let mut from = 0;
    for (i, (&time, &value)) in times.iter().zip(values).enumerate() {
        (low, high) = (low.min(value), high.max(value));
        if time - start <= period {
            found.first = high - low;
        }
        while least.back().is_some_and(|&k| values[k] >= value) {
            least.pop_back();
        }
        while most.back().is_some_and(|&k| values[k] <= value) {
            most.pop_back();
        }
        least.push_back(i);
        most.push_back(i);
        while time - times[from] > period {
            from += 1;
        }
        while least.front().is_some_and(|&k| k < from) {
            least.pop_front();
        }
        while most.front().is_some_and(|&k| k < from) {
            most.pop_front();
        }
        if let (Some(&bottom), Some(&top)) = (least.front(), most.front()) {
            let range = values[top] - values[bottom];
            if range > found.worst {
                (found.worst, found.worst_from) = (range, times[from]);
            }
        }
    }
    found.range = high - low;
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// A spindle warm-up: 30 (1 − e^(−t/τ)), τ = 40 min, eight hours; calculated by hand.
    #[test]
    fn a_warm_up_by_hand() {
        let times: Vec<f64> = (0..=480).map(f64::from).collect();
        let values: Vec<f64> = times.iter().map(|t| 30.0 * (1.0 - (-t / 40.0).exp())).collect();
        let found = drift(&times, &values, 60.0);
        let after = |t: f64| 30.0 * (1.0 - (-t / 40.0).exp());
        assert!((found.first - after(60.0)).abs() < 1e-12 && (found.range - after(480.0)).abs() < 1e-12);
        assert!((found.worst - found.first).abs() < 1e-12 && found.worst_from == 0.0);
        assert!((found.end - after(480.0)).abs() < 1e-12);
    }

    /// Compares with every span one by one, over a record that rises and falls.
    #[test]
    fn the_worst_span_is_the_worst_of_all() {
        let times: Vec<f64> = (0..300).map(|k| f64::from(k) + 0.3 * f64::from(k % 3)).collect();
        let values: Vec<f64> =
            times.iter().map(|t| (t / 17.0).sin() * (1.0 + t / 90.0) + 0.2 * (t * 1.7).cos()).collect();
        let found = drift(&times, &values, 40.0);
        let mut worst: f64 = 0.0;
        for i in 0..times.len() {
            let span = || {
                times.iter().zip(&values).filter(|(t, _)| **t >= times[i] && **t - times[i] <= 40.0).map(|(_, v)| *v)
            };
            worst = worst.max(span().fold(f64::MIN, f64::max) - span().fold(f64::MAX, f64::min));
        }
        assert!((found.worst - worst).abs() < 1e-12, "{} for {worst}", found.worst);
    }
}
