//! Classification: colour and opacity of a sample.
//!
//! Source: Squeeze, section 4.4: a table of 4096 entries R 0.8, G 0.8, B 0.8, sqrt(opacity) 0.8. The square root
//! puts the codes where thin material needs them; [`Sqrt16`] adds 8 more bits of it in a plane of 4 KiB, and [`Colour16`]
//! 8 more bits of each colour in a plane of 12 KiB, for colours that change with the value. Opacity is corrected for the
//! length of a ray's step when the table is built.
//!
//! | value | format | range |
//! |---|---|---|
//! | sample s | 12.F | 0 to 4095 |
//! | square root q | 0.16; of an 8-bit code 257 q8 | 0 to 65535 |
//! | opacity a | 1.31, `(q * q + 1) >> 1` | 0 to 2147418113 |
//! | colour o | 16 bits, 65535 is 1; of an 8-bit colour 257 o8 | 0 to 65535 |
//! | colour c | 1.15, `(o + 1) >> 1`; 1.31 in `Wide`, `(o << 15) + ((o + 1) >> 1)`: to nearest | 0 to 1 |
//!
//! Index: the nearest entry, `(s + 2^(F-1)) >> F`, taken from the stored sample only ([`Nearest`]); or linear between
//! the two neighbours, opacity and colour alike, rounded to nearest ([`Linear`]). Neither can leave the table.
//! Error: nearest half an entry; linear none for colours whose corners are table entries, and for opacities what the
//! step correction curves between two entries. The code:
//! opacity to 2^-16 relative to its square root; an opaque entry leaves 2^-15 of the light. State: none.

use core::marker::PhantomData;
use core::ops::Range;

use crate::composite::Recurrence as _;
use crate::format::Opacity;
use crate::lanes::{Lanes, Small, Wide as _};
use crate::precision::{Formats, Precision};
use crate::rows::{part, three};
use crate::slice::RowRange;
use crate::table::ENTRIES;

/// What a classifier reads of the rays of a row: the sample of each, and, for a classifier of segments, the sample in front
/// of it.
#[derive(Clone, Copy, Debug)]
pub struct Slab<'a, W = i32> {
    /// The samples of the plane in front; empty for classifiers that do not read it.
    pub front: &'a [W],
    /// The samples of this plane.
    pub back: &'a [W],
}

impl<'a, W> Slab<'a, W> {
    /// Samples of one plane.
    #[inline(always)]
    pub const fn of(back: &'a [W]) -> Self {
        Self { front: &[], back }
    }

    /// Samples of two planes. Both rows equally long.
    #[inline(always)]
    pub const fn between(front: &'a [W], back: &'a [W]) -> Self {
        Self { front, back }
    }

    /// A span of the rays.
    #[inline(always)]
    pub(crate) fn part(self, span: Range<usize>) -> Self {
        Self {
            front: part(self.front, span.clone()),
            back: part(self.back, span),
        }
    }
}

/// Gives samples, or the segments between them, their colour and opacity: point tables, or
/// [cumulative integrals](crate::integral).
pub trait Classifier<P: Precision>: Sync {
    /// Whether segments are classified: rows then hold the front samples too, and a plane is folded together with the one
    /// in front of it.
    const SLABS: bool = false;

    /// Opacity of a sample: the definition.
    fn opacity(&self, p: P, sample: i32) -> Opacity;

    /// Colour of a sample (not weighted by its opacity), red, green, blue, `p.pixel().colour_bits()` fraction bits: the
    /// definition.
    fn colour(&self, p: P, sample: i32) -> [u32; 3];

    /// Opacity of a segment from its front and back sample: the definition. Of the back sample where segments are not read.
    #[inline(always)]
    fn segment_opacity(&self, p: P, [_, back]: [i32; 2]) -> Opacity {
        self.opacity(p, back)
    }

    /// Colour of a segment: the definition. Of the back sample where segments are not read.
    #[inline(always)]
    fn segment_colour(&self, p: P, [_, back]: [i32; 2]) -> [u32; 3] {
        self.colour(p, back)
    }

    /// Which voxel ranges can hold a visible sample.
    fn support(&self) -> Support;

    /// The colour of every sample, where all have the same: then it need not be asked for sample by sample.
    #[inline(always)]
    fn one_colour(&self, _: P) -> Option<[u32; 3]> {
        None
    }

    /// Opacities of a row, as the bits of 1.31 in an `i32` lane. Both rows equally long.
    #[inline]
    fn opacity_row<V: Lanes>(&self, p: P, slab: Slab<'_>, out: &mut [i32]) {
        for (o, &s) in out.iter_mut().zip(slab.back) {
            *o = self.opacity(p, s).to_bits() as i32;
        }
    }

