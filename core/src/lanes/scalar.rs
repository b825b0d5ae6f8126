//! One lane: the scalar definition.

use super::{Kernel, Lanes, Wide};
use crate::reciprocal::reciprocal;
use crate::root::reciprocal_root;
use crate::table::Coding;

impl Lanes for i32 {
    type Wide = i64;
    type Halves = u16;
    const COUNT: usize = 1;

    /// A function for each kernel, as of vectors: pipelines share it, and it shares no registers with what surrounds it.
    #[inline(always)]
    fn enter<K: Kernel>(kernel: K) -> K::Output {
        #[inline(never)]
        fn entry<K: Kernel>(kernel: K) -> K::Output {
            kernel.run()
        }
        if K::BRIEF { kernel.run() } else { entry(kernel) }
    }

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
    fn look_up<const N: usize>(values: &[u32; N], samples: &[i32], at: usize, coding: Coding) -> [Self; 2] {
        const { assert!((N - 1).is_power_of_two()) };
        let sample = Self::load(samples, at).wrapping_add(coding.offset);
        let code = (sample as u32 >> coding.bits) as usize & (N - 2);
        let at = |code: usize| values.get(code).map_or(0, |value| *value as Self);
        [at(code), at(code + 1)]
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
    fn reciprocal(self) -> Self {
        reciprocal(self as u32) as Self
    }
    #[inline(always)]
    fn scale16(self, w: Self, bias: u32) -> Self {
        if cfg!(target_pointer_width = "64") {
            // Of numbers without sign: d + 2^31, whose product is 2^31 w more.
            let product = u64::from(self as u32 ^ (1 << 31)) * u64::from(w as u32) + u64::from(bias);
            return ((product >> 16) as u32).wrapping_sub((w as u32) << 15) as Self;
        }
        let low = ((self & 0xffff) as u32 * w as u32 + bias) >> 16;
        (self >> 16) * w + low as Self
    }
    #[inline(always)]
    fn product16_31(self, a: Self, half: u32) -> Self {
        ((u64::from(self as u32) * u64::from(a as u32) + u64::from(half)) >> 31) as Self
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
    fn shr_each(self, by: i32) -> Self {
        (self as u64 >> by) as Self
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
    /// Of the upper half alone.
    #[inline(always)]
    fn shr_upper(self, by: u32) -> i32 {
        ((self as u64 >> 32) as u32 >> (by - 32)) as i32
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
