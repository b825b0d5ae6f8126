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

mod product;
mod scaled;
mod telescoping;

use slicecast::composite::{Channel, Dithered, Recurrence, Telescoping31, Truncating15, Unorm16};
use slicecast::lanes::{Lanes, Wide};

use super::channels::Short;

pub use product::Product;
pub use scaled::Scaled;
pub use telescoping::{Carrying, Telescoping};

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

#[cfg(test)]
mod tests {
    use super::super::channels::{Byte, Long, Packed};
    use super::*;
    use proptest::prelude::*;
    use slicecast::composite::{Dither, Pixel};
    use slicecast::format::Opacity;

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
        let mut model = slicecast_model::Pixel::TRANSPARENT;
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
