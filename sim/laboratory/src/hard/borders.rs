//! Borders: the length of a ray in a volume, rims and corners too (LaMar, figures 1 to 3).

use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_model::Model;
use slicecast_scene::{Borders, Classification, Face, PrecisionName, Sampling, Scene, Surface, View};
use slicecast_volume::Volume;

use super::scenes::{scene, volume};
use super::{Case, Size};

/// The borders, by name.
const ALL: [(&str, Borders); 3] = [
    ("whole", Borders::Whole),
    ("cells", Borders::Cells),
    ("nodes", Borders::Nodes),
];

/// A ray of the base plane: from where to where it runs in the box, along k, and its voxel there.
pub(super) struct Ray {
    from: f64,
    to: f64,
    /// Voxels along i and j at k = 0.
    pub(super) start: [f64; 2],
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
    pub(super) fn steps(&self, rate: usize) -> f64 {
        (self.to - self.from) * rate as f64
    }

    /// The value at a place along k, held to the voxels.
    fn value(&self, model: &Model<'_>, z: f64) -> f64 {
        let [x, y] = [0, 1].map(|a| self.start[a] + z * self.shear[a]);
        model.value_at(model.geometry().held([x, y, z]))
    }

    /// The depth of its part in the box, of extinctions a step at places held to the voxels: a Riemann sum of midpoints.
    fn depth(&self, model: &Model<'_>, extinction: impl Fn(f64) -> f64) -> f64 {
        const PARTS: usize = 600;
        let part = (self.to - self.from) / PARTS as f64;
        let value = |n: usize| self.value(model, self.from + (n as f64 + 0.5) * part);
        (0..PARTS).map(|n| extinction(value(n)) * part).sum()
    }
}

/// Views of all sides: the first along an axis and at 45 degrees, where rays run along faces and through edges.
pub(super) fn views(count: usize) -> impl Iterator<Item = View> {
    let mut state = 2026u64;
    let mut random = move |span: f64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 * 2.0 * span - span
    };
    (0..count).map(move |n| match n {
        0 => View::default(),
        1 => View {
            azimuth: 45.0,
            ..View::default()
        },
        2 => View {
            azimuth: -135.0,
            elevation: 35.264,
            roll: 0.0,
        },
        _ => View {
            azimuth: random(180.0),
            elevation: random(90.0),
            roll: 0.0,
        },
    })
}

