//! Eight floats in AVX2 with FMA.

#![expect(unsafe_code, reason = "vector instructions; every use says why it is sound")]

use std::arch::x86_64::*;
use std::ops::{Add, Mul, Sub};

use slicecast::lanes::Kernel;
use slicecast::table::Neighboured;

use super::{AS_IT_IS, Floats};
use crate::simd::avx2::{PACKED, SPREAD, look_up};
use crate::simd::entry;
use crate::simd::partial::{chunk, chunk_mut, rest};

/// Eight floats. Of use only where the processor has AVX2, FMA and BMI1; see [`super::with_floats`].
#[derive(Clone, Copy)]
pub struct Avx2(__m256);

/// Calls an intrinsic of AVX2 or FMA.
macro_rules! avx2 {
    ($call:expr) => {
        // SAFETY: `with_floats` runs this code only on processors that have AVX2, FMA and BMI1; pointers come from slices
        // that are long enough (`chunk`), or a mask leaves out what the slice does not have.
        unsafe { $call }
    };
}

impl Add for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(avx2!(_mm256_add_ps(self.0, other.0)))
    }
}

impl Sub for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(avx2!(_mm256_sub_ps(self.0, other.0)))
    }
}

impl Mul for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(avx2!(_mm256_mul_ps(self.0, other.0)))
    }
}

/// All bits in as many of the first lanes as there are elements.
#[inline(always)]
fn ones(elements: usize) -> __m256i {
    avx2!(_mm256_cmpgt_epi32(
        _mm256_set1_epi32(elements.min(8) as i32),
        _mm256_set_epi32(7, 6, 5, 4, 3, 2, 1, 0)
    ))
}

#[inline(always)]
fn of_voxels(voxels: &[u16; 8]) -> Avx2 {
    Avx2(avx2!(_mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(_mm_loadu_si128(
        voxels.as_ptr().cast()
    )))))
}

impl Avx2 {
    /// The lanes above 0, as bits.
    #[inline(always)]
    fn positive(self) -> u8 {
        avx2!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(
            self.0,
            _mm256_setzero_ps()
        ))) as u8
    }

    /// Lanes in another order.
    #[inline(always)]
    fn moved(self, order: &[i32; 8]) -> Self {
        Self(avx2!(_mm256_permutevar8x32_ps(
            self.0,
            _mm256_loadu_si256(order.as_ptr().cast())
        )))
    }
}

impl Floats for Avx2 {
    const COUNT: usize = 8;

