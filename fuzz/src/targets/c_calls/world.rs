//! The objects of a C program, and the expected state of each.

use super::draw::{Draw, Wrong};
use super::machines::{Bound, PERIOD_NS, files};
use crate::outcome;
use trueaxis_capi::*;

/// Storage of an object, all words zero.
pub(super) fn zeroed<T>() -> Box<T> {
    let mut storage = Box::<T>::new_uninit();
    // SAFETY: the header's objects are arrays of words, and its structures consist of numbers and pointers.
    unsafe {
        storage.as_mut_ptr().write_bytes(0, 1);
        storage.assume_init()
    }
}

/// All bytes of an object without padding.
pub(super) fn bytes_of<T>(value: &T) -> &[u8] {
    // SAFETY: exactly the bytes of the value, all of them initialised.
    unsafe { std::slice::from_raw_parts((&raw const *value).cast(), size_of::<T>()) }
}

/// Copies an object, which the header permits for some.
pub(super) fn copy<T>(from: &T, to: &mut T) {
    // SAFETY: two complete objects of words.
    unsafe { (&raw mut *to).copy_from_nonoverlapping(from, 1) }
}

/// Returns an object to its unbuilt state.
fn forget<T>(object: &mut T) {
    // SAFETY: objects begin with a word.
    unsafe { (&raw mut *object).cast::<u64>().write(0) }
}

/// A loop that has been built.
#[derive(Clone, Copy)]
pub(super) struct Built {
    pub(super) axes: u32,
    pub(super) bypass: bool,
    pub(super) machine_id: u32,
    pub(super) tables_crc: u32,
    pub(super) period_ns: u32,
    /// Which memory the loop uses.
    pub(super) memory: usize,
    pub(super) bounds: [Bound; AXES_MAX],
}

/// A started state, with the history of its cycles.
#[derive(Clone, Copy)]
pub(super) struct Running {
    pub(super) axes: u32,
    pub(super) bypass: bool,
    pub(super) bounds: [Bound; AXES_MAX],
    /// Commands and readings continue from here.
    pub(super) command: [f64; AXES_MAX],
    pub(super) reading: [f64; AXES_MAX],
    /// Cycles run, and consecutive plain ones.
    pub(super) cycles: u32,
    pub(super) plain: u32,
    /// The correction sent and its change; the dynamic part and its change.
    pub(super) sent: [[f64; 2]; AXES_MAX],
    pub(super) dynamic: [[f64; 2]; AXES_MAX],
}

pub(super) struct Loops {
    pub(super) objects: [Box<Loop>; 3],
    pub(super) built: [Option<Built>; 3],
    pub(super) memory: [Vec<u64>; 4],
}

pub(super) struct States {
    pub(super) objects: [Box<State>; 2],
    pub(super) running: [Option<Running>; 2],
    pub(super) kept: (Box<State>, Option<Running>),
}

pub(super) struct Paths {
    pub(super) objects: [Box<Path>; 2],
    pub(super) memory: [Vec<u64>; 2],
    /// Number of the first span, and whether the path has a tool.
    pub(super) started: [Option<(u32, bool)>; 2],
    pub(super) window: Box<CommandWindow>,
}

pub(super) struct Gauges {
    pub(super) gauge: Box<Gauge>,
    pub(super) state: Box<GaugeState>,
    /// The state before a call.
    pub(super) before: Box<GaugeState>,
    pub(super) spindle: i32,
}

/// Everything that the calls use.
pub(super) struct World {
    pub(super) files: Vec<Vec<u8>>,
    /// A learned correction for the machine of the first file.
    pub(super) lesson: Vec<u8>,
    pub(super) loops: Loops,
    pub(super) states: States,
    pub(super) paths: Paths,
    pub(super) gauges: Gauges,
    pub(super) kinematics: Box<Kinematics>,
    pub(super) tracker: Box<BranchTracker>,
    pub(super) learned: Box<Learned>,
    /// Files of the current correction and of the next.
    pub(super) lessons: [Vec<u8>; 2],
    pub(super) program: Box<Program>,
    pub(super) input: Box<Input>,
    pub(super) output: Box<Output>,
    pub(super) error: Box<Error>,
}

