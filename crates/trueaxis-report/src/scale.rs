use crate::number::{PLOTTABLE, decimals, drawable};

/// Range, ticks and caption of one axis of a figure.
///
/// Values beyond the range are drawn at its edge.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    pub(crate) caption: String,
    pub(crate) low: f64,
    pub(crate) high: f64,
    logarithmic: bool,
    ticks: Option<u32>,
}

impl Scale {
    /// A linear scale over the drawable values; 0 to 1 without any.
    #[must_use]
    pub fn linear(caption: &str, values: impl IntoIterator<Item = f64>) -> Scale {
        let values = values.into_iter().filter(|value| drawable(*value));
        let [low, high] =
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
        Scale::exact(caption, low, high)
    }

    /// A linear scale from `low` to `high`; an empty or undefined range gets a visible width.
    #[must_use]
    pub fn exact(caption: &str, low: f64, high: f64) -> Scale {
        let [low, high] = widened(low, high);
        Scale { caption: caption.into(), low, high, logarithmic: false, ticks: None }
    }

    /// A linear scale from 0 to slightly above the largest value.
    #[must_use]
    pub fn from_zero(caption: &str, values: impl IntoIterator<Item = f64>) -> Scale {
        let highest = values.into_iter().filter(|value| drawable(*value)).fold(0.0, f64::max);
        Scale::exact(caption, 0.0, if highest > 0.0 { 1.08 * highest } else { 1.0 })
    }

    /// A linear scale centred on 0, extending slightly beyond the largest magnitude of the values.
    #[must_use]
    pub fn symmetric(caption: &str, values: impl IntoIterator<Item = f64>) -> Scale {
        let half = Scale::from_zero(caption, values.into_iter().map(f64::abs)).high;
        Scale::exact(caption, -half, half)
    }

    /// A logarithmic scale; both ends positive, otherwise 0.1 to 1.
    #[must_use]
    pub fn logarithmic(caption: &str, low: f64, high: f64) -> Scale {
        let sound = low > 0.0 && high > low && high <= PLOTTABLE;
        let [low, high] = if sound { [low, high] } else { [0.1, 1.0] };
        Scale { caption: caption.into(), low, high, logarithmic: true, ticks: None }
    }

    /// A logarithmic scale over the positive values, one to four decades.
    #[must_use]
    pub fn decades(caption: &str, values: impl IntoIterator<Item = f64>) -> Scale {
        let positive = values.into_iter().filter(|value| *value > 0.0 && drawable(*value));
        let [low, high] = positive.fold([f64::INFINITY, 0.0_f64], |[low, high], v| [low.min(v), high.max(v)]);
        let top = 1.3 * if high > 0.0 { high } else { 1.0 };
        Scale::logarithmic(caption, (0.7 * low).clamp(1e-4 * top, 0.1 * top), top)
    }

    /// Widens the scale at both ends by this share of its range.
    #[must_use]
    pub fn margin(mut self, share: f64) -> Scale {
        let extra = share * (self.high - self.low);
        (self.low, self.high) = (self.low - extra, self.high + extra);
        self
    }

    /// Sets the approximate number of ticks.
    #[must_use]
    pub fn ticks(mut self, count: u32) -> Scale {
        self.ticks = Some(count.max(1));
        self
    }

    /// Base of the columns: 0, or the edge next to it.
    pub(crate) fn base(&self) -> f64 {
        if self.logarithmic { self.low } else { 0.0_f64.clamp(self.low, self.high) }
    }

    /// Whether a value can be drawn on this scale.
    pub(crate) fn holds(&self, value: f64) -> bool {
        drawable(value) && (!self.logarithmic || value > 0.0)
    }

    /// Position between the ends, 0 to 1.
    pub(crate) fn share(&self, value: f64) -> f64 {
        let [low, high, value] =
            [self.low, self.high, value].map(|value| if self.logarithmic { value.log10() } else { value });
        ((value - low) / (high - low)).clamp(0.0, 1.0)
    }

    /// Positions and labels of the ticks, about `count` unless the scale sets a number.
    pub(crate) fn labels(&self, count: u32) -> Vec<(f64, String)> {
        if self.logarithmic { self.decade_labels() } else { self.round_labels(self.ticks.unwrap_or(count)) }
    }

