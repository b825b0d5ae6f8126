//! The pipeline against the f64 model, stage by stage and picture by picture.

pub mod colours;
pub mod exchange;
pub mod explain;
pub mod fast;
pub mod image;
pub mod lockstep;
pub mod perspective;
pub mod splat;
pub mod stages;
pub mod statistics;

use std::sync::atomic::{AtomicUsize, Ordering};

use slicecast::borders::Borders;
use slicecast::locate::plane;
use slicecast::plan::{Phase, Plan};
use slicecast::slice::Slice;

use fast::FastLockstep;
use image::{ImageFigures, base_figures, picture_figures};
use lockstep::{Lockstep, position, segment_ends};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::Frame;
use slicecast_engine::oriented::Turned;
use slicecast_engine::rendering::{Framing, tapped};
use slicecast_engine::tile::TILE_ROWS;
use slicecast_engine::tile::Tile;
use slicecast_engine::{with_pixel, with_precision};
use slicecast_model::{Affine, Lattice, Model, ModelImage, Pixel, Positions, Segments};
use slicecast_scene::{Blend, PrecisionName};
use stages::{StageErrors, StageReport};

/// Which positions the model takes its samples at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelPositions {
    /// The pipeline's own 16.16 numbers: what remains is the error of the arithmetic behind location.
    Pipeline,
    /// The real ones.
    Exact,
}

/// What a comparison found.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Errors of the base-plane image.
    pub image: ImageFigures,
    /// Errors of the viewer's 8-bit picture against the model's own, warped in f64.
    pub picture: ImageFigures,
    /// Errors stage by stage.
    pub stages: Vec<StageReport>,
    /// The pipeline's frame.
    pub frame: Frame,
    /// The model's base-plane image.
    pub model: ModelImage,
    /// The model's picture.
    pub model_picture: ModelImage,
}

/// The error of the pipeline split: what its arithmetic adds to the algorithm, what a table of segments leaves out, and what
/// the algorithm itself (steps, planes, border) is away from the converged integral.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Split {
    /// The pipeline against the f64 model of the same algorithm.
    pub arithmetic: ImageFigures,
    /// That model against the f64 segments of the transfer function as it is written; `None` where samples are classified.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<ImageFigures>,
    /// That model, or those segments, against the converged integral.
    pub algorithm: ImageFigures,
    /// The pipeline against the converged integral.
    pub both: ImageFigures,
}

/// Splits the error of a comparison; both references are taken at exact positions. `progress` is told how many rows of
/// how many are done.
///
/// # Errors
/// [`RenderError`] if the scene is a projection, which integrates nothing, or modulates the opacities of steps, which have no integral.
pub fn split(
    prepared: &Prepared<'_>,
    comparison: &Comparison,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Split, RenderError> {
    if !prepared.scene.blend.is_composited() {
        return Err(RenderError::Projection);
    }
    prepared.check_unmodulated()?;
    let exact = model(prepared, ModelPositions::Exact);
    let size = exact.lattice().size;
    let begun = AtomicUsize::new(0);
    let written =
        (prepared.segments.is_some()).then(|| model(prepared, ModelPositions::Exact).with_segments(Segments::Exact));
    let images = if written.is_some() { 3 } else { 2 };
    let image = |pixel: &(dyn Fn(usize, usize) -> Pixel + Sync)| {
        ModelImage::from_fn(size, |u, v| {
            if u == 0 {
                progress(begun.fetch_add(1, Ordering::Relaxed), images * size[1]);
            }
            pixel(u, v)
        })
    };
    let (discrete, converged) = (image(&|u, v| exact.ray(u, v)), image(&|u, v| exact.integral(u, v)));
    let written = written.map(|written| image(&|u, v| written.ray(u, v)));
    Ok(Split {
        arithmetic: base_figures(&comparison.frame.base, &discrete),
        table: written.as_ref().map(|written| image::model_figures(&discrete, written)),
        algorithm: image::model_figures(written.as_ref().unwrap_or(&discrete), &converged),
        both: base_figures(&comparison.frame.base, &converged),
    })
}

/// Compares a scene's pipeline with the model.
///
/// # Errors
/// [`RenderError`] if the scene cannot be rendered.
pub fn compare(
    prepared: &Prepared<'_>,
    positions: ModelPositions,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Comparison, RenderError> {
    let plan = &prepared.setup.plan;
    let model = model(prepared, positions);
    beside(
        prepared,
        &model,
        &Turned::new(prepared.volume, plan).slices()?,
        progress,
    )
}

/// The model of a prepared scene: its own geometry from the scene's real numbers, on the pipeline's lattice of rays.
pub fn model<'a>(prepared: &Prepared<'a>, positions: ModelPositions) -> Model<'a> {
    let plan = prepared.setup.plan;
    let n = plan.sampling().rays_per_voxel as usize;
    let lattice = Lattice {
        origin: plan.origin().map(i64::from),
        size: plan.base().map(|side| side as usize * n),
    };
    let cut = prepared.segments.is_some() && plan.borders() != Borders::Whole;
    let positions = match positions {
        ModelPositions::Exact => Positions::Exact,
        ModelPositions::Pipeline if cut => Positions::GivenEnds(Box::new(pipeline_ends(plan))),
        ModelPositions::Pipeline => Positions::Given(Box::new(pipeline_positions(plan))),
    };
    let segments = match &prepared.segments {
        Some(_) => Segments::Binned,
        None => Segments::Not,
    };
    Model::new(prepared.scene, prepared.volume, lattice, positions).with_segments(segments)
}

