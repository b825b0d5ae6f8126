//! Accumulator formats of a study: how many bits a pixel's channel has, and what they would take in memory.
//!
//! | format | F or N | bytes | 1.0 |
//! |---|---|---|---|
//! | [`Scale::Binary`], 1.F | 1 to 31 | (F + 1) / 8, rounded up | 2^F |
//! | [`Scale::Carrying`], 1.F and 16 bits below it | 1 to 15 | 4 | 2^(F + 16) |
//! | [`Scale::Full`], N bits | 2 to 16 | N / 8, rounded up | 2^N - 1 |
//!
//! Widths are values: the pipeline of a study holds every channel in 32 bits ([`Stored`]), whatever its format.

use slicecast::composite::Channel;

/// A channel's format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// 1.F.
    Binary(u32),
    /// 1.F in the upper bits, and below it 16 bits of what its last rounding left over.
    Carrying(u32),
    /// N bits of which the largest code is 1.0.
    Full(u32),
}

impl Scale {
    /// 1.0.
    #[inline(always)]
    pub const fn one(self) -> u32 {
        match self {
            Self::Binary(fraction) => 1 << fraction,
            Self::Carrying(fraction) => 1 << (fraction + 16),
            Self::Full(bits) => (1 << bits) - 1,
        }
    }

    /// Bits behind the point, or all of them where the largest code is 1.0.
    pub const fn bits(self) -> u32 {
        match self {
            Self::Binary(bits) | Self::Carrying(bits) | Self::Full(bits) => bits,
        }
    }

    /// Bytes of a channel that is stored by itself.
    pub const fn bytes(self) -> usize {
        let bits = match self {
            Self::Binary(fraction) => fraction + 1,
            Self::Carrying(_) => 32,
            Self::Full(bits) => bits,
        };
        bits.div_ceil(8) as usize
    }

    /// The bits of a channel that make the picture; the others are the arithmetic's own.
    pub const fn shown(self) -> u32 {
        match self {
            Self::Carrying(_) => 0xffff_0000,
            Self::Binary(_) | Self::Full(_) => u32::MAX,
        }
    }

    /// The name that reports use.
    pub const fn name(self) -> &'static str {
        const BINARY: [&str; 32] = [
            "1.0", "1.1", "1.2", "1.3", "1.4", "1.5", "1.6", "1.7", "1.8", "1.9", "1.10", "1.11", "1.12", "1.13",
            "1.14", "1.15", "1.16", "1.17", "1.18", "1.19", "1.20", "1.21", "1.22", "1.23", "1.24", "1.25", "1.26",
            "1.27", "1.28", "1.29", "1.30", "1.31",
        ];
        const FULL: [&str; 17] = [
            "unorm0", "unorm1", "unorm2", "unorm3", "unorm4", "unorm5", "unorm6", "unorm7", "unorm8", "unorm9",
            "unorm10", "unorm11", "unorm12", "unorm13", "unorm14", "unorm15", "unorm16",
        ];
        match self {
            Self::Binary(fraction) | Self::Carrying(fraction) => BINARY[fraction as usize],
            Self::Full(bits) => FULL[bits as usize],
        }
    }
}

/// A channel as the pipeline of a study holds it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct Stored(u32);

impl Channel for Stored {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_say_what_one_is_and_what_it_takes() {
        for (scale, name, one, bytes) in [
            (Scale::Binary(7), "1.7", 128, 1),
            (Scale::Binary(8), "1.8", 256, 2),
            (Scale::Binary(15), "1.15", 32768, 2),
            (Scale::Binary(23), "1.23", 1 << 23, 3),
            (Scale::Binary(31), "1.31", 1 << 31, 4),
            (Scale::Carrying(12), "1.12", 1 << 28, 4),
            (Scale::Full(8), "unorm8", 255, 1),
            (Scale::Full(16), "unorm16", 65535, 2),
        ] {
            assert_eq!((scale.name(), scale.one(), scale.bytes()), (name, one, bytes));
        }
    }
}
