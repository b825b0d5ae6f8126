//! Segments one after the other on a machine without vectors: the same bits by fewer instructions.
//!
//! Fractions fill 32 bits, so that a look-up is one product and a sum whose upper half is taken, and no shift is by a number that
//! is known at run time only. Both ends are found once for all lists; all lists have one length, so that bounds are tested once.
//! A segment of one bin has a length whose reciprocal is known. Colours of 15 bits are rounded with the product.
//!
//! The end of the last bin has no node behind it: its segments go the way of the definition, as does what these lists are not.

use super::{Colours, Integral, nodes};
use crate::classify::Slab;
use crate::composite::Recurrence as _;
use crate::exp2::{LIMIT, absorbed};
use crate::lanes::{Lanes as _, Small};
use crate::precision::Precision;
use crate::reciprocal::reciprocal_small;
use crate::table::ENTRIES;

/// The nodes that bins begin with, and those that they end with: as many as there are bins.
#[derive(Clone, Copy)]
struct List<'a> {
    begin: &'a [u32],
    end: &'a [u32],
}

impl<'a> List<'a> {
    #[inline(always)]
    fn of(list: &'a [u32], bins: usize) -> Option<Self> {
        Some(Self {
            begin: list.get(..bins)?,
            end: list.get(1..)?.get(..bins)?,
        })
    }

    /// The integral up to a node coordinate: `a + ((b - a) f + 1/2)`, f a fraction of 32 bits.
    #[inline(always)]
    fn up_to(self, End { bin, fraction }: End) -> Option<u32> {
        let (a, b) = (*self.begin.get(bin)?, *self.end.get(bin)?);
        let part = u64::from(b.wrapping_sub(a)) * u64::from(fraction);
        Some(((u64::from(a) << 32 | 1 << 31).wrapping_add(part) >> 32) as u32)
    }

    /// The integral over a segment.
    #[inline(always)]
    fn over(self, segment: Segment) -> Option<u32> {
        let high = self.up_to(segment.high)?;
        Some(high.wrapping_sub(self.up_to(segment.low)?))
    }
}

/// An end of a segment.
#[derive(Clone, Copy)]
struct End {
    bin: usize,
    /// Of the bin, 32 bits.
    fraction: u32,
}

impl End {
    #[inline(always)]
    fn of(u: u32, bits: u32) -> Self {
        Self {
            bin: (u >> bits) as usize,
            fraction: u << (32 - bits),
        }
    }
}

/// A segment.
#[derive(Clone, Copy)]
struct Segment {
    low: End,
    high: End,
    length: u32,
}

impl Segment {
    #[inline(always)]
    fn between(front: i32, back: i32, sample_bits: u32, bits: u32) -> Self {
        let (low, high) = if front < back { (front, back) } else { (back, front) };
        let length = high.wrapping_sub(low);
        let (half, bin) = (1 << sample_bits >> 1, 1 << bits);
        let low = low.wrapping_add(half);
        let (low, length) = if length >= bin {
            (low, length)
        } else {
            let wide = low.wrapping_sub(bin.wrapping_sub(length).wrapping_add(1) >> 1);
            (
                Ord::min(Ord::max(wide, 0), ((ENTRIES as i32) << sample_bits) - bin),
                bin,
            )
        };
        let (low, length) = (low as u32, length as u32);
        Self {
            low: End::of(low, bits),
            high: End::of(low.wrapping_add(length), bits),
            length,
        }
    }
}

/// Where a colour goes.
type Colour<'a> = ((&'a mut i32, &'a mut i32), &'a mut i32);

/// What opacities of a row have in common.
struct Rate {
    scaled: u32,
    /// Bits of a bin.
    bits: u32,
    /// To be shifted by, less what the length's zeros make up for.
    shift: u32,
}

impl Rate {
    /// The opacity of a segment with this integral, which is not 0.
    #[inline(always)]
    fn opacity(&self, integral: u32, length: u32) -> i32 {
        let k = length.leading_zeros().wrapping_sub(5);
        let rate = if length == 1 << self.bits {
            self.scaled
        } else {
            let reciprocal = reciprocal_small(length << k);
            ((u64::from(reciprocal) * u64::from(self.scaled)) >> 26) as u32
        };
        let product = u64::from(integral) * u64::from(rate);
        let shift = self.shift.wrapping_sub(k);
        // Twice y, and rounded then.
        let twice = if shift >= 32 {
            (product >> 32) as u32 >> (shift - 32)
        } else {
            Ord::min(product >> shift, u64::from(u32::MAX)) as u32
        };
        let y = (Ord::min(twice, 2 * LIMIT) + 1) >> 1;
        let mut out = [0];
        absorbed(Small::splat(y as i32)).store(&mut out, 0);
        let [out] = out;
        out
    }
}

