//! Borders: the length of a ray in a volume, rims and corners too (LaMar, figures 1 to 3).

use slicecast_engine::error::RenderError;
use slicecast_scene::{Borders, Classification, Face, Scene, Surface, View};
use slicecast_volume::Volume;

use super::scenes::{scene, volume};
use super::{Case, Size};
use crate::borders::rays::{ALL, checkerboard, rays, seen};

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

/// A homogeneous cube, of samples and of segments.
pub(super) fn homogeneous() -> (Volume, [(&'static str, Scene); 2]) {
    let points = scene(&[(0.0, 0.1)]);
    let segments = Scene {
        classification: Classification::Integral,
        ..points.clone()
    };
    let cube = volume([8; 3], [1.0; 3], |_| 1000.0);
    (cube, [("samples", points), ("segments", segments)])
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
    let (cube, kinds) = homogeneous();
    for ((kind, scene), (name, borders)) in kinds.iter().flat_map(|kind| ALL.map(|borders| (kind, borders))) {
        let mut worst: f64 = 0.0;
        for (n, view) in views(count).enumerate() {
            let rate = [1, 2, 3, 5][n % 4];
            let scene = seen(scene, view, rate, borders);
            let errors = rays(&scene, &cube, |model, ray, left| {
                // A step is as long as the geometry says, in voxels, which are the unit of the opacity.
                let tau = -(-0.1f64).ln_1p() * model.geometry().step_length();
                (-left.ln() / tau - ray.steps(rate as usize)).abs()
            })?;
            worst = errors.values.into_iter().fold(worst, f64::max);
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
                255.0 * (left - ray.left(model, alpha, voxel)).abs()
            })?;
            let worst = errors.values.iter().copied().fold(0.0, f64::max);
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
            let seen = seen.values;
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
    let mut board = against_integral(
        "checkerboard of 4 voxels, opacity 0.5",
        (&checkerboard(), 0.5),
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
