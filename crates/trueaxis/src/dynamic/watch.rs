//! Watch on the contour feedback: an error that repeatedly changes sides, each time exceeding a level, is an oscillation.
//!
//! A reversal or a corner throws the tool to one side; only a loop without margin throws it back and forth. The feedback
//! is ramped out after [`TURNS`] sign changes, each within a quarter of a second of the previous one; it stays out until
//! the compensation is switched off or a reset arrives.

#![deny(clippy::indexing_slicing)]

use crate::machine::FeedbackSettings;
use crate::real::Real;

/// Changes of sign that make an oscillation.
const TURNS: u8 = 8;
/// Longest time between two sign changes, s.
const APART_S: f64 = 0.25;

/// Level and time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watch<R> {
    level: R,
    /// Cycles.
    apart: u32,
}

/// State of one direction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Swing {
    /// Side on which the error last exceeded the level: −1, 1; initially 0.
    side: i8,
    turns: u8,
    /// Cycles since the last change.
    since: u32,
}

impl<R: Real> Watch<R> {
    pub(super) fn new(settings: &FeedbackSettings, period_s: f64) -> Self {
        Watch { level: R::of(settings.watch_mm), apart: (APART_S / period_s) as u32 }
    }

    /// Whether the error has changed sides too often.
    #[inline(always)]
    pub(super) fn swings(&self, swing: &mut Swing, error: R) -> bool {
        swing.since = swing.since.saturating_add(1);
        if error.abs() <= self.level {
            return false;
        }
        let side = if error < R::ZERO { -1 } else { 1 };
        if side == swing.side {
            return false;
        }
        let follows = swing.side != 0 && swing.since <= self.apart;
        let turns = if follows { swing.turns.saturating_add(1) } else { 0 };
        *swing = Swing { side, turns, since: 0 };
        turns >= TURNS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watch() -> Watch<f64> {
        Watch::new(&FeedbackSettings { watch_mm: 0.01, ..FeedbackSettings::default() }, 1e-3)
    }

    /// Number of cycles until the watch detects an oscillation in an error over the cycles.
    fn trips(error: impl Fn(u32) -> f64) -> Option<u32> {
        let mut swing = Swing::default();
        (0..20_000).find(|k| watch().swings(&mut swing, error(*k)))
    }

    #[test]
    fn an_oscillation_is_found_within_nine_half_waves() {
        for hz in [5.0, 20.0, 100.0] {
            let found = trips(|k| 0.02 * (core::f64::consts::TAU * hz * f64::from(k) * 1e-3).sin()).unwrap();
            assert!(f64::from(found) * 1e-3 * hz * 2.0 <= 9.5, "{hz} Hz: {found}");
        }
    }

    #[test]
    fn small_slow_and_one_sided_errors_are_none() {
        let wave = |hz: f64, size: f64| move |k: u32| size * (core::f64::consts::TAU * hz * f64::from(k) * 1e-3).sin();
        assert_eq!(trips(wave(20.0, 0.0099)), None);
        assert_eq!(trips(wave(1.5, 0.5)), None);
        assert_eq!(trips(|k| if k % 50 < 10 { 0.05 } else { 0.0 }), None);
        // Occasional corners with three swings each.
        assert_eq!(trips(|k| if k % 1000 < 150 { wave(10.0, 0.05)(k) } else { 0.0 }), None);
    }
}
