//! Sixteen floats in AVX-512.

#![expect(unsafe_code, reason = "vector instructions; every use says why it is sound")]

use std::arch::x86_64::*;
use std::ops::{Add, Mul, Sub};

use slicecast::lanes::Kernel;
use slicecast::table::Neighboured;

use super::{AS_IT_IS, Floats};
use crate::simd::avx512::look_up;
use crate::simd::entry;
use crate::simd::partial::{chunk, chunk_mut, rest};

/// Sixteen floats. Of use only where the processor has AVX-512; see [`super::with_floats`].
#[derive(Clone, Copy)]
pub struct Avx512(__m512);

/// Calls an intrinsic of AVX-512.
macro_rules! avx512 {
    ($call:expr) => {
        // SAFETY: `with_floats` runs this code only on processors that have AVX-512 (F, BW, CD, DQ, VL) and BMI1;
        // pointers come from slices that are long enough (`chunk`), or a mask leaves out what the slice does not have.
        unsafe { $call }
    };
}

impl Add for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(avx512!(_mm512_add_ps(self.0, other.0)))
    }
}

impl Sub for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(avx512!(_mm512_sub_ps(self.0, other.0)))
    }
}

impl Mul for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(avx512!(_mm512_mul_ps(self.0, other.0)))
    }
}

/// As many low bits as there are elements, fewer than 16.
#[inline(always)]
fn ones(elements: usize) -> u16 {
    ((1u32 << (elements & 15)) - 1) as u16
}

#[inline(always)]
fn of_voxels(voxels: &[u16; 16]) -> Avx512 {
    Avx512(avx512!(_mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(_mm256_loadu_si256(
        voxels.as_ptr().cast()
    )))))
}

impl Avx512 {
    /// The lanes above 0, as bits.
    #[inline(always)]
    fn positive(self) -> __mmask16 {
        avx512!(_mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, _mm512_setzero_ps()))
    }
}

impl Floats for Avx512 {
    const COUNT: usize = 16;

