//! Rays through a volume in boxes of several levels, whose voxels are once, twice, four or eight times as long.
//!
//! Source: LaMar, adaptive border sampling, section 4 and figure 12. A place of the finest level is (x + 1/2) / 2^m - 1/2 on level m. A ray is
//! clipped to each box; the boxes that it meets come in the order of its entries. In each it is sampled on the level's own planes, as the level
//! alone would be, and what counts of a step is what lies in the box.

use std::ops::Range;

use super::clip::Left;
use super::composite::Pixel;
use super::rays::{Geometry, Lattice};
use super::render::{Model, Place, Positions, Segments};
use super::warp::ModelImage;
use slicecast_scene::{Blend, Borders, Scene};
use slicecast_volume::Volume;

/// A box of a volume.
#[derive(Clone, Debug)]
pub struct BoxOfLevel<'a> {
    /// All voxels of its level.
    pub volume: &'a Volume,
    /// The level.
    pub level: u32,
    /// The voxels of level 0 that it covers, along x, y and z.
    pub voxels: [Range<usize>; 3],
}

/// A box and the model of its level.
struct Part<'a> {
    model: Model<'a>,
    /// How many times as long its voxels are.
    scale: f64,
    /// Low and high face along i, j and k, finest voxels.
    faces: [[f64; 2]; 3],
    /// Finest voxels that the level has before the finest first slice.
    before: f64,
}

/// The f64 model of a scene in several levels.
pub struct Levels<'a> {
    finest: Geometry,
    lattice: Lattice,
    parts: Vec<Part<'a>>,
    segments: bool,
    back_to_front: bool,
}

impl<'a> Levels<'a> {
    /// A model of a scene without a crop box, on a volume of this size and spacing that some boxes cover. Rays are those of a lattice of the finest
    /// level; `crop` are the faces of a crop box along x, y and z, finest voxels.
    ///
    /// # Panics
    /// If the scene has a crop box itself, and as [`Model::new`].
    pub fn new(
        scene: &'a Scene,
        (dims, spacing): ([usize; 3], [f64; 3]),
        lattice: Lattice,
        boxes: &[BoxOfLevel<'a>],
        crop: Option<[[f64; 2]; 3]>,
        segments: Segments,
    ) -> Self {
        assert!(scene.crop.is_none(), "the crop box is in finest voxels");
        let finest =
            Geometry::new(scene.view.axes().forward, dims, spacing, scene.sampling).with_borders(Borders::Cells);
        let finest = match crop {
            None => finest,
            Some(faces) => finest.with_crop(faces),
        };
        let part = |of_level: &BoxOfLevel<'a>| {
            let scale = f64::from(1 << of_level.level);
            let ends = of_level
                .voxels
                .each_ref()
                .map(|side| [side.start, side.end].map(|end| end as f64 - 0.5));
            let model = Model::new(scene, of_level.volume, lattice, Positions::Exact).with_segments(segments);
            let before = if finest.flipped {
                scale * model.geometry().dims[2] as f64 - finest.dims[2] as f64
            } else {
                0.0
            };
            Part {
                faces: finest.with_crop(ends).faces,
                model,
                scale,
                before,
            }
        };
        Self {
            // Nothing is left of a box beside the crop box.
            parts: (boxes.iter().map(part))
                .filter(|part| part.faces.iter().all(|[low, high]| low < high))
                .collect(),
            segments: segments != Segments::Not,
            back_to_front: scene.blend == Blend::BackToFront,
            finest,
            lattice,
        }
    }

    /// The whole base plane, rows in parallel.
    pub fn render(&self) -> ModelImage {
        ModelImage::from_fn(self.lattice.size, |u, v| self.ray(u, v))
    }

