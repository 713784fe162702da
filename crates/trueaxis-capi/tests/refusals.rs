//! Every mistake of a caller has its result code, and the outputs of the function remain unchanged.

use crate::machines::*;
use std::ptr::{null, null_mut};
use std::slice;
use trueaxis_capi::*;

/// All bytes of a value. Miri does not allow reading padding, so nothing is compared there.
fn bytes_of<T>(value: &T) -> Vec<u8> {
    if cfg!(miri) {
        return Vec::new();
    }
    // SAFETY: as many bytes as the value has.
    unsafe { slice::from_raw_parts((&raw const *value).cast(), size_of::<T>()) }.to_vec()
}

/// A misaligned pointer into memory.
fn odd<T>(memory: &mut [u64]) -> *mut T {
    memory.as_mut_ptr().cast::<u8>().wrapping_add(1).cast()
}

struct Build {
    storage: *mut Loop,
    size: usize,
    file: *const u8,
    length: usize,
    machine_id: u32,
    period_ns: u32,
    memory: *mut u64,
    memory_size: usize,
    error: *mut Error,
}

impl Build {
    fn call(&self) -> ResultCode {
        // SAFETY: invalid arguments are null, misaligned or have a wrong size stated.
        unsafe {
            trueaxis_loop_build(
                self.storage,
                self.size,
                self.file,
                self.length,
                self.machine_id,
                self.period_ns,
                self.memory.cast(),
                self.memory_size,
                self.error,
            )
        }
    }
}

#[test]
fn a_loop_is_built_of_nothing_less() {
    let mut storage = zeroed::<Loop>();
    let mut memory = vec![0_u64; mill_loop().memory.len()];
    let (mut spare, mut error) = (vec![0_u64; 4096], error());
    let storage: *mut Loop = &mut *storage;
    let good = Build {
        storage,
        size: size_of::<Loop>(),
        file: mill().as_ptr(),
        length: mill().len(),
        machine_id: 0,
        period_ns: PERIOD_NS,
        memory: memory.as_mut_ptr(),
        memory_size: memory.len() * 8,
        error: null_mut(),
    };
    let error: *mut Error = &mut error;
    let overlapping = storage.cast::<u64>();
    let refused = [
        (ERROR_NULL, Build { storage: null_mut(), ..good }),
        (ERROR_NULL, Build { file: null(), ..good }),
        (ERROR_NULL, Build { memory: null_mut(), ..good }),
        (ERROR_SIZE, Build { size: size_of::<Loop>() - 8, ..good }),
        (ERROR_SIZE, Build { size: size_of::<Loop>() + 8, ..good }),
        (ERROR_SIZE, Build { length: usize::MAX, ..good }),
        (ERROR_SIZE, Build { memory_size: usize::MAX, ..good }),
        (ERROR_ALIGNMENT, Build { storage: odd(&mut spare), ..good }),
        (ERROR_ALIGNMENT, Build { memory: odd(&mut spare), ..good }),
        (ERROR_ALIGNMENT, Build { memory: good.memory.cast::<u8>().wrapping_add(4).cast(), ..good }),
        (ERROR_ALIGNMENT, Build { error: odd(&mut spare), ..good }),
        (ERROR_ARGUMENT, Build { memory: overlapping, memory_size: size_of::<Loop>(), ..good }),
        (ERROR_TABLES, Build { length: 0, ..good }),
        (ERROR_TABLES, Build { length: mill().len() - 1, ..good }),
        (ERROR_MACHINE, Build { machine_id: 1, ..good }),
        (ERROR_CONFIG, Build { period_ns: 999, ..good }),
        (ERROR_CONFIG, Build { period_ns: 100_000_001, ..good }),
        (ERROR_MEMORY, Build { memory_size: 8, ..good }),
        (ERROR_MEMORY, Build { memory_size: 0, ..good }),
    ];
    for (place, (result, build)) in refused.iter().enumerate() {
        // SAFETY: our own storage, zeroed.
        let before = bytes_of(unsafe { &*storage });
        // Miri takes a second to read a file: there every other mistake has an error only, the rest none.
        if !cfg!(miri) || place % 2 == 0 {
            assert_eq!(build.call(), *result, "{place}");
        }
        if !cfg!(miri) || place % 2 == 1 {
            let error = if build.error.is_null() { error } else { build.error };
            assert_eq!(Build { error, ..*build }.call(), *result, "{place}");
        }
        // SAFETY: as above.
        assert_eq!(bytes_of(unsafe { &*storage }), before, "{place}");
        // SAFETY: as above.
        assert_eq!(
            unsafe { trueaxis_start(storage, spare.as_mut_ptr().cast(), size_of::<State>(), PERIOD_NS) },
            ERROR_UNBUILT
        );
    }
    let mut wrong_size = crate::machines::error();
    wrong_size.size -= 4;
    let before = bytes_of(&wrong_size);
    assert_eq!(Build { error: &mut wrong_size, machine_id: 1, ..good }.call(), ERROR_SIZE);
    assert_eq!(bytes_of(&wrong_size), before);
    assert_eq!(good.call(), OK);
}

