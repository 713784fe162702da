//! Numbers as they are written into files.

/// The shortest decimal u with u / scale == value, or else the double nearest to value · scale.
pub(super) fn shortest(value: f64, scale: f64) -> f64 {
    let micro = value * scale;
    for near in [micro, micro.next_up(), micro.next_down()] {
        for digits in 0..17 {
            let text = format!("{near:.digits$e}");
            if let Ok(candidate) = text.parse::<f64>()
                && candidate / scale == value
            {
                // −0 reads back as 0: the sign of nothing is no information.
                return candidate + 0.0;
            }
        }
    }
    micro
}

/// The value of a comment as TOML: a list, a word in quotes, or as it is.
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