    /// Colours of a row. All rows equally long.
    #[inline]
    fn colour_row<V: Lanes>(&self, p: P, slab: Slab<'_>, out: [&mut [i32]; 3]) {
        let [red, green, blue] = out;
        for (((r, g), b), &s) in red.iter_mut().zip(green).zip(blue).zip(slab.back) {
            [*r, *g, *b] = three(self.colour(p, s), |c| c as i32);
        }
    }
}
/// The set of codes that are visible, in blocks of 64: bit b stands for codes 64 b to 64 b + 63. A row whose range
/// meets no block classifies to nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Support(u64);

impl Support {
    /// Nothing is visible.
    pub const NONE: Self = Self(0);

    /// The blocks that hold a visible entry.
    pub fn of(visible: impl Iterator<Item = bool>) -> Self {
        let mut bits = 0;
        for (code, _) in visible.take(ENTRIES).enumerate().filter(|(_, visible)| *visible) {
            bits |= 1 << (code >> 6);
        }
        Self(bits)
    }

    /// Whether a sample between voxels of this range may be visible.
    #[inline]
    pub fn meets(self, range: RowRange) -> bool {
        if range.low > range.high {
            return false;
        }
        let (low, high) = (u32::from(range.low >> 6).min(63), u32::from(range.high >> 6).min(63));
        self.0 << (63 - high) >> (63 - high) >> low != 0
    }

    /// A sample up to which none is visible: the code before the first block; -1 if the first block is.
    #[inline]
    fn dark<P: Precision>(self, p: P) -> i32 {
        // No block at all: 4096, which nothing reaches.
        let first = (self.0.trailing_zeros() << 6) as i32;
        ((first - 1) << p.formats().sample_bits).max(-1)
    }
}

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

/// How a sample finds its entry.
pub trait Lookup: Copy + Send + Sync + 'static {
    /// Whether two entries are mixed.
    const LINEAR: bool;
}

/// The nearest entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Nearest;

/// Linear between the two neighbouring entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Linear;

impl Lookup for Nearest {
    const LINEAR: bool = false;
}

impl Lookup for Linear {
    const LINEAR: bool = true;
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

/// A table of points: one entry a code.
#[derive(Clone, Copy, Debug)]
pub struct PointTable<'a, A: AlphaCode, L> {
    entries: &'a [u32; ENTRIES],
    plane: A::Plane<'a>,
    support: Support,
    lookup: PhantomData<L>,
}

impl<'a, A: AlphaCode, L: Lookup> PointTable<'a, A, L> {
    /// A table over [`entry`]s in the caller's memory (16 KiB), and the plane that its alpha code needs.
    pub fn new(entries: &'a [u32; ENTRIES], plane: A::Plane<'a>) -> Self {
        let visible = |(index, &entry): (usize, &u32)| A::root(entry, plane, index) != 0;
        Self {
            entries,
            plane,
            support: Support::of(entries.iter().enumerate().map(visible)),
            lookup: PhantomData,
        }
    }

    /// Bytes of the table, entries and plane.
    pub const BYTES: usize = 4 * ENTRIES + A::PLANE_BYTES;

    /// The entry of a code. Behind the last code lies the first: samples reach it with a fraction of 0 only.
    #[inline(always)]
    fn entry_at(&self, index: usize) -> u32 {
        self.entries.get(index % ENTRIES).copied().unwrap_or(0)
    }

    #[inline(always)]
    fn root_at(&self, index: usize) -> u16 {
        A::root(self.entry_at(index), self.plane, index % ENTRIES)
    }

    /// High and low bytes of a code's colours, red in the lowest place.
    #[inline(always)]
    fn colours_at(&self, index: usize) -> [u32; 2] {
        let (entry, mask) = (self.entry_at(index), 0x00ff_ffff);
        [entry & mask, A::low_colours(entry, self.plane, index % ENTRIES) & mask]
    }

    /// The opacity of a code.
    #[inline]
    pub fn code_opacity(&self, code: usize) -> Opacity {
        A::opacity(self.root_at(code))
    }

    /// The colour of a code: red, green, blue, 65535 is 1.
    #[inline]
    pub fn code_colour(&self, code: usize) -> [u16; 3] {
        words(self.colours_at(code))
    }

    #[cfg(test)]
    fn opacity_at(&self, index: usize) -> u32 {
        self.code_opacity(index).to_bits()
    }

    #[cfg(test)]
    fn colour_at<P: Precision>(&self, p: P, index: usize) -> [u32; 3] {
        decoded(p, self.colours_at(index))
    }
}

