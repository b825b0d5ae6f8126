//! The pixel of `Compact`: 16 bits, telescoping, with a dither that changes from plane to plane.

use super::{Channel as _, ChannelFormat as _, Dither, Pixel, PixelRow, Recurrence, Unorm16};
use crate::format::Opacity;
use crate::lanes::{Lanes, Wide as _};

/// [`Unorm16`] with a dither that changes from plane to plane; 64 bits per pixel.
///
/// With the plane's [`Dither`] d:
/// over: `w = (T a + (2 dT + 1) 2^15) >> 31; T -= w; C += (c w + dC) >> 15`;
/// under: `w` and T alike, `C += ((c - C) a + (2 dC + 1) 2^15) >> 31` with c on the channel's scale.
/// The opacity keeps its 31 bits: rounded to 1.16 it would be wrong by up to 1 % in thin fog, the same way at every
/// sample, and no dither could mend that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dithered;

/// The arithmetic of [`Dithered`] front to back, in channels of any format of at most 16 bits.
#[inline(always)]
pub fn dithered_over<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V> {
    let w = taken(pixel.transparency, opacity, dither);
    let offset = V::splat(dither.colour as i32);
    let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
    Pixel {
        colour: [
            r + given(cr, w, offset),
            g + given(cg, w, offset),
            b + given(cb, w, offset),
        ],
        transparency: pixel.transparency - w,
    }
}

/// The arithmetic of [`Dithered`] back to front, in channels in which 1.0 is `one`, at most 65535.
#[inline(always)]
pub fn dithered_under<V: Lanes>(one: u32, pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V> {
    let w = taken(pixel.transparency, opacity, dither);
    let half = V::Wide::splat(i64::from(2 * dither.colour + 1) << 15);
    let ([r, g, b], [cr, cg, cb], one) = (pixel.colour, colour, V::splat(one as i32));
    Pixel {
        colour: [
            dithered_mix(r, cr, opacity, one, half),
            dithered_mix(g, cg, opacity, one, half),
            dithered_mix(b, cb, opacity, one, half),
        ],
        transparency: pixel.transparency - w,
    }
}

/// The light that a sample takes: at most the transparency, and none at an opacity of 0.
#[inline(always)]
fn taken<V: Lanes>(transparency: V, opacity: V, dither: Dither) -> V {
    transparency.product16_31(opacity, (2 * dither.transparency + 1) << 15)
}

/// What a sample of this colour gives of the light that it takes.
#[inline(always)]
fn given<V: Lanes>(colour: V, taken: V, offset: V) -> V {
    colour.wrapping_mul(taken).wrapping_add(offset).shr_unsigned(15)
}

/// The same in the upper 16 bits, for twice the offset: twice the sum that is shifted by 15 need not be shifted at all.
#[inline(always)]
fn given_above<V: Lanes>(colour: V, taken: V, twice_offset: V) -> V {
    (colour + colour).wrapping_mul(taken).wrapping_add(twice_offset)
}

/// `C + ((c - C) a + half) >> 31`, with C inside the shift so that nothing is negative.
#[inline(always)]
fn dithered_mix<V: Lanes>(old: V, colour: V, opacity: V, one: V, half: V::Wide) -> V {
    let scaled = colour.wrapping_mul(one);
    let scaled = scaled.wrapping_add(V::splat(1 << 14)).shr_unsigned(15);
    let sum = V::Wide::of(old).shl(31) + scaled.product(opacity) - old.product(opacity);
    (sum + half).shr_narrow(31)
}

impl Recurrence for Dithered {
    type Channel = Unorm16;

    #[inline(always)]
    fn format(self) -> &'static str {
        Unorm16::NAME
    }

    #[inline(always)]
    fn one(self) -> Unorm16 {
        Unorm16::ONE
    }

    #[inline(always)]
    fn floor(self) -> Unorm16 {
        Unorm16(1)
    }

    #[inline(always)]
    fn telescoping(self) -> bool {
        true
    }

    #[inline(always)]
    fn colour_bits(self) -> u32 {
        15
    }

    #[inline(always)]
    fn read(self, opacity: Opacity) -> Opacity {
        opacity
    }

    #[inline(always)]
    fn over_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V> {
        dithered_over(pixel, colour, opacity, dither)
    }

    #[inline(always)]
    fn over_two<V: Lanes>(
        self,
        row: &mut PixelRow<'_, Unorm16>,
        at: usize,
        [first, second]: [([V; 3], V); 2],
        dither: Dither,
        floor: V,
    ) {
        // No closure and no array's `map`, which may become calls: a call keeps no vector in a register.
        let transparency = &mut *row.transparency;
        let t0: V = V::load_as(transparency, at, Unorm16::bits);
        let t1: V = V::load_as(transparency, at + V::COUNT, Unorm16::bits);
        let (w0, w1) = (taken(t0, first.1, dither), taken(t1, second.1, dither));
        let (t0, t1) = (t0 - w0, t1 - w1);
        let left = [t0.at_least_then(floor, t0), t1.at_least_then(floor, t1)];
        V::store_two_as(left, transparency, at, Unorm16::from_bits);
        let (offset, [r0, g0, b0], [r1, g1, b1]) = (V::splat(2 * dither.colour as i32), first.0, second.0);
        let [red, green, blue] = &mut row.colour;
        let given = [given_above(r0, w0, offset), given_above(r1, w1, offset)];
        V::add_upper_as(given, red, at, Unorm16::bits, Unorm16::from_bits);
        let given = [given_above(g0, w0, offset), given_above(g1, w1, offset)];
        V::add_upper_as(given, green, at, Unorm16::bits, Unorm16::from_bits);
        let given = [given_above(b0, w0, offset), given_above(b1, w1, offset)];
        V::add_upper_as(given, blue, at, Unorm16::bits, Unorm16::from_bits);
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V> {
        dithered_under(Unorm16::ONE.bits(), pixel, colour, opacity, dither)
    }
}
