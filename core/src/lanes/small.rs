//! One lane of a machine without vectors (Cortex-M, RV32), on which a 64-bit product costs less than splitting it, and a
//! branch less than the work that it saves. The bits are those of `i32`.

use core::ops::{Add, BitAnd, BitOr, BitXor, Mul, Shl, Shr, Sub};

use super::{Lanes, Wide};
use crate::reciprocal::reciprocal_small;
use crate::table::Coding;

/// One lane of a small machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Small(i32);

/// The 64-bit product of a small machine's lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct SmallWide(i64);

macro_rules! operators {
    ($lane:ty: $($operator:ident $method:ident),*) => {$(
        impl $operator for $lane {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    )*};
}

operators!(Small: Add add, Sub sub, Mul mul, BitAnd bitand, BitOr bitor, BitXor bitxor);
operators!(SmallWide: Add add, Sub sub);

impl Shl<u32> for Small {
    type Output = Self;
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        Self(self.0 << by)
    }
}

impl Shr<u32> for Small {
    type Output = Self;
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        Self(self.0 >> by)
    }
}

/// The upper half of a 64-bit sum.
#[inline(always)]
const fn upper(sum: i64) -> Small {
    Small((sum >> 32) as i32)
}

impl Lanes for Small {
    type Wide = SmallWide;
    type Halves = u16;
    const COUNT: usize = 1;
    const SMALL: bool = true;

