//! Display: the finished picture for embedded-graphics (feature `embedded-graphics`), a pixel at a time and in no memory of its
//! own.
//!
//! A [`Picture`] is an [`ImageDrawable`]: pixels are mixed from the base plane while the display takes them, so that a
//! device needs the base-plane image and no frame buffer. Where a bus is fed from memory (DMA), [`Picture::strip`] makes
//! some rows at a time.
//!
//! | value | format |
//! |---|---|
//! | base-plane pixel | the channel's |
//! | background | 1.15 |
//! | colour | 8 bits a channel by [`in_front_of`], then to the display's bits, each to the nearest (`From<Rgb888>`) |
//!
//! State: none.

use core::marker::PhantomData;

use embedded_graphics_core::draw_target::DrawTarget;
use embedded_graphics_core::geometry::{OriginDimensions, Point, Size};
use embedded_graphics_core::image::ImageDrawable;
use embedded_graphics_core::pixelcolor::{PixelColor, Rgb888};
use embedded_graphics_core::primitives::Rectangle;

use crate::composite::{ChannelFormat, Pixel};
use crate::format::Intensity;
use crate::plan::Plan;
use crate::warp::{Warp, in_front_of};

/// A finished frame as a display of the colour type `C` shows it. `B` gives the pixels of the base plane by (u, v), clear
/// outside it: `|u, v| stream.pixel(u, v)`, or [`base_pixel`](crate::stream::base_pixel) of an image kept elsewhere.
///
/// ```
/// use embedded_graphics::image::Image;
/// use embedded_graphics::mock_display::MockDisplay;
/// use embedded_graphics::pixelcolor::Rgb565;
/// use embedded_graphics::prelude::*;
/// use slicecast::composite::{Pixel, Unorm16};
/// use slicecast::display::Picture;
/// use slicecast::format::Intensity;
/// use slicecast::warp::Warp;
///
/// // A base plane that holds nothing shows the background.
/// let white = [Intensity::ONE; 3];
/// let picture = Picture::new(Warp::IDENTITY, [8, 4], white, |_, _| Pixel::<Unorm16>::clear());
/// let mut display = MockDisplay::<Rgb565>::new();
/// Image::new(&picture, Point::new(3, 5)).draw(&mut display)?;
/// assert_eq!(display.get_pixel(Point::new(10, 8)), Some(Rgb565::WHITE));
/// # Ok::<(), core::convert::Infallible>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Picture<B, C> {
    warp: Warp,
    size: [u32; 2],
    background: [Intensity; 3],
    base: B,
    colour: PhantomData<C>,
}

impl<B, C> Picture<B, C> {
    /// The viewer's picture: so many pixels across and down, each where the warp looks, in front of a background.
    pub const fn new(warp: Warp, size: [u32; 2], background: [Intensity; 3], base: B) -> Self {
        Self {
            warp,
            size,
            background,
            base,
            colour: PhantomData,
        }
    }

    /// The base plane itself, all phases, pixel by pixel.
    pub const fn of_base(plan: &Plan, background: [Intensity; 3], base: B) -> Self {
        let ([width, height], rays) = (plan.base(), plan.sampling().rays_per_voxel);
        // At most 16384 columns and rows, 8 rays each.
        Self::new(Warp::IDENTITY, [width * rays, height * rays], background, base)
    }
}

impl<B, F, C> Picture<B, C>
where
    B: Fn(i64, i64) -> Pixel<F>,
    F: ChannelFormat,
    C: PixelColor + From<Rgb888>,
{
    /// The colour of a pixel.
    pub fn colour(&self, x: u32, y: u32) -> C {
        let [red, green, blue] = in_front_of(self.warp.pixel(x, y, &self.base), self.background);
        Rgb888::new(red, green, blue).into()
    }

    /// Fills a strip with whole rows from the row `first` on, as many as fit in and the picture has left. Returns where they
    /// belong: of no size where there are none. What of the strip is beyond them stays as it is.
    pub fn strip(&self, first: u32, strip: &mut [C]) -> Rectangle {
        let [width, height] = self.size;
        let mut rows = 0;
        for (y, row) in (first..height).zip(strip.chunks_exact_mut((width as usize).max(1))) {
            for (x, out) in (0..width).zip(row) {
                *out = self.colour(x, y);
            }
            rows += 1;
        }
        Rectangle::new(Point::new(0, first as i32), Size::new(width, rows))
    }
}

impl<B, C> OriginDimensions for Picture<B, C> {
    fn size(&self) -> Size {
        let [width, height] = self.size;
        Size::new(width, height)
    }
}

impl<B, F, C> ImageDrawable for Picture<B, C>
where
    B: Fn(i64, i64) -> Pixel<F>,
    F: ChannelFormat,
    C: PixelColor + From<Rgb888>,
{
    type Color = C;

    fn draw<D: DrawTarget<Color = C>>(&self, target: &mut D) -> Result<(), D::Error> {
        self.draw_sub_image(target, &Rectangle::new(Point::zero(), self.size()))
    }

    /// Nothing is drawn of an area that is not inside the picture, as embedded-graphics' own images do.
    fn draw_sub_image<D: DrawTarget<Color = C>>(&self, target: &mut D, area: &Rectangle) -> Result<(), D::Error> {
        let [width, height] = self.size;
        let Size {
            width: across,
            height: down,
        } = area.size;
        let ends = |start: i32, len: u32, side: u32| {
            let start = u32::try_from(start).ok()?;
            let end = start.checked_add(len).filter(|end| *end <= side)?;
            Some(start..end)
        };
        let (Some(columns), Some(rows)) = (
            ends(area.top_left.x, across, width),
            ends(area.top_left.y, down, height),
        ) else {
            return Ok(());
        };
        let row = |y| columns.clone().map(move |x| self.colour(x, y));
        target.fill_contiguous(&Rectangle::new(Point::zero(), area.size), rows.flat_map(row))
    }
}
