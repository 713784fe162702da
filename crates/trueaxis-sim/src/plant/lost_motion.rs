//! Lost motion.

/// Lost motion between encoder and carriage: a play that is traversed at each reversal.
///
/// The table applies in positive travel; in negative travel the carriage stays behind, actual − indicated = +backlash.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LostMotion {
    width: f64,
    reverse: f64,
}

impl LostMotion {
    /// A play of `width` mm (deg), approached in positive travel. A width of 0 switches at once.
    pub(super) fn new(width: f64) -> LostMotion {
        LostMotion { width: width.abs(), reverse: 0.0 }
    }

    /// Follows a travel of `travel` mm (deg) on the encoder's side.
    pub(super) fn follow(&mut self, travel: f64) {
        let moved = if self.width > 0.0 { travel / self.width } else { travel * f64::MAX };
        self.reverse = (self.reverse - moved).clamp(0.0, 1.0);
    }

    /// Traversed share of the play: 0 in positive travel, 1 in negative travel.
    pub(super) fn reverse(&self) -> f64 {
        self.reverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn play_is_traversed_within_its_width() {
        let mut play = LostMotion::new(0.010);
        play.follow(1.0);
        assert_eq!(play.reverse(), 0.0);
        play.follow(-0.004);
        assert!((play.reverse() - 0.4).abs() < 1e-12);
        play.follow(-0.006);
        play.follow(-2.0);
        assert!((play.reverse() - 1.0).abs() < 1e-12);
        play.follow(0.0025);
        assert!((play.reverse() - 0.75).abs() < 1e-12);
    }
}
