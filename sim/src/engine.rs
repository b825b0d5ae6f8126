//! Renders a scene: tiles of base-plane rows through all slices, on all cores; or slice by slice, as firmware does.

use rayon::prelude::*;
use slicecast::composite::Channel;
use slicecast::format::Intensity;
use slicecast::lanes::Lanes;
use slicecast::locate::{Plane, cell, plane};
use slicecast::plan::Plan;
use slicecast::plane::{ChannelOf, Pipeline, Rows, clear, scratch_len};
use slicecast::slice::{RowRange, Slice, SliceError, Window};
use slicecast::stream::{Memory, Needs, Stream, StreamError, base_pixel};
use slicecast::tap::{NoTap, Tap};

use crate::camera::{CameraError, Setup, set_up};
use crate::occupancy::Sight;
use crate::oriented::{Oriented, packed, with_slices};
pub(crate) use crate::picture::picture;
use crate::pipelines::{Job, compile, dispatch};
use crate::scene::Scene;
use crate::simd::{OverLanes, Simd, prefetch, with_lanes};
use crate::table::Table;
use crate::volume::Volume;

/// Rows of the base plane that one thread takes through all slices at a time.
pub const TILE_ROWS: usize = 32;

/// Why a frame was not rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The scene does not fit the pipeline.
    #[error("{0}")]
    Camera(#[from] CameraError),
    /// The volume is not one.
    #[error("the volume: {0}")]
    Volume(#[from] SliceError),
    /// The stream layer refused a slice.
    #[error("the stream: {0}")]
    Stream(#[from] StreamError),
    /// The base plane would be too large.
    #[error("the base-plane image would take {bytes} bytes; accepted: at most {limit}")]
    Memory {
        /// What it would take.
        bytes: u64,
        /// What this program allows.
        limit: u64,
    },
    /// A projection has no integral.
    #[error("a projection keeps one sample a ray; the converged integral is that of a composited scene")]
    Projection,
    /// The threads could not be started.
    #[error("the threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// The largest base-plane image that is rendered, bytes.
const IMAGE_BYTES_MAX: u64 = 4 << 30;

/// The base-plane image of a frame, all phases interleaved, as raw bits of the precision's channels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BaseImage {
    /// Pixels across and down.
    pub size: [usize; 2],
    /// The channel's format: its name, and the bits of 1.0.
    pub format: &'static str,
    /// See [`BaseImage::format`].
    pub one: u32,
    /// Red, green, blue and transparency, row after row.
    pub planes: [Vec<u32>; 4],
}

/// An 8-bit RGB picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgb {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Red, green, blue, pixel after pixel.
    pub bytes: Vec<u8>,
}

/// A rendered frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// What the pipeline made.
    pub base: BaseImage,
    /// What the viewer sees.
    pub picture: Rgb,
}

/// A scene on a volume, ready to be rendered.
#[derive(Clone, Debug)]
pub struct Prepared<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The volume.
    pub volume: &'a Volume,
    /// Geometry, picture and lights.
    pub setup: Setup,
    /// The table.
    pub table: Table,
    /// Which vectors fold tiles.
    pub simd: Simd,
}

/// How slices reach the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// The plane layer on the volume in memory, in tiles of this many rows.
    Tiles(usize),
    /// The stream layer, one slice at a time on one thread.
    Stream,
}

impl<'a> Prepared<'a> {
    /// Prepares a scene.
    ///
    /// # Errors
    /// [`RenderError::Camera`] if the scene does not fit the pipeline.
    pub fn new(scene: &'a Scene, volume: &'a Volume) -> Result<Self, RenderError> {
        let setup = set_up(scene, volume)?;
        Ok(Self {
            table: compile(scene, &volume.mapping, setup.step_length),
            scene,
            volume,
            setup,
            simd: Simd::widest(),
        })
    }

    /// The same, with these vectors.
    #[must_use]
    pub fn with_simd(self, simd: Simd) -> Self {
        Self { simd, ..self }
    }

    /// Does a job with this scene's pipeline.
    ///
    /// # Errors
    /// [`RenderError::Camera`] if the setup's material has been changed to one that the pipeline does not take.
    pub fn dispatch<J: Job>(&self, job: J) -> Result<J::Output, RenderError> {
        let material = self.setup.material.as_ref();
        Ok(dispatch(self.scene, &self.table, material, job).map_err(CameraError::from)?)
    }

