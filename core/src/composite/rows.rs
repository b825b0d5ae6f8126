//! Rows of pixels, and how a row of samples is folded into them.

use core::iter::zip;
use core::ops::Range;

use super::{Channel, Dither, Order, Pixel, Recurrence};
use crate::lanes::Lanes;
use crate::rows::{part_mut, take, three};

/// The four planes of a row of pixels, or of a part of it.
#[derive(Debug)]
pub struct PixelRow<'a, C> {
    /// Red, green, blue.
    pub colour: [&'a mut [C]; 3],
    /// Transparency.
    pub transparency: &'a mut [C],
}

impl<'a, C> PixelRow<'a, C> {
    /// Some columns of the four runs that a row of the image consists of (`width` pixels each).
    #[inline]
    pub fn of_runs(row: &'a mut [C], width: usize, columns: Range<usize>) -> Self {
        let mut rest = row;
        let mut run = || {
            let run = take(&mut rest, width);
            run.get_mut(columns.clone()).unwrap_or(&mut [])
        };
        Self {
            colour: [run(), run(), run()],
            transparency: run(),
        }
    }

    /// The bits of the pixels at `at ..`.
    #[inline(always)]
    pub(super) fn lanes<V: Lanes>(&self, at: usize) -> Pixel<V>
    where
        C: Channel,
    {
        let [red, green, blue] = &self.colour;
        Pixel {
            colour: [
                V::load_as(red, at, C::bits),
                V::load_as(green, at, C::bits),
                V::load_as(blue, at, C::bits),
            ],
            transparency: V::load_as(self.transparency, at, C::bits),
        }
    }

    /// Writes them.
    #[inline(always)]
    pub(super) fn set_lanes<V: Lanes>(&mut self, at: usize, pixel: Pixel<V>)
    where
        C: Channel,
    {
        let ([red, green, blue], [r, g, b]) = (&mut self.colour, pixel.colour);
        r.store_as(red, at, C::from_bits);
        g.store_as(green, at, C::from_bits);
        b.store_as(blue, at, C::from_bits);
        pixel.transparency.store_as(self.transparency, at, C::from_bits);
    }

    /// The pixels by whole vectors, whose lengths the compiler knows.
    #[inline(always)]
    pub(super) fn vectors<V: Lanes>(&mut self) -> impl Iterator<Item = PixelRow<'_, C>> {
        let Self {
            colour: [red, green, blue],
            transparency,
        } = self;
        let colour = zip(
            red.chunks_exact_mut(V::COUNT),
            zip(green.chunks_exact_mut(V::COUNT), blue.chunks_exact_mut(V::COUNT)),
        );
        zip(colour, transparency.chunks_exact_mut(V::COUNT)).map(|((red, (green, blue)), transparency)| PixelRow {
            colour: [red, green, blue],
            transparency,
        })
    }

    /// Some of the pixels.
    #[inline]
    pub fn span(&mut self, columns: Range<usize>) -> PixelRow<'_, C> {
        PixelRow {
            colour: three(self.colour.each_mut(), |c| part_mut(c, columns.clone())),
            transparency: self.transparency.get_mut(columns).unwrap_or(&mut []),
        }
    }
}

/// The colours of a row of samples, [`Recurrence::colour_bits`] each: rows of red, green and blue, or one colour for all.
#[derive(Debug)]
pub struct Colours<'a, W> {
    /// The colour of all samples; the rows then need not hold it.
    pub one: Option<[u32; 3]>,
    /// Red, green and blue of each sample.
    pub rows: [&'a mut [W]; 3],
}

impl<W> Colours<'_, W> {
    /// Red, green and blue of each sample.
    #[inline(always)]
    pub fn rows(&self) -> [&[W]; 3] {
        let [red, green, blue] = &self.rows;
        [red, green, blue]
    }
}

/// Where a kernel takes colours from.
trait Given: Copy {
    /// The first of them, if there are as many.
    fn first(self, len: usize) -> Option<Self>;
    /// Those of the samples at `at ..`.
    fn colours<V: Lanes>(self, at: usize) -> [V; 3];
}

