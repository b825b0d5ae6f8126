//! Splatting into image-aligned sheets.
//!
//! Source: paper, section 4.6, and Mueller et al. 1999, as the project's convention has it: a quadratic B-spline along each axis of the
//! image, as wide as the voxels are spread there, integrated over the thickness of a sheet along z.
//!
//! ```text
//! w_a = sqrt(sum_m s_ma^2)        s_m: step of a voxel along axis m, in pixels, pixels and sheets
//! weight = b(dx / w_x) b(dy / w_y) int_(dz - 1/2)^(dz + 1/2) b(z / w_z) dz
//! sample = sum weight v / sum weight, where that is half of w_x w_y w_z / |det s| at least
//! ```
//!
//! The first sheet is the nearest that the nearest voxel reaches from in front. Gradients are differences of samples; a step is a sheet.
//!
//! From an eye, as `docs/contract/splatting-in-perspective.md` has it, all in sheets:
//!
//! ```text
//! x = phi X / Z                       phi: distance of the image, pixels
//! omega_a(b) = max(1, w_a phi / Z_b)  pixels; Z_b: the middle of the slab that the voxel lies in
//! sample where sum weight is half of max(Z_k / phi, w_x) max(Z_k / phi, w_y) w_z / |det s| at least
//! opacity = 1 - (1 - a)^|(x, y, 1)|   of the ray of slopes x, y
//! G = (dx phi / Z_k, dy phi / Z_k, dz - x G_x - y G_y)
//! ```

use super::classify::Classifier;
use super::composite::Pixel;
use super::gradient::normalise;
use super::rays::Geometry;
use super::shade::Lights;
use super::vector::dot;
use super::warp::ModelImage;
use rayon::prelude::*;
use slicecast_scene::{CameraAxes, Frame, Light, Lighting, Sampling, Scene};
use slicecast_volume::Volume;

/// Sheets that are made at a time.
const AT_A_TIME: usize = 16;

/// What is rounded of a voxel's record; without a number nothing is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rounding {
    /// Fraction bits of x and y.
    pub position: Option<u32>,
    /// Fraction bits of the depth, in sheets.
    pub depth: Option<u32>,
    /// Bits of the value, of 12.
    pub value: Option<u32>,
}

/// The f64 model of a scene whose voxels are splatted.
pub struct Splat<'a> {
    scene: &'a Scene,
    classifier: Classifier<'a>,
    lights: Option<Lights>,
    size: [usize; 2],
    /// Voxels by the whole part of their depth: x, y, depth, value.
    voxels: Vec<Vec<[f64; 4]>>,
    widths: [f64; 3],
    least: f64,
    /// Lengths of a pixel and of a sheet.
    lengths: [f64; 2],
    /// Where rays spread from; none where they are parallel.
    eye: Option<Eye>,
}

/// An eye before the middle of the image.
struct Eye {
    /// Distance of the image, pixels.
    distance: f64,
    /// The depth at which the first slab begins, sheets.
    near: f64,
    /// Whether voxels may lie in front of it.
    cut: bool,
    /// Volume of a voxel, cubes of a sheet's thickness.
    cell: f64,
}

impl Eye {
    /// Widths of kernels along x and y in a slab, pixels.
    fn pixels(&self, widths: [f64; 3], slab: usize) -> [f64; 2] {
        let middle = self.near + slab as f64 + 0.5;
        [widths[0], widths[1]].map(|width| (width * self.distance / middle).max(1.0))
    }

    /// Slopes of the ray of a pixel.
    fn slopes(&self, at: usize, size: [usize; 2]) -> [f64; 2] {
        [(at % size[0], size[0]), (at / size[0], size[1])]
            .map(|(pixel, side)| (pixel as f64 - (side as f64 - 1.0) / 2.0) / self.distance)
    }
}

/// A sheet's samples; NaN where there is none.
type Samples = Vec<f64>;

