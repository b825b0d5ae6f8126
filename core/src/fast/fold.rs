//! Compositing in 16 bits, by the square root of an opacity.
//!
//! With the offsets dT and dC of a plane: `t = (T q + 2^15) >> 16; w = (t q + dT) >> 16; T -= w; C += (c w + dC) >> 16`.
//! `w <= t <= T`, and a sample never gives more than it takes: `C + T <= 65535`. A root of 0 leaves a pixel as it is, and so
//! does any sample where T is 0. Back to front T alike, and with the light A that is taken of 65535:
//! `C = C - ((C A + dC) >> 16) + ((c A + dC) >> 16)`, which lies between C and c.

use crate::composite::{Dither, Order, Pixel, PixelRow};
use crate::lanes::{Halves, each};

/// The offsets of a plane, both odd; or [`Offsets::NEAREST`].
#[derive(Clone, Copy, Debug)]
pub struct Offsets {
    transparency: u16,
    colour: u16,
}

impl Offsets {
    /// Those of a projection, which folds one value: to nearest.
    pub const NEAREST: Self = Self {
        transparency: 1 << 15,
        colour: 1 << 15,
    };

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
    fold_lanes::<O, u16>(&mut row, Given::One(colour), &[root], offsets, floor);
    let ([transparency], [red, green, blue]) = (transparency, [red, green, blue].map(|[c]| c));
    Pixel {
        colour: [red, green, blue],
        transparency,
    }
}

/// Colours of a row of samples, red, green and blue.
#[derive(Clone, Copy)]
pub(crate) enum Given<'a> {
    /// The same for all, 65535 is 1.
    One([u16; 3]),
    /// Of each.
    Rows([&'a [u16]; 3]),
}

impl<'a> Given<'a> {
    #[inline(always)]
    fn channels(self) -> [Channel<'a>; 3] {
        match self {
            Self::One(colour) => colour.map(Channel::One),
            Self::Rows(rows) => rows.map(Channel::Row),
        }
    }
}

/// One of them.
#[derive(Clone, Copy)]
enum Channel<'a> {
    One(u16),
    Row(&'a [u16]),
}

impl Channel<'_> {
    /// The first colours, if there are as many.
    #[inline(always)]
    fn first(self, len: usize) -> Option<Self> {
        match self {
            Self::One(_) => Some(self),
            Self::Row(row) => row.get(..len).map(Self::Row),
        }
    }

    #[inline(always)]
    fn at<H: Halves, const WHOLE: bool>(self, at: usize) -> H {
        match self {
            Self::One(colour) => H::splat_here(colour),
            Self::Row(row) => H::load::<WHOLE>(row, at),
        }
    }
}

/// Colour with a sample's light added.
#[inline(always)]
fn add<O: Order, H: Halves, const WHOLE: bool>(row: &mut [u16], colour: Channel<'_>, taken: H, offset: u16, at: usize) {
    let (old, given) = (
        H::load::<WHOLE>(row, at),
        colour.at::<H, WHOLE>(at).product_plus(taken, offset),
    );
    let kept = if O::BACK_TO_FRONT {
        old.minus(old.product_plus(taken, offset))
    } else {
        old
    };
    kept.plus(given).store::<WHOLE>(row, at);
}

/// Folds a sample into each pixel of a row. All rows equally long. Transparency below the floor becomes 0, front to back.
#[inline(always)]
pub(crate) fn fold_row<O: Order, H: Halves>(
    pixels: &mut PixelRow<'_, u16>,
    given: Given<'_>,
    roots: &[u16],
    offsets: Offsets,
    floor: u16,
) {
    if H::COUNT == 1 {
        fold_one_by_one::<O>(pixels, given, roots, offsets, floor);
    } else {
        fold_lanes::<O, H>(pixels, given, roots, offsets, floor);
    }
}

/// Pixels of one lane, one after the other: numbers of 16 bits in registers of 32, of which a function of its own has enough.
#[inline(never)]
fn fold_one_by_one<O: Order>(
    pixels: &mut PixelRow<'_, u16>,
    given: Given<'_>,
    roots: &[u16],
    offsets: Offsets,
    floor: u16,
) {
    let [red, green, blue] = &mut pixels.colour;
    let rows = roots.iter().zip(pixels.transparency.iter_mut());
    let rows = rows.zip(red.iter_mut()).zip(green.iter_mut()).zip(blue.iter_mut());
    let fold =
        |root, left: &mut u16, row: [&mut u16; 3], given| fold_one::<O>(left, row, (root, given), offsets, floor);
    match given {
        Given::Rows([r, g, b]) => {
            for ((((((root, left), red), green), blue), (r, g)), b) in rows.zip(r.iter().zip(g)).zip(b) {
                fold(*root, left, [red, green, blue], [*r, *g, *b]);
            }
        }
        Given::One(colour) => {
            for ((((root, left), red), green), blue) in rows {
                fold(*root, left, [red, green, blue], colour);
            }
        }
    }
}

