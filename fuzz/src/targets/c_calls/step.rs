//! The step, and the promises of every cycle.

use super::draw::Draw;
use super::machines::PERIOD_NS;
use super::world::{Built, Running, World, answered, bytes_of};
use crate::outcome;
use std::ptr::{null, null_mut};
use trueaxis_capi::*;

/// Runs some cycles: usually plain motion with readings at the drives' commands; the first may be anything.
pub(super) fn run(world: &mut World, draw: &mut Draw<'_>) {
    let (servo, slot, cycles) = (draw.below(3), draw.below(2), 1 + draw.below(12));
    let what = draw.byte();
    let deltas: [f64; AXES_MAX] = [(); AXES_MAX].map(|()| 1e-3 * f64::from(draw.byte() as i8));
    plan(world, slot, draw, what);
    let against = draw.byte();
    let (gauge, reference) = (draw.below(4) == 0, Reference { span: draw.byte().into(), t: draw.number() });
    for cycle in 0..cycles {
        let running = world.states.running[slot];
        let (command, reading) = running.map_or(([0.0; 6], [0.0; 6]), |running| (running.command, running.reading));
        if cycle > 0 || what < 128 {
            world.input.command = std::array::from_fn(|axis| command[axis] + deltas[axis]);
            world.input.feedback = reading;
            world.input.elapsed_ns = PERIOD_NS;
            (world.input.refusal, world.input.encoder_alarm) = (0, 0);
        }
        let mut measure = measure(world, against, reference);
        // The first cycle may have a defective pointer, the others have none.
        let odd = if cycle == 0 { draw.byte() } else { 0 };
        one(world, [servo, slot], &mut measure, gauge, odd);
    }
}

/// Draws the switches of these cycles, and in a wild one everything else.
fn plan(world: &mut World, slot: usize, draw: &mut Draw<'_>, what: u8) {
    let input = &mut world.input;
    let switches = if what.is_multiple_of(4) { draw.byte() } else { 0b11 };
    (input.enable, input.homed, input.reset) = (switches & 1, switches >> 1 & 1, switches >> 2 & 1);
    input.dynamics_off = if switches >> 3 & 1 == 1 { draw.byte() } else { 0 };
    if what < 128 {
        return;
    }
    let running = world.states.running[slot];
    input.command = running.map_or([0.0; 6], |running| running.command);
    input.feedback = running.map_or([0.0; 6], |running| running.reading);
    let axis = draw.below(AXES_MAX);
    match what & 7 {
        0 => input.command[axis] = draw.number(),
        1 => input.feedback[axis] = draw.number(),
        2 => input.encoder_alarm = draw.byte(),
        3 => input.elapsed_ns = draw.word(),
        4 => input.learned = draw.numbers(),
        5 => (input.refusal, input.refusal_axis) = (draw.byte(), draw.byte()),
        6 => (input.command, input.feedback) = (draw.numbers(), draw.numbers()),
        _ => input.command[axis] += 0.01 * draw.number(),
    }
}

fn measure(world: &mut World, against: u8, reference: Reference) -> Option<Measure> {
    let kind = match against {
        0..128 => return None,
        128..248 => u32::from(against % 4),
        _ => u32::from(against),
    };
    Some(Measure {
        size: if against == 255 { 0 } else { size_of::<Measure>() as u32 },
        kind,
        path: if against % 16 == 15 { null() } else { &raw const *world.paths.objects[usize::from(against / 4 % 2)] },
        reference,
        window: if against % 32 == 18 { null_mut() } else { &raw mut *world.paths.window },
        kinematics: &raw const *world.kinematics,
        direction_error: [f64::NAN; 3],
    })
}

fn ride(world: &mut World, cycle: u32) -> GaugeRide {
    let gauges = &mut world.gauges;
    gauges.spindle = gauges.spindle.wrapping_add(8);
    let turn = super::machines::COUNTS;
    let angle = std::f64::consts::TAU * f64::from(gauges.spindle.rem_euclid(turn)) / f64::from(turn);
    GaugeRide {
        size: size_of::<GaugeRide>() as u32,
        spindle: gauges.spindle,
        index: gauges.spindle - gauges.spindle.rem_euclid(turn),
        arm: 0,
        gauge: &raw const *gauges.gauge,
        state: &raw mut *gauges.state,
        readings: [0.0, 1.0, 2.0].map(|phase| (3.0 * (angle + phase)).cos()),
        has_index: u8::from(gauges.spindle.rem_euclid(turn) < 8),
        new_part: u8::from(cycle % 97 == 96),
        idle: 0,
        finished: 9,
        flags: u16::MAX,
        reserved: [0; 2],
        infeed: f64::NAN,
    }
}

