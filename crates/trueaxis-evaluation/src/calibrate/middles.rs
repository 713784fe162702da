//! Middles of touches on opposite sides, which are the centres of a plate's balls or holes.

use super::plan::{Plan, Planned};
use trueaxis_metrology::calibration::{Surface, Touch};

/// The touches of a network, the touch of the plan that each belongs to, and its opposite.
type Middles = (Vec<Touch>, Vec<usize>, Vec<Option<usize>>);

/// Replaces two touches on opposite sides of a ball or a hole by their middle, which belongs to the first of them.
pub(super) fn middles(plan: &Plan, touches: Vec<Touch>) -> Middles {
    let (mut all, mut of, mut opposites): Middles = (Vec::new(), Vec::new(), Vec::new());
    // Index in `all` of touches that still lack their opposite.
    let mut waiting: Vec<usize> = Vec::new();
    for (index, touch) in touches.into_iter().enumerate() {
        if let Surface::Centre(_) = touch.surface {
            let opposite = |one: &usize| is_opposite(&plan.touches[of[*one]], &plan.touches[index]);
            if let Some(at) = waiting.iter().position(opposite) {
                let first = waiting.remove(at);
                merge(&mut all[first], touch);
                opposites[first] = Some(index);
                continue;
            }
            waiting.push(all.len());
        }
        all.push(touch);
        of.push(index);
        opposites.push(None);
    }
    (all, of, opposites)
}

/// Direction of a probing move.
pub(super) fn way(touch: &Planned) -> [f64; 3] {
    let way: [f64; 3] = std::array::from_fn(|k| touch.end[k] - touch.start[k]);
    let length = way.iter().map(|part| part * part).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    way.map(|part| part / length)
}

fn is_opposite(one: &Planned, other: &Planned) -> bool {
    let cosine: f64 = way(one).into_iter().zip(way(other)).map(|(a, b)| a * b).sum();
    (one.artefact, one.place, one.feature) == (other.artefact, other.place, other.feature) && cosine < -0.99
}

/// The mean of two vectors.
pub(super) fn middle(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| 0.5 * (a[k] + b[k]))
}

fn merge(first: &mut Touch, second: Touch) {
    first.tip_mm = middle(first.tip_mm, second.tip_mm);
    for (one, other) in first.response.iter_mut().zip(second.response) {
        *one = middle(*one, other);
    }
    first.drift.extend(second.drift);
    first.drift.iter_mut().for_each(|(_, weight)| *weight *= 0.5);
    if let Surface::Centre(centre) = &mut first.surface {
        centre.weight = 2_f64.sqrt();
    }
}
