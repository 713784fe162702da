//! Pacing with only the standard library: a monotonic clock and an ordinary sleep.

use std::{
    thread,
    time::{Duration, Instant},
};

use super::{Clock, Pace, Permission};

/// A host without real-time facilities.
pub(super) struct Host {
    start: Instant,
}

impl Host {
    pub(super) fn new() -> Self {
        Self { start: Instant::now() }
    }
}

impl Clock for Host {
    fn prepare(&mut self, _: &Pace) -> Vec<Permission> {
        ["real-time scheduling", "locked memory", "pinned core"]
            .map(|means| Permission {
                means: means.to_owned(),
                refused: Some("not implemented for this operating system".to_owned()),
            })
            .into()
    }

    fn now_ns(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    fn sleep_until_ns(&self, deadline_ns: u64) {
        thread::sleep(Duration::from_nanos(deadline_ns.saturating_sub(self.now_ns())));
    }
}
