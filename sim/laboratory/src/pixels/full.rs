//! Products on a scale whose largest code is 1.0 (Squeeze, section 3).

use slicecast::composite::Pixel;
use slicecast::format::Opacity;
use slicecast::lanes::{Lanes, Wide};

use super::plain::{product, sum};

/// N bits, colours of 15 bits. `rounded`: after Blinn (Squeeze, equation 1); otherwise one multiply and one shift, which makes
/// 1.0 times 1.0 less than 1.0.
#[derive(Clone, Copy)]
pub(super) struct Full {
    pub(super) bits: u32,
    pub(super) rounded: bool,
}

/// A fraction of `fraction` bits on a scale of `bits` bits, to nearest.
#[inline(always)]
fn scale<V: Lanes>(bits: u32, value: V, fraction: u32) -> V {
    product(true, value, V::splat((1 << bits) - 1), fraction)
}

/// The opacity of the nearest code, back in 1.31, to nearest.
pub(super) fn read(bits: u32, opacity: Opacity) -> Opacity {
    let code = scale(bits, opacity.to_bits() as i32, 31) as u64;
    let one = (1u64 << bits) - 1;
    Opacity::from_bits((((code << 32) + one) / (2 * one)) as u32)
}

impl Full {
    #[inline(always)]
    fn one(self) -> u32 {
        (1 << self.bits) - 1
    }

    #[inline(always)]
    fn product<V: Lanes>(self, a: V, b: V) -> V {
        let exact = a.product(b);
        let scaled = if self.rounded {
            let sum = exact + V::Wide::splat(1 << (self.bits - 1));
            sum + sum.shr(self.bits)
        } else {
            exact
        };
        scaled.shr(self.bits).narrow()
    }

    /// What a colour gives through an opacity.
    #[inline(always)]
    fn given<V: Lanes>(self, colour: V, opacity: V) -> V {
        self.product(scale(self.bits, colour, 15), opacity)
    }

    #[inline(always)]
    pub(super) fn over<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V) -> Pixel<V> {
        let a = scale(self.bits, opacity, 31);
        let (before, one) = (pixel.transparency, self.one());
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                sum(r, self.product(self.given(cr, a), before), one),
                sum(g, self.product(self.given(cg, a), before), one),
                sum(b, self.product(self.given(cb, a), before), one),
            ],
            transparency: self.product(before, V::splat(one as i32).wrapping_sub(a)),
        }
    }

    #[inline(always)]
    pub(super) fn under<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V) -> Pixel<V> {
        let a = scale(self.bits, opacity, 31);
        let one = self.one();
        let t = V::splat(one as i32).wrapping_sub(a);
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                sum(self.product(r, t), self.given(cr, a), one),
                sum(self.product(g, t), self.given(cg, a), one),
                sum(self.product(b, t), self.given(cb, a), one),
            ],
            transparency: self.product(pixel.transparency, t),
        }
    }
}
