//! What of a scene the pipeline cannot take.

use std::ops::RangeInclusive;

use slicecast::clip::ClipError;
use slicecast::perspective::EyeError;
use slicecast::plan::PlanError;
use slicecast::screen::PICTURE_SIDE_MAX;
use slicecast::shade::PhongError;
use slicecast::shade::map::MapError;
use slicecast::view::ViewError;
use slicecast_scene::check::shown;

/// Distances between voxels: lengths of steps and pixels are computed from them, and must be numbers too.
pub const SPACING: RangeInclusive<f64> = 1e-100..=1e100;

/// How many times as long as the shortest distance the longest may be: beyond, a spacing factor would be 0.
pub const SPACING_RATIO_MAX: f64 = 32768.0;

/// A scene that the pipeline cannot take.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// The viewing direction.
    #[error("the view: {0}")]
    View(#[from] ViewError),
    /// Sizes and sampling rates.
    #[error("the sampling: {0}")]
    Plan(#[from] PlanError),
    /// Distances between voxels.
    #[error(
        "a voxel spacing of {}; accepted: {} to {} along each axis, none more than {SPACING_RATIO_MAX} times another",
        .spacing.map(shown).join(" x "), shown(*SPACING.start()), shown(*SPACING.end())
    )]
    Spacing {
        /// The spacing given, in its own unit.
        spacing: [f64; 3],
    },
    /// A view in perspective, where rays are parallel.
    #[error(
        "this command draws parallel views, and the scene is in perspective ([view] projection); expected a scene without --fov and --eye"
    )]
    InPerspective,
    /// The eye of a view in perspective.
    #[error("the view in perspective: {0}")]
    Eye(#[from] EyeError),
    /// An additive projection in perspective of a volume of few steps.
    #[error(
        "an additive projection in perspective of a volume whose diagonal is {diagonal} long; \
         expected eight steps or more, {eight}: take more planes per voxel"
    )]
    Additive {
        /// The volume's diagonal.
        diagonal: f64,
        /// Eight steps along the facet's axis.
        eight: f64,
    },
    /// Clip planes.
    #[error("the clip planes: {0}")]
    Clip(#[from] ClipError),
    /// Lights and material.
    #[error("the lighting: {0}")]
    Lighting(#[from] PhongError),
    /// A reflectance map.
    #[error("the lighting: {0}")]
    Reflectance(#[from] MapError),
    /// A picture of more pixels than this program makes.
    #[error("a picture of {width} x {height} pixels; accepted: 1 to {PICTURE_SIDE_MAX} along each side")]
    Picture {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
}