impl<'a> Splat<'a> {
    /// The model of a scene, composited front to back, in an image of this size in whose middle that of the volume is.
    pub fn new(scene: &'a Scene, volume: &'a Volume, size: [usize; 2], rounding: Rounding) -> Self {
        let axes = scene.view.axes();
        let shortest = volume.spacing.iter().copied().fold(f64::INFINITY, f64::min);
        let lengths = [
            shortest / f64::from(scene.sampling.rays_per_voxel),
            shortest / f64::from(scene.sampling.planes_per_voxel),
        ];
        let frame = [axes.right, axes.up.map(|c| -c), axes.forward];
        let units = [lengths[0], lengths[0], lengths[1]];
        // Of a voxel along axis m of the volume, along axis a of the image.
        let step = |m: usize, a: usize| frame[a][m] * volume.spacing[m] / units[a];
        let widths = [0, 1, 2].map(|a| (0..3).map(|m| step(m, a).powi(2)).sum::<f64>().sqrt());
        // Axes of the image are a rotation.
        let cell: f64 = volume.spacing.iter().product::<f64>() / units.iter().product::<f64>();
        let middle = volume.dims.map(|side| (side as f64 - 1.0) / 2.0);
        let behind = |a: usize, at: [f64; 3]| -> f64 { (0..3).map(|m| (at[m] - middle[m]) * step(m, a)).sum() };
        let nearest: f64 = -(0..3).map(|m| (middle[m] * step(m, 2)).abs()).sum::<f64>();
        let to = |number: f64, bits: Option<u32>| match bits {
            Some(bits) => (number * f64::from(bits).exp2() + 0.5).floor() / f64::from(bits).exp2(),
            None => number,
        };
        let mut voxels: Vec<Vec<[f64; 4]>> = vec![Vec::new(); (-2.0 * nearest).floor() as usize + 2];
        for (number, &code) in volume.voxels.iter().enumerate() {
            let [nx, ny, _] = volume.dims;
            let at = [number % nx, number / nx % ny, number / nx / ny].map(|c| c as f64);
            let place = |a: usize| to(behind(a, at) + (size[a] as f64 - 1.0) / 2.0, rounding.position);
            let depth = to((behind(2, at) - nearest).max(0.0), rounding.depth);
            let value = rounding.value.map_or(f64::from(code), |bits| {
                let steps = f64::from(bits).exp2() - 1.0;
                (f64::from(code) * steps / 4095.0).round() / steps * 4095.0
            });
            voxels[depth as usize].push([place(0), place(1), depth, value]);
        }
        Self {
            classifier: Classifier::new(&scene.transfer, volume.mapping, lengths[1]),
            lights: scene.lighting.as_ref().map(|lighting| lights(lighting, &axes)),
            least: widths.iter().product::<f64>() / cell / 2.0,
            scene,
            size,
            voxels,
            widths,
            lengths,
            eye: None,
        }
    }

