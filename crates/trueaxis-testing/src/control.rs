//! A minimal control: runs a LinuxCNC probing program of X, Y, Z against a function that returns the gap to a surface.

use std::fmt::Write;

/// State of the machine on a probing move.
pub struct Touch {
    /// Pauses passed, from 0.
    pub set_up: Option<usize>,
    /// X, Y, Z as the control counts them.
    pub at: [f64; 3],
    /// Axes that arrived in negative travel.
    pub reverse: [bool; 3],
    /// Touches before this one.
    pub count: f64,
}

/// Runs a program and returns its log. `gap`: from the tip to the nearest surface, mm, negative inside.
pub fn run(program: &str, mut gap: impl FnMut(Touch) -> f64) -> String {
    let (mut log, mut at, mut reverse) = (String::new(), [0.0_f64; 3], [false; 3]);
    let (mut set_up, mut count) = (None::<usize>, 0.0);
    let mut trip = [0.0; 3];
    for line in program.lines() {
        if let Some(text) = line.strip_prefix("(LOG,") {
            let text = text.trim_end_matches(')');
            let text = text.replace("#5070", "1.000000");
            let text = (0..3).fold(text, |text, k| text.replace(&format!("#{}", 5061 + k), &format!("{:.6}", trip[k])));
            writeln!(log, "{text}").unwrap();
        }
        if line == "M0" {
            set_up = Some(set_up.map_or(0, |set_up| set_up + 1));
        }
        let mut words = line.split(' ');
        let code = words.next().unwrap_or_default();
        if !matches!(code, "G0" | "G1" | "G38.2") {
            continue;
        }
        let mut end = at;
        for word in words {
            let (letter, value) = word.split_at(1);
            if let Some(axis) = ["X", "Y", "Z"].iter().position(|known| *known == letter) {
                end[axis] = value.parse().unwrap();
            }
        }
        for k in 0..3 {
            if (end[k] - at[k]).abs() > 0.01 {
                reverse[k] = end[k] < at[k];
            }
        }
        if code == "G38.2" {
            let on = |share: f64| -> [f64; 3] { std::array::from_fn(|k| at[k] + share * (end[k] - at[k])) };
            let mut gap = |share: f64| gap(Touch { set_up, at: on(share), reverse, count });
            let (mut low, mut high) = (0.0, 1.0);
            assert!(gap(low) > 0.0 && gap(high) < 0.0, "{line}: {} {}", gap(low), gap(high));
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if gap(middle) > 0.0 { low = middle } else { high = middle }
            }
            trip = on(low);
            count += 1.0;
            end = trip;
        }
        at = end;
    }
    log
}
