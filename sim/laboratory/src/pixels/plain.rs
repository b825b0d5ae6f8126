//! Products and telescoping pixels on a scale whose 1.0 is a power of two.

use slicecast::composite::Pixel;
use slicecast::format::Opacity;
use slicecast::lanes::{Lanes, Wide};

/// `a b` with `bits` low bits cut off, or rounded to nearest, halves up.
#[inline(always)]
pub(super) fn product<V: Lanes>(rounded: bool, a: V, b: V, bits: u32) -> V {
    let half = if rounded { 1 << bits >> 1 } else { 0 };
    (a.product(b) + V::Wide::splat(half)).shr(bits).narrow()
}

/// A sum that stops at 1.0.
#[inline(always)]
pub(super) fn sum<V: Lanes>(a: V, b: V, one: u32) -> V {
    a.wrapping_add(b).at_most_unsigned(V::splat(one as i32))
}

/// Channels of 1.F, colours of 15 or 31 bits.
#[derive(Clone, Copy)]
pub(super) struct Plain {
    pub(super) rounded: bool,
    pub(super) fraction: u32,
    pub(super) colour_bits: u32,
}

impl Plain {
    #[inline(always)]
    fn one(self) -> u32 {
        1 << self.fraction
    }

    #[inline(always)]
    fn product<V: Lanes>(self, a: V, b: V, bits: u32) -> V {
        product(self.rounded, a, b, bits)
    }

    /// Transparency and opacity of a sample, 1.F: opacities are cut to F + 1 bits and halved where products are truncated, as
    /// in core's `Truncating15`; rounded to F bits where they are rounded.
    #[inline(always)]
    fn sample<V: Lanes>(self, opacity: V) -> (V, V) {
        let one = V::splat(self.one() as i32);
        if self.rounded || self.fraction == 31 {
            let cut = 31 - self.fraction;
            let half = if self.rounded { 1 << cut >> 1 } else { 0 };
            let a = opacity.wrapping_add(V::splat(half)).shr_unsigned(cut);
            (one.wrapping_sub(a), a)
        } else {
            let a = opacity.shr_unsigned(30 - self.fraction);
            ((one << 1).wrapping_sub(a).shr_unsigned(1), a.shr_unsigned(1))
        }
    }

    /// The opacity as [`Plain::sample`] reads it.
    #[inline(always)]
    pub(super) fn read(self, opacity: Opacity) -> Opacity {
        let (cut, half) = if self.rounded {
            (31 - self.fraction, 1 << (31 - self.fraction) >> 1)
        } else {
            (30u32.saturating_sub(self.fraction), 0)
        };
        Opacity::from_bits((opacity.to_bits() + half) >> cut << cut)
    }

    #[inline(always)]
    pub(super) fn product_over<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V) -> Pixel<V> {
        let (t, a) = self.sample(opacity);
        let (before, one) = (pixel.transparency, self.one());
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                sum(r, self.given(cr, a, before), one),
                sum(g, self.given(cg, a, before), one),
                sum(b, self.given(cb, a, before), one),
            ],
            transparency: self.product(before, t, self.fraction),
        }
    }

    /// `(c a) T`.
    #[inline(always)]
    fn given<V: Lanes>(self, colour: V, a: V, before: V) -> V {
        self.product(self.product(colour, a, self.colour_bits), before, self.fraction)
    }

    #[inline(always)]
    pub(super) fn product_under<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V) -> Pixel<V> {
        let (t, a) = self.sample(opacity);
        let one = self.one();
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                sum(
                    self.product(r, t, self.fraction),
                    self.product(cr, a, self.colour_bits),
                    one,
                ),
                sum(
                    self.product(g, t, self.fraction),
                    self.product(cg, a, self.colour_bits),
                    one,
                ),
                sum(
                    self.product(b, t, self.fraction),
                    self.product(cb, a, self.colour_bits),
                    one,
                ),
            ],
            transparency: self.product(pixel.transparency, t, self.fraction),
        }
    }

    #[inline(always)]
    pub(super) fn telescoping_over<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V) -> Pixel<V> {
        let w = self.product(pixel.transparency, opacity, 31);
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                r.wrapping_add(self.product(cr, w, self.colour_bits)),
                g.wrapping_add(self.product(cg, w, self.colour_bits)),
                b.wrapping_add(self.product(cb, w, self.colour_bits)),
            ],
            transparency: pixel.transparency.wrapping_sub(w),
        }
    }

    /// Back to front, in channels in which 1.0 is `one`: a carrying channel's value and rest are one number.
    #[inline(always)]
    pub(super) fn telescoping_under<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, one: u32) -> Pixel<V> {
        let t = pixel.transparency;
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                self.mixed(r, cr, opacity, one),
                self.mixed(g, cg, opacity, one),
                self.mixed(b, cb, opacity, one),
            ],
            transparency: t.wrapping_sub(self.product(t, opacity, 31)),
        }
    }

    /// `C - C a + c a` on the channel's scale.
    #[inline(always)]
    fn mixed<V: Lanes>(self, old: V, colour: V, opacity: V, one: u32) -> V {
        let own = self.product(colour, V::splat(one as i32), self.colour_bits);
        let left = old.wrapping_sub(self.product(old, opacity, 31));
        sum(left, self.product(own, opacity, 31), one)
    }
}

/// The telescoping recurrence that keeps what each product loses (16 bits of it) and adds it to the next one.
///
/// `t = T a + rest; w = floor(t); T -= w; rest = t - w`: the rest of T is what is still to be taken from it. Alike
/// `C += floor(c w + rest)`, which is one sum of value and rest. w <= T, because `rest < 1` ulp and T is whole; an opacity
/// of 0 gives w = 0 and leaves the rest alone.
#[inline(always)]
pub(super) fn carrying_over<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V) -> Pixel<V> {
    let low = V::splat(0xffff);
    let value = pixel.transparency.shr_unsigned(16);
    let taken = value.product(opacity) + V::Wide::of(pixel.transparency & low).shl(15);
    let w = taken.shr(31).narrow();
    let rest = taken.shr(15).narrow() & low;
    let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
    Pixel {
        colour: [
            r.wrapping_add(carried(cr, w)),
            g.wrapping_add(carried(cg, w)),
            b.wrapping_add(carried(cb, w)),
        ],
        transparency: (value.wrapping_sub(w) << 16) | rest,
    }
}

/// `c w` in units of 2^-(F + 16): the product has 15 bits behind the point of w.
#[inline(always)]
fn carried<V: Lanes>(colour: V, w: V) -> V {
    colour.product(w).shl(1).narrow()
}
