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

mod code;

use core::marker::PhantomData;
use core::ops::Range;

pub use self::code::{
    AlphaCode, Colour16, Sqrt8, Sqrt16, colour_of_byte, colour_of_word, colour_of_words, entry, opacity_of_root,
};

use crate::borders::WHOLE;
use crate::composite::Recurrence as _;
use crate::format::Opacity;
use crate::lanes::{Lanes, Small, Wide as _};
use crate::precision::{Formats, Precision};
use crate::rows::{part, three};
use crate::slice::RowRange;
use crate::surface::Turn;
use crate::table::ENTRIES;

/// What a classifier reads of the rays of a row: the sample of each, and, for a classifier of segments, the sample in front
/// of it.
#[derive(Clone, Copy, Debug)]
pub struct Slab<'a, W = i32> {
    /// The samples of the plane in front; empty for classifiers that do not read it.
    pub front: &'a [W],
    /// The samples of this plane.
    pub back: &'a [W],
    /// Which part of the segments is asked for, where they are cut ([`Classifier::parts`]).
    pub part: u32,
    /// What of the segments lies in the volume, 0.16: their length ([`WHOLE`] is all of it).
    pub fraction: u32,
    /// What is known of the opacities of the part when colours are asked for: where one is 0, the colour may be anything.
    /// Empty: every colour is wanted.
    pub opacities: &'a [W],
}

impl<'a, W> Slab<'a, W> {
    /// Samples of one plane.
    #[inline(always)]
    pub const fn of(back: &'a [W]) -> Self {
        Self::between(&[], back)
    }

    /// Samples of two planes. Both rows equally long.
    #[inline(always)]
    pub const fn between(front: &'a [W], back: &'a [W]) -> Self {
        Self {
            front,
            back,
            part: 0,
            fraction: WHOLE,
            opacities: &[],
        }
    }

    /// Another part of the same segments.
    #[inline(always)]
    #[must_use]
    pub const fn of_part(self, part: u32) -> Self {
        Self { part, ..self }
    }

    /// Segments of another length.
    #[inline(always)]
    pub(crate) const fn of_fraction(self, fraction: u32) -> Self {
        Self { fraction, ..self }
    }

    /// Segments no longer than this fraction.
    #[inline(always)]
    pub(crate) fn at_most(self, fraction: u32) -> Self {
        let fraction = self.fraction.min(fraction);
        self.of_fraction(fraction)
    }

    /// The same segments with their opacities.
    #[inline(always)]
    pub(crate) const fn of_opacities(self, opacities: &'a [W]) -> Self {
        Self { opacities, ..self }
    }

    /// A span of the rays.
    #[inline(always)]
    pub(crate) fn span(self, span: Range<usize>) -> Self {
        Self {
            front: part(self.front, span.clone()),
            back: part(self.back, span.clone()),
            part: self.part,
            fraction: self.fraction,
            opacities: part(self.opacities, span),
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

    /// Parts into which these segments are cut, at most. One behind the other they are folded like segments: those of even
    /// number are parts of the volume, those of odd number crossings of surfaces. 1: no segment is cut.
    #[inline(always)]
    fn parts<V: Lanes>(&self, _: P, _: Slab<'_>) -> u32 {
        1
    }

    /// Opacity of a part of a segment of which a fraction ([`WHOLE`] is 1) lies between these samples, 0 where it has no such
    /// part: the definition.
    #[inline(always)]
    fn part_opacity(&self, p: P, ends: [i32; 2], _fraction: u32, part: u32) -> Opacity {
        if part == 0 {
            self.segment_opacity(p, ends)
        } else {
            Opacity::ZERO
        }
    }

    /// Colour of a part of a segment that is visible: the definition.
    #[inline(always)]
    fn part_colour(&self, p: P, ends: [i32; 2], _fraction: u32, _part: u32) -> [u32; 3] {
        self.segment_colour(p, ends)
    }

    /// Where between the gradients of a segment's ends that of a crossing lies ([`Turn`]), for a part of odd number: the
    /// definition.
    #[inline(always)]
    fn turn(&self, _: P, _ends: [i32; 2], _part: u32) -> Turn {
        Turn::default()
    }

    /// [`Classifier::turn`] of a row, as bits. Both rows equally long.
    #[inline(always)]
    fn turn_row<V: Lanes>(&self, _: P, _: Slab<'_>, _: &mut [i32]) {}

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

    /// What is visible by either.
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
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

    /// The square root of a code's opacity, 0.16.
    #[inline]
    pub fn code_root(&self, code: usize) -> u16 {
        self.root_at(code)
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
mod tests;
