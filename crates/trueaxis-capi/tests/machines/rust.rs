//! The Rust side of a comparison.

use super::PERIOD_NS;
use trueaxis::tcomp::Tcomp;
use trueaxis::telemetry::{FRAME_BYTES as CORE_FRAME_BYTES, Frame};
use trueaxis::{DynamicParts, Dynamics, Position as _, ServoLoop};
use trueaxis_capi::*;

#[cfg(not(feature = "single"))]
pub(crate) type P = f64;
#[cfg(feature = "single")]
pub(crate) type P = trueaxis::Nanometres;
pub(crate) type R = Real;

pub(crate) fn core_position(x: f64) -> P {
    P::of(x)
}

fn bits(x: P) -> u64 {
    x.to_f64().to_bits()
}

#[cfg(not(feature = "single"))]
pub(crate) fn from_c(x: Position) -> P {
    x
}
#[cfg(feature = "single")]
pub(crate) fn from_c(x: Position) -> P {
    trueaxis::Nanometres(x)
}

/// A loop whose file and memory live as long as the test.
pub(crate) fn rust_loop<const N: usize>(file: &[u8]) -> ServoLoop<'static, R, P, N> {
    let tables = Tcomp::parse(file.to_vec().leak()).unwrap();
    ServoLoop::load(&tables, PERIOD_NS, vec![0.0; tables.requirement()].leak()).unwrap()
}

/// Input of the C structure as the Rust type.
pub(crate) fn core_input<const N: usize>(c: &Input) -> trueaxis::Input<P, N> {
    let mut input = trueaxis::Input::<P, N>::at_rest(PERIOD_NS);
    for axis in 0..N {
        input.command[axis] = from_c(c.command[axis]);
        input.feedback[axis] = from_c(c.feedback[axis]);
    }
    (input.homed, input.enable, input.reset) = (c.homed != 0, c.enable != 0, c.reset != 0);
    input.encoder_alarm = c.encoder_alarm;
    input.dynamics = Dynamics((127 & !c.dynamics_off) | (128 & c.dynamics_off));
    input.learned = c.learned.map(from_c);
    input
}

/// Asserts that the parts of the dynamic correction are equal; zero if the machine has none.
fn same_dynamic<const N: usize>(c: &Record, core: Option<&DynamicParts<R, N>>, cycle: usize) {
    assert_eq!(c.has_dynamic, u8::from(core.is_some()));
    let c = [&c.dynamic.sent, &c.dynamic.feed_forward, &c.dynamic.feedback, &c.dynamic.crosstalk, &c.dynamic.learned];
    let core = core.map(|core| [core.sent, core.feed_forward, core.feedback, core.crosstalk, core.learned]);
    for (part, (c, core)) in c.into_iter().zip(core.unwrap_or([[0.0; N]; 5])).enumerate() {
        assert_eq!(
            c[..N].iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
            core.map(R::to_bits),
            "cycle {cycle}, {part}"
        );
        assert_eq!(c[N..], [0.0; AXES_MAX][N..], "cycle {cycle}, {part}");
    }
}

/// Asserts that both outputs, and their frames, are equal in every bit.
pub(crate) fn same<const N: usize>(c: &Output, rust: &trueaxis::Output<R, P, N>, cycle: usize) {
    assert_eq!(c.axes as usize, N);
    for axis in 0..N {
        assert_eq!(bits(from_c(c.drive[axis])), bits(rust.drive[axis]), "cycle {cycle}, drive {axis}");
        assert_eq!(bits(from_c(c.feedback[axis])), bits(rust.feedback[axis]), "cycle {cycle}, feedback {axis}");
        let [a, b] = [c.record.correction[axis], rust.record.correction[axis]];
        assert_eq!(a.to_bits(), b.to_bits(), "cycle {cycle}, correction {axis}");
    }
    let (record, core) = (&c.record, &rust.record);
    assert_eq!(record.sequence, core.sequence);
    assert_eq!((record.machine_id, record.tables_crc), (core.machine_id, core.tables_crc));
    assert_eq!((record.fault, record.fault_axis), (core.fault as u8, core.fault_axis), "cycle {cycle}");
    assert_eq!((record.status, record.limited, record.at_edge), (core.status.0, core.limited, core.at_edge));
    same_dynamic(record, core.dynamic.as_ref(), cycle);
    assert_eq!(record.orientation.to_bits(), core.orientation.to_bits(), "cycle {cycle}");
    assert_eq!(record.orientation_flags, core.orientation_flags.bits(), "cycle {cycle}");
    for (c, core) in [(&record.tip, &core.tip), (&record.encoder, &core.encoder)] {
        assert_eq!((c.span, c.evaluations, c.flags), (core.span, core.evaluations, core.flags.bits()));
        let numbers = [c.t, c.error, c.normal, c.binormal, c.tangential, c.lag, c.width];
        let expected = [core.t, core.error, core.normal, core.binormal, core.tangential, core.lag, core.width];
        assert_eq!(numbers.map(R::to_bits), expected.map(R::to_bits), "cycle {cycle}");
        assert_eq!(c.vector.map(R::to_bits), <[R; 3]>::from(core.vector).map(R::to_bits), "cycle {cycle}");
    }
    let (mut bytes, mut expected, mut written) = ([0; FRAME_BYTES], [0; CORE_FRAME_BYTES], 0);
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_frame_encode(c, bytes.as_mut_ptr(), bytes.len(), &mut written) }, OK);
    assert_eq!(&bytes[..written], &*Frame::of(core).encode(&mut expected).unwrap(), "cycle {cycle}");
}
