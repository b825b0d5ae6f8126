//! Accumulator formats of a study: how many bits a pixel's channel has, and what they take in memory.
//!
//! | type | format | bytes | 1.0 |
//! |---|---|---|---|
//! | [`Short`] | 1.F, F at most 15 | 2 | 2^F |
//! | [`Packed`] | 1.F, F at most 23 | 3 | 2^F |
//! | [`Long`] | 1.F, F at most 31 | 4 | 2^F |
//! | [`Carry`] | 1.F, F at most 15, and 16 bits below it | 4 | 2^(F + 16) |
//! | [`Byte`] | 8 bits | 1 | 255 |
//!
//! Core's own are 1.15 (`u16`), `Unorm16` and 1.31 (`u32`).

use slicecast::composite::{Channel, Unorm16};

/// A channel whose 1.0 is a power of two.
pub trait Binary: Channel {
    /// Fraction bits.
    const FRACTION: u32;
}

impl Binary for u16 {
    const FRACTION: u32 = 15;
}

impl Binary for u32 {
    const FRACTION: u32 = 31;
}

/// A channel of which the largest code is 1.0.
pub trait Full: Channel {
    /// Bits of the code.
    const BITS: u32;
}

impl Full for Unorm16 {
    const BITS: u32 = 16;
}

/// The name of 1.F.
const fn name(fraction: u32) -> &'static str {
    match fraction {
        7 => "1.7",
        8 => "1.8",
        10 => "1.10",
        12 => "1.12",
        14 => "1.14",
        15 => "1.15",
        16 => "1.16",
        23 => "1.23",
        31 => "1.31",
        _ => "1.F",
    }
}

/// 1.F in 16 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct Short<const F: u32>(u16);

impl<const F: u32> Channel for Short<F> {
    const NAME: &'static str = name(F);
    const ONE: Self = Self(1 << F);
    const LEAST: Self = Self(1);
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits as u16)
    }
}

impl<const F: u32> Binary for Short<F> {
    const FRACTION: u32 = F;
}

/// 1.F in 32 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct Long<const F: u32>(u32);

impl<const F: u32> Channel for Long<F> {
    const NAME: &'static str = name(F);
    const ONE: Self = Self(1 << F);
    const LEAST: Self = Self(1);
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits)
    }
}

impl<const F: u32> Binary for Long<F> {
    const FRACTION: u32 = F;
}

/// 1.F in three bytes, the highest first, so that the order of the bytes is the order of the values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct Packed<const F: u32>([u8; 3]);

impl<const F: u32> Packed<F> {
    const fn of(bits: u32) -> Self {
        let [_, high, middle, low] = bits.to_be_bytes();
        Self([high, middle, low])
    }
}

impl<const F: u32> Channel for Packed<F> {
    const NAME: &'static str = name(F);
    const ONE: Self = Self::of(1 << F);
    const LEAST: Self = Self::of(1);
    #[inline(always)]
    fn bits(self) -> u32 {
        let [high, middle, low] = self.0;
        u32::from_be_bytes([0, high, middle, low])
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self::of(bits)
    }
}

impl<const F: u32> Binary for Packed<F> {
    const FRACTION: u32 = F;
}

/// 1.F in the upper 16 bits, and below it what its last rounding left over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct Carry<const F: u32>(u32);

impl<const F: u32> Carry<F> {
    /// One unit of the value.
    pub const ULP: Self = Self(1 << 16);
}

impl<const F: u32> Channel for Carry<F> {
    const NAME: &'static str = name(F);
    const ONE: Self = Self(1 << (F + 16));
    const LEAST: Self = Self(1);
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits)
    }
}

/// Eight bits of which 255 is 1.0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct Byte(u8);

impl Channel for Byte {
    const NAME: &'static str = "unorm8";
    const ONE: Self = Self(255);
    const LEAST: Self = Self(1);
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits as u8)
    }
}

impl Full for Byte {
    const BITS: u32 = 8;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holds<C: Channel>(bytes: usize, values: impl IntoIterator<Item = u32>) {
        assert_eq!(size_of::<C>(), bytes);
        assert_eq!((C::default().bits(), C::LEAST.bits()), (0, 1));
        let mut last = None;
        for bits in values {
            let channel = C::from_bits(bits);
            assert_eq!(channel.bits(), bits);
            assert!(last < Some(channel), "{bits} is not above the one before");
            last = Some(channel);
        }
        assert_eq!(last, Some(C::ONE));
    }

    #[test]
    fn channels_hold_every_value_in_order() {
        holds::<Short<8>>(2, 0..=256);
        holds::<Short<15>>(2, 0..=32768);
        holds::<Packed<16>>(3, 0..=65536);
        holds::<Packed<23>>(3, (0..=1 << 23).step_by(64));
        holds::<Long<16>>(4, 0..=65536);
        holds::<Carry<12>>(4, (0..=1 << 28).step_by(1 << 14));
        holds::<Byte>(1, 0..=255);
    }
}
