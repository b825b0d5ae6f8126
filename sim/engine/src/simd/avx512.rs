//! Sixteen lanes in AVX-512.

#![expect(unsafe_code, reason = "vector instructions; every use says why it is sound")]

use std::arch::x86_64::*;
use std::mem::transmute_copy;
use std::ops::{Add, BitAnd, BitOr, BitXor, Mul, Shl, Shr, Sub};

use slicecast::lanes::{Kernel, Lanes, Wide};
use slicecast::table::Coding;

use super::partial::{chunk, chunk_mut, chunk_or_zeros, is_half, is_word, neighbours, rest};
use super::root::ROOT_SCALE;

/// Sixteen 32-bit lanes. The type can be named only by [`super::with_lanes`], which holds the token of AVX-512.
#[derive(Clone, Copy)]
pub struct Avx512(__m512i);

/// Sixteen 64-bit products: those of the even lanes and those of the odd lanes.
#[derive(Clone, Copy)]
pub struct Products(__m512i, __m512i);

/// Calls an intrinsic of AVX-512.
macro_rules! avx512 {
    ($call:expr) => {
        // SAFETY: `super::with_lanes` runs this code only on processors that have AVX-512 (F, BW, CD, DQ, VL) and BMI1;
        // pointers come from slices that are long enough (`chunk`), or a mask leaves out what the slice does not have.
        unsafe { $call }
    };
}

mod halves;

/// An operator by its intrinsic.
macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(avx512!($intrinsic(self.0, other.0)))
            }
        }
    };
}

operator!(Avx512, Add, add, _mm512_add_epi32);
operator!(Avx512, Sub, sub, _mm512_sub_epi32);
operator!(Avx512, Mul, mul, _mm512_mullo_epi32);
operator!(Avx512, BitAnd, bitand, _mm512_and_si512);
operator!(Avx512, BitOr, bitor, _mm512_or_si512);
operator!(Avx512, BitXor, bitxor, _mm512_xor_si512);

impl Shl<u32> for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        Self(avx512!(_mm512_sll_epi32(self.0, _mm_cvtsi32_si128(by as i32))))
    }
}

impl Shr<u32> for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        Self(avx512!(_mm512_sra_epi32(self.0, _mm_cvtsi32_si128(by as i32))))
    }
}

impl Avx512 {
    #[inline(always)]
    fn of_array(lanes: &[i32; 16]) -> Self {
        Self(avx512!(_mm512_loadu_si512(lanes.as_ptr().cast())))
    }

    #[inline(always)]
    fn of_voxels(lanes: &[u16; 16]) -> Self {
        Self(avx512!(_mm512_cvtepu16_epi32(_mm256_loadu_si256(
            lanes.as_ptr().cast()
        ))))
    }

    /// The lanes shifted so that the odd ones stand where the even ones were.
    #[inline(always)]
    fn odd(self) -> __m512i {
        avx512!(_mm512_srli_epi64::<32>(self.0))
    }

    #[inline(always)]
    fn to_array(self) -> [i32; 16] {
        let mut lanes = [0; 16];
        avx512!(_mm512_storeu_si512(lanes.as_mut_ptr().cast(), self.0));
        lanes
    }
}

/// As many low bits as there are elements, fewer than a vector has.
#[inline(always)]
fn ones(elements: usize) -> u32 {
    (1 << (elements & 31)) - 1
}

/// Places of the lower (`UPPER` 0) or upper (1) halves of two vectors' lanes.
#[inline(always)]
fn words<const UPPER: u16>() -> __m512i {
    let places: [u16; 32] = std::array::from_fn(|lane| 2 * lane as u16 + UPPER);
    avx512!(_mm512_loadu_si512(places.as_ptr().cast()))
}

/// The neighbours of samples 0 and 1, 4 and 5, 8 and 9, 12 and 13 from this one on.
///
/// # Safety
/// The processor has AVX-512, and there are 14 samples. (A function: a closure might not be inlined.)
#[inline(always)]
unsafe fn every_second_pair<const N: usize>(values: &[u32; N], samples: *const i32, coding: Coding) -> __m512 {
    // SAFETY: as above.
    unsafe {
        let low = _mm256_set_m128i(
            neighbours(values, samples.add(4), coding),
            neighbours(values, samples, coding),
        );
        let high = _mm256_set_m128i(
            neighbours(values, samples.add(12), coding),
            neighbours(values, samples.add(8), coding),
        );
        _mm512_castsi512_ps(_mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high))
    }
}

