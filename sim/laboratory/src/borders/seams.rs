//! Figure 12: volumes in boxes of several levels, what of each ray lies in which box, and the paper's cylinder.

use serde::Serialize;
use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::Rgb;
use slicecast_engine::levels::Leveled;
use slicecast_engine::levels::tree::Tree;
use slicecast_model::Model;
use slicecast_pyramid::scalar::halved;
use slicecast_scene::{Borders, Sampling, Scene, View};
use slicecast_volume::Volume;

use super::figures::{LOUDER, grey};
use super::rays::{Found, seen};
use crate::hard::scenes::{scene, volume};

/// Opacity a voxel of the cylinder's axis, as in the study.
const OPACITY: f64 = 0.1;
/// Voxels of the cylinder along each axis.
const SIDE: usize = 64;
/// Rays per voxel, each way.
const RAYS: u32 = 2;

/// A level of a volume: its voxels, as its f64 model has them.
struct Level<'a> {
    model: Model<'a>,
    /// Voxels of level 0 that it has before the first slice.
    before: f64,
    scale: f64,
}

/// What of a ray lies in a box.
struct Piece {
    level: usize,
    /// From where to where along k, in voxels of level 0.
    way: [f64; 2],
}

/// A ray of the base plane and the boxes that it meets.
pub struct Ray<'a> {
    levels: &'a [Level<'a>],
    start: [f64; 2],
    shear: [f64; 2],
    pieces: Vec<Piece>,
}

impl Ray<'_> {
    /// Its length in all boxes, voxels along k.
    pub fn length(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.way[1] - piece.way[0]).sum()
    }

    /// Whether it meets boxes of several levels.
    pub fn meets_a_seam(&self) -> bool {
        self.pieces.iter().any(|piece| piece.level != self.pieces[0].level)
    }

    /// The value of a level at a place along k.
    fn value(&self, level: usize, z: f64) -> f64 {
        let Level { model, before, scale } = &self.levels[level];
        let along = |axis: usize| (self.start[axis] + z * self.shear[axis] + 0.5) / scale - 0.5;
        model.value_at(
            model
                .geometry()
                .held([along(0), along(1), (z + 0.5 + before) / scale - 0.5]),
        )
    }

    /// What it leaves of light where opacities a voxel along k of `voxel` are linear in the value, up to `alpha`: midpoints, 32 a voxel.
    pub fn left(&self, alpha: f64, voxel: f64) -> f64 {
        let depth = |piece: &Piece| {
            let [from, to] = piece.way;
            let parts = ((to - from) * 32.0).ceil().max(1.0);
            let part = (to - from) / parts;
            let place = |n: usize| from + (n as f64 + 0.5) * part;
            let extinction = |n: usize| extinction(self.value(piece.level, place(n)), alpha);
            (0..parts as usize).map(|n| extinction(n) * voxel * part).sum::<f64>()
        };
        (-self.pieces.iter().map(depth).sum::<f64>()).exp()
    }

    /// The same with bricks as most renderers have them: from their first voxel's centre to their last one's, sampled on planes a voxel of their
    /// level apart, each sample a whole step.
    fn left_by_whole_steps(&self, faces: &[[[f64; 2]; 3]], alpha: f64, voxel: f64) -> f64 {
        let mut depth = 0.0;
        for (level, faces) in faces.iter().enumerate() {
            let scale = self.levels[level].scale;
            let half = scale / 2.0;
            let [front, back] = faces[2];
            let planes = ((back - front) / scale).round() as usize;
            for plane in 0..planes {
                let z = front + half + plane as f64 * scale;
                let at = [0, 1].map(|axis| self.start[axis] + z * self.shear[axis]);
                let inside = |axis: usize| faces[axis][0] + half <= at[axis] && at[axis] <= faces[axis][1] - half;
                if inside(0) && inside(1) {
                    depth += extinction(self.value(level, z), alpha) * voxel * scale;
                }
            }
        }
        (-depth).exp()
    }
}

/// Opacity, not extinction, is linear in the value.
fn extinction(value: f64, alpha: f64) -> f64 {
    -(-alpha * value / 4095.0).ln_1p()
}

