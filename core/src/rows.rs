//! Parts of rows without a panic: a range that does not fit gives nothing.

use core::ops::Range;

/// Part of a row.
#[inline(always)]
pub(crate) fn part<W>(row: &[W], range: Range<usize>) -> &[W] {
    row.get(range).unwrap_or(&[])
}

/// Part of a row, to write to.
#[inline(always)]
pub(crate) fn part_mut<W>(row: &mut [W], range: Range<usize>) -> &mut [W] {
    row.get_mut(range).unwrap_or(&mut [])
}

/// What `[T; 3]::map` makes, without its loop: a pipeline is compiled many times, and that loop was a quarter of what the
/// compiler had to work on.
#[inline(always)]
pub(crate) fn three<T, U>([a, b, c]: [T; 3], mut each: impl FnMut(T) -> U) -> [U; 3] {
    [each(a), each(b), each(c)]
}

/// The same of two.
#[inline(always)]
pub(crate) fn two<T, U>([a, b]: [T; 2], mut each: impl FnMut(T) -> U) -> [U; 2] {
    [each(a), each(b)]
}

/// The same of four.
#[inline(always)]
pub(crate) fn four<T, U>([a, b, c, d]: [T; 4], mut each: impl FnMut(T) -> U) -> [U; 4] {
    [each(a), each(b), each(c), each(d)]
}

/// Cuts the first `len` elements off a buffer.
#[inline]
pub(crate) fn take<'a, T>(rest: &mut &'a mut [T], len: usize) -> &'a mut [T] {
    let (head, tail) = core::mem::take(rest)
        .split_at_mut_checked(len)
        .unwrap_or((&mut [], &mut []));
    *rest = tail;
    head
}