/// The values at the codes of sixteen samples, and the next ones.
#[inline(always)]
pub fn look_up<const N: usize>(values: &[u32; N], samples: &[i32; 16], coding: Coding) -> [__m512i; 2] {
    let samples = samples.as_ptr();
    avx512!({
        // Their even elements, two from a quarter of each, are the values in order.
        let first = every_second_pair(values, samples, coding);
        let second = every_second_pair(values, samples.add(2), coding);
        [
            _mm512_castps_si512(_mm512_shuffle_ps::<0b10_00_10_00>(first, second)),
            _mm512_castps_si512(_mm512_shuffle_ps::<0b11_01_11_01>(first, second)),
        ]
    })
}

/// Where r^2 s > 2^70, of the lanes in the low halves of 64 bits, with nothing above them in `r`. Less than 2^63 away from
/// 2^70, so the low 64 bits of the product tell.
#[inline(always)]
fn too_large(r: __m512i, s: __m512i) -> __mmask8 {
    avx512!({
        let product = _mm512_mullo_epi64(_mm512_mul_epu32(r, s), r);
        _mm512_cmpgt_epi64_mask(product, _mm512_setzero_si512())
    })
}

impl Lanes for Avx512 {
    type Wide = Products;
    type Halves = halves::Halves512;
    const COUNT: usize = 16;

    #[inline(always)]
    fn enter<K: Kernel>(kernel: K) -> K::Output {
        super::entry::avx512(kernel)
    }

