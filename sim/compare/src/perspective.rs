//! Views in perspective against the f64 model, at exact positions: the base planes of all frames about the eye, and the picture.

use super::image::{ImageFigures, base_figures, picture_figures};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Layer;
use slicecast_engine::image::Frame;
use slicecast_engine::perspective::{Facet, InPerspective};
use slicecast_engine::tile::TILE_ROWS;
use slicecast_model::perspective::{FromEye, Screen};
use slicecast_model::{ModelImage, Pixel};
use slicecast_scene::Scene;
use slicecast_volume::Volume;

/// What a comparison found.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Errors of the base planes, together.
    pub image: ImageFigures,
    /// Errors of the viewer's 8-bit picture against the model's own, mixed in f64.
    pub picture: ImageFigures,
    /// The pipeline's frame.
    pub frame: Frame,
    /// The model's picture.
    pub model_picture: ModelImage,
}

/// The image of a facet's rays as the model states it; `None` of a plan of parallel rays.
pub fn screen(facet: &Facet<'_>) -> Option<Screen> {
    let plan = &facet.prepared.setup.plan;
    let spread = facet.spread()?;
    Some(Screen {
        axis: facet.axis(),
        flipped: plan.view().reversed(),
        eye: spread.eye().map(|c| c.to_bits() as f64 / 4294967296.0),
        first: spread.first().map(i64::from),
        size: plan.base().map(|side| side as usize),
        per_voxel: spread.rays_per_voxel() as usize,
    })
}

/// Compares a view in perspective with the model.
///
/// # Errors
/// [`RenderError`] if the scene cannot be rendered.
pub fn compare(
    scene: &Scene,
    volume: &Volume,
    prepared: &InPerspective<'_>,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Comparison, RenderError> {
    let bases = prepared.bases(Layer::Tiles(TILE_ROWS), progress)?;
    let screens = prepared.facets.iter().filter_map(screen);
    let models: Vec<ModelImage> = screens
        .map(|screen| FromEye::new(scene, volume, screen).render())
        .collect();
    let figures: Vec<_> = (bases.iter().zip(&models))
        .map(|(base, model)| base_figures(base, model))
        .collect();
    let frame = prepared.frame(&bases);
    let size = prepared.camera.size.map(|side| side as usize);
    let model_picture = ModelImage::from_fn(size, |x, y| match prepared.point(x as u32, y as u32) {
        Some((place, [u, v])) => models[place].bilinear(u, v),
        None => Pixel::TRANSPARENT,
    });
    Ok(Comparison {
        image: ImageFigures::together(&figures),
        picture: picture_figures(&frame.picture, &model_picture, scene.image.background),
        frame,
        model_picture,
    })
}
