//! Rows in pieces of so many elements, and their ends: fewer elements than lanes.

#![expect(
    unsafe_code,
    reason = "one comparison a piece, where a slice's own checks make two that cannot be hoisted"
)]

/// `N` elements of a row, if it has them.
#[inline(always)]
pub fn chunk<T, const N: usize>(row: &[T], at: usize) -> Option<&[T; N]> {
    // SAFETY: `at + N <= row.len()`.
    (at < row.len().saturating_sub(N - 1)).then(|| unsafe { &*row.as_ptr().add(at).cast() })
}

/// `N` elements of a row to write to, if it has them.
#[inline(always)]
pub fn chunk_mut<T, const N: usize>(row: &mut [T], at: usize) -> Option<&mut [T; N]> {
    // SAFETY: `at + N <= row.len()`.
    (at < row.len().saturating_sub(N - 1)).then(|| unsafe { &mut *row.as_mut_ptr().add(at).cast() })
}

/// How many elements a row has from `at` on, where they are fewer than a chunk. What reads them must not be a call: the
/// compiler would keep no vector in a register across it.
#[inline(always)]
pub fn rest<T>(row: &[T], at: usize) -> usize {
    row.len().saturating_sub(at)
}