impl Given for [&[i32]; 3] {
    #[inline(always)]
    fn first(self, len: usize) -> Option<Self> {
        let [red, green, blue] = self;
        Some([red.get(..len)?, green.get(..len)?, blue.get(..len)?])
    }
    #[inline(always)]
    fn colours<V: Lanes>(self, at: usize) -> [V; 3] {
        let [red, green, blue] = self;
        [V::load(red, at), V::load(green, at), V::load(blue, at)]
    }
}

impl Given for [u32; 3] {
    #[inline(always)]
    fn first(self, _: usize) -> Option<Self> {
        Some(self)
    }
    #[inline(always)]
    fn colours<V: Lanes>(self, _: usize) -> [V; 3] {
        let [red, green, blue] = self;
        [V::splat(red as i32), V::splat(green as i32), V::splat(blue as i32)]
    }
}

/// Folds one sample into each pixel of a row. `opacity`: bits of 1.31. All rows equally long.
#[inline(always)]
pub fn fold_row<R: Recurrence, O: Order, V: Lanes>(
    recurrence: R,
    row: &mut PixelRow<'_, R::Channel>,
    colour: [&[i32]; 3],
    opacity: &[i32],
    dither: Dither,
    floor: R::Channel,
) {
    fold_row_of::<R, O, V, _, true>(recurrence, row, colour, opacity, dither, floor);
}

/// [`fold_row`] of one colour, for a row in which not all samples need be visible: lanes whose opacities are all 0 are left
/// out, which changes nothing.
#[inline(always)]
pub fn fold_visible_row<R: Recurrence, O: Order, V: Lanes>(
    recurrence: R,
    row: &mut PixelRow<'_, R::Channel>,
    colour: [u32; 3],
    opacity: &[i32],
    dither: Dither,
    floor: R::Channel,
) {
    fold_row_of::<R, O, V, _, false>(recurrence, row, colour, opacity, dither, floor);
}

#[inline(always)]
fn fold_row_of<R: Recurrence, O: Order, V: Lanes, K: Given, const ALL: bool>(
    recurrence: R,
    row: &mut PixelRow<'_, R::Channel>,
    colour: K,
    opacity: &[i32],
    dither: Dither,
    floor: R::Channel,
) {
    let floor = V::splat(floor.bits() as i32);
    let len = opacity.len();
    let [red, green, blue] = &mut row.colour;
    let (Some(red), Some(green), Some(blue)) = (red.get_mut(..len), green.get_mut(..len), blue.get_mut(..len)) else {
        return;
    };
    let (Some(colour), Some(transparency)) = (colour.first(len), row.transparency.get_mut(..len)) else {
        return;
    };
    let mut row = PixelRow {
        colour: [red, green, blue],
        transparency,
    };
    // Two vectors at a time, as far as they go; one lane stays one.
    let mut at = 0;
    while V::COUNT > 1 && at + V::COUNT < len {
        if ALL || !(V::load(opacity, at) | V::load(opacity, at + V::COUNT)).all_zero() {
            let second = at + V::COUNT;
            let samples = [
                (colour.colours(at), V::load(opacity, at)),
                (colour.colours(second), V::load(opacity, second)),
            ];
            O::fold_two(recurrence, &mut row, at, samples, dither, floor);
        }
        at += 2 * V::COUNT;
    }
    while at < len {
        if ALL || !V::load(opacity, at).all_zero() {
            let pixel = row.lanes(at);
            let folded = O::fold(
                recurrence,
                pixel,
                colour.colours(at),
                V::load(opacity, at),
                dither,
                floor,
            );
            row.set_lanes(at, folded);
        }
        at += V::COUNT;
    }
}

/// Folds a sample, colour and opacity, into each pixel of one vector of a row.
#[inline(always)]
pub(crate) fn fold_at<R: Recurrence, O: Order, V: Lanes>(
    recurrence: R,
    row: &mut PixelRow<'_, R::Channel>,
    at: usize,
    (colour, opacity): ([V; 3], V),
    dither: Dither,
    floor: V,
) {
    let pixel = row.lanes(at);
    row.set_lanes(at, O::fold(recurrence, pixel, colour, opacity, dither, floor));
}
