//! Rays of a base plane, and what of each lies in the box of the volume.

use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_model::Model;
use slicecast_scene::{Borders, PrecisionName, Sampling, Scene, View};
use slicecast_volume::Volume;

use crate::hard::scenes::volume;

/// The borders, by name.
pub const ALL: [(&str, Borders); 3] = [
    ("whole", Borders::Whole),
    ("cells", Borders::Cells),
    ("nodes", Borders::Nodes),
];

/// A ray of the base plane, and its part in the box.
pub struct Ray {
    /// Where it enters the box, along k.
    pub from: f64,
    /// Where it leaves it; where it enters, if it misses it.
    pub to: f64,
    /// Its voxel on the first slice.
    pub start: [f64; 2],
    shear: [f64; 2],
}

impl Ray {
    /// The ray of pixel (u, v), clipped at the volume's box and at the scene's: their faces, one after the other.
    fn of(model: &Model<'_>, scene: &Scene, [u, v]: [usize; 2]) -> Self {
        let (geometry, lattice) = (model.geometry(), model.lattice());
        let beyond = if scene.borders == Borders::Cells { 0.5 } else { 0.0 };
        let faces = |axis: usize| {
            let last = geometry.dims[axis] as f64 - 1.0;
            let [mut low, mut high] = [-beyond, last + beyond];
            if let Some(crop) = scene.crop {
                // Voxels are the unit of these volumes.
                let [from, to] = crop.ranges[geometry.order[axis]];
                let reversed = axis == 2 && geometry.flipped;
                let [from, to] = if reversed { [last - to, last - from] } else { [from, to] };
                (low, high) = (low.max(from), high.min(to));
            }
            [low, high]
        };
        let pixel = [u, v];
        let start = [0, 1].map(|a| lattice.origin[a] as f64 + pixel[a] as f64 / geometry.rays_per_voxel as f64);
        let [mut from, mut to] = faces(2);
        for (axis, (at, s)) in start.into_iter().zip(geometry.shear).enumerate() {
            let [low, high] = faces(axis);
            if s.abs() < 1e-12 {
                if at < low || at > high {
                    to = from;
                }
                continue;
            }
            let [a, b] = [(low - at) / s, (high - at) / s];
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        Self {
            from,
            to: to.max(from),
            start,
            shear: geometry.shear,
        }
    }

    /// Its length, in steps of which there are `rate` a voxel along k.
    pub fn steps(&self, rate: usize) -> f64 {
        (self.to - self.from) * rate as f64
    }

    /// Its place along i and j at one along k.
    pub fn place(&self, z: f64) -> [f64; 2] {
        [0, 1].map(|a| self.start[a] + z * self.shear[a])
    }

    /// The value at a place along k, held to the voxels.
    pub fn value(&self, model: &Model<'_>, z: f64) -> f64 {
        let [x, y] = self.place(z);
        model.value_at(model.geometry().held([x, y, z]))
    }

    /// What it leaves of light where opacities a voxel along k of `voxel` are linear in the value, up to `alpha`.
    pub fn left(&self, model: &Model<'_>, alpha: f64, voxel: f64) -> f64 {
        // Opacity, not extinction, is linear in the value.
        let extinction = |value: f64| -(-alpha * value / 4095.0).ln_1p() * voxel;
        (-self.depth(model, extinction)).exp()
    }

    /// The depth of its part in the box, of extinctions a step at places held to the voxels: a Riemann sum of midpoints.
    fn depth(&self, model: &Model<'_>, extinction: impl Fn(f64) -> f64) -> f64 {
        const PARTS: usize = 600;
        let part = (self.to - self.from) / PARTS as f64;
        let value = |n: usize| self.value(model, self.from + (n as f64 + 0.5) * part);
        (0..PARTS).map(|n| extinction(value(n)) * part).sum()
    }
}

/// The same scene at other rates and borders, in 1.31.
pub fn seen(scene: &Scene, view: View, planes: u32, borders: Borders) -> Scene {
    Scene {
        view,
        borders,
        precision: PrecisionName::Wide,
        sampling: Sampling {
            planes_per_voxel: planes,
            rays_per_voxel: 3,
        },
        ..scene.clone()
    }
}

/// What was found of each pixel of a base plane.
pub struct Found<R> {
    /// Columns and rows, of all phases.
    pub size: [usize; 2],
    /// Row after row.
    pub values: Vec<R>,
}

/// What is left of light on each ray of a scene, and the rays.
///
/// # Errors
/// [`RenderError`] if the scene cannot be rendered.
pub fn rays<R>(
    scene: &Scene,
    volume: &Volume,
    see: impl Fn(&Model<'_>, &Ray, f64) -> R,
) -> Result<Found<R>, RenderError> {
    let prepared = Prepared::new(scene, volume)?;
    let model = model(&prepared, ModelPositions::Exact);
    let base = prepared.render(Layer::Tiles(64), &|_, _| ())?.base;
    let [width, height] = base.size;
    let pixels = (0..height).flat_map(|v| (0..width).map(move |u| [u, v]));
    let values = pixels
        .map(|[u, v]| {
            let left = f64::from(base.planes[3][v * width + u]) / f64::from(base.one);
            see(&model, &Ray::of(&model, scene, [u, v]), left)
        })
        .collect();
    Ok(Found {
        size: base.size,
        values,
    })
}

/// LaMar's checkerboard of 4 voxels a side.
pub fn checkerboard() -> Volume {
    let full = |[x, y, z]: [usize; 3]| (x + y + z).is_multiple_of(2);
    volume([4; 3], [1.0; 3], |place| if full(place) { 4095.0 } else { 0.0 })
}
