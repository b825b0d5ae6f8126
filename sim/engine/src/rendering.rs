//! A frame under way: a pipeline with its image, whatever their types.
//!
//! What compares, times or observes frames calls pipelines through these two traits, once per frame or per tile.

use std::any::Any;
use std::ops::Range;
use std::sync::Mutex;

use rayon::prelude::*;
use slicecast::classify::Support;
use slicecast::clip::Clips;
use slicecast::plan::Plan;
use slicecast::slice::{Code12, Slice};
use slicecast::stream::{Needs, StreamError};
use slicecast::tap::Tap;

use crate::base::base_image;
use crate::base::new_image;
use crate::bundle::Bundle;
use crate::error::RenderError;
use crate::folds::{Folds, Frames};
use crate::geometry::Geometry;
use crate::image::{BaseImage, Rgb};
use crate::occupancy::Looks;
use crate::oriented::Oriented;
use crate::part::Part;
use crate::part::parts;
use crate::picture::Shown;
use crate::progress::{LendTap, Progress};
use crate::shard::Shard;
use crate::simd::Simd;
use crate::stream::fold_stream;
use crate::tile::TILE_ROWS;
use crate::tile::Tile;
use crate::tiles::{Tiling, fold_oriented, fold_tile, fold_tiles, fold_tiles_tapped};
use slicecast::plane::Pictured;

/// A pipeline with its image.
pub trait Rendering: Any + Send + Sync {
    /// Memory that a stream of the pipeline needs.
    fn needs(&self) -> Needs;
    /// Which voxel ranges can change the image; `None` where any can.
    fn support(&self) -> Option<Support>;
    /// What it looks at of a slice and the next.
    fn looks(&self) -> Looks;
    /// The order of compositing.
    fn back_to_front(&self) -> bool;

