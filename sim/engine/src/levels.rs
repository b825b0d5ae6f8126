//! Frames of volumes in boxes of several levels: some of the voxels themselves, some of voxels twice, four or eight times as long.
//!
//! After LaMar; `docs/contract/levels.md` has the formulas, and why no seam is seen. Each level has its own table or integrals, for steps as long
//! as its planes lie apart, and each box is folded after the other, in the order of the rays, into one base plane.

pub mod budget;
pub mod timed;
pub mod tree;

use std::borrow::Cow;
use std::fmt;
use std::ops::Range;

use slicecast::crop::Crop;
use slicecast::format::Position;
use slicecast::plan::{LEVEL_MAX, LevelError, Plan, PlanError, Rays};
use slicecast::slice::Slice;
use slicecast_pyramid::scalar::halved;
use slicecast_scene::{Blend, Borders, Classification, Interpolation, Scene, check};
use slicecast_volume::Volume;

use crate::bundle::Bundle;
use crate::camera;
use crate::error::RenderError;
use crate::error::{CameraError, LevelsError};
use crate::frame::Prepared;
use crate::image::Frame;
use crate::oriented::{Held, Oriented, Turned};
use crate::progress::Progress;
use crate::rendering::Framing;
use crate::source::SIDE;
use crate::source::Source;
use tree::{Leaf, Tree};

impl LevelsError {
    /// Refuses scenes that are not rendered in several levels.
    fn check(scene: &Scene) -> Result<(), Self> {
        match scene {
            Scene { borders, .. } if *borders != Borders::Cells => Err(Self::Borders),
            Scene { blend, .. } if !blend.is_composited() => Err(Self::Projection),
            Scene { surfaces, .. } if !surfaces.is_empty() => Err(Self::Surfaces),
            Scene { clips, cueing, .. } if !clips.is_empty() || cueing.is_some() => Err(Self::Clipped),
            Scene { modulation, .. } if modulation.is_some() => Err(Self::Modulated),
            Scene {
                interpolation: Interpolation::Nearest,
                ..
            } => Err(Self::Nearest),
            Scene {
                interpolation: Interpolation::Quadratic,
                ..
            } => Err(Self::Splines),
            Scene {
                classification: Classification::Auto,
                ..
            } => Err(Self::Automatic),
            _ => Ok(()),
        }
    }
}

/// Rows of level 0 that are read at a time for a coarser level: as many as of a brick.
const ROWS: usize = SIDE;

/// Voxels of a level, `dims` from `first` on. The volume has `all` of level 0.
fn voxels_of_level(
    source: &dyn Source,
    level: u32,
    all: [usize; 3],
    (first, dims): ([usize; 3], [usize; 3]),
) -> Result<Cow<'_, Volume>, RenderError> {
    if level == 0 {
        return source.voxels(first, dims);
    }
    // Some rows after the other: a level may stand for more voxels than there is room for.
    let [width, height, depth] = dims;
    let mut voxels = Vec::with_capacity(width * height * depth);
    let mut made = None;
    for z in first[2]..first[2] + depth {
        for y in (first[1]..first[1] + height).step_by(ROWS >> level) {
            let begin = [first[0], y, z].map(|voxel| voxel << level);
            let rows = (ROWS >> level).min(first[1] + height - y);
            let size = [width, rows, 1].map(|side| side << level);
            let size = [0, 1, 2].map(|axis| size[axis].min(all[axis] - begin[axis]));
            let mut piece = source.voxels(begin, size)?;
            for _ in 0..level {
                piece = Cow::Owned(halved(&piece));
            }
            voxels.extend_from_slice(&piece.voxels);
            made = Some(piece);
        }
    }
    let Some(piece) = made else {
        return source.voxels(first, dims);
    };
    Ok(Cow::Owned(Volume {
        name: piece.name.clone(),
        dims,
        voxels,
        ..*piece
    }))
}

/// A level of a scene.
struct Level {
    /// Its plan, of all its voxels.
    plan: Plan,
    /// Its pipeline.
    rendering: Box<dyn Framing>,
}

impl Level {
    fn of(scene: &Scene, volume: &Volume, level: u32) -> Result<Self, RenderError> {
        let scene = Scene {
            crop: None,
            ..scene.clone()
        };
        let shape = Volume {
            name: volume.name.clone(),
            dims: volume.dims.map(|side| side.div_ceil(1 << level)),
            spacing: volume.spacing.map(|side| side * f64::from(1 << level)),
            voxels: Vec::new(),
            mapping: volume.mapping,
        };
        let prepared = Prepared::new(&scene, &shape)?;
        Ok(Self {
            plan: prepared.setup.plan,
            rendering: prepared.rendering()?,
        })
    }
}

