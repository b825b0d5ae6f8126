//! Compositing of samples of colour and extinction: no opacity is formed, and one factor serves extinction and colours.
//!
//! Source: Kraus and Bürger, section 3.4; `docs/contract/extinction.md` has the ranges. What is given is at most what is taken,
//! because a sample's colours are at most its extinction and both are multiplied and rounded alike.
//!
//! | value | format | range |
//! |---|---|---|
//! | s_t; s_k | 15.S | 0 to 32767 · 2^S; 0 to s_t |
//! | G, n | [`Absorption`] | s_t G <= 2^(n + 28) |
//!
//! Rounding: down (1.31), or with the plane's dither (16 bits), the same for all four. Overflow: none.

use core::iter::zip;

use super::{Channel as _, Dither, Dithered, Pixel, PixelRow, Recurrence, Telescoping31};
use crate::absorption::Absorption;
use crate::absorption::CENTRED_PHI;
use crate::absorption::PHI;
use crate::absorption::Phi;
use crate::lanes::{Lanes, Wide as _, places};
use crate::rows::{four, part};

/// A pixel that takes samples of colour and extinction.
pub trait Weighted: Recurrence {
    /// The values of phi that factors are made by.
    const PHI: &'static Phi;

    /// Pixels with one more sample behind them: extinction, and red, green and blue times extinction, with their factor and its
    /// n. This function is the definition; it leaves out the floor.
    fn over_factor<V: Lanes>(self, pixel: Pixel<V>, sample: [V; 4], factor: (V, u32), dither: Dither) -> Pixel<V>;
}

impl Weighted for Telescoping31 {
    /// Of errors of 31 bits those of phi would be the largest, if they added up.
    const PHI: &'static Phi = &CENTRED_PHI;

    /// `h = (T G) >> 31; w = (s_t h) >> (n - 3); T -= w; C_k += (s_k h) >> (n - 3)`.
    #[inline(always)]
    fn over_factor<V: Lanes>(self, pixel: Pixel<V>, sample: [V; 4], (factor, n): (V, u32), _: Dither) -> Pixel<V> {
        let h = pixel.transparency.product31(factor);
        let ([t, red, green, blue], [r, g, b]) = (sample, pixel.colour);
        Pixel {
            colour: [
                r.wrapping_add(shifted(red.product(h), n - 3)),
                g.wrapping_add(shifted(green.product(h), n - 3)),
                b.wrapping_add(shifted(blue.product(h), n - 3)),
            ],
            transparency: pixel.transparency.wrapping_sub(shifted(t.product(h), n - 3)),
        }
    }
}

impl Weighted for Dithered {
    const PHI: &'static Phi = &PHI;

    /// `h = (T G) >> 15; o = (2 dT + 1) << (n - 3); w = (s_t h + o) >> (n + 13); T -= w; C_k += (s_k h + o) >> (n + 13)`.
    #[inline(always)]
    fn over_factor<V: Lanes>(self, pixel: Pixel<V>, sample: [V; 4], (factor, n): (V, u32), dither: Dither) -> Pixel<V> {
        let h = pixel.transparency.product(factor).shr_narrow(15);
        let offset = V::Wide::splat(i64::from(2 * dither.transparency + 1) << (n - 3));
        let ([t, red, green, blue], [r, g, b]) = (sample, pixel.colour);
        Pixel {
            colour: [
                r + taken(red.product(h) + offset, n),
                g + taken(green.product(h) + offset, n),
                b + taken(blue.product(h) + offset, n),
            ],
            transparency: pixel.transparency - taken(t.product(h) + offset, n),
        }
    }
}

/// `product >> by`, 1 to 63, below 2^32. Vectors have an instruction less for either half of the bits.
#[inline(always)]
fn shifted<V: Lanes>(product: V::Wide, by: u32) -> V {
    if const { V::COUNT == 1 } {
        product.shr(by).narrow()
    } else if by < 32 {
        product.shr_narrow(by)
    } else {
        product.shr_upper(by)
    }
}

