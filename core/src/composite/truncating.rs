//! The pixel of `Paper`: Squeeze's recurrence, every product truncated.

use super::{ChannelFormat as _, Dither, Pixel, Recurrence};
use crate::format::Opacity;
use crate::lanes::Lanes;

/// 1.15, every product truncated: Squeeze, equations 9 and 6. 64 bits per pixel.
///
/// With `A = a >> 15` (1.16), `t = (2^16 - A) >> 1` and `p = (c (A >> 1)) >> 15`:
/// over: `C += (p T) >> 15; T = (T t) >> 15`; under: `C = ((C t) >> 15) + p`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Truncating15;

/// Product of two 1.15 numbers, truncated.
#[inline(always)]
fn product15<V: Lanes>(a: V, b: V) -> V {
    (a * b) >> 15
}

impl Truncating15 {
    /// Transparency and opacity of a sample, 1.15.
    #[inline(always)]
    fn sample<V: Lanes>(opacity: V) -> (V, V) {
        let a = opacity.shr_unsigned(15);
        ((V::splat(1 << 16) - a) >> 1, a >> 1)
    }
}

impl Recurrence for Truncating15 {
    type Channel = u16;

    #[inline(always)]
    fn format(self) -> &'static str {
        u16::NAME
    }

    #[inline(always)]
    fn one(self) -> u16 {
        u16::ONE
    }

    #[inline(always)]
    fn floor(self) -> u16 {
        1
    }

    #[inline(always)]
    fn telescoping(self) -> bool {
        false
    }

    #[inline(always)]
    fn colour_bits(self) -> u32 {
        15
    }

    #[inline(always)]
    fn read(self, opacity: Opacity) -> Opacity {
        Opacity::from_bits(opacity.to_bits() >> 15 << 15)
    }

    #[inline(always)]
    fn over_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let (t, a) = Self::sample(opacity);
        let before = pixel.transparency;
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                r + product15(product15(cr, a), before),
                g + product15(product15(cg, a), before),
                b + product15(product15(cb, a), before),
            ],
            transparency: product15(before, t),
        }
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let (t, a) = Self::sample(opacity);
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                product15(r, t) + product15(cr, a),
                product15(g, t) + product15(cg, a),
                product15(b, t) + product15(cb, a),
            ],
            transparency: product15(pixel.transparency, t),
        }
    }
}
