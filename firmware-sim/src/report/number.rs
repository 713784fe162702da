//! Numbers and text as they appear on the page.

/// Largest magnitude that is plotted; beyond it a value is treated as undefined.
pub(super) const PLOTTABLE: f64 = 1e12;

/// A number with `digits` significant digits, grouped in threes; a dash if it is not finite.
pub(super) fn significant(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value != 0.0 && !(1e-6..PLOTTABLE).contains(&value.abs()) {
        return format!("{value:.2e}").replace('-', "−");
    }
    let magnitude = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    decimals(value, (digits - 1 - magnitude).max(0))
}

/// A number with a fixed count of decimals, grouped in threes by narrow spaces (ISO 80000-1), with a true minus sign.
pub(super) fn decimals(value: f64, count: i32) -> String {
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

/// A count, grouped in threes.
pub(super) fn count(value: u64) -> String {
    decimals(value as f64, 0)
}

/// The member of 1, 2, 5 × 10^n that is not above `value`; 1 unless `value` is positive and finite.
pub(super) fn round_down(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powi(value.log10().floor() as i32);
    // The tolerance keeps 5.0 from becoming 2 when the division rounds to 4.999….
    let digit = [5.0, 2.0, 1.0].into_iter().find(|digit| digit * power <= value * (1.0 + 1e-9)).unwrap_or(1.0);
    digit * power
}

/// Text without the characters that XML does not permit; they become spaces.
pub(super) fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

/// Text made safe inside an element or a quoted attribute.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in printable(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
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