    /// The model of a scene in perspective, whose eye lies so many voxels from the first along x, y, z and sees so many degrees from the
    /// upper to the lower edge of an image of this size.
    pub fn from_eye(
        scene: &'a Scene,
        volume: &'a Volume,
        size: [usize; 2],
        (eye, fov): ([f64; 3], f64),
        rounding: Rounding,
    ) -> Self {
        let axes = scene.view.axes();
        let shortest = volume.spacing.iter().copied().fold(f64::INFINITY, f64::min);
        let sheet = shortest / f64::from(scene.sampling.planes_per_voxel);
        let frame = [axes.right, axes.up.map(|c| -c), axes.forward];
        // In sheets, along each axis of the image.
        let place = |at: [f64; 3]| {
            frame.map(|axis| {
                (0..3)
                    .map(|m| (at[m] - eye[m]) * volume.spacing[m] * axis[m] / sheet)
                    .sum::<f64>()
            })
        };
        let widths = frame.map(|axis| {
            (0..3)
                .map(|m| (volume.spacing[m] * axis[m] / sheet).powi(2))
                .sum::<f64>()
                .sqrt()
        });
        let distance = size[1] as f64 * scene.image.zoom / (2.0 * (fov / 2.0).to_radians().tan());
        let corners = (0..8).map(|corner| {
            let at = [0, 1, 2].map(|m| {
                if corner >> m & 1 == 1 {
                    volume.dims[m] as f64 - 1.0
                } else {
                    0.0
                }
            });
            place(at)[2]
        });
        let (nearest, farthest) = corners.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), z| {
            (low.min(z), high.max(z))
        });
        let widest = widths[0].max(widths[1]);
        let least = (2.0 * widest).max(2.0).max(widest * distance / 128.0);
        let near = nearest.max(least);
        let to = |number: f64, bits: Option<u32>| match bits {
            Some(bits) => (number * f64::from(bits).exp2() + 0.5).floor() / f64::from(bits).exp2(),
            None => number,
        };
        let mut voxels: Vec<Vec<[f64; 4]>> = vec![Vec::new(); (farthest - near).max(0.0).floor() as usize + 2];
        for (number, &code) in volume.voxels.iter().enumerate() {
            let [nx, ny, _] = volume.dims;
            let [x, y, z] = place([number % nx, number / nx % ny, number / nx / ny].map(|c| c as f64));
            // The voxel that slabs begin at is in the first.
            let depth = z - near;
            if depth < -1e-6 {
                continue;
            }
            let depth = to(depth.max(0.0), rounding.depth);
            let across = |c: f64, side: usize| to(c * distance / z + (side as f64 - 1.0) / 2.0, rounding.position);
            let value = rounding.value.map_or(f64::from(code), |bits| {
                let steps = f64::from(bits).exp2() - 1.0;
                (f64::from(code) * steps / 4095.0).round() / steps * 4095.0
            });
            voxels[depth as usize].push([across(x, size[0]), across(y, size[1]), depth, value]);
        }
        let cell = volume.spacing.iter().product::<f64>() / sheet.powi(3);
        Self {
            classifier: Classifier::new(&scene.transfer, volume.mapping, sheet),
            lights: scene.lighting.as_ref().map(|lighting| lights(lighting, &axes)),
            least: f64::NAN,
            scene,
            size,
            voxels,
            widths,
            lengths: [sheet; 2],
            eye: Some(Eye {
                distance,
                near,
                cut: nearest < least,
                cell,
            }),
        }
    }

    /// The sum of weights from which on a sample of a sheet exists.
    fn least(&self, number: usize) -> f64 {
        let Some(eye) = &self.eye else { return self.least };
        let apart = self.apart(number);
        let [wx, wy, wz] = self.widths;
        apart.max(wx) * apart.max(wy) * wz / eye.cell / 2.0
    }

    /// Distance of the pixels of a sheet, sheets.
    fn apart(&self, number: usize) -> f64 {
        let Some(eye) = &self.eye else { return 1.0 };
        (eye.near + number as f64 + 1.0 - self.reach()) / eye.distance
    }

    /// The first sheet that no voxel is missing from.
    fn first(&self) -> usize {
        match &self.eye {
            Some(eye) if eye.cut => (2.0 * self.reach() - 1e-4).ceil() as usize - 1,
            _ => 0,
        }
    }

    /// Half of the depth that a voxel's kernel and a sheet have together.
    fn reach(&self) -> f64 {
        1.5 * self.widths[2] + 0.5
    }

    /// Sheets in all.
    pub fn sheets(&self) -> usize {
        self.voxels.len() + (2.0 * self.reach()).ceil() as usize
    }

    /// The samples of a sheet.
    fn samples(&self, number: usize) -> Samples {
        let [width, height] = self.size;
        if number < self.first() {
            return vec![f64::NAN; width * height];
        }
        let (reach, [wx, wy, wz]) = (self.reach(), self.widths);
        let middle = number as f64 + 1.0 - reach;
        let mut sums = vec![[0.0; 2]; width * height];
        let whole = |depth: f64| depth.clamp(0.0, self.voxels.len() as f64) as usize;
        let bins = whole(middle - reach)..(whole(middle + reach) + 1).min(self.voxels.len());
        let of_bins = bins.clone().zip(&self.voxels[bins]);
        for (bin, [x, y, depth, value]) in
            of_bins.flat_map(|(bin, voxels)| voxels.iter().map(move |voxel| (bin, *voxel)))
        {
            let [wx, wy] = self.eye.as_ref().map_or([wx, wy], |eye| eye.pixels(self.widths, bin));
            let away = middle - depth;
            let slab = wz * (integral((away + 0.5) / wz) - integral((away - 0.5) / wz));
            if slab <= 0.0 {
                continue;
            }
            let covered = |place: f64, width: f64, side: usize| {
                let from = (place - 1.5 * width).ceil().max(0.0) as usize;
                from..((place + 1.5 * width).floor() + 1.0).clamp(0.0, side as f64) as usize
            };
            for row in covered(y, wy, height) {
                let down = slab * spline((row as f64 - y) / wy);
                for column in covered(x, wx, width) {
                    let weight = down * spline((column as f64 - x) / wx);
                    let [weights, values] = &mut sums[row * width + column];
                    *weights += weight;
                    *values += weight * value;
                }
            }
        }
        // Sums that should be half stay half.
        let least = self.least(number) * (1.0 - 1e-9);
        let sample = |[weights, values]: [f64; 2]| if weights >= least { values / weights } else { f64::NAN };
        sums.into_iter().map(sample).collect()
    }

    /// A pixel with one more sample.
    fn seen(&self, pixel: Pixel, (number, at): (usize, usize), [before, here, behind]: [&Samples; 3]) -> Pixel {
        let sample = here[at];
        if sample.is_nan() {
            return pixel;
        }
        let mut classified = self.classifier.classify(sample);
        if classified.opacity == 0.0 {
            return pixel;
        }
        let ray = self.eye.as_ref().map(|eye| {
            let [x, y] = eye.slopes(at, self.size);
            ([x, y], (1.0 + x * x + y * y).sqrt())
        });
        if let Some((_, length)) = ray {
            classified.opacity = 1.0 - (1.0 - classified.opacity).powf(length);
        }
        let Some(lights) = &self.lights else {
            return pixel.front_to_back(classified.colour, classified.opacity);
        };
        let [width, height] = self.size;
        let (column, row) = (at % width, at / width);
        let of = |inside: bool, samples: &Samples, at: usize| if inside { samples[at] } else { f64::NAN };
        let [pixels, sheets] = self.lengths;
        let slope = |before: f64, behind: f64, length: f64| {
            let difference = match (before.is_nan(), behind.is_nan()) {
                (false, false) => behind - before,
                (true, false) => 2.0 * (behind - sample),
                (false, true) => 2.0 * (sample - before),
                (true, true) => 0.0,
            };
            // Means of equal values differ by what f64 rounds, which is no direction.
            if difference.abs() < 1e-9 {
                0.0
            } else {
                difference / length
            }
        };
        let gradient = [
            slope(
                of(column > 0, here, at.wrapping_sub(1)),
                of(column + 1 < width, here, at + 1),
                pixels,
            ),
            slope(
                of(row > 0, here, at.wrapping_sub(width)),
                of(row + 1 < height, here, at + width),
                pixels,
            ),
            slope(of(true, before, at), of(true, behind, at), sheets),
        ];
        let Some(([x, y], length)) = ray else {
            return pixel.front_to_back(lights.shade(normalise(gradient), classified.colour), classified.opacity);
        };
        let apart = self.apart(number);
        let across = [gradient[0] / apart, gradient[1] / apart];
        let gradient = [across[0], across[1], gradient[2] - x * across[0] - y * across[1]];
        let lights = lights.seen_from([-x / length, -y / length, -1.0 / length]);
        pixel.front_to_back(lights.shade(normalise(gradient), classified.colour), classified.opacity)
    }

    /// The whole image.
    pub fn render(&self) -> ModelImage {
        let [width, height] = self.size;
        let none = vec![f64::NAN; width * height];
        let mut pixels = vec![Pixel::TRANSPARENT; width * height];
        let (mut before, mut here) = (none.clone(), none.clone());
        // The sheet that is seen; the first time there is none.
        let mut number = 0usize;
        let mut fold = |before: &Samples, here: &Samples, behind: &Samples| {
            let seen = number.saturating_sub(1);
            pixels
                .par_iter_mut()
                .enumerate()
                .for_each(|(at, pixel)| *pixel = self.seen(*pixel, (seen, at), [before, here, behind]));
            number += 1;
        };
        for first in (0..self.sheets()).step_by(AT_A_TIME) {
            let numbers = first..(first + AT_A_TIME).min(self.sheets());
            let some: Vec<Samples> = numbers.into_par_iter().map(|number| self.samples(number)).collect();
            for behind in some {
                fold(&before, &here, &behind);
                before = std::mem::replace(&mut here, behind);
            }
        }
        fold(&before, &here, &none);
        ModelImage::from_fn(self.size, |u, v| pixels[v * width + u])
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        self.scene
    }
}

