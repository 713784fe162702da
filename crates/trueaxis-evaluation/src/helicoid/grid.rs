//! The grid of surface parameters.

use serde::Serialize;
use std::f64::consts::PI;

/// Maximum number of points in a grid.
pub const MOST: usize = 1_000_000;

/// Equidistant values, both ends included.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Range {
    /// First value, rad.
    pub start: f64,
    /// Last value, rad.
    pub stop: f64,
    /// Number of values, at least 1; 1 means `start` alone.
    pub count: usize,
}

impl Range {
    /// Reads START:STOP:COUNT; a COUNT of 1 is START alone.
    ///
    /// # Errors
    /// Found and needed, without the option's name.
    pub fn parse(text: &str) -> Result<Range, String> {
        let needed = "START:STOP:COUNT, two finite angles in rad and a whole number from 1";
        let wrong = || format!("found {text}, needed {needed}");
        let mut parts = text.split(':');
        let (Some(start), Some(stop), Some(count), None) = (parts.next(), parts.next(), parts.next(), parts.next())
        else {
            return Err(wrong());
        };
        let (Some(start), Some(stop)) = (finite(start), finite(stop)) else { return Err(wrong()) };
        match count.trim().parse::<usize>() {
            Ok(count) if (1..=MOST).contains(&count) => Ok(Range { start, stop, count }),
            Ok(count) => Err(format!("found COUNT {count}, needed 1 to {MOST}")),
            Err(_) => Err(wrong()),
        }
    }

    /// The values in order; the last is STOP itself.
    pub fn values(self) -> impl DoubleEndedIterator<Item = f64> + ExactSizeIterator {
        let last = self.count.saturating_sub(1);
        (0..self.count).map(move |i| match i {
            0 => self.start,
            i if i == last => self.stop,
            i => self.start + (self.stop - self.start) * i as f64 / last as f64,
        })
    }
}

fn finite(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite())
}

/// Whether a step along a grid line turns the table by more than half a turn, so that a straight move between its points would
/// leave the surface by far.
pub fn is_coarse(range: Range) -> bool {
    range.count > 1 && (range.stop - range.start).abs() / (range.count - 1) as f64 > PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_as_they_are_written() {
        let values = |text: &str| Range::parse(text).unwrap().values().collect::<Vec<_>>();
        assert_eq!(values("-1:2:4"), [-1.0, 0.0, 1.0, 2.0]);
        assert_eq!(values("2:-2.5e-1:2"), [2.0, -0.25]);
        assert_eq!(values("0.1:9:1"), [0.1]);
        assert_eq!(*values("0.1:0.7:7").last().unwrap(), 0.7);
        for bad in ["", "1:2", "1:2:3:4", "1:2:0", "1:2:-3", "1:2:2.5", "a:2:3", "nan:1:2", "0:inf:2", "0:1:1000001"] {
            assert!(Range::parse(bad).unwrap_err().contains("needed"), "{bad}");
        }
    }
}
