//! The pixel of `Wide`: 1.31, telescoping.

use super::{ChannelFormat as _, Dither, Pixel, Recurrence};
use crate::format::Opacity;
use crate::lanes::{Lanes, Wide as _};

/// 1.31 in floor steps; 128 bits per pixel. At most 2^-31 is lost a step.
///
/// Over: `w = floor(T a / 2^31); T -= w; C += floor(c w / 2^31)`.
/// Under: `C = C - floor(C a / 2^31) + floor(c a / 2^31)`.
/// Close to 0 floor steps no longer move T (below 2^-20 those of an opacity under 2^-11), hence the floor there: 0.0003
/// of an 8-bit step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Telescoping31;

/// Product of two 1.31 numbers, truncated.
#[inline(always)]
fn product31<V: Lanes>(a: V, b: V) -> V {
    a.product(b).shr_narrow(31)
}

/// What an opacity leaves of a value.
#[inline(always)]
fn left31<V: Lanes>(value: V, opacity: V) -> V {
    value.wrapping_sub(product31(value, opacity))
}

impl Recurrence for Telescoping31 {
    type Channel = u32;

    #[inline(always)]
    fn format(self) -> &'static str {
        u32::NAME
    }

    #[inline(always)]
    fn one(self) -> u32 {
        u32::ONE
    }

    #[inline(always)]
    fn floor(self) -> u32 {
        1 << 11
    }

    #[inline(always)]
    fn telescoping(self) -> bool {
        true
    }

    #[inline(always)]
    fn colour_bits(self) -> u32 {
        31
    }

    #[inline(always)]
    fn read(self, opacity: Opacity) -> Opacity {
        opacity
    }

    #[inline(always)]
    fn over_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let w = product31(pixel.transparency, opacity);
        let [r, g, b] = pixel.colour;
        let [cr, cg, cb] = colour;
        Pixel {
            colour: [
                r.wrapping_add(product31(cr, w)),
                g.wrapping_add(product31(cg, w)),
                b.wrapping_add(product31(cb, w)),
            ],
            transparency: pixel.transparency.wrapping_sub(w),
        }
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                left31(r, opacity).wrapping_add(product31(cr, opacity)),
                left31(g, opacity).wrapping_add(product31(cg, opacity)),
                left31(b, opacity).wrapping_add(product31(cb, opacity)),
            ],
            transparency: left31(pixel.transparency, opacity),
        }
    }
}
