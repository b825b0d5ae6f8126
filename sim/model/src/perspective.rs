//! Rays from an eye, plane by plane.
//!
//! Source: equation 7 of the paper, as for parallel rays; what differs is where a ray lies on a plane, how long its steps are and where
//! its viewer is. Rays pass through the pixels of an image in the last slice of a frame (i, j, k) whose k is an axis of the volume:
//!
//! ```text
//! slope = ((first + (u, v)) / n - eye) / (D - 1 - eye_k)        voxels along i, j per voxel along k
//! place = eye + (plane / r - eye_k) slope
//! step  = |(slope_i sp_i, slope_j sp_j, sp_k)| / r              lengths
//! V     = -(slope_i sp_i, slope_j sp_j, sp_k) / |...|
//! ```

use super::classify::{Classified, Classifier};
use super::composite::Pixel;
use super::gradient::{difference_at, normalise, spacing_factors};
use super::grid::Grid;
use super::interpolate::value_at;
use super::rays::Geometry;
use super::shade::Lights;
use super::vector::{dot, scale};
use super::warp::ModelImage;
use slicecast_scene::{Blend, Scene};
use slicecast_volume::{Mapping, Volume};

/// The mean of some values; none of none.
fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    (count > 0.0).then_some(sum / count)
}

/// The image in the last slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screen {
    /// The axis of the volume (0 = x, 1 = y, 2 = z) that is k.
    pub axis: usize,
    /// Whether k runs against it.
    pub flipped: bool,
    /// The eye along i, j, k, voxels from the first one's centre.
    pub eye: [f64; 3],
    /// Where pixel (0, 0) lies, in pixels from the first voxel's centre.
    pub first: [i64; 2],
    /// Pixels along i and j.
    pub size: [usize; 2],
    /// Pixels per voxel.
    pub per_voxel: usize,
}

/// The f64 model of a scene seen from an eye.
pub struct FromEye<'a> {
    scene: &'a Scene,
    geometry: Geometry,
    screen: Screen,
    grid: Grid<'a>,
    spacing_factors: [f64; 3],
    mapping: Mapping,
    lights: Option<Lights>,
    /// Fraction bits of slopes; none: all.
    slope_bits: Option<u32>,
}

/// One ray.
struct Ray {
    /// Voxels along i and j per voxel along k.
    slope: [f64; 2],
    /// Length of a step.
    step: f64,
    /// Unit vector towards the eye.
    viewer: [f64; 3],
}

impl<'a> FromEye<'a> {
    /// The model of a scene: samples, composited, lit or not.
    ///
    /// # Panics
    /// As [`Model::new`](super::Model::new).
    pub fn new(scene: &'a Scene, volume: &'a Volume, screen: Screen) -> Self {
        let mut forward = [0.0; 3];
        forward[screen.axis] = if screen.flipped { -1.0 } else { 1.0 };
        let geometry = Geometry::new(forward, volume.dims, volume.spacing, scene.sampling);
        Self {
            grid: Grid::new(volume, &geometry),
            spacing_factors: spacing_factors(geometry.spacing),
            lights: (scene.lighting.as_ref()).map(|lighting| Lights::new(lighting, &scene.view.axes(), &geometry)),
            mapping: volume.mapping,
            slope_bits: None,
            scene,
            geometry,
            screen,
        }
    }

    /// The same with the slopes of rays to so many fraction bits, each to nearest: what the paper asks how many are needed of
    /// (section 4.6). Positions on planes are exact multiples of them.
    #[must_use]
    pub fn with_slope_bits(self, bits: u32) -> Self {
        Self {
            slope_bits: Some(bits),
            ..self
        }
    }

    /// The slopes of a pixel's ray along i and j, voxels per voxel along k.
    pub fn slope(&self, u: usize, v: usize) -> [f64; 2] {
        self.ray_of(u, v).slope
    }

