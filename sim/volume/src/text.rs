//! Text in files, and pieces of files as they appear in messages.

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

/// Text that is UTF-8 or, where it is not, Latin-1, and whether it was Latin-1.
pub(super) fn decode(bytes: &[u8]) -> (String, bool) {
    match str::from_utf8(bytes) {
        Ok(text) => (text.to_owned(), false),
        Err(_) => (bytes.iter().map(|&byte| char::from(byte)).collect(), true),
    }
}

/// A number for a message: with an exponent where its digits would fill a line.
pub(super) fn number(value: f64) -> String {
    let digits = value.to_string();
    if digits.len() > 20 {
        format!("{value:e}")
    } else {
        digits
    }
}
