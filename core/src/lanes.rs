//! Lanes: several samples side by side, all treated alike.
//!
//! Every stage is written once, over [`Lanes`]. With `i32` (one lane) it is the scalar definition, and what firmware
//! runs; a host puts vectors of its processor in its place and gets the same bits, because all arithmetic is of
//! integers and every operation here is defined by what `i32` does. Lanes hold 32 bits, read as signed or unsigned by
//! the operation; [`Wide`] holds a 64-bit product of each.
//!
//! Operators (`+`, `-`, `*`) are for results that fit: `i32` checks them in debug builds. What may wrap says so.

mod halves;
mod scalar;
mod small;
pub(crate) mod two;

use core::ops::{Add, BitAnd, BitOr, BitXor, Mul, Shl, Shr, Sub};

pub use self::halves::Halves;
pub use self::small::Small;
use crate::table::Coding;

/// The lane that is fastest on this machine without vectors: what a stream folds with.
#[cfg(any(target_arch = "arm", target_arch = "riscv32"))]
pub type Native = Small;
/// The lane that is fastest on this machine without vectors: what a stream folds with.
#[cfg(not(any(target_arch = "arm", target_arch = "riscv32")))]
pub type Native = i32;

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

/// Does the same at each place of rows of this length, in lanes of 16 bits: first where whole vectors lie inside, then what is left.
/// Twice the code, so that the loop has none for the ends of rows.
macro_rules! each {
    ($halves:ty, $len:expr, |$at:ident, $whole:ident| $body:block) => {{
        let len: usize = $len;
        let mut $at = 0;
        {
            const $whole: bool = true;
            while $at < len.saturating_sub(<$halves>::COUNT - 1) {
                $body
                $at += <$halves>::COUNT;
            }
        }
        if $at < len {
            const $whole: bool = false;
            $body
        }
    }};
}

pub(crate) use each;

/// What [`Lanes::enter`] runs. [`Kernel::run`] and all that it calls are `inline(always)`: vectors stay in registers only
/// inside the function that is compiled for them. A closure cannot be marked so, and a large one is not inlined.
pub trait Kernel {
    /// What comes of it.
    type Output;
    /// Whether one lane does it where it is called: little work beside a call, or called from a function that does nothing else.
    const BRIEF: bool = false;
    /// Does the work.
    fn run(self) -> Self::Output;
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
    /// As many bits in lanes of 16.
    type Halves: Halves;
    /// How many lanes.
    const COUNT: usize;
    /// Whether the machine is a small one: code is scarce, and a branch costs less than the work that it saves. One
    /// pipeline is then compiled as a whole; elsewhere its kernels are compiled one by one and called per row.
    const SMALL: bool = false;

    /// Runs a kernel, compiled for the instructions of these lanes.
    #[inline(always)]
    fn enter<K: Kernel>(kernel: K) -> K::Output {
        kernel.run()
    }

    /// The same number in all lanes.
    fn splat(bits: i32) -> Self;
    /// Elements `at ..` of a row; 0 behind its end.
    fn load(row: &[i32], at: usize) -> Self;
    /// Writes to elements `at ..` of a row, as far as it goes.
    fn store(self, row: &mut [i32], at: usize);
    /// Voxels `at ..` of a row; 0 behind its end.
    fn load_voxels(row: &[u16], at: usize) -> Self;
    /// The same where the row has as many; where it has fewer, anything. Without code for the ends of rows, of which each load has
    /// its own.
    #[inline(always)]
    fn load_inner_voxels(row: &[u16], at: usize) -> Self {
        Self::load_voxels(row, at)
    }
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
    /// Of a table of another length than [`Neighboured`](crate::table::Neighboured) so many low bits of a code count as it takes; `N` is one more than a power
    /// of two.
    fn look_up<const N: usize>(values: &[u32; N], samples: &[i32], at: usize, coding: Coding) -> [Self; 2];

    /// The elements of a row at a place and these many behind it, each fewer than twice the number of lanes, with one lane none: two vectors
    /// are loaded, and no memory is gathered. 0 behind the end of the row.
    fn picked(row: &[i32], place: usize, offsets: Self) -> Self;

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
    /// [`reciprocal_root`](crate::root::reciprocal_root) of each lane: 0, or 2^28 to 3 * 32767^2.
    fn reciprocal_root(self) -> Self;

    /// [`reciprocal`](crate::reciprocal::reciprocal) of each lane: 2^26 to 2^27 - 1.
    fn reciprocal(self) -> Self;

    /// `floor(a f / 2^31)` of unsigned numbers: f < 2^31.
    #[inline(always)]
    fn product31(self, f: Self) -> Self {
        self.product(f).shr_narrow(31)
    }

    /// The smaller of a number of 0 or more and a limit.
    #[inline(always)]
    fn limited(self, limit: i32) -> Self {
        self.at_most(Self::splat(limit))
    }

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
    /// Right shift by another amount in each lane, 0 to 63, filling with zeros.
    fn shr_each(self, by: Self::Narrow) -> Self;
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
    /// The low 32 bits after a right shift by 32 to 63.
    #[inline(always)]
    fn shr_upper(self, by: u32) -> Self::Narrow {
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
