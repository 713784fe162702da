#![allow(clippy::indexing_slicing)]

use super::*;
use std::string::ToString;
use std::vec::Vec;

fn header() -> LearnedHeader {
    // 10 mm every 4 mm: nodes at 0, 4, 8, 12.
    LearnedHeader {
        parts: 2,
        machine_id: 0x11,
        program_id: 0x22,
        length_nm: 10_000_000,
        spacing_nm: 4_000_000,
        resolution_pm: 500,
    }
}

const NODES: [[i16; 3]; 4] = [[0; 3], [100, -200, 0], [32_767, 3, -32_768], [0; 3]];

fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let sum = checksum(&bytes);
    bytes.extend(sum.to_le_bytes());
    bytes
}

fn body(header: &LearnedHeader, nodes: &[[i16; 3]]) -> Vec<u8> {
    let mut bytes = header.to_bytes().to_vec();
    bytes.extend(nodes.iter().flatten().flat_map(|count| count.to_le_bytes()));
    bytes
}

fn file(header: &LearnedHeader, nodes: &[[i16; 3]]) -> Vec<u8> {
    sealed(body(header, nodes))
}

#[test]
fn nodes_come_back_and_the_correction_is_linear_between_them() {
    let bytes = file(&header(), &NODES);
    let learned = Learned::<f64>::parse(&bytes).unwrap();
    assert_eq!(*learned.header(), header());
    let mm = |node: [i16; 3]| node.map(|count| 0.5e-6 * f64::from(count));
    for (k, node) in NODES.into_iter().enumerate() {
        let found = learned.at(4.0 * k as f64);
        assert!(found.iter().zip(mm(node)).all(|(a, b)| (a - b).abs() < 1e-15), "{k}: {found:?}");
    }
    assert_eq!(learned.nodes().len(), 4);
    // A quarter of the distance from the second node to the third.
    let [x, y, z] = learned.at(5.0);
    let expected = [0.75 * 100.0 + 0.25 * 32_767.0, -0.75 * 200.0 + 0.25 * 3.0, -0.25 * 32_768.0];
    for (found, expected) in [x, y, z].into_iter().zip(expected) {
        assert!((found - 0.5e-6 * expected).abs() < 1e-15, "{found} {expected}");
    }
    assert_eq!(learned.at_nm(5_000_000), learned.at(5.0));
    // Equal in single precision, to its rounding.
    let single = Learned::<f32>::parse(&bytes).unwrap().at_nm(5_000_000);
    assert!(single.iter().zip([x, y, z]).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-8));
}

#[test]
fn beyond_the_ends_there_is_nothing_and_nothing_jumps() {
    let bytes = file(&header(), &NODES);
    let learned = Learned::<f64>::parse(&bytes).unwrap();
    for length in [-1.0, 0.0, 12.0, 1e3, 1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        assert_eq!(learned.at(length), [0.0; 3], "{length}");
    }
    assert_eq!(learned.at_nm(u64::MAX), [0.0; 3]);
    // 0.1 µm further: at most the steepest slope of the nodes.
    let steepest = 0.5e-6 * 32_768.0 / 4.0;
    for i in 0..=130_000 {
        let s = 1e-4 * f64::from(i);
        let (here, ahead) = (learned.at(s), learned.at(s + 1e-4));
        assert!(here.iter().zip(ahead).all(|(a, b)| (a - b).abs() <= 1.01e-4 * steepest), "{s}");
        assert!(here.iter().all(|value| value.abs() <= 0.5e-6 * 32_768.0 * (1.0 + f64::EPSILON)));
    }
}

#[test]
fn every_damage_is_refused() {
    let good = file(&header(), &NODES);
    for length in 0..good.len() {
        assert!(Learned::<f32>::parse(&good[..length]).is_err(), "{length} bytes");
    }
    for bit in 0..8 * good.len() {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(Learned::<f32>::parse(&bytes).is_err(), "bit {bit}");
    }
    let mut longer = good.clone();
    longer.push(0);
    assert_eq!(Learned::<f32>::parse(&longer), Err(LearnedError::TooLong));
    assert_eq!(Learned::<f32>::parse(b"TRUEAXIS........"), Err(LearnedError::Magic));
    let mut version = good.clone();
    version[8] = 9;
    assert_eq!(Learned::<f32>::parse(&version), Err(LearnedError::Version));
    let mut flipped = good.clone();
    flipped[50] ^= 1;
    assert_eq!(Learned::<f32>::parse(&flipped), Err(LearnedError::Checksum));
}

