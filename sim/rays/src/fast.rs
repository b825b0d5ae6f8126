//! Rays in 16-bit lanes, one at a time: samples and gradients from their voxels, in numbers that hold every product.

use slicecast::borders::{WHOLE, fraction_of};
use slicecast::classify::opacity_of_root;
use slicecast::composite::{BackToFront, FrontToBack, Pixel};
use slicecast::fast::FastPhong;
use slicecast::fast::fold::{Offsets, folded};
use slicecast::fast::table::root_of;
use slicecast::precision::Fast;
use slicecast::project::{Projection, Sum};
use slicecast_engine::camera::Material;
use slicecast_engine::error::CameraError;
use slicecast_engine::fast::{Owned, table};
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::BaseImage;
use slicecast_scene::Blend;

use super::{Cells, Ray, Rays, Unobserved};

/// `(a b + 2^14) >> 15`.
fn rounded(a: i64, b: i64) -> i64 {
    (a * b + (1 << 14)) >> 15
}

fn lerp(a: i64, b: i64, w: i64) -> i64 {
    a + rounded(b - a, w)
}

fn mix(a: i64, b: i64, w: i64) -> i64 {
    if w == 0 {
        a
    } else {
        rounded(a, (1 << 15) - w) + rounded(b, w)
    }
}

/// A sample's place: its cell and the upper 15 bits of its weights.
#[derive(Clone, Copy)]
struct Place {
    cell: [i32; 3],
    weights: [i64; 3],
}

impl Place {
    fn of(cells: Cells) -> Self {
        Self {
            cell: cells.map(|c| c.index),
            weights: cells.map(|c| i64::from(c.weight.to_bits() >> 1)),
        }
    }

    /// The same in another cell.
    fn beside(self, axis: usize, by: i32) -> Self {
        let mut cell = self.cell;
        cell[axis] += by;
        Self { cell, ..self }
    }
}

struct FastRays<'r, 'a> {
    rays: &'r Rays<'a, Fast>,
    table: Owned,
    phong: Option<FastPhong>,
    floor: u16,
}

/// Renders the base plane of a frame.
pub(super) fn render(prepared: &Prepared<'_>) -> Result<BaseImage, CameraError> {
    let asked = match (prepared.scene.blend, prepared.scene.early_termination) {
        (Blend::FrontToBack, Some(bits)) => u16::MAX.checked_shr(bits).unwrap_or(0),
        _ => 0,
    };
    let rays = FastRays {
        rays: &Rays::new(Fast, prepared)?,
        table: table(&prepared.table),
        phong: prepared.setup.material.as_ref().map(Material::fast).transpose()?,
        floor: asked.max(1),
    };
    let [width, height] = rays.rays.size();
    let mut planes = [(); 4].map(|()| Vec::new());
    for (u, v) in (0..height).flat_map(|v| (0..width).map(move |u| (u, v))) {
        let pixel = rays.pixel(&rays.rays.ray([u, v]));
        let [red, green, blue] = pixel.colour;
        for (plane, bits) in planes.iter_mut().zip([red, green, blue, pixel.transparency]) {
            plane.push(bits.into());
        }
    }
    Ok(BaseImage {
        size: [width as usize, height as usize],
        format: "unorm16",
        one: 65535,
        planes,
    })
}

impl FastRays<'_, '_> {
    /// What a projection makes of a ray.
    fn projected(&self, ray: &Ray) -> Pixel<u16> {
        let mut samples = Vec::new();
        for step in 0..self.rays.planes() {
            if let Some(located) = self.rays.locate(ray, step, &mut Unobserved) {
                samples.push((self.sample(Place::of(located.cells)), located.fraction));
            }
        }
        let values = samples.iter().map(|(sample, _)| *sample as u16);
        let shown = |sum: Sum| {
            let words = (samples.iter()).fold([0; 3], |words, (s, f)| Sum::add(words, *s as i32, *f));
            sum.shown(Fast, words).map(|value| value as u16)
        };
        let shown = match self.rays.blend {
            Blend::Maximum => values.max(),
            Blend::Minimum => values.min(),
            Blend::Average => shown(Sum::Average),
            _ => shown(self.rays.additive),
        };
        let clear = Pixel {
            colour: [0; 3],
            transparency: u16::MAX,
        };
        shown.map_or(clear, |sample| {
            let (colour, root) = (self.table.colour(sample), self.table.root(sample));
            folded::<FrontToBack>(clear, colour, root, Offsets::NEAREST, 0)
        })
    }

