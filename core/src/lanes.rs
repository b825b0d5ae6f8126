//! Lanes: several samples side by side, all treated alike.
//!
//! Every stage is written once, over [`Lanes`]. With `i32` (one lane) it is the scalar definition, and what firmware
//! runs; a host puts vectors of its processor in its place and gets the same bits, because all arithmetic is of
//! integers and every operation here is defined by what `i32` does. Lanes hold 32 bits, read as signed or unsigned by
//! the operation; [`Wide`] holds a 64-bit product of each.
//!
//! Operators (`+`, `-`, `*`) are for results that fit: `i32` checks them in debug builds. What may wrap says so.

use core::ops::{Add, BitAnd, BitOr, BitXor, Mul, Shl, Shr, Sub};

use crate::classify::ENTRIES;
use crate::normalise::reciprocal_root;

/// Whether the machine is one without vectors, where a 64-bit product costs less than splitting it, and a branch less
/// than the work that it saves.
pub(crate) const SMALL: bool = cfg!(any(target_arch = "arm", target_arch = "riscv32"));

/// The places at which a loop over rows of this length handles its lanes. Row kernels first cut all their rows to that
/// length: with a single lane the compiler then sees that every place lies inside, and leaves its checks out.
#[inline(always)]
pub fn places<V: Lanes>(len: usize) -> impl Iterator<Item = usize> {
    let mut next = 0;
    core::iter::from_fn(move || {
        let at = next;
        next += V::COUNT;
        (at < len).then_some(at)
    })
}

/// A value a code, and one more behind the last for its neighbour.
pub type Neighboured = [u32; ENTRIES + 1];

/// How samples find their codes: `(sample + offset) >> bits`, of which the low 12 bits count. Samples are 0 to 2^28, offsets
/// below 2^15.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coding {
    /// What is added before the fraction is cut off.
    pub offset: i32,
    /// Bits of the fraction.
    pub bits: u32,
}

