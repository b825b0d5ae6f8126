//! What a sample takes from the transparency is what it gives: nothing is lost between the two.

use std::marker::PhantomData;

use slicecast::composite::{Channel, Dither, Pixel, Recurrence};
use slicecast::format::Opacity;
use slicecast::lanes::{Lanes, Wide};

use super::super::channels::{Binary, Carry};
use super::{Described, one, product, sum};

/// The telescoping recurrence with opacities of 31 bits; each product truncated or rounded half up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Telescoping<C, const ROUND: bool, const CB: u32>(PhantomData<C>);

/// `C - C a + c a` on a channel's scale, colours of `cb` bits.
#[inline(always)]
fn mixed<V: Lanes, C: Channel, const ROUND: bool>(old: V, colour: V, opacity: V, cb: u32) -> V {
    let own = product::<V, ROUND>(colour, one::<V, C>(), cb);
    let left = old.wrapping_sub(product::<V, ROUND>(old, opacity, 31));
    sum::<V, C>(left, product::<V, ROUND>(own, opacity, 31))
}

impl<C: Binary, const ROUND: bool, const CB: u32> Recurrence for Telescoping<C, ROUND, CB> {
    type Channel = C;
    const FLOOR: C = C::LEAST;
    const TELESCOPING: bool = true;
    const COLOUR_BITS: u32 = CB;

    #[inline(always)]
    fn read(opacity: Opacity) -> Opacity {
        opacity
    }

    #[inline(always)]
    fn over_lanes<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let w = product::<V, ROUND>(pixel.transparency, opacity, 31);
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                r.wrapping_add(product::<V, ROUND>(cr, w, CB)),
                g.wrapping_add(product::<V, ROUND>(cg, w, CB)),
                b.wrapping_add(product::<V, ROUND>(cb, w, CB)),
            ],
            transparency: pixel.transparency.wrapping_sub(w),
        }
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let t = pixel.transparency;
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                mixed::<V, C, ROUND>(r, cr, opacity, CB),
                mixed::<V, C, ROUND>(g, cg, opacity, CB),
                mixed::<V, C, ROUND>(b, cb, opacity, CB),
            ],
            transparency: t.wrapping_sub(product::<V, ROUND>(t, opacity, 31)),
        }
    }
}

impl<C: Binary, const ROUND: bool, const CB: u32> Described for Telescoping<C, ROUND, CB> {
    const ROUNDING: &'static str = if ROUND { "telescoping, rounded" } else { "telescoping" };
    const BITS: u32 = C::FRACTION;
}

/// The telescoping recurrence that keeps what each product loses (16 bits of it) and adds it to the next one.
///
/// `t = T a + rest; w = floor(t); T -= w; rest = t - w`: the rest of T is what is still to be taken from it. Alike
/// `C += floor(c w + rest)`, which is one sum of value and rest. w <= T, because `rest < 1` ulp and T is whole; an opacity of 0 gives w = 0 and leaves the rest alone.
/// Back to front value and rest are one number of F + 16 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Carrying<const F: u32>;

impl<const F: u32> Recurrence for Carrying<F> {
    type Channel = Carry<F>;
    const FLOOR: Carry<F> = Carry::ULP;
    const TELESCOPING: bool = true;
    const COLOUR_BITS: u32 = 15;

    #[inline(always)]
    fn read(opacity: Opacity) -> Opacity {
        opacity
    }

    #[inline(always)]
    fn over_lanes<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let low = V::splat(0xffff);
        let value = pixel.transparency.shr_unsigned(16);
        let taken = value.product(opacity) + V::Wide::of(pixel.transparency & low).shl(15);
        let w = taken.shr(31).narrow();
        let rest = taken.shr(15).narrow() & low;
        // In units of 2^-(F + 16): the product has 15 bits behind the point of w.
        let given = |c: V| c.product(w).shl(1).narrow();
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                r.wrapping_add(given(cr)),
                g.wrapping_add(given(cg)),
                b.wrapping_add(given(cb)),
            ],
            transparency: (value.wrapping_sub(w) << 16) | rest,
        }
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let t = pixel.transparency;
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                mixed::<V, Carry<F>, false>(r, cr, opacity, 15),
                mixed::<V, Carry<F>, false>(g, cg, opacity, 15),
                mixed::<V, Carry<F>, false>(b, cb, opacity, 15),
            ],
            transparency: t.wrapping_sub(product::<V, false>(t, opacity, 31)),
        }
    }
}

impl<const F: u32> Described for Carrying<F> {
    const ROUNDING: &'static str = "residual carry";
    const BITS: u32 = F;
    const SHOWN: u32 = 0xffff_0000;
}
