//! Sixteen-bit lanes: what the `fast` precision computes in.
//!
//! A lane is 16 bits, read as signed or unsigned by the operation. Products are of 16 by 16 bits; what needs all 32 bits of
//! one is a single operation here, so that vectors hold them in an order of their own. With `u16`, one lane, every operation
//! is its definition.

/// Some 16-bit lanes.
pub trait Halves: Copy {
    /// Shifts of [`Halves::normalised`], in whatever order.
    type Shifts: Copy;
    /// A vector as [`Halves::facing`] multiplies by it.
    type Direction: Copy;
    /// How many lanes.
    const COUNT: usize;

    /// The same number in all lanes.
    fn splat(bits: u16) -> Self;
    /// The same number in all lanes, made at this place: outside of the loop a compiler widens it for products, and with it the other
    /// factor.
    #[inline(always)]
    fn splat_here(bits: u16) -> Self {
        Self::splat(if Self::COUNT > 1 {
            core::hint::black_box(bits)
        } else {
            bits
        })
    }

    /// Elements `at ..` of a row; 0 behind its end. `WHOLE`: the row has as many.
    fn load<const WHOLE: bool>(row: &[u16], at: usize) -> Self;
    /// The lower and the upper halves of the numbers `at ..` of a row; 0 behind the last whole vector of it.
    fn load_pairs<const N: usize>(row: &[u32; N], at: usize) -> [Self; 2];
    /// Writes to elements `at ..` of a row, as far as it goes. `WHOLE`: the row has as many.
    fn store<const WHOLE: bool>(self, row: &mut [u16], at: usize);

    /// Sum modulo 2^16.
    fn plus(self, other: Self) -> Self;
    /// Difference modulo 2^16.
    fn minus(self, other: Self) -> Self;
    /// Unsigned sum, at most 65535.
    fn plus_saturating(self, other: Self) -> Self;
    /// Unsigned difference, at least 0.
    fn minus_saturating(self, other: Self) -> Self;
    /// Left shift by less than 16.
    fn shl(self, by: u32) -> Self;
    /// Right shift by less than 16 that fills with zeros.
    fn shr(self, by: u32) -> Self;
    /// Right shift by less than 16 that fills with the sign.
    fn shr_signed(self, by: u32) -> Self;

    /// The upper half of the unsigned product.
    fn product_high(self, other: Self) -> Self;
    /// The lower half of the product.
    fn product_low(self, other: Self) -> Self;
    /// `(a b + 2^14) >> 15` of signed numbers; b is not -32768.
    fn product_round(self, other: Self) -> Self;
    /// `(a b + offset) >> 16` of unsigned numbers; the offset is not 0.
    fn product_plus(self, other: Self, offset: u16) -> Self;

    /// `value` where the top bit is set, else `other`.
    fn top_then_else(self, value: Self, other: Self) -> Self;
    /// `value` where this is not 0, else 0.
    fn nonzero_then(self, value: Self) -> Self;
    /// This where it is at least `floor`, as unsigned numbers, else 0.
    fn at_least_or_zero(self, floor: Self) -> Self;
    /// Whether all lanes are 0.
    fn all_zero(self) -> bool;

    /// How many lanes are not 0.
    #[inline(always)]
    fn count(self) -> usize {
        self.lanes().iter().filter(|lane| **lane != 0).count()
    }
    /// Writes the lanes that are not 0 in `chosen` side by side to elements `at ..` of a row, as far as it goes; how many they are. As many
    /// elements as there are lanes may be changed.
    #[inline(always)]
    fn store_packed(self, chosen: Self, row: &mut [u16], at: usize) -> usize {
        let mut places = row.get_mut(at..).unwrap_or(&mut []).iter_mut();
        for (lane, _) in self
            .lanes()
            .iter()
            .zip(chosen.lanes())
            .filter(|(_, chosen)| *chosen != 0)
        {
            if let Some(place) = places.next() {
                *place = *lane;
            }
        }
        chosen.count()
    }
    /// Elements `at ..` of a row, one after the other in the lanes that are not 0 in `chosen`; 0 in the others, and behind the row's end.
    #[inline(always)]
    fn load_spread(row: &[u16], at: usize, chosen: Self) -> Self {
        let mut elements = row.get(at..).unwrap_or(&[]).iter();
        let mut lanes = chosen.lanes();
        for lane in lanes.iter_mut().filter(|lane| **lane != 0) {
            *lane = elements.next().copied().unwrap_or(0);
        }
        Self::load::<false>(&lanes, 0)
    }
    /// The lanes, and zeros behind them.
    #[inline(always)]
    fn lanes(self) -> [u16; 64] {
        let mut lanes = [0; 64];
        self.store::<false>(lanes.get_mut(..Self::COUNT).unwrap_or(&mut []), 0);
        lanes
    }