    /// The pixel of one ray, composited as the scene asks.
    pub fn ray(&self, u: usize, v: usize) -> Pixel {
        let rays = self.finest.rays_per_voxel as f64;
        let start = [u, v].into_iter().zip(self.lattice.origin);
        let start: Vec<f64> = start
            .map(|(pixel, origin)| origin as f64 + pixel as f64 / rays)
            .collect();
        let mut met: Vec<([f64; 2], &Part<'_>)> = (self.parts.iter())
            .map(|part| (self.clipped([start[0], start[1]], part), part))
            .filter(|([from, to], _)| from < to)
            .collect();
        met.sort_by(|([a, _], _), ([b, _], _)| a.total_cmp(b));
        let samples = met
            .into_iter()
            .flat_map(|(way, part)| self.samples([start[0], start[1]], way, part));
        if self.back_to_front {
            let all: Vec<_> = samples.collect();
            return all
                .into_iter()
                .rev()
                .fold(Pixel::TRANSPARENT, |pixel, (colour, opacity)| {
                    pixel.back_to_front(colour, opacity)
                });
        }
        samples.fold(Pixel::TRANSPARENT, |pixel, (colour, opacity)| {
            pixel.front_to_back(colour, opacity)
        })
    }

    /// From where to where along k a ray lies in a box, finest voxels.
    fn clipped(&self, start: [f64; 2], part: &Part<'_>) -> [f64; 2] {
        let [mut from, mut to] = part.faces[2];
        for axis in [0, 1] {
            let (at, shear, [low, high]) = (start[axis], self.finest.shear[axis], part.faces[axis]);
            if shear == 0.0 {
                // Along the face between two boxes it is in the one behind.
                let last = high >= self.finest.faces[axis][1];
                if at < low || at > high || (at == high && !last) {
                    return [0.0; 2];
                }
                continue;
            }
            let [a, b] = [low, high].map(|face| (face - at) / shear);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        [from, to]
    }

    /// Colours and opacities in a box, in the order along the ray.
    fn samples(&self, start: [f64; 2], [from, to]: [f64; 2], part: &Part<'_>) -> Vec<([f64; 3], f64)> {
        let (geometry, rate) = (part.model.geometry(), part.model.geometry().planes_per_voxel as f64);
        // From places along k on the finest level to those of this one, in its voxels, and back.
        let of_level = |z: f64| (z + 0.5 + part.before) / part.scale - 0.5;
        let of_finest = |z: f64| (z + 0.5) * part.scale - 0.5 - part.before;
        let place = |z: f64| {
            let fine = of_finest(z);
            let along = |axis: usize| (start[axis] + fine * self.finest.shear[axis] + 0.5) / part.scale - 0.5;
            geometry.held([along(0), along(1), z])
        };
        let (front, back) = (of_level(from), of_level(to));
        // Steps begin half a voxel before the first slice, or those between samples as many whole ones as reach that far.
        let first = if self.segments {
            -(rate / 2.0).ceil() / rate
        } else {
            -0.5
        };
        let (begin, end) = (((front - first) * rate).floor(), ((back - first) * rate).ceil());
        let mut seen = Vec::new();
        for step in begin as i64..end as i64 {
            let ends = [step, step + 1].map(|step| first + step as f64 / rate);
            let cut = [ends[0].max(front), ends[1].min(back)];
            let fraction = (cut[1] - cut[0]) * rate;
            if fraction <= 1e-12 {
                continue;
            }
            let at = if self.segments {
                Place {
                    position: place(cut[1]),
                    front: Some(place(cut[0])),
                    fraction,
                    left: Left::WHOLE,
                    turned: 0.0,
                }
            } else {
                Place {
                    position: place((ends[0] + ends[1]) / 2.0),
                    front: None,
                    fraction,
                    left: Left::WHOLE,
                    turned: 0.0,
                }
            };
            seen.extend(part.model.seen(at));
        }
        seen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{scene_along, volume_of};

    /// A homogeneous volume in boxes of three levels is the volume: each ray has its length.
    #[test]
    fn homogeneous_boxes_are_the_volume() {
        let dims = [13_usize, 12, 11];
        let volumes = [0, 1, 2].map(|level| Volume {
            spacing: [f64::from(1 << level); 3],
            ..volume_of(dims.map(|side| side.div_ceil(1 << level)), |_, _, _| 1000)
        });
        let of_level = |level: usize, voxels| BoxOfLevel {
            volume: &volumes[level],
            level: level as u32,
            voxels,
        };
        let boxes = [
            of_level(0, [0..8, 0..12, 0..11]),
            of_level(1, [8..13, 0..4, 0..11]),
            of_level(2, [8..13, 4..12, 0..11]),
        ];
        for (forward, rate) in [
            ([0.3, -0.4, 0.9], 1),
            ([-0.8, 0.1, 0.5], 2),
            ([0.0, 0.0, -1.0], 3),
            ([0.5, 0.9, -0.2], 2),
        ] {
            let mut scene = scene_along(forward, &[(0.0, 0.1)]);
            scene.borders = Borders::Cells;
            scene.sampling.planes_per_voxel = rate;
            scene.sampling.rays_per_voxel = 2;
            for (segments, blend) in [
                (Segments::Not, Blend::FrontToBack),
                (Segments::Exact, Blend::FrontToBack),
                (Segments::Not, Blend::BackToFront),
            ] {
                scene.blend = blend;
                let whole = Model::natural(&scene, &volumes[0]).with_segments(segments);
                let levels = Levels::new(&scene, (dims, [1.0; 3]), whole.lattice(), &boxes, None, segments);
                let [width, height] = whole.lattice().size;
                for (u, v) in (0..width).flat_map(|u| (0..height).map(move |v| (u, v))) {
                    let [a, b] = [whole.ray(u, v), levels.ray(u, v)].map(|pixel| pixel.transparency);
                    assert!((a - b).abs() < 1e-9, "{forward:?} {u} {v}: {a} {b}");
                }
            }
        }
    }
}
