//! The rules of a pixel for every arithmetic, and the same bits as core's where core has it.

use super::Arithmetic::{Dithered, Product, Telescoping};
use super::Scale::{Binary, Carrying, Full};
use super::*;
use proptest::prelude::*;
use slicecast::composite::{self, Telescoping31, Truncating15};

type Samples = Vec<([u32; 3], Opacity)>;

fn pixel(arithmetic: Arithmetic, scale: Scale) -> StudyPixel {
    StudyPixel::new(arithmetic, scale).unwrap()
}

fn deep(arithmetic: Arithmetic, scale: Scale) -> StudyPixel {
    pixel(arithmetic, scale).deep().unwrap()
}

const TRUNCATED: Arithmetic = Product { rounded: false };
const ROUNDED: Arithmetic = Product { rounded: true };
const PLAIN: Arithmetic = Telescoping { rounded: false };
const NEAREST: Arithmetic = Telescoping { rounded: true };

fn samples() -> impl Strategy<Value = Samples> {
    let colour = prop::array::uniform3(prop_oneof![0u32..=32768, Just(32768), Just(0)]);
    let opacity = prop_oneof![0u32..=1 << 31, 0u32..200_000, Just(1u32 << 31), Just(0)];
    prop::collection::vec((colour, opacity.prop_map(Opacity::from_bits)), 0..120)
}

/// The pixels of a ray, with `over` or `under`.
fn ray<R: Recurrence>(r: R, samples: &Samples, back_to_front: bool) -> Vec<[u32; 4]> {
    let bits = |p: Pixel<R::Channel>| {
        let [red, green, blue] = p.colour.map(|c| c.bits());
        [red, green, blue, p.transparency.bits()]
    };
    let mut pixel = r.clear();
    let mut all = vec![bits(pixel)];
    for (k, &(c, a)) in samples.iter().enumerate() {
        let (c, dither) = (c.map(|c| c << (r.colour_bits() - 15)), Dither::of_plane(k as u32));
        pixel = if back_to_front {
            r.under(pixel, c, a, dither)
        } else {
            r.over(pixel, c, a, dither)
        };
        all.push(bits(pixel));
    }
    all
}

/// Nothing leaves 0 to 1, transparency never rises, nothing changes at an opacity of 0 or behind a finished ray.
fn keeps_the_rules(r: StudyPixel, samples: &Samples) -> Result<(), TestCaseError> {
    let (one, shown) = (r.one(), r.scale().shown());
    let mut before = r.clear();
    for (k, (c, a)) in samples.iter().enumerate() {
        let (c, a) = (c.map(|c| c << (r.colour_bits() - 15)), *a);
        let dither = Dither::of_plane(k as u32);
        let after = r.over(before, c, a, dither);
        let left = |pixel: Pixel<Stored>| pixel.transparency.bits() & shown;
        prop_assert!(left(after) <= left(before));
        prop_assert!(after.colour.iter().all(|c| *c <= one));
        prop_assert_eq!(r.over(before, c, Opacity::ZERO, dither), before);
        prop_assert_eq!(r.under(before, c, Opacity::ZERO, dither).colour, before.colour);
        let finished = Pixel {
            transparency: Stored::default(),
            ..before
        };
        prop_assert_eq!(r.over(finished, c, a, dither), finished);
        prop_assert!(r.under(before, c, a, dither).colour.iter().all(|c| *c <= one));
        before = after;
    }
    Ok(())
}

/// How far the last pixel is from f64, in units of the channel.
fn away(r: StudyPixel, samples: &Samples) -> f64 {
    let one = f64::from(r.scale().one());
    let mut model = slicecast_model::Pixel::TRANSPARENT;
    for (c, a) in samples {
        let opacity = f64::from(a.to_bits()) / 2147483648.0;
        model = model.front_to_back(c.map(|c| f64::from(c) / 32768.0), opacity);
    }
    let [red, green, blue] = model.colour;
    let last = ray(r, samples, false)[samples.len()];
    let error = |(bits, exact): (u32, f64)| (f64::from(bits) - exact * one).abs();
    let exact = [red, green, blue, model.transparency];
    last.into_iter().zip(exact).map(error).fold(0.0, f64::max)
}

