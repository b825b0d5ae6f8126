//! Clip planes: the length of a ray behind them, in slabs thinner than a step too, and what is cut away beside what is left.

use slicecast_engine::error::RenderError;
use slicecast_model::Model;
use slicecast_scene::clip::Clip;
use slicecast_scene::{Borders, Scene};

use super::borders::{homogeneous, views};
use super::scenes::{scene, waves};
use super::{Case, Size};
use crate::borders::rays::{Ray, rays, seen};

/// Planes of a cube of eight voxels: askew, through voxels and along them, beside the cube, a wedge, slabs thinner than any step,
/// a slab cut away, three planes about a corner, six about a small box askew.
const PLANES: [&[&str]; 8] = [
    &["3.3,2.7,4.1:0.4,-1,0.3"],
    &["3,3,3:1,1,1"],
    &["4,4,4:0,0,-1"],
    &["3,0,0:1,0.2,0", "0,5,0:0.3,-1,0.1"],
    &["3.2,3.9,2.2:-0.7,0.2,1:thickness=0.04"],
    &["2,2,2:0.3,0.5,-0.2:thickness=2:outside"],
    &["1.5,0,0:1,0,0", "0,2.5,0:0,1,0", "0,0,3.25:0,0,1:thickness=0.5"],
    &[
        "3,3,3:1,0.5,0",
        "5,5,5:-1,-0.5,0",
        "3,3,3:-0.5,1,0.1",
        "4,5,5:0.5,-1,-0.1",
        "3,3,3:0,0.1,1",
        "5,5,5:0,-0.1,-1",
    ],
];

fn clips(texts: &[&str]) -> Vec<Clip> {
    // Every line above is one.
    texts.iter().filter_map(|text| Clip::parse(text).ok()).collect()
}

/// The part of a ray, along k, between the faces of a hard plane on cubic voxels; `None` of a ray that runs in a face, which may be on
/// either side.
fn between(clip: &Clip, ray: &Ray, model: &Model<'_>) -> Option<[f64; 2]> {
    let geometry = model.geometry();
    let norm = clip.normal.iter().map(|n| n * n).sum::<f64>().sqrt();
    let distance = |z: f64| {
        let [i, j] = ray.place(z);
        let k = if geometry.flipped {
            geometry.dims[2] as f64 - 1.0 - z
        } else {
            z
        };
        let places = geometry.order.into_iter().zip([i, j, k]);
        places
            .map(|(axis, at)| clip.normal[axis] / norm * (at - clip.point[axis]))
            .sum::<f64>()
    };
    let (first, along) = (distance(0.0), distance(1.0) - distance(0.0));
    let far = clip.thickness.unwrap_or(f64::INFINITY);
    if along.abs() < 1e-8 {
        if first.abs().min((far - first).abs()) < 1e-6 {
            return None;
        }
        let all = if (0.0..=far).contains(&first) {
            f64::INFINITY
        } else {
            0.0
        };
        return Some([-all, all]);
    }
    let [a, b] = [-first / along, (far - first) / along];
    Some([a.min(b), a.max(b)])
}

/// What planes leave of a ray's part in the volume, along k; `None` if it runs in a face.
fn length(clips: &[Clip], ray: &Ray, model: &Model<'_>) -> Option<f64> {
    let (mut from, mut to, mut away) = (ray.from, ray.to, 0.0);
    for clip in clips {
        let [a, b] = between(clip, ray, model)?;
        if clip.outside {
            away += (b.min(ray.to) - a.max(ray.from)).max(0.0);
        } else {
            (from, to) = (from.max(a), to.min(b));
        }
    }
    Some((to - from - away).max(0.0))
}

