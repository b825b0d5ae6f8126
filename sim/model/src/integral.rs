//! The converged integral: the picture without planes, steps and tables.
//!
//! The model of the rest of this folder samples where the pipeline does. What both have in common, the step length, the
//! border and the order of colours inside a step, is the error of the *algorithm*; this file is the reference for it.
//!
//! A ray from its entry into the volume to its exit, z along k in voxels, L the world length of a voxel of it:
//!
//! ```text
//! T(z) = exp(-int tau)        tau = -ln(1 - alpha) L / unit distance
//! C    = int c tau T dz       c: shaded colour; alpha, c of the trilinear value, the normal of the trilinear gradient
//! ```
//!
//! The ray is cut where it crosses from one cell of voxels to the next. Within a cell a part is accepted when halving it
//! changes neither colour nor transparency by a thousandth of 1/255, and when all of it lies on one straight piece of the
//! transfer function; otherwise it is halved, up to [`SMOOTH_DEPTH_MAX`] times where the function is straight and
//! [`DEPTH_MAX`] times around its corners. Optical depths are summed by Simpson's rule.
//!
//! A surface is met where the value along the ray, in a cell a cubic, passes its own; there the ray is cut. Its normal is that of
//! the trilinear gradient at that place.
//!
//! The integral ends at the centres of the outermost voxels, or half a voxel beyond them where the scene's borders are cells, or at
//! the faces of its crop box; places are held to the voxels. With whole borders the discrete model has planes at the centres, each as thick as a step: half a step on
//! either side counts as error of the algorithm.

use super::clip::ClipPlane;
use super::composite::Pixel;
use super::gradient::normalise;
use super::interpolate::Cell;
use super::parts::Isosurface;
use super::rays::Geometry;
use super::render::Model;
use super::warp::ModelImage;
use slicecast_scene::Face;

/// Halvings of a cell where the transfer function has a corner or a step; what is then left of it is 2^-14 of a voxel.
const DEPTH_MAX: u32 = 14;

/// Halvings where it is straight. More would follow normals that turn over within a hundredth of a voxel, where the
/// gradient vanishes.
const SMOOTH_DEPTH_MAX: u32 = 5;

/// The change of a pixel that is not worth another halving, in a cell: below a thousandth of 1/255.
const TOLERANCE: f64 = 1e-3 / 255.0;

/// An opacity of 1 would be an infinite extinction.
const OPACITY_MAX: f64 = 1.0 - 1e-12;

/// A value nearer to a surface's than this, in codes, does not tell the sides apart.
const SAME: f64 = 1e-7;

/// What the integral is made of at a point.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// Extinction per voxel of z.
    tau: f64,
    colour: [f64; 3],
    /// The straight piece of the transfer function.
    piece: usize,
}

impl Model<'_> {
    /// The converged pixel of one ray, composited.
    pub fn integral(&self, u: usize, v: usize) -> Pixel {
        let geometry = self.geometry();
        let lattice = self.lattice();
        let rays = geometry.rays_per_voxel as f64;
        let start = [
            lattice.origin[0] as f64 + u as f64 / rays,
            lattice.origin[1] as f64 + v as f64 / rays,
        ];
        let position = |z: f64| [start[0] + z * geometry.shear[0], start[1] + z * geometry.shear[1], z];
        let ray = Ray {
            model: self,
            position: &position,
        };
        let mut pixel = Pixel::TRANSPARENT;
        let mut inside = None;
        for [from, to] in cells(start, geometry, self.clips()) {
            let mut reached = from;
            for (z, surface) in ray.surfaces(from, to, &mut inside) {
                pixel = behind(pixel, ray.volume(reached, z, pixel.transparency));
                pixel = behind(pixel, surface);
                reached = z;
            }
            pixel = behind(pixel, ray.volume(reached, to, pixel.transparency));
            if pixel.transparency < 1e-9 {
                break;
            }
        }
        pixel
    }

    /// The whole base plane, rows in parallel.
    pub fn render_integral(&self) -> ModelImage {
        ModelImage::from_fn(self.lattice().size, |u, v| self.integral(u, v))
    }
}

