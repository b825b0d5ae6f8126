//! Volumes of colour and extinction: samples, and rays through them.
//!
//! Source: Kraus and Bürger, "Interpolating and Downsampling RGBA Volume Data", section 3.4: extinction tau and colours times
//! tau are interpolated; over a step of length d a sample blocks `1 - e^-(tau d)` and gives `C tau / tau` of it. Light takes tau for
//! the scalar whose gradient is the normal.
//!
//! | value | unit |
//! |---|---|
//! | tau, C tau | per unit of the volume's spacing |
//! | d | unit of the spacing |

use super::clip::{ClipPlane, CuePlane, left};
use super::composite::Pixel;
use super::gradient::{normalise, spacing_factors};
use super::interpolate::{Cell, trilinear};
use super::pyramid::Voxel;
use super::rays::{Geometry, Lattice};
use super::render::Positions;
use super::shade::Lights;
use super::warp::ModelImage;
use slicecast_scene::clip::Clip;
use slicecast_scene::cueing::Cueing;
use slicecast_scene::{Borders, CameraAxes, Lighting};

/// Share of the largest number in a sum of some that what is left of it counts from.
const NOISE: f64 = 1.0 / (1_u64 << 48) as f64;

/// The f64 model of a volume of colour and extinction under a view.
pub struct Absorbing<'a> {
    geometry: Geometry,
    lattice: Lattice,
    positions: Positions<'a>,
    /// Red, green and blue times extinction, and extinction, at (x, y, z).
    voxel: Box<dyn Fn([usize; 3]) -> Voxel + Send + Sync + 'a>,
    /// Whether samples are moved to the nearest voxel.
    nearest: bool,
    clips: Vec<ClipPlane>,
    lights: Option<Lights>,
    cue: Option<CuePlane>,
}

impl<'a> Absorbing<'a> {
    /// A volume that is read voxel by voxel, on a lattice of rays.
    pub fn new(
        geometry: Geometry,
        lattice: Lattice,
        positions: Positions<'a>,
        voxel: impl Fn([usize; 3]) -> Voxel + Send + Sync + 'a,
    ) -> Self {
        let voxel = Box::new(voxel);
        Self {
            geometry,
            lattice,
            positions,
            voxel,
            nearest: false,
            clips: Vec::new(),
            lights: None,
            cue: None,
        }
    }

    /// The same, each sample at its nearest voxel, halves up.
    #[must_use]
    pub fn with_nearest(self, nearest: bool) -> Self {
        Self { nearest, ..self }
    }

    /// The same behind clip planes.
    #[must_use]
    pub fn with_clips(self, clips: &[Clip]) -> Self {
        let clips = clips.iter().map(|clip| ClipPlane::of(clip, &self.geometry)).collect();
        Self { clips, ..self }
    }

    /// The same under a scene's lights, seen by this camera.
    #[must_use]
    pub fn with_lighting(self, lighting: &Lighting, camera: &CameraAxes) -> Self {
        let lights = Some(Lights::new(lighting, camera, &self.geometry));
        Self { lights, ..self }
    }

    /// The same with depth cueing along a view of this direction.
    #[must_use]
    pub fn with_cueing(self, cue: &Cueing, forward: [f64; 3]) -> Self {
        let cue = Some(CuePlane::of(cue, forward, &self.geometry));
        Self { cue, ..self }
    }

    /// The lattice of rays.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// The position of a plane's sample, the part of its step inside, and the middle of that step.
    fn place(&self, plane: usize, u: usize, v: usize) -> Option<([f64; 3], f64, [f64; 3])> {
        let settled = |at: [f64; 3]| {
            if self.nearest {
                at.map(|c| (c + 0.5).floor())
            } else {
                at
            }
        };
        let exact = self.geometry.position(self.lattice, plane, u, v);
        let at = settled(match &self.positions {
            Positions::Exact => exact,
            Positions::Given(position) => position(plane, u, v),
            Positions::GivenEnds(ends) => ends(plane, u, v)[1],
        });
        if self.geometry.borders != Borders::Whole {
            let fraction = self.geometry.fraction(exact);
            let left = self.left(exact);
            return (fraction > 0.0).then(|| (self.geometry.held(at), fraction * left, exact));
        }
        let inside = match &self.positions {
            Positions::Exact => self.geometry.inside_tolerant(at),
            Positions::Given(_) | Positions::GivenEnds(_) => self.geometry.inside(at),
        };
        inside.map(|at| (at, self.left(exact), exact))
    }

    /// The share of a sample's segment that clip planes leave, of what lies in the box.
    fn left(&self, middle: [f64; 3]) -> f64 {
        let (front, way) = (self.geometry.front(middle), self.geometry.way());
        left(&self.clips, front, way, self.geometry.part(middle)).weight()
    }

    /// The voxel (i, j, k) of the frame.
    fn voxel(&self, [i, j, k]: [usize; 3]) -> Voxel {
        let Geometry {
            order, flipped, dims, ..
        } = self.geometry;
        let place = [i, j, if flipped { dims[2] - 1 - k } else { k }];
        let mut xyz = [0; 3];
        for (axis, index) in order.into_iter().zip(place) {
            xyz[axis] = index;
        }
        (self.voxel)(xyz)
    }

