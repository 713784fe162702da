//! Loops, states and the step.

use super::draw::Draw;
use super::machines::{PERIOD_NS, bounds};
use super::world::{Built, Loops, Running, World, answered, bytes_of, copy, explained};
use std::ptr::{null, null_mut};
use trueaxis_capi::*;

/// Describes a table file and builds a loop from it in memory that no other loop uses.
pub(super) fn build(world: &mut World, draw: &mut Draw<'_>) {
    let mut wrong = draw.wrong();
    let file = world.file(draw);
    let slot = draw.below(3);
    let info = info(world, &file, draw);
    let Loops { objects, built, memory } = &mut world.loops;
    let free = (0..4).find(|block| built.iter().flatten().all(|built| built.memory != *block)).expect("a free block");
    let (machine_id, period_ns) = match draw.below(16) {
        0 => (draw.word(), PERIOD_NS),
        1 => (0, draw.word()),
        2 => (0, [999, 1000, 100_000_000, 100_000_001][draw.below(4)]),
        _ => (info.map_or(0, |info| info.machine_id), PERIOD_NS),
    };
    let size = if draw.below(16) == 0 { 8 * draw.below(64) } else { 8 * memory[free].len() };
    let before = bytes_of(&*objects[slot]).to_vec();
    // SAFETY: a wrong argument is null, misaligned or has another stated size; no loop uses the memory.
    let result = unsafe {
        trueaxis_loop_build(
            wrong.at(0, &raw mut *objects[slot]),
            wrong.size(0, size_of::<Loop>()),
            wrong.at(1, file.as_ptr().cast_mut()),
            file.len(),
            machine_id,
            period_ns,
            wrong.memory(2, &mut memory[free]),
            size,
            &raw mut *world.error,
        )
    };
    let refusals = [ERROR_TABLES, ERROR_MACHINE, ERROR_CONFIG, ERROR_MEMORY];
    answered("loop_build", result, &wrong, &refusals);
    if result != OK {
        explained(&world.error, result);
        assert!(before == bytes_of(&*objects[slot]), "a refused loop was written");
        return;
    }
    let info = info.expect("a file that a loop was built of can be described");
    assert!(info.memory_bytes <= size as u64 && (machine_id == 0 || machine_id == info.machine_id));
    built[slot] = Some(Built {
        axes: info.axes,
        bypass: false,
        machine_id: info.machine_id,
        tables_crc: info.tables_crc,
        period_ns,
        memory: free,
        bounds: bounds(&file, period_ns),
    });
}

/// The description of a file, if it is sound.
fn info(world: &mut World, file: &[u8], draw: &mut Draw<'_>) -> Option<TablesInfo> {
    let mut wrong = draw.wrong();
    // SAFETY: numbers only.
    let mut info: TablesInfo = unsafe { std::mem::zeroed() };
    info.size = wrong.size(0, size_of::<TablesInfo>()) as u32;
    let before = info;
    // SAFETY: a wrong argument is null, misaligned or has another stated size.
    let result = unsafe {
        let (file, length) = (wrong.at(1, file.as_ptr().cast_mut()), file.len());
        trueaxis_tables_info(file, length, wrong.at(0, &raw mut info), &raw mut *world.error)
    };
    answered("tables_info", result, &wrong, &[ERROR_TABLES]);
    if result != OK {
        explained(&world.error, result);
        assert!(bytes_of(&before) == bytes_of(&info), "a refused description was written");
        // The loop needs the description without the defect.
        if wrong.met {
            info.size = size_of::<TablesInfo>() as u32;
            // SAFETY: every argument matches its type.
            let result = unsafe { trueaxis_tables_info(file.as_ptr(), file.len(), &mut info, null_mut()) };
            return (result == OK).then_some(info);
        }
        return None;
    }
    assert!((3..=6).contains(&info.axes) && info.letters[info.axes as usize] == 0);
    assert!(info.name.contains(&0) && info.chain.contains(&0));
    Some(info)
}

