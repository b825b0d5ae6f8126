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

/// What is interpolated between voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interpolated {
    /// Extinctions and colours times extinction (section 3.3).
    Extinctions,
    /// Opacities over a distance d' and colours times opacity (section 3.2), which are then brought to the length of a step.
    Opacities {
        /// d'.
        distance: f64,
        /// What 1 is in whole numbers, to the nearest of which all four are rounded before; without it they are not.
        one: Option<u32>,
    },
}

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
    interpolated: Interpolated,
    /// Whether samples are splines of second degree.
    quadratic: bool,
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
            interpolated: Interpolated::Extinctions,
            quadratic: false,
        }
    }

    /// The same, each sample a B-spline of second degree about the nearest of 27 voxels; beyond a face the last voxel is repeated.
    #[must_use]
    pub fn with_quadratic(self, quadratic: bool) -> Self {
        Self { quadratic, ..self }
    }

    /// The same with something else interpolated.
    #[must_use]
    pub fn with_interpolated(self, interpolated: Interpolated) -> Self {
        Self { interpolated, ..self }
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

    /// Red, green and blue times what is interpolated, and that, at a position of the frame.
    fn sample(&self, at: [f64; 3]) -> Voxel {
        if self.quadratic {
            return self.spline(at);
        }
        let corners = Cell::at(at, self.geometry.dims);
        let voxels = corners.corners(|at| self.interpolated.of(self.voxel(at)));
        [0, 1, 2, 3].map(|channel| trilinear(voxels.map(|voxel| voxel[channel]), corners.weight))
    }

    /// The same by splines.
    fn spline(&self, at: [f64; 3]) -> Voxel {
        let nearest = at.map(|c| (c + 0.5).floor());
        let weights = [0, 1, 2].map(|axis| {
            let u: f64 = at[axis] - nearest[axis];
            [(0.5 - u).powi(2) / 2.0, 0.75 - u * u, (0.5 + u).powi(2) / 2.0]
        });
        let mut sum = [0.0; 4];
        for (i, j, k) in (0..27).map(|n| (n % 3, n / 3 % 3, n / 9)) {
            let taps = [i, j, k];
            let place = [0, 1, 2].map(|axis| {
                let last = self.geometry.dims[axis] as f64 - 1.0;
                (nearest[axis] + taps[axis] as f64 - 1.0).clamp(0.0, last) as usize
            });
            let weight = weights[0][i] * weights[1][j] * weights[2][k];
            let voxel = self.interpolated.of(self.voxel(place));
            sum = [0, 1, 2, 3].map(|channel| sum[channel] + weight * voxel[channel]);
        }
        sum
    }

    /// The pixel of one ray, front to back.
    pub fn ray(&self, u: usize, v: usize) -> Pixel {
        let step = self.geometry.step_length();
        let mut pixel = Pixel::TRANSPARENT;
        for plane in 0..self.geometry.planes() {
            let Some((at, fraction, middle)) = self.place(plane, u, v) else {
                continue;
            };
            let [red, green, blue, of] = self.sample(at);
            if of > 0.0 {
                let opacity = self.interpolated.opacity(of, step * fraction);
                let mut colour = [red, green, blue].map(|weighted| weighted / of);
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

impl Interpolated {
    /// What a voxel is interpolated as.
    fn of(self, voxel: Voxel) -> Voxel {
        let [.., tau] = voxel;
        match self {
            Self::Opacities { distance, one } if tau > 0.0 => {
                let opacity = -(-tau * distance).exp_m1();
                let weighted = voxel.map(|channel| channel / tau * opacity);
                one.map_or(weighted, |one| {
                    weighted.map(|channel| (channel * f64::from(one)).round() / f64::from(one))
                })
            }
            _ => voxel,
        }
    }

    /// The opacity of a sample over a length.
    fn opacity(self, sample: f64, length: f64) -> f64 {
        match self {
            Self::Extinctions => -(-sample * length).exp_m1(),
            Self::Opacities { distance, .. } => -((-sample).ln_1p() * length / distance).exp_m1(),
        }
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

    /// Sampled by opacities over its own step the same sheet blocks `1 - e^-tau` where samples meet it, and less between: at half a
    /// voxel `1 - (1 - a/2)^2`, a of half a voxel. Whole numbers hold what they are rounded to.
    #[test]
    fn opacities_are_those_of_the_paper() {
        let sampling = |planes_per_voxel| Sampling {
            planes_per_voxel,
            rays_per_voxel: 1,
        };
        let blocked = |planes, distance, one| {
            let geometry = Geometry::new([0.0, 0.0, 1.0], [3, 3, 5], [1.0; 3], sampling(planes));
            let voxel = |at: [usize; 3]| if at[2] == 2 { [4.0, 1.0, 0.0, 4.0] } else { [0.0; 4] };
            let model = Absorbing::new(geometry, geometry.natural_lattice(), Positions::Exact, voxel);
            let Pixel { colour, transparency } = model
                .with_interpolated(Interpolated::Opacities { distance, one })
                .ray(1, 1);
            assert!((colour[1] - colour[0] / 4.0).abs() < 0.003, "{colour:?}");
            1.0 - transparency
        };
        let opacity = |length: f64| -(-4.0 * length).exp_m1();
        assert!((blocked(1, 1.0, None) - opacity(1.0)).abs() < 1e-12);
        let halves = 1.0 - (1.0 - opacity(0.5)) * (1.0 - opacity(0.5) / 2.0).powi(2);
        assert!((blocked(2, 0.5, None) - halves).abs() < 1e-12);
        // Over another distance they are brought to the step's.
        let corrected = 1.0 - (1.0 - opacity(0.5)) * (1.0 - opacity(1.0) / 2.0).powf(0.5).powi(2);
        assert!((blocked(2, 1.0, None) - corrected).abs() < 1e-12);
        assert!((blocked(1, 1.0, Some(255)) - (255.0 * opacity(1.0)).round() / 255.0).abs() < 1e-12);
    }

    /// A sheet by splines: 1/8, 3/4 and 1/8 of it on three planes.
    #[test]
    fn splines_spread_a_sheet() {
        let geometry = Geometry::new([0.0, 0.0, 1.0], [3, 3, 7], [1.0; 3], Sampling::default());
        let voxel = |at: [usize; 3]| if at[2] == 3 { [2.0, 1.0, 0.0, 2.0] } else { [0.0; 4] };
        let model = Absorbing::new(geometry, geometry.natural_lattice(), Positions::Exact, voxel).with_quadratic(true);
        assert!((model.sample([1.0, 1.0, 3.0])[3] - 1.5).abs() < 1e-12);
        assert!((model.sample([1.3, 0.2, 2.0])[3] - 0.25).abs() < 1e-12);
        assert!((model.sample([0.0, 2.0, 2.5])[3] - 1.0).abs() < 1e-12 && model.sample([0.0, 0.0, 6.0])[3] == 0.0);
        // Splines add up to 1 at any phase.
        assert!((1.0 - model.ray(1, 1).transparency - (1.0 - (-2.0f64).exp())).abs() < 1e-12);
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
