//! Sixteen lanes of 16 bits in AVX2.

use std::arch::asm;
use std::arch::x86_64::*;

use slicecast::lanes::{Halves, Lanes as _};

use super::{Avx2, SLIDING};
use crate::simd::partial::{chunk, chunk_mut, chunk_mut_or, chunk_or_zeros, rest};

/// Sixteen 16-bit lanes.
#[derive(Clone, Copy)]
pub struct Halves256(__m256i);

/// Elements `at ..` of a row, 0 behind its end. Fewer than eight are read as the end of the last eight.
#[inline(always)]
fn eight(row: &[u16], at: usize) -> __m128i {
    if let Some(lanes) = chunk::<_, 8>(row, at) {
        return avx2!(_mm_loadu_si128(lanes.as_ptr().cast()));
    }
    let rest = rest(row, at);
    match row.last_chunk::<8>() {
        Some(last) => avx2!({
            let down = _mm_loadu_si128(SLIDING[32 - 2 * (rest & 7)..][..16].as_ptr().cast());
            _mm_shuffle_epi8(_mm_loadu_si128(last.as_ptr().cast()), down)
        }),
        None => {
            let mut lanes = [0u16; 8];
            for (lane, element) in lanes.iter_mut().zip(row.get(at..).unwrap_or(&[])) {
                *lane = *element;
            }
            avx2!(_mm_loadu_si128(lanes.as_ptr().cast()))
        }
    }
}

/// Writes to elements `at ..` of a row, as far as it goes.
#[inline(always)]
fn store_eight(lanes: __m128i, row: &mut [u16], at: usize) {
    if let Some(place) = chunk_mut::<_, 8>(row, at) {
        return avx2!(_mm_storeu_si128(place.as_mut_ptr().cast(), lanes));
    }
    let rest = rest(row, at);
    match row.last_chunk_mut::<8>() {
        Some(last) => avx2!({
            let up = _mm_loadu_si128(SLIDING[2 * (rest & 7)..][..16].as_ptr().cast());
            let (moved, kept) = (_mm_shuffle_epi8(lanes, up), _mm_loadu_si128(last.as_ptr().cast()));
            _mm_storeu_si128(last.as_mut_ptr().cast(), _mm_blendv_epi8(moved, kept, up));
        }),
        None => {
            let mut elements = [0u16; 8];
            avx2!(_mm_storeu_si128(elements.as_mut_ptr().cast(), lanes));
            for (place, element) in row.get_mut(at..).unwrap_or(&mut []).iter_mut().zip(elements) {
                *place = element;
            }
        }
    }
}

/// A vector's components side by side, in 32 bits each: lanes 0 to 3, 8 to 11 in the first, the others in the second.
#[inline(always)]
fn pairs(a: __m256i, b: __m256i) -> [__m256i; 2] {
    avx2!([_mm256_unpacklo_epi16(a, b), _mm256_unpackhi_epi16(a, b)])
}

/// Two 16-bit numbers as one of 32 bits.
#[inline(always)]
fn both(low: i16, high: i16) -> __m256i {
    avx2!(_mm256_set1_epi32(i32::from(low as u16) | i32::from(high) << 16))
}

/// The upper halves of unsigned products. What the intrinsic becomes are products of 32 bits cut off, which the compiler knows again
/// as one instruction only while both factors are made in the same block as the product; behind a branch it widens them.
#[inline]
#[target_feature(enable = "avx2")]
fn upper(a: __m256i, b: __m256i) -> __m256i {
    let high;
    // SAFETY: an instruction of the features named, between registers.
    unsafe {
        asm!(
            "vpmulhuw {}, {}, {}",
            lateout(ymm_reg) high,
            in(ymm_reg) a,
            in(ymm_reg) b,
            options(pure, nomem, nostack, preserves_flags)
        );
    }
    high
}

impl Halves for Halves256 {
    type Shifts = [__m256i; 2];
    /// x and y, and z and 0, side by side.
    type Direction = [__m256i; 2];
    const COUNT: usize = 16;

