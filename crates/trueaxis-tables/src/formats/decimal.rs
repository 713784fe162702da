//! Formats numbers for files.

/// The shortest decimal u with u / scale == value, otherwise the double nearest to value · scale.
pub(super) fn shortest(value: f64, scale: f64) -> f64 {
    shortest_read_as(value, value * scale, |micro| micro / scale)
}

/// The shortest decimal near `micro` that reads back as `value`, otherwise `micro`.
pub(super) fn shortest_read_as(value: f64, micro: f64, read: impl Fn(f64) -> f64) -> f64 {
    for near in [micro, micro.next_up(), micro.next_down()] {
        for digits in 0..17 {
            let text = format!("{near:.digits$e}");
            if let Ok(candidate) = text.parse::<f64>()
                && read(candidate) == value
            {
                // −0 reads back as 0; the sign carries no information.
                return candidate + 0.0;
            }
        }
    }
    micro
}

/// The double that a table in thousandths or millionths (`scale` 1e3, 1e6) gives for a decimal of at most twelve digits:
/// 0.000952 mm becomes 0.952 / 1000, one unit in the last place away, and is written as 0.952. Any other number is unchanged.
pub(super) fn as_in_a_table(value: f64, scale: f64) -> f64 {
    let micro = format!("{:.11e}", value * scale).parse::<f64>().unwrap_or(value * scale);
    let read = micro / scale;
    if (read - value).abs() <= 2.0 * f64::EPSILON * value.abs() { read + 0.0 } else { value }
}

/// `value` to six decimals of a table's unit (`scale` 1, 1e3, 1e6 from mm or rad), as the table is read: −0.7 + 2 · 33.3 gives
/// 65.9, not 65.89999999999999, and a mean of three readings ends at the sixth decimal.
pub(super) fn to_six_places(value: f64, scale: f64) -> f64 {
    to_places(value, scale, 1e6)
}

/// A height in mm to a nanometre, finer than heights are written, as a table in µm is read.
pub(super) fn to_nanometre(height: f64) -> f64 {
    to_places(height, 1e3, 1e3)
}

/// `value` times `scale` rounded to parts of a unit, as a table in that unit is read; turns −0 into 0.
fn to_places(value: f64, scale: f64, parts: f64) -> f64 {
    (value * scale * parts).round() / parts / scale + 0.0
}

/// a − b of two decimals of at most ten places, without binary rounding noise: 10.016312 − 10 gives 0.016312, not
/// 0.016311999999998, as a table in thousandths is read. For other numbers, the plain difference.
pub(super) fn difference(a: f64, b: f64) -> f64 {
    let exact = a - b;
    let decimal = (exact * 1e10).round() / 1e7 / 1e3;
    let binary = f64::EPSILON * a.abs().max(b.abs());
    if (exact - decimal).abs() <= binary { decimal + 0.0 } else { exact }
}

/// The value of a comment as TOML: a list, a quoted word, or unchanged.
pub(super) fn toml_value(key: &str, value: &str) -> String {
    match key {
        "interpolation" | "lookup" | "cross_lookup" | "model" => format!("\"{value}\""),
        "orientation" => value.to_owned(),
        _ => {
            let numbers: Vec<String> = value
                .split(' ')
                .map(|number| number.parse::<f64>().map_or_else(|_| number.to_owned(), |n| format!("{n:?}")))
                .collect();
            match numbers.as_slice() {
                [alone] => alone.clone(),
                several => format!("[{}]", several.join(", ")),
            }
        }
    }
}
