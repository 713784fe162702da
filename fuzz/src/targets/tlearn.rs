//! Files with a learned correction, as the controller reads them.

use crate::execution::SLOWEST;
use crate::{Target, outcome, sum};
use trueaxis::learned::{HEADER_BYTES, Learned, LearnedHeader, MAGIC, NODE_BYTES};

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "tlearn",
    about: "learned corrections (.tlearn)",
    run,
    seeds,
    repair,
    dictionary: include_str!("../../dictionaries/tlearn.dict"),
    slowest: SLOWEST,
};

fn run(bytes: &[u8]) {
    let double = Learned::<f64>::parse(bytes);
    let learned = match (double, Learned::<f32>::parse(bytes)) {
        (Ok(double), Ok(single)) => {
            assert_eq!((double.header(), double.crc()), (single.header(), single.crc()));
            both(&double, &single);
            double
        }
        (Err(double), Err(single)) => {
            assert_eq!(double, single);
            assert!((1..=13).contains(&double.code()));
            outcome::saw(double.code());
            return assert!(!double.to_string().contains(char::is_control));
        }
        (double, single) => panic!("{double:?} in double precision, {single:?} in single"),
    };
    let header = learned.header();
    assert_eq!(header.to_bytes(), bytes[..HEADER_BYTES]);
    assert_eq!(header.nodes(), Some(learned.nodes().len() as u64));
    assert_eq!(bytes.len(), HEADER_BYTES + NODE_BYTES * learned.nodes().len() + 4);
    let length_mm = 1e-6 * header.length_nm as f64;
    // Exact in f64 up to 2^53 nm, nine thousand kilometres.
    if header.length_nm < 1 << 53 {
        assert_eq!(learned.expect_program(header.program_id, length_mm), Ok(()));
    }
    assert!(learned.expect_program(!header.program_id, length_mm).is_err());
    assert_eq!(learned.expect_machine(header.machine_id), Ok(()));
    assert!(learned.expect_machine(!header.machine_id).is_err());
    outcome::accepted();
    outcome::saw(learned.nodes().len().ilog2());
    damaged(bytes);
}

/// Zero at the ends and beyond, never larger than the nodes, nearly equal in both precisions.
fn both(double: &Learned<'_, f64>, single: &Learned<'_, f32>) {
    let header = double.header();
    let largest = double.nodes().flatten().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    assert!(largest <= 32_768.0 * 1e-9 * f64::from(header.resolution_pm) * (1.0 + 1e-15));
    let end = u64::from(header.spacing_nm) * (double.nodes().len() as u64 - 1);
    for at in [0, end, end.saturating_add(1), u64::MAX] {
        assert_eq!(double.at_nm(at), [0.0; 3], "at {at} nm");
        assert_eq!(single.at_nm(at), [0.0; 3], "at {at} nm");
    }
    for length in [-1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        assert_eq!(double.at(length), [0.0; 3]);
    }
    for part in 1..16 {
        let at = end / 16 * part + u64::from(header.parts) % 97;
        for (double, single) in double.at_nm(at).into_iter().zip(single.at_nm(at)) {
            assert!(double.abs() <= largest * (1.0 + 1e-12), "{double} at {at} nm, nodes to {largest}");
            assert!((double - f64::from(single)).abs() <= 1e-6 * largest, "{double} and {single} at {at} nm");
        }
    }
}

/// A file with a wrong bit, a missing byte or an additional one is refused.
fn damaged(good: &[u8]) {
    let mut bytes = good.to_vec();
    let choice = usize::from(good[good.len() - 1]) << 8 | usize::from(good[good.len() - 2]);
    let bit = choice % (8 * good.len());
    bytes[bit / 8] ^= 1 << (bit % 8);
    assert!(Learned::<f32>::parse(&bytes).is_err(), "bit {bit} wrong");
    assert!(Learned::<f32>::parse(&good[..choice % good.len()]).is_err());
    bytes.clone_from(&good.to_vec());
    bytes.push(good[0]);
    assert!(Learned::<f32>::parse(&bytes).is_err());
}

fn seeds() -> Vec<Vec<u8>> {
    let header = LearnedHeader {
        parts: 2,
        machine_id: 0x11,
        program_id: 0x22,
        length_nm: 10_000_000,
        spacing_nm: 4_000_000,
        resolution_pm: 500,
    };
    let coarse = LearnedHeader { length_nm: 1, spacing_nm: 1_000_000_000, resolution_pm: 1_000_000, ..header };
    let wide = LearnedHeader { length_nm: 7_000_000_000, spacing_nm: 1_000_000_000, ..coarse };
    let nodes = [[0; 3], [100, -200, 0], [32_767, 3, -32_768], [0; 3]];
    vec![
        file(&header, &nodes),
        file(&coarse, &[[0; 3]; 2]),
        file(&wide, &[&nodes[..3], &nodes[1..3], &nodes[1..]].concat()),
    ]
}

/// A file of four nodes for other targets.
pub(super) fn seed() -> Vec<u8> {
    seeds().swap_remove(0)
}

fn file(header: &LearnedHeader, nodes: &[[i16; 3]]) -> Vec<u8> {
    let mut bytes = header.to_bytes().to_vec();
    bytes.extend(nodes.iter().flatten().flat_map(|count| count.to_le_bytes()));
    bytes.extend([0; 4]);
    sum::seal(&mut bytes);
    bytes
}

/// Sets the number of nodes from the file's length, a matching path length, zero ends, and the sum.
fn repair(bytes: &mut Vec<u8>) {
    if !bytes.starts_with(&MAGIC) || bytes.len() < HEADER_BYTES + 2 * NODE_BYTES + 4 {
        return;
    }
    let nodes = (bytes.len() - HEADER_BYTES - 4) / NODE_BYTES;
    bytes.truncate(HEADER_BYTES + NODE_BYTES * nodes + 4);
    let spacing = u64::from(u32::from_le_bytes([bytes[28], bytes[29], bytes[30], bytes[31]]));
    let length = u64::from_le_bytes([20, 21, 22, 23, 24, 25, 26, 27].map(|at: usize| bytes[at]));
    // Keeps the part of the length that fits into the last cell.
    let rest = length.checked_rem(spacing).unwrap_or(0);
    let length = spacing.saturating_mul(nodes as u64 - 2).saturating_add(if rest == 0 { spacing } else { rest });
    bytes[20..28].copy_from_slice(&length.to_le_bytes());
    bytes[36..40].copy_from_slice(&(nodes as u32).to_le_bytes());
    let last = HEADER_BYTES + NODE_BYTES * (nodes - 1);
    bytes[HEADER_BYTES..HEADER_BYTES + NODE_BYTES].fill(0);
    bytes[last..last + NODE_BYTES].fill(0);
    sum::seal(bytes);
}
