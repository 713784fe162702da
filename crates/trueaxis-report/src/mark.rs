use crate::{colour::Colour, scale::Scale};

/// Mean character width in units of the text size, used to space labels.
const ADVANCE: f64 = 0.56;

/// A vertical line with a label above the plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Position on the horizontal scale.
    pub x: f64,
    /// The label.
    pub text: String,
    /// Colour of line and label.
    pub colour: Colour,
    /// Whether the line is dashed.
    pub dashed: bool,
}

/// The row of each mark's label, counted from the top: no label crosses another or another mark's line.
pub(crate) fn rows(marks: &[Mark], x: &Scale, width_px: i32, text_px: i32) -> Vec<i32> {
    let mut placed: Vec<(f64, f64, i32)> = Vec::new();
    for mark in marks {
        let start = x.share(mark.x) * f64::from(width_px);
        let end = start + (mark.text.chars().count() as f64 + 1.5) * ADVANCE * f64::from(text_px);
        let row = placed.iter().filter(|label| label.1 >= start).map(|label| label.2 + 1).max().unwrap_or(0);
        placed.push((start, end, row));
    }
    placed.into_iter().map(|label| label.2).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour;

    #[test]
    fn labels_of_marks_never_overlap() {
        let mark = |x| Mark { x, text: "p99.99 12 345 ns".to_owned(), colour: colour::LIMIT, dashed: false };
        let marks = [100.0, 101.0, 150.0, 700.0].map(mark);
        assert_eq!(rows(&marks, &Scale::exact("", 0.0, 1_000.0), 922, 11), [0, 1, 2, 0]);
    }
}