/// A part of a ray behind another.
fn behind(front: Pixel, part: Pixel) -> Pixel {
    Pixel {
        colour: [0, 1, 2].map(|c| front.colour[c] + front.transparency * part.colour[c]),
        transparency: front.transparency * part.transparency,
    }
}

/// The parts of a ray between the faces of voxel cells, from its entry to its exit, of the box that counts.
fn cells(start: [f64; 2], geometry: &Geometry, clips: &[ClipPlane]) -> Vec<[f64; 2]> {
    let Geometry { shear, dims, faces, .. } = *geometry;
    let mut range = faces[2];
    for axis in 0..2 {
        let [low, high] = faces[axis];
        if shear[axis] == 0.0 {
            if !(low..=high).contains(&start[axis]) {
                return Vec::new();
            }
            continue;
        }
        let [a, b] = [low, high].map(|face| (face - start[axis]) / shear[axis]);
        range = [range[0].max(a.min(b)), range[1].min(a.max(b))];
    }
    let [entry, exit] = range;
    if exit <= entry {
        return Vec::new();
    }
    let mut cuts = vec![entry, exit];
    let mut within = |z: f64| {
        if entry < z && z < exit {
            cuts.push(z);
        }
    };
    (0..dims[2]).for_each(|k| within(k as f64));
    for axis in 0..2 {
        if shear[axis] != 0.0 {
            (0..dims[axis]).for_each(|i| within((i as f64 - start[axis]) / shear[axis]));
        }
    }
    // Where the shares that clip planes leave have corners.
    let [si, sj] = shear;
    for plane in clips {
        let first = plane.distance([start[0], start[1], 0.0]);
        let along = plane.distance([start[0] + si, start[1] + sj, 1.0]) - first;
        plane
            .corners()
            .into_iter()
            .for_each(|corner| within((corner - first) / along));
    }
    cuts.sort_by(f64::total_cmp);
    cuts.windows(2)
        .map(|pair| [pair[0], pair[1]])
        .filter(|[a, b]| b > a)
        .collect()
}

struct Ray<'a> {
    model: &'a Model<'a>,
    position: &'a dyn Fn(f64) -> [f64; 3],
}

