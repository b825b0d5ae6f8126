//! Volumes of colour and extinction beside the f64 model, on the same voxels.

use slicecast_colours::Coloured;
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Layer;
use slicecast_engine::image::{Frame, Rgb};
use slicecast_engine::progress::Progress;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_model::{Absorbing, Affine, Geometry, Interpolated, Lattice, ModelImage, Positions};
use slicecast_scene::{Interpolation, Sampling};

use crate::image::{ImageFigures, base_figures, model_figures, model_picture, picture_figures};
use crate::{ModelPositions, pipeline_positions};

/// What a comparison found.
#[derive(Clone, Debug)]
pub struct ColourComparison {
    /// Errors of the base-plane image.
    pub image: ImageFigures,
    /// Errors of the viewer's 8-bit picture against the model's own, warped in f64.
    pub picture: ImageFigures,
    /// The pipeline's frame.
    pub frame: Frame,
    /// The model's base-plane image.
    pub model: ModelImage,
}

/// The model of a prepared scene, on the pipeline's lattice of rays.
pub fn model<'a>(prepared: &Coloured<'a>, positions: ModelPositions) -> Absorbing<'a> {
    sampled(prepared, positions, prepared.scene.sampling)
}

/// The same at another rate of planes.
fn sampled<'a>(prepared: &Coloured<'a>, positions: ModelPositions, sampling: Sampling) -> Absorbing<'a> {
    let Coloured {
        scene, volume, setup, ..
    } = prepared;
    let (plan, volume) = (setup.plan, *volume);
    let n = plan.sampling().rays_per_voxel as usize;
    let lattice = Lattice {
        origin: plan.origin().map(i64::from),
        size: plan.base().map(|side| side as usize * n),
    };
    let forward = scene.view.axes().forward;
    let geometry = Geometry::new(forward, volume.dims, volume.spacing, sampling).with_borders(scene.borders);
    let geometry = match scene.crop {
        None => geometry,
        Some(crop) => geometry.with_crop(crop.faces(volume.spacing)),
    };
    let positions = match positions {
        ModelPositions::Exact => Positions::Exact,
        ModelPositions::Pipeline => Positions::Given(Box::new(pipeline_positions(plan))),
    };
    let [nx, ny, _] = volume.dims;
    let voxel = move |[x, y, z]: [usize; 3]| volume.voxels.codes(x + nx * (y + ny * z)).map(|code| volume.tau(code));
    let mut model = Absorbing::new(geometry, lattice, positions, voxel)
        .with_nearest(scene.interpolation == Interpolation::Nearest)
        .with_quadratic(scene.interpolation == Interpolation::Quadratic)
        .with_clips(&scene.clips);
    if let Some(lighting) = &scene.lighting {
        model = model.with_lighting(lighting, &scene.view.axes());
    }
    if let Some(cueing) = &scene.cueing {
        model = model.with_cueing(cueing, forward);
    }
    model
}

/// Compares a scene's pipeline with the model.
///
/// # Errors
/// [`RenderError`] if the scene cannot be rendered.
pub fn compare_colours(
    prepared: &Coloured<'_>,
    positions: ModelPositions,
    progress: Progress<'_>,
) -> Result<ColourComparison, RenderError> {
    let frame = prepared.render(Layer::Tiles(TILE_ROWS), progress)?;
    let model = model(prepared, positions).render();
    let picture = warped(prepared, &model);
    Ok(ColourComparison {
        image: base_figures(&frame.base, &model),
        picture: picture_figures(&frame.picture, &picture, prepared.scene.image.background),
        frame,
        model,
    })
}

/// A base-plane image of the model as the scene's picture shows it.
fn warped(prepared: &Coloured<'_>, base: &ModelImage) -> ModelImage {
    let [origin, right, down] = prepared.setup.picture.affine;
    let map = Affine {
        u: [origin[0], right[0], down[0]],
        v: [origin[1], right[1], down[1]],
    };
    base.warp(prepared.setup.picture.size.map(|side| side as usize), map)
}

/// The picture of a scene in f64, with something else interpolated.
pub fn picture_of(prepared: &Coloured<'_>, interpolated: Interpolated) -> Rgb {
    let base = model(prepared, ModelPositions::Pipeline)
        .with_interpolated(interpolated)
        .render();
    model_picture(&warped(prepared, &base), prepared.scene.image.background)
}

/// Ways to sample a volume, in f64, all of a scene's planes but the reference, which is extinctions at [`CONVERGED`] planes a voxel.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct SamplingComparison {
    /// Opacities against extinctions.
    pub apart: ImageFigures,
    /// Extinctions against the reference.
    pub extinctions: ImageFigures,
    /// Opacities against the reference.
    pub opacities: ImageFigures,
}

/// Planes a voxel of the reference.
pub const CONVERGED: u32 = 16;

/// Compares a way of sampling with that by extinctions.
pub fn compare_sampling(prepared: &Coloured<'_>, interpolated: Interpolated) -> SamplingComparison {
    let of = |planes_per_voxel, interpolated| {
        let sampling = Sampling {
            planes_per_voxel,
            ..prepared.scene.sampling
        };
        let model = sampled(prepared, ModelPositions::Exact, sampling);
        model.with_interpolated(interpolated).render()
    };
    let planes = prepared.scene.sampling.planes_per_voxel;
    let [extinctions, opacities] = [Interpolated::Extinctions, interpolated].map(|way| of(planes, way));
    let converged = of(CONVERGED, Interpolated::Extinctions);
    SamplingComparison {
        apart: model_figures(&opacities, &extinctions),
        extinctions: model_figures(&extinctions, &converged),
        opacities: model_figures(&opacities, &converged),
    }
}
