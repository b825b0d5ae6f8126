//! Tiles of base-plane rows through all planes, on all cores.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use slicecast::clip::Clips;
use slicecast::lanes::Lanes;
use slicecast::locate::cell;
use slicecast::plan::Plan;
use slicecast::plane::{At, Kept, Reading, Rows, ScratchError, Shape};
use slicecast::slice::{Code12, Slice, Voxel, Window};
use slicecast::tap::Tap;

use crate::folds::{Fold, Folds};
use crate::geometry::Geometry;
use crate::occupancy::{Looks, Sight};
use crate::oriented::Oriented;
use crate::part::Brick;
use crate::part::Part;
use crate::progress::LendTap;
use crate::progress::Progress;
use crate::shard::Shard;
use crate::simd::{OverLanes, Simd, prefetch, with_lanes};
use crate::tile::Tile;

/// The tiles that are folded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tiling<'p> {
    /// Rows of a tile.
    pub(crate) rows: usize,
    pub(crate) shard: Shard,
    /// The planes that are folded, and which slices there are of the volume; none: all.
    pub(crate) part: Option<&'p Part>,
}

impl From<usize> for Tiling<'_> {
    /// All tiles of so many rows.
    fn from(rows: usize) -> Self {
        Self {
            rows,
            shard: Shard::ALL,
            part: None,
        }
    }
}

/// Folds all planes into an image, tile by tile on rayon's current threads: rows as a whole, or, where the volume's blocks
/// are known and few of them can be seen, those blocks.
pub(crate) fn fold_oriented<F: Folds<Voxel = Code12> + ?Sized>(
    geometry: Geometry<'_>,
    pipeline: &F,
    volume: &Oriented<'_>,
    image: &mut [F::Element],
    tiling: Tiling<'_>,
    simd: Simd,
    progress: Progress<'_>,
) {
    let shape = pipeline.shape();
    let looks = Looks::of(shape, geometry.plan);
    let sight = volume.sight(looks, pipeline.support(), shape.back_to_front, simd);
    let slices = (volume.slices, sight.as_ref());
    fold_tiles(geometry, pipeline, slices, image, tiling, simd, progress);
}