#[test]
fn an_error_says_what_is_wrong() {
    let mut storage = zeroed::<Loop>();
    let mut memory = vec![0_u64; 16];
    let mut build = |file: &[u8], machine_id, period_ns| {
        let mut error = error();
        let build = Build {
            storage: &mut *storage,
            size: size_of::<Loop>(),
            file: file.as_ptr(),
            length: file.len(),
            machine_id,
            period_ns,
            memory: memory.as_mut_ptr(),
            memory_size: 8,
            error: &mut error,
        };
        let result = build.call();
        assert_eq!(result, error.result);
        error
    };
    let mut damaged = mill().to_vec();
    damaged[60] ^= 0x10;
    let found = build(&damaged, 0, PERIOD_NS);
    assert_eq!((found.result, found.code, found.index), (ERROR_TABLES, 5, u32::MAX));
    assert_eq!(text(&found.text), "table file: the file is damaged (its CRC-32 is wrong)");

    let found = build(mill(), 77, PERIOD_NS);
    assert_eq!((found.result, found.code), (ERROR_MACHINE, 12));
    let found = build(mill(), 0, PERIOD_NS);
    assert_eq!((found.result, found.found), (ERROR_MEMORY, 8.0));
    assert!(text(&found.text).starts_with("memory: found 8 bytes, needed "), "{}", text(&found.text));
    let found = build(b"not a table file", 0, PERIOD_NS);
    assert_eq!((found.result, found.code), (ERROR_TABLES, 3));
}

#[test]
#[cfg_attr(miri, ignore)]
fn every_damage_is_refused() {
    let mut info = info();
    let before = bytes_of(&info);
    let mut codes = [0_usize; 16];
    let mut refused = |bytes: &[u8]| {
        let mut error = error();
        // SAFETY: all pointers and sizes match their types.
        let result = unsafe { trueaxis_tables_info(bytes.as_ptr(), bytes.len(), &mut info, &mut error) };
        assert_eq!(result, ERROR_TABLES);
        assert!(!text(&error.text).is_empty());
        codes[error.code as usize] += 1;
        assert_eq!(bytes_of(&info), before);
    };
    for length in (0..MILL.len()).step_by(7) {
        refused(&MILL[..length]);
    }
    for place in (0..MILL.len()).step_by(3) {
        let mut bytes = MILL.to_vec();
        bytes[place] ^= 1 << (place % 8);
        refused(&bytes);
    }
    refused(&[MILL, &[0]].concat());
    // Too short, too long, another kind, another version, damaged: each code must have occurred.
    assert!(codes[1..=5].iter().all(|count| *count > 0), "{codes:?}");
}

#[test]
#[cfg_attr(miri, ignore)]
fn contents_that_make_no_sense_name_the_setting() {
    let mut machine = read("mill-3axis");
    // The limits of the dynamic correction may be the same numbers, so the machine gets no dynamic correction.
    machine.settings.axes.iter_mut().for_each(|axis| axis.servo.dynamic = None);
    let good = trueaxis_tables::compile(&machine).unwrap();
    machine.settings.axes[1].limits.slope_per_s = 0.0;
    // The compiler refuses this setting too, so the test patches a valid file, in which the slope limit of Y is a
    // double.
    assert!(trueaxis_tables::compile(&machine).is_err());
    let slope = 5.0_f64.to_le_bytes();
    let settings = read("mill-3axis").settings;
    assert_eq!(settings.axes[1].limits.slope_per_s, 5.0);
    let acceleration = settings.axes[1].limits.acceleration_per_s2.to_le_bytes();
    let both = [slope, acceleration].concat();
    let places: Vec<usize> = (0..good.len() - 16).filter(|at| good[*at..*at + 16] == both[..]).collect();
    let mut bytes = good.clone();
    bytes[places[1]..places[1] + 8].copy_from_slice(&0.0_f64.to_le_bytes());
    let end = bytes.len() - 4;
    let sum = trueaxis::tcomp::checksum(&bytes[..end]);
    bytes[end..].copy_from_slice(&sum.to_le_bytes());
    let (mut info, mut error) = (info(), error());
    // SAFETY: all pointers and sizes match their types.
    let result = unsafe { trueaxis_tables_info(bytes.as_ptr(), bytes.len(), &mut info, &mut error) };
    assert_eq!((result, error.code, error.axis as u8), (ERROR_TABLES, 11, b'Y'));
    assert_eq!((text(&error.field).as_str(), error.found), ("Slope", 0.0));
    assert!(
        text(&error.text).starts_with("table file: axis.Y.limits.slope_mm_per_s: found 0, needed "),
        "{}",
        text(&error.text)
    );
}

