//! Bits that flip after loading. The CRC of the file is checked when it is loaded; the tables in memory are not checked
//! afterwards. The file may be discarded. A damaged table in memory gives a wrong correction, but never one beyond its
//! limits.
// The scalar of the other build is single.
#![allow(clippy::useless_conversion)]
// Miri rejects a write by somebody else to the memory of a loop.

use crate::machines::*;
use trueaxis_capi::*;
use trueaxis_testing::noise::Noise;

/// Longer than the limits need to apply a correction in full.
const CYCLES: u32 = 2000;

/// Runs cycles along all axes and returns the drive positions; compares each correction with its limits.
fn run(built: &BuiltLoop) -> Vec<[Position; 3]> {
    let settings = read("mill-3axis").settings;
    let mut state = started(&built.servo);
    let (mut sent, mut correction) = (Vec::new(), [0.0_f64; 3]);
    let mut out = output();
    for n in 0..CYCLES {
        // Passes several points of every table.
        let way = 0.005 * f64::from(n);
        let command = [-200.0 + way, 100.0 - way, -150.0 + way, 0.0, 0.0, 0.0];
        assert_eq!(step(&built.servo, &mut state, &input(command, command), &mut out), OK);
        assert_eq!(out.record.fault, FAULT_NONE);
        for (axis, limits) in settings.axes[..3].iter().map(|axis| axis.limits).enumerate() {
            let c = f64::from(out.record.correction[axis]);
            // The sum of both corrections, the geometric and the dynamic one, in single precision.
            let most = 2.0 * limits.magnitude * (1.0 + 1e-6);
            assert!(c.is_finite() && c.abs() <= most, "axis {axis}, cycle {n}: {c}");
            let slope = 2.0 * limits.slope_per_s * f64::from(PERIOD_NS) * 1e-9;
            assert!((c - correction[axis]).abs() <= slope * 1.01 + 1e-6, "axis {axis}, cycle {n}: {c}");
            correction[axis] = c;
            #[cfg(not(feature = "single"))]
            assert!(out.drive[axis].is_finite() && out.feedback[axis].is_finite());
        }
        sent.push([out.drive[0], out.drive[1], out.drive[2]]);
    }
    sent
}

#[test]
fn the_file_may_go_once_it_is_loaded() {
    let expected = run(&built(MILL));
    let mut file = MILL.to_vec();
    let built = built(&file);
    file.fill(0xff);
    assert_eq!(run(&built), expected);
}

#[test]
fn damaged_memory_gives_no_correction_beyond_its_limits() {
    let mut noise = Noise::new(20);
    let mut differing = 0;
    let mut built = built(MILL);
    let expected = run(&built);
    let whole = built.memory.clone();
    // First the same bit in every word, then random bits in random words.
    for bit in 0..64 {
        built.memory.iter_mut().for_each(|word| *word ^= 1 << bit);
        differing += u32::from(run(&built) != expected);
        built.memory.copy_from_slice(&whole);
    }
    for _ in 0..64 {
        for _ in 0..whole.len() / 4 {
            let (place, bit) = (noise.below(whole.len()), noise.below(64));
            built.memory[place] ^= 1 << bit;
        }
        differing += u32::from(run(&built) != expected);
        built.memory.copy_from_slice(&whole);
    }
    // NaN, infinity, all bits set; as doubles and as singles.
    for word in [f64::NAN.to_bits(), f64::INFINITY.to_bits(), u64::MAX, 0x7fc0_0000_7fc0_0000, 0xff80_0000_7f80_0000] {
        built.memory.fill(word);
        differing += u32::from(run(&built) != expected);
    }
    assert!(differing > 60, "{differing}: the damage was met");
}