/// The quadratic B-spline.
fn spline(t: f64) -> f64 {
    let t = t.abs();
    if t < 0.5 {
        0.75 - t * t
    } else if t < 1.5 {
        (1.5 - t).powi(2) / 2.0
    } else {
        0.0
    }
}

/// Its integral from 0.
fn integral(t: f64) -> f64 {
    let size = t.abs();
    let half = if size < 0.5 {
        0.75 * size - size.powi(3) / 3.0
    } else if size < 1.5 {
        0.5 - (1.5 - size).powi(3) / 6.0
    } else {
        0.5
    };
    half.copysign(t)
}

/// Lights in the frame of the image: x to the right, y down, z away from the eye.
fn lights(lighting: &Lighting, camera: &CameraAxes) -> Lights {
    let seen = |light: &Light| match light.frame {
        Frame::Camera => *light,
        Frame::Volume => Light {
            direction: [
                dot(light.direction, camera.right),
                dot(light.direction, camera.up),
                -dot(light.direction, camera.forward),
            ],
            frame: Frame::Camera,
            ..*light
        },
    };
    let lighting = Lighting {
        lights: lighting.lights.iter().map(seen).collect(),
        ..lighting.clone()
    };
    let image = CameraAxes {
        right: [1.0, 0.0, 0.0],
        up: [0.0, -1.0, 0.0],
        forward: [0.0, 0.0, 1.0],
    };
    let geometry = Geometry::new(image.forward, [1; 3], [1.0; 3], Sampling::default());
    Lights::new(&lighting, &image, &geometry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{scene_along, volume_of};

    /// From far away what is seen is what parallel rays see, lit or not, and sheets lie as deep.
    #[test]
    fn from_afar_rays_are_parallel() {
        let mut scene = scene_along([0.0, 1.0, 0.0], &[(0.0, 0.0), (4095.0, 0.4)]);
        let volume = volume_of([9, 8, 7], |x, y, z| (x * 301 + y * 97 + z * 111) as u16 as _);
        for lighting in [None, Some(Lighting::default())] {
            scene.lighting = lighting;
            let parallel = Splat::new(&scene, &volume, [9, 9], Rounding::default()).render();
            let far = 1e7;
            let axes = scene.view.axes();
            let eye = [0, 1, 2].map(|m| (volume.dims[m] as f64 - 1.0) / 2.0 - far * axes.forward[m]);
            let fov = 2.0 * (4.5f64 / far).atan().to_degrees();
            let model = Splat::from_eye(&scene, &volume, [9, 9], (eye, fov), Rounding::default());
            let image = model.render();
            for (u, v) in (2..7).flat_map(|u| (2..7).map(move |v| (u, v))) {
                let (a, b) = (parallel.pixel(u, v), image.pixel(u, v));
                let parts = a.colour.into_iter().zip(b.colour).map(|(a, b)| (a - b).abs());
                let worst = parts.fold((a.transparency - b.transparency).abs(), f64::max);
                assert!(worst < 1e-5, "{u} {v}: {worst}");
            }
        }
    }

    /// In a linear field samples are the field's at the places of rays, and gradients its slope, near an eye and at slopes to the side.
    #[test]
    fn linear_fields_stay_linear_from_an_eye() {
        let scene = scene_along([0.0, 0.0, 1.0], &[(0.0, 0.5)]);
        let volume = volume_of([21, 21, 21], |x, y, z| (90 * x + 50 * y + 30 * z) as u16 as _);
        let axes = scene.view.axes();
        let eye = [0, 1, 2].map(|m| 10.0 - 30.0 * axes.forward[m]);
        let model = Splat::from_eye(&scene, &volume, [41, 41], (eye, 50.0), Rounding::default());
        let step = |axis: [f64; 3]| 90.0 * axis[0] + 50.0 * axis[1] + 30.0 * axis[2];
        let seen = model.eye.as_ref().unwrap();
        let number = 10;
        let z = seen.near + number as f64 + 1.0 - model.reach();
        let samples = model.samples(number);
        let mut count = 0;
        for (at, sample) in samples.iter().enumerate() {
            let [x, y] = seen.slopes(at, [41, 41]);
            // Far enough from the faces.
            if x.abs() * z > 6.0 || y.abs() * z > 6.0 {
                continue;
            }
            count += 1;
            let wanted =
                10.0 * 170.0 + x * z * step(axes.right) - y * z * step(axes.up) + (z - 30.0) * step(axes.forward);
            // A kernel has one width in a slab, and its voxels are nearer and farther than the sheet.
            assert!((sample - wanted).abs() < 6.0, "{at}: {} {wanted}", *sample);
        }
        assert!(count > 50, "{count}");
    }

    /// Fog of one value from the side: as many samples as there are voxels, and each takes its part.
    #[test]
    fn fog_is_as_thick_as_the_volume() {
        let scene = scene_along([0.0, 1.0, 0.0], &[(0.0, 0.02)]);
        let volume = volume_of([9, 12, 9], |_, _, _| 3000);
        let image = Splat::new(&scene, &volume, [9, 9], Rounding::default()).render();
        let left = image.pixel(4, 4).transparency;
        assert!((left - 0.98f64.powi(12)).abs() < 1e-12, "{left}");
        // Four sheets to a voxel: within, the weights' mean does not depend on it.
        let mut fine = scene.clone();
        fine.sampling.planes_per_voxel = 4;
        let image = Splat::new(&fine, &volume, [9, 9], Rounding::default()).render();
        let length = image.pixel(4, 4).transparency.ln() / 0.98f64.ln();
        assert!((length - 12.0).abs() <= 0.5, "{length}");
    }

    /// In a linear field samples are the field's, and normals its slope, away from the faces.
    #[test]
    fn linear_fields_stay_linear() {
        let mut scene = scene_along([0.0, 0.0, 1.0], &[(0.0, 0.5)]);
        scene.view.azimuth = 0.0;
        let volume = volume_of([11, 11, 11], |x, y, z| (100 * x + 70 * y + 40 * z) as u16 as _);
        let axes = scene.view.axes();
        let model = Splat::new(&scene, &volume, [11, 11], Rounding::default());
        let middle: f64 = 5.0 * 210.0;
        let step = |axis: [f64; 3]| 100.0 * axis[0] + 70.0 * axis[1] + 40.0 * axis[2];
        // Sheet k lies k + 1 - reach behind the nearest voxel, the middle 5.
        let number = 6;
        let depth = number as f64 + 1.0 - model.reach() - 5.0;
        let samples = model.samples(number);
        for (row, column) in (3..8).flat_map(|row| (3..8).map(move |column| (row, column))) {
            let (x, y) = (column as f64 - 5.0, row as f64 - 5.0);
            let wanted = middle + x * step(axes.right) - y * step(axes.up) + depth * step(axes.forward);
            let found = samples[row * 11 + column];
            assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        }
    }

    #[test]
    fn the_spline_is_the_slope_of_its_integral() {
        for number in -400..=400 {
            let t = f64::from(number) / 200.0;
            let slope = (integral(t + 1e-6) - integral(t - 1e-6)) / 2e-6;
            assert!((slope - spline(t)).abs() < 1e-6);
        }
        assert!((integral(1.5) - 0.5).abs() < 1e-15);
    }
}
