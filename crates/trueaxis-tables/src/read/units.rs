//! Converts the units of `machine.toml` to those of the core.

/// µm to mm: a division, so that the result is the double nearest to the decimal.
pub(super) fn from_um(value: f64) -> f64 {
    value / 1e3
}

/// µrad to rad.
pub(super) fn from_urad(value: f64) -> f64 {
    value / 1e6
}

/// µrad to degrees.
pub(crate) fn degrees_from_urad(value: f64) -> f64 {
    (value / 1e6).to_degrees()
}

/// Already in the unit of the core.
pub(super) fn same(value: f64) -> f64 {
    value
}

/// Per minute to per second.
pub(super) fn per_second(value: f64) -> f64 {
    value / 60.0
}