impl Ray<'_> {
    fn point(&self, z: f64) -> Point {
        let geometry = self.model.geometry();
        let at = self.inside(z);
        let (classified, piece) = self.model.as_written_on_piece(self.model.value_at(at));
        let length =
            geometry.step_length() * geometry.planes_per_voxel as f64 / self.model.classifier().unit_distance();
        let tau = -(-classified.opacity.min(OPACITY_MAX)).ln_1p() * length * self.left(z);
        let colour = match self.model.lights() {
            Some(lights) if tau > 0.0 => lights.shade(normalise(self.model.gradient_at(at)), classified.colour),
            _ => classified.colour,
        };
        let colour = self.cued(z, colour);
        Point { tau, colour, piece }
    }

    /// A colour at a place as depth cueing turns it.
    fn cued(&self, z: f64, colour: [f64; 3]) -> [f64; 3] {
        let Some(cue) = self.model.cue() else { return colour };
        cue.colour(colour, cue.turned((self.position)(z)))
    }

    /// The share of the optical depth at a place that clip planes leave.
    fn left(&self, z: f64) -> f64 {
        let at = (self.position)(z);
        self.model.clips().iter().map(|plane| plane.share(at)).product()
    }

    /// The surfaces that are met in a cell, with their places. `inside` keeps on which side of each surface the ray is: a
    /// voxel that has a surface's value is the end of one cell and the beginning of the next, and rounding would have it on
    /// both sides.
    fn surfaces(&self, from: f64, to: f64, inside: &mut Option<Vec<bool>>) -> Vec<(f64, Pixel)> {
        let surfaces = self.model.surfaces();
        if surfaces.is_empty() {
            return Vec::new();
        }
        let along = Cubic::through(|t| self.value(from + (to - from) * t));
        let inside = inside.get_or_insert_with(|| surfaces.iter().map(|s| along.at(0.0) >= s.code).collect());
        let mut met = Vec::new();
        for [a, b] in along.monotone() {
            let end = along.at(b);
            for (surface, inside) in surfaces.iter().zip(inside.iter_mut()) {
                if (end >= surface.code) == *inside || (end - surface.code).abs() < SAME {
                    continue;
                }
                let t = along.root(surface.code, [a, b]);
                met.push((t, surface, *inside));
                *inside = !*inside;
            }
        }
        met.sort_by(|a, b| a.0.total_cmp(&b.0));
        let drawn = |(t, surface, falling): (f64, &Isosurface, bool)| {
            let z = from + (to - from) * t;
            let Face { colour, opacity } = if falling { surface.falling } else { surface.rising };
            let shaded = match self.model.lights() {
                Some(lights) => {
                    let gradient = self.model.gradient_at(self.inside(z));
                    let sign = if falling { -1.0 } else { 1.0 };
                    lights.shade(normalise(gradient.map(|g| sign * g)), colour)
                }
                None => colour,
            };
            let shaded = self.cued(z, shaded);
            // As a step of this opacity fades.
            let opacity = 1.0 - (1.0 - opacity).powf(self.left(z));
            let pixel = Pixel {
                colour: shaded.map(|c| c * opacity),
                transparency: 1.0 - opacity,
            };
            (z, pixel)
        };
        met.into_iter().map(drawn).collect()
    }

    /// A place of the ray, held to the voxels: cuts lie on faces up to rounding, and a box may reach beyond.
    fn inside(&self, z: f64) -> [f64; 3] {
        let (at, dims) = ((self.position)(z), self.model.geometry().dims);
        [0, 1, 2].map(|a| at[a].clamp(0.0, (dims[a] - 1) as f64))
    }

    fn value(&self, z: f64) -> f64 {
        self.model.value_at(self.inside(z))
    }

    /// A part of a cell, behind this much transparency.
    fn volume(&self, from: f64, to: f64, before: f64) -> Pixel {
        if to <= from || !self.model.has_volume() {
            return Pixel::TRANSPARENT;
        }
        self.cell(from, to, before)
    }

    /// A cell, behind this much transparency.
    fn cell(&self, from: f64, to: f64, before: f64) -> Pixel {
        // A whisker inside, so that the ends are of this cell's own gradient.
        let inset = (to - from) * 1e-9;
        let middle = self.inside((from + to) / 2.0);
        let grid = self.model.grid();
        let corners = Cell::at(middle, grid.dims()).corners(|c| grid.voxel(c));
        let low = corners.iter().copied().fold(f64::INFINITY, f64::min);
        let high = corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if self.model.classifier().is_clear(low, high) {
            return Pixel::TRANSPARENT;
        }
        let [from, to] = [from + inset, to - inset];
        let points = [from, (from + to) / 2.0, to].map(|z| self.point(z));
        let whole = simpson(to - from, points);
        self.refine([from, to], points, whole, TOLERANCE / before.max(1e-9), DEPTH_MAX)
    }

    fn refine(&self, [from, to]: [f64; 2], points: [Point; 3], whole: Pixel, tolerance: f64, depth: u32) -> Pixel {
        let middle = (from + to) / 2.0;
        let [first, centre, last] = points;
        let left = [first, self.point((from + middle) / 2.0), centre];
        let right = [centre, self.point((middle + to) / 2.0), last];
        let halves = [simpson(middle - from, left), simpson(to - middle, right)];
        let both = behind(halves[0], halves[1]);
        let change = (0..3)
            .map(|c| (both.colour[c] - whole.colour[c]).abs())
            .fold((both.transparency - whole.transparency).abs(), f64::max);
        let straight = left.iter().chain(&right).all(|point| point.piece == first.piece);
        let smooth_end = straight && depth <= DEPTH_MAX - SMOOTH_DEPTH_MAX;
        if depth == 0 || smooth_end || straight && change <= tolerance {
            return both;
        }
        let [a, b] = halves;
        let near = self.refine([from, middle], left, a, tolerance, depth - 1);
        if near.transparency < 1e-9 {
            return near;
        }
        behind(near, self.refine([middle, to], right, b, tolerance, depth - 1))
    }
}

/// The value along a ray in a cell, where it is a cubic, from 0 to 1.
#[derive(Clone, Copy, Debug)]
struct Cubic([f64; 4]);