proptest! {
    #[test]
    fn every_pixel_keeps_the_rules(samples in samples(), bits in 1u32..=31, narrow in 1u32..=15, full in 2u32..=16) {
        for arithmetic in [TRUNCATED, ROUNDED, PLAIN, NEAREST] {
            keeps_the_rules(pixel(arithmetic, Binary(bits)), &samples)?;
            keeps_the_rules(deep(arithmetic, Binary(bits)), &samples)?;
        }
        keeps_the_rules(pixel(PLAIN, Carrying(narrow)), &samples)?;
        keeps_the_rules(pixel(Dithered, Binary(narrow)), &samples)?;
        keeps_the_rules(pixel(Dithered, Full(full)), &samples)?;
        keeps_the_rules(pixel(ROUNDED, Full(full)), &samples)?;
    }

    #[test]
    fn at_the_same_width_the_same_bits_as_core(samples in samples(), back_to_front in any::<bool>()) {
        let same = |study: StudyPixel, core: Vec<[u32; 4]>| ray(study, &samples, back_to_front) == core;
        prop_assert!(same(pixel(TRUNCATED, Binary(15)), ray(Truncating15, &samples, back_to_front)));
        prop_assert!(same(pixel(Dithered, Full(16)), ray(composite::Dithered, &samples, back_to_front)));
        // Back to front the study scales a colour first.
        let study = ray(deep(PLAIN, Binary(31)), &samples, false);
        prop_assert_eq!(study, ray(Telescoping31, &samples, false));
        for &(_, a) in &samples {
            prop_assert_eq!(pixel(TRUNCATED, Binary(15)).read(a), Truncating15.read(a));
        }
    }

    /// A step of a truncated product errs by less than 3 ulp, a rounded one by 2, a telescoping one by 2.
    #[test]
    fn errors_grow_with_the_steps_and_no_faster(samples in samples(), bits in 8u32..=24) {
        let steps = samples.len() as f64;
        prop_assert!(away(pixel(TRUNCATED, Binary(bits.min(14))), &samples) <= 3.0 * steps + 1.0);
        prop_assert!(away(pixel(ROUNDED, Binary(bits.min(14))), &samples) <= 2.0 * steps + 1.0);
        prop_assert!(away(pixel(PLAIN, Binary(bits)), &samples) <= 2.0 * steps + 1.0);
        prop_assert!(away(deep(NEAREST, Binary(bits)), &samples) <= 2.0 * steps + 1.0);
        prop_assert!(away(pixel(ROUNDED, Full(8)), &samples) <= 3.0 * steps + 1.0);
    }
}

/// What one step loses is there in the next: white fog keeps C + T = 1, and T stays within a unit of the exact
/// value after any number of equal steps, where truncation drifts by one per step.
#[test]
fn residual_carry_does_not_drift() {
    let fog: Samples = vec![([32768; 3], Opacity::from_bits(1 << 19)); 4096];
    // In units of the value; the rest has 16 bits more.
    let carried = away(pixel(PLAIN, Carrying(12)), &fog) / 65536.0;
    assert!(carried < 2.0, "{carried}");
    assert!(away(pixel(PLAIN, Binary(12)), &fog) > 500.0);
    for [colour, _, _, transparency] in ray(pixel(PLAIN, Carrying(12)), &fog, false) {
        assert_eq!((colour >> 16) + (transparency >> 16), 4096);
    }
}

/// Squeeze, section 3: 255 * 255 >> 8 is 254, so complete transparency turns to opacity within 255 samples.
#[test]
fn one_shift_on_the_full_scale_loses_transparency() {
    let clear: Samples = vec![([32768; 3], Opacity::ZERO); 255];
    assert_eq!(ray(pixel(TRUNCATED, Full(8)), &clear, false)[255][3], 0);
    assert_eq!(ray(pixel(ROUNDED, Full(8)), &clear, false)[255][3], 255);
}

#[test]
fn formats_that_an_arithmetic_lacks_are_none() {
    assert_eq!(StudyPixel::new(Dithered, Binary(16)), None);
    assert_eq!(StudyPixel::new(Dithered, Carrying(12)), None);
    assert_eq!(StudyPixel::new(TRUNCATED, Binary(32)), None);
    assert_eq!(StudyPixel::new(PLAIN, Carrying(16)), None);
    assert_eq!(StudyPixel::new(PLAIN, Full(8)), None);
    assert_eq!(pixel(Dithered, Binary(12)).deep(), None);
}