/// 16-bit colours of their high and low bytes.
#[inline(always)]
fn words([high, low]: [u32; 2]) -> [u16; 3] {
    let ([r, g, b, _], [r_low, g_low, b_low, _]) = (high.to_le_bytes(), low.to_le_bytes());
    let word = |(high, low)| 256 * u16::from(high) + u16::from(low);
    three([(r, r_low), (g, g_low), (b, b_low)], word)
}

/// Colours of their high and low bytes.
#[inline(always)]
fn decoded<P: Precision>(p: P, bytes: [u32; 2]) -> [u32; 3] {
    three(words(bytes), |word| colour_of_word(word, p.pixel().colour_bits()))
}

/// Entry and fraction of a sample that lies between two entries.
#[inline(always)]
fn split<P: Precision>(p: P, bits: i32) -> (usize, i32) {
    let Formats { sample_bits, .. } = p.formats();
    ((bits >> sample_bits) as usize, bits & ((1 << sample_bits) - 1))
}

/// Nearest entry of a sample.
#[inline(always)]
fn nearest<P: Precision>(p: P, bits: i32) -> usize {
    let Formats { sample_bits, .. } = p.formats();
    ((bits + (1 << sample_bits >> 1)) >> sample_bits) as usize
}

/// `a + (b - a) f` to nearest, for colours.
#[inline(always)]
pub fn mix_colour<P: Precision, V: Lanes>(p: P, a: V, b: V, f: V) -> V {
    let Formats { sample_bits, .. } = p.formats();
    let (half, rest) = (1 << sample_bits >> 1, V::splat(1 << sample_bits) - f);
    if p.pixel().colour_bits() == 15 {
        // 16 and 15 bits: 32 suffice.
        (a * rest + b * f + V::splat(half)) >> sample_bits
    } else {
        let sum = a.product(rest) + b.product(f) + V::Wide::splat(i64::from(half));
        sum.shr_narrow(sample_bits)
    }
}

impl<A: AlphaCode, L: Lookup> PointTable<'_, A, L> {
    /// Opacity of a sample, mixed by a lane.
    #[inline(always)]
    fn opacity_by<P: Precision, V: Lanes>(&self, p: P, bits: i32) -> i32 {
        let opacity = |root| A::opacity(root).to_bits() as i32;
        if !L::LINEAR {
            return opacity(self.root_at(nearest(p, bits)));
        }
        let (index, f) = split(p, bits);
        let (a, b) = (self.root_at(index), self.root_at(index + 1));
        if V::SMALL && a == b {
            return opacity(a);
        }
        let mut out = [0];
        let mixed = V::splat(opacity(a)).mix(V::splat(opacity(b)), V::splat(f), p.formats().sample_bits);
        mixed.store(&mut out, 0);
        let [mixed] = out;
        mixed
    }

    /// Colour of a sample. On small machines two entries of one colour are not mixed.
    #[inline(always)]
    fn colour_by<P: Precision, V: Lanes>(&self, p: P, bits: i32) -> [u32; 3] {
        if !L::LINEAR {
            return decoded(p, self.colours_at(nearest(p, bits)));
        }
        let (index, f) = split(p, bits);
        let (a, b) = (self.colours_at(index), self.colours_at(index + 1));
        let first = decoded(p, a);
        if V::SMALL && a == b {
            return first;
        }
        let ([r0, g0, b0], [r1, g1, b1]) = (first, decoded(p, b));
        three([(r0, r1), (g0, g1), (b0, b1)], |(a, b)| {
            mix_colour(p, a as i32, b as i32, f) as u32
        })
    }

    /// Opacities of a row on a small machine. With registers of its own it takes fewer instructions where there are few.
    #[inline(never)]
    fn opacity_row_small<P: Precision>(&self, p: P, samples: &[i32], out: &mut [i32]) {
        let dark = self.support.dark(p);
        for (o, &s) in out.iter_mut().zip(samples) {
            *o = if s <= dark {
                0
            } else {
                self.opacity_by::<P, Small>(p, s)
            };
        }
    }
}

