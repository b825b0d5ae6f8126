//! Pictures on displays: every way to draw one gives the pixels of the warp's definition, each once.

use embedded_graphics::framebuffer::{Framebuffer, buffer_size};
use embedded_graphics::image::{Image, ImageDrawableExt as _};
use embedded_graphics::mock_display::MockDisplay;
use embedded_graphics::pixelcolor::raw::BigEndian;
use embedded_graphics::pixelcolor::{Rgb565, Rgb888};
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::Rectangle;
use slicecast::classify::{Linear, PointTable, Sqrt16, entry};
use slicecast::composite::{ChannelFormat, FrontToBack, Pixel, Unorm16};
use slicecast::display::Picture;
use slicecast::format::{Direction, Intensity, Step};
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::plane::Composite;
use slicecast::precision::Compact;
use slicecast::shade::Unlit;
use slicecast::slice::RowRange;
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::table::ENTRIES;
use slicecast::view::View;
use slicecast::warp::{Warp, in_front_of};

/// A background whose channels differ, 1.15.
const BACKGROUND: [u16; 3] = [3000, 17_000, 32_768];

fn background() -> [Intensity; 3] {
    BACKGROUND.map(Intensity::from_bits)
}

/// A base plane of 40 x 30 pixels without a pattern, clear outside.
fn base<C: ChannelFormat>(u: i64, v: i64) -> Pixel<C> {
    if !(0..40).contains(&u) || !(0..30).contains(&v) {
        return Pixel::clear();
    }
    let mut state = (u * 30 + v + 1) as u64;
    let mut share = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % 256
    };
    // Colours that what is not transparent can have.
    let transparency = share();
    let mut channel = |share_of: u64| C::from_bits((u64::from(C::ONE.bits()) * share_of / 255) as u32);
    let colour = [0; 3].map(|_| share() * (255 - transparency) / 255).map(&mut channel);
    Pixel {
        colour,
        transparency: channel(transparency),
    }
}

/// A quarter turn and a bit, with a margin of background.
fn turned() -> Warp {
    Warp {
        origin: [Step::from_num(-3.3), Step::from_num(28.7)],
        right: [Step::from_num(0.31), Step::from_num(-0.52)],
        down: [Step::from_num(0.55), Step::from_num(0.27)],
    }
}

/// The definition.
fn expected<C: ChannelFormat>(warp: Warp, x: u32, y: u32) -> Rgb888 {
    let [red, green, blue] = in_front_of(warp.pixel(x, y, base::<C>), background());
    Rgb888::new(red, green, blue)
}

/// The mock display refuses a pixel that is drawn twice or outside.
fn whole_pictures_are_the_warp<F: ChannelFormat, C>()
where
    C: RgbColor + From<Rgb888> + core::fmt::Debug,
{
    let size = [61, 57];
    let picture = Picture::new(turned(), size, background(), base::<F>);
    let mut display = MockDisplay::<C>::new();
    Image::new(&picture, Point::new(2, 5)).draw(&mut display).unwrap();
    let mut shown = 0;
    for point in display.bounding_box().points() {
        let inside = Rectangle::new(Point::new(2, 5), Size::new(61, 57)).contains(point);
        let here = point - Point::new(2, 5);
        let colour = inside.then(|| C::from(expected::<F>(turned(), here.x as u32, here.y as u32)));
        assert_eq!(display.get_pixel(point), colour, "{point}");
        shown += u32::from(inside);
    }
    assert_eq!(shown, size[0] * size[1]);
}

#[test]
fn pictures_are_the_warp_pixel_by_pixel() {
    whole_pictures_are_the_warp::<Unorm16, Rgb565>();
    whole_pictures_are_the_warp::<Unorm16, Rgb888>();
    whole_pictures_are_the_warp::<u16, Rgb565>();
    whole_pictures_are_the_warp::<u32, Rgb888>();
}

/// 8 bits to 5 and 6, to the nearest: every byte of every channel.
#[test]
fn colours_go_to_the_nearest_of_the_display() {
    for byte in 0..=255u8 {
        let opaque = |_: i64, _: i64| Pixel {
            colour: [Unorm16(u16::from(byte) * 257); 3],
            transparency: Unorm16(0),
        };
        let colour: Rgb565 = Picture::new(Warp::IDENTITY, [1, 1], background(), opaque).colour(0, 0);
        let nearest = |most: u32| ((u32::from(byte) * most * 2 + 255) / 510) as u8;
        assert_eq!(
            (colour.r(), colour.g(), colour.b()),
            (nearest(31), nearest(63), nearest(31)),
            "{byte}"
        );
    }
}

