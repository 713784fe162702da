//! Numbers and text as they appear on a page.

/// A number with `digits` significant digits and a true minus sign; a dash if it is not finite.
pub(super) fn significant(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value != 0.0 && !(1e-4..1e6).contains(&value.abs()) {
        return format!("{value:.2e}").replace('-', "−");
    }
    let magnitude = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    let places = usize::try_from(digits - 1 - magnitude).unwrap_or(0);
    format!("{value:.places$}").replace('-', "−")
}

/// A tick's label: as many digits as it needs, at most six decimals.
pub(super) fn tick(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.replace('-', "−") }
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

/// Text made safe inside an element or a quoted attribute; what XML does not permit becomes a space.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_text_read_as_printed() {
        assert_eq!(significant(18.437, 3), "18.4");
        assert_eq!(significant(-0.012_34, 3), "−0.0123");
        assert_eq!(significant(1234.4, 3), "1234");
        assert_eq!(significant(f64::NAN, 3), "–");
        assert_eq!((tick(-0.0), tick(-2.50), tick(1000.0)), ("0".into(), "−2.5".into(), "1000".into()));
        for (value, round) in [(499.0, 200.0), (500.0, 500.0), (0.07, 0.05), (1.99, 1.0), (-3.0, 1.0), (f64::NAN, 1.0)]
        {
            assert!((round_down(value) / round - 1.0).abs() < 1e-12, "{value}");
        }
        assert_eq!(escape("a<b & \"c\"\u{1}"), "a&lt;b &amp; &quot;c&quot; ");
    }
}
