//! Work on a stated number of threads.

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::RenderError;

/// Runs `work` on this many threads; `None` uses all processors.
///
/// # Errors
/// [`RenderError::Threads`] if they cannot be started.
pub fn on_threads<R: Send>(threads: Option<usize>, work: impl FnOnce() -> R + Send) -> Result<R, RenderError> {
    let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build()?;
    let (mut work, mut done) = (Some(work), None);
    run(&pool, &mut || done = work.take().map(|work| work()));
    Ok(done.unwrap_or_else(|| unreachable!("a pool runs what it is given")))
}

/// Apart, so that entering a pool is compiled once for all kinds of work.
fn run(pool: &ThreadPool, work: &mut (dyn FnMut() + Send)) {
    pool.install(work);
}
