//! The viewer's picture: the final warp of core, a tile of the picture at a time.
//!
//! The base plane keeps its phases and channels apart. What a tile looks at is first put side by side in a small copy, clear
//! where nothing exists; a tile that sees only clear pixels is background. Then a row of picture pixels collects the
//! corners of its mixtures, four channels a pixel, and core's row kernels do the rest in lanes.
//!
//! Tiles are as large as the copy allows: where the picture is much smaller than the base plane, a tile is one pixel and
//! its copy the four that it mixes. No memory grows with the base plane.

use std::marker::PhantomData;
use std::ops::Range;

use rayon::prelude::*;
use slicecast::composite::{Channel as _, ChannelFormat, Pixel, Recurrence};
use slicecast::format::Intensity;
use slicecast::lanes::{Kernel, Lanes};
use slicecast::plan::Plan;
use slicecast::plane::ChannelOf;
use slicecast::precision::Precision;
use slicecast::warp::{Point, Warp, in_front_of, in_front_of_row, mix_row};

use crate::camera::Picture;
use crate::image::{BaseImage, Rgb, background};
use crate::simd::{OverLanes, Simd, with_lanes};
use crate::with_pixel;
use slicecast_scene::PrecisionName;

/// Picture pixels across the largest tile.
const ACROSS: usize = 64;

/// Picture pixels down the largest tile.
const DOWN: usize = 32;

/// Base-plane pixels of the largest copy: it stays in the second-level cache.
const COPY_MAX: i128 = 8192;

/// The picture of a base-plane image whose phases are interleaved, of this precision, in front of a background.
pub fn of_base(base: &BaseImage, precision: PrecisionName, picture: &Picture, behind: [f64; 3], simd: Simd) -> Rgb {
    let shown = Shown::new(picture, behind, simd);
    with_pixel!(precision, p => shown.picture(&Interleaved::of(p, base)))
}

/// What a picture shows of a base plane.
pub struct Shown<'a> {
    picture: &'a Picture,
    background: [Intensity; 3],
    simd: Simd,
}

impl<'a> Shown<'a> {
    /// In front of a background, mixed with these vectors.
    pub fn new(picture: &'a Picture, behind: [f64; 3], simd: Simd) -> Self {
        Self {
            picture,
            background: background(behind),
            simd,
        }
    }

    /// The picture of a base plane, compiled once per channel format.
    pub(crate) fn picture<C: ChannelFormat>(&self, base: &dyn BasePixels<C>) -> Rgb {
        let Picture { size, warp, .. } = *self.picture;
        let (background, simd) = (self.background, self.simd);
        let shape = Shape::of(&warp);
        let [width, height] = size.map(|side| side as usize);
        let [_, down] = shape.tile;
        let mut bytes = vec![0; 3 * width * height];
        bytes
            .par_chunks_mut((3 * width * down).max(1))
            .enumerate()
            .for_each_init(
                || Memory::new(&shape, background),
                |memory, (band, out)| {
                    let band = Band {
                        base,
                        warp: &warp,
                        shape: &shape,
                        clear: in_front_of(Pixel::<C>::clear(), background),
                        first: (band * down) as u32,
                        width,
                        out,
                        memory,
                    };
                    with_lanes(simd, band);
                },
            );
        Rgb { size, bytes }
    }
}

/// How large tiles are, and what one looks at.
struct Shape {
    /// Picture pixels across and down.
    tile: [usize; 2],
    /// Base-plane pixels across and down that any tile looks at, at most.
    copy: [usize; 2],
    /// From the place that a tile's first pixel looks at back to the least that any looks at, s31.32.
    back: [i64; 2],
}

