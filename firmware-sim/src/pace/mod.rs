//! Runs the simulated servo cycle at its real rate, with the real-time facilities that the host permits.

use std::{fmt, ops::ControlFlow, thread};

#[cfg(target_os = "linux")]
mod linux;
#[cfg(any(test, not(target_os = "linux")))]
mod portable;

#[cfg(target_os = "linux")]
use linux::Host;
#[cfg(not(target_os = "linux"))]
use portable::Host;

/// Settings of a paced run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pace {
    /// Servo period in ns; 0 counts as 1.
    pub period_ns: u64,
    /// Delay after the deadline above which a wake-up counts as late, in ns.
    pub late_after_ns: u64,
    /// Requested priority under `SCHED_FIFO`, 1 to 99; by default below the kernel's own threads at 99.
    pub priority: u8,
    /// Core to run on; `None` selects the last core this process may use, since interrupts tend to be served on the first.
    pub core: Option<usize>,
}

impl Pace {
    /// Default pace for a servo period: late after a tenth of it, priority 80, last core.
    #[must_use]
    pub const fn new(period_ns: u64) -> Self {
        Self { period_ns, late_after_ns: period_ns / 10, priority: 80, core: None }
    }
}

/// A real-time facility requested from the host, and the host's answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Permission {
    /// The requested facility, e.g. `SCHED_FIFO priority 80`.
    pub means: String,
    /// `None` if permitted and in force; otherwise the host's reason, with the error number's text.
    pub refused: Option<String>,
}

impl fmt::Display for Permission {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.refused {
            None => write!(f, "{}: permitted", self.means),
            Some(reason) => write!(f, "{}: not permitted ({reason})", self.means),
        }
    }
}

/// Real-time facilities of a paced run, and its punctuality.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PaceReport {
    /// Each real-time facility and whether it was permitted.
    pub permissions: Vec<Permission>,
    /// Servo period in ns.
    pub period_ns: u64,
    /// Cycles run.
    pub cycles: u64,
    /// Cycles that began more than `late_after_ns` after their deadline.
    pub late: u64,
    /// Whole periods without a cycle, because the previous one had not returned or the host did not wake the thread.
    pub skipped_periods: u64,
    /// Longest delay between a deadline and the start of its cycle, in ns.
    pub worst_wake_ns: u64,
}

impl PaceReport {
    /// One line per real-time facility and one on punctuality, for a console or the report's notes.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let punctuality = format!(
            "paced at {} ns: {} cycles, {} late wake-ups, {} periods skipped, latest wake-up {} ns after its deadline",
            self.period_ns, self.cycles, self.late, self.skipped_periods, self.worst_wake_ns
        );
        self.permissions.iter().map(Permission::to_string).chain([punctuality]).collect()
    }
}

/// Host services that pacing needs.
trait Clock {
    /// Requests the real-time facilities, on the thread that will run the cycle.
    fn prepare(&mut self, pace: &Pace) -> Vec<Permission>;
    /// Monotonic time in ns.
    fn now_ns(&self) -> u64;
    /// Sleeps until the monotonic time `deadline_ns`; returns at once if it is past.
    fn sleep_until_ns(&self, deadline_ns: u64);
}

/// Calls `cycle` with 0, 1, 2 … once per period until it breaks, and reports the punctuality.
///
/// Deadlines are absolute, `t0 + k·period`, so that no drift accumulates. Every cycle is run: if a whole period has passed,
/// the following deadlines are moved by whole periods, which count as skipped. The cycle runs on a separate thread, so that
/// priority and core binding end with it. The memory in use at the start is locked (allocate before) and is unlocked
/// afterwards. A refusal by the host is not an error.
pub fn run<F>(pace: &Pace, cycle: F) -> PaceReport
where
    F: FnMut(u64) -> ControlFlow<()> + Send,
{
    thread::scope(|scope| match scope.spawn(|| run_here(Host::new(), pace, cycle)).join() {
        Ok(report) => report,
        Err(panic) => std::panic::resume_unwind(panic),
    })
}