/// Some 32-bit lanes.
pub trait Lanes:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// The 64-bit products of these lanes.
    type Wide: Wide<Narrow = Self>;
    /// How many lanes.
    const COUNT: usize;

    /// The same number in all lanes.
    fn splat(bits: i32) -> Self;
    /// Elements `at ..` of a row; 0 behind its end.
    fn load(row: &[i32], at: usize) -> Self;
    /// Writes to elements `at ..` of a row, as far as it goes.
    fn store(self, row: &mut [i32], at: usize);
    /// Voxels `at ..` of a row; 0 behind its end.
    fn load_voxels(row: &[u16], at: usize) -> Self;
    /// Elements `at ..` of a row of some other type; 0 behind its end.
    fn load_as<T: Copy + 'static>(row: &[T], at: usize, bits: impl Fn(T) -> u32) -> Self;
    /// Writes to elements `at ..` of such a row, as far as it goes.
    fn store_as<T: Copy + 'static>(self, row: &mut [T], at: usize, element: impl Fn(u32) -> T);
    /// [`Lanes::store_as`] of two, one behind the other, into a row of numbers.
    #[inline(always)]
    fn store_two_as<T: Copy + 'static>(
        [first, second]: [Self; 2],
        row: &mut [T],
        at: usize,
        element: impl Fn(u32) -> T,
    ) {
        first.store_as(row, at, &element);
        second.store_as(row, at + Self::COUNT, element);
    }
    /// Adds the upper 16 bits of two, one behind the other, to the elements of a row, which are numbers; the sums fit 16
    /// bits.
    #[inline(always)]
    fn add_upper_as<T: Copy + 'static>(
        [first, second]: [Self; 2],
        row: &mut [T],
        at: usize,
        bits: impl Fn(T) -> u32,
        element: impl Fn(u32) -> T,
    ) {
        let sum = Self::load_as(row, at, &bits) + first.shr_unsigned(16);
        sum.store_as(row, at, &element);
        let at = at + Self::COUNT;
        (Self::load_as(row, at, bits) + second.shr_unsigned(16)).store_as(row, at, element);
    }
    /// The table's values at the codes of the samples `at ..` of a row, and the next ones; samples of 0 behind its end. From
    /// the row in memory, because taking a vector apart costs a host more than loading its parts.
    fn look_up(values: &Neighboured, samples: &[i32], at: usize, coding: Coding) -> [Self; 2];

    /// Lanes 1 .. of this and the first of `next`: each lane's right neighbour.
    fn followed_by(self, next: Self) -> Self;
    /// Sum modulo 2^32.
    fn wrapping_add(self, other: Self) -> Self;
    /// Difference modulo 2^32.
    fn wrapping_sub(self, other: Self) -> Self;
    /// Product modulo 2^32.
    fn wrapping_mul(self, other: Self) -> Self;
    /// Unsigned sum, at most 2^32 - 1.
    fn saturating_add(self, other: Self) -> Self;
    /// Right shift that fills with zeros.
    fn shr_unsigned(self, by: u32) -> Self;
    /// Left shift by another amount in each lane, 0 to 31.
    fn shl_each(self, by: Self) -> Self;
    /// Right shift by another amount in each lane, 0 to 31, filling with zeros.
    fn shr_each(self, by: Self) -> Self;
    /// The smaller, as signed numbers.
    fn at_most(self, other: Self) -> Self;
    /// The larger, as signed numbers.
    fn at_least(self, other: Self) -> Self;
    /// The smaller, as unsigned numbers.
    fn at_most_unsigned(self, other: Self) -> Self;
    /// Magnitude of a signed number above -2^31.
    fn abs(self) -> Self;
    /// Zero bits above the highest bit that is set.
    fn leading_zeros(self) -> Self;
    /// `value` where this is not 0, else 0.
    fn nonzero_then(self, value: Self) -> Self;
    /// `value` where this is at least `floor`, as unsigned numbers, else 0.
    fn at_least_then(self, floor: Self, value: Self) -> Self;
    /// Whether all lanes are 0.
    fn all_zero(self) -> bool;
    /// How many lanes are not 0.
    fn count(self) -> usize;
    /// The lanes where `chosen` is not 0, in their order, in the first lanes; the others hold anything.
    fn packed(self, chosen: Self) -> Self;
    /// The first lanes, in their order, in those where `chosen` is not 0; the others hold anything.
    fn spread(self, chosen: Self) -> Self;
    /// Unsigned 32 by 32 bits.
    fn product(self, other: Self) -> Self::Wide;
    /// Signed 32 by 32 bits.
    fn product_signed(self, other: Self) -> Self::Wide;
    /// [`reciprocal_root`] of each lane: 0, or 2^28 to 3 * 32767^2.
    fn reciprocal_root(self) -> Self;

    /// This, or its negative where `sign` is negative.
    #[inline(always)]
    fn with_sign_of(self, sign: Self) -> Self {
        let mask = sign >> 31;
        (self ^ mask) - mask
    }

    /// `floor((d w + bias) / 2^16)`: |d| < 2^30, 0 <= w < 2^16, bias < 2^16.
    #[inline(always)]
    fn scale16(self, w: Self, bias: u32) -> Self {
        let low = (self & Self::splat(0xffff))
            .wrapping_mul(w)
            .wrapping_add(Self::splat(bias as i32));
        (self >> 16) * w + low.shr_unsigned(16)
    }

    /// `floor((g f + 2^14) / 2^15)`: |g| < 2^29, 0 <= f <= 2^15.
    #[inline(always)]
    fn round15(self, f: Self) -> Self {
        (self >> 15) * f + (((self & Self::splat(0x7fff)) * f + Self::splat(1 << 14)) >> 15)
    }

    /// `floor((t a + half) / 2^31)` of unsigned numbers: t < 2^16, a < 2^31, half <= 2^31 - 2^15.
    #[inline(always)]
    fn product16_31(self, a: Self, half: u32) -> Self {
        // The sum of both parts is at most (2^16 - 1)^2 + 2^17 - 5.
        let low = self.wrapping_mul(a & Self::splat(0x7fff));
        let low = low.wrapping_add(Self::splat(half as i32)).shr_unsigned(15);
        let high = self.wrapping_mul(a.shr_unsigned(15));
        high.wrapping_add(low).shr_unsigned(16)
    }

    /// `(a << 16) + (b - a) w`, exact: |a|, |b| < 2^14, 0 <= w < 2^16.
    #[inline(always)]
    fn between16(self, b: Self, w: Self) -> Self {
        (self << 16) + (b - self) * w
    }

    /// `a + floor(((b - a) f + 2^(bits - 1)) / 2^bits)` of unsigned numbers: |b - a| < 2^31, 0 <= f < 2^bits, bits 1 to
    /// 15.
    #[inline(always)]
    fn mix(self, b: Self, f: Self, bits: u32) -> Self {
        let d = b.wrapping_sub(self);
        let low = ((d & Self::splat(0xffff)) * f + Self::splat(1 << bits >> 1)) >> bits;
        self.wrapping_add((((d >> 16) * f) << (16 - bits)).wrapping_add(low))
    }
}

