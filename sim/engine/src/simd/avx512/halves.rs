//! Thirty-two lanes of 16 bits in AVX-512.

use std::arch::asm;
use std::arch::x86_64::*;

use slicecast::lanes::Halves;

use super::{ones, words};
use crate::simd::partial::{chunk, chunk_mut, chunk_mut_or, chunk_or_zeros, rest};

/// Thirty-two 16-bit lanes.
#[derive(Clone, Copy)]
pub struct Halves512(__m512i);

/// A vector's components side by side, in 32 bits each: lanes 0 to 3, 8 to 11 .. in the first, the others in the second.
#[inline(always)]
fn pairs(a: __m512i, b: __m512i) -> [__m512i; 2] {
    avx512!([_mm512_unpacklo_epi16(a, b), _mm512_unpackhi_epi16(a, b)])
}

/// Two 16-bit numbers as one of 32 bits.
#[inline(always)]
fn both(low: i16, high: i16) -> __m512i {
    avx512!(_mm512_set1_epi32(i32::from(low as u16) | i32::from(high) << 16))
}

/// The upper halves of unsigned products. What the intrinsic becomes are products of 32 bits cut off, which the compiler knows again
/// as one instruction only while both factors are made in the same block as the product; behind a branch it widens them.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn upper(a: __m512i, b: __m512i) -> __m512i {
    let high;
    // SAFETY: an instruction of the features named, between registers.
    unsafe {
        asm!(
            "vpmulhuw {}, {}, {}",
            lateout(zmm_reg) high,
            in(zmm_reg) a,
            in(zmm_reg) b,
            options(pure, nomem, nostack, preserves_flags)
        );
    }
    high
}

impl Halves for Halves512 {
    type Shifts = [__m512i; 2];
    /// x and y, and z and 0, side by side.
    type Direction = [__m512i; 2];
    const COUNT: usize = 32;

