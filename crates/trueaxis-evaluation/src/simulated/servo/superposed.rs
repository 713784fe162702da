//! The contour error of a family at one moment, from plants in which one figure varies.

use super::family::Place;
use glam::DVec3;

/// Directions from which the worst place is sought.
const STARTS: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
/// Steps from a direction to the worst place in it and on to the direction of the error there.
const STEPS: usize = 3;

/// Effects of the figures at one moment: the error of the plant about which the family lies, µm, and its change with each
/// figure at its lower and upper end.
#[derive(Clone, Debug, Default)]
pub(super) struct Effects {
    pub(super) about: DVec3,
    pub(super) changes: Vec<[DVec3; 2]>,
}

impl Effects {
    /// Largest error over the family if the effects add up:
    ///
    /// ```text
    /// max over u, |u| = 1, of  u·e0 + Σ max(0, u·d−, u·d+)
    /// ```
    pub(super) fn largest(&self) -> f64 {
        let mut largest = 0.0;
        for start in STARTS {
            let mut direction = start;
            for _ in 0..STEPS {
                let error = self.farthest(direction);
                largest = f64::max(largest, error.length());
                direction = error.normalize_or_zero();
            }
        }
        largest
    }

    /// The error farthest in a direction.
    fn farthest(&self, direction: DVec3) -> DVec3 {
        self.changes.iter().fold(self.about, |sum, [lower, upper]| {
            let [below, above] = [lower, upper].map(|change| change.dot(direction));
            match below > above {
                _ if below <= 0.0 && above <= 0.0 => sum,
                true => sum + *lower,
                false => sum + *upper,
            }
        })
    }

    /// The error at a place of the family if the effects add up and each is proportional to its figure on either side.
    pub(super) fn at(&self, place: &Place, varied: &[(usize, usize)]) -> f64 {
        let sum = varied.iter().zip(&self.changes).fold(self.about, |sum, (&(axis, figure), [lower, upper])| {
            let share = place[axis][figure];
            sum + if share < 0.0 { *lower } else { *upper } * share.abs()
        });
        sum.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulated::servo::family::Family;
    use trueaxis::Axis;

    #[test]
    fn the_largest_sum_is_reached_at_an_end_of_each_figure_and_exceeded_nowhere() {
        let varied = Family::default().varied(&[Axis::X, Axis::Y]);
        let changes = (0..varied.len()).map(|i| {
            let (sin, cos) = (1.7 * i as f64).sin_cos();
            let change = DVec3::new(cos, sin, 0.3 * sin * cos) / (1.0 + i as f64);
            [change * -0.8, change]
        });
        let effects = Effects { about: DVec3::new(0.4, -0.1, 0.0), changes: changes.collect() };
        let largest = effects.largest();
        // Every combination of ends.
        let most = (0..1_u32 << varied.len())
            .map(|ends| {
                let mut place = Place::default();
                for (i, &(axis, figure)) in varied.iter().enumerate() {
                    place[axis][figure] = if ends >> i & 1 == 1 { 1.0 } else { -1.0 };
                }
                effects.at(&place, &varied)
            })
            .fold(0.0, f64::max);
        assert!((largest - most).abs() < 1e-12, "{largest} {most}");
        let drawn = Family::draw(1, 2000).iter().map(|place| effects.at(place, &varied)).fold(0.0, f64::max);
        assert!(drawn < largest && drawn > 0.6 * largest, "{drawn} {largest}");
    }
}
