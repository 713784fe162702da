//! Sensors that stop answering while a record goes on.

use crate::rows::Rows;

/// Readings of exactly the same value in a row that no living sensor gives where others differ.
const LEAST: usize = 8;

/// A stretch of one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stuck {
    /// Index of its first reading.
    pub from: usize,
    /// Readings.
    pub count: usize,
    /// The value.
    pub value: f64,
}

/// The longest stretch of one value, where it is long enough to be a sensor that stands still: eight readings and a fifth of
/// those that there are. A record of one value alone is taken as it is: there is nothing that moved.
pub fn longest(values: &[f64]) -> Option<Stuck> {
    let mut from = 0;
    let mut best: Option<Stuck> = None;
    for stretch in values.chunk_by(|one, other| one == other) {
        let (count, value) = (stretch.len(), stretch[0]);
        if best.is_none_or(|best| count > best.count) {
            best = Some(Stuck { from, count, value });
        }
        from += count;
    }
    best.filter(|best| best.count >= LEAST && 5 * best.count >= values.len() && best.count < values.len())
}

impl Stuck {
    /// The refusal, at the line of the first reading; `scale` from the value to the column's unit.
    pub fn error<const C: usize>(&self, rows: &Rows<'_, C>, lines: &[u32], column: &str, scale: f64) -> anyhow::Error {
        let line = lines.get(self.from).copied().unwrap_or(1);
        // The value as the file has it: nine decimals undo the change of unit.
        let value = (1e9 * scale * self.value).round() / 1e9;
        let found = format!("{value} for {} readings in a row", self.count);
        rows.error(line, column, found, "a sensor that does not stand still")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_in_a_record_that_moves_is_found_and_a_record_of_one_value_is_not() {
        let mut values: Vec<f64> = (0..20).map(f64::from).collect();
        assert_eq!(longest(&values), None);
        values[5..17].fill(3.5);
        assert_eq!(longest(&values), Some(Stuck { from: 5, count: 12, value: 3.5 }));
        assert_eq!(longest(&[0.0; 30]), None);
        assert_eq!(longest(&[]), None);
    }
}