    #[inline(always)]
    fn splat(bits: i32) -> Self {
        Self(bits)
    }
    #[inline(always)]
    fn load(row: &[i32], at: usize) -> Self {
        Self(i32::load(row, at))
    }
    #[inline(always)]
    fn store(self, row: &mut [i32], at: usize) {
        self.0.store(row, at);
    }
    #[inline(always)]
    fn load_voxels(row: &[u16], at: usize) -> Self {
        Self(i32::load_voxels(row, at))
    }
    #[inline(always)]
    fn load_as<T: Copy + 'static>(row: &[T], at: usize, bits: impl Fn(T) -> u32) -> Self {
        Self(i32::load_as(row, at, bits))
    }
    #[inline(always)]
    fn store_as<T: Copy + 'static>(self, row: &mut [T], at: usize, element: impl Fn(u32) -> T) {
        self.0.store_as(row, at, element);
    }
    #[inline(always)]
    fn look_up<const N: usize>(values: &[u32; N], samples: &[i32], at: usize, coding: Coding) -> [Self; 2] {
        i32::look_up(values, samples, at, coding).map(Self)
    }
    #[inline(always)]
    fn picked(row: &[i32], place: usize, _: Self) -> Self {
        Self::load(row, place)
    }
    #[inline(always)]
    fn followed_by(self, next: Self) -> Self {
        next
    }
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }
    #[inline(always)]
    fn wrapping_sub(self, other: Self) -> Self {
        Self(self.0.wrapping_sub(other.0))
    }
    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        Self(self.0.wrapping_mul(other.0))
    }
    #[inline(always)]
    fn saturating_add(self, other: Self) -> Self {
        Self(Lanes::saturating_add(self.0, other.0))
    }
    #[inline(always)]
    fn shr_unsigned(self, by: u32) -> Self {
        Self(self.0.shr_unsigned(by))
    }
    #[inline(always)]
    fn shl_each(self, by: Self) -> Self {
        Self(self.0 << by.0)
    }
    #[inline(always)]
    fn shr_each(self, by: Self) -> Self {
        Self(self.0.shr_each(by.0))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Self(Lanes::at_most(self.0, other.0))
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        Self(Lanes::at_least(self.0, other.0))
    }
    #[inline(always)]
    fn at_most_unsigned(self, other: Self) -> Self {
        Self(self.0.at_most_unsigned(other.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.wrapping_abs())
    }
    #[inline(always)]
    fn leading_zeros(self) -> Self {
        Self(Lanes::leading_zeros(self.0))
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        Self(Lanes::nonzero_then(self.0, value.0))
    }
    #[inline(always)]
    fn at_least_then(self, floor: Self, value: Self) -> Self {
        Self(self.0.at_least_then(floor.0, value.0))
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        self.0 == 0
    }
    #[inline(always)]
    fn count(self) -> usize {
        self.0.count()
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
    fn product(self, other: Self) -> SmallWide {
        SmallWide(self.0.product(other.0))
    }
    #[inline(always)]
    fn product_signed(self, other: Self) -> SmallWide {
        SmallWide(self.0.product_signed(other.0))
    }
    #[inline(always)]
    fn reciprocal_root(self) -> Self {
        Self(self.0.reciprocal_root())
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        Self(reciprocal_small(self.0 as u32) as i32)
    }

    /// The upper half is a register.
    #[inline(always)]
    fn product31(self, f: Self) -> Self {
        Self(((u64::from(self.0 as u32) * u64::from((f.0 as u32) << 1)) >> 32) as i32)
    }

    /// A clamp from both sides is one instruction, a minimum three.
    #[inline(always)]
    fn limited(self, limit: i32) -> Self {
        Self(Ord::min(Ord::max(self.0, 0), limit))
    }
    #[inline(always)]
    fn scale16(self, w: Self, bias: u32) -> Self {
        upper(i64::from(self.0 << 1) * i64::from(w.0 << 15) + (i64::from(bias) << 16))
    }
    #[inline(always)]
    fn round15(self, f: Self) -> Self {
        upper(i64::from(self.0 << 2) * i64::from(f.0 << 15) + (1 << 31))
    }
    #[inline(always)]
    fn product16_31(self, a: Self, half: u32) -> Self {
        Self(self.0.product16_31(a.0, half))
    }
    /// A product and a sum are one instruction.
    #[inline(always)]
    fn between16(self, b: Self, w: Self) -> Self {
        Self(self.0 * ((1 << 16) - w.0) + b.0 * w.0)
    }
    #[inline(always)]
    fn mix(self, b: Self, f: Self, bits: u32) -> Self {
        let d = b.0.wrapping_sub(self.0);
        // The fraction as a signed number that fills 32 bits: from one half on it counts backwards from b.
        let f = f.0 << (32 - bits);
        let end = if f < 0 { b.0 } else { self.0 };
        upper((i64::from(end) << 32).wrapping_add(i64::from(d) * i64::from(f) + (1 << 31)))
    }
}

impl Wide for SmallWide {
    type Narrow = Small;

    #[inline(always)]
    fn splat(bits: i64) -> Self {
        Self(bits)
    }
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        Self(Wide::shr(self.0, by))
    }
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        Self(self.0 << by)
    }
    #[inline(always)]
    fn shr_each(self, by: Small) -> Self {
        Self(Wide::shr_each(self.0, by.0))
    }
    #[inline(always)]
    fn at_least_zero(self) -> Self {
        Self(self.0.at_least_zero())
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Self(Wide::at_most(self.0, other.0))
    }
    #[inline(always)]
    fn times(self, other: Small) -> Self {
        Self(self.0.times(other.0))
    }
    #[inline(always)]
    fn square31(self) -> Self {
        let x = self.0 as u32;
        if x < 1 << 31 {
            // Twice the square, whose upper half is rounded by the top bit of the lower.
            let square = u64::from(x << 1) * u64::from(x);
            Self(i64::from((square >> 32) as u32 + (square as u32 >> 31)))
        } else {
            Self(self.0.square31())
        }
    }
    #[inline(always)]
    fn shr_upper(self, by: u32) -> Small {
        Small(self.0.shr_upper(by))
    }
    #[inline(always)]
    fn shr_to_one(self, by: u32) -> Self {
        Self(self.0.shr_to_one(by))
    }
    #[inline(always)]
    fn low_product(self, other: Self) -> Self {
        Self(self.0.low_product(other.0))
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        Self(Wide::nonzero_then(self.0, value.0))
    }
    #[inline(always)]
    fn any_at_least(self, least: u32) -> bool {
        self.0.any_at_least(least)
    }
    #[inline(always)]
    fn of(narrow: Small) -> Self {
        Self(i64::of(narrow.0))
    }
    #[inline(always)]
    fn narrow(self) -> Small {
        Small(self.0.narrow())
    }
}