    #[inline(always)]
    fn enter<K: Kernel>(kernel: K) -> K::Output {
        entry::avx512(kernel)
    }
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(avx512!(_mm512_set1_ps(value)))
    }
    #[inline(always)]
    fn load(row: &[f32], at: usize) -> Self {
        match chunk::<_, 16>(row, at) {
            Some(lanes) => Self(avx512!(_mm512_loadu_ps(lanes.as_ptr()))),
            None => Self(avx512!(_mm512_maskz_loadu_ps(
                ones(rest(row, at)),
                row.as_ptr().wrapping_add(at)
            ))),
        }
    }
    #[inline(always)]
    fn store(self, row: &mut [f32], at: usize) {
        match chunk_mut::<_, 16>(row, at) {
            Some(lanes) => avx512!(_mm512_storeu_ps(lanes.as_mut_ptr(), self.0)),
            None => {
                let (first, mask) = (row.as_mut_ptr().wrapping_add(at), ones(rest(row, at)));
                avx512!(_mm512_mask_storeu_ps(first, mask, self.0));
            }
        }
    }
    #[inline(always)]
    fn load_voxels(row: &[u16], at: usize) -> Self {
        match chunk::<_, 16>(row, at) {
            Some(lanes) => of_voxels(lanes),
            None => {
                let first = row.as_ptr().wrapping_add(at).cast();
                let voxels = avx512!(_mm256_maskz_loadu_epi16(ones(rest(row, at)), first));
                Self(avx512!(_mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(voxels))))
            }
        }
    }
    #[inline(always)]
    fn store_whole(self, row: &mut [i32], at: usize) {
        if let Some(codes) = chunk_mut::<_, 16>(row, at) {
            avx512!(_mm512_storeu_si512(
                codes.as_mut_ptr().cast(),
                _mm512_cvttps_epi32(self.0)
            ));
        }
    }
    #[inline(always)]
    fn load_whole(row: &[i32], at: usize) -> Self {
        let Some(codes) = chunk::<_, 16>(row, at) else {
            return Self::splat(0.0);
        };
        Self(avx512!(_mm512_cvtepi32_ps(_mm512_loadu_si512(codes.as_ptr().cast()))))
    }
    #[inline(always)]
    fn look_up(values: &Neighboured, codes: &[i32], at: usize) -> [Self; 2] {
        let Some(codes) = chunk::<_, 16>(codes, at) else {
            return [Self::splat(0.0); 2];
        };
        let [value, next] = look_up(values, codes, AS_IT_IS);
        avx512!([Self(_mm512_castsi512_ps(value)), Self(_mm512_castsi512_ps(next)),])
    }
    #[inline(always)]
    fn look_up_colours(entries: &Neighboured, codes: &[i32], at: usize) -> [[Self; 3]; 2] {
        let Some(codes) = chunk::<_, 16>(codes, at) else {
            return [[Self::splat(0.0); 3]; 2];
        };
        let [entry, next] = look_up(entries, codes, AS_IT_IS);
        [colours(entry), colours(next)]
    }
    #[inline(always)]
    fn followed_by(self, next: Self) -> Self {
        avx512!({
            let (this, next) = (_mm512_castps_si512(self.0), _mm512_castps_si512(next.0));
            Self(_mm512_castsi512_ps(_mm512_alignr_epi32::<1>(next, this)))
        })
    }
    #[inline(always)]
    fn times_plus(self, factor: Self, term: Self) -> Self {
        Self(avx512!(_mm512_fmadd_ps(self.0, factor.0, term.0)))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Self(avx512!(_mm512_min_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        Self(avx512!(_mm512_max_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn positive_then(self, value: Self) -> Self {
        avx512!({
            let mask = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, _mm512_setzero_ps());
            Self(_mm512_maskz_mov_ps(mask, value.0))
        })
    }
    #[inline(always)]
    fn at_least_then(self, floor: Self, value: Self) -> Self {
        avx512!({
            let mask = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(self.0, floor.0);
            Self(_mm512_maskz_mov_ps(mask, value.0))
        })
    }
    #[inline(always)]
    fn any_positive(self) -> bool {
        avx512!(_mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, _mm512_setzero_ps())) != 0
    }
    #[inline(always)]
    fn count_positive(self) -> usize {
        self.positive().count_ones() as usize
    }
    #[inline(always)]
    fn packed(self, chosen: Self) -> Self {
        Self(avx512!(_mm512_maskz_compress_ps(chosen.positive(), self.0)))
    }
    #[inline(always)]
    fn spread(self, chosen: Self) -> Self {
        Self(avx512!(_mm512_maskz_expand_ps(chosen.positive(), self.0)))
    }
    #[inline(always)]
    fn reciprocal_root(self) -> Self {
        avx512!({
            let mask = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, _mm512_setzero_ps());
            // 14 bits, then y (3 - s y^2) / 2.
            let y = _mm512_maskz_rsqrt14_ps(mask, self.0);
            let e = _mm512_fnmadd_ps(_mm512_mul_ps(self.0, y), y, _mm512_set1_ps(3.0));
            Self(_mm512_mul_ps(_mm512_mul_ps(y, _mm512_set1_ps(0.5)), e))
        })
    }
}

/// Red, green and blue in the low bytes.
#[inline(always)]
fn colours(entries: __m512i) -> [Avx512; 3] {
    avx512!({
        let byte = _mm512_set1_epi32(255);
        let [red, green, blue] = [
            _mm512_and_si512(entries, byte),
            _mm512_and_si512(_mm512_srli_epi32::<8>(entries), byte),
            _mm512_srli_epi32::<16>(entries),
        ];
        [
            Avx512(_mm512_cvtepi32_ps(red)),
            Avx512(_mm512_cvtepi32_ps(green)),
            Avx512(_mm512_cvtepi32_ps(blue)),
        ]
    })
}
