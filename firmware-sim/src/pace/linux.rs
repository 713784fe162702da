//! `clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME)`, `SCHED_FIFO`, `mlockall` and core affinity.

use std::io;

use rustix::{
    mm::{MlockAllFlags, mlockall, munlockall},
    thread::{CpuSet, clock_nanosleep_absolute, sched_getaffinity, sched_setaffinity},
    time::{ClockId, Timespec, clock_gettime},
};
use thread_priority::{
    RealtimeThreadSchedulePolicy::Fifo, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy::Realtime,
    set_thread_priority_and_policy, thread_native_id,
};

use super::{Clock, Pace, Permission};

const NS_PER_S: u64 = 1_000_000_000;

/// The Linux host; unlocks the memory when dropped.
pub(super) struct Host {
    locked: bool,
}

impl Host {
    pub(super) const fn new() -> Self {
        Self { locked: false }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        if self.locked {
            // A failure has no consequence: the memory merely stays locked until the process ends.
            let _ = munlockall();
        }
    }
}

impl Clock for Host {
    fn prepare(&mut self, pace: &Pace) -> Vec<Permission> {
        // Not MCL_FUTURE: an unprivileged process would then be refused ordinary allocations at its lock limit.
        let lock = mlockall(MlockAllFlags::CURRENT);
        self.locked = lock.is_ok();
        let (core, pinned) = pin(pace.core);
        vec![
            permission(format!("SCHED_FIFO priority {}", pace.priority), fifo(pace.priority)),
            permission("mlockall of the memory in use".to_owned(), lock.map_err(|errno| errno.to_string())),
            permission(format!("pinned to {core}"), pinned),
        ]
    }

    fn now_ns(&self) -> u64 {
        let time = clock_gettime(ClockId::Monotonic);
        u64::try_from(time.tv_sec).unwrap_or(0) * NS_PER_S + u64::try_from(time.tv_nsec).unwrap_or(0)
    }

    fn sleep_until_ns(&self, deadline_ns: u64) {
        let request =
            Timespec { tv_sec: (deadline_ns / NS_PER_S).cast_signed(), tv_nsec: (deadline_ns % NS_PER_S) as _ };
        // A signal interrupts the sleep; the deadline is absolute, so repeating the call is enough.
        while clock_nanosleep_absolute(ClockId::Monotonic, &request) == Err(rustix::io::Errno::INTR) {}
    }
}

fn permission(means: String, answer: Result<(), String>) -> Permission {
    Permission { means, refused: answer.err() }
}

fn fifo(priority: u8) -> Result<(), String> {
    let value = ThreadPriorityValue::try_from(priority)?;
    set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Crossplatform(value), Realtime(Fifo)).map_err(
        |error| match error {
            thread_priority::Error::OS(errno) => io::Error::from_raw_os_error(errno).to_string(),
            other => other.to_string(),
        },
    )
}

/// Binds the thread to `core`, or to the last permitted core; returns the request and the host's answer.
fn pin(core: Option<usize>) -> (String, Result<(), String>) {
    let permitted = match sched_getaffinity(None) {
        Ok(set) => set,
        Err(errno) => return ("one core".to_owned(), Err(errno.to_string())),
    };
    let last = (0..CpuSet::MAX_CPU).rev().find(|&cpu| permitted.is_set(cpu)).unwrap_or(0);
    let core = core.unwrap_or(last);
    let mut set = CpuSet::new();
    if core < CpuSet::MAX_CPU {
        set.set(core);
    }
    (format!("core {core}"), sched_setaffinity(None, &set).map_err(|errno| errno.to_string()))
}
