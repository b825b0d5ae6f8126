//! The look-up table of the `fast` precision: square roots of opacities, and colours, both linear between two codes.
//!
//! Of a sample s, 12.3: code `n = s >> 3`, fraction `f = 2^13 (s & 7)`, 0.16. A value is
//! `v[n] - high(v[n], f) + high(v[n + 1], f)` with `high(a, b) = (a b) >> 16`: `v[n]` where f is 0 or both are equal, and never
//! above 65535 (`docs/contract/fast.md`).
//!
//! Source: Squeeze, section 4.4 (a table of roots). The opacity is the root's square, so it bends between two codes.

use core::marker::PhantomData;
use core::ops::Deref;

use crate::classify::{AlphaCode, Lookup, PointTable, Support};
use crate::format::Opacity;
use crate::lanes::{Halves, Kernel, Lanes, each};
use crate::rows::three;
use crate::table::ENTRIES;

/// The roots of a code's opacity and of the next one's, in the lower and the upper half. 16 KiB.
pub type Roots = [u32; ENTRIES];

/// Red, green and blue of a code, 65535 is 1, and nothing; the last code stands twice. 32 KiB.
pub type Colours = [[u16; 4]; ENTRIES + 1];

/// Fills [`Roots`] from a point table.
pub fn fill_roots<A: AlphaCode, L: Lookup>(table: &PointTable<'_, A, L>, out: &mut Roots) {
    for (code, out) in out.iter_mut().enumerate() {
        let next = table.code_root((code + 1).min(ENTRIES - 1));
        *out = u32::from(table.code_root(code)) | u32::from(next) << 16;
    }
}

/// Fills [`Colours`] from a point table; its one colour, if all codes have the same.
pub fn fill_colours<A: AlphaCode, L: Lookup>(table: &PointTable<'_, A, L>, out: &mut Colours) -> Option<[u16; 3]> {
    let first = table.code_colour(0);
    let mut one = true;
    for (code, out) in out.iter_mut().enumerate() {
        let [r, g, b] = table.code_colour(code.min(ENTRIES - 1));
        one &= [r, g, b] == first;
        *out = [r, g, b, 0];
    }
    one.then_some(first)
}

/// The root of an opacity, to nearest, at most 65535; of [`opacity_of_root`](crate::classify::opacity_of_root) what it was made of.
#[inline]
pub const fn root_of(opacity: Opacity) -> u16 {
    let square = opacity.to_bits().saturating_mul(2);
    let root = square.isqrt();
    // At most 65535, whose square is 131071 below 2^32.
    let nearest = root + (square - root * root > root) as u32;
    if nearest > 0xffff { 0xffff } else { nearest as u16 }
}

/// Looks samples up in a table in the caller's memory.
#[derive(Clone, Copy, Debug)]
pub struct RootTable<R, C> {
    roots: R,
    colours: Result<[u16; 3], C>,
    support: Support,
}

/// Samples that are fetched together.
const CHUNK: usize = 256;

impl<R: Deref<Target = Roots>, C: Deref<Target = Colours>> RootTable<R, C> {
    /// A table of many colours, or of one.
    pub fn new(roots: R, colours: Result<[u16; 3], C>) -> Self {
        Self {
            support: Support::of(roots.iter().map(|pair| pair & 0xffff != 0)),
            roots,
            colours,
        }
    }

    /// Bytes of roots and colours.
    pub const fn bytes(&self) -> usize {
        let colours = if self.colours.is_ok() { 0 } else { size_of::<Colours>() };
        size_of::<Roots>() + colours
    }

    /// Which voxel ranges can hold a visible sample.
    pub const fn support(&self) -> Support {
        self.support
    }

    /// The colour of every sample, where all have the same.
    pub fn one_colour(&self) -> Option<[u16; 3]> {
        self.colours.as_ref().ok().copied()
    }

    /// The square root of a sample's opacity: the definition.
    #[inline(always)]
    pub fn root(&self, sample: u16) -> u16 {
        let pair = self.pair(sample);
        mixed(pair as u16, (pair >> 16) as u16, fraction(sample))
    }

    /// Colours of samples one by one.
    #[inline(never)]
    fn colours_one_by_one(&self, samples: &[u16], [red, green, blue]: [&mut [u16]; 3]) {
        for (((sample, r), g), b) in samples.iter().zip(red).zip(green).zip(blue) {
            [*r, *g, *b] = self.colour(*sample);
        }
    }

    /// The colour of a sample: the definition.
    #[inline(always)]
    pub fn colour(&self, sample: u16) -> [u16; 3] {
        let colours = match &self.colours {
            Ok(colour) => return *colour,
            Err(colours) => colours,
        };
        let code = usize::from(sample >> 3) % ENTRIES;
        let at = |code: usize| colours.get(code).copied().unwrap_or_default();
        let ([r0, g0, b0, _], [r1, g1, b1, _]) = (at(code), at(code + 1));
        three([(r0, r1), (g0, g1), (b0, b1)], |(a, b)| mixed(a, b, fraction(sample)))
    }