    #[inline(always)]
    fn splat(bits: i32) -> Self {
        Self(avx512!(_mm512_set1_epi32(bits)))
    }
    #[inline(always)]
    fn load(row: &[i32], at: usize) -> Self {
        match chunk::<_, 16>(row, at) {
            Some(lanes) => Self::of_array(lanes),
            None => {
                let first = row.as_ptr().wrapping_add(at);
                Self(avx512!(_mm512_maskz_loadu_epi32(ones(rest(row, at)) as u16, first)))
            }
        }
    }
    #[inline(always)]
    fn store(self, row: &mut [i32], at: usize) {
        match chunk_mut::<_, 16>(row, at) {
            Some(lanes) => avx512!(_mm512_storeu_si512(lanes.as_mut_ptr().cast(), self.0)),
            None => {
                let mask = ones(rest(row, at)) as u16;
                avx512!(_mm512_mask_storeu_epi32(
                    row.as_mut_ptr().wrapping_add(at),
                    mask,
                    self.0
                ));
            }
        }
    }
    #[inline(always)]
    fn load_voxels(row: &[u16], at: usize) -> Self {
        match chunk::<_, 16>(row, at) {
            Some(lanes) => Self::of_voxels(lanes),
            None => {
                let first = row.as_ptr().wrapping_add(at).cast();
                let voxels = avx512!(_mm256_maskz_loadu_epi16(ones(rest(row, at)) as u16, first));
                Self(avx512!(_mm512_cvtepu16_epi32(voxels)))
            }
        }
    }
    #[inline(always)]
    fn load_inner_voxels(row: &[u16], at: usize) -> Self {
        Self::of_voxels(chunk_or_zeros::<_, 16>(row, at))
    }
    #[inline(always)]
    fn load_as<T: Copy + 'static>(row: &[T], at: usize, bits: impl Fn(T) -> u32) -> Self {
        match chunk::<_, 16>(row, at) {
            Some(lanes) => Self::of_array(&lanes.map(|t| bits(t) as i32)),
            None => {
                let (first, mask) = (row.as_ptr().wrapping_add(at), ones(rest(row, at)) as u16);
                let lanes = if is_half::<T>() {
                    let elements = avx512!(_mm256_maskz_loadu_epi16(mask, first.cast()));
                    // SAFETY: numbers of 16 bits (`is_half`).
                    unsafe { transmute_copy::<_, [T; 16]>(&elements) }.map(|t| bits(t) as i32)
                } else if is_word::<T>() {
                    let elements = avx512!(_mm512_maskz_loadu_epi32(mask, first.cast()));
                    // SAFETY: numbers of 32 bits (`is_word`).
                    unsafe { transmute_copy::<_, [T; 16]>(&elements) }.map(|t| bits(t) as i32)
                } else {
                    let mut lanes = [0; 16];
                    for (lane, t) in lanes.iter_mut().zip(row.get(at..).unwrap_or(&[])) {
                        *lane = bits(*t) as i32;
                    }
                    lanes
                };
                Self(avx512!(_mm512_maskz_mov_epi32(mask, Self::of_array(&lanes).0)))
            }
        }
    }
    #[inline(always)]
    fn store_as<T: Copy + 'static>(self, row: &mut [T], at: usize, element: impl Fn(u32) -> T) {
        if is_half::<T>() {
            let halves = avx512!(_mm512_cvtepi32_epi16(self.0));
            match chunk_mut::<_, 16>(row, at) {
                Some(place) => avx512!(_mm256_storeu_si256(place.as_mut_ptr().cast(), halves)),
                None => {
                    let (first, mask) = (row.as_mut_ptr().wrapping_add(at), ones(rest(row, at)) as u16);
                    avx512!(_mm256_mask_storeu_epi16(first.cast(), mask, halves));
                }
            }
            return;
        }
        let lanes = self.to_array();
        match chunk_mut::<_, 16>(row, at) {
            Some(place) => *place = lanes.map(|bits| element(bits as u32)),
            None => {
                let (first, mask) = (row.as_mut_ptr().wrapping_add(at), ones(rest(row, at)) as u16);
                if is_word::<T>() {
                    let elements = lanes.map(|bits| element(bits as u32));
                    avx512!({
                        let elements = _mm512_loadu_si512(elements.as_ptr().cast());
                        _mm512_mask_storeu_epi32(first.cast(), mask, elements);
                    });
                } else {
                    for (t, lane) in row.get_mut(at..).unwrap_or(&mut []).iter_mut().zip(lanes) {
                        *t = element(lane as u32);
                    }
                }
            }
        }
    }
    #[inline(always)]
    fn store_two_as<T: Copy + 'static>(
        [first, second]: [Self; 2],
        row: &mut [T],
        at: usize,
        element: impl Fn(u32) -> T,
    ) {
        if !is_half::<T>() {
            first.store_as(row, at, &element);
            second.store_as(row, at + 16, element);
            return;
        }
        let halves = avx512!(_mm512_permutex2var_epi16(first.0, words::<0>(), second.0));
        match chunk_mut::<_, 32>(row, at) {
            Some(place) => avx512!(_mm512_storeu_si512(place.as_mut_ptr().cast(), halves)),
            None => {
                let (first, mask) = (row.as_mut_ptr().wrapping_add(at), ones(rest(row, at)));
                avx512!(_mm512_mask_storeu_epi16(first.cast(), mask, halves));
            }
        }
    }
    #[inline(always)]
    fn add_upper_as<T: Copy + 'static>(
        [first, second]: [Self; 2],
        row: &mut [T],
        at: usize,
        bits: impl Fn(T) -> u32,
        element: impl Fn(u32) -> T,
    ) {
        if !is_half::<T>() {
            let sum = Self::load_as(row, at, &bits) + first.shr_unsigned(16);
            sum.store_as(row, at, &element);
            (Self::load_as(row, at + 16, bits) + second.shr_unsigned(16)).store_as(row, at + 16, element);
            return;
        }
        let halves = avx512!(_mm512_permutex2var_epi16(first.0, words::<1>(), second.0));
        match chunk_mut::<_, 32>(row, at) {
            Some(place) => avx512!({
                let sum = _mm512_add_epi16(_mm512_loadu_si512(place.as_ptr().cast()), halves);
                _mm512_storeu_si512(place.as_mut_ptr().cast(), sum);
            }),
            None => {
                let (first, mask) = (row.as_mut_ptr().wrapping_add(at), ones(rest(row, at)));
                avx512!({
                    let sum = _mm512_add_epi16(_mm512_maskz_loadu_epi16(mask, first.cast()), halves);
                    _mm512_mask_storeu_epi16(first.cast(), mask, sum);
                });
            }
        }
    }
    #[inline(always)]
    fn look_up<const N: usize>(values: &[u32; N], samples: &[i32], at: usize, coding: Coding) -> [Self; 2] {
        let last;
        let samples = match chunk::<_, 16>(samples, at) {
            Some(samples) => samples,
            None => {
                last = Self::load(samples, at).to_array();
                &last
            }
        };
        let [value, next] = look_up(values, samples, coding);
        [Self(value), Self(next)]
    }
    #[inline(always)]
    fn picked(row: &[i32], place: usize, offsets: Self) -> Self {
        let (near, far) = (Self::load(row, place), Self::load(row, place + Self::COUNT));
        Self(avx512!(_mm512_permutex2var_epi32(near.0, offsets.0, far.0)))
    }
    #[inline(always)]
    fn followed_by(self, next: Self) -> Self {
        Self(avx512!(_mm512_alignr_epi32::<1>(next.0, self.0)))
    }
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn wrapping_sub(self, other: Self) -> Self {
        self - other
    }
    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        self * other
    }
    #[inline(always)]
    fn saturating_add(self, other: Self) -> Self {
        let room = avx512!(_mm512_xor_si512(other.0, _mm512_set1_epi32(-1)));
        Self(avx512!(_mm512_add_epi32(_mm512_min_epu32(self.0, room), other.0)))
    }
    #[inline(always)]
    fn shr_unsigned(self, by: u32) -> Self {
        Self(avx512!(_mm512_srl_epi32(self.0, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn shl_each(self, by: Self) -> Self {
        Self(avx512!(_mm512_sllv_epi32(self.0, by.0)))
    }
    #[inline(always)]
    fn shr_each(self, by: Self) -> Self {
        Self(avx512!(_mm512_srlv_epi32(self.0, by.0)))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Self(avx512!(_mm512_min_epi32(self.0, other.0)))
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        Self(avx512!(_mm512_max_epi32(self.0, other.0)))
    }
    #[inline(always)]
    fn at_most_unsigned(self, other: Self) -> Self {
        Self(avx512!(_mm512_min_epu32(self.0, other.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(avx512!(_mm512_abs_epi32(self.0)))
    }
    #[inline(always)]
    fn leading_zeros(self) -> Self {
        Self(avx512!(_mm512_lzcnt_epi32(self.0)))
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        Self(avx512!(_mm512_maskz_mov_epi32(
            _mm512_test_epi32_mask(self.0, self.0),
            value.0
        )))
    }
    #[inline(always)]
    fn at_least_then(self, floor: Self, value: Self) -> Self {
        Self(avx512!(_mm512_maskz_mov_epi32(
            _mm512_cmpge_epu32_mask(self.0, floor.0),
            value.0
        )))
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        avx512!(_mm512_test_epi32_mask(self.0, self.0)) == 0
    }
    #[inline(always)]
    fn count(self) -> usize {
        avx512!(_mm512_test_epi32_mask(self.0, self.0)).count_ones() as usize
    }
    #[inline(always)]
    fn packed(self, chosen: Self) -> Self {
        Self(avx512!(_mm512_maskz_compress_epi32(
            _mm512_test_epi32_mask(chosen.0, chosen.0),
            self.0
        )))
    }
    #[inline(always)]
    fn spread(self, chosen: Self) -> Self {
        Self(avx512!(_mm512_maskz_expand_epi32(
            _mm512_test_epi32_mask(chosen.0, chosen.0),
            self.0
        )))
    }
    #[inline(always)]
    fn product(self, other: Self) -> Products {
        Products(
            avx512!(_mm512_mul_epu32(self.0, other.0)),
            avx512!(_mm512_mul_epu32(self.odd(), other.odd())),
        )
    }
    #[inline(always)]
    fn product_signed(self, other: Self) -> Products {
        Products(
            avx512!(_mm512_mul_epi32(self.0, other.0)),
            avx512!(_mm512_mul_epi32(self.odd(), other.odd())),
        )
    }
    #[inline(always)]
    fn reciprocal_root(self) -> Self {
        avx512!({
            let s = _mm512_cvtepu32_ps(self.0);
            // Within 2^-14, whatever the processor's table; with e = 1 - s y^2, 1 / sqrt(s) = y (1 + e/2 + 3 e^2/8 ...).
            // 0 stays 0.
            let y = _mm512_maskz_rsqrt14_ps(_mm512_test_epi32_mask(self.0, self.0), s);
            let e = _mm512_fnmadd_ps(_mm512_mul_ps(s, y), y, _mm512_set1_ps(1.0));
            let half = _mm512_mul_ps(y, _mm512_set1_ps(ROOT_SCALE / 2.0));
            let scaled = _mm512_mul_ps(y, _mm512_set1_ps(ROOT_SCALE));
            // Wrong by 0.2 at most: to nearest it is the floor that is asked for, or one more.
            let r = _mm512_cvtps_epi32(_mm512_fmadd_ps(half, e, scaled));
            let even = too_large(_mm512_maskz_mov_epi32(0x5555, r), self.0);
            let odd = too_large(_mm512_srli_epi64::<32>(r), self.odd());
            let r = _mm512_mask_sub_epi64(r, even, r, _mm512_set1_epi64(1));
            Self(_mm512_mask_sub_epi64(r, odd, r, _mm512_set1_epi64(1 << 32)))
        })
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        avx512!({
            // 2^52; exact (`slicecast::reciprocal`).
            let numerator = _mm512_set1_pd(4_503_599_627_370_496.0);
            let low = _mm512_cvtepi32_pd(_mm512_castsi512_si256(self.0));
            let high = _mm512_cvtepi32_pd(_mm512_extracti64x4_epi64::<1>(self.0));
            let low = _mm512_cvttpd_epi32(_mm512_div_pd(numerator, low));
            let high = _mm512_cvttpd_epi32(_mm512_div_pd(numerator, high));
            Self(_mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high))
        })
    }
    #[inline(always)]
    fn with_sign_of(self, sign: Self) -> Self {
        avx512!({
            let negative = _mm512_movepi32_mask(sign.0);
            Self(_mm512_mask_sub_epi32(self.0, negative, _mm512_setzero_si512(), self.0))
        })
    }
}

impl Add for Products {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(
            avx512!(_mm512_add_epi64(self.0, other.0)),
            avx512!(_mm512_add_epi64(self.1, other.1)),
        )
    }
}

impl Sub for Products {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(
            avx512!(_mm512_sub_epi64(self.0, other.0)),
            avx512!(_mm512_sub_epi64(self.1, other.1)),
        )
    }
}

impl Products {
    #[inline(always)]
    fn each(self, f: impl Fn(__m512i) -> __m512i) -> Self {
        Self(f(self.0), f(self.1))
    }
}

impl Wide for Products {
    type Narrow = Avx512;

    #[inline(always)]
    fn splat(bits: i64) -> Self {
        let v = avx512!(_mm512_set1_epi64(bits));
        Self(v, v)
    }
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        self.each(|v| avx512!(_mm512_srl_epi64(v, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        self.each(|v| avx512!(_mm512_sll_epi64(v, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn shr_each(self, by: Avx512) -> Self {
        let by = Self::of(by);
        Self(
            avx512!(_mm512_srlv_epi64(self.0, by.0)),
            avx512!(_mm512_srlv_epi64(self.1, by.1)),
        )
    }
    #[inline(always)]
    fn at_least_zero(self) -> Self {
        self.each(|v| avx512!(_mm512_max_epi64(v, _mm512_setzero_si512())))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Self(
            avx512!(_mm512_min_epi64(self.0, other.0)),
            avx512!(_mm512_min_epi64(self.1, other.1)),
        )
    }
    #[inline(always)]
    fn times(self, other: Avx512) -> Self {
        let other = Self::of(other);
        Self(
            avx512!(_mm512_mullo_epi64(self.0, other.0)),
            avx512!(_mm512_mullo_epi64(self.1, other.1)),
        )
    }
    #[inline(always)]
    fn shr_to_one(self, by: u32) -> Self {
        self.shr(by)
            .each(|v| avx512!(_mm512_min_epu32(v, _mm512_set1_epi64(1 << 31))))
    }
    #[inline(always)]
    fn low_product(self, other: Self) -> Self {
        Self(
            avx512!(_mm512_mul_epu32(self.0, other.0)),
            avx512!(_mm512_mul_epu32(self.1, other.1)),
        )
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        avx512!(Self(
            _mm512_maskz_mov_epi64(_mm512_test_epi64_mask(self.0, self.0), value.0),
            _mm512_maskz_mov_epi64(_mm512_test_epi64_mask(self.1, self.1), value.1),
        ))
    }
    #[inline(always)]
    fn any_at_least(self, least: u32) -> bool {
        avx512!({
            let least = _mm512_set1_epi64(i64::from(least));
            _mm512_cmpge_epu64_mask(_mm512_max_epu32(self.0, self.1), least) != 0
        })
    }
    #[inline(always)]
    fn of(narrow: Avx512) -> Self {
        Self(
            avx512!(_mm512_maskz_mov_epi32(0x5555, narrow.0)),
            avx512!(_mm512_srli_epi64::<32>(narrow.0)),
        )
    }
    #[inline(always)]
    fn shr_narrow(self, by: u32) -> Avx512 {
        // The odd lanes' bits go straight to where they belong.
        let even = avx512!(_mm512_srl_epi64(self.0, _mm_cvtsi32_si128(by as i32)));
        let odd = avx512!(_mm512_sll_epi64(self.1, _mm_cvtsi32_si128(32 - by as i32)));
        Avx512(avx512!(_mm512_mask_mov_epi32(odd, 0x5555, even)))
    }
    #[inline(always)]
    fn shr_upper(self, by: u32) -> Avx512 {
        let even = avx512!(_mm512_srl_epi64(self.0, _mm_cvtsi32_si128(by as i32)));
        let odd = avx512!(_mm512_srl_epi64(self.1, _mm_cvtsi32_si128(by as i32 - 32)));
        Avx512(avx512!(_mm512_mask_mov_epi32(odd, 0x5555, even)))
    }
    #[inline(always)]
    fn narrow(self) -> Avx512 {
        let odd = avx512!(_mm512_slli_epi64::<32>(self.1));
        Avx512(avx512!(_mm512_mask_mov_epi32(odd, 0x5555, self.0)))
    }
}
