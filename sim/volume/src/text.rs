//! Pieces of files as they appear in messages.

/// A piece of a file for a message: at most 60 characters, and no control characters.
pub(super) fn shorten(text: &str) -> String {
    let shown: String = text.chars().take(60).flat_map(char::escape_debug).collect();
    if text.chars().nth(60).is_some() {
        shown + "…"
    } else {
        shown
    }
}

/// Bytes of a file for a message, shortened.
pub(super) fn shorten_bytes(bytes: &[u8]) -> String {
    let part = bytes.get(..60).unwrap_or(bytes);
    shorten(&String::from_utf8_lossy(part))
}
