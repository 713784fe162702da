//! Kinematics, the tool, learned corrections, programs, versions.

use super::draw::Draw;
use super::world::{World, answered, bytes_of, damage, explained};
use trueaxis_capi::*;

/// Builds the kinematics of a file.
pub(super) fn build(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, mut file) = (draw.wrong(), world.file(draw));
    let before = bytes_of(&*world.kinematics).to_vec();
    // SAFETY: a wrong argument is null, misaligned or has another stated size.
    let result = unsafe {
        trueaxis_kinematics_build(
            wrong.at(0, &raw mut *world.kinematics),
            wrong.size(0, size_of::<Kinematics>()),
            wrong.at(1, file.as_mut_ptr()),
            file.len(),
            &raw mut *world.error,
        )
    };
    answered("kinematics_build", result, &wrong, &[ERROR_TABLES, ERROR_CONFIG]);
    if result != OK {
        explained(&world.error, result);
        assert!(before == bytes_of(&*world.kinematics), "refused kinematics were written");
    }
}

/// Tool and forward kinematics; the tracker starts there.
pub(super) fn forward(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, kind) = (draw.wrong(), draw.below(3));
    let numbers = draw.numbers::<AXES_MAX>();
    let given = wrong.at(1, numbers.as_ptr().cast_mut());
    match kind {
        0 => {
            let kinematics = wrong.at(0, &raw mut *world.kinematics);
            // SAFETY: as above.
            let result = unsafe { trueaxis_kinematics_set_tool(kinematics, given) };
            answered("kinematics_set_tool", result, &wrong, &[ERROR_ARGUMENT]);
            assert!(result != OK || numbers[..3].iter().all(|q| q.is_finite()));
        }
        1 => {
            let mut tool = Tool { tip: [f64::NAN; 3], axis: [f64::NAN; 3] };
            let kinematics = wrong.at(0, (&raw const *world.kinematics).cast_mut());
            // SAFETY: as above.
            let result = unsafe { trueaxis_kinematics_forward(kinematics, given, wrong.at(2, &raw mut tool)) };
            answered("kinematics_forward", result, &wrong, &[ERROR_ARGUMENT]);
            let components = tool.tip.iter().chain(&tool.axis);
            assert!(components.clone().all(|q| q.is_nan()) || result == OK, "a refused tool was written");
            // Beyond the range of any machine a sum may overflow.
            let sane = numbers.iter().all(|q| q.abs() <= 1e9);
            assert!(result != OK || !sane || tool.axis.iter().all(|q| q.is_finite()), "{tool:?}");
        }
        _ => {
            let step = draw.number();
            let before = bytes_of(&*world.tracker).to_vec();
            // SAFETY: as above.
            let result = unsafe {
                let kinematics = wrong.at(0, (&raw const *world.kinematics).cast_mut());
                let size = wrong.size(2, size_of::<BranchTracker>());
                let tracker = wrong.at(2, &raw mut *world.tracker);
                trueaxis_branch_tracker_start(tracker, size, kinematics, given, step, &raw mut *world.error)
            };
            answered("branch_tracker_start", result, &wrong, &[ERROR_POSE, ERROR_ARGUMENT]);
            if result != OK {
                explained(&world.error, result);
                assert!(before == bytes_of(&*world.tracker), "a refused tracker was written");
            }
        }
    }
}

/// Writes the axis positions for a tool into the input of the next step.
pub(super) fn rtcp(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, servo, slot) = (draw.wrong(), draw.below(3), draw.below(2));
    let axis = if draw.flag() { [0.0, 0.0, 1.0] } else { draw.numbers() };
    let tool = Tool { tip: draw.numbers(), axis };
    let (input, tracker) = (*world.input, bytes_of(&*world.tracker).to_vec());
    let command: Vec<u64> = input.command.iter().map(|q| q.to_bits()).collect();
    // SAFETY: as above.
    let result = unsafe {
        trueaxis_rtcp(
            wrong.at(0, (&raw const *world.loops.objects[servo]).cast_mut()),
            wrong.at(1, (&raw const *world.states.objects[slot]).cast_mut()),
            wrong.at(2, (&raw const tool).cast_mut()),
            wrong.at(3, &raw mut *world.tracker),
            wrong.at(4, (&raw const *world.kinematics).cast_mut()),
            wrong.at(5, &raw mut *world.input),
        )
    };
    answered("rtcp", result, &wrong, &[ERROR_AXES, ERROR_STATE, ERROR_MACHINE]);
    if result != OK {
        let now: Vec<u64> = world.input.command.iter().map(|q| q.to_bits()).collect();
        assert!(now == command && world.input.refusal == input.refusal, "a refused tool was commanded");
        return assert!(tracker == bytes_of(&*world.tracker), "a refused tool moved the tracker");
    }
    let axes = world.loops.built[servo].map_or(0, |built| built.axes as usize);
    let refused = world.input.refusal != FAULT_NONE;
    assert!(refused || world.input.command[..axes].iter().all(|q| q.is_finite()), "{:?}", world.input);
    let mut left = f64::NAN;
    // SAFETY: as above.
    let result = unsafe { trueaxis_branch_tracker_direction_error(&raw const *world.tracker, &raw mut left) };
    assert!(result == OK && (0.0..=45.0).contains(&left), "{result} {left}");
}