#[test]
fn a_cycle_takes_what_it_says() {
    let servo: &Loop = &mill_loop().servo;
    let mut state = started(servo);
    let at = [10.0, 20.0, -200.0, 0.0, 0.0, 0.0];
    let good = input(at, at);
    let mut out = output();
    assert_eq!(step(servo, &mut state, &good, &mut out), OK);

    let mut spare = vec![0_u64; 4096];
    let nothing = zeroed::<Loop>();
    let mut never_started = zeroed::<State>();
    let mut path = zeroed::<Path>();
    let strange_refusal = Input { refusal: 99, ..good };
    let freezing_refusal = Input { refusal: FAULT_ENCODER_STUCK, ..good };
    let (mut short_input, mut short_output) = (good, out);
    short_input.size -= 8;
    short_output.size += 8;
    let state: *mut State = &mut *state;
    let never_started: *mut State = &mut *never_started;
    let mut against = Measure { path: &mut *path, ..measure(MEASURE_PATH) };
    let servo: *const Loop = servo;
    let foreign: *mut State = spare.as_mut_ptr().cast();
    // SAFETY: as many bytes as both have; a loop where a state is wanted.
    unsafe { foreign.cast::<u8>().copy_from(servo.cast(), size_of::<State>().min(size_of::<Loop>())) };
    let mut unaligned = vec![0_u64; 4096];
    let before = (bytes_of(&out), bytes_of(&short_output));
    // SAFETY: the state is ours.
    let state_before = bytes_of(unsafe { &*state });
    let out: *mut Output = &mut out;
    // SAFETY: invalid arguments are null, misaligned, zeroed, or have a wrong size stated.
    let none = null_mut();
    let on = &raw mut against;
    let answers = unsafe {
        [
            (ERROR_NULL, trueaxis_step(null(), state, &good, none, null_mut(), out)),
            (ERROR_NULL, trueaxis_step(servo, null_mut(), &good, none, null_mut(), out)),
            (ERROR_NULL, trueaxis_step(servo, state, null(), none, null_mut(), out)),
            (ERROR_NULL, trueaxis_step(servo, state, &good, none, null_mut(), null_mut())),
            (ERROR_SIZE, trueaxis_step(servo, state, &short_input, none, null_mut(), out)),
            (ERROR_SIZE, trueaxis_step(servo, state, &good, none, null_mut(), &mut short_output)),
            (ERROR_ARGUMENT, trueaxis_step(servo, state, &strange_refusal, none, null_mut(), out)),
            (ERROR_ARGUMENT, trueaxis_step(servo, state, &freezing_refusal, none, null_mut(), out)),
            (ERROR_UNBUILT, trueaxis_step(&*nothing, state, &good, none, null_mut(), out)),
            (ERROR_UNBUILT, trueaxis_step(state.cast(), state, &good, none, null_mut(), out)),
            (ERROR_UNBUILT, trueaxis_step(servo, never_started, &good, none, null_mut(), out)),
            (ERROR_UNBUILT, trueaxis_step(servo, foreign, &good, none, null_mut(), out)),
            (ERROR_UNBUILT, trueaxis_step(servo, state, &good, on, null_mut(), out)),
            (ERROR_ALIGNMENT, trueaxis_step(odd(&mut unaligned), state, &good, none, null_mut(), out)),
            (ERROR_ALIGNMENT, trueaxis_step(servo, odd(&mut unaligned), &good, none, null_mut(), out)),
            (ERROR_ALIGNMENT, trueaxis_step(servo, state, odd(&mut unaligned), none, null_mut(), out)),
            (ERROR_ALIGNMENT, trueaxis_step(servo, state, &good, odd(&mut unaligned), null_mut(), out)),
            (ERROR_ALIGNMENT, trueaxis_step(servo, state, &good, none, odd(&mut unaligned), out)),
            (ERROR_ALIGNMENT, trueaxis_step(servo, state, &good, none, null_mut(), odd(&mut unaligned))),
        ]
    };
    for (place, (expected, answer)) in answers.into_iter().enumerate() {
        assert_eq!(answer, expected, "{place}");
    }
    // SAFETY: ours.
    unsafe {
        assert_eq!((bytes_of(&*out), bytes_of(&short_output)), before);
        assert_eq!(bytes_of(&*state), state_before);
        assert_eq!(trueaxis_step(servo, state, &good, null_mut(), null_mut(), out), OK);
        assert_eq!((*out).record.sequence, 1, "refused cycles do not count");
    }
}