/// A loop without tables.
pub(super) fn bypass(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, slot, axes) = (draw.wrong(), draw.below(3), draw.below(9) as u32);
    let reason = [FAULT_TABLES_REFUSED, FAULT_PERIOD_MISMATCH, FAULT_ABI_MISMATCH, draw.byte()][draw.below(4)];
    let period_ns = if draw.below(8) == 0 { draw.word() } else { PERIOD_NS };
    let object = &mut world.loops.objects[slot];
    let before = bytes_of(&**object).to_vec();
    let size = wrong.size(0, size_of::<Loop>());
    // SAFETY: as above.
    let result = unsafe { trueaxis_loop_bypass(wrong.at(0, &raw mut **object), size, axes, reason, period_ns) };
    answered("loop_bypass", result, &wrong, &[ERROR_AXES, ERROR_ARGUMENT]);
    if result != OK {
        return assert!(before == bytes_of(&**object), "a refused loop was written");
    }
    assert!((3..=6).contains(&axes) && (1_000..=100_000_000).contains(&period_ns));
    world.loops.built[slot] = Some(Built {
        axes,
        bypass: true,
        machine_id: 0,
        tables_crc: 0,
        period_ns,
        memory: usize::MAX,
        bounds: Default::default(),
    });
}

/// Copies a loop; the copy is equally valid.
pub(super) fn copy_loop(world: &mut World, draw: &mut Draw<'_>) {
    let (from, to) = (draw.below(3), draw.below(3));
    let Loops { objects, built, .. } = &mut world.loops;
    if let Ok([from, to]) = objects.get_disjoint_mut([from, to]) {
        copy(&**from, &mut **to);
    }
    built[to] = built[from];
}

/// Starts a new state.
pub(super) fn start(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, servo, slot) = (draw.wrong(), draw.below(3), draw.below(2));
    let period_ns = if draw.below(8) == 0 { draw.word() } else { PERIOD_NS };
    let (object, of) = (&mut world.states.objects[slot], &world.loops.objects[servo]);
    let before = bytes_of(&**object).to_vec();
    // SAFETY: as above.
    let result = unsafe {
        let (size, of) = (wrong.size(1, size_of::<State>()), wrong.at(0, (&raw const **of).cast_mut()));
        trueaxis_start(of, wrong.at(1, &raw mut **object), size, period_ns)
    };
    answered("start", result, &wrong, &[ERROR_PERIOD]);
    let built = world.loops.built[servo];
    if result != OK {
        assert!(built.is_none() || result != ERROR_UNBUILT);
        return assert!(before == bytes_of(&**object), "a refused state was written");
    }
    let built = built.expect("a state of a loop that was never built");
    assert!(period_ns.abs_diff(built.period_ns) <= built.period_ns / 1000);
    world.states.running[slot] = Some(Running {
        axes: built.axes,
        bypass: built.bypass,
        bounds: built.bounds,
        command: [0.0; AXES_MAX],
        reading: [0.0; AXES_MAX],
        cycles: 0,
        plain: 0,
        sent: [[0.0; 2]; AXES_MAX],
        dynamic: [[0.0; 2]; AXES_MAX],
    });
}

/// Saves a state, or restores the saved one.
pub(super) fn keep_state(world: &mut World, draw: &mut Draw<'_>) {
    let (slot, back) = (draw.below(2), draw.flag());
    let states = &mut world.states;
    if back {
        if states.kept.1.is_some() {
            copy(&*states.kept.0, &mut *states.objects[slot]);
            states.running[slot] = states.kept.1;
        }
    } else {
        copy(&*states.objects[slot], &mut *states.kept.0);
        states.kept.1 = states.running[slot];
    }
}

