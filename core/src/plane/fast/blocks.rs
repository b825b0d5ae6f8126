//! Blocks in 16-bit lanes: the way through a plane that makes only the vectors of columns in which something can be seen.
//!
//! As `plane/blocks.rs`, for vectors of more lanes than a block may have columns: blocks beside each other are one run, which is
//! gone through vector by vector. Visible samples of many rows are packed side by side before light is made of them. Samples and gradients
//! come straight from the voxels; at faces by the rules of `source.rs`, of which the bits are the same.

use core::marker::PhantomData;
use core::ops::Range;

use super::kernels::FastShader;
use super::pixels::Pixels;
use super::source::{Faces, at_face_along_z, slope};
use crate::classify::Slab;
use crate::composite::{Colours, Order};
use crate::fast::fold::fold_at;
use crate::fast::sample::{Both, Slope, VOXEL_SHIFT, lerp, short};
use crate::format::Intensity;
use crate::lanes::{Halves, Kernel, Lanes};
use crate::plane::extent::Extent;
use crate::plane::fold::Batches;
use crate::plane::kernels::ClassifierRows;
use crate::plane::scratch::BATCH;
use crate::plane::source::derivatives;
use crate::rows::{part, part_mut, three};
use crate::seen::Seen;
use crate::slice::Window;
use crate::tap::Beam;

/// Vectors of a batch: no vector has fewer than 16 lanes.
const VECTORS: usize = BATCH >> 4;

/// Fewest voxels of a row: with fewer a sample may be at both faces along x.
pub(super) const WIDTH_LEAST: usize = 4;

/// Some samples side by side, at most a vector of them.
#[derive(Clone, Copy, Default)]
struct Spot {
    /// Row of the image.
    row: u32,
    /// Column of the volume of the first.
    column: usize,
    len: usize,
}

/// The way through the runs of blocks of some rows.
struct Walk<'s> {
    seen: Seen<'s>,
    /// Rows that are left.
    rows: Range<u32>,
    row: u32,
    /// What is left of the row's blocks, and of the present run's columns.
    blocks: u64,
    run: Range<usize>,
}

impl Walk<'_> {
    /// The next samples, of those in some columns of the volume.
    #[inline(always)]
    fn next(&mut self, extent: &Extent, inside: &Range<usize>, lanes: usize) -> Option<Spot> {
        loop {
            while self.run.start >= self.run.end {
                while self.blocks == 0 {
                    self.row = self.rows.next()?;
                    self.blocks = self.seen.row(extent.voxel_row(self.row) as usize);
                }
                let first = self.blocks.trailing_zeros();
                let last = first + (self.blocks >> first).trailing_ones() - 1;
                // A carry clears the run.
                self.blocks &= self.blocks.wrapping_add(1 << first);
                let grain = self.seen.grain();
                self.run = grain.block(first).start..grain.block(last).end.min(inside.end);
            }
            let column = self.run.start.max(inside.start);
            self.run.start += lanes;
            let end = self.run.start.min(self.run.end);
            if column < end {
                return Some(Spot {
                    row: self.row,
                    column,
                    len: end - column,
                });
            }
        }
    }
}

/// Batches of the vectors that can be seen.
pub(super) struct Blocks<'s, 'w, V, S> {
    walk: Walk<'s>,
    extent: &'s Extent,
    window: &'s Window<'w>,
    spacing: [Intensity; 3],
    spots: [Spot; VECTORS],
    samples: &'s mut [u16],
    /// Vectors whose samples have been made, and vectors in which one of them is visible.
    made: usize,
    kept: usize,
    packed: bool,
    kinds: PhantomData<(V, S)>,
}