/// `sum >> (n + 13)`: with 12 fraction bits n is at least 26.
#[inline(always)]
fn taken<V: Lanes>(sum: V::Wide, n: u32) -> V {
    sum.shr_upper(n + 13)
}

/// Samples whose optical depths are found together.
const BLOCK: usize = 64;

/// Folds a row of samples into its pixels: rows of extinction, red, green and blue, as long as each other. Vectors without
/// extinction or without light are left out, which changes nothing.
#[inline(always)]
pub(crate) fn fold_weighted_row<R: Weighted, V: Lanes>(
    recurrence: R,
    row: &mut PixelRow<'_, R::Channel>,
    samples: [&[i32]; 4],
    absorption: Absorption,
    dither: Dither,
    floor: R::Channel,
) {
    let floor = V::splat(floor.bits() as i32);
    if const { V::COUNT == 1 } {
        fold_weighted_block::<R, V>(recurrence, row, samples, (absorption, &[]), (dither, floor));
        return;
    }
    // Look-ups take their places from memory. A loop of its own, since the compiler would take a vector apart that is read where it was
    // written.
    let mut depths = [0; BLOCK];
    let [extinction, ..] = samples;
    let mut first = 0;
    while first < extinction.len() {
        let block = first..(first + BLOCK).min(extinction.len());
        let samples = four(samples, |run| part(run, block.clone()));
        let [extinction, ..] = samples;
        for at in places::<V>(extinction.len()) {
            absorption.depth(V::load(extinction, at)).store(&mut depths, at);
        }
        let row = &mut row.span(block);
        fold_weighted_block::<R, V>(recurrence, row, samples, (absorption, &depths), (dither, floor));
        first += BLOCK;
    }
}

/// Folds samples of these depths; one lane finds them itself.
#[inline(always)]
fn fold_weighted_block<R: Weighted, V: Lanes>(
    recurrence: R,
    row: &mut PixelRow<'_, R::Channel>,
    samples: [&[i32]; 4],
    (absorption, depths): (Absorption, &[i32]),
    (dither, floor): (Dither, V),
) {
    let [extinction, red, green, blue] = samples;
    let pieces = zip(
        zip(extinction.chunks_exact(V::COUNT), red.chunks_exact(V::COUNT)),
        zip(green.chunks_exact(V::COUNT), blue.chunks_exact(V::COUNT)),
    );
    let mut at = 0;
    for (mut row, ((t, red), (green, blue))) in zip(row.vectors::<V>(), pieces) {
        let depths = (absorption, part(depths, at..at + V::COUNT));
        fold_weighted::<R, V>(recurrence, &mut row, [t, red, green, blue], depths, (dither, floor));
        at += V::COUNT;
    }
    if const { V::COUNT > 1 } && at < extinction.len() {
        let rest = at..extinction.len();
        let samples = four(samples, |run| part(run, rest.clone()));
        let depths = (absorption, part(depths, at..at + V::COUNT));
        fold_weighted::<R, V>(recurrence, &mut row.span(rest), samples, depths, (dither, floor));
    }
}

/// Folds a vector.
#[inline(always)]
fn fold_weighted<R: Weighted, V: Lanes>(
    recurrence: R,
    row: &mut PixelRow<'_, R::Channel>,
    [extinction, red, green, blue]: [&[i32]; 4],
    (absorption, depths): (Absorption, &[i32]),
    (dither, floor): (Dither, V),
) {
    let t = V::load(extinction, 0);
    let transparency: V = V::load_as(row.transparency, 0, R::Channel::bits);
    if t.all_zero() || transparency.all_zero() {
        return;
    }
    let sample = [t, V::load(red, 0), V::load(green, 0), V::load(blue, 0)];
    let factor = if const { V::COUNT == 1 } {
        absorption.factor(R::PHI, t)
    } else {
        absorption.factor_at(R::PHI, depths, 0)
    };
    let mut out = recurrence.over_factor(row.lanes::<V>(0), sample, (factor, absorption.shift), dither);
    out.transparency = out.transparency.at_least_then(floor, out.transparency);
    row.set_lanes(0, out);
}