/// Folds a sample into a pixel: [`fold_lanes`] of one.
#[inline(always)]
fn fold_one<O: Order>(
    left: &mut u16,
    row: [&mut u16; 3],
    (root, given): (u16, [u16; 3]),
    offsets: Offsets,
    floor: u16,
) {
    let (root, light) = (u32::from(root), u32::from(*left));
    if root == 0 {
        return;
    }
    let [transparency, colour] = [offsets.transparency, offsets.colour].map(u32::from);
    // At most 65535^2 + 65535.
    let of = |light: u32| (((light * root + (1 << 15)) >> 16) * root + transparency) >> 16;
    let w = of(light);
    let rest = (light - w) as u16;
    let (rest, taken) = if O::BACK_TO_FRONT {
        (rest, of(u32::from(u16::MAX)))
    } else {
        (if rest >= floor { rest } else { 0 }, w)
    };
    *left = rest;
    for (channel, given) in row.into_iter().zip(given) {
        let old = u32::from(*channel);
        let light = |of: u32| (of * taken + colour) >> 16;
        let kept = if O::BACK_TO_FRONT { old - light(old) } else { old };
        *channel = (kept + light(u32::from(given))) as u16;
    }
}

#[inline(always)]
fn fold_lanes<O: Order, H: Halves>(
    pixels: &mut PixelRow<'_, u16>,
    given: Given<'_>,
    roots: &[u16],
    offsets: Offsets,
    floor: u16,
) {
    let [r, g, b] = given.channels();
    let PixelRow {
        colour: [red, green, blue],
        transparency,
    } = pixels;
    let len = transparency.len();
    let (Some(red), Some(green), Some(blue)) = (red.get_mut(..len), green.get_mut(..len), blue.get_mut(..len)) else {
        return;
    };
    let (Some(roots), Some(r), Some(g), Some(b)) = (roots.get(..len), r.first(len), g.first(len), b.first(len)) else {
        return;
    };
    let floor = H::splat(floor);
    each!(H, transparency.len(), |at, WHOLE| {
        let q = H::load::<WHOLE>(roots, at);
        if !q.all_zero() {
            let light = H::load::<WHOLE>(transparency, at);
            let w = taken(light, q, offsets);
            let (left, taken) = if O::BACK_TO_FRONT {
                (light.minus(w), taken(H::splat(u16::MAX), q, offsets))
            } else {
                (light.minus(w).at_least_or_zero(floor), w)
            };
            left.store::<WHOLE>(transparency, at);
            add::<O, H, WHOLE>(red, r, taken, offsets.colour, at);
            add::<O, H, WHOLE>(green, g, taken, offsets.colour, at);
            add::<O, H, WHOLE>(blue, b, taken, offsets.colour, at);
        }
    });
}

/// Folds samples of a vector into as many pixels as a row has, at most the vector's.
#[inline(always)]
pub(crate) fn fold_at<O: Order, H: Halves>(
    pixels: &mut PixelRow<'_, u16>,
    [r, g, b]: [H; 3],
    q: H,
    offsets: Offsets,
    floor: u16,
) {
    let PixelRow {
        colour: [red, green, blue],
        transparency,
    } = pixels;
    let light = H::load::<false>(transparency, 0);
    let w = taken(light, q, offsets);
    let (left, taken) = if O::BACK_TO_FRONT {
        (light.minus(w), taken(H::splat(u16::MAX), q, offsets))
    } else {
        (light.minus(w).at_least_or_zero(H::splat(floor)), w)
    };
    left.store::<false>(transparency, 0);
    for (row, colour) in [(red, r), (green, g), (blue, b)] {
        let old = H::load::<false>(row, 0);
        let kept = if O::BACK_TO_FRONT {
            old.minus(old.product_plus(taken, offsets.colour))
        } else {
            old
        };
        kept.plus(colour.product_plus(taken, offsets.colour))
            .store::<false>(row, 0);
    }
}