/// Phase of a full-resolution pixel, and its column and row there.
fn pixel(plan: &Plan, u: usize, v: usize) -> (Phase, [u32; 2]) {
    let n = plan.sampling().rays_per_voxel as usize;
    let phase = Phase {
        u: (u % n) as u32,
        v: (v % n) as u32,
    };
    (phase, [(u / n) as u32, (v / n) as u32])
}

/// The pipeline's positions as a function of plane and full-resolution pixel.
pub(crate) fn pipeline_positions(plan: Plan) -> impl Fn(usize, usize, usize) -> [f64; 3] + Send + Sync {
    move |index, u, v| {
        let (phase, pixel) = pixel(&plan, u, v);
        let at = plane(&plan, phase, index as u32);
        position(&plan, [at.x, at.y, at.z], pixel)
    }
}

/// Both ends of its segments, alike.
fn pipeline_ends(plan: Plan) -> impl Fn(usize, usize, usize) -> [[f64; 3]; 2] + Send + Sync {
    move |index, u, v| {
        let (phase, pixel) = pixel(&plan, u, v);
        segment_ends(&plan, phase, index as u32, pixel)
    }
}

/// The pipeline beside the model.
fn beside(
    prepared: &Prepared<'_>,
    model: &Model<'_>,
    slices: &[Slice<'_>],
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Comparison, RenderError> {
    let plan = &prepared.setup.plan;
    let [width, _] = plan.base();
    let rays = plan.sampling().rays_per_voxel;
    let mut rendering = prepared.begun()?;
    let precision = prepared.scene.precision;
    let (setup, blend) = (&prepared.setup, prepared.scene.blend);
    let locksteps = if precision == PrecisionName::Fast {
        let tap = |tile: Tile| FastLockstep::new(model, setup, blend, tile);
        let taps = tapped(&mut *rendering, slices, TILE_ROWS, progress, tap);
        taps.into_iter().map(|tap| tap.lockstep).collect()
    } else {
        let tap = |tile: Tile| with_precision!(precision, p => Lockstep::new(p, model, setup, blend, tile));
        tapped(&mut *rendering, slices, TILE_ROWS, progress, tap)
    };
    let mut errors = StageErrors::default();
    let mut pixels = Tiles::new(model.lattice().size, width as usize, rays as usize);
    for lockstep in locksteps {
        let (tile, tile_errors, tile_pixels) = lockstep.finish();
        errors.merge(&tile_errors);
        pixels.place(plan, tile, &tile_pixels);
    }
    let model_image = match prepared.scene.blend {
        Blend::FrontToBack | Blend::BackToFront => pixels.image(),
        // One value per ray decides: nothing to keep in step.
        Blend::Maximum | Blend::Minimum | Blend::Average | Blend::Additive => model.render(),
    };
    let stages = with_pixel!(precision, p => errors.report(p));
    Ok(compared(prepared, &*rendering, model_image, stages))
}

/// A rendering beside the model's image.
fn compared(
    prepared: &Prepared<'_>,
    rendering: &dyn Framing,
    model: ModelImage,
    stages: Vec<StageReport>,
) -> Comparison {
    let frame = Frame {
        base: rendering.base(),
        picture: rendering.picture(&prepared.shown()),
    };
    let [origin, right, down] = prepared.setup.picture.affine;
    let map = Affine {
        u: [origin[0], right[0], down[0]],
        v: [origin[1], right[1], down[1]],
    };
    let model_picture = model.warp(frame.picture.size.map(|side| side as usize), map);
    Comparison {
        image: base_figures(&frame.base, &model),
        picture: picture_figures(&frame.picture, &model_picture, prepared.scene.image.background),
        stages,
        frame,
        model,
        model_picture,
    }
}

/// The model's pixels, gathered from tiles of single phases.
pub struct Tiles {
    size: [usize; 2],
    width: usize,
    rays: usize,
    pixels: Vec<Pixel>,
}

impl Tiles {
    /// An image of this many pixels, from base planes of this width.
    pub fn new(size: [usize; 2], width: usize, rays: usize) -> Self {
        Self {
            size,
            width,
            rays,
            pixels: vec![Pixel::TRANSPARENT; size[0] * size[1]],
        }
    }

    /// Puts the pixels of a tile where they belong.
    pub fn place(&mut self, plan: &Plan, tile: Tile, pixels: &[Pixel]) {
        let phase = plan.phase(tile.phase);
        for (index, pixel) in pixels.iter().enumerate() {
            let u = index % self.width * self.rays + phase.u as usize;
            let v = (index / self.width + tile.first as usize) * self.rays + phase.v as usize;
            self.pixels[v * self.size[0] + u] = *pixel;
        }
    }

    /// The image.
    pub fn image(self) -> ModelImage {
        ModelImage::from_fn(self.size, |u, v| self.pixels[v * self.size[0] + u])
    }
}
