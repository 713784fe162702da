//! The periods found, as additions to a machine.

use super::Test;
use super::document::PeriodFound;
use trueaxis_tables::finding::Fit;
use trueaxis_tables::{Additions, FoundPeriod};

impl Test {
    /// Every period, also one without a harmonic: the machine may state one. `compensated`: the machine's figures corrected it
    /// during the scan, so the record shows what they leave.
    pub fn additions(&self, compensated: bool) -> Additions {
        let found = &self.found;
        let travelled = [false, true].map(|side| self.readings.iter().any(|own| own.own.is_negative == side));
        let one_way = (travelled != [true; 2]).then_some(travelled[1]);
        let of_period = |own: &trueaxis_metrology::periodic::Period| {
            let tried = own.forward.iter().map(|own| own.number).collect();
            let own = PeriodFound::new(own, found.degrees_of_freedom as f64);
            FoundPeriod {
                axis: self.options.axis,
                period: own.period,
                length: found.length,
                harmonics: own.harmonics,
                reverse: own.reverse.unwrap_or_default(),
                one_way,
                tried,
                uncertainty: own.standard_uncertainty,
                degrees_of_freedom: found.degrees_of_freedom,
                on_top: compensated,
            }
        };
        // Noise is no misfit, however large: each harmonic exceeds it. Another wave in the record is one.
        let [before_mm, left_mm] = [found.before, found.left].map(|micro| 1e-3 * micro);
        let is_angle = self.options.axis.is_rotary();
        let fit = found.remains.map(|_| Fit { before_mm, left_mm, noise_mm: None, is_angle });
        Additions { periods: found.periods.iter().map(of_period).collect(), fit, compensated, ..Additions::default() }
    }
}
