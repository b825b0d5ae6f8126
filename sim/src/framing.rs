//! How large a picture is, at which scale, and how densely the volume is sampled for the picture to be sharp.
//!
//! All pictures of a turn have one size and one scale: those at which the view that reaches farthest fits. A picture is
//! sharp if its pixels are not smaller than the rays are apart. Planes follow the pixels, too, down to a quarter of the
//! shortest side of a voxel: the eye sees steps along the ray less than steps across it.

use slicecast_engine::camera::{PICTURE_SIDE_MAX, Shape, extent, fitting_pixel, plan, size_at, view};
use slicecast_engine::error::RenderError;
use slicecast_scene::check::{PLANES_PER_VOXEL, RAYS_PER_VOXEL};
use slicecast_scene::{Sampling, Scene};

/// Pixels along the longer side of a picture of no stated size, at least.
pub const LONGER_SIDE_MIN: u32 = 512;

/// Samples of a frame that sharpness alone may ask for: some seconds' work.
const SAMPLES_MAX: u64 = 1 << 32;

/// Rays that a pixel may lack without being blurred to the eye.
const RAYS_TOLERANCE: f64 = 0.05;

/// What the command line fixes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stated {
    /// Pixels across and down.
    pub size: Option<[u32; 2]>,
    /// Whether the rays per voxel are the scene's, whatever the size.
    pub rays: bool,
    /// Whether the planes per voxel are.
    pub planes: bool,
}

/// One size, scale and sampling for all views of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Framing {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// How densely the volume is sampled.
    pub sampling: Sampling,
    /// How far the volume reaches in any of the views, across and up.
    reach: [f64; 2],
}

impl Framing {
    /// Frames a scene that is seen from all these sides (scenes that differ in nothing but the view).
    ///
    /// # Errors
    /// [`RenderError::Camera`] if a view or the volume's shape is not one that the pipeline takes.
    pub fn of(scenes: &[Scene], volume: impl Into<Shape>, stated: Stated) -> Result<Self, RenderError> {
        let volume = volume.into();
        let reach = scenes.iter().fold([0.0; 2], |[across, high]: [f64; 2], scene| {
            let [a, h] = extent(scene, volume.dims, volume.spacing);
            [across.max(a), high.max(h)]
        });
        let mut framing = Self {
            size: [1; 2],
            sampling: scenes.first().map_or_else(Sampling::default, |scene| scene.sampling),
            reach,
        };
        let size = stated.size.or_else(|| scenes.first()?.image.size);
        framing.size = size.unwrap_or_else(|| framing.roomy(volume));
        let wanted = scenes.iter().try_fold(framing.sampling, |sampling, scene| {
            let needed = framing.sharp(scene, volume)?;
            Ok::<_, RenderError>(Sampling {
                planes_per_voxel: sampling.planes_per_voxel.max(needed.planes_per_voxel),
                rays_per_voxel: sampling.rays_per_voxel.max(needed.rays_per_voxel),
            })
        })?;
        if !stated.planes {
            framing.sampling.planes_per_voxel = wanted.planes_per_voxel;
        }
        if !stated.rays {
            let least = framing.sampling.rays_per_voxel;
            framing.sampling.rays_per_voxel = wanted.rays_per_voxel;
            while framing.sampling.rays_per_voxel > least && framing.samples(scenes, volume)? > SAMPLES_MAX {
                framing.sampling.rays_per_voxel -= 1;
            }
        }
        Ok(framing)
    }

    /// The scene in this frame.
    #[must_use]
    pub fn scene(&self, scene: &Scene, volume: impl Into<Shape>) -> Scene {
        let volume = volume.into();
        let mut framed = scene.clone();
        // A view that reaches less far is not magnified until it fills the picture.
        let own = fitting_pixel(extent(scene, volume.dims, volume.spacing), self.size);
        framed.image.zoom *= own / fitting_pixel(self.reach, self.size);
        framed.image.size = Some(self.size);
        framed.sampling = self.sampling;
        framed
    }

    /// A pixel for every ray of the scene's own sampling, and not too small a picture.
    fn roomy(&self, volume: Shape) -> [u32; 2] {
        let [across, high] = self.reach;
        let finest = shortest(volume) / f64::from(self.sampling.rays_per_voxel);
        let coarsest = across.max(high) / f64::from(LONGER_SIDE_MIN - 1);
        if finest <= coarsest {
            return size_at(self.reach, finest);
        }
        // Slightly larger pixels, so that rounding does not make the longer side longer.
        size_at(self.reach, coarsest * (1.0 + 1e-9)).map(|side| side.min(PICTURE_SIDE_MAX))
    }

