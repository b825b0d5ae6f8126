//! Eight lanes in AVX2.

#![expect(unsafe_code, reason = "vector instructions; every use says why it is sound")]

use std::arch::x86_64::*;
use std::mem::transmute_copy;
use std::ops::{Add, BitAnd, BitOr, BitXor, Mul, Shl, Shr, Sub};

use slicecast::lanes::{Kernel, Lanes, Wide};
use slicecast::table::Coding;

use super::partial::{chunk, chunk_mut, chunk_or_zeros, is_half, is_word, neighbours, rest};
use super::root::{ROOT_LIMIT, ROOT_SCALE};

/// Eight 32-bit lanes. The type can be named only by [`super::with_lanes`], which holds the token of AVX2.
#[derive(Clone, Copy)]
pub struct Avx2(__m256i);

/// Eight 64-bit products: those of the even lanes and those of the odd lanes.
#[derive(Clone, Copy)]
pub struct Products(__m256i, __m256i);

/// Calls an intrinsic of AVX2 or FMA.
macro_rules! avx2 {
    ($call:expr) => {
        // SAFETY: `super::with_lanes` runs this code only on processors that have AVX2, FMA and BMI1; pointers come from
        // slices that are long enough (`chunk`), or a mask leaves out what the slice does not have.
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
                Self(avx2!($intrinsic(self.0, other.0)))
            }
        }
    };
}

operator!(Avx2, Add, add, _mm256_add_epi32);
operator!(Avx2, Sub, sub, _mm256_sub_epi32);
operator!(Avx2, Mul, mul, _mm256_mullo_epi32);
operator!(Avx2, BitAnd, bitand, _mm256_and_si256);
operator!(Avx2, BitOr, bitor, _mm256_or_si256);
operator!(Avx2, BitXor, bitxor, _mm256_xor_si256);

impl Shl<u32> for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        Self(avx2!(_mm256_sll_epi32(self.0, _mm_cvtsi32_si128(by as i32))))
    }
}

impl Shr<u32> for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        Self(avx2!(_mm256_sra_epi32(self.0, _mm_cvtsi32_si128(by as i32))))
    }
}

impl Avx2 {
    #[inline(always)]
    fn of_array(lanes: &[i32; 8]) -> Self {
        Self(avx2!(_mm256_loadu_si256(lanes.as_ptr().cast())))
    }

    #[inline(always)]
    fn to_array(self) -> [i32; 8] {
        let mut lanes = [0; 8];
        avx2!(_mm256_storeu_si256(lanes.as_mut_ptr().cast(), self.0));
        lanes
    }

    #[inline(always)]
    fn of_voxels(lanes: &[u16; 8]) -> Self {
        Self(avx2!(_mm256_cvtepu16_epi32(_mm_loadu_si128(lanes.as_ptr().cast()))))
    }

    /// The lanes shifted so that the odd ones stand where the even ones were.
    #[inline(always)]
    fn odd(self) -> __m256i {
        avx2!(_mm256_srli_epi64::<32>(self.0))
    }

    /// The lanes that are 0, as bits.
    #[inline(always)]
    fn zeros_mask(self) -> u8 {
        avx2!(_mm256_movemask_ps(_mm256_castsi256_ps(self.zeros()))) as u8
    }

    /// Lanes in another order.
    #[inline(always)]
    fn moved(self, order: &[i32; 8]) -> Self {
        Self(avx2!(_mm256_permutevar8x32_epi32(self.0, Self::of_array(order).0)))
    }

    /// All bits where this is 0.
    #[inline(always)]
    fn zeros(self) -> __m256i {
        avx2!(_mm256_cmpeq_epi32(self.0, _mm256_setzero_si256()))
    }
}

/// For each set of lanes, the bits of a byte: those lanes in their order, in the first places.
pub(super) static PACKED: [[i32; 8]; 256] = orders(false);

/// For each set of lanes: where each of them finds itself among the packed ones.
pub(super) static SPREAD: [[i32; 8]; 256] = orders(true);