/// Division by an integral of extinction.
struct Mean {
    integral: u32,
    zeros: u32,
    /// Times 2^5.
    reciprocal: u32,
}

impl Mean {
    /// Of an integral that is not 0.
    #[inline(always)]
    fn of(integral: u32) -> Self {
        let zeros = integral.leading_zeros() & 31;
        Self {
            integral,
            zeros,
            reciprocal: (reciprocal_small(integral << zeros >> 5) + 1) << 5,
        }
    }

    /// The mean whose integral this is, of 15 to 31 bits.
    #[inline(always)]
    fn colour(&self, weighted: u32, bits: u32) -> u32 {
        // What the definition shifts right by 5 is cut here: the product is 2^10 times that of the definition.
        let raised = Ord::min(weighted, self.integral) << self.zeros & !31;
        let product = u64::from(raised) * u64::from(self.reciprocal);
        if bits < 24 {
            // At most 2^62 + 2^37: what is above 1 is rounded off.
            (product.wrapping_add(1 << (61 - bits)) >> (62 - bits)) as u32
        } else {
            let colour = Ord::min((product >> 31) as u32, 1 << 31);
            if bits == 31 {
                colour
            } else {
                (colour + (1 << (30 - bits))) >> (31 - bits)
            }
        }
    }
}

impl<L: AsRef<[u32]>> Integral<L> {
    /// Extinction and its products with red, green, blue.
    #[inline(always)]
    fn lists(&self) -> Option<[List<'_>; 4]> {
        let Colours::Each([red, green, blue]) = &self.colours else {
            return None;
        };
        let bins = nodes(self.grain) - 1;
        Some([
            List::of(self.extinction.as_ref(), bins)?,
            List::of(red.as_ref(), bins)?,
            List::of(green.as_ref(), bins)?,
            List::of(blue.as_ref(), bins)?,
        ])
    }

    #[cold]
    #[inline(never)]
    fn opacity_defined<P: Precision>(&self, p: P, front: i32, back: i32, scaled: u32) -> i32 {
        self.opacity_by::<P, Small>(p, front, back, scaled)
    }

    #[cold]
    #[inline(never)]
    fn colour_defined<P: Precision>(&self, p: P, front: i32, back: i32, ((r, g), b): Colour<'_>) {
        [*r, *g, *b] = self.colour_by::<P, Small>(p, front, back).map(|c| c as i32);
    }

    /// Opacities segment by segment.
    #[inline(never)]
    pub(super) fn opacity_row_small<P: Precision>(&self, p: P, slab: Slab<'_>, out: &mut [i32]) {
        let sample_bits = p.formats().sample_bits;
        let rate = Rate {
            scaled: self.scaled(slab.fraction),
            bits: self.bin_bits(p),
            shift: (self.exponent + self.length.bits + 1).wrapping_sub(sample_bits),
        };
        let rows = out.iter_mut().zip(slab.front).zip(slab.back);
        let Some(list) = List::of(self.extinction.as_ref(), nodes(self.grain) - 1) else {
            return rows.for_each(|((o, &front), &back)| *o = self.opacity_defined(p, front, back, rate.scaled));
        };
        for ((o, &front), &back) in rows {
            let segment = Segment::between(front, back, sample_bits, rate.bits);
            *o = match list.over(segment) {
                Some(0) => 0,
                Some(integral) => rate.opacity(integral, segment.length),
                None => self.opacity_defined(p, front, back, rate.scaled),
            };
        }
    }

    /// Colours segment by segment.
    #[inline(never)]
    pub(super) fn colour_row_small<P: Precision>(&self, p: P, slab: Slab<'_>, [red, green, blue]: [&mut [i32]; 3]) {
        let (sample_bits, bits) = (p.formats().sample_bits, self.bin_bits(p));
        let colour_bits = p.pixel().colour_bits();
        let rows = red.iter_mut().zip(green).zip(blue).zip(slab.front).zip(slab.back);
        let Some([extinction, r, g, b]) = self.lists() else {
            return rows.for_each(|((out, &front), &back)| self.colour_defined(p, front, back, out));
        };
        for ((out, &front), &back) in rows {
            let segment = Segment::between(front, back, sample_bits, bits);
            let integrals = || {
                Some([
                    extinction.over(segment)?,
                    r.over(segment)?,
                    g.over(segment)?,
                    b.over(segment)?,
                ])
            };
            let ((red, green), blue) = out;
            match integrals() {
                Some([0, ..]) => [*red, *green, *blue] = [0; 3],
                Some([integral, r, g, b]) => {
                    let mean = Mean::of(integral);
                    *red = mean.colour(r, colour_bits) as i32;
                    *green = mean.colour(g, colour_bits) as i32;
                    *blue = mean.colour(b, colour_bits) as i32;
                }
                None => self.colour_defined(p, front, back, ((red, green), blue)),
            }
        }
    }
}