impl Cubic {
    /// Through the values at 0, 1/3, 2/3 and 1.
    fn through(value: impl Fn(f64) -> f64) -> Self {
        let [a, b, c, d] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(value);
        Self([
            a,
            (-11.0 * a + 18.0 * b - 9.0 * c + 2.0 * d) / 2.0,
            9.0 * (2.0 * a - 5.0 * b + 4.0 * c - d) / 2.0,
            9.0 * (-a + 3.0 * b - 3.0 * c + d) / 2.0,
        ])
    }

    fn at(&self, t: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    /// Parts in which it only rises or only falls.
    fn monotone(&self) -> Vec<[f64; 2]> {
        let [_, b, c, d] = self.0;
        let discriminant = c * c - 3.0 * b * d;
        let mut cuts = vec![0.0, 1.0];
        if discriminant > 0.0 {
            // The stable form of both roots of b + 2 c t + 3 d t^2.
            let q = -(c + c.signum() * discriminant.sqrt());
            for root in [q / (3.0 * d), b / q] {
                if root > 0.0 && root < 1.0 {
                    cuts.push(root);
                }
            }
        }
        cuts.sort_by(f64::total_cmp);
        cuts.windows(2).map(|pair| [pair[0], pair[1]]).collect()
    }

    /// Where it takes a value that it passes within a monotone part.
    fn root(&self, value: f64, [mut low, mut high]: [f64; 2]) -> f64 {
        let rising = self.at(high) > self.at(low);
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            if (self.at(middle) >= value) == rising {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }
}

/// A part of a ray from its ends and its middle.
fn simpson(length: f64, points: [Point; 3]) -> Pixel {
    let weights = [1.0, 4.0, 1.0].map(|w| w * length / 6.0);
    let depths = [0, 1, 2].map(|i| weights[i] * points[i].tau);
    let depth: f64 = depths.iter().sum();
    let blocked = -(-depth).exp_m1();
    let colour = [0, 1, 2].map(|c| {
        let sum: f64 = (0..3).map(|i| depths[i] * points[i].colour[c]).sum();
        if depth > 0.0 { blocked * sum / depth } else { 0.0 }
    });
    Pixel {
        colour,
        transparency: (-depth).exp(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{scene_along, volume_of};
    use slicecast_scene::{Sampling, Scene};
    use slicecast_volume::Volume;

    fn centre(scene: &Scene, volume: &Volume) -> Pixel {
        let model = Model::natural(scene, volume);
        let [width, height] = model.lattice().size;
        model.integral(width / 2, height / 2)
    }

    /// A ramp along the ray meets a surface where it has its value, once, though that is at a voxel; a ball meets it twice.
    #[test]
    fn surfaces_are_met_where_they_lie() {
        let red = [1.0, 0.0, 0.0];
        let ramp = volume_of([3, 11, 3], |_, y, _| 100 * y);
        for value in [400.0, 437.0] {
            let mut scene = scene_along([0.0, 1.0, 0.0], &[(0.0, 0.2), (1000.0, 0.2)]);
            scene.surfaces = vec![slicecast_scene::Surface::of(
                value,
                Face {
                    colour: red,
                    opacity: 0.5,
                },
            )];
            scene
                .transfer
                .points
                .iter_mut()
                .for_each(|point| point.colour = [0.0, 0.0, 1.0]);
            let pixel = centre(&scene, &ramp);
            let (near, far) = (0.8_f64.powf(value / 100.0), 0.8_f64.powf(10.0 - value / 100.0));
            assert!((pixel.colour[0] - 0.5 * near).abs() < 1e-6, "{:?}", pixel.colour);
            let blue = 1.0 - near + 0.5 * near * (1.0 - far);
            assert!((pixel.colour[2] - blue).abs() < 2e-5, "{:?} {blue}", pixel.colour);
        }
        let ball = volume_of([15, 15, 15], |x, y, z| {
            let d = |c: usize| (c as f64 - 7.0).powi(2);
            (2000.0 - 200.0 * (d(x) + d(y) + d(z)).sqrt()).max(0.0) as usize
        });
        let mut scene = scene_along([0.3, 1.0, -0.2], &[(0.0, 0.0), (1000.0, 0.0)]);
        scene.surfaces = vec![slicecast_scene::Surface::of(
            1000.0,
            Face {
                colour: red,
                opacity: 0.5,
            },
        )];
        let pixel = centre(&scene, &ball);
        assert!((pixel.transparency - 0.25).abs() < 1e-12);
    }

    /// Constant fog of opacity a: T = (1 - a)^length, straight on and obliquely.
    #[test]
    fn constant_fog() {
        let volume = volume_of([9, 11, 9], |_, _, _| 1000);
        for forward in [[0.0, 1.0, 0.0], [0.2, 1.0, -0.1]] {
            let scene = scene_along(forward, &[(0.0, 0.3), (2000.0, 0.3)]);
            let model = Model::natural(&scene, &volume);
            let [width, height] = model.lattice().size;
            let (u, v) = (width / 2, height / 2);
            let geometry = model.geometry();
            let start = [0, 1].map(|a| model.lattice().origin[a] as f64 + [u, v][a] as f64);
            let parts = cells(start, geometry, &[]);
            let length: f64 = parts.iter().map(|[a, b]| b - a).sum::<f64>() * geometry.step_length();
            let exact = 0.7_f64.powf(length);
            let pixel = model.integral(u, v);
            assert!(length > 5.0);
            assert!(
                (pixel.transparency - exact).abs() < 1e-6,
                "{} {exact}",
                pixel.transparency
            );
            assert!((pixel.colour[0] - (1.0 - exact)).abs() < 1e-6);
        }
    }

    /// Opacity that rises linearly from 0 to a along the ray: the depth is the length over a times the integral of
    /// -ln(1 - x) from 0 to a, that is (1 - a) ln(1 - a) + a.
    #[test]
    fn rising_fog() {
        let volume = volume_of([3, 11, 3], |_, y, _| 100 * y);
        let a: f64 = 0.8;
        let scene = scene_along([0.0, 1.0, 0.0], &[(0.0, 0.0), (1000.0, a)]);
        let depth = 10.0 / a * ((1.0 - a) * (1.0 - a).ln() + a);
        let pixel = centre(&scene, &volume);
        assert!(
            (pixel.transparency - (-depth).exp()).abs() < 2e-6,
            "{}",
            pixel.transparency
        );
    }

    /// Red fog until the middle, then blue, changing at a point of the transfer function and not at a voxel.
    #[test]
    fn colours_in_their_order() {
        let volume = volume_of([3, 11, 3], |_, y, _| 100 * y);
        let mut scene = scene_along(
            [0.0, 1.0, 0.0],
            &[(0.0, 0.2), (537.0, 0.2), (537.0, 0.2), (1000.0, 0.2)],
        );
        for (point, colour) in
            scene
                .transfer
                .points
                .iter_mut()
                .zip([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
        {
            point.colour = colour;
        }
        let (near, far) = (0.8_f64.powf(5.37), 0.8_f64.powf(4.63));
        let pixel = centre(&scene, &volume);
        for (got, exact) in pixel.colour.into_iter().zip([1.0 - near, 0.0, near * (1.0 - far)]) {
            assert!((got - exact).abs() < 2e-5, "{:?}", pixel.colour);
        }
    }

    /// The model approaches the integral as planes are added: the algorithm's error falls.
    #[test]
    fn more_planes_come_closer() {
        let volume = volume_of([12, 14, 12], |x, y, z| {
            let d = |c: usize, m: f64| (c as f64 - m).powi(2);
            (3000.0 * (-(d(x, 5.5) + d(y, 6.5) + d(z, 5.5)) / 20.0).exp()) as usize
        });
        let mut last = f64::INFINITY;
        for planes in [1, 4, 16] {
            let mut scene = scene_along([0.3, 1.0, 0.2], &[(300.0, 0.0), (1500.0, 0.6), (3000.0, 0.1)]);
            scene.sampling = Sampling {
                planes_per_voxel: planes,
                rays_per_voxel: 1,
            };
            let model = Model::natural(&scene, &volume);
            let (discrete, converged) = (model.render(), model.render_integral());
            let error: f64 = discrete.rgb[0]
                .iter()
                .zip(&converged.rgb[0])
                .map(|(a, b)| (a - b).abs())
                .sum();
            assert!(error < 0.6 * last, "{planes}: {error} after {last}");
            last = error;
        }
    }
}