fn run_here<C: Clock>(mut clock: C, pace: &Pace, mut cycle: impl FnMut(u64) -> ControlFlow<()>) -> PaceReport {
    let permissions = clock.prepare(pace);
    let period_ns = pace.period_ns.max(1);
    let mut report = PaceReport { permissions, period_ns, cycles: 0, late: 0, skipped_periods: 0, worst_wake_ns: 0 };
    let mut deadline_ns = clock.now_ns().saturating_add(period_ns);
    loop {
        clock.sleep_until_ns(deadline_ns);
        let wake_ns = clock.now_ns().saturating_sub(deadline_ns);
        report.worst_wake_ns = report.worst_wake_ns.max(wake_ns);
        report.late += u64::from(wake_ns > pace.late_after_ns);
        let skipped = wake_ns / period_ns;
        report.skipped_periods += skipped;

        let flow = cycle(report.cycles);
        report.cycles += 1;
        if flow.is_break() {
            return report;
        }
        deadline_ns = deadline_ns.saturating_add((skipped + 1).saturating_mul(period_ns));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    /// A host whose clock is driven by the test: a sleep ends `wake_late_ns` after the deadline.
    struct Scripted<'a> {
        now_ns: &'a RefCell<u64>,
        wake_late_ns: u64,
    }

    impl Clock for Scripted<'_> {
        fn prepare(&mut self, _: &Pace) -> Vec<Permission> {
            Vec::new()
        }
        fn now_ns(&self) -> u64 {
            *self.now_ns.borrow()
        }
        fn sleep_until_ns(&self, deadline_ns: u64) {
            let mut now = self.now_ns.borrow_mut();
            *now = (*now).max(deadline_ns + self.wake_late_ns);
        }
    }

    fn after(last: u64) -> impl Fn(u64) -> ControlFlow<()> {
        move |k| if k == last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    #[test]
    fn punctual_cycles_do_not_drift() {
        let now = RefCell::new(5_000);
        let host = Scripted { now_ns: &now, wake_late_ns: 70 };
        let report = run_here(host, &Pace::new(1_000), after(99));
        assert_eq!((report.cycles, report.late, report.skipped_periods, report.worst_wake_ns), (100, 0, 0, 70));
        assert_eq!(*now.borrow(), 5_000 + 100 * 1_000 + 70, "lateness must not add up");
    }

    #[test]
    fn a_late_wake_up_is_counted() {
        let now = RefCell::new(0);
        let host = Scripted { now_ns: &now, wake_late_ns: 101 };
        assert_eq!(run_here(host, &Pace::new(1_000), after(9)).late, 10);
    }

    #[test]
    fn an_overrun_skips_whole_periods_and_keeps_the_phase() {
        let now = RefCell::new(0);
        let host = Scripted { now_ns: &now, wake_late_ns: 0 };
        let mut begun = Vec::new();
        let report = run_here(host, &Pace::new(1_000), |k| {
            begun.push(*now.borrow());
            *now.borrow_mut() += if k == 1 { 3_400 } else { 10 };
            after(3)(k)
        });
        // Cycle 1 begins at 2 000 and returns at 5 400: deadline 3 000 is met 2 400 late, the next deadline is 6 000.
        assert_eq!(begun, [1_000, 2_000, 5_400, 6_000]);
        assert_eq!((report.late, report.skipped_periods, report.worst_wake_ns), (1, 2, 2_400));
    }

    /// The kernel withholds the processor for 100 ms at 10 kHz, twice: each time a thousand periods are skipped and not made
    /// up for; the next cycle begins a period later, on the original grid.
    #[test]
    fn a_stall_of_100_ms_is_followed_by_no_burst() {
        const STALL_NS: u64 = 100_000_000;
        let now = RefCell::new(0);
        let host = Scripted { now_ns: &now, wake_late_ns: 0 };
        let mut begun = Vec::new();
        let report = run_here(host, &Pace::new(100_000), |k| {
            begun.push(*now.borrow());
            *now.borrow_mut() += if k == 5 || k == 20 { STALL_NS } else { 2_000 };
            after(39)(k)
        });
        assert_eq!((report.cycles, report.late, report.skipped_periods), (40, 2, 2 * 999));
        assert_eq!(report.worst_wake_ns, STALL_NS - 100_000);
        let gaps: Vec<u64> = begun.windows(2).map(|pair| pair[1] - pair[0]).collect();
        for (k, gap) in gaps.iter().enumerate() {
            let needed = if k == 5 || k == 20 { STALL_NS } else { 100_000 };
            assert_eq!(*gap, needed, "after cycle {k}");
        }
        assert_eq!(begun.last().unwrap() % 100_000, 0, "the phase does not change");
    }

    #[test]
    fn on_this_host_the_rate_is_kept_on_average() {
        let start = std::time::Instant::now();
        let report = run(&Pace::new(1_000_000), after(49));
        assert_eq!(report.cycles, 50);
        assert!(start.elapsed().as_millis() >= 50, "fifty periods of a millisecond took {:?}", start.elapsed());
        assert_eq!(report.permissions.len(), 3);
        for permission in &report.permissions {
            let line = permission.to_string();
            assert!(line.ends_with(": permitted") || line.contains(": not permitted ("), "{line}");
        }
        assert_eq!(report.notes().len(), 4);
    }

    #[test]
    fn the_portable_clock_keeps_the_rate_too() {
        let start = std::time::Instant::now();
        let report = run_here(portable::Host::new(), &Pace::new(1_000_000), after(9));
        assert!(start.elapsed().as_millis() >= 10);
        assert!(report.permissions.iter().all(|permission| permission.refused.is_some()));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_core_that_does_not_exist_is_refused_with_the_reason() {
        let report = run(&Pace { core: Some(1_000), ..Pace::new(100_000) }, after(0));
        let pinned = report.permissions.iter().find(|permission| permission.means.contains("core")).unwrap();
        assert!(pinned.refused.as_deref().is_some_and(|reason| reason.contains("Invalid argument")), "{pinned}");
    }
}
