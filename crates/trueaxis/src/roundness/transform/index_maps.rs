//! Exhaustive tests of the transform's index maps: every permitted number of points, every stage, every slice.

use super::*;
use crate::roundness::settings::{FEWEST_POINTS, MOST_POINTS};
use std::vec::Vec;

/// Calls a function of N for every permitted number of points.
macro_rules! for_all_sizes {
    ($function:ident) => {{
        let sizes = [64, 128, 256, 512, 1024, 2048, 4096];
        assert_eq!([sizes[0], sizes[6]], [FEWEST_POINTS, MOST_POINTS]);
        $function::<64>();
        $function::<128>();
        $function::<256>();
        $function::<512>();
        $function::<1024>();
        $function::<2048>();
        $function::<4096>();
    }};
}

/// Checks that each of `0..size` occurs exactly once.
fn assert_bijection(found: impl IntoIterator<Item = usize>, size: usize, what: &str) {
    let mut times = std::vec![0u8; size];
    for index in found {
        assert!(index < size, "{what}: {index} of {size}");
        times[index] += 1;
    }
    assert!(times.iter().all(|times| *times == 1), "{what}: {size} values");
}

#[test]
fn every_stage_of_radix_4_touches_every_value_once() {
    fn stages<const N: usize>() {
        // Each factor is replaced by its number, which shows which one is used.
        let numbered: Vec<Complex<f64>> = (0..N).map(|i| [i as f64, 0.0]).collect();
        let circle: &[Complex<f64>; N] = numbered.as_slice().try_into().unwrap();
        let mut stage = 0;
        while slices::<N>(stage) > 0 {
            let quarter = quarter::<N>(stage);
            let mut touched = Vec::new();
            for at in 0..slices::<N>(stage) {
                if quarter <= 2 {
                    let eight = at & (N / 16 - 1);
                    touched
                        .extend(pairs_of_butterflies(quarter).iter().flat_map(|(_, four)| four.map(|i| 8 * eight + i)));
                    continue;
                }
                let (i, factors) = operands(circle, at, quarter);
                let four = [0, 1, 2, 3].map(|k| i + k * quarter);
                assert_eq!(four, [i, i | quarter, i | (2 * quarter), i | (3 * quarter)], "{N} {stage} {at}");
                // e^{−j2πki/(4·quarter)} for place i within the block, by the definition of the transform.
                let turn = (i % quarter) * (N / (4 * quarter));
                assert_eq!(factors.map(|[at, _]| at as usize), [turn, 2 * turn, 3 * turn], "{N} {stage} {at}");
                touched.extend(four);
            }
            assert_bijection(touched, N / 2, "values of a stage");
            stage += 1;
        }
        assert!(stage >= 2 && quarter::<N>(stage) == 0);
    }
    for_all_sizes!(stages);
}

/// Every slice is in range, even one that is never due, so no index can panic.
#[test]
fn no_slice_is_out_of_range() {
    fn slices_beyond<const N: usize>() {
        let circle = [[0.0f32; 2]; N];
        for quarter in (0..).map(quarter::<N>).take_while(|quarter| *quarter > 2) {
            for at in (0..4 * N).chain([usize::MAX - 1, usize::MAX, usize::MAX / 2, 1 << 31]) {
                let (i, _) = operands(&circle, at, quarter);
                assert!(i + 3 * quarter < N / 2, "{N} {quarter} {at}");
            }
        }
        let mut z = [1.0f32; N];
        let multipliers = [0.0; N];
        let mut pairs = Pairs::NONE;
        for at in (0..2 * N).chain([usize::MAX]) {
            twos_slice(&mut z, at);
            forward_slice(&mut z, &circle, at, 2);
            inverse_slice(&mut z, &circle, at, 1);
            let from = z;
            pair_slice(&from, &mut z, &circle, &multipliers, &mut pairs, at);
        }
    }
    slices_beyond::<64>();
    slices_beyond::<128>();
    slices_beyond::<4096>();
}

#[test]
fn the_stage_of_radix_2_touches_every_value_once() {
    fn stage<const N: usize>() {
        let count = slices_of_twos::<N>();
        assert_eq!(count > 0, (N / 2).ilog2() % 2 == 1, "{N} points");
        // The sum of a pair goes to the first value, the difference to the second: powers of two distinguish them.
        let mut z: Vec<f64> = (0..N).map(|i| (i + 1) as f64).collect();
        let before = z.clone();
        for at in 0..count {
            twos_slice::<f64, N>(z.as_mut_slice().try_into().unwrap(), at);
        }
        for (z, x) in z.chunks(4).zip(before.chunks(4)).take(if count > 0 { N } else { 0 }) {
            assert_eq!(z, [x[0] + x[2], x[1] + x[3], x[0] - x[2], x[1] - x[3]], "{N} points");
        }
    }
    for_all_sizes!(stage);
}

#[test]
fn the_bit_reversed_order_is_its_own_inverse() {
    fn order<const N: usize>() {
        assert_bijection((0..N / 2).map(harmonic::<N>), N / 2, "harmonics");
        for index in 0..N / 2 {
            let bits = (N / 2).ilog2();
            let reversed = (0..bits).fold(0, |sum, bit| sum | ((index >> bit) & 1) << (bits - 1 - bit));
            assert_eq!((harmonic::<N>(index), harmonic::<N>(reversed)), (reversed, index));
        }
        for index in [N / 2, N, usize::MAX] {
            assert!(harmonic::<N>(index) < N / 2);
        }
    }
    for_all_sizes!(order);
}

#[test]
fn the_pairs_are_each_harmonic_and_its_mirror_image_once() {
    fn pairs<const N: usize>() {
        let mut pairs = Pairs::START;
        let mut touched = std::vec![0];
        for _ in 0..N / 4 {
            assert_eq!(harmonic::<N>(pairs.at) + harmonic::<N>(pairs.partner), N / 2, "{N}: {pairs:?}");
            touched.push(pairs.at);
            touched.extend((pairs.partner != pairs.at).then_some(pairs.partner));
            pairs.next();
        }
        assert_bijection(touched, N / 2, "pairs and the mean");
    }
    for_all_sizes!(pairs);
}