/// Builds a learned correction, whole or damaged, or evaluates it.
pub(super) fn learned(world: &mut World, draw: &mut Draw<'_>) {
    let mut wrong = draw.wrong();
    if draw.flag() {
        let (length, mut found) = (draw.number(), [f64::NAN; 3]);
        // SAFETY: a wrong argument is null or misaligned; the file that was read still exists.
        let result = unsafe {
            let learned = wrong.at(0, (&raw const *world.learned).cast_mut());
            trueaxis_learned_at(learned, length, wrong.at(1, found.as_mut_ptr()))
        };
        answered("learned_at", result, &wrong, &[]);
        return assert!(found.iter().all(|value| value.is_finite() == (result == OK)), "{found:?} at {length}");
    }
    world.lessons[1].clone_from(&world.lesson);
    damage(&mut world.lessons[1], draw);
    let before = bytes_of(&*world.learned).to_vec();
    let (machine, program) = ([0, 0x11, 0x12][draw.below(3)], [0x22, 0x22, 0x22, 0x23][draw.below(4)]);
    let length_mm = if draw.below(4) == 0 { draw.number() } else { 10.0 };
    // SAFETY: as above.
    let result = unsafe {
        trueaxis_learned_build(
            wrong.at(0, &raw mut *world.learned),
            wrong.size(0, size_of::<Learned>()),
            wrong.at(1, world.lessons[1].as_mut_ptr()),
            world.lessons[1].len(),
            machine,
            program,
            length_mm,
            &raw mut *world.error,
        )
    };
    answered("learned_build", result, &wrong, &[ERROR_LEARNED, ERROR_MACHINE, ERROR_ARGUMENT]);
    if result == OK {
        // Swapping does not move the bytes.
        world.lessons.swap(0, 1);
        return;
    }
    explained(&world.error, result);
    assert!(before == bytes_of(&*world.learned), "a refused correction was written");
}

/// Sets the id of a program.
pub(super) fn program(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, kind) = (draw.wrong(), draw.below(3));
    let numbers = draw.numbers::<6>();
    let program = wrong.at(0, &raw mut *world.program);
    // SAFETY: as above.
    unsafe {
        match kind {
            0 => {
                let result = trueaxis_program_start(program, wrong.size(0, size_of::<Program>()), numbers[0]);
                answered("program_start", result, &wrong, &[ERROR_ARGUMENT]);
                assert!(result != OK || (0.0..=1e12).contains(&numbers[0]));
            }
            1 => {
                let result = trueaxis_program_point(program, wrong.at(1, numbers.as_ptr().cast_mut()));
                answered("program_point", result, &wrong, &[ERROR_ARGUMENT]);
                assert!(result != OK || numbers.iter().all(|q| q.is_finite()));
            }
            _ => {
                let mut id = 0;
                let result = trueaxis_program_id(program, wrong.at(1, &raw mut id));
                answered("program_id", result, &wrong, &[]);
                assert!(result == OK || id == 0);
            }
        }
    }
}

/// Passes an object of another kind as a loop, and as a state.
pub(super) fn other_kinds(world: &mut World, draw: &mut Draw<'_>) {
    let object: *const Loop = match draw.below(5) {
        0 => (&raw const *world.states.objects[0]).cast(),
        1 => (&raw const *world.paths.objects[0]).cast(),
        2 => (&raw const *world.gauges.gauge).cast(),
        3 => (&raw const *world.kinematics).cast(),
        _ => (&raw const *world.learned).cast(),
    };
    let mut output = *world.output;
    // SAFETY: only the first word of an object of another kind is read.
    let result = unsafe {
        let state = &raw mut *world.states.objects[1];
        trueaxis_step(object, state, &*world.input, std::ptr::null_mut(), std::ptr::null_mut(), &mut output)
    };
    assert!([ERROR_UNBUILT, ERROR_ARGUMENT].contains(&result), "another object was taken for a loop: {result}");
}

/// Versions, texts, and 64-bit times.
pub(super) fn version(draw: &mut Draw<'_>) {
    let (version, result) = (draw.word(), draw.word() as i32);
    assert_eq!(trueaxis_check_abi(trueaxis_abi_version()), OK);
    assert!([OK, ERROR_ABI].contains(&trueaxis_check_abi(version)));
    // SAFETY: a constant, zero-terminated string.
    let text = unsafe { std::ffi::CStr::from_ptr(trueaxis_result_text(result)) };
    assert!(!text.to_str().expect("UTF-8").is_empty());
    let host_ns = i64::from(version) * i64::from(result);
    let elapsed_ns = trueaxis_elapsed_ns(host_ns);
    assert!(i64::from(elapsed_ns) == host_ns || elapsed_ns == u32::MAX, "{host_ns} ns became {elapsed_ns}");
}
