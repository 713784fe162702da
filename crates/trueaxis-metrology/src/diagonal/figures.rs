//! Figures of a diagonal in the terms of ISO 230-6.

use super::Test;
use crate::accuracy::{Approach, Direction, Measurement, evaluate};
use std::vec::Vec;
use trueaxis::Axis;

/// Figures of one diagonal, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Figures {
    /// E(D): range of the mean deviations of both directions.
    pub systematic: f64,
    /// B(D): largest difference between the directions at a target; `None` with one direction.
    pub reversal: Option<f64>,
    /// M(D): range of the mean of both directions.
    pub mean_range: f64,
    /// R(D): repeatability, bidirectional if both directions were measured; `None` with one run.
    pub repeatability: Option<f64>,
}

/// Computes the figures of each diagonal; R(D) only if every target has every run, as ISO 230-2 defines it.
pub fn figures(test: &Test) -> [Figures; 4] {
    std::array::from_fn(|k| {
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
            if low <= high { high - low } else { 0.0 }
        };
        let both = test.on(k).filter_map(|target| target.mean_mm[0].zip(target.mean_mm[1]));
        Figures {
            systematic: range(&mut test.on(k).flat_map(|target| target.mean_mm).flatten()),
            reversal: both.map(|(up, down)| (up - down).abs()).reduce(f64::max),
            mean_range: range(&mut test.on(k).map(super::Target::mean)),
            repeatability: repeatability(test, k),
        }
    })
}

/// R of ISO 230-2 with the distance along the diagonal as the position.
fn repeatability(test: &Test, k: usize) -> Option<f64> {
    let own = &test.diagonals[k];
    let mut approaches = Vec::new();
    for target in test.on(k) {
        let of = test.readings.iter().filter(|reading| reading.diagonal == k);
        let here = of.filter(|reading| {
            let off = super::less(reading.position_mm, target.position_mm);
            super::dot(off, off).sqrt() < 1e-6 * own.length_mm
        });
        approaches.extend(here.map(|reading| Approach {
            position: target.along_mm,
            run: reading.run,
            direction: reading.direction,
            deviation: reading.deviation_mm,
        }));
    }
    // Any linear axis will do: only the letter would differ.
    let found = evaluate(&Measurement::new(Axis::X, approaches).ok()?).ok()?;
    let one_way = |direction| match direction {
        Direction::Up => found.up,
        Direction::Down => found.down,
    };
    let both = found.both.map(|both| both.repeatability);
    both.or_else(|| [Direction::Up, Direction::Down].into_iter().find_map(one_way).map(|way| way.repeatability))
}