/// Folds all planes into an image, tile by tile on rayon's current threads: the blocks of slices that can be seen, or rows as a
/// whole where none are named.
pub(crate) fn fold_tiles<F: Folds + ?Sized>(
    geometry: Geometry<'_>,
    pipeline: &F,
    (slices, seen): (&[Slice<'_, F::Voxel>], Option<&Sight>),
    image: &mut [F::Element],
    tiling: Tiling<'_>,
    simd: Simd,
    progress: Progress<'_>,
) {
    let (plan, shape) = (geometry.plan, pipeline.shape());
    let mut sizes = Sizes::of(shape, plan);
    // Blocks are made where they lie.
    if shape.slabs && seen.is_none() {
        sizes = sizes.keeping(plan, tiling.rows);
    }
    each_tile(plan, image, sizes, tiling, progress, &|tile, data, memory| {
        let clips = geometry.clips.map(|clips| with_lanes(simd, InLanes(clips)));
        let geometry = Geometry {
            plan,
            clips: clips.as_ref(),
        };
        let way = Way::of(shape, geometry, slices, seen, tile, tiling.part);
        enough(way.walk(TileFolding::new(pipeline, simd, &way, (data, memory), None)));
    });
}

/// Folds all planes into an image like [`fold_tiles`], by the scalar definitions, each tile under a tap that `lend` lends.
pub(crate) fn fold_tiles_tapped<F: Folds + ?Sized>(
    geometry: Geometry<'_>,
    pipeline: &F,
    slices: &[Slice<'_, F::Voxel>],
    image: &mut [F::Element],
    tile_rows: usize,
    progress: Progress<'_>,
    lend: LendTap<'_>,
) {
    each_tile(
        geometry.plan,
        image,
        Sizes::of(pipeline.shape(), geometry.plan),
        tile_rows.into(),
        progress,
        &|tile, data, memory| {
            lend(tile, &mut |tap| {
                enough(fold_scalar(geometry, pipeline, slices, tile, data, memory, tap))
            });
        },
    );
}

/// [`each_tile`] lends as much scratch memory as pipelines ask for.
fn enough(folded: Result<(), ScratchError>) {
    folded.unwrap_or_else(|error| unreachable!("{error}"));
}

/// The tiles of an image whose rows have `row_len` elements, and what each holds: the same rows of all phases one after the
/// other, because they read the same voxels, which are still near.
pub fn tiles<'i, E>(plan: &Plan, image: &'i mut [E], row_len: usize, tile_rows: usize) -> Vec<(Tile, &'i mut [E])> {
    let [_, height] = plan.base();
    let tile_rows = tile_rows.clamp(1, height as usize);
    let mut phases: Vec<_> = (image.chunks_mut(row_len * height as usize))
        .map(|phase| phase.chunks_mut(row_len * tile_rows))
        .collect();
    let mut tiles = Vec::new();
    for first in (0..height).step_by(tile_rows) {
        for (phase, rest) in (0..).zip(&mut phases) {
            let data = rest.next().unwrap_or(&mut []);
            let rows = (data.len() / row_len) as u32;
            tiles.push((Tile { phase, first, rows }, data));
        }
    }
    tiles
}

/// What a pipeline's tiles need, as numbers: the loop over the tiles is compiled once per element of an image.
struct Sizes {
    /// Elements of a row of an image.
    row_len: usize,
    /// Words of scratch memory.
    scratch_len: usize,
    /// Words for the samples that tiles keep from plane to plane.
    kept_len: usize,
}

impl Sizes {
    /// Of a pipeline's tiles, with room for rows that begin with a line of the cache.
    fn of(shape: Shape, plan: &Plan) -> Self {
        Self {
            row_len: shape.row_len(plan),
            scratch_len: shape.blocks_scratch_len(plan.longest_row().max(1024) + 32),
            kept_len: 0,
        }
    }

    /// With the samples of a tile's rows kept from plane to plane.
    fn keeping(self, plan: &Plan, tile_rows: usize) -> Self {
        let ([width, _, _], [_, height]) = (plan.dims(), plan.base());
        Self {
            kept_len: Kept::len(tile_rows.min(height as usize), width),
            ..self
        }
    }

    fn memory(&self) -> Memory {
        Memory {
            scratch: vec![0; self.scratch_len],
            kept: vec![0; self.kept_len],
        }
    }
}

/// Memory that a tile works in.
struct Memory {
    scratch: Vec<i32>,
    /// Empty where nothing is kept from plane to plane.
    kept: Vec<i32>,
}

/// Work on a tile: where it lies, its rows, memory.
type Work<'a, E> = &'a (dyn Fn(Tile, &mut [E], &mut Memory) + Sync);

/// Does something with every tile of an image, in parallel.
fn each_tile<E: Send>(
    plan: &Plan,
    image: &mut [E],
    sizes: Sizes,
    Tiling { rows, shard, .. }: Tiling<'_>,
    progress: Progress<'_>,
    work: Work<'_, E>,
) {
    let mut tiles = tiles(plan, image, sizes.row_len, rows);
    tiles.retain(|(tile, _)| shard.holds(*tile, rows as u32));
    let total = tiles.len();
    let done = AtomicUsize::new(0);
    // Each on its own: how long it takes depends on what it sees.
    tiles.into_par_iter().with_max_len(1).for_each_init(
        || sizes.memory(),
        |memory, (tile, data)| {
            work(tile, data, memory);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        },
    );
}

/// Folds all planes into the rows of a tile by the scalar definitions, under a tap.
pub(crate) fn fold_tile<F: Folds + ?Sized>(
    geometry: Geometry<'_>,
    pipeline: &F,
    slices: &[Slice<'_, F::Voxel>],
    tile: Tile,
    data: &mut [F::Element],
    tap: &mut dyn Tap,
) {
    let mut memory = Sizes::of(pipeline.shape(), geometry.plan).memory();
    enough(fold_scalar(geometry, pipeline, slices, tile, data, &mut memory, tap));
}

fn fold_scalar<F: Folds + ?Sized>(
    geometry: Geometry<'_>,
    pipeline: &F,
    slices: &[Slice<'_, F::Voxel>],
    tile: Tile,
    data: &mut [F::Element],
    memory: &mut Memory,
    tap: &mut dyn Tap,
) -> Result<(), ScratchError> {
    let clips = geometry.clips.map(|clips| clips.clone().in_lanes::<i32>());
    let geometry = Geometry {
        plan: geometry.plan,
        clips: clips.as_ref(),
    };
    let way = Way::of(pipeline.shape(), geometry, slices, None, tile, None);
    way.walk(TileFolding::new(
        pipeline,
        Simd::Scalar,
        &way,
        (data, memory),
        Some(tap),
    ))
}

/// Clip planes, with lanes still to be chosen.
struct InLanes<'a>(&'a Clips);

impl OverLanes for InLanes<'_> {
    type Output = Clips;

    fn run<V: Lanes>(self) -> Clips {
        self.0.clone().in_lanes::<V>()
    }
}

/// How many slices ahead of a plane memory is asked for.
pub const AHEAD: i32 = 3;

/// After how many planes a tile is asked whether its rays are all finished.
const FINISHED_EVERY: u32 = 16;

/// A tile's way through all planes.
struct Way<'a, 's, X> {
    plan: &'a Plan,
    clips: Option<&'a Clips>,
    slices: &'a [Slice<'s, X>],
    /// The blocks that can be seen; none: rows are made as a whole.
    seen: Option<&'a Sight>,
    tile: Tile,
    /// The planes that are folded.
    planes: Range<u32>,
    /// The brick of the slices that there is, if they are not whole.
    brick: Option<&'a Brick>,
    /// Number of the first of the slices.
    first_slice: i32,
    /// That of the pipeline.
    shape: Shape,
}

impl<'a, 's, X: Voxel> Way<'a, 's, X> {
    /// The way of a kind of pipeline.
    fn of(
        shape: Shape,
        Geometry { plan, clips }: Geometry<'a>,
        slices: &'a [Slice<'s, X>],
        seen: Option<&'a Sight>,
        tile: Tile,
        part: Option<&'a Part>,
    ) -> Self {
        Self {
            brick: part.and_then(|part| part.brick.as_ref()),
            planes: part.map_or(shape.planes(plan), |part| part.planes.clone()),
            first_slice: part.map_or(0, |part| part.slices.start as i32),
            plan,
            clips,
            slices,
            seen,
            tile,
            shape,
        }
    }

    /// Goes through the planes, in a pipeline's order, until its rays are finished.
    fn walk<F: Folds<Voxel = X> + ?Sized>(&self, mut fold: TileFolding<'_, F>) -> Result<(), ScratchError> {
        let back_to_front = self.shape.back_to_front;
        let place = |z: i32| usize::try_from(z - self.first_slice).ok();
        let slice = |z: i32| place(z).and_then(|z| self.slices.get(z)).copied();
        let Range { start, end } = self.planes;
        let mut ahead = None;
        for step in 0..end - start {
            let index = if back_to_front { end - 1 - step } else { start + step };
            let plane = self.shape.plane(self.plan, self.plan.phase(self.tile.phase), index);
            let z = self.shape.near_slice(self.plan, index);
            let wanted = if back_to_front { z - AHEAD } else { z + AHEAD };
            let mut fresh = None;
            if ahead != Some(wanted) {
                ahead = Some(wanted);
                fresh = slice(wanted).map(Ahead);
            }
            // Rows of rays that spread are not rows of the slice.
            if let (Some(Ahead(slice)), Some(_), false) = (&fresh, self.seen, self.plan.spreads()) {
                self.prefetch(slice, cell(plane.y).index);
            }
            if let Some(window) = Window::at(z, slice) {
                let at = At {
                    plan: self.plan,
                    plane,
                    window,
                    seen: self.seen.map(|sight| sight.at(place(z).unwrap_or(0))),
                    clips: self.clips.map(Clips::clipper),
                    reading: fresh.as_ref().map(|ahead| ahead as &dyn Reading),
                };
                match self.brick {
                    None => fold.plane(&at, None)?,
                    Some(brick) => self.fold_brick(brick, &at, &mut fold)?,
                }
            }
            // Rows as a whole are left out one by one.
            if self.seen.is_some() && step % FINISHED_EVERY == 0 && fold.finished(self.plan) {
                break;
            }
        }
        Ok(())
    }

    /// Folds the pixels of a plane whose samples lie in a brick.
    fn fold_brick<F: Folds<Voxel = X> + ?Sized>(
        &self,
        brick: &Brick,
        at: &At<'_, X>,
        fold: &mut TileFolding<'_, F>,
    ) -> Result<(), ScratchError> {
        let Tile { first, rows, .. } = self.tile;
        let [columns, _] = self.plan.base();
        let columns = brick.pixels(0, at.plane.x, 0..columns);
        let rows = brick.pixels(1, at.plane.y, first..first + rows);
        if columns.is_empty() || rows.is_empty() {
            return Ok(());
        }
        let plan = self.plan.of_columns(columns.start, columns.len() as u32);
        let plane = self.shape.plane(&plan, at.plane.phase, at.plane.index);
        fold.plane(
            &At {
                plan: &plan,
                plane,
                ..*at
            },
            Some([columns, rows]),
        )
    }

    /// Asks for the rows of a slice that a tile will read: those under its own rows, shifted by `offset`, and those that
    /// gradients look at beyond.
    fn prefetch(&self, slice: &Slice<'_, X>, offset: i32) {
        let first = (i64::from(self.tile.first) + i64::from(offset)).max(1) as usize;
        for row in first - 1..(first + self.tile.rows as usize + 2).min(slice.height()) {
            prefetch(slice.words(row));
        }
    }
}