    #[inline(always)]
    fn pair(&self, sample: u16) -> u32 {
        self.roots.get(usize::from(sample >> 3) % ENTRIES).copied().unwrap_or(0)
    }

    /// Fetches of some samples the roots of their codes and of the next ones. A function of its own: compiled for vectors it
    /// would gather, which takes longer.
    #[inline(never)]
    fn fetch(&self, samples: &[u16], pairs: &mut [u32; CHUNK]) {
        let roots: &Roots = &self.roots;
        let pair = |sample: u16| roots.get(usize::from(sample >> 3) % ENTRIES).copied().unwrap_or(0);
        let (eights, rest) = samples.as_chunks::<8>();
        let (of_eights, of_rest) = pairs.split_at_mut((8 * eights.len()).min(CHUNK));
        for (samples, pairs) in eights.iter().zip(of_eights.as_chunks_mut::<8>().0) {
            *pairs = samples.map(pair);
        }
        for (sample, out) in rest.iter().zip(of_rest) {
            *out = pair(*sample);
        }
    }

    /// Roots of a row, fetched and mixed chunk by chunk.
    #[inline(always)]
    pub(crate) fn root_row<V: Lanes>(&self, samples: &[u16], out: &mut [u16]) {
        if V::SMALL {
            for (out, sample) in out.iter_mut().zip(samples) {
                *out = self.root(*sample);
            }
            return;
        }
        let mut pairs = [0; CHUNK];
        for (samples, out) in samples.chunks(CHUNK).zip(out.chunks_mut(CHUNK)) {
            self.fetch(samples, &mut pairs);
            V::enter((MixRow, PhantomData::<V>, samples, &pairs, out));
        }
    }

    /// Fetches of some samples the colours of their codes and of the next ones, a channel each; as [`RootTable::fetch`].
    #[inline(never)]
    fn fetch_colours(colours: &Colours, samples: &[u16], [red, green, blue]: &mut [[u32; CHUNK]; 3]) {
        let pairs = red.iter_mut().zip(green).zip(blue);
        for (sample, ((r, g), b)) in samples.iter().zip(pairs) {
            let code = usize::from(sample >> 3) % ENTRIES;
            let at = |code: usize| colours.get(code).copied().unwrap_or_default();
            let ([r0, g0, b0, _], [r1, g1, b1, _]) = (at(code), at(code + 1));
            let pair = |(near, next)| u32::from(near) | u32::from(next) << 16;
            [*r, *g, *b] = three([(r0, r1), (g0, g1), (b0, b1)], pair);
        }
    }

    /// Colours of a row, fetched and mixed chunk by chunk.
    #[inline(always)]
    pub(crate) fn colour_row<V: Lanes>(&self, samples: &[u16], [red, green, blue]: [&mut [u16]; 3]) {
        let colours = match &self.colours {
            Err(colours) if !V::SMALL => colours,
            _ => return self.colours_one_by_one(samples, [red, green, blue]),
        };
        let mut pairs = [[0; CHUNK]; 3];
        let rows = red
            .chunks_mut(CHUNK)
            .zip(green.chunks_mut(CHUNK))
            .zip(blue.chunks_mut(CHUNK));
        for (samples, ((red, green), blue)) in samples.chunks(CHUNK).zip(rows) {
            Self::fetch_colours(colours, samples, &mut pairs);
            V::enter((MixColours, PhantomData::<V>, samples, &pairs, [red, green, blue]));
        }
    }
}

/// The way from a sample's code to the next one, 0.16.
#[inline(always)]
fn fraction<H: Halves>(sample: H) -> H {
    sample.shl(13)
}

/// Between the values of two codes.
#[inline(always)]
fn mixed<H: Halves>(a: H, b: H, f: H) -> H {
    a.minus(a.product_high(f)).plus(b.product_high(f))
}

struct MixRow;

impl<V: Lanes> Kernel for (MixRow, PhantomData<V>, &[u16], &[u32; CHUNK], &mut [u16]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, samples, pairs, out) = self;
        mix_row::<V::Halves>(samples, pairs, out);
    }
}

/// Between the values of two codes along a row.
#[inline(always)]
fn mix_row<H: Halves>(samples: &[u16], pairs: &[u32; CHUNK], out: &mut [u16]) {
    let len = out.len();
    let Some(samples) = samples.get(..len) else {
        return;
    };
    each!(H, len, |at, WHOLE| {
        let f = fraction(H::load::<WHOLE>(samples, at));
        let [first, next] = H::load_pairs(pairs, at);
        mixed(first, next, f).store::<WHOLE>(out, at);
    });
}

struct MixColours;

impl<V: Lanes> Kernel for (MixColours, PhantomData<V>, &[u16], &[[u32; CHUNK]; 3], [&mut [u16]; 3]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, samples, [red, green, blue], [r, g, b]) = self;
        mix_row::<V::Halves>(samples, red, r);
        mix_row::<V::Halves>(samples, green, g);
        mix_row::<V::Halves>(samples, blue, b);
    }
}