/// Files with a correct checksum and a wrong value.
#[test]
fn figures_out_of_range_are_refused_with_the_figure() {
    let refused = |header: LearnedHeader, nodes: &[[i16; 3]]| Learned::<f64>::parse(&file(&header, nodes)).unwrap_err();
    let count = |spacing_nm, nodes: u32| {
        let mut bytes = body(&LearnedHeader { spacing_nm, ..header() }, &NODES);
        bytes[36..40].copy_from_slice(&nodes.to_le_bytes());
        Learned::<f64>::parse(&sealed(bytes)).unwrap_err()
    };
    assert_eq!(count(0, 4), LearnedError::Spacing(0));
    assert_eq!(count(u32::MAX, 4), LearnedError::Spacing(u32::MAX));
    assert_eq!(count(3_000_000, 4), LearnedError::Nodes { found: 4, needed: 5 });
    assert_eq!(count(4_000_000, u32::MAX), LearnedError::TooShort);
    assert_eq!(refused(LearnedHeader { resolution_pm: 0, ..header() }, &NODES), LearnedError::Resolution(0));
    assert_eq!(refused(LearnedHeader { parts: 0, ..header() }, &NODES), LearnedError::Parts);
    let none = LearnedHeader { length_nm: 0, ..header() };
    assert_eq!(refused(none, &[[0; 3]]), LearnedError::Nodes { found: 1, needed: 1 });
    let mut ends = NODES;
    ends[3] = [0, 0, 1];
    assert_eq!(refused(header(), &ends), LearnedError::Ends);
    ends = NODES;
    ends[0] = [-1, 0, 0];
    assert_eq!(refused(header(), &ends), LearnedError::Ends);
}

#[test]
fn another_program_length_or_machine_is_refused_with_both_figures() {
    let bytes = file(&header(), &NODES);
    let learned = Learned::<f64>::parse(&bytes).unwrap();
    assert_eq!(learned.expect_program(0x22, 10.0009), Ok(()));
    let text = |result: Result<(), LearnedError>| result.unwrap_err().to_string();
    assert_eq!(text(learned.expect_program(0x23, 10.0)), "learned on the program 00000022, needed 00000023");
    assert_eq!(text(learned.expect_program(0x22, 10.0011)), "learned on a path of 10.000000 mm, needed 10.001100 mm");
    assert!(learned.expect_program(0x22, f64::NAN).is_err());
    assert_eq!(learned.expect_machine(0x11), Ok(()));
    assert_eq!(text(learned.expect_machine(0x12)), "learned on the machine 00000011, needed 00000012");
}

#[test]
fn every_refusal_has_a_code_and_words_of_its_own() {
    let all = [
        LearnedError::TooShort,
        LearnedError::TooLong,
        LearnedError::Magic,
        LearnedError::Version,
        LearnedError::Checksum,
        LearnedError::Spacing(0),
        LearnedError::Resolution(0),
        LearnedError::Parts,
        LearnedError::Nodes { found: 1, needed: 2 },
        LearnedError::Ends,
        LearnedError::WrongProgram { found: 1, needed: 2 },
        LearnedError::WrongLength { found_nm: 1, needed_nm: 2 },
        LearnedError::WrongMachine { found: 1, needed: 2 },
    ];
    for (k, error) in all.iter().enumerate() {
        assert_eq!(usize::from(error.code()), k + 1);
        assert!(all.iter().take(k).all(|other| other.to_string() != error.to_string()), "{error}");
    }
}

/// These bytes, summed by zlib in Python:
/// `zlib.crc32(struct.pack("<19q", 2000, 0,0,0,0,0,0, 1000,0,0,0,0,0, 2000,-1,0,0,0,90500))`.
#[test]
fn the_id_of_a_program_is_the_stated_sum() {
    let mut id = ProgramId::new(2.0);
    for (x, y, c) in [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, -0.001, 90.5)] {
        id.point([x, y, 0.0, 0.0, 0.0, c]);
    }
    assert_eq!(id.finish(), 0x44a5_05a4);
}
