//! Volumes of texels, and rays through them.

use rayon::prelude::*;
use slicecast_engine::frame::Prepared;
use slicecast_model::gradient::{normalise, spacing_factors};
use slicecast_model::{Model, ModelImage, Pixel};
use slicecast_scene::{Blend, Borders};

use super::arithmetic::{Bytes, Light, Lights, component, filtered, normalised, over, under};
use super::{Order, Texture8};

/// A scene as the hardware holds it.
pub(super) struct Frame<'a> {
    pipeline: Texture8,
    model: &'a Model<'a>,
    back_to_front: bool,
    /// In the frame (i, j, k), i fastest.
    texels: Vec<Bytes>,
    dims: [usize; 3],
    table: [Bytes; 256],
    lights: Option<Lights>,
}

/// A share of 1 as a byte.
fn byte(share: f64) -> u8 {
    (255.0 * share).round() as u8
}

impl<'a> Frame<'a> {
    /// Loads a scene.
    pub(super) fn new(pipeline: Texture8, prepared: &Prepared<'_>, model: &'a Model<'a>) -> Self {
        let voxels = prepared.volume.voxels.iter();
        let low = voxels.clone().copied().min().map_or(0.0, f64::from);
        let high = voxels.copied().max().map_or(0.0, f64::from);
        // Of a constant volume every byte is 0, and stands for its value.
        let range = (high - low).max(1.0);
        let table = std::array::from_fn(|index| {
            let classified = model.classify(low + index as f64 / 255.0 * range);
            let [red, green, blue] = classified.colour.map(byte);
            [red, green, blue, byte(classified.opacity)]
        });
        let lights = model.lights().map(|lights| Lights {
            ambient: byte(lights.ambient),
            lights: (lights.lights.iter())
                .map(|light| Light {
                    direction: light.direction.map(component),
                    diffuse: light.colour.map(|colour| byte(lights.diffuse * colour)),
                })
                .collect(),
        });
        let mut frame = Self {
            pipeline,
            model,
            back_to_front: prepared.scene.blend == Blend::BackToFront,
            texels: Vec::new(),
            dims: model.grid().dims(),
            table,
            lights,
        };
        let [ni, nj, nk] = frame.dims;
        let factors = spacing_factors(model.geometry().spacing);
        let texel = |at: [usize; 3]| {
            let grid = model.grid();
            let value = byte((grid.voxel(at) - low) / range);
            let [x, y, z] = match &frame.lights {
                Some(_) => {
                    normalise([0, 1, 2].map(|axis| grid.central_difference(at, axis) * factors[axis])).map(component)
                }
                None => [128; 3],
            };
            frame.loaded([x, y, z, value])
        };
        let rows = (0..nk * nj).into_par_iter();
        frame.texels = rows
            .flat_map_iter(|row| (0..ni).map(move |i| [i, row % nj, row / nj]))
            .map(texel)
            .collect();
        frame
    }

    /// A voxel's normal and value as its texel.
    fn loaded(&self, voxel: Bytes) -> Bytes {
        match self.pipeline.order {
            Order::After | Order::Normalised => voxel,
            Order::Before => self.classified(voxel),
            Order::Weighted => self.weighted(self.classified(voxel)),
        }
    }

    /// Colour and opacity of a normal and a value, lit.
    fn classified(&self, [x, y, z, value]: Bytes) -> Bytes {
        let [red, green, blue, alpha] = self.table[usize::from(value)];
        let colour = [red, green, blue];
        let [red, green, blue] = match &self.lights {
            Some(lights) => lights.shade(self.pipeline.product, [x, y, z], colour),
            None => colour,
        };
        [red, green, blue, alpha]
    }

    /// A colour times its opacity.
    fn weighted(&self, [red, green, blue, alpha]: Bytes) -> Bytes {
        let [red, green, blue] = [red, green, blue].map(|c| self.pipeline.product.of(c, alpha));
        [red, green, blue, alpha]
    }

    /// The weighted colour and the opacity of a sample.
    fn sample(&self, position: [f64; 3]) -> Bytes {
        // To nearest of 8 fraction bits; at the last voxel, as in front of it with a weight of 1.
        let places: [(usize, u32); 3] = std::array::from_fn(|axis| {
            let last = self.dims[axis] - 1;
            let place = ((position[axis] * 256.0 + 0.5).floor() as usize).min(last << 8);
            (place >> 8, (place & 255) as u32)
        });
        let texels = std::array::from_fn(|corner| {
            let [i, j, k] = std::array::from_fn(|axis| {
                let (first, _) = places[axis];
                (first + (corner >> axis & 1)).min(self.dims[axis] - 1)
            });
            self.texels[i + self.dims[0] * (j + self.dims[1] * k)]
        });
        let texel = filtered(texels, places.map(|(_, weight)| weight));
        match self.pipeline.order {
            Order::After => self.weighted(self.classified(texel)),
            Order::Normalised => {
                let [x, y, z, value] = texel;
                let [x, y, z] = normalised([x, y, z]);
                self.weighted(self.classified([x, y, z, value]))
            }
            Order::Before => self.weighted(texel),
            Order::Weighted => texel,
        }
    }

    /// Where the ray of a pixel is sampled on a plane.
    fn position(&self, plane: usize, u: usize, v: usize) -> Option<[f64; 3]> {
        let geometry = self.model.geometry();
        let position = self.model.position(plane, u, v)?;
        let middle = || geometry.position(self.model.lattice(), plane, u, v);
        let counts = geometry.borders == Borders::Whole || geometry.fraction(middle()) >= 0.5;
        counts.then_some(position)
    }

    fn ray(&self, u: usize, v: usize) -> Bytes {
        let planes = self.model.planes();
        let sample = |plane| self.position(plane, u, v).map(|at| self.sample(at));
        let clear = [0, 0, 0, 255];
        let product = self.pipeline.product;
        if self.back_to_front {
            (0..planes)
                .rev()
                .filter_map(sample)
                .fold(clear, |pixel, s| under(product, pixel, s))
        } else {
            (0..planes)
                .filter_map(sample)
                .fold(clear, |pixel, s| over(product, pixel, s))
        }
    }

    /// All rays.
    pub(super) fn render(&self) -> ModelImage {
        ModelImage::from_fn(self.model.lattice().size, |u, v| {
            let [red, green, blue, transparency] = self.ray(u, v).map(|byte| f64::from(byte) / 255.0);
            Pixel {
                colour: [red, green, blue],
                transparency,
            }
        })
    }
}
