//! Why a frame is not rendered.

mod camera;
mod colours;
mod levels;

use slicecast::slice::SliceError;
use slicecast::splat::SplatError;
use slicecast::stream::StreamError;
use slicecast_volume::error::ReadError;

pub use self::camera::{CameraError, SPACING, SPACING_RATIO_MAX};
pub use self::colours::ColourError;
pub use self::levels::LevelsError;

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
    /// Between the slices along the view there is nothing to integrate.
    #[error(
        "the volume is one slice deep along the view, and segments lie between slices; use --classification point, or --borders cells"
    )]
    Segments,
    /// Segments where single samples are needed: the f64 model, exported scenes and vectors know no others.
    #[error(
        "this command classifies samples, and the scene asks for segments (render.classification = {asked}); use \
         --classification point, without surfaces"
    )]
    PointsOnly {
        /// The scene's setting, as a scene file has it.
        asked: &'static str,
    },
    /// A crop box, where the whole volume is needed: exported vectors know no box.
    #[error("this command knows the whole volume, and the scene has a crop box ([crop]); expected a scene without one")]
    Cropped,
    /// Clip planes or depth cueing, where they are not known.
    #[error(
        "this command knows neither clip planes nor depth cueing, and the scene has them ([[clip]], [cueing]); expected a scene without"
    )]
    Clipped,
    /// Modulation, where it is not known.
    #[error(
        "this command knows no modulation by the gradient's magnitude, and the scene has one ([modulation]); expected a scene without"
    )]
    Modulated,
    /// A reflectance map, where light is computed.
    #[error(
        "this command knows no reflectance maps, and the scene looks its light up in one ([reflectance]); expected a scene without"
    )]
    Mapped,
    /// 16-bit lanes, where the stages of 32-bit lanes are known.
    #[error(
        "this command knows the stages of paper, compact and wide, and the scene asks for 16-bit lanes (render.precision = \"fast\"); \
         use --precision compact"
    )]
    Fast,
    /// Segments in 16-bit lanes.
    #[error(
        "precision \"fast\" classifies samples, and the scene asks for segments; use --classification point, without surfaces"
    )]
    FastSegments,
    /// Splines, where samples are linear.
    #[error(
        "this command knows no samples by splines, and the scene asks for them (sampling.interpolation = \"quadratic\"); use \
         --interpolation linear"
    )]
    Splines,
    /// Sums of samples, where single ones are known.
    #[error(
        "this command knows projections that keep a sample, and the scene sums samples up (render.blend average or additive); \
         expected maximum or minimum, or a composited scene"
    )]
    Summed,
    /// A volume of colours, and a scene that asks for what there is not.
    #[error("{0}")]
    Colours(#[from] ColourError),
    /// A projection has no integral.
    #[error("a projection keeps one sample a ray; the converged integral is that of a composited scene")]
    Projection,
    /// Not even the image and a few rows of the slices around a plane fit.
    #[error(
        "within {memory} bytes of memory: the image and a few rows of the slices around a plane take {least}; expected at least as much, \
         or fewer --rays"
    )]
    Budget {
        /// Bytes given.
        memory: u64,
        /// Bytes needed.
        least: u64,
    },
    /// Several levels, and a scene or a cut that asks for what there is not.
    #[error("{0}")]
    Levels(#[from] LevelsError),
    /// Splatting, and a number that is out of range.
    #[error("splatting: {0}")]
    Splat(#[from] SplatError),
    /// Splatting, and a scene that asks for what there is not.
    #[error("splatting knows other scenes: {field} is given, expected {expected}")]
    Unsplattable {
        /// The scene's setting, as a scene file has it.
        field: &'static str,
        /// What splatting knows.
        expected: &'static str,
    },
    /// Records of too many voxels.
    #[error("splatting: records of the voxels would take {bytes} bytes; accepted: at most {limit}")]
    Records {
        /// What they would take.
        bytes: u64,
        /// What this program allows.
        limit: u64,
    },
    /// A part of the volume cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The threads could not be started.
    #[error("the threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}