    /// Of the squared length S of a vector of signed numbers above -2^15, the shift `k = min(15, clz(S) >> 1)`, and the upper half of
    /// `S << 2 k`: at least 16384, or 0 where the vector is.
    fn normalised(vector: [Self; 3]) -> (Self::Shifts, Self);
    /// The same vector for all lanes, no longer than 32767.
    fn direction(vector: [i16; 3]) -> Self::Direction;
    /// `((a . b << k) + 2^14) >> 15` of signed numbers, held to 0 and 65535, where k is of `a`.
    fn facing(a: [Self; 3], b: Self::Direction, k: Self::Shifts) -> Self;
}

/// Numbers as signed ones.
#[inline(always)]
fn signed(vector: [u16; 3]) -> [i32; 3] {
    crate::rows::three(vector, |c| i32::from(c as i16))
}

impl Halves for u16 {
    type Shifts = u32;
    type Direction = [i16; 3];
    const COUNT: usize = 1;

    #[inline(always)]
    fn splat(bits: u16) -> Self {
        bits
    }
    #[inline(always)]
    fn load<const WHOLE: bool>(row: &[u16], at: usize) -> Self {
        row.get(at).copied().unwrap_or(0)
    }
    #[inline(always)]
    fn load_pairs<const N: usize>(row: &[u32; N], at: usize) -> [Self; 2] {
        let pair = row.get(at).copied().unwrap_or(0);
        [pair as Self, (pair >> 16) as Self]
    }
    #[inline(always)]
    fn store<const WHOLE: bool>(self, row: &mut [u16], at: usize) {
        if let Some(place) = row.get_mut(at) {
            *place = self;
        }
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.wrapping_add(other)
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.wrapping_sub(other)
    }
    #[inline(always)]
    fn plus_saturating(self, other: Self) -> Self {
        self.saturating_add(other)
    }
    #[inline(always)]
    fn minus_saturating(self, other: Self) -> Self {
        self.saturating_sub(other)
    }
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        self << by
    }
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        self >> by
    }
    #[inline(always)]
    fn shr_signed(self, by: u32) -> Self {
        (self as i16 >> by) as Self
    }
    #[inline(always)]
    fn product_high(self, other: Self) -> Self {
        ((u32::from(self) * u32::from(other)) >> 16) as Self
    }
    #[inline(always)]
    fn product_low(self, other: Self) -> Self {
        self.wrapping_mul(other)
    }
    #[inline(always)]
    fn product_round(self, other: Self) -> Self {
        ((i32::from(self as i16) * i32::from(other as i16) + (1 << 14)) >> 15) as Self
    }
    #[inline(always)]
    fn product_plus(self, other: Self, offset: u16) -> Self {
        // At most 65535^2 + 65535.
        ((u32::from(self) * u32::from(other) + u32::from(offset)) >> 16) as Self
    }
    #[inline(always)]
    fn top_then_else(self, value: Self, other: Self) -> Self {
        if self >> 15 != 0 { value } else { other }
    }
    #[inline(always)]
    fn nonzero_then(self, value: Self) -> Self {
        if self != 0 { value } else { 0 }
    }
    #[inline(always)]
    fn at_least_or_zero(self, floor: Self) -> Self {
        if self >= floor { self } else { 0 }
    }
    #[inline(always)]
    fn all_zero(self) -> bool {
        self == 0
    }
    #[inline(always)]
    fn normalised(vector: [Self; 3]) -> (u32, Self) {
        let [x, y, z] = signed(vector);
        // At most 3 * 32767^2, which 32 bits hold without a sign.
        let square = (x * x) as u32 + (y * y) as u32 + (z * z) as u32;
        let k = (square.leading_zeros() >> 1).min(15);
        (k, (square << (2 * k) >> 16) as Self)
    }
    #[inline(always)]
    fn direction(vector: [i16; 3]) -> [i16; 3] {
        vector
    }
    #[inline(always)]
    fn facing(a: [Self; 3], [bx, by, bz]: [i16; 3], k: u32) -> Self {
        let [ax, ay, az] = signed(a);
        // Below 2^31 - 2^14 in magnitude: |a| 2^k < 2^16, |b| < 2^15.
        let dot = (ax * i32::from(bx) + ay * i32::from(by) + az * i32::from(bz)) << k;
        ((dot + (1 << 14)) >> 15).clamp(0, 0xffff) as Self
    }
}