impl<'s, 'w, V: Lanes, S: FastShader> Blocks<'s, 'w, V, S> {
    /// Blocks of some rows of the image. `samples`: room for a batch.
    pub(super) fn new(
        seen: Seen<'s>,
        (extent, window, rows): (&'s Extent, &'s Window<'w>, Range<u32>),
        spacing: [Intensity; 3],
        samples: &'s mut [u16],
    ) -> Self {
        let walk = Walk {
            seen,
            rows,
            row: 0,
            blocks: 0,
            run: 0..0,
        };
        Self {
            walk,
            extent,
            window,
            spacing,
            spots: [Spot::default(); VECTORS],
            samples: part_mut(samples, 0..BATCH),
            made: 0,
            kept: 0,
            packed: true,
            kinds: PhantomData,
        }
    }

    /// Columns of the plane's pixels, counted from its first.
    #[inline(always)]
    fn pixels(&self, spot: Spot) -> Range<usize> {
        let first = spot.column.saturating_sub(self.extent.voxel);
        first..first + spot.len
    }

    #[inline(always)]
    fn spot(&self, number: usize) -> Spot {
        self.spots.get(number).copied().unwrap_or_default()
    }

    /// Finds the next vectors under which a ray goes on, and makes their samples.
    #[inline(always)]
    fn make<O: Order>(&mut self, canvas: &Pixels<'_, O, V>) {
        let lanes = V::Halves::COUNT;
        let (extent, inside) = (
            self.extent,
            self.extent.voxel..self.extent.voxel + self.extent.columns.len(),
        );
        let probe = Probe::<V::Halves>::new(extent, self.window);
        self.made = 0;
        let room = BATCH.checked_div(lanes).unwrap_or(0).min(VECTORS);
        while self.made < room
            && let Some(spot) = self.walk.next(extent, &inside, lanes)
        {
            let goes_on =
                O::BACK_TO_FRONT || !V::Halves::load::<false>(canvas.left(spot.row, self.pixels(spot)), 0).all_zero();
            if goes_on {
                let sample = probe.sample(extent.voxel_row(spot.row), spot.column);
                sample.store::<false>(self.samples, self.made * lanes);
                if let Some(place) = self.spots.get_mut(self.made) {
                    *place = spot;
                }
                self.made += 1;
            }
        }
    }

    /// Moves vectors with a visible sample to the front, and visible samples side by side; how many these are.
    #[inline(always)]
    fn pack<O: Order>(&mut self, canvas: &Pixels<'_, O, V>, roots: &mut [u16]) -> usize {
        let lanes = V::Halves::COUNT;
        let (mut kept, mut packed) = (0, 0);
        for number in 0..self.made {
            let (spot, at) = (self.spot(number), number * lanes);
            // Lanes beyond the run see nothing.
            let mut root = V::Halves::load::<false>(part(roots, at..at + spot.len), 0);
            if !O::BACK_TO_FRONT {
                let left = V::Halves::load::<false>(canvas.left(spot.row, self.pixels(spot)), 0);
                root = left.nonzero_then(root);
            }
            if root.all_zero() {
                continue;
            }
            let samples = V::Halves::load::<false>(self.samples, at);
            packed += samples.store_packed(root, self.samples, packed);
            root.store::<false>(roots, kept * lanes);
            if let Some(place) = self.spots.get_mut(kept) {
                *place = spot;
            }
            kept += 1;
        }
        self.kept = kept;
        packed
    }

    #[inline(always)]
    fn make_gradients(&self, roots: &[u16], [gx, gy, gz]: [&mut [u16]; 3]) {
        let probe = Probe::<V::Halves>::new(self.extent, self.window);
        let [fx, fy, fz] = self.spacing;
        let mut at = 0;
        for number in 0..self.kept {
            let spot = self.spot(number);
            let chosen = V::Halves::load::<false>(roots, number * V::Halves::COUNT);
            let [x, y, z] = probe.gradient(self.extent.voxel_row(spot.row), spot.column);
            spaced(x, fx).store_packed(chosen, gx, at);
            spaced(y, fy).store_packed(chosen, gy, at);
            at += spaced(z, fz).store_packed(chosen, gz, at);
        }
    }

    #[inline(always)]
    fn fold_packed<O: Order>(&self, canvas: &mut Pixels<'_, O, V>, colours: &Colours<'_, u16>, roots: &[u16]) {
        let [red, green, blue] = colours.rows();
        let (offsets, floor) = (canvas.offsets, canvas.floor);
        let mut at = 0;
        for number in 0..self.kept {
            let spot = self.spot(number);
            let root = V::Halves::load::<false>(roots, number * V::Halves::COUNT);
            let colour = [
                V::Halves::load_spread(red, at, root),
                V::Halves::load_spread(green, at, root),
                V::Halves::load_spread(blue, at, root),
            ];
            at += root.count();
            let mut pixels = canvas.pixel_row(spot.row, self.pixels(spot));
            fold_at::<O, V::Halves>(&mut pixels, colour, root, offsets, floor);
        }
    }
}

impl<O: Order, V: Lanes, S: FastShader> Batches<u16, Pixels<'_, O, V>> for Blocks<'_, '_, V, S> {
    const WHOLE_ROWS: bool = false;