/// A 64-bit product of each lane.
pub trait Wide: Copy + Add<Output = Self> + Sub<Output = Self> {
    /// The 32-bit lanes.
    type Narrow: Lanes<Wide = Self>;
    /// The same number in all lanes.
    fn splat(bits: i64) -> Self;
    /// Right shift that fills with zeros.
    fn shr(self, by: u32) -> Self;
    /// Left shift.
    fn shl(self, by: u32) -> Self;
    /// 0 where this is negative.
    fn at_least_zero(self) -> Self;
    /// The smaller, as signed numbers.
    fn at_most(self, other: Self) -> Self;
    /// Product with a 32-bit unsigned number.
    fn times(self, other: Self::Narrow) -> Self;
    /// The square of a number of 31 fraction bits, at most 1, to nearest.
    #[inline(always)]
    fn square31(self) -> Self {
        (self.low_product(self) + Self::splat(1 << 30)).shr(31)
    }
    /// The low 32 bits after a right shift by 1 to 31.
    #[inline(always)]
    fn shr_narrow(self, by: u32) -> Self::Narrow {
        self.shr(by).narrow()
    }
    /// The low 32 bits after a right shift by 1 to 31, at most 2^31 as an unsigned number.
    fn shr_to_one(self, by: u32) -> Self;
    /// Product of the low 32 bits, unsigned.
    fn low_product(self, other: Self) -> Self;
    /// `value` where this is not 0, else 0.
    fn nonzero_then(self, value: Self) -> Self;
    /// Whether any is at least `least`, as unsigned numbers of 32 bits (more there are not).
    fn any_at_least(self, least: u32) -> bool;
    /// Unsigned 32-bit lanes in 64 bits.
    fn of(narrow: Self::Narrow) -> Self;
    /// The low 32 bits.
    fn narrow(self) -> Self::Narrow;
}

impl Lanes for i32 {
    type Wide = i64;
    const COUNT: usize = 1;

