//! One input, once: panics are caught, time is taken.

use crate::Target;
use crate::outcome::{self, Outcome};
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;
use std::time::{Duration, Instant};

/// An execution that takes longer is a finding.
pub const SLOWEST: Duration = Duration::from_secs(1);

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
    static PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Runs an input.
///
/// # Errors
/// A broken promise, in words: the panic with its place, or a time above [`SLOWEST`] that a second run confirms (the
/// first may have waited for a processor).
pub fn execute(target: &Target, input: &[u8]) -> Result<Outcome, String> {
    listen();
    let (outcome, took) = timed(target, input)?;
    if took <= SLOWEST {
        return Ok(outcome);
    }
    let (outcome, again) = timed(target, input)?;
    if again <= SLOWEST { Ok(outcome) } else { Err(format!("took {:.1} s", took.min(again).as_secs_f64())) }
}

fn timed(target: &Target, input: &[u8]) -> Result<(Outcome, Duration), String> {
    outcome::take();
    let start = Instant::now();
    GUARDED.set(true);
    let ended = catch_unwind(AssertUnwindSafe(|| (target.run)(input)));
    GUARDED.set(false);
    match ended {
        Ok(()) => Ok((outcome::take(), start.elapsed())),
        Err(_) => Err(PANIC.take()),
    }
}

/// A panic of a guarded execution is kept, not printed.
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