    #[inline(always)]
    fn splat(bits: u16) -> Self {
        Self(avx512!(_mm512_set1_epi16(bits as i16)))
    }
    #[inline(always)]
    fn load<const WHOLE: bool>(row: &[u16], at: usize) -> Self {
        if WHOLE {
            let lanes = chunk_or_zeros::<_, 32>(row, at);
            return Self(avx512!(_mm512_loadu_si512(lanes.as_ptr().cast())));
        }
        match chunk::<_, 32>(row, at) {
            Some(lanes) => Self(avx512!(_mm512_loadu_si512(lanes.as_ptr().cast()))),
            None => {
                let first = row.as_ptr().wrapping_add(at).cast();
                Self(avx512!(_mm512_maskz_loadu_epi16(ones(rest(row, at)), first)))
            }
        }
    }
    #[inline(always)]
    fn load_pairs<const N: usize>(row: &[u32; N], at: usize) -> [Self; 2] {
        let lanes = chunk_or_zeros::<_, 32>(row, at);
        avx512!({
            let first = _mm512_loadu_si512(lanes.as_ptr().cast());
            let second = _mm512_loadu_si512(lanes.as_ptr().add(16).cast());
            [
                Self(_mm512_permutex2var_epi16(first, words::<0>(), second)),
                Self(_mm512_permutex2var_epi16(first, words::<1>(), second)),
            ]
        })
    }
    #[inline(always)]
    fn store<const WHOLE: bool>(self, row: &mut [u16], at: usize) {
        if WHOLE {
            let mut unread = [0; 32];
            let lanes = chunk_mut_or(row, at, &mut unread);
            return avx512!(_mm512_storeu_si512(lanes.as_mut_ptr().cast(), self.0));
        }
        match chunk_mut::<_, 32>(row, at) {
            Some(lanes) => avx512!(_mm512_storeu_si512(lanes.as_mut_ptr().cast(), self.0)),
            None => {
                let (first, mask) = (row.as_mut_ptr().wrapping_add(at).cast(), ones(rest(row, at)));
                avx512!(_mm512_mask_storeu_epi16(first, mask, self.0));
            }
        }
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(avx512!(_mm512_add_epi16(self.0, other.0)))
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(avx512!(_mm512_sub_epi16(self.0, other.0)))
    }
    #[inline(always)]
    fn plus_saturating(self, other: Self) -> Self {
        Self(avx512!(_mm512_adds_epu16(self.0, other.0)))
    }
    #[inline(always)]
    fn minus_saturating(self, other: Self) -> Self {
        Self(avx512!(_mm512_subs_epu16(self.0, other.0)))
    }
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        Self(avx512!(_mm512_sll_epi16(self.0, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        Self(avx512!(_mm512_srl_epi16(self.0, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn shr_signed(self, by: u32) -> Self {
        Self(avx512!(_mm512_sra_epi16(self.0, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn product_high(self, other: Self) -> Self {
        Self(avx512!(upper(self.0, other.0)))
    }
    #[inline(always)]
    fn product_low(self, other: Self) -> Self {
        Self(avx512!(_mm512_mullo_epi16(self.0, other.0)))
    }
    #[inline(always)]
    fn product_round(self, other: Self) -> Self {
        Self(avx512!(_mm512_mulhrs_epi16(self.0, other.0)))
    }
    #[inline(always)]
    fn product_plus(self, other: Self, offset: u16) -> Self {
        let (high, low) = (self.product_high(other).0, self.product_low(other).0);
        Self(avx512!({
            let carries = _mm512_cmpgt_epu16_mask(low, _mm512_set1_epi16(!offset as i16));
            _mm512_mask_sub_epi16(high, carries, high, _mm512_set1_epi16(-1))
        }))
    }
    #[inline(always)]
    fn top_then_else(self, value: Self, other: Self) -> Self {
        Self(avx512!(_mm512_mask_mov_epi16(
            other.0,
            _mm512_movepi16_mask(self.0),
            value.0
        )))
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        Self(avx512!(_mm512_maskz_mov_epi16(
            _mm512_test_epi16_mask(self.0, self.0),
            value.0
        )))
    }
    #[inline(always)]
    fn at_least_or_zero(self, floor: Self) -> Self {
        Self(avx512!(_mm512_maskz_mov_epi16(
            _mm512_cmpge_epu16_mask(self.0, floor.0),
            self.0
        )))
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        avx512!(_mm512_test_epi16_mask(self.0, self.0)) == 0
    }
    #[inline(always)]
    fn count(self) -> usize {
        avx512!(_mm512_test_epi16_mask(self.0, self.0)).count_ones() as usize
    }
    /// By lanes of 32 bits: those of 16 are packed by later processors only.
    #[inline(always)]
    fn store_packed(self, chosen: Self, row: &mut [u16], at: usize) -> usize {
        let mask = avx512!(_mm512_test_epi16_mask(chosen.0, chosen.0));
        let mut place = at;
        for (lanes, mask) in widened(self.0).into_iter().zip([mask as u16, (mask >> 16) as u16]) {
            let packed = avx512!(_mm512_cvtepi32_epi16(_mm512_maskz_compress_epi32(mask, lanes)));
            let first = row.as_mut_ptr().wrapping_add(place).cast();
            let inside = inside(row, place, mask.count_ones());
            avx512!(_mm256_mask_storeu_epi16(first, inside, packed));
            place += mask.count_ones() as usize;
        }
        place - at
    }
    #[inline(always)]
    fn load_spread(row: &[u16], at: usize, chosen: Self) -> Self {
        let mask = avx512!(_mm512_test_epi16_mask(chosen.0, chosen.0));
        let (low, high) = (mask as u16, (mask >> 16) as u16);
        let (low, high) = (spread(row, at, low), spread(row, at + low.count_ones() as usize, high));
        Self(avx512!(_mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high)))
    }
    #[inline(always)]
    fn normalised([x, y, z]: [Self; 3]) -> ([__m512i; 2], Self) {
        avx512!({
            let ([xy_low, xy_high], [z_low, z_high]) = (pairs(x.0, y.0), pairs(z.0, _mm512_setzero_si512()));
            let low = _mm512_add_epi32(_mm512_madd_epi16(xy_low, xy_low), _mm512_madd_epi16(z_low, z_low));
            let high = _mm512_add_epi32(_mm512_madd_epi16(xy_high, xy_high), _mm512_madd_epi16(z_high, z_high));
            let (k_low, h_low) = shifted(low);
            let (k_high, h_high) = shifted(high);
            ([k_low, k_high], Self(_mm512_packus_epi32(h_low, h_high)))
        })
    }
    #[inline(always)]
    fn direction([x, y, z]: [i16; 3]) -> [__m512i; 2] {
        [both(x, y), both(z, 0)]
    }
    #[inline(always)]
    fn facing([ax, ay, az]: [Self; 3], [xy, z]: [__m512i; 2], [k_low, k_high]: [__m512i; 2]) -> Self {
        avx512!({
            let ([xy_low, xy_high], [z_low, z_high]) = (pairs(ax.0, ay.0), pairs(az.0, _mm512_setzero_si512()));
            let low = _mm512_add_epi32(_mm512_madd_epi16(xy_low, xy), _mm512_madd_epi16(z_low, z));
            let high = _mm512_add_epi32(_mm512_madd_epi16(xy_high, xy), _mm512_madd_epi16(z_high, z));
            Self(_mm512_packus_epi32(rounded(low, k_low), rounded(high, k_high)))
        })
    }
}

/// A bit for each of so many elements `place ..` that a row has.
#[inline(always)]
fn inside(row: &[u16], place: usize, count: u32) -> u16 {
    ((1u32 << (count as usize).min(rest(row, place))) - 1) as u16
}

/// Elements `place ..` of a row in the lanes of a mask, one after the other.
#[inline(always)]
fn spread(row: &[u16], place: usize, mask: u16) -> __m256i {
    let first = row.as_ptr().wrapping_add(place).cast();
    let inside = inside(row, place, mask.count_ones());
    avx512!({
        let packed = _mm512_cvtepu16_epi32(_mm256_maskz_loadu_epi16(inside, first));
        _mm512_cvtepi32_epi16(_mm512_maskz_expand_epi32(mask, packed))
    })
}

/// The lower and the upper lanes in 32 bits each.
#[inline(always)]
fn widened(lanes: __m512i) -> [__m512i; 2] {
    avx512!([
        _mm512_cvtepu16_epi32(_mm512_castsi512_si256(lanes)),
        _mm512_cvtepu16_epi32(_mm512_extracti64x4_epi64::<1>(lanes)),
    ])
}

/// The shift of a squared length, and the upper half of the length shifted.
#[inline(always)]
fn shifted(square: __m512i) -> (__m512i, __m512i) {
    avx512!({
        // 16 where there is no length, and nothing to be shifted.
        let k = _mm512_srli_epi32::<1>(_mm512_lzcnt_epi32(square));
        let shifted = _mm512_sllv_epi32(square, _mm512_add_epi32(k, k));
        (k, _mm512_srli_epi32::<16>(shifted))
    })
}

/// A product shifted left by k, and right by 15, to nearest.
#[inline(always)]
fn rounded(dot: __m512i, k: __m512i) -> __m512i {
    avx512!({
        let shifted = _mm512_add_epi32(_mm512_sllv_epi32(dot, k), _mm512_set1_epi32(1 << 14));
        _mm512_srai_epi32::<15>(shifted)
    })
}
