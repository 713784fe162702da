use crate::{Colour, Figure, Scale, colour, number::significant};

/// Number of values in the legend.
const KEYS: u32 = 5;

/// A map of values over a grid: `rows` from the bottom to the top of `y`, each from the left to the right of `x`.
///
/// All cells have equal size and together cover both scales. Their colours are those of errors in the desk. A value that is not
/// finite leaves its cell blank. The legend shows the colours of five values in `unit`.
#[must_use]
pub fn heat_map(description: &str, x: Scale, y: Scale, rows: &[Vec<f64>], unit: &str) -> Figure {
    let values = || rows.iter().flatten().copied().filter(|value| value.is_finite());
    let [low, high] = [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
    let edge =
        |scale: &Scale, cell: usize, of: usize| scale.low + (scale.high - scale.low) * cell as f64 / of.max(1) as f64;
    let mut figure = Figure::half(description, 420, x.clone(), y.clone());
    for (j, row) in rows.iter().enumerate() {
        let [bottom, top] = [j, j + 1].map(|j| edge(&y, j, rows.len()));
        for (i, value) in row.iter().enumerate().filter(|(_, value)| value.is_finite()) {
            let [left, right] = [i, i + 1].map(|i| edge(&x, i, row.len()));
            figure.area([left, bottom], [right, top], shade(*value, low, high), 1.0);
        }
    }
    if low <= high {
        let keys = if low < high { KEYS } else { 1 };
        for key in 0..keys {
            let share = f64::from(key) / f64::from((keys - 1).max(1));
            let value = (1.0 - share) * low + share * high;
            figure.area_key(format!("{} {unit}", significant(value, 3)), shade(value, low, high));
        }
    }
    figure
}

fn shade(value: f64, low: f64, high: f64) -> Colour {
    // Halved, so that even the widest range does not overflow.
    let share = (0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low);
    colour::of_error(if share > 0.0 { share } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_run_from_the_lowest_to_the_highest() {
        let [first, last] = [0.0, 1.0].map(colour::of_error);
        assert_eq!(shade(-1.0, -1.0, 1.0), first);
        assert_eq!(shade(1.0, -1.0, 1.0), last);
        assert_eq!(shade(f64::MAX, f64::MIN, f64::MAX), last);
        assert_eq!(shade(3.0, 3.0, 3.0), first);
        assert_eq!(shade(0.25, 0.0, 1.0), colour::of_error(0.25));
    }
}
