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

use super::{Channel as _, Dither, Dithered, Pixel, PixelRow, Recurrence, Telescoping31};
use crate::extinction::Absorption;
use crate::lanes::{Lanes, Wide as _, places};

/// A pixel that takes samples of colour and extinction.
pub trait Weighted: Recurrence {
    /// Pixels with one more sample behind them: extinction, and red, green and blue times extinction, with their factor and its
    /// n. This function is the definition; it leaves out the floor.
    fn over_factor<V: Lanes>(self, pixel: Pixel<V>, sample: [V; 4], factor: (V, u32), dither: Dither) -> Pixel<V>;
}

impl Weighted for Telescoping31 {
    /// `h = (T G) >> 31; w = (s_t h) >> (n - 3); T -= w; C_k += (s_k h) >> (n - 3)`.
    #[inline(always)]
    fn over_factor<V: Lanes>(self, pixel: Pixel<V>, sample: [V; 4], (factor, n): (V, u32), _: Dither) -> Pixel<V> {
        let h = pixel.transparency.product31(factor);
        let ([t, red, green, blue], [r, g, b]) = (sample, pixel.colour);
        Pixel {
            colour: [
                r.wrapping_add(red.product(h).shr(n - 3).narrow()),
                g.wrapping_add(green.product(h).shr(n - 3).narrow()),
                b.wrapping_add(blue.product(h).shr(n - 3).narrow()),
            ],
            transparency: pixel.transparency.wrapping_sub(t.product(h).shr(n - 3).narrow()),
        }
    }
}

impl Weighted for Dithered {
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

/// `sum >> (n + 13)`. With 12 fraction bits n is at least 26, and a single lane looks at the upper half alone.
#[inline(always)]
fn taken<V: Lanes>(sum: V::Wide, n: u32) -> V {
    if V::COUNT == 1 {
        sum.shr(32).narrow().shr_unsigned(n - 19)
    } else {
        sum.shr(n + 13).narrow()
    }
}

/// Folds a row of samples into its pixels: rows of extinction, red, green and blue, as long as each other. Vectors without
/// extinction or without light are left out, which changes nothing.
#[inline(always)]
pub(crate) fn fold_weighted_row<R: Weighted, V: Lanes>(
    recurrence: R,
    row: &mut PixelRow<'_, R::Channel>,
    [extinction, red, green, blue]: [&[i32]; 4],
    absorption: Absorption,
    dither: Dither,
    floor: R::Channel,
) {
    let floor = V::splat(floor.bits() as i32);
    for at in places::<V>(extinction.len()) {
        let t = V::load(extinction, at);
        if t.all_zero() {
            continue;
        }
        let pixel = row.lanes::<V>(at);
        if pixel.transparency.all_zero() {
            continue;
        }
        let sample = [t, V::load(red, at), V::load(green, at), V::load(blue, at)];
        let factor = (absorption.factor(t), absorption.shift);
        let mut out = recurrence.over_factor(pixel, sample, factor, dither);
        out.transparency = out.transparency.at_least_then(floor, out.transparency);
        row.set_lanes(at, out);
    }
}