    /// The difference of the extinctions of a voxel's neighbours along an axis; beyond a face the volume is continued linearly.
    fn difference(&self, at: [usize; 3], axis: usize) -> f64 {
        let last = self.geometry.dims[axis] - 1;
        let tau = |index: usize| {
            let mut place = at;
            place[axis] = index;
            self.voxel(place)[3]
        };
        match at[axis] {
            _ if last == 0 => 0.0,
            0 => 2.0 * (tau(1) - tau(0)),
            index if index == last => 2.0 * (tau(last) - tau(last - 1)),
            index => tau(index + 1) - tau(index - 1),
        }
    }

    /// The normal at a position of the frame: differences interpolated as extinctions are, in the world's proportions.
    fn normal(&self, at: [f64; 3]) -> [f64; 3] {
        let cell = Cell::at(at, self.geometry.dims);
        let largest = cell.corners(|at| self.voxel(at)[3]).into_iter().fold(0.0, f64::max);
        let factors = spacing_factors(self.geometry.spacing);
        normalise([0, 1, 2].map(|axis| {
            let corners = cell.corners(|at| self.difference(at, axis));
            let difference = trilinear(corners, cell.weight);
            let largest = corners.into_iter().fold(largest, |most: f64, d| most.max(d.abs()));
            // Less than this is the noise of sums that vanish.
            if difference.abs() <= largest * NOISE {
                0.0
            } else {
                difference * factors[axis]
            }
        }))
    }

    /// Red, green and blue times extinction, and extinction, at a position of the frame.
    fn sample(&self, at: [f64; 3]) -> Voxel {
        let corners = Cell::at(at, self.geometry.dims);
        let voxels = corners.corners(|at| self.voxel(at));
        [0, 1, 2, 3].map(|channel| trilinear(voxels.map(|voxel| voxel[channel]), corners.weight))
    }

    /// The pixel of one ray, front to back.
    pub fn ray(&self, u: usize, v: usize) -> Pixel {
        let step = self.geometry.step_length();
        let mut pixel = Pixel::TRANSPARENT;
        for plane in 0..self.geometry.planes() {
            let Some((at, fraction, middle)) = self.place(plane, u, v) else {
                continue;
            };
            let [red, green, blue, tau] = self.sample(at);
            if tau > 0.0 {
                let opacity = -(-tau * step * fraction).exp_m1();
                let mut colour = [red, green, blue].map(|weighted| weighted / tau);
                if let Some(lights) = &self.lights {
                    colour = lights.shade(self.normal(at), colour);
                }
                if let Some(cue) = &self.cue {
                    colour = cue.colour(colour, cue.turned(middle));
                }
                pixel = pixel.front_to_back(colour, opacity);
            }
        }
        pixel
    }

    /// The whole base plane, rows in parallel.
    pub fn render(&self) -> ModelImage {
        ModelImage::from_fn(self.lattice.size, |u, v| self.ray(u, v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_scene::Sampling;

    /// The paper's figure 1: across a voxel of extinction tau in a clear line, samples 1/m apart sum to tau whatever their phase.
    #[test]
    fn steps_that_divide_a_voxel_are_exact() {
        for planes_per_voxel in [1, 2, 5] {
            let sampling = Sampling {
                planes_per_voxel,
                rays_per_voxel: 1,
            };
            for (forward, major) in [([0.0, 0.0, 1.0], 2), ([0.0, -1.0, 0.0], 1), ([1.0, 0.0, 0.0], 0)] {
                let geometry = Geometry::new(forward, [5; 3], [1.0; 3], sampling);
                let voxel = move |at: [usize; 3]| if at[major] == 2 { [4.0, 1.0, 0.0, 4.0] } else { [0.0; 4] };
                let model = Absorbing::new(geometry, geometry.natural_lattice(), Positions::Exact, voxel);
                let Pixel {
                    colour: [red, green, blue],
                    transparency,
                } = model.ray(1, 2);
                let blocked = 1.0 - (-4.0f64).exp();
                assert!((1.0 - transparency - blocked).abs() < 1e-12);
                assert!((red - blocked).abs() < 1e-12 && (green - blocked / 4.0).abs() < 1e-12 && blue == 0.0);
            }
        }
    }

    /// A homogeneous block between its faces: `1 - e^(-tau length)`.
    #[test]
    fn blocks_are_as_thick_as_they_are() {
        let geometry = Geometry::new([0.3, 0.2, 0.9], [6, 7, 8], [1.0, 1.0, 2.0], Sampling::default());
        let geometry = geometry.with_borders(Borders::Cells);
        let lattice = geometry.natural_lattice();
        let model = Absorbing::new(geometry, lattice, Positions::Exact, |_| [0.05; 4]);
        let steps: f64 = (0..geometry.planes())
            .map(|plane| geometry.fraction(geometry.position(lattice, plane, lattice.size[0] / 2, lattice.size[1] / 2)))
            .sum();
        let pixel = model.ray(lattice.size[0] / 2, lattice.size[1] / 2);
        let expected = (-0.05 * steps * geometry.step_length()).exp();
        assert!((pixel.transparency - expected).abs() < 1e-12);
        assert!(
            pixel
                .colour
                .iter()
                .all(|c| (c + pixel.transparency - 1.0).abs() < 1e-12)
        );
    }
}