    /// Renders the frame. `progress` is told how many steps of how many are done (tiles, or slices of a stream).
    ///
    /// # Errors
    /// [`RenderError`]; nothing is rendered then.
    pub fn render(&self, layer: Layer, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<Frame, RenderError> {
        with_slices(self.volume, self.setup.plan.view(), |slices| {
            self.render_oriented(&Oriented::of(slices), layer, progress)
        })?
    }

    /// Renders the frame from a volume that has been turned for a view along the same axis and direction.
    ///
    /// # Errors
    /// As [`Prepared::render`].
    pub fn render_oriented(
        &self,
        volume: &Oriented<'_>,
        layer: Layer,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Frame, RenderError> {
        self.dispatch(Render {
            prepared: self,
            volume,
            layer,
            progress,
        })?
    }
}

struct Render<'a> {
    prepared: &'a Prepared<'a>,
    volume: &'a Oriented<'a>,
    layer: Layer,
    progress: &'a (dyn Fn(usize, usize) + Sync),
}

impl Job for Render<'_> {
    type Output = Result<Frame, RenderError>;

    fn run<L: Pipeline>(self, pipeline: &L) -> Self::Output {
        let plan = &self.prepared.setup.plan;
        let mut image = new_image::<L>(plan)?;
        match self.layer {
            Layer::Tiles(rows) => {
                let simd = self.prepared.simd;
                fold_oriented(plan, pipeline, self.volume, &mut image, rows, simd, self.progress);
            }
            Layer::Stream => stream_tapped(
                plan,
                pipeline,
                self.volume.slices,
                &mut image,
                self.progress,
                &mut NoTap,
            )?,
        }
        Ok(Frame {
            base: base_image(plan, pipeline, &image),
            picture: picture(self.prepared, pipeline, &image),
        })
    }
}

/// An untouched base-plane image.
///
/// # Errors
/// [`RenderError::Memory`] before anything too large is allocated.
pub fn new_image<L: Pipeline>(plan: &Plan) -> Result<Vec<L::Element>, RenderError> {
    let needs = Needs::of::<L>(plan);
    let bytes = needs.image as u64 * needs.element_bytes as u64;
    if bytes > IMAGE_BYTES_MAX {
        return Err(RenderError::Memory {
            bytes,
            limit: IMAGE_BYTES_MAX,
        });
    }
    let mut image = vec![L::empty(0); needs.image];
    clear::<L>(plan, &mut image);
    Ok(image)
}

/// Some rows of one phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Number of the phase.
    pub phase: u32,
    /// First row.
    pub first: u32,
    /// Number of rows.
    pub rows: u32,
}

/// Folds all planes into an image, tile by tile on rayon's current threads: rows as a whole, or, where the volume's blocks
/// are known and few of them can be seen, those blocks.
pub fn fold_oriented<L: Pipeline>(
    plan: &Plan,
    pipeline: &L,
    volume: &Oriented<'_>,
    image: &mut [L::Element],
    tile_rows: usize,
    simd: Simd,
    progress: &(dyn Fn(usize, usize) + Sync),
) {
    let slices = volume.slices;
    let Some(sight) = volume.sight(plan, pipeline, simd) else {
        return fold_tiles(plan, pipeline, slices, image, tile_rows, simd, progress);
    };
    each_tile::<L, ()>(plan, image, tile_rows, progress, |tile, data, scratch| {
        scratch.resize(scratch.len().max(L::SEEN_SCRATCH), 0);
        let fold = FoldTile {
            plan,
            pipeline,
            slices,
            how: Blocks(&sight),
            tile,
            data,
            scratch,
        };
        with_lanes(simd, fold);
    });
}