    #[inline(always)]
    fn splat(bits: i32) -> Self {
        bits
    }
    #[inline(always)]
    fn load(row: &[i32], at: usize) -> Self {
        row.get(at).copied().unwrap_or(0)
    }
    #[inline(always)]
    fn store(self, row: &mut [i32], at: usize) {
        if let Some(place) = row.get_mut(at) {
            *place = self;
        }
    }
    #[inline(always)]
    fn load_voxels(row: &[u16], at: usize) -> Self {
        row.get(at).copied().map_or(0, Self::from)
    }
    #[inline(always)]
    fn load_as<T: Copy + 'static>(row: &[T], at: usize, bits: impl Fn(T) -> u32) -> Self {
        row.get(at).copied().map_or(0, |t| bits(t) as Self)
    }
    #[inline(always)]
    fn store_as<T: Copy + 'static>(self, row: &mut [T], at: usize, element: impl Fn(u32) -> T) {
        if let Some(place) = row.get_mut(at) {
            *place = element(self as u32);
        }
    }
    #[inline(always)]
    fn look_up(values: &Neighboured, samples: &[i32], at: usize, coding: Coding) -> [Self; 2] {
        let sample = Self::load(samples, at).wrapping_add(coding.offset);
        let code = (sample as u32 >> coding.bits) as usize % ENTRIES;
        let at = |code: usize| values.get(code).map_or(0, |value| *value as Self);
        [at(code), at(code + 1)]
    }
    #[inline(always)]
    fn followed_by(self, next: Self) -> Self {
        next
    }
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        self.wrapping_add(other)
    }
    #[inline(always)]
    fn wrapping_sub(self, other: Self) -> Self {
        self.wrapping_sub(other)
    }
    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        self.wrapping_mul(other)
    }
    #[inline(always)]
    fn saturating_add(self, other: Self) -> Self {
        (self as u32).saturating_add(other as u32) as Self
    }
    #[inline(always)]
    fn shr_unsigned(self, by: u32) -> Self {
        (self as u32 >> by) as Self
    }
    #[inline(always)]
    fn shl_each(self, by: Self) -> Self {
        self << by
    }
    #[inline(always)]
    fn shr_each(self, by: Self) -> Self {
        (self as u32 >> by) as Self
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Ord::min(self, other)
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        Ord::max(self, other)
    }
    #[inline(always)]
    fn at_most_unsigned(self, other: Self) -> Self {
        Ord::min(self as u32, other as u32) as Self
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.wrapping_abs()
    }
    #[inline(always)]
    fn leading_zeros(self) -> Self {
        self.leading_zeros() as Self
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        if self != 0 { value } else { 0 }
    }
    #[inline(always)]
    fn at_least_then(self, floor: Self, value: Self) -> Self {
        if self as u32 >= floor as u32 { value } else { 0 }
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        self == 0
    }
    #[inline(always)]
    fn count(self) -> usize {
        usize::from(self != 0)
    }
    #[inline(always)]
    fn packed(self, _: Self) -> Self {
        self
    }
    #[inline(always)]
    fn spread(self, _: Self) -> Self {
        self
    }
    #[inline(always)]
    fn product(self, other: Self) -> i64 {
        (u64::from(self as u32) * u64::from(other as u32)) as i64
    }
    #[inline(always)]
    fn product_signed(self, other: Self) -> i64 {
        i64::from(self) * i64::from(other)
    }
    #[inline(always)]
    fn reciprocal_root(self) -> Self {
        reciprocal_root(self as u32) as Self
    }
    #[inline(always)]
    fn scale16(self, w: Self, bias: u32) -> Self {
        if SMALL {
            ((i64::from(self << 1) * i64::from(w << 15) + (i64::from(bias) << 16)) >> 32) as Self
        } else {
            let low = ((self & 0xffff) as u32 * w as u32 + bias) >> 16;
            (self >> 16) * w + low as Self
        }
    }
    #[inline(always)]
    fn round15(self, f: Self) -> Self {
        if SMALL {
            ((i64::from(self << 2) * i64::from(f << 15) + (1 << 31)) >> 32) as Self
        } else {
            (self >> 15) * f + (((self & 0x7fff) * f + (1 << 14)) >> 15)
        }
    }
    #[inline(always)]
    fn product16_31(self, a: Self, half: u32) -> Self {
        ((u64::from(self as u32) * u64::from(a as u32) + u64::from(half)) >> 31) as Self
    }
    #[inline(always)]
    fn between16(self, b: Self, w: Self) -> Self {
        if SMALL {
            // A product and a sum are one instruction.
            self * ((1 << 16) - w) + b * w
        } else {
            (self << 16) + (b - self) * w
        }
    }
    #[inline(always)]
    fn mix(self, b: Self, f: Self, bits: u32) -> Self {
        let d = b.wrapping_sub(self);
        if SMALL {
            // The fraction as a signed number that fills 32 bits: from one half on it counts backwards from b.
            let f = f << (32 - bits);
            let end = if f < 0 { b } else { self };
            let sum = (i64::from(end) << 32).wrapping_add(i64::from(d) * i64::from(f) + (1 << 31));
            (sum >> 32) as Self
        } else {
            let low = ((d & 0xffff) * f + (1 << bits >> 1)) >> bits;
            self.wrapping_add((((d >> 16) * f) << (16 - bits)) + low)
        }
    }
}