/// A pipeline and the tile that it is folded into.
struct TileFolding<'a, F: Folds + ?Sized> {
    pipeline: &'a F,
    simd: Simd,
    rows: Rows<'a, F::Element>,
    scratch: &'a mut [i32],
    kept: Option<Kept<'a>>,
    /// Some columns of the rows, while they are folded on their own.
    columns: Vec<F::Element>,
    /// Columns of the image.
    width: usize,
    /// Elements of a row of it.
    row_len: usize,
    /// Sees every plane, those of finished tiles too.
    tap: Option<&'a mut dyn Tap>,
}

impl<'a, F: Folds + ?Sized> TileFolding<'a, F> {
    fn new(
        pipeline: &'a F,
        simd: Simd,
        way: &Way<'_, '_, F::Voxel>,
        (data, Memory { scratch, kept }): (&'a mut [F::Element], &'a mut Memory),
        tap: Option<&'a mut dyn Tap>,
    ) -> Self {
        let Tile { first, rows, .. } = way.tile;
        let [width, _, _] = way.plan.dims();
        Self {
            pipeline,
            simd,
            rows: Rows { first, data },
            scratch,
            // `Sizes::keeping` has as much as the highest tile needs.
            kept: Kept::new(kept, first, rows as usize, width).ok(),
            columns: Vec::new(),
            width: way.plan.base()[0] as usize,
            row_len: way.shape.row_len(way.plan),
            tap,
        }
    }

