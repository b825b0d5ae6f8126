//! A scale whose largest code is 1.0.

use std::marker::PhantomData;

use slicecast::composite::{Dither, Pixel, Recurrence};
use slicecast::format::Opacity;
use slicecast::lanes::{Lanes, Wide};

use super::super::channels::Full;
use super::{Described, one, product, sum};

/// [`Product`](super::Product) on a scale whose largest code is 1.0 (Squeeze, section 3): `CORRECTED` after Blinn, equation 1, or with
/// one multiply and one shift, which makes 1.0 times 1.0 less than 1.0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scaled<C, const CORRECTED: bool>(PhantomData<C>);

impl<C: Full, const CORRECTED: bool> Scaled<C, CORRECTED> {
    #[inline(always)]
    fn product<V: Lanes>(a: V, b: V) -> V {
        let exact = a.product(b);
        let scaled = if CORRECTED {
            let sum = exact + V::Wide::splat(1 << (C::BITS - 1));
            sum + sum.shr(C::BITS)
        } else {
            exact
        };
        scaled.shr(C::BITS).narrow()
    }

    /// What a colour of 15 bits gives through an opacity. Not a closure: vectors stay vectors only where all is inlined.
    #[inline(always)]
    fn given<V: Lanes>(colour: V, opacity: V) -> V {
        Self::product(Self::scale(colour, 15), opacity)
    }

    /// A fraction of `bits` bits on this scale, to nearest.
    #[inline(always)]
    fn scale<V: Lanes>(value: V, bits: u32) -> V {
        product::<V, true>(value, one::<V, C>(), bits)
    }
}

impl<C: Full, const CORRECTED: bool> Recurrence for Scaled<C, CORRECTED> {
    type Channel = C;
    const FLOOR: C = C::LEAST;
    const TELESCOPING: bool = false;
    const COLOUR_BITS: u32 = 15;

    #[inline(always)]
    fn read(opacity: Opacity) -> Opacity {
        let code = Self::scale::<i32>(opacity.to_bits() as i32, 31) as u64;
        // Back to 1.31, to nearest; the divisor is a constant of the type.
        let one = u64::from(C::ONE.bits());
        Opacity::from_bits((((code << 32) + one) / (2 * one)) as u32)
    }

    #[inline(always)]
    fn over_lanes<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let a = Self::scale(opacity, 31);
        let before = pixel.transparency;
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                sum::<V, C>(r, Self::product(Self::given(cr, a), before)),
                sum::<V, C>(g, Self::product(Self::given(cg, a), before)),
                sum::<V, C>(b, Self::product(Self::given(cb, a), before)),
            ],
            transparency: Self::product(before, one::<V, C>().wrapping_sub(a)),
        }
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let a = Self::scale(opacity, 31);
        let t = one::<V, C>().wrapping_sub(a);
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                sum::<V, C>(Self::product(r, t), Self::given(cr, a)),
                sum::<V, C>(Self::product(g, t), Self::given(cg, a)),
                sum::<V, C>(Self::product(b, t), Self::given(cb, a)),
            ],
            transparency: Self::product(pixel.transparency, t),
        }
    }
}

impl<C: Full, const CORRECTED: bool> Described for Scaled<C, CORRECTED> {
    const ROUNDING: &'static str = if CORRECTED {
        "full scale, Blinn"
    } else {
        "full scale, one shift"
    };
    const BITS: u32 = C::BITS;
}
