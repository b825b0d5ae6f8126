//! What is not rendered in several levels.

use std::time::Duration;

use slicecast::plan::{LEVEL_MAX, LevelError};

/// What is not rendered in several levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LevelsError {
    /// Borders that levels do not share.
    #[error(
        "several levels have the borders of their voxels' cells, and the scene asks for others; expected --borders cells"
    )]
    Borders,
    /// The largest or least value of a ray.
    #[error(
        "a projection keeps one sample a ray, which no mean of voxels is; expected a composited scene (--blend front-to-back)"
    )]
    Projection,
    /// Surfaces, of which some would be missed at a face.
    #[error(
        "isosurfaces have gaps where two levels meet, because their values differ there; expected a scene without surfaces"
    )]
    Surfaces,
    /// Clip planes and depth cueing, which a plan of each level would need.
    #[error(
        "several levels have neither clip planes nor depth cueing, and the scene has them ([[clip]], [cueing]); expected a scene without"
    )]
    Clipped,
    /// Modulation, whose gradients differ between levels.
    #[error(
        "two levels have different gradients where they meet, and the scene weighs them ([modulation]); expected a scene without"
    )]
    Modulated,
    /// Labels.
    #[error("labels have no mean; expected --interpolation linear, and a volume that is no label map")]
    Nearest,
    /// Splines, which reach across the borders of levels.
    #[error("splines reach across the borders of levels; expected --interpolation linear")]
    Splines,
    /// Samples or segments, chosen by how much neighbouring voxels differ.
    #[error("--classification auto would choose for each level; accepted with several levels: point, integral")]
    Automatic,
    /// A box that ends within a voxel of its level.
    #[error(
        "a box of level {level} from voxel {from} to {to}; expected faces at whole voxels of its level, or of the volume"
    )]
    Face {
        /// The level.
        level: u32,
        /// First voxel of the volume.
        from: usize,
        /// The one behind its last.
        to: usize,
    },
    /// A cut that leaves nothing on one side.
    #[error("a cut at voxel {at} of a box from {from} to {to}; expected one within it")]
    Cut {
        /// Where it is.
        at: usize,
        /// First voxel of the node.
        from: usize,
        /// The one behind its last.
        to: usize,
    },
    /// Not even the coarsest level fits in memory.
    #[error(
        "within {memory} bytes of memory: the image and all of the volume at level {LEVEL_MAX} take {least}; expected at least as much, or fewer --rays"
    )]
    Budget {
        /// Bytes given.
        memory: u64,
        /// Bytes needed.
        least: u64,
    },
    /// Not even the coarsest level is fast enough.
    #[error(
        "within {} ms: a frame of all of the volume at level {LEVEL_MAX} takes {} ms here; expected at least as long, fewer --rays or a smaller --size",
        .time.as_millis(), .least.as_millis()
    )]
    Time {
        /// The time given.
        time: Duration,
        /// What was measured.
        least: Duration,
    },
    /// A level that there is not.
    #[error("{0}")]
    Level(#[from] LevelError),
}
