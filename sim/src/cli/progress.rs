//! Progress of long work, on standard error: a bar on a terminal, now and then a line elsewhere.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// How long work may go on without a line, where there is no bar.
const SILENCE: Duration = Duration::from_secs(10);

/// Runs `work` with a bar that its callback moves: steps done, of how many.
pub fn with_bar<R>(title: &str, work: impl FnOnce(&(dyn Fn(usize, usize) + Sync)) -> R) -> R {
    // Hidden where standard error is not a terminal.
    let bar = ProgressBar::new(1).with_message(title.to_owned());
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    let lines = bar.is_hidden().then(|| Lines::new(Instant::now()));
    let result = work(&|done, total| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
        if lines.as_ref().is_some_and(|lines| lines.is_due(Instant::now())) {
            eprintln!("{title}: {} %", 100 * done / total.max(1));
        }
    });
    bar.finish_and_clear();
    result
}

/// When the next line is due.
struct Lines {
    next: Mutex<Instant>,
}

impl Lines {
    fn new(now: Instant) -> Self {
        Self {
            next: Mutex::new(now + SILENCE),
        }
    }

    /// Whether a line is due now; then the next is due a silence later.
    fn is_due(&self, now: Instant) -> bool {
        // Another thread that is telling tells it for all.
        let Ok(mut next) = self.next.try_lock() else {
            return false;
        };
        let due = now >= *next;
        if due {
            *next = now + SILENCE;
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_due_once_a_silence() {
        let start = Instant::now();
        let lines = Lines::new(start);
        let due = |seconds| lines.is_due(start + Duration::from_secs(seconds));
        assert_eq!(
            [0, 9, 10, 11, 19, 20, 45, 46].map(due),
            [false, false, true, false, false, true, true, false]
        );
    }
}