    #[inline(always)]
    fn next(&mut self, canvas: &mut Pixels<'_, O, V>) -> Option<usize> {
        V::enter((Make, &mut *self, &*canvas));
        self.packed = false;
        (self.made > 0).then_some(self.made * V::Halves::COUNT)
    }

    #[inline(always)]
    fn slab(&self) -> Slab<'_, u16> {
        Slab::of(self.samples)
    }

    #[inline(always)]
    fn again(&mut self) {
        self.packed = false;
    }

    #[inline(always)]
    fn clip<C: ClassifierRows<u16> + ?Sized>(&self, _: &C, _: u32, _: &mut [u16]) {}

    #[inline(always)]
    fn visible(&mut self, canvas: &mut Pixels<'_, O, V>, roots: &mut [u16]) -> Option<Range<usize>> {
        if self.packed {
            return None;
        }
        self.packed = true;
        let packed = V::enter((Pack, &mut *self, &*canvas, roots));
        (packed > 0).then_some(0..packed)
    }

    #[inline(always)]
    fn gradients(&mut self, _: Range<usize>, roots: &[u16], _: Option<&[u16]>, out: [&mut [u16]; 3]) {
        if S::LIT {
            V::enter((MakeGradients, &*self, roots, out));
        }
    }

    #[inline(always)]
    fn weigh(&self, _: &Pixels<'_, O, V>, _: Range<usize>, _: &mut [u16], _: &[u16]) {}

    #[inline(always)]
    fn fold(
        &mut self,
        canvas: &mut Pixels<'_, O, V>,
        _: Range<usize>,
        colours: &Colours<'_, u16>,
        roots: &[u16],
        _: Option<&[u16]>,
    ) {
        V::enter((FoldPacked, &*self, canvas, colours, roots));
    }

    #[inline(always)]
    fn beam(&self, _: usize, _: u32) -> Option<Beam<'_>> {
        None
    }
}

struct Make;

impl<O: Order, V: Lanes, S: FastShader> Kernel for (Make, &mut Blocks<'_, '_, V, S>, &Pixels<'_, O, V>) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.1.make(self.2);
    }
}

struct Pack;

impl<O: Order, V: Lanes, S: FastShader> Kernel for (Pack, &mut Blocks<'_, '_, V, S>, &Pixels<'_, O, V>, &mut [u16]) {
    type Output = usize;

    #[inline(always)]
    fn run(self) -> usize {
        self.1.pack(self.2, self.3)
    }
}

struct MakeGradients;

impl<V: Lanes, S: FastShader> Kernel for (MakeGradients, &Blocks<'_, '_, V, S>, &[u16], [&mut [u16]; 3]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.1.make_gradients(self.2, self.3);
    }
}

struct FoldPacked;

