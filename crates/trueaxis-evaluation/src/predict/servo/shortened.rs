//! Of a program of X, Y and Z alone only the features run, each with some moves before and after it, and rapids between them.

use glam::DVec3;
use trueaxis_sim::program::{Curve, Move, Program, Turn};

/// Moves before and after a feature that are simulated with it, at least so many and so long, mm: friction and lost motion then
/// have their side, and the drives follow at the programmed feed.
const BESIDE: usize = 3;
const BESIDE_MM: f64 = 30.0;
/// Shortest way between two features, mm: the simulator takes no line of length zero.
const SHORTEST_MM: f64 = 1e-6;

/// A program of the features alone.
pub(super) struct Shortened {
    pub(super) program: Program,
    /// Where the moves of the whole program are in this one.
    pub(super) index: Vec<Option<usize>>,
}

impl Shortened {
    /// `features`: first and last move of each.
    pub(super) fn of(program: &Program, features: impl Iterator<Item = [usize; 2]>) -> Shortened {
        let mut index = vec![None; program.moves.len()];
        if program.is_five_axis() {
            (0..program.moves.len()).for_each(|step| index[step] = Some(step));
            return Shortened { program: program.clone(), index };
        }
        let mut stretches: Vec<[usize; 2]> = features.map(|feature| widened(program, feature)).collect();
        stretches.sort_unstable();
        let mut moves: Vec<Move> = Vec::new();
        for [first, last] in stretches {
            for (step, own) in program.moves.iter().enumerate().take(last + 1).skip(first) {
                if index[step].is_some() {
                    continue;
                }
                let start = own.curve.position(own.curve.domain().0);
                let follows = step > 0 && index[step - 1].is_some();
                let last = moves.last().filter(|_| !follows);
                if let Some(end) = last.map(|before| before.curve.position(before.curve.domain().1))
                    && (DVec3::from(end) - DVec3::from(start)).length() > SHORTEST_MM
                {
                    let curve = Curve::Line { start: end, end: start };
                    moves.push(Move { rapid: true, feed_per_min: 0.0, curve, turn: Turn::default(), ..own.clone() });
                }
                index[step] = Some(moves.len());
                moves.push(own.clone());
            }
        }
        Shortened { program: Program { moves, ..program.clone() }, index }
    }
}

/// A feature with the moves beside it.
fn widened(program: &Program, [mut first, mut last]: [usize; 2]) -> [usize; 2] {
    let length = |step: usize| program.moves[step].curve.length();
    let (mut count, mut mm) = (0, 0.0);
    while first > 0 && (count < BESIDE || mm < BESIDE_MM) {
        first -= 1;
        (count, mm) = (count + 1, mm + length(first));
    }
    (count, mm) = (0, 0.0);
    while last + 1 < program.moves.len() && (count < BESIDE || mm < BESIDE_MM) {
        last += 1;
        (count, mm) = (count + 1, mm + length(last));
    }
    [first, last]
}