/// The same scene at other rates and borders, in 1.31.
pub(super) fn seen(scene: &Scene, view: View, planes: u32, borders: Borders) -> Scene {
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

/// What is left of light on each ray of a scene, and the rays.
pub(super) fn rays<R>(
    scene: &Scene,
    volume: &Volume,
    see: impl Fn(&Model<'_>, &Ray, f64) -> R,
) -> Result<Vec<R>, RenderError> {
    let prepared = Prepared::new(scene, volume)?;
    let model = model(&prepared, ModelPositions::Exact);
    let base = prepared.render(Layer::Tiles(64), &|_, _| ())?.base;
    let [width, height] = base.size;
    let pixels = (0..height).flat_map(|v| (0..width).map(move |u| [u, v]));
    Ok(pixels
        .map(|[u, v]| {
            let left = f64::from(base.planes[3][v * width + u]) / f64::from(base.one);
            see(&model, &Ray::of(&model, scene, [u, v]), left)
        })
        .collect())
}

/// A homogeneous cube from all sides: what is missing from, or too much of, each ray, in steps.
fn cube(size: Size) -> Result<Case, RenderError> {
    let count = match size {
        Size::Full => 100,
        Size::Reduced => 12,
    };
    let mut case = Case::new(
        "borders",
        format!("homogeneous cube of 8 voxels, opacity 0.1 a voxel, {count} views, every ray"),
        "largest error of a ray's length, steps",
        0.0,
        "what is left is exp(-tau times the ray's length in the box)",
    );
    let cube = volume([8; 3], [1.0; 3], |_| 1000.0);
    let points = scene(&[(0.0, 0.1)]);
    let segments = Scene {
        classification: Classification::Integral,
        ..points.clone()
    };
    let kinds = [("samples", &points), ("segments", &segments)];
    for ((kind, scene), (name, borders)) in kinds.into_iter().flat_map(|kind| ALL.map(|borders| (kind, borders))) {
        let mut worst: f64 = 0.0;
        for (n, view) in views(count).enumerate() {
            let rate = [1, 2, 3, 5][n % 4];
            let scene = seen(scene, view, rate, borders);
            let errors = rays(&scene, &cube, |model, ray, left| {
                // A step is as long as the geometry says, in voxels, which are the unit of the opacity.
                let tau = -(-0.1f64).ln_1p() * model.geometry().step_length();
                (-left.ln() / tau - ray.steps(rate as usize)).abs()
            })?;
            worst = errors.into_iter().fold(worst, f64::max);
        }
        let allowed = (borders != Borders::Whole).then_some(0.01);
        case.outcome(format!("wide, {kind}, {name}"), worst, allowed);
    }
    case.study = Some("whole: up to one step; exact borders: 0.0009 of 255 in integers, opacities apart".into());
    case.note = Some(
        "limit: what exact borders were to keep; the same rounding of the table's opacity in every step adds up".into(),
    );
    Ok(case)
}

/// A volume against the integral of its extinction over exactly the box, steps of 1/255.
fn against_integral(
    name: &str,
    (volume, alpha): (&Volume, f64),
    view: View,
    rates: &[(u32, Option<f64>)],
) -> Result<Case, RenderError> {
    let mut case = Case::new(
        "borders",
        name,
        "largest error, steps of 1/255",
        0.0,
        "the integral of the extinction over the ray's part of the box, by 600 places",
    );
    let scene = scene(&[(0.0, 0.0), (4095.0, alpha)]);
    for (name, borders) in ALL {
        for (rate, allowed) in rates {
            let scene = seen(&scene, view, *rate, borders);
            let errors = rays(&scene, volume, |model, ray, left| {
                let voxel = model.geometry().step_length() * f64::from(*rate);
                // Opacity, not extinction, is linear in the value.
                let extinction = |value: f64| -(-alpha * value / 4095.0).ln_1p() * voxel;
                255.0 * (left - (-ray.depth(model, extinction)).exp()).abs()
            })?;
            let worst = errors.iter().copied().fold(0.0, f64::max);
            let allowed = allowed.filter(|_| borders != Borders::Whole);
            case.outcome(format!("wide, {name}, {rate} planes"), worst, allowed);
        }
    }
    Ok(case)
}

/// A surface of a field that is linear from voxel to voxel and constant beyond them: a ray crosses it once, if its ends in the
/// box lie on both sides of the value.
fn surface(size: Size) -> Result<Case, RenderError> {
    const HALF: f64 = 0.5;
    let count = match size {
        Size::Full => 40,
        Size::Reduced => 9,
    };
    let mut case = Case::new(
        "borders",
        format!("surface of opacity 0.5 in a linear field, {count} views, every ray"),
        "rays with a crossing too many or too few",
        0.0,
        "one crossing where the values at the ray's entry and exit lie on both sides, none elsewhere",
    );
    for (name, borders) in ALL {
        if borders == Borders::Whole {
            continue;
        }
        let (mut wrong, mut crossed, mut rays_seen) = (0, 0, 0);
        for (n, view) in views(count).enumerate() {
            let axis = n % 3;
            let ramp = volume([7, 6, 8], [1.0; 3], |at| 1000.0 + 300.0 * at[axis] as f64);
            // In voxels, at a voxel, and between the last two.
            let value = [1450.0, 1300.0, 2377.7][n / 3 % 3];
            let face = Face {
                colour: [1.0; 3],
                opacity: HALF,
            };
            let scene = Scene {
                classification: Classification::None,
                surfaces: vec![Surface {
                    value,
                    front: face,
                    back: face,
                }],
                ..seen(&scene(&[(0.0, 0.1)]), view, [1, 2, 3, 4][n % 4], borders)
            };
            let seen = rays(&scene, &ramp, |model, ray, left| {
                let [from, to] = [ray.from, ray.to].map(|z| ray.value(model, z));
                let near = |end: f64| (end - value).abs() < 0.1;
                // Within the rounding of a position anything may be.
                let known = ray.to > ray.from && !near(from) && !near(to);
                let crosses = (from < value) != (to < value);
                let expected = if crosses { HALF } else { 1.0 };
                (known && (left - expected).abs() > 1e-4, known && crosses)
            })?;
            rays_seen += seen.len();
            wrong += seen.iter().filter(|(wrong, _)| *wrong).count();
            crossed += seen.iter().filter(|(_, crosses)| *crosses).count();
        }
        case.outcome(
            format!("wide, {name}: {crossed} of {rays_seen} rays cross"),
            wrong as f64,
            Some(0.0),
        );
    }
    Ok(case)
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    // Shears of 0.577 and 0.364 along a major axis.
    let view = View {
        azimuth: 30.0,
        elevation: 17.5,
        roll: 0.0,
    };
    let checkerboard = volume(
        [4; 3],
        [1.0; 3],
        |[x, y, z]| if (x + y + z) % 2 == 0 { 4095.0 } else { 0.0 },
    );
    let mut board = against_integral(
        "checkerboard of 4 voxels, opacity 0.5",
        (&checkerboard, 0.5),
        view,
        &[(1, None), (2, None), (4, None), (16, Some(0.25))],
    )?;
    board.study = Some("nodes, samples held: 19.4, 8.5, 1.8 at 1, 2, 4 planes; whole at 4: 48".into());
    board.note = Some(
        "what is left is the sampling's, and falls with the number of planes; the limit is a quarter of a step".into(),
    );
    let cylinder = volume([33, 17, 33], [1.0; 3], |[x, _, z]| {
        let (x, z) = (x as f64 - 16.0, z as f64 - 16.0);
        4095.0 * (1.0 - (x * x + z * z).sqrt() / 16.0).max(0.0)
    });
    let mut drum = against_integral(
        "cylinder of 33 x 17 x 33 voxels along the view, opacity 0.1 at its axis",
        (&cylinder, 0.1),
        view,
        &[(1, Some(0.15))],
    )?;
    drum.study = Some("nodes, samples held: 0.15; whole: 5.7".into());
    drum.note = Some("limit: the study's figure".into());
    Ok(vec![cube(size)?, board, drum, surface(size)?])
}