impl<O: Order, V: Lanes, S: FastShader> Kernel
    for (
        FoldPacked,
        &Blocks<'_, '_, V, S>,
        &mut Pixels<'_, O, V>,
        &Colours<'_, u16>,
        &[u16],
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.1.fold_packed(self.2, self.3, self.4);
    }
}

/// A component times its spacing factor.
#[inline(always)]
fn spaced<H: Halves>(component: H, factor: Intensity) -> H {
    if factor == Intensity::ONE {
        component
    } else {
        component.product_round(H::splat(factor.to_bits()))
    }
}

/// The top bit at a single place: loaded so that this place meets one of the lanes.
static TOP: [u16; 128] = {
    let mut top = [0; 128];
    top[64] = 1 << 15;
    top
};

/// A plane between voxels, as many samples side by side as there are lanes. Lanes behind the last column hold anything.
struct Probe<'p, 'w, H: Halves> {
    window: &'p Window<'w>,
    extent: &'p Extent,
    width: usize,
    last_row: i32,
    in_slice: bool,
    /// Weights of samples.
    x: H,
    y: H,
    z: H,
    wx: u16,
    wy: u16,
    /// Weights of derivatives.
    both: [Both<H>; 3],
    at_face_along_z: bool,
}

impl<'p, 'w, H: Halves> Probe<'p, 'w, H> {
    #[inline(always)]
    fn new(extent: &'p Extent, window: &'p Window<'w>) -> Self {
        let [wx, wy, wz] = three([extent.x, extent.y, extent.z], |cell| short(cell.weight));
        Self {
            window,
            extent,
            width: window.near.width(),
            last_row: extent.height - 1,
            in_slice: wz == 0,
            x: H::splat(wx),
            y: H::splat(wy),
            z: H::splat(wz),
            wx,
            wy,
            both: [Both::of(wx), Both::of(wy), Both::of(wz)],
            at_face_along_z: at_face_along_z(window, wz),
        }
    }

    /// Voxels of a row and slice interpolated along z.
    #[inline(always)]
    fn along_z(&self, row: i32, from: usize) -> H {
        let row = row.min(self.last_row).max(0) as usize;
        let near = H::load::<false>(self.window.near.row(row), from).shl(VOXEL_SHIFT);
        if self.in_slice {
            return near;
        }
        let far = H::load::<false>(self.window.far_or_near().row(row), from).shl(VOXEL_SHIFT);
        lerp(near, far, self.z)
    }

    /// The same interpolated between a row and the next.
    #[inline(always)]
    fn along_y(&self, row: i32, from: usize) -> H {
        lerp(self.along_z(row, from), self.along_z(row + 1, from), self.y)
    }

    /// The samples between a row and the next, from those between a column and the next on.
    #[inline(always)]
    fn sample(&self, row: i32, from: usize) -> H {
        lerp(self.along_y(row, from), self.along_y(row, from + 1), self.x)
    }

