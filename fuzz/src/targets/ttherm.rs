//! Files with thermal growth, as the controller reads them, and the task with arbitrary readings.

use crate::execution::SLOWEST;
use crate::{Target, outcome, sum};
use trueaxis::Axis;
use trueaxis::temperature::{MAGIC, Readings, Thermal, ThermalState, VERSION};

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "ttherm",
    about: "thermal growth (.ttherm), and its task with any readings",
    run,
    seeds,
    repair,
    dictionary: include_str!("../../dictionaries/ttherm.dict"),
    slowest: SLOWEST,
};

fn run(bytes: &[u8]) {
    let thermal = match Thermal::parse(bytes) {
        Ok(thermal) => thermal,
        Err(error) => {
            assert!((1..=14).contains(&error.code()));
            outcome::saw(error.code());
            return assert!(!error.to_string().contains(char::is_control));
        }
    };
    assert_eq!(thermal.expect_machine(thermal.machine_id()), Ok(()));
    assert!(thermal.expect_machine(!thermal.machine_id()).is_err());
    let axes: Vec<(Axis, f64)> = thermal.axes().collect();
    assert!((1..=6).contains(&axes.len()) && axes.windows(2).all(|pair| pair[0].0 < pair[1].0));
    outcome::accepted();
    outcome::saw((thermal.sensors(), axes.len(), thermal.has_spindle()));
    task(&thermal, bytes, &axes);
    damaged(bytes);
}

/// Takes readings from the file's bytes: whatever they are, the step accepts every line.
fn task(thermal: &Thermal<'_>, bytes: &[u8], axes: &[(Axis, f64)]) {
    let mut state = ThermalState::new();
    // Some sensors must start up, others are accepted from their first reading on.
    let known_good = bytes.iter().rev().enumerate().filter(|(_, byte)| *byte & 1 == 0).map(|(sensor, _)| sensor);
    known_good.for_each(|sensor| state.accept(sensor));
    let mut words = bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).cycle();
    let mut any = || match words.next().unwrap_or(0) {
        word if word % 17 == 0 => f64::from_bits(u64::from(word) << 32 | u64::from(word)),
        word => f64::from(word % 80_000) * 1e-3,
    };
    for _ in 0..12 {
        let temperatures: Vec<Option<f64>> = (0..thermal.sensors()).map(|_| Some(any())).collect();
        let readings = Readings { temperatures_c: &temperatures, spindle_rpm: Some(300.0 * any()), tool_mm: any() };
        let growth = thermal.update(&mut state, any(), &readings);
        for axis in Axis::ALL {
            let named = axes.iter().any(|(own, _)| *own == axis);
            let line = growth.line::<f64>(axis);
            assert_eq!(line.is_some(), named, "{axis:?}: {:?}", growth.lines);
        }
        if growth.is_good() {
            outcome::saw("good");
        }
        growth.sensors.iter().for_each(|status| outcome::saw(*status as u8));
    }
    // Without readings nothing changes.
    let before = thermal.update(&mut state, 1.0, &Readings { temperatures_c: &[], spindle_rpm: None, tool_mm: 0.0 });
    let after = thermal.update(&mut state, 900.0, &Readings { temperatures_c: &[], spindle_rpm: None, tool_mm: 0.0 });
    assert_eq!(before.lines, after.lines);
}

/// A file with a wrong bit, a missing byte or an additional one is refused.
fn damaged(good: &[u8]) {
    let choice = usize::from(good[good.len() - 1]) << 8 | usize::from(good[good.len() - 2]);
    let mut bytes = good.to_vec();
    let bit = choice % (8 * good.len());
    bytes[bit / 8] ^= 1 << (bit % 8);
    assert!(Thermal::parse(&bytes).is_err(), "bit {bit} wrong");
    assert!(Thermal::parse(&good[..choice % good.len()]).is_err());
    let longer = [good, &good[..1]].concat();
    assert!(Thermal::parse(&longer).is_err());
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    vec![file(2, &[0, 2], &[0, 6000, 12_000]), file(1, &[1], &[]), file(0, &[0, 1, 2], &[0, 1000])]
}

fn file(sensors: u8, axes: &[u8], speeds: &[u32]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(7_u32.to_le_bytes());
    bytes.extend([sensors, axes.len() as u8, speeds.len() as u8, 0]);
    bytes.extend(900_000_u32.to_le_bytes());
    bytes.extend(speeds.iter().flat_map(|speed| speed.to_le_bytes()));
    for sensor in 0..sensors {
        let numbers = [600_000 * i32::from(sensor), -20_000, 90_000, 2_000, 1_000, 60_000, 3_000];
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        bytes.push(2);
        bytes.extend([10_000_i32, 40_000].iter().flat_map(|knot| knot.to_le_bytes()));
    }
    for axis in axes {
        bytes.push(*axis);
        bytes.extend((50_000_000 * i64::from(*axis)).to_le_bytes());
        for sensor in 0..i32::from(sensors) {
            let curve = [-5_000, -100_000_000, 10_000 * sensor, 200_000_000];
            bytes.extend(curve.iter().flat_map(|number| number.to_le_bytes()));
        }
        for knot in 0..speeds.len() as i32 {
            bytes.extend([3_000 * knot, 10_000 * knot].iter().flat_map(|number| number.to_le_bytes()));
        }
    }
    bytes.extend([0; 4]);
    sum::seal(&mut bytes);
    bytes
}

/// Corrects the sum.
#[expect(clippy::ptr_arg, reason = "the signature of every repair")]
fn repair(bytes: &mut Vec<u8>) {
    if bytes.starts_with(&MAGIC) {
        sum::seal(bytes);
    }
}
