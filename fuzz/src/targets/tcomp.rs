//! Compiled table files: every accepted one is run, and keeps its limits.

use crate::execution::SLOWEST;
use crate::outcome::{accepted, refused, saw};
use crate::{Target, machines};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use trueaxis::machine::{AxisOrder, Limits};
use trueaxis::tcomp::{
    HEADER_BYTES, MAGIC, Tcomp, VERSION, VERSION_WITHOUT_ADDITIONS, VERSION_WITHOUT_ENCODERS, VERSION_WITHOUT_GRIDS,
    checksum, machine_id,
};
use trueaxis::telemetry::{Frame, Status};
use trueaxis::{Input, Nanometres, Position, Real, ServoLoop};
use trueaxis_tables::{Machine, compile};

/// Form, sum, settings, tables, grids; then a servo loop built from them and some hundred cycles.
pub const TARGET: Target = Target {
    name: "tcomp",
    about: "compiled table files (.tcomp), loaded and run",
    run,
    seeds,
    repair: |bytes| repair(bytes),
    dictionary: include_str!("../../dictionaries/tcomp.dict"),
    slowest: SLOWEST,
};

const CYCLES: usize = 200;

fn seeds() -> Vec<Vec<u8>> {
    machines::ALL.iter().map(|files| compile(&machines::read(files)).expect("a machine that compiles")).collect()
}

/// Corrects length, version and sum of a file that begins like one; also the id, if the machine's name and chain can be found.
fn repair(bytes: &mut [u8]) {
    if bytes.len() < HEADER_BYTES + 4 || bytes[..8] != MAGIC {
        return;
    }
    let end = bytes.len() - 4;
    let length = (end - HEADER_BYTES) as u32;
    if ![VERSION, VERSION_WITHOUT_ADDITIONS, VERSION_WITHOUT_ENCODERS]
        .map(u16::to_le_bytes)
        .contains(&[bytes[8], bytes[9]])
    {
        bytes[8..10].copy_from_slice(&VERSION_WITHOUT_GRIDS.to_le_bytes());
    }
    bytes[14..18].copy_from_slice(&length.to_le_bytes());
    if let Some((name, chain)) = name_and_chain(&bytes[HEADER_BYTES..end]) {
        let id = machine_id(name, chain);
        bytes[10..14].copy_from_slice(&id.to_le_bytes());
    }
    let sum = checksum(&bytes[..end]);
    bytes[end..].copy_from_slice(&sum.to_le_bytes());
}

/// The first two entries of the settings, each a one-byte length and its text.
fn name_and_chain(payload: &[u8]) -> Option<(&str, &str)> {
    let (name, rest) = text(payload)?;
    Some((name, text(rest)?.0))
}

fn text(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let (length, rest) = bytes.split_first()?;
    let (text, rest) = rest.split_at_checked(usize::from(*length)).filter(|_| *length < 128)?;
    Some((std::str::from_utf8(text).ok()?, rest))
}

fn run(input: &[u8]) {
    let file = match Tcomp::parse(input) {
        Ok(file) => file,
        Err(error) => return refused(error),
    };
    accepted();
    same_again(&file);
    let random = ChaCha8Rng::seed_from_u64(u64::from(file.crc()));
    match file.settings().step_axes().count() {
        3 => in_both::<3>(&file, random),
        4 => in_both::<4>(&file, random),
        5 => in_both::<5>(&file, random),
        _ => in_both::<6>(&file, random),
    }
}

/// Written and read again, the file has the same content.
fn same_again(file: &Tcomp<'_>) {
    let machine = Machine::from_tcomp(file);
    let bytes = compile(&machine).unwrap_or_else(|error| panic!("accepted, but not to be written: {error}"));
    let again = Tcomp::parse(&bytes).unwrap_or_else(|error| panic!("written, but not to be read: {error}"));
    assert_eq!(Machine::from_tcomp(&again), machine);
    assert_eq!((again.machine_id(), again.inverse_passes()), (file.machine_id(), file.inverse_passes()));
    assert_eq!(again.requirement(), file.requirement());
    for (one, other) in file.axes().zip(again.axes()) {
        let ([one, other], axis) = ([one.1, other.1], one.0.axis.letter());
        let bits = |row: trueaxis::Row| {
            let numbers = std::iter::once(row.position).chain(row.forward).chain(row.reverse);
            numbers.map(f64::to_bits).collect::<Vec<_>>()
        };
        let [one, other] = [one, other].map(|table| table.iter().flat_map(|t| t.rows()).map(bits).collect::<Vec<_>>());
        assert!(one == other, "the table of {axis} is another");
    }
}

/// Runs in single or double precision, as drawn.
fn in_both<const N: usize>(file: &Tcomp<'_>, mut random: ChaCha8Rng) {
    let period_ns = [1_000_000, 100_000, 31_250][random.next_u32() as usize % 3];
    if random.next_u32().is_multiple_of(2) {
        in_one::<f64, f64, N>(file, period_ns, random);
    } else {
        in_one::<f32, Nanometres, N>(file, period_ns, random);
    }
}

