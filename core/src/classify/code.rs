//! Codes of a point table: how an entry of 32 bits, and the planes of low bytes beside it, hold opacity and colour.

use crate::format::Opacity;
use crate::lanes::Lanes;
use crate::table::ENTRIES;

/// How an entry holds the square root of its opacity, and its colour.
pub trait AlphaCode: Copy + Send + Sync + 'static {
    /// What there is beside the 32-bit entries.
    type Plane<'a>: Copy + Send + Sync;
    /// Bytes that it takes.
    const PLANE_BYTES: usize;
    /// The square root of an entry's opacity, 0.16.
    fn root(entry: u32, plane: Self::Plane<'_>, index: usize) -> u16;
    /// The low bytes of an entry's colours, in the places of the entry's own. Colours of 8 bits have the entry's own there:
    /// 257 times a byte is that byte twice.
    #[inline(always)]
    fn low_colours(entry: u32, _: Self::Plane<'_>, _: usize) -> u32 {
        entry
    }
    /// The opacity that a root stands for. A code that holds no root (for studies) replaces it.
    #[inline(always)]
    fn opacity(root: u16) -> Opacity {
        opacity_of_root(root)
    }
}

/// The square root in 8 bits, inside the 32-bit entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sqrt8;

/// The square root in 16 bits: the high byte inside the entry, the low byte in a plane of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sqrt16;

/// The square root and the colours in 16 bits each: the high bytes inside the entry, the root's low byte in one plane, the
/// colours' (red, green, blue) in another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour16;

impl AlphaCode for Sqrt8 {
    type Plane<'a> = ();
    const PLANE_BYTES: usize = 0;
    #[inline(always)]
    fn root(entry: u32, (): (), _: usize) -> u16 {
        257 * (entry >> 24) as u16
    }
}

impl AlphaCode for Sqrt16 {
    type Plane<'a> = &'a [u8; ENTRIES];
    const PLANE_BYTES: usize = ENTRIES;
    #[inline(always)]
    fn root(entry: u32, plane: &[u8; ENTRIES], index: usize) -> u16 {
        let low = plane.get(index).copied().unwrap_or(0);
        (entry >> 16) as u16 & 0xff00 | u16::from(low)
    }
}

impl AlphaCode for Colour16 {
    type Plane<'a> = (&'a [u8; ENTRIES], &'a [[u8; 3]; ENTRIES]);
    const PLANE_BYTES: usize = 4 * ENTRIES;
    #[inline(always)]
    fn root(entry: u32, (roots, _): Self::Plane<'_>, index: usize) -> u16 {
        Sqrt16::root(entry, roots, index)
    }
    #[inline(always)]
    fn low_colours(_: u32, (_, colours): Self::Plane<'_>, index: usize) -> u32 {
        let [red, green, blue] = colours.get(index).copied().unwrap_or([0; 3]);
        u32::from_le_bytes([red, green, blue, 0])
    }
}

/// Opacity of a square root, 1.31.
#[inline]
pub const fn opacity_of_root(root: u16) -> Opacity {
    Opacity::from_bits((root as u32 * root as u32 + 1) >> 1)
}

/// An 8-bit colour with 15 or 31 fraction bits, to nearest: 255 is exactly 1, and all 256 values come back from 8-bit
/// output.
#[inline(always)]
pub const fn colour_of_byte(byte: u8, bits: u32) -> u32 {
    colour_of_word(257 * byte as u16, bits)
}

/// A 16-bit colour with 15 or 31 fraction bits, to nearest: 65535 is exactly 1.
#[inline(always)]
pub const fn colour_of_word(word: u16, bits: u32) -> u32 {
    let half = (word as u32 + 1) >> 1;
    if bits == 31 { ((word as u32) << 15) + half } else { half }
}

/// [`colour_of_word`] in lanes.
#[inline(always)]
pub fn colour_of_words<V: Lanes>(words: V, bits: u32) -> V {
    let half = (words + V::splat(1)) >> 1;
    if bits == 31 {
        (words << 15).wrapping_add(half)
    } else {
        half
    }
}

/// Packs an entry: red in the lowest byte, then green, blue and the square root of the opacity (or its high byte).
pub const fn entry([red, green, blue]: [u8; 3], root: u8) -> u32 {
    u32::from_le_bytes([red, green, blue, root])
}