#[test]
fn periods_and_numbers_of_axes_must_fit() {
    let built = mill_loop();
    let mut bypass = zeroed::<Loop>();
    let mut state = zeroed::<State>();
    let size = size_of::<Loop>();
    // SAFETY: all pointers and sizes match their types.
    unsafe {
        assert_eq!(trueaxis_start(&*built.servo, &mut *state, size_of::<State>(), 101_000), ERROR_PERIOD);
        assert_eq!(trueaxis_start(&*built.servo, &mut *state, size_of::<State>() - 8, PERIOD_NS), ERROR_SIZE);
        assert_eq!(trueaxis_start(&*built.servo, null_mut(), size_of::<State>(), PERIOD_NS), ERROR_NULL);
        assert!(bytes_of(&*state).iter().all(|byte| *byte == 0));
        assert_eq!(trueaxis_start(&*built.servo, &mut *state, size_of::<State>(), 100_099), OK);

        for (axes, reason, period, result) in [
            (2, FAULT_TABLES_REFUSED, PERIOD_NS, ERROR_AXES),
            (7, FAULT_TABLES_REFUSED, PERIOD_NS, ERROR_AXES),
            (3, FAULT_NONE, PERIOD_NS, ERROR_ARGUMENT),
            (3, FAULT_JOINT_RANGE, PERIOD_NS, ERROR_ARGUMENT),
            (3, 250, PERIOD_NS, ERROR_ARGUMENT),
            (3, FAULT_TABLES_REFUSED, 0, ERROR_ARGUMENT),
        ] {
            assert_eq!(trueaxis_loop_bypass(&mut *bypass, size, axes, reason, period), result);
            assert_eq!(trueaxis_start(&*bypass, &mut *state, size_of::<State>(), PERIOD_NS), ERROR_UNBUILT);
        }
        assert_eq!(trueaxis_loop_bypass(null_mut(), size, 3, FAULT_TABLES_REFUSED, PERIOD_NS), ERROR_NULL);
        assert_eq!(trueaxis_loop_bypass(&mut *bypass, size - 1, 3, FAULT_TABLES_REFUSED, PERIOD_NS), ERROR_SIZE);

        let at = input([1.0; 6], [1.0; 6]);
        let mut out = output();
        for axes in 3..=6 {
            assert_eq!(trueaxis_loop_bypass(&mut *bypass, size, axes, FAULT_CAPACITY_TOO_SMALL, PERIOD_NS), OK);
            let mut passing = zeroed::<State>();
            assert_eq!(trueaxis_start(&*bypass, &mut *passing, size_of::<State>(), PERIOD_NS + 200), ERROR_PERIOD);
            assert_eq!(trueaxis_start(&*bypass, &mut *passing, size_of::<State>(), PERIOD_NS), OK);
            // Loop and state do not belong together; tested both ways.
            let mixed = if axes == 3 { ERROR_STATE } else { ERROR_AXES };
            assert_eq!(step(&bypass, &mut state, &at, &mut out), mixed);
            assert_eq!(step(&built.servo, &mut passing, &at, &mut out), mixed);
            for sequence in 0..3 {
                assert_eq!(step(&bypass, &mut passing, &at, &mut out), OK);
                assert_eq!((out.record.fault, out.record.sequence), (FAULT_CAPACITY_TOO_SMALL, sequence));
                assert_eq!(out.drive[..axes as usize], at.command[..axes as usize]);
                assert_eq!(out.axes, axes);
            }
        }
    }
}

#[test]
fn temperatures_must_be_of_this_world() {
    let built = mill_loop();
    let mut state = started(&built.servo);
    let before = bytes_of(&*state);
    let state: *mut State = &mut *state;
    let set = |place, kelvin| {
        // SAFETY: all pointers and sizes match their types.
        unsafe { trueaxis_set_thermal(&*built.servo, state, place, kelvin) }
    };
    assert_eq!(set(3, 1.0), ERROR_ARGUMENT);
    assert_eq!(set(u32::MAX, 1.0), ERROR_ARGUMENT);
    assert_eq!(set(0, f64::NAN), ERROR_ARGUMENT);
    assert_eq!(set(0, f64::INFINITY), ERROR_ARGUMENT);
    // SAFETY: ours.
    assert_eq!(bytes_of(unsafe { &*state }), before);
    assert_eq!(set(2, -3.0), OK);
}

