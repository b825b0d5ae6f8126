//! A frame of colour and extinction stated in integers, and its way through the pipeline.

use slicecast::absorption::Medium;
use slicecast::borders::Borders;
use slicecast::clip::{Clip, Cue};
use slicecast::crop::Crop;
use slicecast::format::Direction;
use slicecast::plan::{Plan, PlanError, Sampling, Spacing};
use slicecast::view::View;
use slicecast_colours::Coloured;
use slicecast_engine::camera::{Material, Setup};
use slicecast_engine::simd::Simd;
use slicecast_pyramid::volume::{RgbaVolume, Voxels};
use slicecast_scene::{Interpolation, PrecisionName, Scene, file};
use slicecast_volume::decoded::Orientation;

use crate::frame::{ADDITIVE, clips, picture};
use crate::random::{Filling, Random, volume};

/// Everything that decides a frame's bits.
#[derive(Clone, Debug)]
pub struct ColourFrame {
    /// The voxels.
    pub volume: RgbaVolume,
    /// Viewing direction in voxel units, any scale; each component within +-2^30.
    pub direction: [i64; 3],
    /// Planes a voxel.
    pub planes_per_voxel: u32,
    /// Rays a voxel along a side.
    pub rays_per_voxel: u32,
    /// Number formats: compact or wide.
    pub precision: PrecisionName,
    /// Where the volume ends.
    pub borders: Borders,
    /// The box that the volume is cropped to.
    pub crop: Option<Crop>,
    /// Clip planes.
    pub clips: Vec<Clip>,
    /// Depth cueing.
    pub cue: Option<Cue>,
    /// Lights in the slice frame; `None` is unlit.
    pub material: Option<Material>,
    /// Whether samples are made by splines.
    pub quadratic: bool,
    /// M and N of the scale of extinctions.
    pub medium: [u32; 2],
    /// Threshold of early termination.
    pub early_termination: Option<u32>,
}

impl ColourFrame {
    /// A frame straight along +z, one sample a voxel, of a step whose largest optical depth is 4.
    pub fn new(volume: RgbaVolume) -> Self {
        Self {
            volume,
            direction: [0, 0, 1],
            planes_per_voxel: 1,
            rays_per_voxel: 1,
            precision: PrecisionName::Compact,
            borders: Borders::Whole,
            crop: None,
            clips: Vec::new(),
            cue: None,
            material: None,
            quadratic: false,
            // 4 · 2^28 / 32767 · 2^15.
            medium: [1_073_774_593, 15],
            early_termination: None,
        }
    }

    /// The frame's plan.
    ///
    /// # Errors
    /// [`PlanError`] if core refuses the sampling.
    ///
    /// # Panics
    /// If the direction is none.
    pub fn plan(&self) -> Result<Plan, PlanError> {
        let view = View::new(self.direction.map(|c| Direction::from_bits(c << 28))).expect("a direction");
        let dims = self.volume.dims.map(|side| side as u32);
        let sampling = Sampling {
            planes_per_voxel: self.planes_per_voxel,
            rays_per_voxel: self.rays_per_voxel,
        };
        let plan = Plan::with_borders(view, dims, Spacing::CUBIC, sampling, self.borders)?;
        self.crop.map_or(Ok(plan), |crop| plan.with_crop(crop))
    }

    /// Gives the prepared frame to `run`.
    ///
    /// # Panics
    /// If core refuses the frame: tests state frames that it takes.
    pub fn with_prepared<R>(&self, run: impl FnOnce(&Coloured<'_>) -> R) -> R {
        let plan = self.plan().expect("a frame that has a plan");
        let scene = Scene {
            precision: self.precision,
            early_termination: self.early_termination,
            interpolation: if self.quadratic {
                Interpolation::Quadratic
            } else {
                Interpolation::Linear
            },
            ..file::parse("[colours]", "colours").expect("a scene")
        };
        let [mantissa, exponent] = self.medium;
        run(&Coloured {
            scene: &scene,
            volume: &self.volume,
            setup: Setup {
                picture: picture(&plan),
                material: self.material.clone(),
                step_length: 1.0,
                additive: ADDITIVE,
                spread: None,
                clips: clips(&plan, &self.clips, self.cue.as_ref()),
                plan,
            },
            medium: Medium::new(mantissa, exponent).expect("a scale"),
            simd: Simd::widest(),
        })
    }
}

/// A volume of entries: extinctions by a filling, whose codes' high bytes are the roots, colours on their own where `colours` is
/// a seed, else white.
pub fn colour_volume(dims: [usize; 3], filling: Filling, seed: u64, colours: Option<u64>) -> RgbaVolume {
    let roots = volume(dims, filling, seed);
    let mut random = colours.map(Random::new);
    let entry = |code: &u16| {
        let [red, green, blue, _] = random
            .as_mut()
            .map_or([255; 4], |random| (random.next_bits() as u32).to_le_bytes());
        [red, green, blue, (code >> 4) as u8]
    };
    RgbaVolume {
        name: roots.name.clone(),
        dims,
        spacing: [1.0; 3],
        orientation: Orientation::Unknown,
        tau_max: 4.0,
        alpha_distance: None,
        voxels: Voxels::Entries(roots.voxels.iter().map(entry).collect()),
    }
}