/// One call of the step.
fn one(world: &mut World, [servo, slot]: [usize; 2], measure: &mut Option<Measure>, gauge: bool, odd: u8) {
    let mut wrong = Draw::new(&[odd, odd / 7]).wrong();
    let (built, running) = (world.loops.built[servo], world.states.running[slot]);
    let mut ride = gauge.then(|| ride(world, running.map_or(0, |running| running.cycles)));
    let before = bytes_of(&*world.states.objects[slot]).to_vec();
    let (input, mut output) = (*world.input, *world.output);
    output.drive = [f64::NAN; AXES_MAX];
    output.size = wrong.size(5, size_of::<Output>()) as u32;
    let untouched = output;
    if let Some(ride) = &mut ride {
        ride.readings[0] += world.input.learned[0];
        // A large copy, made only if the call must be refused.
        if odd >= 200 {
            super::world::copy(&*world.gauges.state, &mut *world.gauges.before);
        }
    }
    // SAFETY: a wrong argument is null, misaligned or has another stated size; everything else matches its type.
    let result = unsafe {
        let measure = wrong.or_null(3, measure.as_mut().map(|measure| &raw mut *measure));
        let gauge = wrong.or_null(4, ride.as_mut().map(|ride| &raw mut *ride));
        trueaxis_step(
            wrong.at(0, (&raw const *world.loops.objects[servo]).cast_mut()),
            wrong.at(1, &raw mut *world.states.objects[slot]),
            wrong.at(2, (&raw const input).cast_mut()),
            measure,
            gauge,
            wrong.at(5, &raw mut output),
        )
    };
    // A measure also contains a size and pointers, which may be wrong.
    let named = measure.as_ref().is_some_and(|m| m.size == 0 || m.path.is_null() || m.window.is_null());
    wrong.met |= named && [ERROR_NULL, ERROR_SIZE].contains(&result);
    let refusals = [ERROR_AXES, ERROR_STATE, ERROR_MACHINE, ERROR_ARGUMENT, ERROR_NO_OUTPUT, ERROR_GAUGE];
    answered("step", result, &wrong, &refusals);
    if result == OK || result == ERROR_NO_OUTPUT {
        let (built, running) = (built.expect("a step of no loop"), running.expect("a step of no state"));
        assert!(built.axes == running.axes && built.bypass == running.bypass);
        finite(&output, result, measure.as_ref(), ride.as_ref());
        world.states.running[slot] = Some(followed(built, running, &input, &output, result));
        *world.output = output;
        return;
    }
    assert!(before == bytes_of(&*world.states.objects[slot]), "a refused step changed the state: {result}");
    assert!(bytes_of(&untouched) == bytes_of(&output), "a refused step wrote its output: {result}");
    assert!(measure.as_ref().is_none_or(|measure| measure.direction_error.iter().all(|x| x.is_nan())));
    if let Some(ride) = &ride {
        assert!(
            ride.finished == 9 && ride.flags == u16::MAX && ride.infeed.is_nan(),
            "a refused step wrote the gauge's"
        );
        let kept = odd < 200 || bytes_of(&*world.gauges.before) == bytes_of(&*world.gauges.state);
        assert!(kept, "a refused step changed the gauge's state");
    }
    let fits =
        built.zip(running).is_some_and(|(built, running)| (built.axes, built.bypass) == (running.axes, running.bypass));
    let plain = measure.is_none() && ride.is_none() && input.refusal == 0 && !wrong.met;
    assert!(!(fits && plain), "a good step was refused with {result}");
}

