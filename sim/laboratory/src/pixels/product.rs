//! Squeeze's recurrence: each product loses its low bits on its own.

use std::marker::PhantomData;

use slicecast::composite::{Dither, Pixel, Recurrence};
use slicecast::format::Opacity;
use slicecast::lanes::Lanes;

use super::super::channels::Binary;
use super::{Described, one, product, sum};

/// Squeeze's recurrence (equation 9; back to front equation 6) in 1.F, colours of `CB` bits.
///
/// Opacities are cut to F + 1 bits and halved where products are truncated, as in core's `Truncating15`; rounded to F
/// bits where they are rounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Product<C, const ROUND: bool, const CB: u32>(PhantomData<C>);

impl<C: Binary, const ROUND: bool, const CB: u32> Product<C, ROUND, CB> {
    /// Transparency and opacity of a sample, 1.F.
    #[inline(always)]
    fn sample<V: Lanes>(opacity: V) -> (V, V) {
        let one = one::<V, C>();
        if ROUND || C::FRACTION == 31 {
            let cut = 31 - C::FRACTION;
            let half = if ROUND { 1 << cut >> 1 } else { 0 };
            let a = opacity.wrapping_add(V::splat(half)).shr_unsigned(cut);
            (one.wrapping_sub(a), a)
        } else {
            let a = opacity.shr_unsigned(30 - C::FRACTION);
            ((one << 1).wrapping_sub(a).shr_unsigned(1), a.shr_unsigned(1))
        }
    }
}

impl<C: Binary, const ROUND: bool, const CB: u32> Recurrence for Product<C, ROUND, CB> {
    type Channel = C;
    const FLOOR: C = C::LEAST;
    const TELESCOPING: bool = false;
    const COLOUR_BITS: u32 = CB;

    #[inline(always)]
    fn read(opacity: Opacity) -> Opacity {
        // As `sample` has it: F bits rounded, F + 1 truncated.
        let (cut, half) = if ROUND {
            (31 - C::FRACTION, 1 << (31 - C::FRACTION) >> 1)
        } else {
            (30u32.saturating_sub(C::FRACTION), 0)
        };
        Opacity::from_bits((opacity.to_bits() + half) >> cut << cut)
    }

    #[inline(always)]
    fn over_lanes<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let (t, a) = Self::sample(opacity);
        let before = pixel.transparency;
        let given = |c: V| product::<V, ROUND>(product::<V, ROUND>(c, a, CB), before, C::FRACTION);
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                sum::<V, C>(r, given(cr)),
                sum::<V, C>(g, given(cg)),
                sum::<V, C>(b, given(cb)),
            ],
            transparency: product::<V, ROUND>(before, t, C::FRACTION),
        }
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let (t, a) = Self::sample(opacity);
        let behind = |old: V| product::<V, ROUND>(old, t, C::FRACTION);
        let given = |c: V| product::<V, ROUND>(c, a, CB);
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                sum::<V, C>(behind(r), given(cr)),
                sum::<V, C>(behind(g), given(cg)),
                sum::<V, C>(behind(b), given(cb)),
            ],
            transparency: behind(pixel.transparency),
        }
    }
}

impl<C: Binary, const ROUND: bool, const CB: u32> Described for Product<C, ROUND, CB> {
    const ROUNDING: &'static str = if ROUND { "rounded" } else { "truncated" };
    const BITS: u32 = C::FRACTION;
}
