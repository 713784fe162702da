//! Ranges of settings.

/// A setting with its value and its accepted range, both ends included.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range<'k> {
    pub(crate) key: &'k str,
    pub(crate) found: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) unit: &'static str,
}

impl Range<'_> {
    /// Whether the value is in range; NaN is not.
    pub(crate) fn holds(&self) -> bool {
        (self.low..=self.high).contains(&self.found)
    }

    /// The range in words: `1 to 1000 %`.
    pub(crate) fn needed(&self) -> String {
        let Range { low, high, unit, .. } = self;
        format!("{} to {} {unit}", number(*low), number(*high)).trim_end().to_owned()
    }
}

/// A number in words: very small and very large ones with an exponent.
pub(crate) fn number(value: f64) -> String {
    match value {
        _ if value != 0.0 && !(1e-3..1e6).contains(&value.abs()) => format!("{value:e}"),
        _ => value.to_string(),
    }
}
