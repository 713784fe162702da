//! Thermal growth with readings of its sensors, as stored in a controller's flash, and the task with every row.

use super::ttherm;
use crate::execution::SLOWEST;
use crate::{Target, outcome, sum};
use trueaxis::Axis;
use trueaxis_recording::warming::{MAGIC, Task, Warming, WarmingRefusal, write};

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "warming",
    about: "thermal growth with readings, in a controller's flash",
    run,
    seeds,
    repair,
    dictionary: include_str!("../../dictionaries/ttherm.dict"),
    slowest: SLOWEST,
};

/// Offset of the growth, and of its machine's id.
const GROWTH: usize = 18;
const ID: usize = GROWTH + 10;

/// The id of the growth's machine.
fn id(bytes: &[u8]) -> u32 {
    bytes.get(ID..).and_then(|rest| rest.first_chunk()).map_or(0, |id| u32::from_le_bytes(*id))
}

fn run(bytes: &[u8]) {
    let warming = match Warming::parse(bytes, id(bytes)) {
        Ok(warming) => warming,
        Err(refused) => return outcome::refused(refused),
    };
    assert!(matches!(Warming::parse(bytes, !id(bytes)), Err(WarmingRefusal::Growth(_))));
    outcome::accepted();
    let thermal = warming.thermal();
    outcome::saw((thermal.sensors(), warming.rows().min(3)));
    let mut task = Task::default();
    // Skips some rows.
    for row in (0..warming.rows().min(64)).filter(|row| row % 5 != 3) {
        assert!(warming.in_force_from(row) > 0);
        let growth = warming.update(&mut task, row, 1_000_000).expect("a row that is there");
        for axis in Axis::ALL {
            let named = thermal.axes().any(|(own, _)| own == axis);
            assert_eq!(growth.line::<f32>(axis).is_some(), named, "{axis:?}: {:?}", growth.lines);
        }
    }
    assert!(warming.update(&mut task, warming.rows(), 1_000_000).is_none());
    damaged(bytes);
}

/// A wrong bit under the sum, or a missing end, is refused.
fn damaged(good: &[u8]) {
    let [.., first, second] = good else { return };
    let bit = (usize::from(*first) << 8 | usize::from(*second)) % (8 * GROWTH);
    let mut bytes = good.to_vec();
    bytes[bit / 8] ^= 1 << (bit % 8);
    assert!(Warming::parse(&bytes, id(good)).is_err(), "bit {bit} wrong");
    assert!(Warming::parse(&good[..bit % GROWTH], id(good)).is_err());
}

fn seeds() -> Vec<Vec<u8>> {
    let of = |(growth, sensors): (Vec<u8>, usize)| {
        let rows: Vec<_> =
            (0..6).map(|row| (vec![(row != 4).then_some(20.0 + f64::from(row)); sensors], Some(900.0))).collect();
        write(&growth, 1000, &rows)
    };
    ttherm::seeds().into_iter().zip([2, 1, 0]).map(of).collect()
}

/// Corrects both sums, that of the growth first.
#[expect(clippy::ptr_arg, reason = "the signature of every repair")]
fn repair(bytes: &mut Vec<u8>) {
    if !bytes.starts_with(&MAGIC) || bytes.len() < GROWTH {
        return;
    }
    let length = u32::from_le_bytes([bytes[14], bytes[15], bytes[16], bytes[17]]) as usize;
    if let Some(growth) = bytes.get_mut(GROWTH..).and_then(|rest| rest.get_mut(..length)) {
        sum::seal(growth);
    }
    sum::seal(bytes);
}