    /// Makes an untouched image. Nothing is folded before.
    ///
    /// # Errors
    /// [`RenderError::Memory`] before anything too large is allocated.
    fn begin(&mut self) -> Result<(), RenderError>;
    /// Folds all planes, tile by tile on rayon's current threads: rows as a whole, or the blocks that can be seen where they
    /// are few.
    fn fold(&mut self, volume: &Oriented<'_>, tile_rows: usize, simd: Simd, progress: Progress<'_>);
    /// The planes in parts of at most so many slices, in the order of folding.
    fn parts(&self, most: usize) -> Vec<Part>;
    /// [`Rendering::fold`] of the planes of a part, from its slices alone, into one shard of the tiles; other rows stay untouched.
    fn fold_part(&mut self, volume: &Oriented<'_>, part: &Part, shard: Shard, simd: Simd, progress: Progress<'_>);
    /// Whether no further plane can change these rows of any phase.
    fn is_finished(&self, rows: Range<u32>) -> bool;
    /// [`Rendering::fold`], rows as a whole.
    fn fold_rows(&mut self, slices: &[Slice<'_>], tile_rows: usize, simd: Simd, progress: Progress<'_>);
    /// The same by the scalar definitions, each tile under a tap. See [`tapped`].
    fn fold_tapped(&mut self, slices: &[Slice<'_>], tile_rows: usize, progress: Progress<'_>, lend: LendTap<'_>);
    /// Folds all planes into one tile by the scalar definitions, under a tap.
    fn fold_tile(&mut self, slices: &[Slice<'_>], tile: Tile, tap: &mut dyn Tap);
    /// Folds all planes through the stream layer, perhaps under a tap.
    ///
    /// # Errors
    /// [`StreamError`] if a slice is refused.
    fn stream(
        &mut self,
        slices: &[Slice<'_>],
        progress: Progress<'_>,
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), StreamError>;

    /// Folds some of the image's rays through the slices of another level, whose rendering is of the same scene; each ray is in one bundle,
    /// and the plans of all hold the same voxels.
    fn fold_bundles(&mut self, level: &dyn Framing, bundles: &[Bundle], volume: &Oriented<'_>, simd: Simd);

    /// The base-plane image.
    fn base(&self) -> BaseImage;
}

/// A rendering whose image can be warped to a picture.
pub trait Framing: Rendering {
    /// The viewer's picture.
    fn picture(&self, shown: &Shown<'_>) -> Rgb;
}

/// A pipeline and its image.
pub struct Under<F: Folds + ?Sized> {
    plan: Plan,
    clips: Option<Clips>,
    image: Vec<F::Element>,
    pipeline: Box<F>,
}

impl<F: Folds + ?Sized> Under<F> {
    /// A pipeline without an image.
    pub fn new(Geometry { plan, clips }: Geometry<'_>, pipeline: Box<F>) -> Self {
        Self {
            plan: *plan,
            clips: clips.cloned(),
            image: Vec::new(),
            pipeline,
        }
    }

    /// Elements of a row of the image.
    fn row_len(&self) -> usize {
        self.pipeline.shape().row_len(&self.plan)
    }
}

/// Not a method: images are changed meanwhile.
const fn geometry<'a>(plan: &'a Plan, clips: &'a Option<Clips>) -> Geometry<'a> {
    Geometry {
        plan,
        clips: clips.as_ref(),
    }
}

impl<F: Folds<Voxel = Code12> + ?Sized + 'static> Rendering for Under<F> {
    fn needs(&self) -> Needs {
        let [_, height] = self.plan.base();
        Needs::of_shape(self.pipeline.shape(), &self.plan, height)
    }

    fn support(&self) -> Option<Support> {
        self.pipeline.support()
    }

    fn looks(&self) -> Looks {
        Looks::of(self.pipeline.shape(), &self.plan)
    }

    fn back_to_front(&self) -> bool {
        self.pipeline.shape().back_to_front
    }

    fn begin(&mut self) -> Result<(), RenderError> {
        self.image = new_image(&self.plan, &*self.pipeline)?;
        Ok(())
    }

    fn fold(&mut self, volume: &Oriented<'_>, tile_rows: usize, simd: Simd, progress: Progress<'_>) {
        let (geometry, pipeline, image) = (geometry(&self.plan, &self.clips), &*self.pipeline, &mut self.image);
        fold_oriented(geometry, pipeline, volume, image, tile_rows.into(), simd, progress);
    }

    fn parts(&self, most: usize) -> Vec<Part> {
        let [_, _, depth] = self.plan.dims();
        let shape = self.pipeline.shape();
        let near = |plane| shape.near_slice(&self.plan, plane);
        parts(shape.planes(&self.plan), depth, near, shape.back_to_front, most)
    }

    fn is_finished(&self, rows: Range<u32>) -> bool {
        let (row_len, height) = (self.row_len(), self.plan.base()[1] as usize);
        let rows = rows.start as usize * row_len..rows.end as usize * row_len;
        let mut phases = self.image.chunks(row_len * height);
        phases.all(|phase| {
            let rows = phase.get(rows.clone()).unwrap_or(&[]);
            self.pipeline.finished(Simd::Scalar, &self.plan, rows)
        })
    }

    fn fold_part(&mut self, volume: &Oriented<'_>, part: &Part, shard: Shard, simd: Simd, progress: Progress<'_>) {
        let tiling = Tiling {
            rows: TILE_ROWS,
            shard,
            part: Some(part),
        };
        let plan = part.brick.as_ref().map_or(self.plan, |brick| brick.plan(&self.plan));
        let (pipeline, image) = (&*self.pipeline, &mut self.image);
        fold_oriented(
            geometry(&plan, &self.clips),
            pipeline,
            volume,
            image,
            tiling,
            simd,
            progress,
        );
    }

    fn fold_rows(&mut self, slices: &[Slice<'_>], tile_rows: usize, simd: Simd, progress: Progress<'_>) {
        let (geometry, pipeline, image) = (geometry(&self.plan, &self.clips), &*self.pipeline, &mut self.image);
        fold_tiles(
            geometry,
            pipeline,
            (slices, None),
            image,
            tile_rows.into(),
            simd,
            progress,
        );
    }

    fn fold_tapped(&mut self, slices: &[Slice<'_>], tile_rows: usize, progress: Progress<'_>, lend: LendTap<'_>) {
        let (geometry, pipeline, image) = (geometry(&self.plan, &self.clips), &*self.pipeline, &mut self.image);
        fold_tiles_tapped(geometry, pipeline, slices, image, tile_rows, progress, lend);
    }

    fn fold_tile(&mut self, slices: &[Slice<'_>], tile: Tile, tap: &mut dyn Tap) {
        let row_len = self.row_len();
        let first = (tile.phase as usize * self.plan.base()[1] as usize + tile.first as usize) * row_len;
        let data = self.image.get_mut(first..first + tile.rows as usize * row_len);
        let geometry = geometry(&self.plan, &self.clips);
        fold_tile(geometry, &*self.pipeline, slices, tile, data.unwrap_or(&mut []), tap);
    }

    fn stream(
        &mut self,
        slices: &[Slice<'_>],
        progress: Progress<'_>,
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), StreamError> {
        let geometry = geometry(&self.plan, &self.clips);
        fold_stream(geometry, &*self.pipeline, slices, &mut self.image, progress, tap)
    }

    fn fold_bundles(&mut self, level: &dyn Framing, bundles: &[Bundle], volume: &Oriented<'_>, simd: Simd) {
        let level: &dyn Any = level;
        let (Some(Self { pipeline, .. }), Some(first)) = (level.downcast_ref(), bundles.first()) else {
            assert!(bundles.is_empty(), "levels of one scene have images of one kind");
            return;
        };
        let (pipeline, shape) = (&**pipeline, pipeline.shape());
        let looks = Looks::of(shape, &first.plan);
        let sight = volume.sight(looks, pipeline.support(), shape.back_to_front, simd);
        let slices = (volume.slices, sight.as_ref());
        let (finest, image) = (&self.plan, &mut self.image);
        // Pixels are copied, of as many bundles at a time as there are threads.
        for some in bundles.chunks(rayon::current_num_threads()) {
            let folded = |bundle: &Bundle| {
                let mut own = bundle.gathered(finest, shape.channels, image);
                if !pipeline.finished(Simd::Scalar, &bundle.plan, &own) {
                    // Levels have no clip planes.
                    let geometry = geometry(&bundle.plan, &None);
                    fold_tiles(geometry, pipeline, slices, &mut own, TILE_ROWS.into(), simd, &|_, _| ());
                }
                own
            };
            let folded: Vec<_> = some.par_iter().map(folded).collect();
            for (bundle, own) in some.iter().zip(&folded) {
                bundle.scatter(finest, shape.channels, image, own);
            }
        }
    }

    fn base(&self) -> BaseImage {
        base_image(&self.plan, &*self.pipeline, &self.image)
    }
}

impl<F: Frames<Voxel = Code12> + ?Sized + 'static> Framing for Under<F> {
    fn picture(&self, shown: &Shown<'_>) -> Rgb {
        self.pipeline.picture(shown, &self.plan, &self.image)
    }
}

/// A pipeline as a rendering.
pub(crate) fn under<L: Pictured<Voxel = Code12> + Send + 'static>(
    geometry: Geometry<'_>,
    pipeline: L,
) -> Box<dyn Framing> {
    let pipeline: Box<dyn Frames<Voxel = Code12, Element = L::Element>> = Box::new(pipeline);
    Box::new(Under::new(geometry, pipeline))
}

/// Folds all planes by the scalar definitions, each tile under a tap of its own. The taps in the order of the tiles, phase by
/// phase, which does not depend on the number of threads.
pub fn tapped<T: Tap + Send>(
    rendering: &mut (impl Rendering + ?Sized),
    slices: &[Slice<'_>],
    tile_rows: usize,
    progress: Progress<'_>,
    tap: impl Fn(Tile) -> T + Sync,
) -> Vec<T> {
    let taps = Mutex::new(Vec::new());
    rendering.fold_tapped(slices, tile_rows, progress, &|tile, fold| {
        let mut tap = tap(tile);
        fold(&mut tap);
        let mut taps = taps.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        taps.push((tile, tap));
    });
    let mut taps = taps.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    taps.sort_by_key(|(tile, _)| (tile.phase, tile.first));
    taps.into_iter().map(|(_, tap)| tap).collect()
}

/// The channels of a base-plane image in the order of memory: phases, rows, channels, columns.
pub fn in_memory_order<'i>(image: &'i BaseImage, rays_per_voxel: usize) -> impl Iterator<Item = u32> + 'i {
    let [width, height] = image.size;
    (0..rays_per_voxel * rays_per_voxel).flat_map(move |phase| {
        (phase / rays_per_voxel..height)
            .step_by(rays_per_voxel)
            .flat_map(move |v| {
                image.planes.iter().flat_map(move |plane| {
                    let row = &plane[v * width..(v + 1) * width];
                    row.iter().copied().skip(phase % rays_per_voxel).step_by(rays_per_voxel)
                })
            })
    })
}
