//! Compositing of a study: the recurrences that Squeeze proposes, compares with or would have met.
//!
//! | type | front to back | rounding |
//! |---|---|---|
//! | [`Product`] | `C += (c a) T; T = T t` (Squeeze, equation 9) | each product truncated, or half up |
//! | [`Telescoping`] | `w = T a; T -= w; C += c w` | each product truncated, or half up |
//! | `Dithered` (core) | the same | an offset that changes from plane to plane |
//! | [`Carrying`] | the same | what a product loses is added to the next one |
//! | [`Scaled`] | as [`Product`], on a scale whose largest code is 1.0 | corrected after Blinn (equation 1), or one shift |
//!
//! Every one keeps to the rules of `slicecast::composite`: nothing leaves 0 to 1, and but for the uncorrected scale an
//! opacity of 0 changes nothing. Rounded products and Blinn's can add up to one unit more than 1.0 and are saturated.

use std::marker::PhantomData;

use slicecast::composite::{Channel, Dither, Dithered, Pixel, Recurrence, Telescoping31, Truncating15, Unorm16};
use slicecast::format::Opacity;
use slicecast::lanes::{Lanes, Wide};

use super::channels::{Binary, Carry, Full, Short};

/// A recurrence that a study can name.
pub trait Described: Recurrence {
    /// How products lose their low bits.
    const ROUNDING: &'static str;
    /// Bits of the channel: behind the point, or all of them where the largest code is 1.0.
    const BITS: u32;
    /// The bits of a channel that make the picture; the others are the arithmetic's own.
    const SHOWN: u32 = u32::MAX;
}

impl Described for Truncating15 {
    const ROUNDING: &'static str = "truncated";
    const BITS: u32 = 15;
}

impl Described for Telescoping31 {
    const ROUNDING: &'static str = "telescoping";
    const BITS: u32 = 31;
}

impl Described for Dithered<Unorm16> {
    const ROUNDING: &'static str = "dithered";
    const BITS: u32 = 16;
}

impl<const F: u32> Described for Dithered<Short<F>> {
    const ROUNDING: &'static str = "dithered";
    const BITS: u32 = F;
}

/// `a b` with `bits` low bits cut off, or rounded to nearest, halves up.
#[inline(always)]
fn product<V: Lanes, const ROUND: bool>(a: V, b: V, bits: u32) -> V {
    let half = if ROUND { 1 << bits >> 1 } else { 0 };
    (a.product(b) + V::Wide::splat(half)).shr(bits).narrow()
}

/// 1.0 of a channel.
#[inline(always)]
fn one<V: Lanes, C: Channel>() -> V {
    V::splat(C::ONE.bits() as i32)
}

/// A sum that stops at 1.0.
#[inline(always)]
fn sum<V: Lanes, C: Channel>(a: V, b: V) -> V {
    a.wrapping_add(b).at_most_unsigned(one::<V, C>())
}

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

/// [`Product`] on a scale whose largest code is 1.0 (Squeeze, section 3): `CORRECTED` after Blinn, equation 1, or with
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
        let given = |c: V| Self::product(Self::product(Self::scale(c, 15), a), before);
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                sum::<V, C>(r, given(cr)),
                sum::<V, C>(g, given(cg)),
                sum::<V, C>(b, given(cb)),
            ],
            transparency: Self::product(before, one::<V, C>().wrapping_sub(a)),
        }
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let a = Self::scale(opacity, 31);
        let t = one::<V, C>().wrapping_sub(a);
        let given = |c: V| Self::product(Self::scale(c, 15), a);
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                sum::<V, C>(Self::product(r, t), given(cr)),
                sum::<V, C>(Self::product(g, t), given(cg)),
                sum::<V, C>(Self::product(b, t), given(cb)),
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

#[cfg(test)]
mod tests {
    use super::super::channels::{Byte, Long, Packed};
    use super::*;
    use proptest::prelude::*;

    type Samples = Vec<([u32; 3], Opacity)>;

    fn samples() -> impl Strategy<Value = Samples> {
        let colour = prop::array::uniform3(prop_oneof![0u32..=32768, Just(32768), Just(0)]);
        let opacity = prop_oneof![0u32..=1 << 31, 0u32..200_000, Just(1u32 << 31), Just(0)];
        prop::collection::vec((colour, opacity.prop_map(Opacity::from_bits)), 0..120)
    }

    fn ray<R: Recurrence>(samples: &Samples) -> Vec<Pixel<R::Channel>> {
        let mut pixel = Pixel::<R::Channel>::clear();
        let mut all = vec![pixel];
        for (k, &(c, a)) in samples.iter().enumerate() {
            pixel = R::over(
                pixel,
                c.map(|c| c << (R::COLOUR_BITS - 15)),
                a,
                Dither::of_plane(k as u32),
            );
            all.push(pixel);
        }
        all
    }