/// Every number written is finite.
fn finite(output: &Output, result: ResultCode, measure: Option<&Measure>, ride: Option<&GaugeRide>) {
    let record = &output.record;
    let no_output = result == ERROR_NO_OUTPUT;
    assert_eq!(record.status & STATUS_NO_OUTPUT != 0, no_output);
    assert!(output.drive.iter().all(|drive| drive.is_nan() == no_output), "{:?}", output.drive);
    let contours = [&record.tip, &record.encoder].map(|of| {
        [
            of.t,
            of.error,
            of.normal,
            of.binormal,
            of.tangential,
            of.lag,
            of.width,
            of.vector[0],
            of.vector[1],
            of.vector[2],
        ]
    });
    let dynamic = &record.dynamic;
    let lists = [
        &output.feedback,
        &record.command,
        &record.feedback,
        &record.correction,
        &dynamic.sent,
        &dynamic.feed_forward,
        &dynamic.feedback,
        &dynamic.crosstalk,
        &dynamic.learned,
    ];
    assert!(lists.iter().all(|list| list.iter().all(|value| value.is_finite())), "{output:?}");
    assert!(contours.iter().flatten().all(|value| value.is_finite()) && record.orientation.is_finite(), "{record:?}");
    if let Some(measure) = measure.filter(|measure| measure.kind == MEASURE_TOOL) {
        assert!(measure.direction_error.iter().all(|value| value.is_finite()));
    }
    assert!(ride.is_none_or(|ride| ride.infeed.is_finite() && ride.finished <= 1), "{ride:?}");
    outcome::saw((record.fault, record.status, record.limited != 0, record.tip.flags));
}

/// Checks the cycle against the previous ones.
fn followed(built: Built, before: Running, input: &Input, output: &Output, result: ResultCode) -> Running {
    let (record, axes) = (&output.record, built.axes as usize);
    assert_eq!(output.axes, built.axes);
    let crc = (record.machine_id, record.tables_crc);
    assert!(crc == (built.machine_id, built.tables_crc), "{crc:?}");
    let quiet = STATUS_FROZEN | STATUS_STOP_REQUEST | STATUS_NO_OUTPUT;
    // A cycle without elapsed time moves nothing, even when switched off.
    let plain = record.fault == FAULT_NONE && record.status & quiet == 0 && input.elapsed_ns == PERIOD_NS;
    let mut after = Running { cycles: before.cycles + 1, plain: if plain { before.plain + 1 } else { 0 }, ..before };
    // A loop without a dynamic part takes over the correction sent as its geometric one: the sum keeps its limits.
    let taken_over = record.dynamic.sent[..axes].iter().all(|sent| *sent == 0.0);
    for axis in 0..axes {
        after.bounds[axis] = before.bounds[axis].or(built.bounds[axis]);
        let dynamic = record.dynamic.sent[axis];
        let sum = record.correction[axis] + dynamic;
        after.sent[axis] = [sum, sum - before.sent[axis][0]];
        after.dynamic[axis] = [dynamic, dynamic - before.dynamic[axis][0]];
        let (follows, clean) = (before.cycles > 0, after.plain > 3 && before.cycles > 3);
        within(after.sent[axis], before.sent[axis], after.bounds[axis].sum, follows, clean, "sum");
        if !taken_over {
            let limits = after.bounds[axis].dynamic;
            within(after.dynamic[axis], before.dynamic[axis], limits, follows, clean, "dynamic part");
        }
        if result == OK {
            let drive = output.drive[axis];
            let off = (drive - (record.command[axis] + sum)).abs();
            assert!(off <= 1e-9 * (1.0 + drive.abs()), "axis {axis}: {drive} is not the command with its correction");
            after.reading[axis] = drive;
        }
    }
    let usable = |q: &f64| q.is_finite() && q.abs() <= 1e9;
    let next = if plain && input.command[..axes].iter().all(usable) { input.command } else { record.command };
    after.command[..axes].copy_from_slice(&next[..axes]);
    after
}

/// Checks magnitude, slope and, for plain cycles, acceleration.
fn within(
    [now, change]: [f64; 2],
    [past, past_change]: [f64; 2],
    limits: [f64; 3],
    follows: bool,
    clean: bool,
    what: &str,
) {
    let [magnitude, slope, acceleration] = limits;
    let rounding = 1e-9 * magnitude + 1e-15;
    assert!(now.abs() <= magnitude + rounding, "the {what} is {now}, its limit {magnitude}");
    if follows {
        assert!(change.abs() <= slope + rounding, "the {what} goes from {past} to {now} in a cycle, its limit {slope}");
    }
    if clean {
        let found = change - past_change;
        assert!(
            found.abs() <= acceleration + rounding,
            "the {what}'s change changes by {found}, its limit {acceleration}"
        );
    }
}
