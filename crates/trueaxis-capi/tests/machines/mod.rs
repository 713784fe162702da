//! Machines, their table files, and the static memory of a C program.

#![allow(dead_code, reason = "the example has this module too, and uses a part of it")]

pub(crate) mod gauge;
pub(crate) mod rust;

use std::ptr::{null, null_mut};
use std::sync::OnceLock;
use trueaxis::machine::{DriveFigures, Row};
use trueaxis::tcomp::Tcomp;
use trueaxis_capi::*;
use trueaxis_tables::{Machine, Table, compile};

pub(crate) const PERIOD_NS: u32 = 100_000;

/// Nine terms, three axes.
pub(crate) const MILL: &[u8] = include_bytes!("../../../trueaxis/mill-3axis.tcomp");

/// Table file for the tests that Miri runs too: the mill, or under Miri a smaller machine.
pub(crate) fn mill() -> &'static [u8] {
    static SMALL: OnceLock<Vec<u8>> = OnceLock::new();
    if cfg!(miri) { SMALL.get_or_init(|| compile(&small()).unwrap()) } else { MILL }
}

/// `w X' Y' b Z t`, 0 to 20 µm along X in a table of two lines: the smallest machine that can be checked and corrected.
pub(crate) fn small() -> Machine {
    small_of("w X' Y' b Z t")
}

/// Like [`small`], with a table that turns and tilts.
pub(crate) fn small_five() -> Machine {
    small_of("w C' A' X' Y' b Z t")
}

fn small_of(chain: &str) -> Machine {
    let row = |(position, error)| {
        let errors = [error, 0.0, 0.0, 0.0, 0.0, 0.0];
        Row { position, forward: errors, reverse: errors }
    };
    let table = Table {
        given: [true, false, false, false, false, false],
        bidirectional: false,
        rows: [(-400.0, 0.0), (400.0, 0.02)].map(row).to_vec(),
    };
    let machine = trueaxis_testing::machine::Machine::new(chain).name("small");
    let settings = machine.travel([-400.0, 400.0], 1.0).settings();
    let mut tables = vec![None; settings.axes.len()];
    tables[0] = Some(table);
    Machine { settings, tables, grids: Vec::new() }
}

/// A sample machine of `compensation-tables`, compiled.
pub(crate) fn sample(name: &str) -> Vec<u8> {
    compile(&read(name)).unwrap()
}

pub(crate) fn read(name: &str) -> Machine {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../compensation-tables/");
    Machine::read(format!("{folder}{name}").as_ref()).unwrap()
}

/// Parameters of a stable drive.
pub(crate) fn drive() -> DriveFigures {
    DriveFigures {
        position_gain_per_s: 110.0,
        velocity_gain_per_s: 800.0,
        reset_time_s: 0.01,
        velocity_feed_forward: 0.9,
        current_loop_s: 0.00025,
        dead_time_s: 0.0,
        resonance_hz: 0.0,
        resonance_damping: 0.0,
        lowest_resonance_hz: 5000.0,
        gain_without_notch: 0.0,
    }
}

/// The machine of `bytes` with half the errors.
pub(crate) fn halved(bytes: &[u8]) -> Vec<u8> {
    let mut machine = Machine::from_tcomp(&Tcomp::parse(bytes).unwrap());
    for row in machine.tables.iter_mut().flatten().flat_map(|table| &mut table.rows) {
        row.forward = row.forward.map(|error| 0.5 * error);
        row.reverse = row.reverse.map(|error| 0.5 * error);
    }
    compile(&machine).unwrap()
}

/// Zeroed storage of a C object.
pub(crate) fn zeroed<T>() -> Box<T> {
    let mut storage = Box::<T>::new_uninit();
    // SAFETY: the objects of the header are arrays of words.
    unsafe {
        storage.as_mut_ptr().write_bytes(0, 1);
        storage.assume_init()
    }
}

pub(crate) fn error() -> Error {
    // SAFETY: numbers only.
    Error { size: size_of::<Error>() as u32, ..unsafe { std::mem::zeroed() } }
}

pub(crate) fn info() -> TablesInfo {
    // SAFETY: numbers only.
    TablesInfo { size: size_of::<TablesInfo>() as u32, ..unsafe { std::mem::zeroed() } }
}

pub(crate) fn output() -> Output {
    // SAFETY: numbers only.
    Output { size: size_of::<Output>() as u32, ..unsafe { std::mem::zeroed() } }
}

pub(crate) fn input(command: [f64; AXES_MAX], feedback: [f64; AXES_MAX]) -> Input {
    Input {
        size: size_of::<Input>() as u32,
        elapsed_ns: PERIOD_NS,
        command: command.map(position),
        feedback: feedback.map(position),
        encoder_alarm: 0,
        homed: 1,
        enable: 1,
        reset: 0,
        refusal: 0,
        refusal_axis: 0,
        dynamics_off: 0,
        reserved: 0,
        learned: [position(0.0); 3],
    }
}