/// Folds all planes into an image, tile by tile on rayon's current threads, rows as a whole.
pub fn fold_tiles<L: Pipeline>(
    plan: &Plan,
    pipeline: &L,
    slices: &[Slice<'_>],
    image: &mut [L::Element],
    tile_rows: usize,
    simd: Simd,
    progress: &(dyn Fn(usize, usize) + Sync),
) {
    each_tile::<L, ()>(plan, image, tile_rows, progress, |tile, data, scratch| {
        let fold = FoldTile {
            plan,
            pipeline,
            slices,
            how: Whole(&mut NoTap),
            tile,
            data,
            scratch,
        };
        with_lanes(simd, fold);
    });
}

/// Folds all planes into an image like [`fold_tiles`], by the scalar definitions, each tile under a tap of its own.
/// Returns the taps in the order of the tiles, which does not depend on the number of threads.
pub fn fold_tiles_tapped<L: Pipeline, T: Tap + Send>(
    plan: &Plan,
    pipeline: &L,
    slices: &[Slice<'_>],
    image: &mut [L::Element],
    tile_rows: usize,
    progress: &(dyn Fn(usize, usize) + Sync),
    tap: impl Fn(Tile) -> T + Sync,
) -> Vec<T> {
    each_tile::<L, T>(plan, image, tile_rows, progress, |tile, data, scratch| {
        let mut tap = tap(tile);
        let fold = FoldTile {
            plan,
            pipeline,
            slices,
            how: Whole(&mut tap),
            tile,
            data,
            scratch,
        };
        fold.run::<i32>();
        tap
    })
}

/// The tiles of an image whose rows have `row_len` elements, and what each holds: the same rows of all phases one after the
/// other, because they read the same voxels, which are still near.
pub(crate) fn tiles<'i, E>(
    plan: &Plan,
    image: &'i mut [E],
    row_len: usize,
    tile_rows: usize,
) -> Vec<(Tile, &'i mut [E])> {
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

/// Does something with every tile of an image, in parallel; its results phase by phase, row by row.
fn each_tile<L: Pipeline, R: Send>(
    plan: &Plan,
    image: &mut [L::Element],
    tile_rows: usize,
    progress: &(dyn Fn(usize, usize) + Sync),
    work: impl Fn(Tile, &mut [L::Element], &mut Vec<i32>) -> R + Sync,
) -> Vec<R> {
    let [base_width, _] = plan.base();
    let [slice_width, _, _] = plan.dims();
    let tiles = tiles(plan, image, L::CHANNELS * base_width as usize, tile_rows);
    let (total, phases) = (tiles.len(), plan.phases() as usize);
    let tiles_per_phase = total / phases;
    let done = std::sync::atomic::AtomicUsize::new(0);
    // Each on its own: how long it takes depends on what it sees.
    let mut results: Vec<Option<R>> = tiles
        .into_par_iter()
        .with_max_len(1)
        .map_init(
            // Room for rows that begin with a line of the cache.
            || vec![0; scratch_len::<L>(slice_width + 32)],
            |scratch, (tile, data)| {
                let result = work(tile, data, scratch);
                progress(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1, total);
                Some(result)
            },
        )
        .collect();
    let by_phase = (0..total).map(|place| place % tiles_per_phase * phases + place / tiles_per_phase);
    by_phase.filter_map(|place| results.get_mut(place)?.take()).collect()
}

/// Folds all planes into the rows of a tile by the scalar definitions, under a tap. `scratch` holds at least
/// [`scratch_len`] words.
pub fn fold_tile<L: Pipeline, T: Tap>(
    plan: &Plan,
    pipeline: &L,
    slices: &[Slice<'_>],
    tile: Tile,
    data: &mut [L::Element],
    scratch: &mut [i32],
    tap: &mut T,
) {
    let fold = FoldTile {
        plan,
        pipeline,
        slices,
        how: Whole(tap),
        tile,
        data,
        scratch,
    };
    fold.run::<i32>();
}

/// How many slices ahead of a plane memory is asked for.
pub(crate) const AHEAD: i32 = 3;

/// After how many planes a tile is asked whether its rays are all finished.
const FINISHED_EVERY: u32 = 16;

/// How the planes of a tile are folded.
trait How<L: Pipeline> {
    /// Folds the plane at a slice, or between it and the next.
    fn fold<V: Lanes>(&mut self, pipeline: &L, at: At<'_>, rows: Rows<'_, L::Element>, scratch: &mut [i32]);
    /// Whether no further plane can change these rows.
    fn finished<V: Lanes>(&self, pipeline: &L, plan: &Plan, data: &[L::Element]) -> bool;
}

/// A plane and what is around it.
struct At<'a> {
    plan: &'a Plan,
    plane: Plane,
    slice: usize,
    window: Window<'a>,
}

/// Rows as a whole, under a tap, which sees every plane: finished rows are left out one by one.
struct Whole<'t, T>(&'t mut T);

/// The blocks that can be seen.
struct Blocks<'a>(&'a Sight);

impl<L: Pipeline, T: Tap> How<L> for Whole<'_, T> {
    #[inline(always)]
    fn fold<V: Lanes>(&mut self, pipeline: &L, at: At<'_>, rows: Rows<'_, L::Element>, scratch: &mut [i32]) {
        pipeline.fold::<V, T>(at.plan, &at.plane, &at.window, rows, scratch, self.0);
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, _: &L, _: &Plan, _: &[L::Element]) -> bool {
        false
    }
}

impl<L: Pipeline> How<L> for Blocks<'_> {
    #[inline(always)]
    fn fold<V: Lanes>(&mut self, pipeline: &L, at: At<'_>, rows: Rows<'_, L::Element>, scratch: &mut [i32]) {
        pipeline.fold_seen::<V>(at.plan, &at.plane, &at.window, self.0.at(at.slice), rows, scratch);
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, pipeline: &L, plan: &Plan, data: &[L::Element]) -> bool {
        pipeline.finished::<V>(plan, data)
    }
}