#[test]
fn frames_need_room() {
    let built = mill_loop();
    let mut state = started(&built.servo);
    let mut out = output();
    assert_eq!(step(&built.servo, &mut state, &input([0.0; 6], [0.0; 6]), &mut out), OK);
    let (mut bytes, mut written) = ([0xaa_u8; FRAME_BYTES], 12345);
    let mut encode = |output: *const Output, size: usize| {
        // SAFETY: invalid arguments are null or have a smaller size stated.
        let result = unsafe { trueaxis_frame_encode(output, bytes.as_mut_ptr(), size, &mut written) };
        (result, written, bytes == [0xaa; FRAME_BYTES])
    };
    assert_eq!(encode(null(), FRAME_BYTES), (ERROR_NULL, 12345, true));
    assert_eq!(encode(&out, 20), (ERROR_BUFFER, 12345, true));
    assert_eq!(encode(&Output { size: 4, ..out }, FRAME_BYTES), (ERROR_SIZE, 12345, true));
    assert_eq!(encode(&Output { axes: 7, ..out }, FRAME_BYTES), (ERROR_ARGUMENT, 12345, true));
    let mut strange = out;
    strange.record.fault = 99;
    assert_eq!(encode(&strange, FRAME_BYTES), (ERROR_ARGUMENT, 12345, true));
    // SAFETY: null is refused.
    unsafe {
        assert_eq!(trueaxis_frame_encode(&out, null_mut(), FRAME_BYTES, &mut written), ERROR_NULL);
        assert_eq!(trueaxis_frame_encode(&out, bytes.as_mut_ptr(), FRAME_BYTES, null_mut()), ERROR_NULL);
    }
}

#[test]
fn versions() {
    assert_eq!(trueaxis_abi_version(), ABI_VERSION);
    assert_eq!(trueaxis_check_abi(ABI_VERSION), OK);
    for other in [0, ABI_VERSION + 1, ABI_VERSION + (1 << 16), ABI_VERSION ^ ABI_SINGLE] {
        assert_eq!(trueaxis_check_abi(other), ERROR_ABI, "{other:x}");
    }
}

/// A host's 64-bit time is never truncated to 32 bits: a time that does not fit, or that runs backwards, is a late
/// cycle.
#[test]
fn a_time_that_does_not_fit_is_a_late_cycle() {
    let fits = i64::from(u32::MAX);
    for host_ns in [0, 1, i64::from(PERIOD_NS), fits] {
        assert_eq!(i64::from(trueaxis_elapsed_ns(host_ns)), host_ns);
    }
    // 2^32 ns plus a period would be truncated to a period.
    let built = mill_loop();
    for host_ns in [fits + 1, fits + 1 + i64::from(PERIOD_NS), i64::MAX, -1, -i64::from(PERIOD_NS), i64::MIN] {
        let elapsed_ns = trueaxis_elapsed_ns(host_ns);
        assert_eq!(elapsed_ns, u32::MAX, "{host_ns}");
        let mut state = started(&built.servo);
        let mut out = output();
        let at = [10.0, 20.0, -200.0, 0.0, 0.0, 0.0];
        for (elapsed_ns, fault) in [(PERIOD_NS, FAULT_NONE), (elapsed_ns, FAULT_LATE_CYCLE), (PERIOD_NS, FAULT_NONE)] {
            assert_eq!(step(&built.servo, &mut state, &Input { elapsed_ns, ..input(at, at) }, &mut out), OK);
            assert_eq!(out.record.fault, fault, "{host_ns}");
            assert_eq!(out.record.status & STATUS_FROZEN != 0, fault == FAULT_LATE_CYCLE);
        }
    }
}

#[test]
fn every_result_has_its_words() {
    let words = |result| {
        // SAFETY: a constant string.
        unsafe { std::ffi::CStr::from_ptr(trueaxis_result_text(result)) }.to_str().unwrap().to_string()
    };
    let mut all: Vec<String> = (OK..=ERROR_LEFT_OUT).map(words).collect();
    let unknown = words(ERROR_LEFT_OUT + 1);
    assert_eq!((&unknown, &unknown), (&words(-1), &words(i32::MAX)));
    all.push(unknown);
    let count = all.len();
    all.sort();
    all.dedup();
    assert_eq!(all.len(), count);
}