impl<P: Precision, A: AlphaCode, L: Lookup> Classifier<P> for PointTable<'_, A, L> {
    #[inline]
    fn opacity(&self, p: P, sample: i32) -> Opacity {
        Opacity::from_bits(self.opacity_by::<P, i32>(p, sample) as u32)
    }

    #[inline]
    fn colour(&self, p: P, sample: i32) -> [u32; 3] {
        self.colour_by::<P, i32>(p, sample)
    }

    fn support(&self) -> Support {
        self.support
    }

    #[inline(always)]
    fn opacity_row<V: Lanes>(&self, p: P, slab: Slab<'_>, out: &mut [i32]) {
        if V::SMALL {
            return self.opacity_row_small(p, slab.back, out);
        }
        for (o, &s) in out.iter_mut().zip(slab.back) {
            *o = self.opacity_by::<P, i32>(p, s);
        }
    }

    #[inline(always)]
    fn colour_row<V: Lanes>(&self, p: P, slab: Slab<'_>, out: [&mut [i32]; 3]) {
        let [red, green, blue] = out;
        for (((r, g), b), &s) in red.iter_mut().zip(green).zip(blue).zip(slab.back) {
            [*r, *g, *b] = three(self.colour_by::<P, V>(p, s), |c| c as i32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::{Compact, Wide};
    use proptest::prelude::*;
    use std::boxed::Box;
    use std::vec::Vec;

    #[test]
    fn every_root_decodes_within_half_a_unit_and_rises() {
        let mut last = None;
        for root in 0..=u16::MAX {
            let a = opacity_of_root(root).to_bits();
            let exact = (f64::from(root) / 65536.0).powi(2) * 2147483648.0;
            assert!((f64::from(a) - exact).abs() <= 0.5);
            assert!(last < Some(a));
            last = Some(a);
        }
        assert_eq!(last, Some(2147418113));
    }

    #[test]
    fn every_byte_survives_a_round_trip() {
        for byte in 0..=255u8 {
            for bits in [15, 31] {
                let c = colour_of_byte(byte, bits);
                let exact = f64::from(byte) / 255.0 * f64::from(bits).exp2();
                assert!((f64::from(c) - exact).abs() <= 0.5, "{byte} {bits}");
                assert_eq!((u64::from(c) * 255 + (1 << (bits - 1))) >> bits, u64::from(byte));
            }
        }
        assert_eq!((colour_of_byte(255, 15), colour_of_byte(255, 31)), (1 << 15, 1 << 31));
    }

    #[test]
    fn every_word_decodes_within_half_a_unit_and_rises() {
        for bits in [15, 31] {
            let mut last = None;
            for word in 0..=u16::MAX {
                let c = colour_of_word(word, bits);
                let exact = f64::from(word) / 65535.0 * f64::from(bits).exp2();
                assert!((f64::from(c) - exact).abs() <= 0.5, "{word} {bits}");
                assert_eq!(colour_of_words(i32::from(word), bits) as u32, c);
                // Two words share a colour of 1.15, none one of 1.31.
                assert!(last <= Some(c) && (bits == 15 || last < Some(c)));
                last = Some(c);
            }
        }
        assert_eq!(
            (colour_of_word(65535, 15), colour_of_word(65535, 31)),
            (1 << 15, 1 << 31)
        );
    }

    #[test]
    fn index_comes_from_the_stored_sample() {
        for (bits, index) in [
            (0, 0),
            (16383, 0),
            (16384, 1),
            (3260415, 99),
            (3260416, 100),
            (134168576, 4095),
        ] {
            assert_eq!(nearest(Wide, bits), index);
        }
        assert_eq!(split(Wide, 3260415), (99, 16383));
        assert_eq!(split(Wide, 134184960), (4095, 0));
    }

    #[test]
    fn support_meets_exactly_the_blocks_of_visible_codes() {
        for code in [0usize, 63, 64, 2000, 4095] {
            let support = Support::of((0..ENTRIES).map(|c| c == code));
            for low in (0..4096).step_by(31) {
                for high in (low..4096).step_by(53) {
                    let meets = support.meets(RowRange { low, high });
                    let block = code >> 6;
                    assert_eq!(meets, usize::from(low >> 6) <= block && block <= usize::from(high >> 6));
                }
            }
        }
        assert!(!Support::NONE.meets(RowRange { low: 0, high: 4095 }));
        assert!(!Support(u64::MAX).meets(RowRange::EMPTY));
        assert!(Support(u64::MAX).meets(RowRange {
            low: 65535,
            high: 65535
        }));
    }

    fn table(seed: u64) -> (Box<[u32; ENTRIES]>, Box<[u8; ENTRIES]>) {
        let mut state = seed | 1;
        let mut next = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 32) as u32
        };
        let entries: Vec<u32> = (0..ENTRIES).map(|_| next()).collect();
        let plane: Vec<u8> = (0..ENTRIES).map(|_| (next() >> 24) as u8).collect();
        (
            entries.into_boxed_slice().try_into().unwrap(),
            plane.into_boxed_slice().try_into().unwrap(),
        )
    }

    /// Low bytes of colours, from some of the entries' own bits.
    fn low_colours(entries: &[u32; ENTRIES]) -> Box<[[u8; 3]; ENTRIES]> {
        let low = |entry: &u32| {
            let [a, b, c, d] = entry.wrapping_mul(2654435761).to_le_bytes();
            [a ^ d, b, c]
        };
        let low: Vec<_> = entries.iter().map(low).collect();
        low.into_boxed_slice().try_into().unwrap()
    }

    #[test]
    fn colours_of_8_bits_are_those_of_16_that_have_the_byte_twice() {
        let (entries, plane) = table(9);
        let twice: Vec<[u8; 3]> = entries
            .iter()
            .map(|e| e.to_le_bytes())
            .map(|[r, g, b, _]| [r, g, b])
            .collect();
        let twice: Box<[[u8; 3]; ENTRIES]> = twice.into_boxed_slice().try_into().unwrap();
        let narrow = PointTable::<Sqrt16, Linear>::new(&entries, &plane);
        let wide = PointTable::<Colour16, Linear>::new(&entries, (&plane, &twice));
        for s in (0..=4095 << 15).step_by(97) {
            assert_eq!(Classifier::colour(&narrow, Wide, s), Classifier::colour(&wide, Wide, s));
            assert_eq!(
                Classifier::opacity(&narrow, Wide, s),
                Classifier::opacity(&wide, Wide, s)
            );
        }
        let bytes = |code: usize| {
            let [r, g, b, _] = entries[code].to_le_bytes();
            [r, g, b].map(|byte| 257 * u16::from(byte))
        };
        assert_eq!(narrow.code_colour(77), bytes(77));
        let low = low_colours(&entries);
        let other = PointTable::<Colour16, Linear>::new(&entries, (&plane, &low));
        let expected = [0, 1, 2].map(|c| (bytes(77)[c] & 0xff00) | u16::from(low[77][c]));
        assert_eq!(other.code_colour(77), expected);
    }

    proptest! {
        #[test]
        fn linear_is_the_nearest_value_between_two_entries(seed in any::<u64>(), bits in 0i32..=4095 << 15) {
            let (entries, plane) = table(seed);
            let low = low_colours(&entries);
            let t = PointTable::<Colour16, Linear>::new(&entries, (&plane, &low));
            let s = bits;
            let (i, f) = (bits as usize >> 15, f64::from(bits & 32767) / 32768.0);
            let between = |a: u32, b: u32| f64::from(a) * (1.0 - f) + f64::from(b) * f;
            let exact = between(t.opacity_at(i), t.opacity_at(i + 1));
            let got = f64::from(Classifier::opacity(&t, Wide, s).to_bits());
            prop_assert!((got - exact).abs() <= 0.5 + 1e-6, "{got} {exact}");
            let colour = Classifier::colour(&t, Wide, s);
            for (c, (a, b)) in colour.iter().zip(t.colour_at(Wide, i).into_iter().zip(t.colour_at(Wide, i + 1))) {
                prop_assert!((f64::from(*c) - between(a, b)).abs() <= 0.5 + 1e-6);
            }
        }

        #[test]
        fn linear_meets_nearest_at_entries(seed in any::<u64>(), code in 0i32..4096) {
            let (entries, plane) = table(seed);
            let linear = PointTable::<Sqrt16, Linear>::new(&entries, &plane);
            let nearest = PointTable::<Sqrt16, Nearest>::new(&entries, &plane);
            let s = code << 12;
            prop_assert_eq!(Classifier::opacity(&linear, Compact, s), Classifier::opacity(&nearest, Compact, s));
            prop_assert_eq!(Classifier::colour(&linear, Compact, s), Classifier::colour(&nearest, Compact, s));
        }

        #[test]
        fn rows_are_the_scalar(seed in any::<u64>(), samples in prop::collection::vec(0i32..=4095 << 12, 0..34)) {
            let (entries, _) = table(seed);
            let t = PointTable::<Sqrt8, Linear>::new(&entries, ());
            let mut a = std::vec![0; samples.len()];
            let mut c = [a.clone(), a.clone(), a.clone()];
            Classifier::opacity_row::<i32>(&t, Compact, Slab::of(&samples), &mut a);
            let [r, g, b] = &mut c;
            Classifier::colour_row::<i32>(&t, Compact, Slab::of(&samples), [r, g, b]);
            for (i, &s) in samples.iter().enumerate() {
                prop_assert_eq!(a[i] as u32, Classifier::opacity(&t, Compact, s).to_bits());
                let colour = Classifier::colour(&t, Compact, s).map(|c| c as i32);
                prop_assert_eq!([c[0][i], c[1][i], c[2][i]], colour);
            }
        }
    }
}