/// Codes of a volume.
const CODES: u32 = 4096;

/// The optical depth of a step, in halvings of the light, from which a table's opacity says too little of its parts.
const OPAQUE: f64 = 10.0;

/// Steps of samples that leave hardly any light, of which a face cuts no right part: `docs/contract/levels.md`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpaqueSteps {
    level: u32,
    /// The share of the light.
    left: f64,
    /// Planes per voxel at which steps are short enough.
    planes: f64,
}

impl fmt::Display for OpaqueSteps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { level, left, planes } = self;
        write!(
            f,
            "a step at level {level} leaves {left:.1e} of the light at most opacity, and parts of it at faces are drawn too opaque; "
        )?;
        if *planes <= *check::PLANES_PER_VOXEL.end() as f64 {
            write!(f, "--planes {planes} has shorter steps, ")?;
        }
        f.write_str("--classification integral needs none")
    }
}

/// The plan of a box, and the columns and rows of a phase of the base plane on which it can be seen.
type Planned = (Plan, [Range<u32>; 2]);

/// A box with its voxels.
#[derive(Clone, Debug)]
pub struct Brick {
    /// Which part of the volume it is.
    pub leaf: Leaf,
    /// The plan of its level, cropped to it.
    plan: Plan,
    /// First column and row of a phase of the base plane on which it can be seen, and how many.
    shadow: [Range<u32>; 2],
    /// What the plan holds.
    voxels: Volume,
}

impl Brick {
    /// Voxels of its level that it has: the first one, and how many along x, y and z.
    pub fn held(&self) -> ([usize; 3], [usize; 3]) {
        let Held { first, dims } = Held::of(&self.plan);
        (first, dims)
    }

    /// These voxels.
    pub const fn voxels(&self) -> &Volume {
        &self.voxels
    }

    /// Bytes of its voxels.
    pub fn bytes(&self) -> u64 {
        2 * self.voxels.voxels.len() as u64
    }

    /// Its rays, phase by phase; those of a phase that lie side by side in one of its voxels are bundles of their own.
    fn bundles(&self, finest: &Plan) -> Result<Vec<Bundle>, LevelError> {
        let [columns, rows] = &self.shadow;
        let stride = 1 << self.leaf.level;
        let mut bundles = Vec::new();
        for phase in (0..finest.phases()).map(|number| finest.phase(number)) {
            for (v, u) in (0..stride).flat_map(|v| (0..stride).map(move |u| (v, u))) {
                let first = [columns.start + u, rows.start + v];
                let [across, down] = [columns.end, rows.end];
                if first[0] >= across || first[1] >= down {
                    continue;
                }
                let count = [(across - first[0]).div_ceil(stride), (down - first[1]).div_ceil(stride)];
                let rays = Rays { phase, first, count };
                bundles.push(Bundle {
                    plan: self.plan.of_rays(finest, self.leaf.level, rays)?,
                    rays,
                    stride: stride as usize,
                });
            }
        }
        Ok(bundles)
    }
}

/// A scene on a volume in boxes of several levels, ready to be rendered.
pub struct Leveled<'a> {
    finest: &'a Prepared<'a>,
    levels: Vec<Level>,
    leaves: Vec<Leaf>,
}

impl<'a> Leveled<'a> {
    /// A scene whose volume is cut so, given what the finest level makes of it.
    ///
    /// # Errors
    /// [`RenderError::Levels`] for a scene that is not rendered so, a level above [`LEVEL_MAX`], and a cut that does not fit.
    pub fn new(finest: &'a Prepared<'a>, tree: &Tree) -> Result<Self, RenderError> {
        LevelsError::check(finest.scene)?;
        let direction = finest.setup.plan.view().direction();
        let back_to_front = finest.scene.blend == Blend::BackToFront;
        let rising = direction.map(|c| (c.to_bits() >= 0) != back_to_front);
        let leaves = tree.leaves(finest.volume.dims, rising)?;
        let coarsest = leaves.iter().map(|leaf| leaf.level).max().unwrap_or(0);
        if coarsest > LEVEL_MAX {
            return Err(LevelsError::from(LevelError::Level { given: coarsest }).into());
        }
        let levels = (0..=coarsest).map(|level| Level::of(finest.scene, finest.volume, level));
        Ok(Self {
            levels: levels.collect::<Result<_, _>>()?,
            leaves,
            finest,
        })
    }

