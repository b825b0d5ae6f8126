//! What the library says of damaged files.

use super::NAME;
use crate::error::Problem;

/// The library's message as a fault.
pub(super) fn damaged(error: tiff::TiffError) -> Problem {
    Problem::format(NAME, shorten_line(&error.to_string()))
}

/// One line.
fn shorten_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().chars().take(200).collect()
}
