//! A process limited in processor time, so that a busy machine neither stops it early nor makes it appear slow.

use std::os::unix::process::CommandExt;
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};

#[repr(C)]
#[derive(Default)]
struct Usage {
    user: [i64; 2],
    system: [i64; 2],
    rest: [i64; 14],
}

unsafe extern "C" {
    fn setrlimit(resource: i32, limit: *const [u64; 2]) -> i32;
    fn wait4(pid: i32, status: *mut i32, options: i32, usage: *mut Usage) -> i32;
}

/// Linux constants: the limit on processor time in seconds, and wait4's option to return at once.
const RLIMIT_CPU: i32 = 0;
const WNOHANG: i32 = 1;

/// How a process ended.
pub enum End {
    Passed,
    Failed,
    /// Exceeded its time.
    TimedOut,
}

/// Runs the command with a limit in whole seconds of processor time, and thirty times that in wall time; returns the time it
/// took.
pub fn run(command: &mut Command, seconds: u64) -> Result<(End, Duration)> {
    // SAFETY: between fork and exec only setrlimit is called, with the arguments that Linux expects.
    unsafe {
        command.pre_exec(move || {
            setrlimit(RLIMIT_CPU, &[seconds, seconds]);
            Ok(())
        });
    }
    let mut child = command.spawn()?;
    let (pid, begun) = (child.id() as i32, Instant::now());
    let (mut pause, mut killed) = (Duration::from_micros(200), false);
    loop {
        let (mut status, mut usage) = (0, Usage::default());
        // SAFETY: both pointers are valid for wait4 to write to; no other code waits for this child.
        let found = unsafe { wait4(pid, &mut status, WNOHANG, &mut usage) };
        if found == pid {
            let micros = 1_000_000 * (usage.user[0] + usage.system[0]) + usage.user[1] + usage.system[1];
            let took = Duration::from_micros(micros.max(0) as u64);
            let over = killed || took.as_secs_f64() > 0.98 * seconds as f64;
            return Ok(match status {
                0 => (End::Passed, took),
                _ if over => (End::TimedOut, took),
                _ => (End::Failed, took),
            });
        }
        if found < 0 {
            bail!("a test program was lost");
        }
        if !killed && begun.elapsed() > Duration::from_secs(30 * seconds) {
            child.kill()?;
            killed = true;
        }
        std::thread::sleep(pause);
        pause = (2 * pause).min(Duration::from_millis(4));
    }
}