    /// Folds a plane into the tile, or into some columns and rows of the image, which the tile has; the plan is then of those
    /// columns.
    fn plane(&mut self, at: &At<'_, F::Voxel>, pixels: Option<[Range<u32>; 2]>) -> Result<(), ScratchError> {
        let Self {
            pipeline,
            simd,
            rows: Rows { first, data },
            scratch,
            kept,
            columns: own,
            tap,
            width,
            row_len,
        } = self;
        // Rows that come and go are not kept.
        let kept = kept.as_mut().filter(|_| pixels.is_none());
        let (width, row_len) = (*width, *row_len);
        let (mut first, mut data, mut columns) = (*first, &mut **data, 0..width);
        if let Some([across, rows]) = pixels {
            let start = (rows.start - first) as usize * row_len;
            data = &mut data[start..start + rows.len() * row_len];
            (first, columns) = (rows.start, across.start as usize..across.end as usize);
        }
        let is_cut = columns.len() < width;
        if is_cut {
            take_columns(data, width, &columns, own);
        }
        let rows = Rows {
            first,
            data: if is_cut { own } else { &mut *data },
        };
        let tap: Option<&mut dyn Tap> = match tap {
            Some(tap) => Some(&mut **tap),
            None => None,
        };
        let fold = Fold {
            at,
            rows,
            scratch,
            kept,
            tap,
        };
        pipeline.fold(*simd, fold)?;
        if is_cut {
            put_columns(data, width, &columns, own);
        }
        Ok(())
    }

    /// Whether all rays of the tile are finished.
    fn finished(&self, plan: &Plan) -> bool {
        self.pipeline.finished(self.simd, plan, self.rows.data)
    }
}

/// Copies some columns of runs of a width. Pipelines with the same elements share it.
#[inline(never)]
fn take_columns<E: Copy>(runs: &[E], width: usize, columns: &Range<usize>, own: &mut Vec<E>) {
    own.clear();
    for run in runs.chunks_exact(width) {
        own.extend_from_slice(&run[columns.clone()]);
    }
}

/// Puts them back.
#[inline(never)]
fn put_columns<E: Copy>(runs: &mut [E], width: usize, columns: &Range<usize>, own: &[E]) {
    for (run, own) in runs.chunks_exact_mut(width).zip(own.chunks_exact(columns.len())) {
        run[columns.clone()].copy_from_slice(own);
    }
}

/// The slice that will be read some planes later, asked for row by row while the rows before it are folded: a tile's rows
/// all at once would fill the processor's queue.
#[derive(Debug)]
struct Ahead<'s, X>(Slice<'s, X>);

impl<X: Voxel> Reading for Ahead<'_, X> {
    fn row(&self, row: i32) {
        // Gradients look one row beyond the two of a sample.
        let row = usize::try_from(row + 2).unwrap_or(0);
        if row < self.0.height() {
            prefetch(self.0.words(row));
        }
    }
}
