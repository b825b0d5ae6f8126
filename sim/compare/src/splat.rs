//! Splatted scenes against the f64 model, at exact places.

use super::image::{ImageFigures, base_figures, picture_figures};
use slicecast_engine::error::RenderError;
use slicecast_engine::image::Frame;
use slicecast_engine::perspective::Camera;
use slicecast_model::splat::{Rounding, Splat};
use slicecast_model::{Affine, ModelImage};
use slicecast_scene::Scene;
use slicecast_splat::Splatted;
use slicecast_volume::Volume;

/// What a comparison found.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Errors of the image.
    pub image: ImageFigures,
    /// Errors of the viewer's 8-bit picture against the model's own, warped in f64.
    pub picture: ImageFigures,
    /// The pipeline's frame.
    pub frame: Frame,
    /// The model's image.
    pub model: ModelImage,
}

/// The model's image of a scene that is splatted.
pub fn model(scene: &Scene, volume: &Volume, splatted: &Splatted<'_>, rounding: Rounding) -> ModelImage {
    let size = splatted.splatting.size().map(|side| side as usize);
    // The scene has been splatted: it has a camera.
    match scene
        .perspective
        .map(|seen| (seen.fov, Camera::of(scene, &seen, volume)))
    {
        Some((fov, Ok(camera))) => Splat::from_eye(scene, volume, size, (camera.eye, fov), rounding).render(),
        _ => Splat::new(scene, volume, size, rounding).render(),
    }
}

/// Compares a splatted scene with the model.
///
/// # Errors
/// [`RenderError`] if the scene cannot be rendered.
pub fn compare(
    scene: &Scene,
    volume: &Volume,
    splatted: &Splatted<'_>,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Comparison, RenderError> {
    let frame = splatted.render(progress)?;
    let model = model(scene, volume, splatted, Rounding::default());
    let [origin, right, down] = splatted.picture.affine;
    let size = splatted.picture.size.map(|side| side as usize);
    let along = |axis: usize| [origin[axis], right[axis], down[axis]];
    let warped = model.warp(
        size,
        Affine {
            u: along(0),
            v: along(1),
        },
    );
    Ok(Comparison {
        image: base_figures(&frame.base, &model),
        picture: picture_figures(&frame.picture, &warped, scene.image.background),
        frame,
        model,
    })
}