/// What is left of light on each ray of a scene whose volume is cut so, and the rays. `see` is told the length of a step of one voxel along k.
///
/// # Errors
/// [`RenderError`] if the scene cannot be rendered.
pub fn rays<R>(
    scene: &Scene,
    finest: &Volume,
    tree: &Tree,
    see: impl Fn(&Ray<'_>, f64, f64) -> R,
) -> Result<Found<R>, RenderError> {
    let prepared = Prepared::new(scene, finest)?;
    let leveled = Leveled::new(&prepared, tree)?;
    let base = leveled.render(&leveled.bricks(finest, &|_, _| ())?, &|_, _| ())?.base;
    let leaves = tree.leaves(finest.dims, [true; 3])?;
    let coarsest = leaves.iter().map(|leaf| leaf.level).max().unwrap_or(0);
    let volumes: Vec<Volume> = std::iter::successors(Some(finest.clone()), |volume| Some(halved(volume)))
        .take(coarsest as usize + 1)
        .collect();
    let of_finest = model(&prepared, ModelPositions::Exact);
    let (geometry, lattice) = (*of_finest.geometry(), of_finest.lattice());
    let levels: Vec<Level<'_>> = (0..)
        .zip(&volumes)
        .map(|(level, volume)| {
            let scale = f64::from(1 << level);
            let model = Model::natural(scene, volume);
            let beyond = scale * model.geometry().dims[2] as f64 - geometry.dims[2] as f64;
            Level {
                before: if geometry.flipped { beyond } else { 0.0 },
                model,
                scale,
            }
        })
        .collect();
    // Faces along i, j and k.
    let boxes: Vec<([[f64; 2]; 3], usize)> = (leaves.iter())
        .map(|leaf| {
            let mut faces = geometry.order.map(|axis| {
                let side = &leaf.voxels[axis];
                [side.start as f64 - 0.5, side.end as f64 - 0.5]
            });
            if geometry.flipped {
                let last = geometry.dims[2] as f64 - 1.0;
                faces[2] = [last - faces[2][1], last - faces[2][0]];
            }
            (faces, leaf.level as usize)
        })
        .collect();
    let ends = [0, 1].map(|axis| geometry.dims[axis] as f64 - 0.5);
    let step = geometry.step_length() * geometry.planes_per_voxel as f64;
    let [width, height] = base.size;
    let pixels = (0..height).flat_map(|v| (0..width).map(move |u| [u, v]));
    let values = pixels.map(|[u, v]| {
        let pixel = [u, v];
        let start = [0, 1].map(|a| lattice.origin[a] as f64 + pixel[a] as f64 / geometry.rays_per_voxel as f64);
        let clipped = |(faces, level): &([[f64; 2]; 3], usize)| {
            let [mut from, mut to] = faces[2];
            for axis in [0, 1] {
                let ([low, high], s) = (faces[axis], geometry.shear[axis]);
                if s.abs() < 1e-12 {
                    let inside =
                        low <= start[axis] && (start[axis] < high || (high >= ends[axis] && start[axis] <= high));
                    if !inside {
                        to = from;
                    }
                    continue;
                }
                let [a, b] = [(low - start[axis]) / s, (high - start[axis]) / s];
                (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
            }
            (to > from).then_some(Piece {
                level: *level,
                way: [from, to],
            })
        };
        let ray = Ray {
            levels: &levels,
            start,
            shear: geometry.shear,
            pieces: boxes.iter().filter_map(clipped).collect(),
        };
        let left = f64::from(base.planes[3][v * width + u]) / f64::from(base.one);
        see(&ray, step, left)
    });
    Ok(Found {
        values: values.collect(),
        size: base.size,
    })
}

/// Errors of a cylinder of two resolutions, in steps of 1/255.
#[derive(Clone, Debug, Serialize)]
pub struct Seam {
    /// Which way the halves lie on each other, and the view.
    pub name: &'static str,
    /// Planes per voxel of each level.
    pub planes: u32,
    /// Largest and mean error, and the mean of rays through both halves: bricks of whole steps.
    pub whole: [f64; 3],
    /// The same of boxes of levels.
    pub levels: [f64; 3],
}

/// The cylinder about z, or about y, of linear density; and its cut across z in the middle, the half behind of voxels twice as long.
fn cylinder(about: usize) -> (Volume, Tree) {
    let middle = (SIDE as f64 - 1.0) / 2.0;
    let cylinder = volume([SIDE; 3], [1.0; 3], |place| {
        let [a, b] = if about == 2 { [0, 1] } else { [0, 2] };
        let radius = (place[a] as f64 - middle).hypot(place[b] as f64 - middle);
        4095.0 * (1.0 - radius / (SIDE as f64 / 2.0)).max(0.0)
    });
    let tree = Tree::Cut {
        axis: about,
        at: SIDE / 2,
        parts: Box::new([Tree::Leaf(0), Tree::Leaf(1)]),
    };
    (cylinder, tree)
}

/// A view along (i, 1, j) in voxels.
fn sheared([i, j]: [f64; 2]) -> View {
    View {
        azimuth: (-i).atan2(1.0).to_degrees(),
        elevation: (-j).atan2(i.hypot(1.0)).to_degrees(),
        roll: 0.0,
    }
}

/// The study's three arrangements: stacked across the view twice, and along it.
const VIEWS: [(&str, usize, [f64; 2]); 3] = [
    ("across the view, shears 0.3 and 0.2", 2, [0.3, 0.2]),
    ("across the view, shears 0.577 and 0.364", 2, [0.577, 0.364]),
    ("along the view, shears 0.1 and 0.9", 1, [0.1, 0.9]),
];

/// What is left of light on each ray: rendered, exact, by whole steps; and whether it passes the seam.
type Light = ([f64; 3], bool);

fn lights(about: usize, shears: [f64; 2], planes: u32) -> Result<Found<Light>, RenderError> {
    let (cylinder, tree) = cylinder(about);
    let scene = scene(&[(0.0, 0.0), (4095.0, OPACITY)]);
    let scene = Scene {
        sampling: Sampling {
            planes_per_voxel: planes,
            rays_per_voxel: RAYS,
        },
        ..seen(&scene, sheared(shears), planes, Borders::Cells)
    };
    // Both halves along i, j and k: the view is along y.
    let [all, near, far] = [[0, SIDE], [0, SIDE / 2], [SIDE / 2, SIDE]].map(|side| side.map(|end| end as f64 - 0.5));
    let halves = [near, far].map(|half| if about == 2 { [all, half, all] } else { [all, all, half] });
    rays(&scene, &cylinder, &tree, |ray, step, left| {
        let whole = ray.left_by_whole_steps(&halves, OPACITY, step);
        ([left, ray.left(OPACITY, step), whole], ray.meets_a_seam())
    })
}

/// Figure 12: the cylinder's errors.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn errors() -> Result<Vec<Seam>, RenderError> {
    let mut all = Vec::new();
    for (name, about, shears) in VIEWS {
        for planes in [1, 2] {
            let lights = lights(about, shears, planes)?.values;
            // Rays that leave all light say nothing.
            let met: Vec<_> = lights.iter().filter(|([_, exact, _], _)| *exact < 1.0).collect();
            let of = |which: usize| {
                let error = |light: &Light| 255.0 * (light.0[which] - light.0[1]).abs();
                let mean = |errors: Vec<f64>| errors.iter().sum::<f64>() / errors.len().max(1) as f64;
                let most = met.iter().map(|light| error(light)).fold(0.0, f64::max);
                let at_seam = met.iter().filter(|(_, seam)| *seam);
                [
                    most,
                    mean(met.iter().map(|light| error(light)).collect()),
                    mean(at_seam.map(|light| error(light)).collect()),
                ]
            };
            all.push(Seam {
                name,
                planes,
                whole: of(2),
                levels: of(0),
            });
        }
    }
    Ok(all)
}

/// Figure 12: opacities of the cylinder in the first view, one plane per voxel: the integral, bricks of whole steps and boxes of levels, and four
/// times the difference of each from the integral.
///
/// # Errors
/// [`RenderError`] if the scene cannot be rendered.
pub fn pictures() -> Result<Vec<(String, Rgb)>, RenderError> {
    let (_, about, shears) = VIEWS[0];
    let Found { size, values } = lights(about, shears, 1)?;
    let picture = |of: &dyn Fn([f64; 3]) -> f64| grey(size, 2, |at| of(values[at].0));
    Ok(vec![
        ("integral".into(), picture(&|[_, exact, _]| 1.0 - exact)),
        ("whole steps".into(), picture(&|[_, _, whole]| 1.0 - whole)),
        (
            "difference x 4".into(),
            picture(&|[_, exact, whole]| LOUDER * (whole - exact).abs()),
        ),
        ("levels".into(), picture(&|[left, ..]| 1.0 - left)),
        (
            "difference x 4".into(),
            picture(&|[left, exact, _]| LOUDER * (left - exact).abs()),
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's claim: bricks of whole steps show the seam, exact borders do not.
    #[test]
    fn there_is_no_seam() {
        let seams = errors().unwrap();
        for Seam {
            name,
            planes,
            whole: [most, ..],
            levels: [of_levels, mean, at_seam],
        } in &seams
        {
            assert!(
                *of_levels < 1.0 && *at_seam < 2.0 * mean + 0.02,
                "{name}, {planes}: {of_levels} {at_seam} {mean}"
            );
            assert!(*most > 5.0 * of_levels, "{name}, {planes}: {most}");
        }
        assert!(seams[0].whole[0] > 30.0);
    }
}
