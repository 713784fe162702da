//! Runs work that the product spreads over all cores on the calling thread.

use rayon::{ThreadPool, ThreadPoolBuilder};

thread_local! {
    static ALONE: ThreadPool =
        ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().expect("a pool of this thread");
}

/// Runs `work` on this thread only: handing so little of it to another thread costs more than the work.
pub fn alone<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    ALONE.with(|pool| pool.install(work))
}