    fn pixel(&self, ray: &Ray) -> Pixel<u16> {
        if !self.rays.blend.is_composited() {
            return self.projected(ray);
        }
        let mut pixel = Pixel {
            colour: [0; 3],
            transparency: u16::MAX,
        };
        for step in 0..self.rays.planes() {
            let Some(located) = self.rays.locate(ray, step, &mut Unobserved) else {
                continue;
            };
            let place = Place::of(located.cells);
            let sample = self.sample(place) as u16;
            let mut root = self.table.root(sample);
            if located.fraction < WHOLE {
                root = root_of(fraction_of(opacity_of_root(root), located.fraction));
            }
            let colour = self.table.colour(sample);
            let shaded = match &self.phong {
                Some(phong) => phong.shade(self.gradient(place).map(|c| c as i16), colour),
                None => colour,
            };
            let offsets = Offsets::of_plane(self.rays.index(step));
            pixel = if self.rays.blend == Blend::BackToFront {
                folded::<BackToFront>(pixel, shaded, root, offsets, self.floor)
            } else {
                folded::<FrontToBack>(pixel, shaded, root, offsets, self.floor)
            };
        }
        pixel
    }

    fn voxel(&self, ijk: [i32; 3]) -> i64 {
        i64::from(self.rays.grid.voxel(ijk))
    }

    /// Voxels along k, 12.3.
    fn along_k(&self, i: i32, j: i32, place: Place) -> i64 {
        let [_, _, k] = place.cell;
        lerp(
            8 * self.voxel([i, j, k]),
            8 * self.voxel([i, j, k + 1]),
            place.weights[2],
        )
    }

    fn along_jk(&self, i: i32, place: Place) -> i64 {
        let j = place.cell[1];
        lerp(
            self.along_k(i, j, place),
            self.along_k(i, j + 1, place),
            place.weights[1],
        )
    }

    fn along_ik(&self, j: i32, place: Place) -> i64 {
        let i = place.cell[0];
        lerp(
            self.along_k(i, j, place),
            self.along_k(i + 1, j, place),
            place.weights[0],
        )
    }

    fn sample(&self, place: Place) -> i64 {
        let i = place.cell[0];
        lerp(self.along_jk(i, place), self.along_jk(i + 1, place), place.weights[0])
    }

    /// Spaced.
    fn gradient(&self, place: Place) -> [i64; 3] {
        let last = self.rays.grid.last;
        let low = |axis: usize| place.cell[axis] <= 0;
        let high = |axis: usize| place.cell[axis] >= last[axis] - i32::from(place.weights[axis] != 0);
        let [_, _, k] = place.cell;
        let behind_k = k == 0 || k == last[2] || place.weights[2] != 0 && k + 1 == last[2];
        let halved = behind_k || (0..2).any(|axis| low(axis) || high(axis));
        let half = i32::from(halved);
        let across = |axis: usize| {
            let at = |by: i32| self.sample(place.beside(axis, by));
            if !low(axis) && !high(axis) {
                return (at(1) - at(-1)) >> half;
            }
            let before = place.cell[axis].min(last[axis] - 1).max(0);
            let along = |cell: i32| {
                if axis == 0 {
                    self.along_jk(cell, place)
                } else {
                    self.along_ik(cell, place)
                }
            };
            let rise = along((before + 1).min(last[axis])) - along(before);
            match (low(axis), high(axis)) {
                (true, true) => rise,
                (true, false) => ((at(1) - at(0)) >> 1) + (rise >> 1),
                _ => ((at(0) - at(-1)) >> 1) + (rise >> 1),
            }
        };
        // Doubled at a face, and halved in all.
        let of_voxel = |i: i32, j: i32, k: i32| {
            let (before, behind) = ((k - 1).max(0), (k + 1).min(last[2]));
            let one_sided = behind - before < 2;
            let rise = self.voxel([i, j, behind]) - self.voxel([i, j, before]);
            rise * if behind_k { 4 } else { 8 } * if one_sided { 2 } else { 1 }
        };
        let [i, j, _] = place.cell;
        let [wi, wj, wk] = place.weights;
        let column = |i: i32, j: i32| mix(of_voxel(i, j, k), of_voxel(i, j, (k + 1).min(last[2])), wk);
        let row = |i: i32| mix(column(i, j), column(i, j + 1), wj);
        let along = mix(row(i), row(i + 1), wi) >> i32::from(halved && !behind_k);
        let components = [across(0), across(1), along];
        let factors = self.rays.plan.spacing().map(|f| i64::from(f.to_bits()));
        [0, 1, 2].map(|axis| match factors[axis] {
            0x8000 => components[axis],
            factor => rounded(components[axis], factor),
        })
    }
}