    /// The frame's planes, axes and spacing.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    fn ray_of(&self, u: usize, v: usize) -> Ray {
        let Screen {
            eye, first, per_voxel, ..
        } = self.screen;
        let way = self.geometry.dims[2] as f64 - 1.0 - eye[2];
        let slope = [(0, u), (1, v)].map(|(axis, pixel)| {
            let place = (first[axis] + pixel as i64) as f64 / per_voxel as f64;
            let slope = (place - eye[axis]) / way;
            self.slope_bits.map_or(slope, |bits| {
                let one = f64::from(bits).exp2();
                (slope * one).round() / one
            })
        });
        let [pi, pj, pk] = self.geometry.spacing;
        let along = [slope[0] * pi, slope[1] * pj, pk];
        let length = dot(along, along).sqrt();
        Ray {
            slope,
            step: length / self.geometry.planes_per_voxel as f64,
            viewer: scale(along, -1.0 / length),
        }
    }

    /// Where the ray of a pixel meets a plane, unrounded and whether inside the volume or not.
    pub fn position(&self, plane: usize, u: usize, v: usize) -> [f64; 3] {
        self.place(&self.ray_of(u, v), plane)
    }

    fn place(&self, ray: &Ray, plane: usize) -> [f64; 3] {
        let z = plane as f64 / self.geometry.planes_per_voxel as f64;
        let [ei, ej, ek] = self.screen.eye;
        [ei + (z - ek) * ray.slope[0], ej + (z - ek) * ray.slope[1], z]
    }

    /// The planes whose steps lie in front of the eye as a whole.
    pub fn planes(&self) -> std::ops::Range<usize> {
        let rate = self.geometry.planes_per_voxel as f64;
        let first = (self.screen.eye[2] * rate + 0.5).ceil().max(0.0);
        first as usize..self.geometry.planes()
    }

    /// The pixel of one ray.
    pub fn ray(&self, u: usize, v: usize) -> Pixel {
        let ray = self.ray_of(u, v);
        let classifier = Classifier::new(&self.scene.transfer, self.mapping, ray.step);
        let lights = self.lights.as_ref().map(|lights| lights.seen_from(ray.viewer));
        let seen = |plane: usize| {
            let position = self.geometry.inside_tolerant(self.place(&ray, plane))?;
            let Classified { colour, opacity } = classifier.classify(value_at(&self.grid, position));
            if opacity == 0.0 {
                return None;
            }
            let shaded = lights.as_ref().map_or(colour, |lights| {
                let difference = difference_at(&self.grid, position);
                let gradient = [0, 1, 2].map(|axis| difference[axis] * self.spacing_factors[axis]);
                lights.shade(normalise(gradient), colour)
            });
            Some((shaded, opacity))
        };
        let values = || {
            self.planes().filter_map(|plane| {
                let position = self.geometry.inside_tolerant(self.place(&ray, plane))?;
                Some(value_at(&self.grid, position))
            })
        };
        let shown = match self.scene.blend {
            Blend::FrontToBack | Blend::BackToFront => None,
            Blend::Maximum => Some(values().reduce(f64::max)),
            Blend::Minimum => Some(values().reduce(f64::min)),
            Blend::Average => Some(mean(values())),
            // What the ray sums up, over the volume's diagonal.
            Blend::Additive => {
                let sum = values().map(|value| value * ray.step).reduce(|a, b| a + b);
                Some(sum.map(|sum| (sum / self.geometry.diagonal()).min(4095.0)))
            }
        };
        if let Some(shown) = shown {
            return shown.map_or(Pixel::TRANSPARENT, |value| {
                let Classified { colour, opacity } = classifier.as_written(value);
                Pixel::of_sample(colour, opacity)
            });
        }
        if self.scene.blend == Blend::BackToFront {
            let planes = self.planes().rev().filter_map(seen);
            return planes.fold(Pixel::TRANSPARENT, |pixel, (colour, opacity)| {
                pixel.back_to_front(colour, opacity)
            });
        }
        let planes = self.planes().filter_map(seen);
        planes.fold(Pixel::TRANSPARENT, |pixel, (colour, opacity)| {
            pixel.front_to_back(colour, opacity)
        })
    }

    /// The whole image, rows in parallel.
    pub fn render(&self) -> ModelImage {
        ModelImage::from_fn(self.screen.size, |u, v| self.ray(u, v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Model;
    use crate::testing::{scene_along, volume_of};
    use slicecast_scene::{Lighting, Sampling};

    /// Fog of one value: what is left of the light depends on the length of the ray in the volume alone.
    #[test]
    fn fog_is_as_thick_as_rays_are_long() {
        let mut scene = scene_along([0.0, 0.0, -1.0], &[(0.0, 0.02)]);
        scene.sampling = Sampling {
            planes_per_voxel: 4,
            rays_per_voxel: 2,
        };
        let mut volume = volume_of([9, 11, 13], |_, _, _| 3000);
        volume.spacing = [1.0, 0.8, 1.5];
        let screen = Screen {
            axis: 2,
            flipped: true,
            eye: [4.0, 5.5, -20.0],
            first: [8 - 2, 11 - 2],
            size: [5, 5],
            per_voxel: 2,
        };
        let model = FromEye::new(&scene, &volume, screen);
        for (u, v) in (0..5).flat_map(|u| (0..5).map(move |v| (u, v))) {
            let ray = model.ray_of(u, v);
            // Each of 49 planes stands for a step; all lie in the volume.
            let length = 49.0 * ray.step;
            let left = model.ray(u, v).transparency;
            assert!((left - 0.98f64.powf(length)).abs() < 1e-12, "{u} {v}: {left}");
            assert!((dot(ray.viewer, ray.viewer) - 1.0).abs() < 1e-12);
        }
        assert!(model.ray_of(4, 4).step > model.ray_of(2, 2).step);
    }

    /// Of one value the largest, the smallest and the mean are that value; the sum is as much of it as the ray's steps are of the diagonal.
    #[test]
    fn projections_of_one_value_are_closed_forms() {
        let mut scene = scene_along([0.0, 0.0, -1.0], &[(0.0, 0.0), (4095.0, 1.0)]);
        scene.sampling.planes_per_voxel = 2;
        let volume = volume_of([9, 11, 13], |_, _, _| 3000);
        let screen = Screen {
            axis: 2,
            flipped: true,
            eye: [4.0, 5.5, -20.0],
            first: [3, 4],
            size: [3, 3],
            per_voxel: 1,
        };
        let diagonal = f64::from(9 * 9 + 11 * 11 + 13 * 13).sqrt();
        for blend in [Blend::Maximum, Blend::Minimum, Blend::Average, Blend::Additive] {
            scene.blend = blend;
            let model = FromEye::new(&scene, &volume, screen);
            for (u, v) in (0..3).flat_map(|u| (0..3).map(move |v| (u, v))) {
                // 25 planes lie in the volume.
                let share = match blend {
                    Blend::Additive => 25.0 * model.ray_of(u, v).step / diagonal,
                    _ => 1.0,
                };
                let left = model.ray(u, v).transparency;
                assert!(
                    (1.0 - left - share * 3000.0 / 4095.0).abs() < 1e-12,
                    "{blend:?} {u} {v}: {left}"
                );
            }
        }
    }

    /// From afar rays are parallel, lit or not.
    #[test]
    fn from_afar_rays_are_parallel() {
        let volume = volume_of([9, 8, 7], |x, y, z| (x * 401 + y * 97 * (z % 3) + z * 211) % 4096);
        let mut scene = scene_along([0.0, 1.0, 0.0], &[(0.0, 0.0), (4095.0, 0.4)]);
        for lighting in [None, Some(Lighting::default())] {
            scene.lighting = lighting;
            let parallel = Model::natural(&scene, &volume);
            let geometry = *parallel.geometry();
            let [columns, rows, _] = geometry.dims;
            let screen = Screen {
                axis: geometry.major(),
                flipped: geometry.flipped,
                eye: [4.0, 3.0, -1e8],
                first: [0; 2],
                size: [columns, rows],
                per_voxel: 1,
            };
            let model = FromEye::new(&scene, &volume, screen);
            let mut worst: f64 = 0.0;
            for (u, v) in (1..columns - 1).flat_map(|u| (1..rows - 1).map(move |v| (u, v))) {
                let (a, b) = (parallel.ray(u, v), model.ray(u, v));
                let parts = a.colour.into_iter().zip(b.colour).map(|(a, b)| (a - b).abs());
                worst = parts.fold(worst.max((a.transparency - b.transparency).abs()), f64::max);
            }
            assert!(worst < 1e-6, "{worst}");
        }
    }

    #[test]
    fn planes_begin_half_a_step_in_front_of_the_eye() {
        let scene = scene_along([1.0, 0.0, 0.0], &[(0.0, 1.0)]);
        let volume = volume_of([9, 5, 5], |_, _, _| 1);
        for (eye, first) in [(-3.0, 0), (-0.5, 0), (-0.49, 1), (2.0, 3), (2.5, 3), (2.51, 4)] {
            let screen = Screen {
                axis: 0,
                flipped: false,
                eye: [2.0, 2.0, eye],
                first: [0; 2],
                size: [5; 2],
                per_voxel: 1,
            };
            assert_eq!(FromEye::new(&scene, &volume, screen).planes(), first..9, "{eye}");
        }
    }
}
