//! A grid through the C interface: the same corrections as in Rust, and the file may be discarded after building the
//! loop.

#![allow(clippy::useless_conversion, reason = "numbers are f64 or f32")]

use crate::machines::*;
use std::ptr::null;
use trueaxis_capi::*;
use trueaxis_tables::{Grid, GridSource, compile};

/// A surface that rises by 40 µm along X and sags by 20 µm in its middle, with a rotation that nine terms do not
/// describe.
fn gridded(height_mm: f64) -> Vec<u8> {
    let mut machine = small();
    let nodes = [vec![-400.0, -50.0, 400.0], vec![-400.0, 0.0, 400.0], vec![]];
    let mut values = Vec::new();
    for x in &nodes[0] {
        for y in &nodes[1] {
            let sag = if *y == 0.0 { -0.5 * height_mm } else { 0.0 };
            values.push([0.0, 0.0, height_mm * (x + 400.0) / 800.0 + sag, 0.0, 0.0, 1e-6]);
        }
    }
    let given = [false, false, true, false, false, true];
    machine.grids = vec![Grid::new(GridSource { nodes, given, values, ..GridSource::default() }).unwrap()];
    compile(&machine).unwrap()
}

#[cfg(not(feature = "single"))]
fn position(mm: f64) -> Position {
    mm
}
#[cfg(feature = "single")]
fn position(mm: f64) -> Position {
    (mm * 1e6).round() as Position
}

#[test]
fn a_grid_is_corrected_and_the_file_may_go() {
    let bytes = gridded(0.04);
    let rust = rust::rust_loop::<3>(&bytes);
    let mut file = bytes.clone();
    let built = built(&file);
    file.fill(0xa5);
    drop(file);
    for x in [-399.0f64, -200.0, -50.0, 3.0, 380.0] {
        for y in [-399.0f64, -100.0, 0.0, 250.0] {
            let at = [x, y, 7.0];
            let (command, mut found) = (at.map(position), [0.0 as Real; 3]);
            // SAFETY: three positions and three numbers.
            let result =
                unsafe { trueaxis_correction_at(&*built.servo, command.as_ptr(), 0, null(), found.as_mut_ptr()) };
            assert_eq!(result, OK);
            let expected = rust.correction_at(&at.map(rust::core_position), &Default::default()).unwrap();
            assert_eq!(found, expected, "{at:?}");
            let ideal = -(0.04 * (x + 400.0) / 800.0 - 0.02 * (1.0 - y.abs() / 400.0));
            assert!((f64::from(found[2]) - ideal).abs() < 3e-6, "{at:?}: {found:?} {ideal}");
        }
    }
}
