//! Work on a stated number of threads.

use crate::error::RenderError;

/// Runs `work` on this many threads; `None` uses all processors.
///
/// # Errors
/// [`RenderError::Threads`] if they cannot be started.
pub fn on_threads<R: Send>(threads: Option<usize>, work: impl FnOnce() -> R + Send) -> Result<R, RenderError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()?;
    Ok(pool.install(work))
}
