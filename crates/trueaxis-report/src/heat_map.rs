use crate::{Colour, Figure, Scale, number::significant};

/// Colours from the lowest to the highest value, with even steps in lightness (after the scale "cividis").
const RAMP: [Colour; 6] = [
    Colour(0, 34, 78),
    Colour(53, 69, 108),
    Colour(102, 105, 112),
    Colour(148, 142, 119),
    Colour(200, 184, 102),
    Colour(254, 232, 56),
];
/// Number of values in the legend.
const KEYS: u32 = 5;

/// A map of values over a grid: `rows` from the bottom to the top of `y`, each from the left to the right of `x`.
///
/// All cells have equal size and together cover both scales. A value that is not finite leaves its cell blank. The legend
/// shows the colours of five values in `unit`.
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
            figure.area([left, bottom], [right, top], ramp(*value, low, high), 1.0);
        }
    }
    if low <= high {
        let keys = if low < high { KEYS } else { 1 };
        for key in 0..keys {
            let share = f64::from(key) / f64::from((keys - 1).max(1));
            let value = (1.0 - share) * low + share * high;
            figure.area_key(format!("{} {unit}", significant(value, 3)), ramp(value, low, high));
        }
    }
    figure
}

fn ramp(value: f64, low: f64, high: f64) -> Colour {
    let last = RAMP.len() - 1;
    // Halved, so that even the widest range does not overflow.
    let share = (0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low);
    let at = if share > 0.0 { share.min(1.0) * last as f64 } else { 0.0 };
    let (below, above) = (at.floor() as usize, (at.floor() as usize + 1).min(last));
    let mix = |one: u8, other: u8| (f64::from(one) + at.fract() * (f64::from(other) - f64::from(one))).round() as u8;
    let (one, other) = (RAMP[below], RAMP[above]);
    Colour(mix(one.0, other.0), mix(one.1, other.1), mix(one.2, other.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_run_from_the_lowest_to_the_highest() {
        assert_eq!(ramp(-1.0, -1.0, 1.0), RAMP[0]);
        assert_eq!(ramp(1.0, -1.0, 1.0), RAMP[5]);
        assert_eq!(ramp(f64::MAX, f64::MIN, f64::MAX), RAMP[5]);
        assert_eq!(ramp(3.0, 3.0, 3.0), RAMP[0]);
        assert_eq!(ramp(0.2, 0.0, 1.0), RAMP[1]);
    }
}