impl Shape {
    /// The largest tiles whose copies are not too large.
    fn of(warp: &Warp) -> Self {
        let mut tile = [ACROSS, DOWN];
        loop {
            let reach = |axis: usize, sign: i128| {
                let [right, down] =
                    [warp.right, warp.down].map(|step| (sign * i128::from(step[axis].to_bits())).max(0));
                right * (tile[0] - 1) as i128 + down * (tile[1] - 1) as i128
            };
            let back = [0, 1].map(|axis| reach(axis, -1));
            // The first pixel, one more where the fractions of place and reach add up to one, and the next neighbour.
            let copy = [0, 1].map(|axis| ((back[axis] + reach(axis, 1)) >> 32) + 3);
            if copy[0] * copy[1] <= COPY_MAX {
                return Self {
                    tile,
                    copy: copy.map(|side| side as usize),
                    back: back.map(|back| back as i64),
                };
            }
            // Ends at one pixel, which has no reach.
            let longer = usize::from(tile[1] > tile[0]);
            tile[longer] = tile[longer].div_ceil(2);
        }
    }
}

/// Where the pixels of a base plane come from.
pub(crate) trait BasePixels<C>: Sync {
    /// Copies the pixels from `first` on, in rows of `width`, clear ones where none exist; `phase` is room for a row of one
    /// phase. Whether any of them is not clear; if not, the copy may hold anything.
    fn copy(&self, first: [i64; 2], width: usize, copy: &mut [[C; 4]], phase: &mut [[C; 4]]) -> bool;
}

/// A pixel's red, green, blue and transparency, side by side.
#[inline(always)]
pub(crate) fn channels<C>(pixel: Pixel<C>) -> [C; 4] {
    let [red, green, blue] = pixel.colour;
    [red, green, blue, pixel.transparency]
}

/// All that the picture asks of a pipeline.
pub(crate) trait Pixels<E, C>: Sync {
    /// Pixels of a row of one phase, from a column on. The bits in which any of them differs from a clear one.
    fn pixels(&self, row: &[E], column: usize, out: &mut [[C; 4]]) -> u32;
}

/// A base-plane image as the pipeline left it.
pub(crate) struct Base<'a, E, C> {
    pipeline: &'a dyn Pixels<E, C>,
    image: &'a [E],
    /// Phases along u and along v.
    n: usize,
    /// Pixels along u and v.
    size: [usize; 2],
    phase_len: usize,
    row_len: usize,
}

impl<'a, E, C> Base<'a, E, C> {
    pub(crate) fn of(
        shape: slicecast::plane::Shape,
        plan: &Plan,
        pipeline: &'a dyn Pixels<E, C>,
        image: &'a [E],
    ) -> Self {
        let n = plan.sampling().rays_per_voxel as usize;
        Self {
            pipeline,
            image,
            n,
            size: plan.base().map(|side| n * side as usize),
            phase_len: shape.phase_len(plan),
            row_len: shape.row_len(plan),
        }
    }
}

impl<E: Sync, C: ChannelFormat> BasePixels<C> for Base<'_, E, C> {
    fn copy(&self, first: [i64; 2], width: usize, copy: &mut [[C; 4]], phase: &mut [[C; 4]]) -> bool {
        let clear = channels(Pixel::clear());
        let existing = |axis: usize, side: usize| -> Range<usize> {
            let clip = |place: i64| place.clamp(0, self.size[axis] as i64) as usize;
            clip(first[axis])..clip(first[axis] + side as i64)
        };
        let (columns, rows) = (existing(0, width), existing(1, copy.len() / width));
        if columns.is_empty() || rows.is_empty() {
            return false;
        }
        let mut seen = 0;
        for (v, out) in (first[1]..).zip(copy.chunks_exact_mut(width)) {
            let Some(v) = usize::try_from(v).ok().filter(|v| rows.contains(v)) else {
                out.fill(clear);
                continue;
            };
            let (before, out) = out.split_at_mut((columns.start as i64 - first[0]) as usize);
            let (out, behind) = out.split_at_mut(columns.len());
            before.fill(clear);
            behind.fill(clear);
            for (skipped, u) in columns.clone().enumerate().take(self.n) {
                let start = (v % self.n * self.n + u % self.n) * self.phase_len + v / self.n * self.row_len;
                let row = &self.image[start..start + self.row_len];
                if self.n == 1 {
                    seen |= self.pipeline.pixels(row, u, out);
                } else {
                    // Vectors read runs of one phase; only then the pixels are put where they belong.
                    let places = out[skipped..].iter_mut().step_by(self.n);
                    let phase = &mut phase[..places.len()];
                    seen |= self.pipeline.pixels(row, u / self.n, phase);
                    for (place, pixel) in places.zip(phase) {
                        *place = *pixel;
                    }
                }
            }
        }
        seen != 0
    }
}

