//! Times of one processor.

use std::time::Duration;

/// What a processor has worked for this thread; other programs on the machine do not count.
#[cfg(target_os = "linux")]
pub fn worked() -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    let now = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(now.tv_sec as u64, now.tv_nsec as u32)
}

/// The time since the first call, other programs' shares included.
#[cfg(not(target_os = "linux"))]
pub fn worked() -> Duration {
    static BEGIN: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    BEGIN.get_or_init(std::time::Instant::now).elapsed()
}

/// Does something on one thread, whatever shares its work: how well tiles share the processors is another question.
pub fn one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.unwrap_or_else(|error| unreachable!("a pool of one thread: {error}"));
    pool.install(work)
}
