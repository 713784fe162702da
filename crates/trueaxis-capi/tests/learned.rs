//! A learned correction through the C interface: checked, evaluated, refused.

use crate::machines::rust::from_c;
use crate::machines::*;
use std::ptr::null_mut;
use trueaxis::Position as _;
use trueaxis::learned::{LearnedHeader, VERSION};
use trueaxis_capi::*;

const HEADER: LearnedHeader = LearnedHeader {
    parts: 3,
    machine_id: 7,
    program_id: 0xf613_9514,
    length_nm: 2_000_000,
    spacing_nm: 500_000,
    resolution_pm: 1_000,
};
/// Values at 0, 0.5, 1, 1.5 and 2 mm, in nm.
const NODES: [[i16; 3]; 5] = [[0, 0, 0], [100, -200, 3], [3000, 10, -1], [-50, 0, 7], [0, 0, 0]];

/// CRC-32/ISO-HDLC, bit by bit.
fn checksum(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    })
}

fn file(header: LearnedHeader) -> Vec<u8> {
    let mut bytes = header.to_bytes().to_vec();
    bytes.extend(NODES.as_flattened().iter().flat_map(|count| count.to_le_bytes()));
    bytes.extend(checksum(&bytes).to_le_bytes());
    bytes
}

/// Builds the correction for a machine and a program, or returns result, code and text of the refusal.
fn build(file: &[u8], (machine, program, length): (u32, u32, f64)) -> Result<Box<Learned>, (ResultCode, u32, String)> {
    let (mut learned, mut error) = (zeroed::<Learned>(), error());
    let size = size_of::<Learned>();
    // SAFETY: all pointers and sizes match their types; the files of these tests outlive the objects that read them.
    let result = unsafe {
        trueaxis_learned_build(&mut *learned, size, file.as_ptr(), file.len(), machine, program, length, &mut error)
    };
    let mut nothing = [position(9.0); 3];
    if result == OK {
        return Ok(learned);
    }
    assert_eq!(error.result, result);
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_learned_at(&*learned, 1.0, nothing.as_mut_ptr()) }, ERROR_UNBUILT);
    assert_eq!(nothing, [position(9.0); 3]);
    Err((result, error.code, text(&error.text)))
}

/// The correction in nm.
fn at(learned: &Learned, length_mm: f64) -> [f64; 3] {
    let mut found = [position(9.0); 3];
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_learned_at(learned, length_mm, found.as_mut_ptr()) }, OK);
    found.map(|x| from_c(x).to_f64() * 1e6)
}

const HERE: (u32, u32, f64) = (7, 0xf613_9514, 2.0);

#[test]
fn it_is_linear_between_nodes_and_zero_beyond() {
    let file = file(HEADER);
    let learned = build(&file, HERE).unwrap();
    build(&file, (0, HERE.1, 2.0009)).expect("any machine, and a length within 1 µm");
    let expected = [
        (-1.0, [0.0; 3]),
        (0.0, [0.0; 3]),
        (0.25, [50.0, -100.0, 1.5]),
        (0.5, [100.0, -200.0, 3.0]),
        (0.9, [2420.0, -32.0, -0.2]),
        (1.5, [-50.0, 0.0, 7.0]),
        (2.0, [0.0; 3]),
        (f64::NAN, [0.0; 3]),
        (1e300, [0.0; 3]),
    ];
    // Single precision rounds to whole nanometres.
    let most = if cfg!(feature = "single") { 0.501 } else { 1e-6 };
    for (length, nm) in expected {
        let found = at(&learned, length);
        assert!(found.iter().zip(nm).all(|(found, nm)| (found - nm).abs() <= most), "at {length}: {found:?}");
    }
}

#[test]
fn another_program_machine_or_file_is_refused_with_the_figures() {
    let good = file(HEADER);
    let mut damaged = good.clone();
    damaged[45] ^= 1;
    let mut newer = good.clone();
    newer[8] = VERSION as u8 + 1;
    let refused: &[(&[u8], _, ResultCode, u32, &str)] = &[
        (&good, (8, HERE.1, 2.0), ERROR_MACHINE, 13, "learned on the machine 00000007, needed 00000008"),
        (&good, (7, 1, 2.0), ERROR_LEARNED, 11, "learned on the program f6139514, needed 00000001"),
        (&good, (7, HERE.1, 2.002), ERROR_LEARNED, 12, "learned on a path of 2.000000 mm, needed 2.002000 mm"),
        (&damaged, HERE, ERROR_LEARNED, 5, "CRC-32"),
        (&newer, HERE, ERROR_LEARNED, 4, "version"),
        (&good[..good.len() - 1], HERE, ERROR_LEARNED, 1, "shorter"),
        (&file(LearnedHeader { parts: 0, ..HEADER }), HERE, ERROR_LEARNED, 8, "no part"),
    ];
    for (file, here, result, code, says) in refused {
        let (found, found_code, line) = build(file, *here).map(|_| ()).unwrap_err();
        assert_eq!((found, found_code), (*result, *code), "{line}");
        assert!(line.starts_with("learned correction: ") && line.contains(says), "{line}");
    }
    assert_eq!(build(&good, (7, HERE.1, f64::NAN)).map(|_| ()).unwrap_err().0, ERROR_ARGUMENT);
    // SAFETY: null is refused.
    unsafe {
        let mut place = zeroed::<Learned>();
        let size = size_of::<Learned>();
        let build = |to, size, file| trueaxis_learned_build(to, size, file, 1, 0, 0, 0.0, null_mut());
        assert_eq!(build(null_mut(), size, good.as_ptr()), ERROR_NULL);
        assert_eq!(build(&mut *place, size - 8, good.as_ptr()), ERROR_SIZE);
        assert_eq!(build(&mut *place, size, std::ptr::null()), ERROR_NULL);
        assert_eq!(trueaxis_learned_at(&*place, 0.0, null_mut()), ERROR_NULL);
    }
}

#[test]
fn a_program_has_the_id_of_its_points() {
    let (mut program, mut id) = (zeroed::<Program>(), 0);
    let place: *mut Program = &mut *program;
    // SAFETY: all pointers and sizes match their types, or null.
    unsafe {
        assert_eq!(trueaxis_program_id(place, &mut id), ERROR_UNBUILT);
        assert_eq!(trueaxis_program_start(place, size_of::<Program>(), f64::INFINITY), ERROR_ARGUMENT);
        assert_eq!(trueaxis_program_start(place, size_of::<Program>() + 8, 2.0), ERROR_SIZE);
        assert_eq!(trueaxis_program_start(place, size_of::<Program>(), 2.0), OK);
        assert_eq!(trueaxis_program_point(place, [0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0].as_ptr()), ERROR_ARGUMENT);
        // Program of a 2 mm line along X: X as µm in 64 bits, all other axes 0.
        let mut bytes = 2000_u64.to_le_bytes().to_vec();
        for x in [0.0, 1.0, 2.0] {
            assert_eq!(trueaxis_program_point(place, [x, 0.0, 0.0, 0.0, 0.0, 0.0].as_ptr()), OK);
            bytes.extend(((1000.0 * x) as u64).to_le_bytes());
            bytes.extend([0; 40]);
        }
        assert_eq!(trueaxis_program_id(place, null_mut()), ERROR_NULL);
        assert_eq!(trueaxis_program_id(place, &mut id), OK);
        assert_eq!((id, id), (checksum(&bytes), HEADER.program_id));
    }
}