/// A homogeneous cube from all sides: what is missing from, or too much of, each ray, in steps.
fn cube(size: Size) -> Result<Case, RenderError> {
    let count = match size {
        Size::Full => 104,
        Size::Reduced => 16,
    };
    let mut case = Case::new(
        "clip",
        format!(
            "homogeneous cube of 8 voxels, opacity 0.1 a voxel, behind 8 sets of clip planes, {count} views, every ray"
        ),
        "largest error of a ray's length, steps",
        0.0,
        "what is left is exp(-tau times the ray's length behind the planes)",
    );
    let (cube, kinds) = homogeneous();
    let borders = [("cells", Borders::Cells), ("nodes", Borders::Nodes)];
    for ((kind, scene), (name, borders)) in kinds.iter().flat_map(|kind| borders.map(|borders| (kind, borders))) {
        let (mut worst, mut longest, mut within) = (0.0f64, 0.0f64, 0);
        for (n, view) in views(count).enumerate() {
            let rate = [1, 2, 3, 5][n % 4];
            let planes = clips(PLANES[n % PLANES.len()]);
            let scene = Scene {
                clips: planes.clone(),
                ..seen(scene, view, rate, borders)
            };
            let found = rays(&scene, &cube, |model, ray, left| {
                let tau = -(-0.1f64).ln_1p() * model.geometry().step_length();
                let voxels = length(&planes, ray, model)?;
                Some(((-left.ln() / tau - voxels * f64::from(rate)).abs(), voxels))
            })?;
            within += found.values.iter().filter(|ray| ray.is_none()).count();
            for (error, voxels) in found.values.into_iter().flatten() {
                (worst, longest) = (worst.max(error), longest.max(voxels));
            }
        }
        let who = format!("wide, {kind}, {name}, rays of up to {longest:.2} voxels ({within} left out)");
        case.outcome(who, worst, Some(0.01));
    }
    case.note = Some(
        "limit: that of whole volumes and of crop boxes (groups borders and crop); rays that run in a face may be on either side of it, and are \
         left out"
            .into(),
    );
    Ok(case)
}

/// What a plane leaves and what it cuts away: together they are the whole, hard or soft.
fn halves(size: Size) -> Result<Case, RenderError> {
    let count = match size {
        Size::Full => 40,
        Size::Reduced => 10,
    };
    let mut case = Case::new(
        "clip",
        format!("waves of 9 x 8 x 7 voxels on both sides of a clip plane, {count} views, every ray"),
        "largest difference of a ray's depth, in depths of a step through the most opaque voxel",
        0.0,
        "optical depths of both sides add up to that of the whole",
    );
    let waves = waves();
    let points = scene(&[(0.0, 0.0), (4095.0, 0.1)]);
    let planes = [
        "4.1,3.3,2.9:0.5,1,-0.3",
        "4,4,3:1,0,0:falloff=2.5",
        "3.1,3,3:0.2,0.1,1:thickness=2.25",
        "4,3.7,3:-0.4,1,0.6:thickness=1.5:falloff=0.8",
    ];
    for (name, borders) in [
        ("cells", Borders::Cells),
        ("nodes", Borders::Nodes),
        ("whole", Borders::Whole),
    ] {
        let mut worst: f64 = 0.0;
        for (n, view) in views(count).enumerate() {
            let rate = [1, 2, 3, 5][n % 4];
            let scene = seen(&points, view, rate, borders);
            let depths = |clips: Vec<Clip>| {
                let scene = Scene { clips, ..scene.clone() };
                let depths = rays(&scene, &waves, |model, _, left| {
                    let tau = -(-0.1f64).ln_1p() * model.geometry().step_length();
                    -left.ln() / tau
                })?;
                Ok::<_, RenderError>(depths.values)
            };
            let inside = clips(&[planes[n % 3 + n / 3 % 2]]);
            let outside = inside.iter().map(|clip| Clip { outside: true, ..*clip }).collect();
            let (whole, inside, outside) = (depths(Vec::new())?, depths(inside)?, depths(outside)?);
            for ((whole, inside), outside) in whole.iter().zip(inside).zip(outside) {
                worst = worst.max((inside + outside - whole).abs());
            }
        }
        case.outcome(format!("wide, samples, {name}"), worst, Some(0.01));
    }
    Ok(case)
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    Ok(vec![cube(size)?, halves(size)?])
}
