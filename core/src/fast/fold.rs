//! Compositing in 16 bits, by the square root of an opacity.
//!
//! With the offsets dT and dC of a plane: `t = (T q + 2^15) >> 16; w = (t q + dT) >> 16; T -= w; C += (c w + dC) >> 16`.
//! `w <= t <= T`, and a sample never gives more than it takes: `C + T <= 65535`. A root of 0 leaves a pixel as it is, and so
//! does any sample where T is 0. Back to front T alike, and with the light A that is taken of 65535:
//! `C = C - ((C A + dC) >> 16) + ((c A + dC) >> 16)`, which lies between C and c.

use crate::composite::{Dither, Order, Pixel, PixelRow};
use crate::lanes::{Halves, places_of};

/// The offsets of a plane, both odd.
#[derive(Clone, Copy, Debug)]
pub struct Offsets {
    transparency: u16,
    colour: u16,
}

impl Offsets {
    /// Those of a plane.
    pub const fn of_plane(k: u32) -> Self {
        let Dither { transparency, colour } = Dither::of_plane(k);
        Self {
            transparency: (2 * transparency + 1) as u16,
            colour: (2 * colour + 1) as u16,
        }
    }
}

/// What a sample takes of this much light.
#[inline(always)]
pub fn taken<H: Halves>(light: H, root: H, offsets: Offsets) -> H {
    let half = light.product_high(root).plus(light.product_low(root).shr(15));
    half.product_plus(root, offsets.transparency)
}

/// A pixel with one more sample: behind it, or in front of it from back to front. This function is the definition: a row of one.
#[inline]
pub fn folded<O: Order>(pixel: Pixel<u16>, colour: [u16; 3], root: u16, offsets: Offsets, floor: u16) -> Pixel<u16> {
    let [mut red, mut green, mut blue] = pixel.colour.map(|c| [c]);
    let mut transparency = [pixel.transparency];
    let mut row = PixelRow {
        colour: [&mut red, &mut green, &mut blue],
        transparency: &mut transparency,
    };
    fold_row::<O, u16>(&mut row, colour.map(Given::One), &[root], offsets, floor);
    let ([transparency], [red, green, blue]) = (transparency, [red, green, blue].map(|[c]| c));
    Pixel {
        colour: [red, green, blue],
        transparency,
    }
}

/// A sample's colours, of a row or one for all.
#[derive(Clone, Copy)]
pub(crate) enum Given<'a> {
    /// The same for all, 65535 is 1.
    One(u16),
    /// Of each.
    Row(&'a [u16]),
}

impl Given<'_> {
    #[inline(always)]
    fn at<H: Halves>(self, at: usize) -> H {
        match self {
            Self::One(colour) => H::splat(colour),
            Self::Row(row) => H::load(row, at),
        }
    }
}

/// Colour with a sample's light added.
#[inline(always)]
fn add<O: Order, H: Halves>(row: &mut [u16], colour: Given<'_>, taken: H, offset: u16, at: usize) {
    let (old, given) = (H::load(row, at), colour.at::<H>(at).product_plus(taken, offset));
    let kept = if O::BACK_TO_FRONT { old.minus(old.product_plus(taken, offset)) } else { old };
    kept.plus(given).store(row, at);
}

/// Folds a sample into each pixel of a row. All rows equally long. Transparency below the floor becomes 0, front to back.
#[inline(always)]
pub(crate) fn fold_row<O: Order, H: Halves>(
    pixels: &mut PixelRow<'_, u16>,
    [r, g, b]: [Given<'_>; 3],
    roots: &[u16],
    offsets: Offsets,
    floor: u16,
) {
    let PixelRow {
        colour: [red, green, blue],
        transparency,
    } = pixels;
    let floor = H::splat(floor);
    for at in places_of::<H>(transparency.len()) {
        let q = H::load(roots, at);
        if q.all_zero() {
            continue;
        }
        let light = H::load(transparency, at);
        let w = taken(light, q, offsets);
        let left = light.minus(w);
        let left = if O::BACK_TO_FRONT { left } else { left.at_least_or_zero(floor) };
        left.store(transparency, at);
        let taken = if O::BACK_TO_FRONT { self::taken(H::splat(u16::MAX), q, offsets) } else { w };
        add::<O, H>(red, r, taken, offsets.colour, at);
        add::<O, H>(green, g, taken, offsets.colour, at);
        add::<O, H>(blue, b, taken, offsets.colour, at);
    }
}