fn in_one<R: Real, P: Position, const N: usize>(file: &Tcomp<'_>, period_ns: u32, random: ChaCha8Rng) {
    let mut memory = vec![R::ZERO; file.requirement()];
    match ServoLoop::<R, P, N>::load(file, period_ns, &mut memory) {
        Err(error) => refused(error),
        Ok(servo) => cycles(&servo, file, f64::from(period_ns) * 1e-9, random),
    }
}

/// Correction, its change and the change of that, for one axis.
#[derive(Clone, Copy, Default)]
struct Sent {
    correction: f64,
    change: f64,
}

fn cycles<R: Real, P: Position, const N: usize>(
    servo: &ServoLoop<'_, R, P, N>,
    file: &Tcomp<'_>,
    period_s: f64,
    mut random: ChaCha8Rng,
) {
    let order = AxisOrder::<N>::of(file.settings()).expect("the axes that it was built for");
    let axes = order.settings(file.settings());
    let mut state = servo.start();
    let mut sent = [Sent::default(); N];
    let mut at: [f64; N] = axes.map(|axis| axis.map_or(0.0, |axis| 0.5 * (axis.travel[0] + axis.travel[1])));
    let mut drive = at.map(P::of);
    for _ in 0..CYCLES {
        let input = cycle(&mut random, &mut at, &axes, &drive, period_s);
        let out = servo.step(&mut state, &input, (), ());
        let status = out.record.status;
        let held = status.has(Status::STOP_REQUEST) || status.has(Status::NO_OUTPUT);
        for slot in 0..N {
            let dynamic = out.record.dynamic.map_or(0.0, |parts| parts.sent[slot].to_f64());
            let total = out.record.correction[slot].to_f64() + dynamic;
            assert!(out.drive[slot].to_f64().is_finite() && out.feedback[slot].to_f64().is_finite());
            // A letter without an axis has neither a drive nor limits.
            let Some(axis) = axes[slot] else { continue };
            keeps::<R>(&mut sent[slot], total, &axis.limits, period_s, held);
            if status.has(Status::ACTIVE) {
                let [low, high] = axis.joint.map(P::nearest);
                assert!(out.drive[slot].is_within(&[low, high]), "{} outside its joint", axis.axis.letter());
            }
        }
        if out.has_drive() {
            drive = out.drive;
        }
        let _ = Frame::of(&out.record);
    }
    saw((file.settings().axes.len(), file.settings().roundness.is_some()));
}

/// |c|, |Δc| and |Δ²c| stay within their limits, apart from rounding; while the output holds, nothing changes at all.
fn keeps<R: Real>(sent: &mut Sent, correction: f64, limits: &Limits, period_s: f64, held: bool) {
    let change = correction - sent.correction;
    let (most, fastest) = (limits.magnitude, limits.slope_per_s * period_s);
    let acceleration = limits.acceleration_per_s2 * period_s * period_s;
    let rounding = 16.0 * R::EPSILON.to_f64() * (most + fastest + acceleration);
    assert!(correction.abs() <= most + rounding, "a correction of {correction} above {most}");
    if held {
        assert!(change.abs() <= rounding, "a correction that changes by {change} while the output holds");
        *sent = Sent { correction, change: 0.0 };
        return;
    }
    assert!(change.abs() <= fastest + rounding, "a change of {change} above {fastest}");
    let bend = change - sent.change;
    assert!(bend.abs() <= acceleration + 2.0 * rounding, "an acceleration of {bend} above {acceleration}");
    *sent = Sent { correction, change };
}

/// A cycle as machines produce it, and occasionally an invalid one.
fn cycle<P: Position, const N: usize>(
    random: &mut ChaCha8Rng,
    at: &mut [f64; N],
    axes: &[Option<&trueaxis::machine::AxisSettings>; N],
    drive: &[P; N],
    period_s: f64,
) -> Input<P, N> {
    let mut unit = || f64::from(random.next_u32()) / f64::from(u32::MAX);
    for (at, axis) in at.iter_mut().zip(axes) {
        let Some(axis) = axis else { continue };
        *at += (2.0 * unit() - 1.0) * axis.max_feed_per_s * period_s;
        if unit() < 0.002 {
            *at = axis.travel[0] + unit() * (axis.travel[1] - axis.travel[0]);
        }
        *at = at.clamp(axis.travel[0], axis.travel[1]);
    }
    let mut command = at.map(P::of);
    let mut feedback = std::array::from_fn(|slot| P::of(drive[slot].to_f64() + 1e-3 * (unit() - 0.5)));
    if unit() < 0.02 {
        let strange = [f64::NAN, f64::INFINITY, -1e300, 1e6, 0.0, -0.0][(unit() * 5.99) as usize];
        let slot = (unit() * (N as f64 - 0.01)) as usize;
        if unit() < 0.3 { command[slot] = P::of(strange) } else { feedback[slot] = P::of(strange) }
    }
    let period_ns = (period_s * 1e9) as u32;
    Input {
        command,
        feedback,
        homed: unit() > 0.01,
        enable: unit() > 0.02,
        reset: unit() < 0.1,
        encoder_alarm: if unit() < 0.01 { 1 << (unit() * 5.99) as u8 } else { 0 },
        elapsed_ns: if unit() < 0.01 { period_ns * 2 } else { period_ns },
        learned: std::array::from_fn(|_| P::of(0.01 * (unit() - 0.5))),
        ..Input::at_rest(period_ns)
    }
}