/// A base-plane image whose phases are interleaved, as channels of a format.
struct Interleaved<'a, P>(&'a BaseImage, PhantomData<P>);

impl<'a, P: Precision> Interleaved<'a, P> {
    fn of(_: P, base: &'a BaseImage) -> Self {
        Self(base, PhantomData)
    }
}

impl<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>> BasePixels<ChannelOf<P>> for Interleaved<'_, P> {
    fn copy(
        &self,
        [left, upper]: [i64; 2],
        width: usize,
        copy: &mut [[ChannelOf<P>; 4]],
        _: &mut [[ChannelOf<P>; 4]],
    ) -> bool {
        let clear = channels(Pixel::<ChannelOf<P>>::clear());
        let [across, down] = self.0.size.map(|side| side as i64);
        let mut seen = false;
        for (v, out) in (upper..).zip(copy.chunks_exact_mut(width)) {
            for (u, out) in (left..).zip(out) {
                *out = clear;
                if (0..across).contains(&u) && (0..down).contains(&v) {
                    let at = (v * across + u) as usize;
                    *out = self
                        .0
                        .planes
                        .each_ref()
                        .map(|plane| ChannelOf::<P>::from_bits(plane[at]));
                    seen |= *out != clear;
                }
            }
        }
        seen
    }
}

/// What a thread works with.
struct Memory<C> {
    /// Base-plane pixels under a tile, row after row.
    copy: Vec<[C; 4]>,
    /// A row of them, of one phase.
    phase: Vec<[C; 4]>,
    row: Box<Row<C>>,
}

impl<C: ChannelFormat> Memory<C> {
    fn new(shape: &Shape, background: [Intensity; 3]) -> Self {
        let [width, height] = shape.copy;
        let clear = channels(Pixel::clear());
        Self {
            copy: vec![clear; width * height],
            phase: vec![clear; width],
            row: Box::new(Row::new(background)),
        }
    }
}

/// A tile's row of picture pixels on its way, four channels a pixel.
struct Row<C> {
    /// Upper left, upper right, lower left, lower right.
    corners: [[[C; 4]; ACROSS]; 4],
    /// Along u and v, the same for all channels of a pixel.
    weights: [[[u16; 4]; ACROSS]; 2],
    mixed: [[C; 4]; ACROSS],
    /// That of the pixel for each of its channels.
    transparency: [[C; 4]; ACROSS],
    background: [[u16; 4]; ACROSS],
    bytes: [[u8; 4]; ACROSS],
}

impl<C: ChannelFormat> Row<C> {
    fn new(background: [Intensity; 3]) -> Self {
        let [red, green, blue] = background.map(Intensity::to_bits);
        let clear = channels(Pixel::clear());
        Self {
            corners: [[clear; ACROSS]; 4],
            weights: [[[0; 4]; ACROSS]; 2],
            mixed: [clear; ACROSS],
            transparency: [clear; ACROSS],
            background: [[red, green, blue, 0]; ACROSS],
            bytes: [[0; 4]; ACROSS],
        }
    }

