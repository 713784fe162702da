//! Runs one input once, catches panics and measures the time.

use crate::Target;
use crate::outcome::{self, Outcome};
use rustix::time::{ClockId, Timespec, clock_gettime};
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;
use std::time::{Duration, Instant};

/// An execution that takes longer is a finding, unless its target allows more.
pub const SLOWEST: Duration = Duration::from_secs(1);

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
    static PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Runs an input.
///
/// # Errors
/// A broken promise, in words: the panic with its location, or a time above [`Target::slowest`] that a second run confirms.
/// Time is the shorter of wall time and process time: other processes keep the processors busy.
pub fn execute(target: &Target, input: &[u8]) -> Result<Outcome, String> {
    listen();
    let (outcome, took) = timed(target, input)?;
    if took <= target.slowest {
        return Ok(outcome);
    }
    let (outcome, again) = timed(target, input)?;
    if again <= target.slowest { Ok(outcome) } else { Err(format!("took {:.1} s", took.min(again).as_secs_f64())) }
}

fn timed(target: &Target, input: &[u8]) -> Result<(Outcome, Duration), String> {
    outcome::begin(input);
    let (start, busy) = (Instant::now(), processor());
    GUARDED.set(true);
    let ended = catch_unwind(AssertUnwindSafe(|| (target.run)(input)));
    GUARDED.set(false);
    match ended {
        Ok(()) => Ok((outcome::take(), start.elapsed().min(processor() - busy))),
        Err(_) => Err(PANIC.take()),
    }
}

/// Processor time used by this process.
fn processor() -> Duration {
    let Timespec { tv_sec, tv_nsec } = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(tv_sec.unsigned_abs(), u32::try_from(tv_nsec).unwrap_or(0))
}

/// Stores a panic of a guarded execution instead of printing it.
fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let others = take_hook();
        set_hook(Box::new(move |panic| {
            if GUARDED.get() {
                PANIC.set(panic.to_string());
            } else {
                others(panic);
            }
        }));
    });
}
