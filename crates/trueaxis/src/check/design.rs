//! Margins of the whole loop, and the choice of its notch.

use super::margins::{Closed, Margins, rigid};
use super::notch::Notch;
use super::resonance::{Spread, above, worst};

/// Dampings and bottoms of the notches that are tried.
const SHAPES: [[f64; 2]; 4] = [[0.5, 0.2], [0.5, 0.5], [1.0, 0.2], [1.0, 0.5]];
/// How far a notch may be from the stated resonance, as a share of it. A slower one would be a lag for the whole loop.
const NEAR: f64 = 0.2;
/// A notch costs lag, and is worth it if the gains may be larger by this factor.
const WORTH: f64 = 1.1;

/// The margins of a drive in the contour feedback, with its notch.
pub(super) fn margins(closed: &Closed<'_>, spread: &Spread) -> Margins {
    with(closed, spread, chosen(closed).as_ref())
}

fn with(closed: &Closed<'_>, spread: &Spread, notch: Option<&Notch>) -> Margins {
    let rigid = rigid(closed, notch);
    let Some(peak) = worst(closed, spread, notch) else { return rigid };
    Margins { resonance: Some(peak.margin()), factor: rigid.factor.min(peak.factor()), ..rigid }
}

/// The factor by which both gains may grow with any resonance above a frequency, Hz.
pub(super) fn safe_factor(closed: &Closed<'_>, lowest_hz: f64) -> f64 {
    let peak = above(closed, lowest_hz, None);
    rigid(closed, None).factor.min(peak.factor())
}

/// The notch with which the gains may be the largest, if they may be larger than without one; `None` as well if no
/// resonance is stated.
///
/// It depends on the ratio of the gains, not on their size, and not on the uncertainty of the resonance, so that a
/// controller chooses the same.
pub(super) fn chosen(closed: &Closed<'_>) -> Option<Notch> {
    if closed.drive.resonance_hz <= 0.0 {
        return None;
    }
    let bare = with(closed, &Spread::LEAST, None);
    let peak = bare.resonance.filter(|_| bare.factor > 0.0)?;
    let (mut best, mut found) = (bare.factor * WORTH, None);
    let stated = closed.drive.resonance_hz;
    let at_peak = Some(peak.frequency_hz).filter(|peak| (peak / stated - 1.0).abs() < NEAR && *peak != stated);
    for frequency_hz in [Some(stated), at_peak].into_iter().flatten() {
        for [damping, bottom] in SHAPES {
            let notch = Notch { frequency_hz, damping, bottom };
            // The rigid loops only lose by a notch, and are left until it is worth while.
            let factor = worst(closed, &Spread::LEAST, Some(&notch)).map_or(0.0, |peak| peak.factor());
            if factor > best {
                let factor = factor.min(rigid(closed, Some(&notch)).factor);
                if factor > best {
                    (best, found) = (factor, Some(notch));
                }
            }
        }
    }
    found
}
