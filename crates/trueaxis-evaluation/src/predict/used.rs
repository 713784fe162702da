//! How much of its tolerance a characteristic uses.

use super::document::Predicted;
use trueaxis_metrology::uncertainty::Interval;

impl Predicted {
    /// Share of the tolerance that is used: the end of the interval that is closest to a limit, or beyond it farthest, of a
    /// zone as a share of its width, otherwise of half the distance of the limits, from their middle. Up to 1 the whole
    /// interval is within the tolerance. Without uncertainties that of the value, with the servo if that was run.
    pub fn used(&self) -> f64 {
        let um = self.everything_um.unwrap_or(self.corrected_um);
        let value = Interval { low: um, high: um };
        let Interval { low, high } = self.known.as_ref().map_or(value, |known| known.interval_um);
        match self.limits_um {
            [Some(least), Some(most)] => {
                let [middle, half] = [0.5 * (least + most), 0.5 * (most - least)];
                (high - middle).max(middle - low) / half
            }
            [_, Some(width)] => high / width,
            [_, None] => 0.0,
        }
    }
}
