//! Names of files in messages.

use std::path::Path;

use crate::text::shorten;

/// Names of files that a note or message lists.
const LISTED: usize = 3;

/// The first few words, and how many more there are.
pub(super) fn list(words: impl ExactSizeIterator<Item = String>) -> String {
    let more = words.len().saturating_sub(LISTED);
    let mut shown: Vec<String> = words.take(LISTED).collect();
    if more > 0 {
        shown.push(format!("and {more} more"));
    }
    shown.join(", ")
}

/// A file's name as it appears in messages.
pub(super) fn file_name(path: &Path) -> String {
    shorten(&path.file_name().unwrap_or_default().to_string_lossy())
}