/// Strips of a display of 240 x 240, of 7 rows, so that the last is not full, each sent as one area.
#[test]
fn strips_make_the_whole_picture() {
    type Screen =
        Framebuffer<Rgb565, <Rgb565 as PixelColor>::Raw, BigEndian, 240, 240, { buffer_size::<Rgb565>(240, 240) }>;
    let warp = Warp {
        right: [Step::from_num(0.11), Step::from_num(-0.13)],
        down: [Step::from_num(0.14), Step::from_num(0.07)],
        ..turned()
    };
    let picture = Picture::new(warp, [240, 240], background(), base::<Unorm16>);
    let mut whole = Screen::new();
    picture.draw(&mut whole).unwrap();

    let mut display = Screen::new();
    let mut strip = [Rgb565::BLACK; 7 * 240 + 100];
    let (mut first, mut areas) = (0, 0);
    loop {
        let area = picture.strip(first, &mut strip);
        if area.is_zero_sized() {
            break;
        }
        let filled = (area.size.width * area.size.height) as usize;
        display.fill_contiguous(&area, strip[..filled].iter().copied()).unwrap();
        first += area.size.height;
        areas += 1;
    }
    assert_eq!((first, areas), (240, 35));
    assert!(display.data() == whole.data());
    // More than one colour, or nothing has been shown.
    assert!(whole.data().chunks(2).any(|pixel| pixel != &whole.data()[..2]));
    // Behind the rows that it holds, a strip is left alone.
    assert_eq!(strip[7 * 240..], [Rgb565::BLACK; 100]);
    let mut short = [Rgb565::BLACK; 239];
    assert!(picture.strip(0, &mut short).is_zero_sized());
    assert!(picture.strip(240, &mut strip).is_zero_sized());
    assert!(picture.strip(u32::MAX, &mut strip).is_zero_sized());
}

#[test]
fn parts_are_cut_out_and_parts_beyond_are_not_drawn() {
    let picture = Picture::<_, Rgb888>::new(turned(), [20, 10], background(), base::<u16>);
    let part = picture.sub_image(&Rectangle::new(Point::new(4, 3), Size::new(5, 6)));
    let mut display = MockDisplay::new();
    Image::new(&part, Point::new(1, 1)).draw(&mut display).unwrap();
    for point in Rectangle::new(Point::zero(), Size::new(5, 6)).points() {
        let colour = expected::<u16>(turned(), point.x as u32 + 4, point.y as u32 + 3);
        assert_eq!(display.get_pixel(point + Point::new(1, 1)), Some(colour), "{point}");
    }
    assert_eq!(display.affected_area().size, Size::new(5, 6));

    let mut untouched = MockDisplay::new();
    for (x, y, width, height) in [
        (-1, 0, 2, 2),
        (0, -1, 2, 2),
        (16, 0, 5, 1),
        (0, 9, 1, 2),
        (5, 5, u32::MAX, 1),
        (3, 3, 0, 4),
    ] {
        let area = Rectangle::new(Point::new(x, y), Size::new(width, height));
        picture.draw_sub_image(&mut untouched, &area).unwrap();
    }
    untouched.assert_eq(&MockDisplay::new());
}

/// The base plane of a streamed frame of four rays per voxel, pixel by pixel.
#[test]
fn the_base_plane_is_a_picture_too() {
    type Pipe<'t> = Composite<Compact, PointTable<'t, Sqrt16, Linear>, Unlit, FrontToBack>;
    let mut entries = [0; ENTRIES];
    for (code, e) in entries.iter_mut().enumerate().skip(400) {
        *e = entry([(code >> 4) as u8, 90, 255 - (code >> 4) as u8], 0x60);
    }
    let low = [0; ENTRIES];
    let pipeline = Pipe::new(Compact, PointTable::new(&entries, &low), Unlit);
    let direction = [3i64, 1, 5].map(|c| Direction::from_bits(c << 55));
    let sampling = Sampling {
        planes_per_voxel: 1,
        rays_per_voxel: 2,
    };
    let plan = Plan::whole(View::new(direction).unwrap(), [12, 10, 8], Spacing::CUBIC, sampling).unwrap();
    let needs = Needs::of::<Pipe>(&plan);
    let (mut slices, mut ranges) = (vec![0; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let (mut scratch, mut image) = (vec![0; needs.scratch], vec![Unorm16::default(); needs.image]);
    let memory = Memory {
        slices: &mut slices,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image: &mut image,
    };
    let mut stream = Stream::new(plan, pipeline, memory).unwrap();
    while let Some(number) = stream.wanted() {
        let slice: Vec<u16> = (0..120u32).map(|at| ((at * 37 + number * 911) % 4096) as u16).collect();
        stream.push(&slice).unwrap();
    }
    let picture = Picture::of_base(&plan, background(), |u, v| stream.pixel(u, v));
    let [width, height] = plan.base().map(|side| side * 2);
    assert_eq!(picture.size(), Size::new(width, height));
    let mut display = MockDisplay::<Rgb888>::new();
    picture.draw(&mut display).unwrap();
    for point in picture.bounding_box().points() {
        let [red, green, blue] = in_front_of(stream.pixel(point.x.into(), point.y.into()), background());
        assert_eq!(display.get_pixel(point), Some(Rgb888::new(red, green, blue)), "{point}");
    }
    let first = display.get_pixel(Point::new(20, 12));
    assert!(
        picture
            .bounding_box()
            .points()
            .any(|point| display.get_pixel(point) != first)
    );
}