    #[inline(always)]
    fn enter<K: Kernel>(kernel: K) -> K::Output {
        entry::avx2(kernel)
    }
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(avx2!(_mm256_set1_ps(value)))
    }
    #[inline(always)]
    fn load(row: &[f32], at: usize) -> Self {
        match chunk::<_, 8>(row, at) {
            Some(lanes) => Self(avx2!(_mm256_loadu_ps(lanes.as_ptr()))),
            None => Self(avx2!(_mm256_maskload_ps(
                row.as_ptr().wrapping_add(at),
                ones(rest(row, at))
            ))),
        }
    }
    #[inline(always)]
    fn store(self, row: &mut [f32], at: usize) {
        match chunk_mut::<_, 8>(row, at) {
            Some(lanes) => avx2!(_mm256_storeu_ps(lanes.as_mut_ptr(), self.0)),
            None => {
                let (first, mask) = (row.as_mut_ptr().wrapping_add(at), ones(rest(row, at)));
                avx2!(_mm256_maskstore_ps(first, mask, self.0));
            }
        }
    }
    #[inline(always)]
    fn load_voxels(row: &[u16], at: usize) -> Self {
        match chunk::<_, 8>(row, at) {
            Some(lanes) => of_voxels(lanes),
            None => {
                let mut lanes = [0; 8];
                for (lane, voxel) in lanes.iter_mut().zip(row.get(at..).unwrap_or(&[])) {
                    *lane = *voxel;
                }
                of_voxels(&lanes)
            }
        }
    }
    #[inline(always)]
    fn store_whole(self, row: &mut [i32], at: usize) {
        if let Some(codes) = chunk_mut::<_, 8>(row, at) {
            avx2!(_mm256_storeu_si256(
                codes.as_mut_ptr().cast(),
                _mm256_cvttps_epi32(self.0)
            ));
        }
    }
    #[inline(always)]
    fn load_whole(row: &[i32], at: usize) -> Self {
        let Some(codes) = chunk::<_, 8>(row, at) else {
            return Self::splat(0.0);
        };
        Self(avx2!(_mm256_cvtepi32_ps(_mm256_loadu_si256(codes.as_ptr().cast()))))
    }
    #[inline(always)]
    fn look_up(values: &Neighboured, codes: &[i32], at: usize) -> [Self; 2] {
        let Some(codes) = chunk::<_, 8>(codes, at) else {
            return [Self::splat(0.0); 2];
        };
        let [value, next] = look_up(values, codes, AS_IT_IS);
        avx2!([Self(_mm256_castsi256_ps(value)), Self(_mm256_castsi256_ps(next)),])
    }
    #[inline(always)]
    fn look_up_colours(entries: &Neighboured, codes: &[i32], at: usize) -> [[Self; 3]; 2] {
        let Some(codes) = chunk::<_, 8>(codes, at) else {
            return [[Self::splat(0.0); 3]; 2];
        };
        let [entry, next] = look_up(entries, codes, AS_IT_IS);
        [colours(entry), colours(next)]
    }
    #[inline(always)]
    fn followed_by(self, next: Self) -> Self {
        avx2!({
            let (this, next) = (_mm256_castps_si256(self.0), _mm256_castps_si256(next.0));
            // The middle: upper half of this, lower half of the next.
            let middle = _mm256_permute2x128_si256::<0x21>(this, next);
            Self(_mm256_castsi256_ps(_mm256_alignr_epi8::<4>(middle, this)))
        })
    }
    #[inline(always)]
    fn times_plus(self, factor: Self, term: Self) -> Self {
        Self(avx2!(_mm256_fmadd_ps(self.0, factor.0, term.0)))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Self(avx2!(_mm256_min_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        Self(avx2!(_mm256_max_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn positive_then(self, value: Self) -> Self {
        avx2!({
            let mask = _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, _mm256_setzero_ps());
            Self(_mm256_and_ps(mask, value.0))
        })
    }
    #[inline(always)]
    fn at_least_then(self, floor: Self, value: Self) -> Self {
        avx2!({
            let mask = _mm256_cmp_ps::<_CMP_GE_OQ>(self.0, floor.0);
            Self(_mm256_and_ps(mask, value.0))
        })
    }
    #[inline(always)]
    fn any_positive(self) -> bool {
        avx2!({
            let mask = _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, _mm256_setzero_ps());
            _mm256_movemask_ps(mask) != 0
        })
    }
    #[inline(always)]
    fn count_positive(self) -> usize {
        self.positive().count_ones() as usize
    }
    #[inline(always)]
    fn packed(self, chosen: Self) -> Self {
        self.moved(&PACKED[usize::from(chosen.positive())])
    }
    #[inline(always)]
    fn spread(self, chosen: Self) -> Self {
        self.moved(&SPREAD[usize::from(chosen.positive())])
    }
    #[inline(always)]
    fn reciprocal_root(self) -> Self {
        avx2!({
            // 12 bits, then y (3 - s y^2) / 2; the estimate of 0 is infinite.
            let mask = _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, _mm256_setzero_ps());
            let y = _mm256_and_ps(mask, _mm256_rsqrt_ps(self.0));
            let e = _mm256_fnmadd_ps(_mm256_mul_ps(self.0, y), y, _mm256_set1_ps(3.0));
            Self(_mm256_mul_ps(_mm256_mul_ps(y, _mm256_set1_ps(0.5)), e))
        })
    }
}

/// Red, green and blue in the low bytes.
#[inline(always)]
fn colours(entries: __m256i) -> [Avx2; 3] {
    avx2!({
        let byte = _mm256_set1_epi32(255);
        let [red, green, blue] = [
            _mm256_and_si256(entries, byte),
            _mm256_and_si256(_mm256_srli_epi32::<8>(entries), byte),
            _mm256_srli_epi32::<16>(entries),
        ];
        [
            Avx2(_mm256_cvtepi32_ps(red)),
            Avx2(_mm256_cvtepi32_ps(green)),
            Avx2(_mm256_cvtepi32_ps(blue)),
        ]
    })
}