/// A tile on its way through all planes.
struct FoldTile<'a, 's, L: Pipeline, H> {
    plan: &'a Plan,
    pipeline: &'a L,
    slices: &'a [Slice<'s>],
    how: H,
    tile: Tile,
    data: &'a mut [L::Element],
    scratch: &'a mut [i32],
}

impl<L: Pipeline, H: How<L>> FoldTile<'_, '_, L, H> {
    /// Asks for the rows of a slice that a tile will read: those under its own rows, shifted by `offset`, and those that
    /// gradients look at beyond.
    #[inline(always)]
    fn prefetch(&self, slice: &Slice<'_>, offset: i32) {
        let first = (i64::from(self.tile.first) + i64::from(offset)).max(1) as usize;
        for row in first - 1..(first + self.tile.rows as usize + 2).min(slice.height()) {
            prefetch(slice.row(row));
        }
    }
}

impl<L: Pipeline, H: How<L>> OverLanes for FoldTile<'_, '_, L, H> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes>(mut self) {
        let slice = |z: i32| usize::try_from(z).ok().and_then(|z| self.slices.get(z)).copied();
        let planes = self.plan.planes();
        let mut ahead = None;
        for step in 0..planes {
            let index = if L::BACK_TO_FRONT { planes - 1 - step } else { step };
            let plane = plane(self.plan, self.plan.phase(self.tile.phase), index);
            let z = cell(plane.z).index;
            let wanted = if L::BACK_TO_FRONT { z - AHEAD } else { z + AHEAD };
            if ahead != Some(wanted) {
                ahead = Some(wanted);
                if let Some(slice) = slice(wanted) {
                    self.prefetch(&slice, cell(plane.y).index);
                }
            }
            if let Some(window) = Window::at(z, slice) {
                let rows = Rows {
                    first: self.tile.first,
                    data: &mut *self.data,
                };
                let at = At {
                    plan: self.plan,
                    plane,
                    slice: z as usize,
                    window,
                };
                self.how.fold::<V>(self.pipeline, at, rows, self.scratch);
            }
            if step % FINISHED_EVERY == 0 && self.how.finished::<V>(self.pipeline, self.plan, self.data) {
                break;
            }
        }
    }
}

/// Renders through the stream layer under a tap.
///
/// # Errors
/// [`StreamError`] if a slice is refused.
pub fn stream_tapped<L: Pipeline>(
    plan: &Plan,
    pipeline: &L,
    slices: &[Slice<'_>],
    image: &mut [L::Element],
    progress: &(dyn Fn(usize, usize) + Sync),
    tap: &mut impl Tap,
) -> Result<(), StreamError> {
    let needs = Needs::of::<L>(plan);
    let (mut ring, mut ranges) = (vec![0; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let mut scratch = vec![0; needs.scratch];
    let memory = Memory {
        slices: &mut ring,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image,
    };
    let mut stream = Stream::new(*plan, pipeline, memory)?;
    let mut pushed = 0;
    while let Some(wanted) = stream.wanted() {
        let slice = slices.get(wanted as usize).ok_or(StreamError::Complete)?;
        stream.push(&packed(slice), tap)?;
        pushed += 1;
        progress(pushed, slices.len());
    }
    Ok(())
}

/// The base-plane image with its phases interleaved.
pub fn base_image<L: Pipeline>(plan: &Plan, pipeline: &L, image: &[L::Element]) -> BaseImage {
    let n = plan.sampling().rays_per_voxel as usize;
    let size = plan.base().map(|side| side as usize * n);
    let mut planes = [(); 4].map(|()| Vec::with_capacity(size[0] * size[1]));
    for v in 0..size[1] {
        for u in 0..size[0] {
            let pixel = base_pixel(plan, pipeline, image, u as i64, v as i64);
            for (plane, c) in planes.iter_mut().zip(pixel.colour) {
                plane.push(c.bits());
            }
            planes[3].push(pixel.transparency.bits());
        }
    }
    BaseImage {
        size,
        format: ChannelOf::<L::Precision>::NAME,
        one: ChannelOf::<L::Precision>::ONE.bits(),
        planes,
    }
}

/// The scene's background, 1.15.
pub fn background(scene: &Scene) -> [Intensity; 3] {
    scene
        .image
        .background
        .map(|c| Intensity::from_bits((c * 32768.0).round() as u16))
}

/// Runs `work` on this many threads; `None` uses all processors.
///
/// # Errors
/// [`RenderError::Threads`] if they cannot be started.
pub fn on_threads<R: Send>(threads: Option<usize>, work: impl FnOnce() -> R + Send) -> Result<R, RenderError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()?;
    Ok(pool.install(work))
}