    /// Samples whose steps at the coarsest level that is used leave hardly any light.
    pub fn opaque_steps(&self) -> Option<OpaqueSteps> {
        let (scene, volume) = (self.finest.scene, self.finest.volume);
        let level = self.leaves.iter().map(|leaf| leaf.level).max()?;
        if level == 0 || self.finest.segments.is_some() {
            return None;
        }
        let opacity = |code: u32| scene.transfer.evaluate(volume.mapping.value(f64::from(code))).1;
        // What is wholly opaque is so in any part of a step.
        let most = (0..CODES)
            .map(opacity)
            .filter(|opacity| *opacity < 1.0)
            .fold(0.0, f64::max);
        let step = self.finest.setup.step_length * f64::from(1 << level) / scene.transfer.unit_distance;
        let depth = -(1.0 - most).log2() * step;
        let times = (depth / OPAQUE).ceil();
        (times > 1.0).then(|| OpaqueSteps {
            level,
            left: (-depth).exp2(),
            planes: f64::from(scene.sampling.planes_per_voxel) * times,
        })
    }

    /// The boxes in the order of folding, those that the scene's crop box leaves something of, with their voxels. `progress` is told
    /// how many of how many are read.
    ///
    /// # Errors
    /// [`RenderError::Read`] if a file cannot be read any more.
    pub fn bricks(&self, source: &dyn Source, progress: Progress<'_>) -> Result<Vec<Brick>, RenderError> {
        let mut bricks = Vec::new();
        for (number, leaf) in self.leaves.iter().enumerate() {
            progress(number, self.leaves.len());
            let Some((plan, shadow)) = self.planned(leaf)? else {
                continue;
            };
            let Held { first, dims } = Held::of(&plan);
            let voxels = voxels_of_level(source, leaf.level, self.finest.volume.dims, (first, dims))?;
            bricks.push(Brick {
                leaf: leaf.clone(),
                plan,
                shadow,
                voxels: voxels.into_owned(),
            });
        }
        Ok(bricks)
    }

    /// The plan of a box on its level, and where it can be seen.
    fn planned(&self, leaf: &Leaf) -> Result<Option<Planned>, RenderError> {
        let finest = &self.finest.setup.plan;
        let cropped = |plan: Plan, crop: Crop| match plan.with_crop(crop) {
            Ok(plan) => Ok(Some(plan)),
            Err(PlanError::Beside { .. }) => Ok(None),
            Err(error) => Err(CameraError::from(error)),
        };
        let Some(seen) = cropped(*finest, faces(leaf, 0))? else {
            return Ok(None);
        };
        let shadow = [0, 1].map(|axis| {
            let all = finest.base()[axis];
            let first = (seen.origin()[axis] - finest.origin()[axis]).max(0) as u32;
            first.min(all)..(first + seen.base()[axis]).min(all)
        });
        let mut plan = cropped(self.levels[leaf.level as usize].plan, faces(leaf, leaf.level))?;
        if let (Some(of_box), Some(crop)) = (plan, camera::crop(self.finest.scene, self.finest.volume.spacing)) {
            plan = cropped(of_box, of_level(crop, leaf.level))?;
        }
        Ok(plan.map(|plan| (plan, shadow)))
    }

    /// Renders the frame. `progress` is told how many boxes of how many are folded.
    ///
    /// # Errors
    /// [`RenderError`]; nothing is rendered then.
    pub fn render(&self, bricks: &[Brick], progress: Progress<'_>) -> Result<Frame, RenderError> {
        let finest = &self.finest.setup.plan;
        let mut rendering = self.finest.begun()?;
        for (number, brick) in bricks.iter().enumerate() {
            progress(number, bricks.len());
            let bundles = brick.bundles(finest).map_err(LevelsError::from)?;
            let mut turned = Turned::whole(&brick.voxels, finest.view());
            let slices: Vec<Slice<'_>> = turned.slices()?;
            let level = &*self.levels[brick.leaf.level as usize].rendering;
            rendering.fold_bundles(level, &bundles, &Oriented::of(&slices), self.finest.simd);
        }
        progress(bricks.len(), bricks.len());
        Ok(Frame {
            base: rendering.base(),
            picture: rendering.picture(&self.finest.shown()),
        })
    }
}

/// The faces of a box in voxels of a level.
fn faces(leaf: &Leaf, level: u32) -> Crop {
    let face = |voxel: usize| Position::from_bits(((voxel << 16 >> level) as i32) - (1 << 15));
    Crop {
        low: leaf.voxels.each_ref().map(|side| face(side.start)),
        high: leaf.voxels.each_ref().map(|side| face(side.end)),
    }
}

/// A crop box of the volume in voxels of a level, to the 2^-16 voxel below.
fn of_level(crop: Crop, level: u32) -> Crop {
    let face = |face: Position| {
        let bits = ((i64::from(face.to_bits()) + (1 << 15)) >> level) - (1 << 15);
        Position::from_bits(bits.clamp(i32::MIN.into(), i32::MAX.into()) as i32)
    };
    Crop {
        low: crop.low.map(face),
        high: crop.high.map(face),
    }
}