impl World {
    pub(super) fn new() -> World {
        let memory = |words| vec![0; words];
        World {
            files: files(),
            lesson: crate::targets::tlearn::seed(),
            loops: Loops {
                objects: [(); 3].map(|()| zeroed()),
                built: [None; 3],
                memory: [(); 4].map(|()| memory(1 << 14)),
            },
            states: States { objects: [(); 2].map(|()| zeroed()), running: [None; 2], kept: (zeroed(), None) },
            paths: Paths {
                objects: [(); 2].map(|()| zeroed()),
                memory: [(); 2].map(|()| memory(24 * TOOL_SPAN_BYTES / 8)),
                started: [None; 2],
                window: zeroed(),
            },
            gauges: Gauges { gauge: zeroed(), state: zeroed(), before: zeroed(), spindle: 0 },
            kinematics: zeroed(),
            tracker: zeroed(),
            learned: zeroed(),
            lessons: [Vec::new(), Vec::new()],
            program: zeroed(),
            input: zeroed(),
            output: zeroed(),
            error: zeroed(),
        }
    }

    /// Returns to the start of a program: nothing is built.
    pub(super) fn reset(&mut self) {
        self.loops.objects.iter_mut().for_each(|object| forget(&mut **object));
        self.states.objects.iter_mut().for_each(|object| forget(&mut **object));
        self.paths.objects.iter_mut().for_each(|object| forget(&mut **object));
        (self.loops.built, self.states.running, self.states.kept.1) = ([None; 3], [None; 2], None);
        self.paths.started = [None; 2];
        forget(&mut *self.paths.window);
        forget(&mut *self.gauges.gauge);
        forget(&mut *self.gauges.state);
        self.gauges.spindle = 0;
        forget(&mut *self.kinematics);
        forget(&mut *self.tracker);
        forget(&mut *self.learned);
        forget(&mut *self.program);
        *self.input = Input {
            size: size_of::<Input>() as u32,
            elapsed_ns: PERIOD_NS,
            command: [0.0; AXES_MAX],
            feedback: [0.0; AXES_MAX],
            encoder_alarm: 0,
            homed: 1,
            enable: 1,
            reset: 0,
            refusal: 0,
            refusal_axis: 0,
            dynamics_off: 0,
            reserved: 0,
            learned: [0.0; 3],
        };
        self.output = zeroed();
        self.output.size = size_of::<Output>() as u32;
        self.error = zeroed();
        self.error.size = size_of::<Error>() as u32;
    }

    /// A table file, whole or damaged, with or without a corrected check sum.
    pub(super) fn file(&self, draw: &mut Draw<'_>) -> Vec<u8> {
        let mut file = self.files[draw.below(self.files.len())].clone();
        damage(&mut file, draw);
        file
    }
}

/// Damages a file at up to two places or truncates it; usually leaves it whole.
pub(super) fn damage(file: &mut Vec<u8>, draw: &mut Draw<'_>) {
    let how = draw.byte();
    if how < 192 || file.is_empty() {
        return;
    }
    for _ in 0..1 + how % 2 {
        let at = usize::from(u16::from_le_bytes([draw.byte(), draw.byte()])) % file.len();
        file[at] ^= draw.byte().max(1);
    }
    if how % 8 == 7 {
        file.truncate(file.len() - 1 - draw.below(16).min(file.len() - 1));
    }
    if !how.is_multiple_of(4) {
        crate::sum::seal(file);
    }
}

/// Checks a call's result: OK only if no argument was wrong, and otherwise a result that is in `allowed` or permitted for
/// every function.
pub(super) fn answered(function: &'static str, result: ResultCode, wrong: &Wrong, allowed: &[ResultCode]) {
    outcome::saw((function, result));
    let always = [ERROR_NULL, ERROR_SIZE, ERROR_ALIGNMENT, ERROR_UNBUILT];
    assert!(
        result == OK || allowed.contains(&result) || always.contains(&result),
        "{function} answers {result}, which the header does not name"
    );
    assert!(!(wrong.met && result == OK), "{function} takes a pointer or size that is wrong");
    // All other arguments are valid: none is null or misaligned unless made so here.
    let pointer = [ERROR_NULL, ERROR_SIZE, ERROR_ALIGNMENT].contains(&result);
    assert!(wrong.met || !pointer, "{function} refuses good pointers and sizes with {result}");
}

/// Checks the explanation of a refusal: in words, on one line, with the function's result.
pub(super) fn explained(error: &Error, result: ResultCode) {
    if [ERROR_NULL, ERROR_SIZE, ERROR_ALIGNMENT].contains(&result) {
        return;
    }
    assert_eq!(error.result, result);
    for text in [&error.text[..], &error.needed, &error.field] {
        assert!(text.contains(&0), "a text is not closed");
    }
    let bytes: Vec<u8> = error.text.iter().take_while(|c| **c != 0).map(|c| *c as u8).collect();
    let text = std::str::from_utf8(&bytes).expect("UTF-8");
    assert!(!text.is_empty() && !text.contains(char::is_control), "{text:?}");
}