    /// The derivative along z.
    #[inline(always)]
    fn derivative(&self, [near, far]: [Slope<'_>; 2], from: usize) -> H {
        let [_, _, both] = self.both;
        let near = near.at::<H, false>(from);
        if self.in_slice {
            near
        } else {
            both.mix_both(near, far.at::<H, false>(from))
        }
    }

    /// The gradients of the samples.
    #[inline(always)]
    fn gradient(&self, row: i32, from: usize) -> [H; 3] {
        let (first, second) = (self.along_y(row, from), self.along_y(row, from + 1));
        let before = if from > 0 {
            self.along_y(row, from - 1)
        } else {
            // Of the first lane nothing is used.
            let mut moved = [0; 65];
            first.store::<false>(&mut moved, 1);
            H::load::<false>(&moved, 0)
        };
        let here = lerp(first, second, self.x);
        let left = lerp(before, first, self.x);
        let right = lerp(second, self.along_y(row, from + 2), self.x);
        let mut gx = right.minus(left);

        let along_y = Faces::of(row, self.wy, self.last_row + 1);
        let above = if along_y.low { here } else { self.sample(row - 1, from) };
        let below = if along_y.high { here } else { self.sample(row + 1, from) };
        let mut gy = below.minus(above);

        let (this, next) = self.extent.voxel_rows(row);
        let whole = 0..self.width;
        let slopes = |row| {
            let (near, far) = derivatives(self.window, row);
            [near, far].map(|of| slope(of, &whole, self.at_face_along_z))
        };
        let (this, next) = (slopes(this), slopes(next));
        let [x, y, _] = self.both;
        let mut gz = x.mix(
            y.mix(self.derivative(this, from), self.derivative(next, from)),
            y.mix(self.derivative(this, from + 1), self.derivative(next, from + 1)),
        );

        let halved = self.at_face_along_z || along_y.any();
        if halved {
            gx = gx.shr_signed(1);
            gy = gy.shr_signed(1);
            if along_y.any() {
                let low = row.min(self.last_row - 1).max(0);
                let rise = self.rise(low, from);
                gy = if along_y.low && along_y.high {
                    rise
                } else {
                    gy.plus(rise.shr_signed(1))
                };
            }
            if !self.at_face_along_z {
                gz = gz.shr_signed(1);
            }
        }

        // The first and the last column with a sample.
        let highest = self.width.saturating_sub(1 + usize::from(self.wx != 0));
        for (column, low) in [(0, true), (highest, false)] {
            let Some(lane) = column.checked_sub(from).filter(|lane| *lane < H::COUNT) else {
                continue;
            };
            let (difference, rise) = match (low, self.wx) {
                (true, _) => (right.minus(here), second.minus(first)),
                (false, 0) => (here.minus(left), first.minus(before)),
                (false, _) => (here.minus(left), second.minus(first)),
            };
            let end = H::load::<false>(&TOP, 64_usize.saturating_sub(lane));
            gx = end.top_then_else(difference.shr_signed(1).plus(rise.shr_signed(1)), gx);
            if !halved {
                gy = end.top_then_else(gy.shr_signed(1), gy);
                gz = end.top_then_else(gz.shr_signed(1), gz);
            }
        }
        [gx, gy, gz]
    }

    /// What rises between a row of voxels and the next, x interpolated.
    #[inline(always)]
    fn rise(&self, row: i32, from: usize) -> H {
        self.between_columns(row + 1, from)
            .minus(self.between_columns(row, from))
    }

    /// Voxels interpolated along z and x.
    #[inline(always)]
    fn between_columns(&self, row: i32, from: usize) -> H {
        lerp(self.along_z(row, from), self.along_z(row, from + 1), self.x)
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;
    use crate::borders::Part;
    use crate::format::Weight;
    use crate::locate::Cell;
    use crate::seen::Grain;

    /// Pixels 3 to 102 of rows 2 to 5 above the voxels 1 to 100, whose blocks have 16 columns; vectors of 32.
    #[test]
    fn vectors_go_through_runs_of_blocks() {
        let cell = |index| Cell {
            index,
            weight: Weight::ZERO,
        };
        let extent = Extent::of([3..103, 0..20], [cell(-2), cell(-2), cell(0)], 20, Part::WHOLE);
        let mut rows = [0; 20];
        // A run of three blocks, the first cut by the first sample, and one of a block that the last sample cuts.
        rows[0] = 0b100_0111;
        rows[2] = 0b1010;
        let walk = &mut Walk {
            seen: Seen::new(&rows, Grain::of(100)),
            rows: 2..6,
            row: 0,
            blocks: 0,
            run: 0..0,
        };
        let inside = extent.voxel..extent.voxel + extent.columns.len();
        let next = || walk.next(&extent, &inside, 32);
        let spots: Vec<_> = core::iter::from_fn(next)
            .map(|spot| (spot.row, spot.column, spot.len))
            .collect();
        assert_eq!(spots, [(2, 1, 31), (2, 32, 16), (2, 96, 5), (4, 16, 16), (4, 48, 16)]);
    }
}
