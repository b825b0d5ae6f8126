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

/// What a row has from `at` on, and zeros behind it.
#[cold]
#[inline(never)]
pub fn part<T: Copy + Default, const N: usize>(row: &[T], at: usize) -> [T; N] {
    let mut lanes = [T::default(); N];
    for (lane, element) in lanes.iter_mut().zip(row.get(at..).unwrap_or(&[])) {
        *lane = *element;
    }
    lanes
}

/// Writes as many lanes as the row has elements from `at` on.
#[cold]
#[inline(never)]
pub fn store_part<T: Copy>(row: &mut [T], at: usize, lanes: &[T]) {
    for (element, lane) in row.get_mut(at..).unwrap_or(&mut []).iter_mut().zip(lanes) {
        *element = *lane;
    }
}