const fn orders(spread: bool) -> [[i32; 8]; 256] {
    let mut orders = [[0; 8]; 256];
    let mut set = 0;
    while set < 256 {
        let (mut lane, mut place) = (0, 0);
        while lane < 8 {
            if set >> lane & 1 != 0 {
                if spread {
                    orders[set][lane] = place as i32;
                } else {
                    orders[set][place] = lane as i32;
                }
                place += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    orders
}

/// All bits in as many of the first lanes as there are elements.
#[inline(always)]
fn ones(elements: usize) -> __m256i {
    avx2!(_mm256_cmpgt_epi32(
        _mm256_set1_epi32(elements.min(8) as i32),
        _mm256_set_epi32(7, 6, 5, 4, 3, 2, 1, 0)
    ))
}

/// Places of sixteen bytes for a shuffle, between places that give nothing. AVX2 has no masks for 16 bits: what a row has
/// fewer of than lanes is read and written as the end of its last eight.
const SLIDING: [u8; 48] = {
    let mut places = [0x80; 48];
    let mut byte = 0;
    while byte < 16 {
        places[16 + byte] = byte as u8;
        byte += 1;
    }
    places
};

/// The values at the codes of eight samples, and the next ones.
#[inline(always)]
pub fn look_up<const N: usize>(values: &[u32; N], samples: &[i32; 8], coding: Coding) -> [__m256i; 2] {
    let samples = samples.as_ptr();
    avx2!({
        // Halves of the first hold pairs 0 1 and 4 5, those of the second the others, so that picking their even
        // elements, two from each, gives the values in order.
        let first = _mm256_set_m128i(
            neighbours(values, samples.add(4), coding),
            neighbours(values, samples, coding),
        );
        let second = _mm256_set_m128i(
            neighbours(values, samples.add(6), coding),
            neighbours(values, samples.add(2), coding),
        );
        let (first, second) = (_mm256_castsi256_ps(first), _mm256_castsi256_ps(second));
        [
            _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(first, second)),
            _mm256_castps_si256(_mm256_shuffle_ps::<0b11_01_11_01>(first, second)),
        ]
    })
}

/// The lanes that stand in the low halves of 64 bits as floating-point numbers: 2^52 and them, less 2^52.
#[inline(always)]
fn of_low_halves(v: __m256i) -> __m256d {
    avx2!({
        let magic = _mm256_set1_pd(4_503_599_627_370_496.0);
        let joined = _mm256_blend_epi32::<0b1010_1010>(v, _mm256_castpd_si256(magic));
        _mm256_sub_pd(_mm256_castsi256_pd(joined), magic)
    })
}

/// Those in the high halves.
#[inline(always)]
fn of_high_halves(v: __m256i) -> __m256d {
    of_low_halves(avx2!(_mm256_srli_epi64::<32>(v)))
}

/// All bits where r^2 s > 2^70: the square is exact, and a fused operation keeps the difference's sign.
#[inline(always)]
fn too_large(r: __m256d, s: __m256d) -> __m256i {
    avx2!({
        let rest = _mm256_fnmadd_pd(_mm256_mul_pd(r, r), s, _mm256_set1_pd(ROOT_LIMIT));
        _mm256_castpd_si256(_mm256_cmp_pd::<_CMP_LT_OQ>(rest, _mm256_setzero_pd()))
    })
}

impl Lanes for Avx2 {
    type Wide = Products;
    type Halves = halves::Halves256;
    const COUNT: usize = 8;

    #[inline(always)]
    fn enter<K: Kernel>(kernel: K) -> K::Output {
        super::entry::avx2(kernel)
    }

    #[inline(always)]
    fn splat(bits: i32) -> Self {
        Self(avx2!(_mm256_set1_epi32(bits)))
    }
    #[inline(always)]
    fn load(row: &[i32], at: usize) -> Self {
        match chunk::<_, 8>(row, at) {
            Some(lanes) => Self::of_array(lanes),
            None => {
                let first = row.as_ptr().wrapping_add(at);
                Self(avx2!(_mm256_maskload_epi32(first, ones(rest(row, at)))))
            }
        }
    }
    #[inline(always)]
    fn store(self, row: &mut [i32], at: usize) {
        match chunk_mut::<_, 8>(row, at) {
            Some(lanes) => avx2!(_mm256_storeu_si256(lanes.as_mut_ptr().cast(), self.0)),
            None => {
                let mask = ones(rest(row, at));
                avx2!(_mm256_maskstore_epi32(row.as_mut_ptr().wrapping_add(at), mask, self.0));
            }
        }
    }
    #[inline(always)]
    fn load_voxels(row: &[u16], at: usize) -> Self {
        match chunk::<_, 8>(row, at) {
            Some(lanes) => Self::of_voxels(lanes),
            None => Self::load_as(row, at, u32::from),
        }
    }
    #[inline(always)]
    fn load_inner_voxels(row: &[u16], at: usize) -> Self {
        Self::of_voxels(chunk_or_zeros::<_, 8>(row, at))
    }
    #[inline(always)]
    fn load_as<T: Copy + 'static>(row: &[T], at: usize, bits: impl Fn(T) -> u32) -> Self {
        match chunk::<_, 8>(row, at) {
            Some(lanes) => Self::of_array(&lanes.map(|t| bits(t) as i32)),
            None => {
                let rest = rest(row, at);
                let lanes = if let (true, Some(last)) = (is_half::<T>(), row.last_chunk::<8>()) {
                    let elements = avx2!({
                        let down = _mm_loadu_si128(SLIDING[32 - 2 * (rest & 7)..][..16].as_ptr().cast());
                        _mm_shuffle_epi8(_mm_loadu_si128(last.as_ptr().cast()), down)
                    });
                    // SAFETY: numbers of 16 bits (`is_half`).
                    unsafe { transmute_copy::<_, [T; 8]>(&elements) }.map(|t| bits(t) as i32)
                } else if is_word::<T>() {
                    let first = row.as_ptr().wrapping_add(at).cast();
                    let elements = avx2!(_mm256_maskload_epi32(first, ones(rest)));
                    // SAFETY: numbers of 32 bits (`is_word`).
                    unsafe { transmute_copy::<_, [T; 8]>(&elements) }.map(|t| bits(t) as i32)
                } else {
                    let mut lanes = [0; 8];
                    for (lane, t) in lanes.iter_mut().zip(row.get(at..).unwrap_or(&[])) {
                        *lane = bits(*t) as i32;
                    }
                    lanes
                };
                Self(avx2!(_mm256_and_si256(ones(rest), Self::of_array(&lanes).0)))
            }
        }
    }
    #[inline(always)]
    fn store_as<T: Copy + 'static>(self, row: &mut [T], at: usize, element: impl Fn(u32) -> T) {
        let elements = self.to_array().map(|bits| element(bits as u32));
        if let Some(place) = chunk_mut::<_, 8>(row, at) {
            *place = elements;
            return;
        }
        let rest = rest(row, at);
        if let (true, Some(last)) = (is_half::<T>(), row.last_chunk_mut::<8>()) {
            avx2!({
                let up = _mm_loadu_si128(SLIDING[2 * (rest & 7)..][..16].as_ptr().cast());
                let elements = _mm_shuffle_epi8(_mm_loadu_si128(elements.as_ptr().cast()), up);
                let kept = _mm_loadu_si128(last.as_ptr().cast());
                _mm_storeu_si128(last.as_mut_ptr().cast(), _mm_blendv_epi8(elements, kept, up));
            });
        } else if is_word::<T>() {
            avx2!({
                let elements = _mm256_loadu_si256(elements.as_ptr().cast());
                _mm256_maskstore_epi32(row.as_mut_ptr().wrapping_add(at).cast(), ones(rest), elements);
            });
        } else {
            for (t, element) in row.get_mut(at..).unwrap_or(&mut []).iter_mut().zip(elements) {
                *t = element;
            }
        }
    }
    #[inline(always)]
    fn look_up<const N: usize>(values: &[u32; N], samples: &[i32], at: usize, coding: Coding) -> [Self; 2] {
        let last;
        let samples = match chunk::<_, 8>(samples, at) {
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
        Self(avx2!({
            // Of the offset three bits count; the next one says of which vector.
            let (near, far) = (
                _mm256_permutevar8x32_epi32(near.0, offsets.0),
                _mm256_permutevar8x32_epi32(far.0, offsets.0),
            );
            let is_far = _mm256_slli_epi32::<28>(offsets.0);
            _mm256_castps_si256(_mm256_blendv_ps(
                _mm256_castsi256_ps(near),
                _mm256_castsi256_ps(far),
                _mm256_castsi256_ps(is_far),
            ))
        }))
    }
    #[inline(always)]
    fn followed_by(self, next: Self) -> Self {
        // The middle: upper half of this, lower half of the next.
        let middle = avx2!(_mm256_permute2x128_si256::<0x21>(self.0, next.0));
        Self(avx2!(_mm256_alignr_epi8::<4>(middle, self.0)))
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
        let room = avx2!(_mm256_xor_si256(other.0, _mm256_set1_epi32(-1)));
        Self(avx2!(_mm256_add_epi32(_mm256_min_epu32(self.0, room), other.0)))
    }
    #[inline(always)]
    fn shr_unsigned(self, by: u32) -> Self {
        Self(avx2!(_mm256_srl_epi32(self.0, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn shl_each(self, by: Self) -> Self {
        Self(avx2!(_mm256_sllv_epi32(self.0, by.0)))
    }
    #[inline(always)]
    fn shr_each(self, by: Self) -> Self {
        Self(avx2!(_mm256_srlv_epi32(self.0, by.0)))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Self(avx2!(_mm256_min_epi32(self.0, other.0)))
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        Self(avx2!(_mm256_max_epi32(self.0, other.0)))
    }
    #[inline(always)]
    fn at_most_unsigned(self, other: Self) -> Self {
        Self(avx2!(_mm256_min_epu32(self.0, other.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(avx2!(_mm256_abs_epi32(self.0)))
    }
    #[inline(always)]
    fn leading_zeros(self) -> Self {
        avx2!({
            // As a float the number's exponent tells; without the bit behind the highest one it cannot round up.
            let kept = _mm256_andnot_si256(_mm256_srli_epi32::<1>(self.0), self.0);
            let float = _mm256_castps_si256(_mm256_cvtepi32_ps(kept));
            let zeros = _mm256_sub_epi32(_mm256_set1_epi32(127 + 31), _mm256_srli_epi32::<23>(float));
            // 0 has exponent -127; from 2^31 on the number looks negative.
            let zeros = _mm256_min_epi32(zeros, _mm256_set1_epi32(32));
            Self(_mm256_max_epi32(zeros, _mm256_setzero_si256()))
        })
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        Self(avx2!(_mm256_andnot_si256(self.zeros(), value.0)))
    }
    #[inline(always)]
    fn at_least_then(self, floor: Self, value: Self) -> Self {
        let reached = avx2!(_mm256_cmpeq_epi32(_mm256_max_epu32(self.0, floor.0), self.0));
        Self(avx2!(_mm256_and_si256(reached, value.0)))
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        avx2!(_mm256_testz_si256(self.0, self.0)) == 1
    }
    #[inline(always)]
    fn count(self) -> usize {
        8 - self.zeros_mask().count_ones() as usize
    }
    #[inline(always)]
    fn packed(self, chosen: Self) -> Self {
        self.moved(&PACKED[usize::from(!chosen.zeros_mask())])
    }
    #[inline(always)]
    fn spread(self, chosen: Self) -> Self {
        self.moved(&SPREAD[usize::from(!chosen.zeros_mask())])
    }
    #[inline(always)]
    fn product(self, other: Self) -> Products {
        Products(
            avx2!(_mm256_mul_epu32(self.0, other.0)),
            avx2!(_mm256_mul_epu32(self.odd(), other.odd())),
        )
    }
    #[inline(always)]
    fn product_signed(self, other: Self) -> Products {
        Products(
            avx2!(_mm256_mul_epi32(self.0, other.0)),
            avx2!(_mm256_mul_epi32(self.odd(), other.odd())),
        )
    }
    #[inline(always)]
    fn reciprocal_root(self) -> Self {
        avx2!({
            // Half of it: a signed number.
            let s = _mm256_cvtepi32_ps(_mm256_srli_epi32::<1>(self.0));
            // Within 1.5 * 2^-12, whatever the processor's table; with e = 1 - s y^2,
            // 1 / sqrt(s) = y (1 + e/2 + 3 e^2/8 + 5 e^3/16 ...).
            let y = _mm256_rsqrt_ps(s);
            let e = _mm256_fnmadd_ps(_mm256_mul_ps(s, y), y, _mm256_set1_ps(1.0));
            let p = _mm256_fmadd_ps(_mm256_set1_ps(0.375), e, _mm256_set1_ps(0.5));
            let scaled = _mm256_mul_ps(y, _mm256_set1_ps(ROOT_SCALE * std::f32::consts::FRAC_1_SQRT_2));
            // Wrong by 0.3 at most: to nearest it is the floor that is asked for, or one more.
            let r = _mm256_cvtps_epi32(_mm256_fmadd_ps(_mm256_mul_ps(scaled, e), p, scaled));
            let even = too_large(of_low_halves(r), of_low_halves(self.0));
            let odd = too_large(of_high_halves(r), of_high_halves(self.0));
            let one_less = _mm256_blend_epi32::<0b1010_1010>(even, odd);
            self.nonzero_then(Self(_mm256_add_epi32(r, one_less)))
        })
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        let quotients = |v: __m256i| {
            avx2!({
                // 2^52; exact (`slicecast::reciprocal`).
                let numerator = _mm256_set1_pd(4_503_599_627_370_496.0);
                _mm256_cvttpd_epi32(_mm256_div_pd(numerator, of_low_halves(v)))
            })
        };
        let (even, odd) = (quotients(self.0), quotients(self.odd()));
        avx2!({
            let (low, high) = (_mm_unpacklo_epi32(even, odd), _mm_unpackhi_epi32(even, odd));
            Self(_mm256_set_m128i(high, low))
        })
    }
    #[inline(always)]
    fn with_sign_of(self, sign: Self) -> Self {
        // An odd number is not 0, for which the instruction would give 0.
        Self(avx2!(_mm256_sign_epi32(
            self.0,
            _mm256_or_si256(sign.0, _mm256_set1_epi32(1))
        )))
    }
}

impl Add for Products {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(
            avx2!(_mm256_add_epi64(self.0, other.0)),
            avx2!(_mm256_add_epi64(self.1, other.1)),
        )
    }
}

impl Sub for Products {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(
            avx2!(_mm256_sub_epi64(self.0, other.0)),
            avx2!(_mm256_sub_epi64(self.1, other.1)),
        )
    }
}

/// The smaller of two signed numbers.
#[inline(always)]
fn smaller(a: __m256i, b: __m256i) -> __m256i {
    avx2!(_mm256_blendv_epi8(a, b, _mm256_cmpgt_epi64(a, b)))
}

/// A 64-bit number times the low 32 bits of another.
#[inline(always)]
fn times(a: __m256i, b: __m256i) -> __m256i {
    avx2!({
        let upper = _mm256_slli_epi64::<32>(_mm256_mul_epu32(_mm256_srli_epi64::<32>(a), b));
        _mm256_add_epi64(_mm256_mul_epu32(a, b), upper)
    })
}

impl Products {
    #[inline(always)]
    fn each(self, f: impl Fn(__m256i) -> __m256i) -> Self {
        Self(f(self.0), f(self.1))
    }
}

impl Wide for Products {
    type Narrow = Avx2;

    #[inline(always)]
    fn splat(bits: i64) -> Self {
        let v = avx2!(_mm256_set1_epi64x(bits));
        Self(v, v)
    }
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        self.each(|v| avx2!(_mm256_srl_epi64(v, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        self.each(|v| avx2!(_mm256_sll_epi64(v, _mm_cvtsi32_si128(by as i32))))
    }
    #[inline(always)]
    fn shr_each(self, by: Avx2) -> Self {
        let by = Self::of(by);
        Self(
            avx2!(_mm256_srlv_epi64(self.0, by.0)),
            avx2!(_mm256_srlv_epi64(self.1, by.1)),
        )
    }
    #[inline(always)]
    fn at_least_zero(self) -> Self {
        self.each(|v| {
            avx2!({
                let v = _mm256_castsi256_pd(v);
                _mm256_castpd_si256(_mm256_blendv_pd(v, _mm256_setzero_pd(), v))
            })
        })
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Self(smaller(self.0, other.0), smaller(self.1, other.1))
    }
    #[inline(always)]
    fn times(self, other: Avx2) -> Self {
        Self(times(self.0, other.0), times(self.1, other.odd()))
    }
    #[inline(always)]
    fn shr_to_one(self, by: u32) -> Self {
        self.shr(by)
            .each(|v| avx2!(_mm256_min_epu32(v, _mm256_set1_epi64x(1 << 31))))
    }
    #[inline(always)]
    fn low_product(self, other: Self) -> Self {
        Self(
            avx2!(_mm256_mul_epu32(self.0, other.0)),
            avx2!(_mm256_mul_epu32(self.1, other.1)),
        )
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        avx2!({
            let zero = _mm256_setzero_si256();
            Self(
                _mm256_andnot_si256(_mm256_cmpeq_epi64(self.0, zero), value.0),
                _mm256_andnot_si256(_mm256_cmpeq_epi64(self.1, zero), value.1),
            )
        })
    }
    #[inline(always)]
    fn any_at_least(self, least: u32) -> bool {
        avx2!({
            // The upper halves are 0.
            let below = _mm256_set1_epi64x(i64::from(least) - 1);
            let (even, odd) = (_mm256_cmpgt_epi64(self.0, below), _mm256_cmpgt_epi64(self.1, below));
            let any = _mm256_or_si256(even, odd);
            _mm256_testz_si256(any, any) == 0
        })
    }
    #[inline(always)]
    fn of(narrow: Avx2) -> Self {
        let even = avx2!(_mm256_blend_epi32::<0b1010_1010>(narrow.0, _mm256_setzero_si256()));
        Self(even, narrow.odd())
    }
    #[inline(always)]
    fn shr_narrow(self, by: u32) -> Avx2 {
        // The odd lanes' bits go straight to where they belong.
        let even = avx2!(_mm256_srl_epi64(self.0, _mm_cvtsi32_si128(by as i32)));
        let odd = avx2!(_mm256_sll_epi64(self.1, _mm_cvtsi32_si128(32 - by as i32)));
        Avx2(avx2!(_mm256_blend_epi32::<0b1010_1010>(even, odd)))
    }
    #[inline(always)]
    fn shr_upper(self, by: u32) -> Avx2 {
        let even = avx2!(_mm256_srl_epi64(self.0, _mm_cvtsi32_si128(by as i32)));
        let odd = avx2!(_mm256_srl_epi64(self.1, _mm_cvtsi32_si128(by as i32 - 32)));
        Avx2(avx2!(_mm256_blend_epi32::<0b1010_1010>(even, odd)))
    }
    #[inline(always)]
    fn narrow(self) -> Avx2 {
        let odd = avx2!(_mm256_slli_epi64::<32>(self.1));
        Avx2(avx2!(_mm256_blend_epi32::<0b1010_1010>(self.0, odd)))
    }
}
