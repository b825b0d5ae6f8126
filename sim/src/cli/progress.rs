//! Progress of long work, on a terminal only.

use indicatif::{ProgressBar, ProgressStyle};

/// Runs `work` with a bar that its callback moves: steps done, of how many.
pub fn with_bar<R>(title: &str, work: impl FnOnce(&(dyn Fn(usize, usize) + Sync)) -> R) -> R {
    // Drawn on standard error; hidden where that is not a terminal.
    let bar = ProgressBar::new(1).with_message(title.to_owned());
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    let result = work(&|done, total| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    result
}