/// A position of this build.
pub(crate) fn position(x: f64) -> Position {
    #[cfg(not(feature = "single"))]
    return x;
    #[cfg(feature = "single")]
    return (x * 1e6).round() as Position;
}

/// Text of a C string.
pub(crate) fn text(characters: &[std::ffi::c_char]) -> String {
    let bytes: Vec<u8> = characters.iter().take_while(|c| **c != 0).map(|c| *c as u8).collect();
    assert!(bytes.len() < characters.len(), "closed by a zero");
    String::from_utf8(bytes).unwrap()
}

/// A loop with the memory that contains its tables.
pub(crate) struct BuiltLoop {
    pub(crate) servo: Box<Loop>,
    pub(crate) memory: Vec<u64>,
}

pub(crate) fn built(file: &[u8]) -> BuiltLoop {
    let mut info = info();
    let mut servo = zeroed::<Loop>();
    // SAFETY: all pointers and sizes match their types.
    unsafe {
        assert_eq!(trueaxis_tables_info(file.as_ptr(), file.len(), &mut info, null_mut()), OK);
        let mut memory = vec![0xa5a5_a5a5_a5a5_a5a5_u64; (info.memory_bytes as usize).div_ceil(8)];
        let result = trueaxis_loop_build(
            &mut *servo,
            size_of::<Loop>(),
            file.as_ptr(),
            file.len(),
            info.machine_id,
            PERIOD_NS,
            memory.as_mut_ptr().cast(),
            info.memory_bytes as usize,
            null_mut(),
        );
        assert_eq!(result, OK);
        BuiltLoop { servo, memory }
    }
}

/// The loop of [`mill`], built once for all tests that only read it: Miri takes seconds for that.
pub(crate) fn mill_loop() -> &'static BuiltLoop {
    static BUILT: OnceLock<BuiltLoop> = OnceLock::new();
    BUILT.get_or_init(|| built(mill()))
}

pub(crate) fn started(servo: &Loop) -> Box<State> {
    let mut state = zeroed::<State>();
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_start(servo, &mut *state, size_of::<State>(), PERIOD_NS) }, OK);
    state
}

/// A measure of a given kind, with null pointers.
pub(crate) fn measure(kind: u32) -> Measure {
    Measure {
        size: size_of::<Measure>() as u32,
        kind,
        path: null(),
        reference: Reference::default(),
        window: null_mut(),
        kinematics: null(),
        direction_error: [9.0; 3],
    }
}

/// Runs a cycle without measure or gauge.
pub(crate) fn step(servo: &Loop, state: &mut State, input: &Input, output: &mut Output) -> ResultCode {
    // SAFETY: all pointers and sizes match their types.
    unsafe { trueaxis_step(servo, state, input, null_mut(), null_mut(), output) }
}

/// A path with its memory.
pub(crate) struct Programmed {
    pub(crate) path: Box<Path>,
    pub(crate) memory: Vec<u64>,
}

impl Programmed {
    pub(crate) fn new(spans: usize, first: u32) -> Self {
        Self::start(trueaxis_path_start, spans * SPAN_BYTES, first)
    }

    pub(crate) fn of_tool(spans: usize, first: u32) -> Self {
        Self::start(trueaxis_path_start_tool, spans * TOOL_SPAN_BYTES, first)
    }

    fn start(
        start: unsafe extern "C" fn(*mut Path, usize, *mut std::ffi::c_void, usize, u32) -> ResultCode,
        bytes: usize,
        first: u32,
    ) -> Self {
        let (mut path, mut memory) = (zeroed::<Path>(), vec![0_u64; bytes.div_ceil(8)]);
        // SAFETY: all pointers and sizes match their types.
        let result = unsafe { start(&mut *path, size_of::<Path>(), memory.as_mut_ptr().cast(), bytes, first) };
        assert_eq!(result, OK);
        Programmed { path, memory }
    }

    pub(crate) fn line(&mut self, start: [f64; 3], end: [f64; 3]) -> ResultCode {
        // SAFETY: all pointers and sizes match their types.
        unsafe { trueaxis_path_line(&mut *self.path, start.as_ptr(), end.as_ptr(), null_mut()) }
    }

    pub(crate) fn count(&self) -> (u32, u32) {
        let (mut segments, mut spans) = (0, 0);
        // SAFETY: all pointers and sizes match their types.
        assert_eq!(unsafe { trueaxis_path_count(&*self.path, &mut segments, &mut spans) }, OK);
        (segments, spans)
    }

    pub(crate) fn reference(&self, segment: u32, u: f64) -> Result<Reference, ResultCode> {
        let mut reference = Reference { span: 99, t: 9.0 };
        // SAFETY: all pointers and sizes match their types.
        match unsafe { trueaxis_path_reference(&*self.path, segment, u, &mut reference) } {
            OK => Ok(reference),
            result => {
                assert_eq!((reference.span, reference.t), (99, 9.0));
                Err(result)
            }
        }
    }
}