    #[inline(always)]
    fn splat(bits: u16) -> Self {
        Self(avx2!(_mm256_set1_epi16(bits as i16)))
    }
    #[inline(always)]
    fn load<const WHOLE: bool>(row: &[u16], at: usize) -> Self {
        if WHOLE {
            let lanes = chunk_or_zeros::<_, 16>(row, at);
            return Self(avx2!(_mm256_loadu_si256(lanes.as_ptr().cast())));
        }
        match chunk::<_, 16>(row, at) {
            Some(lanes) => Self(avx2!(_mm256_loadu_si256(lanes.as_ptr().cast()))),
            None => {
                let (low, high) = (eight(row, at), eight(row, at.saturating_add(8)));
                Self(avx2!(_mm256_set_m128i(high, low)))
            }
        }
    }
    #[inline(always)]
    fn load_pairs<const N: usize>(row: &[u32; N], at: usize) -> [Self; 2] {
        let lanes = chunk_or_zeros::<_, 16>(row, at);
        avx2!({
            let first = _mm256_loadu_si256(lanes.as_ptr().cast());
            let second = _mm256_loadu_si256(lanes.as_ptr().add(8).cast());
            let lower = _mm256_set1_epi32(0xffff);
            let low = _mm256_packus_epi32(_mm256_and_si256(first, lower), _mm256_and_si256(second, lower));
            let high = _mm256_packus_epi32(_mm256_srli_epi32::<16>(first), _mm256_srli_epi32::<16>(second));
            [
                Self(_mm256_permute4x64_epi64::<0b11_01_10_00>(low)),
                Self(_mm256_permute4x64_epi64::<0b11_01_10_00>(high)),
            ]
        })
    }
    #[inline(always)]
    fn store<const WHOLE: bool>(self, row: &mut [u16], at: usize) {
        if WHOLE {
            let mut unread = [0; 16];
            let lanes = chunk_mut_or(row, at, &mut unread);
            return avx2!(_mm256_storeu_si256(lanes.as_mut_ptr().cast(), self.0));
        }
        match chunk_mut::<_, 16>(row, at) {
            Some(lanes) => avx2!(_mm256_storeu_si256(lanes.as_mut_ptr().cast(), self.0)),
            None => {
                store_eight(avx2!(_mm256_castsi256_si128(self.0)), row, at);
                store_eight(avx2!(_mm256_extracti128_si256::<1>(self.0)), row, at.saturating_add(8));
            }
        }
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(avx2!(_mm256_add_epi16(self.0, other.0)))
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(avx2!(_mm256_sub_epi16(self.0, other.0)))
    }
    #[inline(always)]
    fn plus_saturating(self, other: Self) -> Self {
        Self(avx2!(_mm256_adds_epu16(self.0, other.0)))
    }
    #[inline(always)]
    fn minus_saturating(self, other: Self) -> Self {
        Self(avx2!(_mm256_subs_epu16(self.0, other.0)))
    }
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        Self(avx2!(_mm256_sll_epi16(self.0, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        Self(avx2!(_mm256_srl_epi16(self.0, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn shr_signed(self, by: u32) -> Self {
        Self(avx2!(_mm256_sra_epi16(self.0, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn product_high(self, other: Self) -> Self {
        Self(avx2!(upper(self.0, other.0)))
    }
    #[inline(always)]
    fn product_low(self, other: Self) -> Self {
        Self(avx2!(_mm256_mullo_epi16(self.0, other.0)))
    }
    #[inline(always)]
    fn product_round(self, other: Self) -> Self {
        Self(avx2!(_mm256_mulhrs_epi16(self.0, other.0)))
    }
    #[inline(always)]
    fn product_plus(self, other: Self, offset: u16) -> Self {
        let (high, low) = (self.product_high(other).0, self.product_low(other).0);
        Self(avx2!({
            // The least lower half that carries; there are no unsigned comparisons.
            let least = _mm256_set1_epi16((!offset).wrapping_add(1) as i16);
            let carries = _mm256_cmpeq_epi16(_mm256_max_epu16(low, least), low);
            _mm256_sub_epi16(high, carries)
        }))
    }
    #[inline(always)]
    fn top_then_else(self, value: Self, other: Self) -> Self {
        Self(avx2!(_mm256_blendv_epi8(
            other.0,
            value.0,
            _mm256_srai_epi16::<15>(self.0)
        )))
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        Self(avx2!(_mm256_andnot_si256(
            _mm256_cmpeq_epi16(self.0, _mm256_setzero_si256()),
            value.0
        )))
    }
    #[inline(always)]
    fn at_least_or_zero(self, floor: Self) -> Self {
        Self(avx2!({
            let at_least = _mm256_cmpeq_epi16(_mm256_max_epu16(self.0, floor.0), self.0);
            _mm256_and_si256(at_least, self.0)
        }))
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        avx2!(_mm256_testz_si256(self.0, self.0)) != 0
    }
    #[inline(always)]
    fn count(self) -> usize {
        let [low, high] = widened(self.0);
        low.count() + high.count()
    }
    #[inline(always)]
    fn store_packed(self, chosen: Self, row: &mut [u16], at: usize) -> usize {
        let mut place = at;
        for (lanes, chosen) in widened(self.0).into_iter().zip(widened(chosen.0)) {
            store_eight(narrowed(lanes.packed(chosen)), row, place);
            place += chosen.count();
        }
        place - at
    }
    #[inline(always)]
    fn load_spread(row: &[u16], at: usize, chosen: Self) -> Self {
        let [low, high] = widened(chosen.0);
        let first = Avx2(avx2!(_mm256_cvtepu16_epi32(eight(row, at)))).spread(low);
        let second = Avx2(avx2!(_mm256_cvtepu16_epi32(eight(row, at + low.count())))).spread(high);
        let (first, second) = (narrowed(zeroed(first, low)), narrowed(zeroed(second, high)));
        Self(avx2!(_mm256_set_m128i(second, first)))
    }
    #[inline(always)]
    fn normalised([x, y, z]: [Self; 3]) -> ([__m256i; 2], Self) {
        avx2!({
            let ([xy_low, xy_high], [z_low, z_high]) = (pairs(x.0, y.0), pairs(z.0, _mm256_setzero_si256()));
            let low = _mm256_add_epi32(_mm256_madd_epi16(xy_low, xy_low), _mm256_madd_epi16(z_low, z_low));
            let high = _mm256_add_epi32(_mm256_madd_epi16(xy_high, xy_high), _mm256_madd_epi16(z_high, z_high));
            let (k_low, h_low) = shifted(low);
            let (k_high, h_high) = shifted(high);
            ([k_low, k_high], Self(_mm256_packus_epi32(h_low, h_high)))
        })
    }
    #[inline(always)]
    fn direction([x, y, z]: [i16; 3]) -> [__m256i; 2] {
        [both(x, y), both(z, 0)]
    }
    #[inline(always)]
    fn facing([ax, ay, az]: [Self; 3], [xy, z]: [__m256i; 2], [k_low, k_high]: [__m256i; 2]) -> Self {
        avx2!({
            let ([xy_low, xy_high], [z_low, z_high]) = (pairs(ax.0, ay.0), pairs(az.0, _mm256_setzero_si256()));
            let low = _mm256_add_epi32(_mm256_madd_epi16(xy_low, xy), _mm256_madd_epi16(z_low, z));
            let high = _mm256_add_epi32(_mm256_madd_epi16(xy_high, xy), _mm256_madd_epi16(z_high, z));
            Self(_mm256_packus_epi32(rounded(low, k_low), rounded(high, k_high)))
        })
    }
}

/// The lower and the upper lanes in 32 bits each.
#[inline(always)]
fn widened(lanes: __m256i) -> [Avx2; 2] {
    avx2!([
        Avx2(_mm256_cvtepu16_epi32(_mm256_castsi256_si128(lanes))),
        Avx2(_mm256_cvtepu16_epi32(_mm256_extracti128_si256::<1>(lanes))),
    ])
}

/// Eight lanes below 2^16 in 16 bits each.
#[inline(always)]
fn narrowed(lanes: Avx2) -> __m128i {
    avx2!(_mm_packus_epi32(
        _mm256_castsi256_si128(lanes.0),
        _mm256_extracti128_si256::<1>(lanes.0)
    ))
}

/// Lanes where others are not 0, else 0.
#[inline(always)]
fn zeroed(lanes: Avx2, others: Avx2) -> Avx2 {
    others.nonzero_then(lanes)
}

/// The shift of a squared length, and the upper half of the length shifted.
#[inline(always)]
fn shifted(square: __m256i) -> (__m256i, __m256i) {
    let zeros = Avx2(square).leading_zeros().0;
    avx2!({
        // 16 where there is no length, and nothing to be shifted.
        let k = _mm256_srli_epi32::<1>(zeros);
        let shifted = _mm256_sllv_epi32(square, _mm256_add_epi32(k, k));
        (k, _mm256_srli_epi32::<16>(shifted))
    })
}

/// A product shifted left by k, and right by 15, to nearest.
#[inline(always)]
fn rounded(dot: __m256i, k: __m256i) -> __m256i {
    avx2!({
        let shifted = _mm256_add_epi32(_mm256_sllv_epi32(dot, k), _mm256_set1_epi32(1 << 14));
        _mm256_srai_epi32::<15>(shifted)
    })
}
