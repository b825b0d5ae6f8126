//! Two vectors of 16-bit lanes side by side: stages that are long chains of dependent operations take as long for two as for one.

use super::Halves;

/// Twice as many lanes: those of the first, then those of the second.
#[derive(Clone, Copy)]
pub(crate) struct Two<H>(H, H);

/// The first and the second of three.
#[inline(always)]
fn parted<H: Halves>([x, y, z]: [Two<H>; 3]) -> ([H; 3], [H; 3]) {
    ([x.0, y.0, z.0], [x.1, y.1, z.1])
}

impl<H: Halves> Halves for Two<H> {
    type Shifts = (H::Shifts, H::Shifts);
    type Direction = H::Direction;
    const COUNT: usize = 2 * H::COUNT;

    #[inline(always)]
    fn splat(bits: u16) -> Self {
        let lanes = H::splat(bits);
        Self(lanes, lanes)
    }
    #[inline(always)]
    fn load<const WHOLE: bool>(row: &[u16], at: usize) -> Self {
        Self(H::load::<WHOLE>(row, at), H::load::<WHOLE>(row, at + H::COUNT))
    }
    #[inline(always)]
    fn load_pairs<const N: usize>(row: &[u32; N], at: usize) -> [Self; 2] {
        let ([a, b], [c, d]) = (H::load_pairs(row, at), H::load_pairs(row, at + H::COUNT));
        [Self(a, c), Self(b, d)]
    }
    #[inline(always)]
    fn store<const WHOLE: bool>(self, row: &mut [u16], at: usize) {
        self.0.store::<WHOLE>(row, at);
        self.1.store::<WHOLE>(row, at + H::COUNT);
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(self.0.plus(other.0), self.1.plus(other.1))
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(self.0.minus(other.0), self.1.minus(other.1))
    }
    #[inline(always)]
    fn plus_saturating(self, other: Self) -> Self {
        Self(self.0.plus_saturating(other.0), self.1.plus_saturating(other.1))
    }
    #[inline(always)]
    fn minus_saturating(self, other: Self) -> Self {
        Self(self.0.minus_saturating(other.0), self.1.minus_saturating(other.1))
    }
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        Self(self.0.shl(by), self.1.shl(by))
    }
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        Self(self.0.shr(by), self.1.shr(by))
    }
    #[inline(always)]
    fn shr_signed(self, by: u32) -> Self {
        Self(self.0.shr_signed(by), self.1.shr_signed(by))
    }
    #[inline(always)]
    fn product_high(self, other: Self) -> Self {
        Self(self.0.product_high(other.0), self.1.product_high(other.1))
    }
    #[inline(always)]
    fn product_low(self, other: Self) -> Self {
        Self(self.0.product_low(other.0), self.1.product_low(other.1))
    }
    #[inline(always)]
    fn product_round(self, other: Self) -> Self {
        Self(self.0.product_round(other.0), self.1.product_round(other.1))
    }
    #[inline(always)]
    fn product_plus(self, other: Self, offset: u16) -> Self {
        Self(
            self.0.product_plus(other.0, offset),
            self.1.product_plus(other.1, offset),
        )
    }
    #[inline(always)]
    fn top_then_else(self, value: Self, other: Self) -> Self {
        Self(
            self.0.top_then_else(value.0, other.0),
            self.1.top_then_else(value.1, other.1),
        )
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        Self(self.0.nonzero_then(value.0), self.1.nonzero_then(value.1))
    }
    #[inline(always)]
    fn at_least_or_zero(self, floor: Self) -> Self {
        Self(self.0.at_least_or_zero(floor.0), self.1.at_least_or_zero(floor.1))
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        self.0.all_zero() && self.1.all_zero()
    }
    #[inline(always)]
    fn normalised(vector: [Self; 3]) -> (Self::Shifts, Self) {
        let (first, second) = parted(vector);
        let ((k, h), (l, i)) = (H::normalised(first), H::normalised(second));
        ((k, l), Self(h, i))
    }
    #[inline(always)]
    fn direction(vector: [i16; 3]) -> H::Direction {
        H::direction(vector)
    }
    #[inline(always)]
    fn facing(a: [Self; 3], b: H::Direction, (k, l): Self::Shifts) -> Self {
        let (first, second) = parted(a);
        Self(H::facing(first, b, k), H::facing(second, b, l))
    }
}