    /// Collects what the first `len` pixels mix from a copy in rows of `width`: the first looks at `at`, the next one
    /// `step` further (s31.32, from the copy's first pixel).
    #[inline(always)]
    fn collect(&mut self, copy: &[[C; 4]], width: usize, mut at: [i64; 2], step: [i64; 2], len: usize) {
        let ([a, b, c, d], [along_u, along_v]) = (&mut self.corners, &mut self.weights);
        let (upper, lower) = (a.iter_mut().zip(b), c.iter_mut().zip(d));
        let weights = along_u.iter_mut().zip(along_v);
        for (((a, b), (c, d)), (wu, wv)) in upper.zip(lower).zip(weights).take(len) {
            let Point { pixel: [u, v], weight } = Point::at(at);
            let place = v as usize * width + u as usize;
            let pair = |place: usize| copy.get(place..)?.first_chunk::<2>();
            if let (Some(upper), Some(lower)) = (pair(place), pair(place + width)) {
                [*a, *b] = *upper;
                [*c, *d] = *lower;
            }
            [*wu, *wv] = weight.map(|w| [w as u16; 4]);
            at = [0, 1].map(|axis| at[axis].wrapping_add(step[axis]));
        }
    }

    /// The pixels that have been collected, in front of the background.
    #[inline(always)]
    fn show<V: Lanes>(&mut self, out: &mut [[u8; 3]]) {
        let len = out.len().min(ACROSS);
        let corners = self.corners.each_ref().map(|row| row[..len].as_flattened());
        let weights = self.weights.each_ref().map(|row| row[..len].as_flattened());
        mix_row::<C, V>(corners, weights, self.mixed[..len].as_flattened_mut());
        for (transparency, pixel) in self.transparency[..len].iter_mut().zip(&self.mixed) {
            *transparency = [pixel[3]; 4];
        }
        in_front_of_row::<C, V>(
            self.mixed[..len].as_flattened(),
            self.transparency[..len].as_flattened(),
            self.background[..len].as_flattened(),
            self.bytes[..len].as_flattened_mut(),
        );
        for (out, [red, green, blue, _]) in out.iter_mut().zip(&self.bytes) {
            *out = [*red, *green, *blue];
        }
    }
}

/// A row of tiles.
struct Band<'a, C> {
    base: &'a dyn BasePixels<C>,
    warp: &'a Warp,
    shape: &'a Shape,
    /// A clear pixel in front of the background.
    clear: [u8; 3],
    /// Its first picture row.
    first: u32,
    /// Picture pixels across.
    width: usize,
    out: &'a mut [u8],
    memory: &'a mut Memory<C>,
}

/// Mixes what a row of picture pixels has collected.
struct Show<'a, C, V>(&'a mut Row<C>, &'a mut [[u8; 3]], PhantomData<V>);

impl<C: ChannelFormat, V: Lanes> Kernel for Show<'_, C, V> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.show::<V>(self.1);
    }
}

impl<C: ChannelFormat> OverLanes for Band<'_, C> {
    type Output = ();

    fn run<V: Lanes>(self) {
        let Shape {
            tile,
            copy: [width, _],
            back,
        } = *self.shape;
        let Memory { copy, phase, row } = self.memory;
        let step = self.warp.right.map(|step| step.to_bits());
        for x in (0..self.width).step_by(tile[0]) {
            let corner = self.warp.exact(x as u32, self.first);
            // The coordinate wraps where the definition wraps. The rest of a tile that goes on beyond it sees nothing on
            // either side, as the base plane is far from both.
            let first = [0, 1].map(|axis| {
                let least = i128::from(corner[axis].wrapping_add(1 << 15)) - i128::from(back[axis]);
                (least >> 32) as i64
            });
            let seen = self.base.copy(first, width, copy, phase);
            let columns = 3 * x..3 * (x + tile[0]).min(self.width);
            for (y, out) in (self.first..).zip(self.out.chunks_exact_mut(3 * self.width)) {
                let out = out[columns.clone()].as_chunks_mut::<3>().0;
                if seen {
                    let exact = self.warp.exact(x as u32, y);
                    let at = [0, 1].map(|axis| exact[axis].wrapping_sub(first[axis] << 32));
                    row.collect(copy, width, at, step, out.len());
                    V::enter(Show(row, out, PhantomData::<V>));
                } else {
                    out.fill(self.clear);
                }
            }
        }
    }
}