    fn round_labels(&self, count: u32) -> Vec<(f64, String)> {
        let (low, high) = (self.low, self.high);
        let rough = (high - low) / f64::from(count);
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power).into_iter().find(|step| *step >= 0.999 * rough);
        let step = step.unwrap_or(rough);
        let first = (low / step - 1e-9).ceil();
        let slack = 1e-6 * (high - low);
        (0..64)
            .map(|k| (first + f64::from(k)) * step)
            .take_while(|tick| *tick <= high + slack)
            // If the range is near the resolution of the numbers, the first multiple may round to below it.
            .filter(|tick| *tick >= low - slack)
            .map(|tick| (tick, decimals(tick, places(step))))
            .collect()
    }

    /// Powers of ten, with 2 and 5 between them if they fit.
    fn decade_labels(&self) -> Vec<(f64, String)> {
        let digits: &[f64] = if (self.high / self.low).log10() < 4.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let decades = (self.low.log10().floor() as i32)..=(self.high.log10().ceil() as i32);
        decades
            .flat_map(|decade| digits.iter().map(move |digit| digit * 10_f64.powi(decade)))
            .filter(|value| (self.low..=self.high).contains(value))
            .map(|value| (value, decimals(value, places(value))))
            .collect()
    }
}

/// Number of decimals that a multiple of `step` needs.
fn places(step: f64) -> i32 {
    (-(step.log10() + 1e-9).floor() as i32).clamp(0, 9)
}

/// Widens an empty range: identical values, or values that differ by rounding only.
fn widened(low: f64, high: f64) -> [f64; 2] {
    if !drawable(low) || !drawable(high) || low > high {
        return [0.0, 1.0];
    }
    let size = low.abs().max(high.abs());
    if high - low > 1e-9 * size {
        return [low, high];
    }
    let half = if size > 0.0 { 0.05 * size } else { 0.5 };
    [low - half, high + half]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_inside_the_range_and_not_too_many() {
        for (low, high) in [(0.0, 1.0), (-3.7, 18.4), (0.0, 1e-4), (99_999.0, 100_001.0), (-1e12, 1e12), (0.0, 7e11)] {
            let ticks = Scale::exact("", low, high).labels(6);
            assert!((2..=13).contains(&ticks.len()), "{low} to {high}: {ticks:?}");
            assert!(ticks.iter().all(|tick| tick.0 >= low - 1e-6 * (high - low) && tick.0 <= high * 1.000_001));
            let mut labels: Vec<&String> = ticks.iter().map(|tick| &tick.1).collect();
            labels.dedup();
            assert_eq!(labels.len(), ticks.len(), "labels must differ: {labels:?}");
        }
        let decades: Vec<String> = Scale::logarithmic("", 0.7, 30.0).labels(6).into_iter().map(|tick| tick.1).collect();
        assert_eq!(decades, ["1", "2", "5", "10", "20"]);
        assert_eq!(Scale::logarithmic("", 0.6, 2e6).labels(6).len(), 7);
    }

    #[test]
    fn a_scale_always_has_a_range() {
        for values in [vec![], vec![0.0], vec![5.0; 3], vec![-1e12, 1e12], vec![f64::NAN, f64::INFINITY], vec![1e-30]] {
            for scale in [
                Scale::linear("", values.clone()).margin(0.05),
                Scale::from_zero("", values.clone()),
                Scale::symmetric("", values.clone()),
                Scale::decades("", values.clone()),
                Scale::exact("", f64::NAN, values.first().copied().unwrap_or(f64::INFINITY)),
                Scale::logarithmic("", -1.0, values.first().copied().unwrap_or(0.0)),
            ] {
                assert!(scale.high > scale.low && scale.low.is_finite() && scale.high.is_finite(), "{values:?}");
                assert!((0.0..=1.0).contains(&scale.share(scale.low)), "{values:?}");
            }
        }
    }

    #[test]
    fn values_beyond_the_range_stay_at_its_edge() {
        let scale = Scale::exact("", -1.0, 3.0);
        assert_eq!([-9.0, -1.0, 1.0, 9.0].map(|value| scale.share(value)), [0.0, 0.0, 0.5, 1.0]);
        let scale = Scale::logarithmic("", 1.0, 100.0);
        assert_eq!([0.1, 10.0, 1e9].map(|value| scale.share(value)), [0.0, 0.5, 1.0]);
        assert!(!scale.holds(0.0) && !scale.holds(f64::NAN) && !scale.holds(1e13));
    }
}