    /// Nothing leaves 0 to 1, transparency never rises, nothing changes at an opacity of 0 or behind a finished ray.
    fn keeps_the_rules<R: Described>(samples: &Samples) -> Result<(), TestCaseError> {
        let one = R::Channel::ONE;
        for (before, (sample, k)) in ray::<R>(samples).into_iter().zip(samples.iter().zip(0..)) {
            let (c, a) = (sample.0.map(|c| c << (R::COLOUR_BITS - 15)), sample.1);
            let dither = Dither::of_plane(k);
            let after = R::over(before, c, a, dither);
            let left = |pixel: Pixel<R::Channel>| pixel.transparency.bits() & R::SHOWN;
            prop_assert!(left(after) <= left(before));
            prop_assert!(after.colour.iter().all(|c| *c <= one));
            prop_assert_eq!(R::over(before, c, Opacity::ZERO, dither), before);
            prop_assert_eq!(
                R::under(before, c, Opacity::ZERO, dither).colour.map(Channel::bits),
                before.colour.map(Channel::bits)
            );
            let finished = Pixel {
                transparency: R::Channel::default(),
                ..before
            };
            prop_assert_eq!(R::over(finished, c, a, dither), finished);
            prop_assert!(R::under(before, c, a, dither).colour.iter().all(|c| *c <= one));
        }
        Ok(())
    }

    /// How far the last pixel is from f64, in units of the channel.
    fn away<R: Recurrence>(samples: &Samples) -> f64 {
        let one = f64::from(R::Channel::ONE.bits());
        let mut model = crate::model::Pixel::TRANSPARENT;
        for (c, a) in samples {
            let opacity = f64::from(a.to_bits()) / 2147483648.0;
            model = model.front_to_back(c.map(|c| f64::from(c) / 32768.0), opacity);
        }
        let last = ray::<R>(samples)[samples.len()];
        let value = |c: R::Channel| f64::from(c.bits());
        (0..3)
            .map(|c| (value(last.colour[c]) - model.colour[c] * one).abs())
            .fold((value(last.transparency) - model.transparency * one).abs(), f64::max)
    }

    proptest! {
        #[test]
        fn every_recurrence_keeps_the_rules(samples in samples()) {
            keeps_the_rules::<Product<Short<8>, false, 15>>(&samples)?;
            keeps_the_rules::<Product<Short<8>, true, 15>>(&samples)?;
            keeps_the_rules::<Product<Long<16>, true, 15>>(&samples)?;
            keeps_the_rules::<Product<u32, false, 31>>(&samples)?;
            keeps_the_rules::<Product<u32, true, 31>>(&samples)?;
            keeps_the_rules::<Telescoping<Short<12>, false, 15>>(&samples)?;
            keeps_the_rules::<Telescoping<Packed<23>, true, 31>>(&samples)?;
            keeps_the_rules::<Carrying<8>>(&samples)?;
            keeps_the_rules::<Carrying<15>>(&samples)?;
            keeps_the_rules::<Dithered<Short<10>>>(&samples)?;
            keeps_the_rules::<Scaled<Byte, true>>(&samples)?;
            keeps_the_rules::<Scaled<Unorm16, true>>(&samples)?;
        }

        #[test]
        fn at_the_same_width_the_same_bits_as_core(samples in samples()) {
            let study = ray::<Product<u16, false, 15>>(&samples);
            prop_assert_eq!(study, ray::<Truncating15>(&samples));
            let study = ray::<Telescoping<u32, false, 31>>(&samples);
            prop_assert_eq!(study, ray::<Telescoping31>(&samples));
            for &(_, a) in &samples {
                prop_assert_eq!(Product::<u16, false, 15>::read(a), Truncating15::read(a));
            }
        }

        /// A step of a truncated product errs by less than 3 ulp, a rounded one by 2, a telescoping one by 2.
        #[test]
        fn errors_grow_with_the_steps_and_no_faster(samples in samples()) {
            let steps = samples.len() as f64;
            prop_assert!(away::<Product<Short<10>, false, 15>>(&samples) <= 3.0 * steps + 1.0);
            prop_assert!(away::<Product<Short<10>, true, 15>>(&samples) <= 2.0 * steps + 1.0);
            prop_assert!(away::<Telescoping<Short<10>, false, 15>>(&samples) <= 2.0 * steps + 1.0);
            prop_assert!(away::<Telescoping<Packed<23>, true, 31>>(&samples) <= 2.0 * steps + 1.0);
            prop_assert!(away::<Scaled<Byte, true>>(&samples) <= 3.0 * steps + 1.0);
        }
    }

    /// What one step loses is there in the next: white fog keeps C + T = 1, and T stays within a unit of the exact
    /// value after any number of equal steps, where truncation drifts by one a step.
    #[test]
    fn residual_carry_does_not_drift() {
        let fog: Samples = vec![([32768; 3], Opacity::from_bits(1 << 19)); 4096];
        // In units of the value; the rest has 16 bits more.
        let carried = away::<Carrying<12>>(&fog) / 65536.0;
        assert!(carried < 2.0, "{carried}");
        assert!(away::<Telescoping<Short<12>, false, 15>>(&fog) > 500.0);
        for pixel in ray::<Carrying<12>>(&fog) {
            let (c, t) = (pixel.colour[0].bits(), pixel.transparency.bits());
            assert_eq!((c >> 16) + (t >> 16), 4096);
        }
    }

    /// Squeeze, section 3: 255 * 255 >> 8 is 254, so complete transparency turns to opacity within 255 samples.
    #[test]
    fn one_shift_on_the_full_scale_loses_transparency() {
        let clear: Samples = vec![([32768; 3], Opacity::ZERO); 255];
        assert_eq!(ray::<Scaled<Byte, false>>(&clear)[255].transparency.bits(), 0);
        assert_eq!(ray::<Scaled<Byte, true>>(&clear)[255].transparency.bits(), 255);
    }
}
