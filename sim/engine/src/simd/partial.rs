//! Rows in pieces of so many elements, and their ends: fewer elements than lanes.

#![expect(
    unsafe_code,
    reason = "one comparison a piece, where a slice's own checks make two that cannot be hoisted"
)]

use std::any::TypeId;
use std::arch::x86_64::{
    __m128i, _bextr2_u32, _bextr2_u64, _mm_castpd_si128, _mm_castsi128_pd, _mm_loadh_pd, _mm_loadl_epi64,
};

use slicecast::composite::Unorm16;
use slicecast::table::Coding;

/// The values at the codes of two neighbouring samples, each with the next one behind it. Loads, not a gather, which takes
/// longer; the samples are loaded together.
///
/// # Safety
/// The processor has BMI1 and SSE2, and there are two samples.
#[inline(always)]
pub unsafe fn neighbours<const N: usize>(values: &[u32; N], samples: *const i32, coding: Coding) -> __m128i {
    const { assert!((N - 1).is_power_of_two()) };
    let code_bits = const { (N - 1).ilog2() };
    // SAFETY: there are two samples, in the order of x86-64.
    let pair = unsafe { samples.cast::<u64>().read_unaligned() };
    let pair = pair.wrapping_add(coding.offset as u64 * ((1 << 32) + 1));
    // With nothing above the code, as in depths of phi, a shift leaves it alone. The compiler answers this where lookups are made.
    let (first, second) = if code_bits + coding.bits == 32 {
        (pair as u32 >> coding.bits, pair >> (32 + coding.bits))
    } else {
        // SAFETY: the processor has BMI1.
        unsafe {
            (
                _bextr2_u32(pair as u32, (code_bits << 8) + coding.bits),
                _bextr2_u64(pair, u64::from((code_bits << 8) + 32 + coding.bits)),
            )
        }
    };
    let first = values.as_ptr().wrapping_add(first as usize);
    let second = values.as_ptr().wrapping_add(second as usize);
    // SAFETY: the processor has SSE2; behind the value of every code of so many bits there is one more.
    unsafe {
        let low = _mm_castsi128_pd(_mm_loadl_epi64(first.cast()));
        _mm_castpd_si128(_mm_loadh_pd(low, second.cast()))
    }
}

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

/// A number of which there are zeros, as many as any vector has lanes.
pub trait Zero: Copy + 'static {
    /// They.
    const ZEROS: &'static [Self; 32];
}

impl Zero for u16 {
    const ZEROS: &'static [Self; 32] = &[0; 32];
}

impl Zero for u32 {
    const ZEROS: &'static [Self; 32] = &[0; 32];
}

/// `N` elements of a row, if it has them; else zeros. Not a branch but a choice of places: a branch would part the operands of products
/// from them, which the compiler then makes of twice as wide numbers.
#[inline(always)]
pub fn chunk_or_zeros<T: Zero, const N: usize>(row: &[T], at: usize) -> &[T; N] {
    let inside = at < row.len().saturating_sub(N - 1);
    const { assert!(N <= 32) };
    let place = if inside {
        row.as_ptr().wrapping_add(at).cast()
    } else {
        T::ZEROS.as_ptr().cast()
    };
    // SAFETY: `at + N <= row.len()`, or the zeros.
    unsafe { &*place }
}

/// `N` elements of a row to write to, if it has them; else those of another, which is not read.
#[inline(always)]
pub fn chunk_mut_or<'a, const N: usize>(row: &'a mut [u16], at: usize, else_to: &'a mut [u16; N]) -> &'a mut [u16; N] {
    let inside = at < row.len().saturating_sub(N - 1);
    let place = if inside {
        row.as_mut_ptr().wrapping_add(at).cast()
    } else {
        std::ptr::from_mut(else_to)
    };
    // SAFETY: `at + N <= row.len()`, or the other row; both are borrowed to be written to.
    unsafe { &mut *place }
}

/// How many elements a row has from `at` on, where they are fewer than a chunk. What reads them must not be a call: the
/// compiler would keep no vector in a register across it.
#[inline(always)]
pub fn rest<T>(row: &[T], at: usize) -> usize {
    row.len().saturating_sub(at)
}

/// Whether an element is a number of 16 bits and nothing else: every pattern is a value, and it may be read and written
/// as the number.
#[inline(always)]
pub fn is_half<T: 'static>() -> bool {
    // Unorm16 is transparent.
    [TypeId::of::<u16>(), TypeId::of::<Unorm16>()].contains(&TypeId::of::<T>())
}

/// Whether an element is a number of 32 bits and nothing else.
#[inline(always)]
pub fn is_word<T: 'static>() -> bool {
    TypeId::of::<u32>() == TypeId::of::<T>()
}
