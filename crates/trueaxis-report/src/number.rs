//! Numbers as printed on a page: grouped in threes by narrow spaces (ISO 80000-1), with a true minus sign.

/// Largest magnitude that is drawn; beyond it a value is treated as undefined.
pub(crate) const PLOTTABLE: f64 = 1e12;

/// Whether a value can be drawn: finite and at most 1e12.
#[must_use]
pub fn drawable(value: f64) -> bool {
    value.abs() <= PLOTTABLE
}

/// Whether both coordinates of a point can be drawn.
pub(crate) fn drawable_point(point: &[f64; 2]) -> bool {
    point.iter().all(|value| drawable(*value))
}

/// A number with `digits` significant digits, and all digits before the point; a dash if it is not finite.
#[must_use]
pub fn significant(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value != 0.0 && !(1e-6..PLOTTABLE).contains(&value.abs()) {
        return format!("{value:.2e}").replace('-', "−");
    }
    let magnitude = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    decimals(value, (digits - 1 - magnitude).max(0))
}

/// A number rounded to the last of the `digits` significant digits of its `uncertainty`, with at most ten significant digits;
/// as [`significant`] if the uncertainty has no magnitude.
#[must_use]
pub fn as_far_as(value: f64, uncertainty: f64, digits: i32) -> String {
    let [size, least] = [value, uncertainty].map(f64::abs);
    if !(1e-6..PLOTTABLE).contains(&least) || size >= PLOTTABLE {
        return significant(value, digits + 2);
    }
    let magnitude = |of: f64| of.log10().floor() as i32;
    let most = if size < 1.0 { 9 } else { 9 - magnitude(size) };
    decimals(value, (digits - 1 - magnitude(least)).clamp(0, most.max(0)))
}

/// A number with a fixed count of decimals.
#[must_use]
pub fn decimals(value: f64, count: i32) -> String {
    let text = format!("{:.*}", usize::try_from(count).unwrap_or(0), value.abs());
    let (whole, fraction) = text.split_once('.').map_or((text.as_str(), None), |(whole, part)| (whole, Some(part)));
    let negative = value < 0.0 && text.chars().any(|c| c.is_ascii_digit() && c != '0');
    let mut out = String::from(if negative { "−" } else { "" });
    for (index, digit) in whole.chars().enumerate() {
        if index > 0 && whole.len() > 4 && (whole.len() - index).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    if let Some(fraction) = fraction {
        out.push('.');
        out.push_str(fraction);
    }
    out
}

/// A number of three significant digits with its unit.
#[must_use]
pub fn quantity(value: f64, unit: &str) -> String {
    format!("{} {unit}", significant(value, 3))
}

/// `part` as a share of `whole`, in percent; a dash if undefined.
#[must_use]
pub fn percent(part: f64, whole: f64) -> String {
    let ratio = 100.0 * part / whole;
    if whole > 0.0 && ratio.is_finite() {
        format!("{} %", significant(ratio, if ratio < 10.0 { 2 } else { 3 }))
    } else {
        "–".to_owned()
    }
}

/// A setting as given: as many digits as it needs, at most six decimals, not grouped.
#[must_use]
pub fn shortest(value: f64) -> String {
    if !drawable(value) {
        return significant(value, 3);
    }
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.replace('-', "−") }
}

/// A whole number.
#[must_use]
pub fn count(value: u64) -> String {
    decimals(value as f64, 0)
}

/// The largest of 1, 2, 5 × 10^n not above `value`; 1 unless `value` is positive and finite.
#[must_use]
pub fn round_down(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powi(value.log10().floor() as i32);
    // The tolerance keeps 5.0 from becoming 2 when the division rounds to 4.999….
    let digit = [5.0, 2.0, 1.0].into_iter().find(|digit| digit * power <= value * (1.0 + 1e-9)).unwrap_or(1.0);
    digit * power
}

/// The nearest of 1, 2, 5 × 10^n to `value`, by ratio.
#[must_use]
pub fn nearest_round(value: f64) -> f64 {
    let below = round_down(value);
    let above = round_down(below * 2.5);
    if value * value > below * above { above } else { below }
}

/// Replaces characters that XML does not permit by spaces.
pub(crate) fn printable(text: &str) -> String {
    let foreign = |c: char| c.is_control() && c != '\n' || matches!(c, '\u{fffe}' | '\u{ffff}');
    text.chars().map(|c| if foreign(c) { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_printed() {
        assert_eq!(significant(18.437, 3), "18.4");
        assert_eq!(significant(-0.012_34, 3), "−0.0123");
        assert_eq!(significant(0.0, 3), "0.00");
        assert_eq!(significant(100_000.0, 3), "100\u{202f}000");
        assert_eq!(significant(1234.4, 3), "1234");
        assert_eq!(significant(f64::NAN, 3), "–");
        assert_eq!(significant(-1e300, 3), "−1.00e300");
        assert_eq!(decimals(-0.001, 1), "0.0", "no negative zero");
        assert_eq!((shortest(-0.0), shortest(-2.50), shortest(1000.0)), ("0".into(), "−2.5".into(), "1000".into()));
        assert_eq!((percent(0.5, 8.0), percent(1.0, 0.0)), ("6.2 %".into(), "–".into()));
        assert_eq!((quantity(18.437, "µm"), count(25_000)), ("18.4 µm".into(), "25\u{202f}000".into()));
        assert_eq!((as_far_as(0.5105, 0.22, 2), as_far_as(1234.5, 345.0, 2)), ("0.51".into(), "1234".into()));
        assert_eq!((as_far_as(150.002, 3e-6, 2), as_far_as(0.0, 0.0, 2)), ("150.0020000".into(), "0.000".into()));
        assert_eq!(printable("a\u{1}b\0c\n"), "a b c\n");
    }

    #[test]
    fn round_factors() {
        for (value, round) in [(499.0, 200.0), (500.0, 500.0), (1_000.0, 1_000.0), (0.07, 0.05), (1.99, 1.0)] {
            assert!((round_down(value) / round - 1.0).abs() < 1e-12, "{value} gave {}", round_down(value));
        }
        for odd in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(round_down(odd), 1.0);
        }
    }
}