impl Wide for i64 {
    type Narrow = i32;

    #[inline(always)]
    fn splat(bits: i64) -> Self {
        bits
    }
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        (self as u64 >> by) as Self
    }
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        self << by
    }
    #[inline(always)]
    fn at_least_zero(self) -> Self {
        Ord::max(self, 0)
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Ord::min(self, other)
    }
    #[inline(always)]
    fn times(self, other: i32) -> Self {
        self * Self::from(other as u32)
    }
    #[inline(always)]
    fn square31(self) -> Self {
        let x = self as u32;
        if SMALL && x < 1 << 31 {
            // Twice the square, whose upper half is rounded by the top bit of the lower.
            let square = u64::from(x << 1) * u64::from(x);
            Self::from((square >> 32) as u32 + (square as u32 >> 31))
        } else {
            (self.low_product(self) + (1 << 30)) >> 31
        }
    }
    #[inline(always)]
    fn shr_to_one(self, by: u32) -> Self {
        Self::from(Ord::min((self as u64 >> by) as u32, 1 << 31))
    }
    #[inline(always)]
    fn low_product(self, other: Self) -> Self {
        (u64::from(self as u32) * u64::from(other as u32)) as Self
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        if self != 0 { value } else { 0 }
    }
    #[inline(always)]
    fn any_at_least(self, least: u32) -> bool {
        self as u32 >= least
    }
    #[inline(always)]
    fn of(narrow: i32) -> Self {
        Self::from(narrow as u32)
    }
    #[inline(always)]
    fn narrow(self) -> i32 {
        self as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn d() -> impl Strategy<Value = i32> {
        let limit = 16380 << 16;
        prop_oneof![-limit..=limit, Just(limit), Just(-limit), -70_000..70_000]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn scale16_is_the_floor(d in d(), w in 0i32..65536, bias in 0u32..65536) {
            let exact = (i64::from(d) * i64::from(w) + i64::from(bias)) >> 16;
            prop_assert_eq!(i64::from(d.scale16(w, bias)), exact);
        }

        #[test]
        fn round15_is_the_nearest(g in -(1i32 << 29)..(1 << 29), f in 0i32..=32768) {
            let exact = (i64::from(g) * i64::from(f) + (1 << 14)) >> 15;
            prop_assert_eq!(i64::from(g.round15(f)), exact);
        }

        #[test]
        fn mixes_are_the_nearest(
            a in 0u32..=1 << 31, b in 0u32..=1 << 31, f in 0i32..1 << 15, bits in prop_oneof![Just(12u32), Just(15)],
        ) {
            // Two values that are 2^31 apart do not occur: no entry is quite opaque.
            let (b, f) = (b.min(a.saturating_add((1 << 31) - 1)), f & ((1 << bits) - 1));
            let a = a.min(b.saturating_add((1 << 31) - 1));
            let product = (i64::from(b) - i64::from(a)) * i64::from(f);
            let exact = i64::from(a) + ((product + (1 << bits >> 1)) >> bits);
            prop_assert_eq!(i64::from((a as i32).mix(b as i32, f, bits) as u32), exact);
        }

        #[test]
        fn between_is_exact(a in -8190i32..=8190, b in -8190i32..=8190, w in 0i32..65536) {
            prop_assert_eq!(a.between16(b, w), (a << 16) + (b - a) * w);
        }
    }
}