    /// The sampling at which a view is sharp.
    fn sharp(&self, scene: &Scene, volume: Shape) -> Result<Sampling, RenderError> {
        let pixel = fitting_pixel(self.reach, self.size) / scene.image.zoom;
        let [i, j, k] = view(scene, volume.spacing)?.arrange(volume.spacing);
        let within = |wanted: f64, range: std::ops::RangeInclusive<i64>| {
            (wanted - RAYS_TOLERANCE)
                .ceil()
                .clamp(*range.start() as f64, *range.end() as f64) as u32
        };
        Ok(Sampling {
            planes_per_voxel: within(k / pixel.max(shortest(volume) / 4.0), PLANES_PER_VOXEL),
            rays_per_voxel: within(i.max(j) / pixel, RAYS_PER_VOXEL),
        })
    }

    /// The most samples that any of the views takes.
    fn samples(&self, scenes: &[Scene], volume: Shape) -> Result<u64, RenderError> {
        scenes.iter().try_fold(0, |most, scene| {
            let plan = plan(&self.scene(scene, volume), volume.dims, volume.spacing)?;
            let [width, height] = plan.base().map(u64::from);
            Ok(most.max(width * height * u64::from(plan.phases()) * plan.planes_met().len() as u64))
        })
    }
}

/// The shortest side of a voxel.
fn shortest(volume: Shape) -> f64 {
    volume.spacing.iter().copied().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_engine::camera::set_up;
    use slicecast_scene::file::{DEFAULT, built_in};
    use slicecast_volume::{Mapping, Volume};

    fn volume(dims: [usize; 3], spacing: [f64; 3]) -> Volume {
        Volume {
            name: "t".into(),
            dims,
            spacing,
            voxels: vec![0; dims.iter().product()],
            mapping: Mapping {
                scale: 1.0,
                offset: 0.0,
            },
        }
    }

    fn scene() -> Scene {
        let mut scene = built_in(DEFAULT).unwrap();
        scene.sampling = Sampling::default();
        scene
    }

    #[test]
    fn a_small_volume_fills_a_large_picture_sharply() {
        let volume = volume([64, 64, 93], [3.2, 3.2, 1.5]);
        let framing = Framing::of(&[scene()], &volume, Stated::default()).unwrap();
        assert_eq!(framing.size.iter().max(), Some(&512));
        let scene = framing.scene(&scene(), &volume);
        let [_, right, _] = set_up(&scene, &volume).unwrap().picture.affine;
        // Base-plane pixels per picture pixel: not less than one ray apart.
        assert!((0.9..1.8).contains(&right[0].hypot(right[1])), "{right:?}, {framing:?}");
        assert_eq!(scene.image.zoom, 1.0);
    }

    #[test]
    fn a_large_volume_keeps_its_own_size() {
        let volume = volume([600, 500, 400], [1.0; 3]);
        let framing = Framing::of(&[scene()], &volume, Stated::default()).unwrap();
        let own = set_up(&scene(), &volume).unwrap().picture.size;
        assert_eq!((framing.size, framing.sampling), (own, Sampling::default()));
    }

    #[test]
    fn what_is_stated_is_kept() {
        let volume = volume([64; 3], [1.0; 3]);
        let stated = Stated {
            size: Some([1000, 100]),
            rays: true,
            planes: false,
        };
        let framing = Framing::of(&[scene()], &volume, stated).unwrap();
        assert_eq!((framing.size, framing.sampling.rays_per_voxel), ([1000, 100], 1));
        let stated = Stated { rays: false, ..stated };
        let small = Framing::of(&[scene()], &volume, stated).unwrap();
        let stated = Stated {
            size: Some([1000, 1000]),
            ..stated
        };
        let large = Framing::of(&[scene()], &volume, stated).unwrap();
        assert!(
            small.sampling.rays_per_voxel < 3 && large.sampling.rays_per_voxel == 8,
            "{small:?}, {large:?}"
        );
    }

    /// A pixel is as long in all views of a turn.
    #[test]
    fn a_turn_has_one_scale() {
        let volume = volume([40, 20, 30], [1.0, 2.0, 1.5]);
        let turn: Vec<Scene> = (0..8)
            .map(|eighth| {
                let mut scene = scene();
                scene.view = scene.view.turned(45.0 * f64::from(eighth));
                scene.image.zoom = 1.5;
                scene
            })
            .collect();
        for size in [None, Some([300, 200])] {
            let stated = Stated {
                size,
                ..Stated::default()
            };
            let framing = Framing::of(&turn, &volume, stated).unwrap();
            let expected = fitting_pixel(framing.reach, framing.size) / 1.5;
            for scene in &turn {
                let framed = framing.scene(scene, &volume);
                let own = extent(&framed, volume.dims, volume.spacing);
                let pixel = fitting_pixel(own, framing.size) / framed.image.zoom;
                assert!((pixel / expected - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn sharpness_alone_does_not_ask_for_hours() {
        let volume = volume([700, 700, 8], [0.1, 0.1, 5.0]);
        let stated = Stated {
            size: Some([16000, 16000]),
            ..Stated::default()
        };
        let framing = Framing::of(&[scene()], &volume, stated).unwrap();
        assert!(framing.samples(&[scene()], (&volume).into()).unwrap() <= SAMPLES_MAX);
    }
}