/// Sets the temperature of an axis.
pub(super) fn thermal(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, servo, slot, axis) = (draw.wrong(), draw.below(3), draw.below(2), draw.below(8) as u32);
    let kelvin = draw.number();
    let object = &mut world.states.objects[slot];
    let before = bytes_of(&**object).to_vec();
    // SAFETY: as above.
    let result = unsafe {
        let servo = wrong.at(0, (&raw const *world.loops.objects[servo]).cast_mut());
        trueaxis_set_thermal(servo, wrong.at(1, &raw mut **object), axis, kelvin)
    };
    answered("set_thermal", result, &wrong, &[ERROR_AXES, ERROR_STATE, ERROR_ARGUMENT]);
    if result != OK {
        return assert!(before == bytes_of(&**object), "a refused temperature was set");
    }
    assert!(kelvin.is_finite() && world.states.running[slot].is_some_and(|running| axis < running.axes));
}

/// Queries errors and corrections at a position, without a state.
pub(super) fn query(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, servo, correction) = (draw.wrong(), draw.below(3), draw.flag());
    let (position, kelvin) = (draw.numbers::<AXES_MAX>(), draw.numbers::<AXES_MAX>());
    let (negative, with_kelvin) = (draw.byte(), draw.flag());
    let mut found = [f64::NAN; AXES_MAX];
    let function = if correction { trueaxis_correction_at } else { trueaxis_error_at };
    // SAFETY: as above; six numbers suffice for any loop.
    let result = unsafe {
        let servo = wrong.at(0, (&raw const *world.loops.objects[servo]).cast_mut());
        let position = wrong.at(1, position.as_ptr().cast_mut());
        let kelvin = if with_kelvin { kelvin.as_ptr() } else { null() };
        function(servo, position, negative, kelvin, wrong.at(2, found.as_mut_ptr()))
    };
    answered("error_at", result, &wrong, &[ERROR_STATE, ERROR_ARGUMENT]);
    let axes = world.loops.built[servo].map_or(0, |built| built.axes as usize);
    if result != OK {
        return assert!(found.iter().all(|value| value.is_nan()), "a refused query was answered");
    }
    let (of_axes, beyond) = found.split_at(axes);
    assert!(of_axes.iter().all(|value| value.is_finite()), "{found:?} at {position:?}");
    assert!(beyond.iter().all(|value| value.is_nan()), "written beyond the axes");
}

/// Writes the telemetry frame of the last output, whole or damaged.
pub(super) fn frame(world: &mut World, draw: &mut Draw<'_>) {
    let mut wrong = draw.wrong();
    let mut output = *world.output;
    let damaged = draw.below(4) == 0;
    if damaged {
        let at = usize::from(u16::from_le_bytes([draw.byte(), draw.byte()])) % size_of::<Output>();
        // SAFETY: only numbers, within the structure.
        unsafe { *(&raw mut output).cast::<u8>().add(at) ^= draw.byte().max(1) };
    }
    let size = if draw.below(4) == 0 { draw.below(256) } else { FRAME_BYTES };
    let (mut buffer, mut written) = ([0xa5_u8; FRAME_BYTES], usize::MAX);
    // SAFETY: as above; the buffer is at least as large as stated.
    let result = unsafe {
        let output = wrong.at(0, &raw mut output);
        trueaxis_frame_encode(output, wrong.at(1, buffer.as_mut_ptr()), size, wrong.at(2, &raw mut written))
    };
    wrong.met |= damaged && result == ERROR_SIZE;
    answered("frame_encode", result, &wrong, &[ERROR_BUFFER, ERROR_ARGUMENT]);
    if result != OK {
        return assert!(written == usize::MAX && buffer == [0xa5; FRAME_BYTES], "a refused frame was written");
    }
    assert!(written <= size && buffer[written..].iter().all(|byte| *byte == 0xa5));
    let mut bytes = buffer[..written].to_vec();
    let frame = trueaxis::telemetry::Frame::decode(&mut bytes).expect("a frame");
    assert!(damaged || frame.axes.len() == world.output.axes as usize);
}
