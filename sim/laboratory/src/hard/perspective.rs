//! Perspective: eyes on voxel planes and between them, rays along axes, 120 degrees, volumes of one voxel; and homogeneous fog, whose
//! pictures are known.

use super::scenes::{lit, scene, volume};
use super::{Case, Size};
use slicecast_compare::perspective::compare;
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Layer;
use slicecast_engine::perspective::InPerspective;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_scene::clip::ClipUnit;
use slicecast_scene::perspective::{Eye, Perspective};
use slicecast_scene::{PrecisionName, Scene, View};
use slicecast_volume::Volume;

/// A smooth blob off the middle.
fn blob(dims: [usize; 3]) -> Volume {
    let middle = dims.map(|side| (side as f64 - 1.0) / 2.0);
    volume(dims, [1.0, 1.0, 1.2], |[x, y, z]| {
        let at = [
            x as f64 - middle[0] - 1.0,
            y as f64 - middle[1],
            z as f64 - middle[2] + 1.0,
        ];
        let square: f64 = at.iter().zip(dims).map(|(c, side)| (c / side as f64).powi(2)).sum();
        3600.0 * (-12.0 * square).exp()
    })
}

fn at(fov: f64, eye: [f64; 3]) -> Perspective {
    let unit = ClipUnit::Voxels;
    Perspective {
        fov,
        eye: Some(Eye { at: eye, unit }),
    }
}

/// The same scene in a precision, seen along a direction.
fn seen(scene: &Scene, precision: PrecisionName, azimuth: f64, elevation: f64) -> Scene {
    let mut scene = scene.clone();
    scene.precision = precision;
    scene.view = View {
        azimuth,
        elevation,
        roll: 0.0,
    };
    scene.image.size = Some([48; 2]);
    scene
}

/// Eyes about and in a blob, by the axes that they look along.
fn eyes(side: usize) -> Vec<(f64, [f64; 3], f64, f64)> {
    let side = side as f64;
    let middle = (side / 2.0).floor();
    vec![
        // On a voxel, in its plane's middle, with rays along all axes.
        (90.0, [middle; 3], 0.0, 0.0),
        (120.0, [middle + 0.5; 3], 45.0, 35.264),
        (120.0, [middle, middle + 0.5, middle - 0.25], 30.0, -20.0),
        // On the last voxel plane but one, and just beyond a face.
        (100.0, [middle, side - 2.0, middle], 180.0, 0.0),
        (100.0, [middle, -0.001, middle], 0.0, 0.0),
        // In a face, along it.
        (90.0, [0.0, middle, middle], -90.0, 0.0),
        // From afar.
        (5.0, [middle, -20.0 * side, middle], 0.0, 0.0),
        (60.0, [-side, -side, 2.0 * side], -45.0, 30.0),
    ]
}

fn against_the_model(size: Size) -> Result<Vec<Case>, RenderError> {
    let side = match size {
        Size::Full => 33,
        Size::Reduced => 17,
    };
    let mut cases = Vec::new();
    for light in [false, true] {
        let mut scene = scene(&[(0.0, 0.0), (4095.0, 0.3)]);
        if light {
            scene.lighting = lit(0.3, 5);
        }
        let mut case = Case::new(
            "perspective",
            format!("eight eyes, {}", if light { "lit" } else { "unlit" }),
            "largest error of base planes, steps of 1/255",
            0.0,
            "the same rays in f64, at exact positions",
        );
        let blob = blob([side; 3]);
        for (precision, allowed) in PrecisionName::STAGED.into_iter().zip([None, Some(0.25), Some(0.05)]) {
            let mut worst: f64 = 0.0;
            for (fov, eye, azimuth, elevation) in eyes(side) {
                let scene = seen(&scene, precision, azimuth, elevation);
                let prepared = InPerspective::new(&scene, &at(fov, eye), &blob)?;
                worst = worst.max(compare(&scene, &blob, &prepared, &|_, _| ())?.image.max_lsb8);
            }
            case.outcome(precision.name(), worst, allowed);
        }
        case.note = Some("limits: those of parallel views".into());
        cases.push(case);
    }
    Ok(cases)
}

fn thin_volumes() -> Result<Case, RenderError> {
    let mut case = Case::new(
        "perspective",
        "volumes of 1, 1 x 9 x 9, 9 x 1 x 9 and 2 x 2 x 2 voxels, from outside, lit",
        "largest error of base planes, steps of 1/255",
        0.0,
        "the same rays in f64, at exact positions",
    );
    let mut scene = scene(&[(0.0, 0.0), (4095.0, 0.9)]);
    scene.lighting = lit(0.3, 5);
    for (precision, allowed) in PrecisionName::STAGED.into_iter().zip([None, Some(0.25), Some(0.05)]) {
        let (mut worst, mut values): (f64, u64) = (0.0, 0);
        for dims in [[1; 3], [1, 9, 9], [9, 1, 9], [2; 3]] {
            let blob = blob(dims);
            for (azimuth, elevation) in [(0.0, 0.0), (90.0, 0.0), (0.0, 90.0), (40.0, 30.0)] {
                let scene = seen(&scene, precision, azimuth, elevation);
                let outside = Perspective { fov: 60.0, eye: None };
                // A volume without thickness lies between the rays of some eyes.
                let Ok(prepared) = InPerspective::new(&scene, &outside, &blob) else {
                    continue;
                };
                let found = compare(&scene, &blob, &prepared, &|_, _| ())?.image;
                worst = worst.max(found.max_lsb8);
                values += found.values;
            }
        }
        // Nothing seen is nothing compared.
        case.outcome(precision.name(), if values > 0 { worst } else { f64::NAN }, allowed);
    }
    Ok(case)
}

/// The way of a ray through the box between the outermost voxels, in the unit of the spacing.
fn way(volume: &Volume, eye: [f64; 3], direction: [f64; 3]) -> f64 {
    let (mut from, mut to) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        let [a, b] = [0.0, (volume.dims[axis] - 1) as f64].map(|face| (face - eye[axis]) / direction[axis]);
        if direction[axis] == 0.0 {
            continue;
        }
        (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
    }
    let length: f64 = (0..3).map(|a| (direction[a] * volume.spacing[a]).powi(2)).sum();
    (to - from).max(0.0) * length.sqrt()
}

/// Homogeneous fog from within: what is left of the light depends on a ray's way to the face alone, through all frames about the eye alike.
fn homogeneous(size: Size) -> Result<Case, RenderError> {
    let side = match size {
        Size::Full => 33,
        Size::Reduced => 17,
    };
    let mut case = Case::new(
        "perspective",
        "homogeneous fog from its middle, 120 degrees, 16 planes per voxel",
        "largest error of the picture, as a length, voxels",
        0.0,
        "what is left of the light is exp(-way to the face): whole borders leave up to a step at each end, where a voxel has 16",
    );
    let fog = volume([side; 3], [1.0; 3], |_| 2000.0);
    let opacity: f64 = 0.02;
    let scene = scene(&[(0.0, opacity)]);
    let eye = [(side - 1) as f64 / 2.0 + 0.2; 3];
    for precision in [PrecisionName::Compact, PrecisionName::Wide] {
        let mut scene = seen(&scene, precision, 30.0, 20.0);
        scene.sampling.planes_per_voxel = 16;
        scene.sampling.rays_per_voxel = 4;
        let prepared = InPerspective::new(&scene, &at(120.0, eye), &fog)?;
        let frame = prepared.render(Layer::Tiles(TILE_ROWS), &|_, _| ())?;
        let [width, height] = prepared.camera.size;
        let mut worst: f64 = 0.0;
        for (index, (x, y)) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).enumerate() {
            let exact = way(&fog, eye, prepared.camera.direction(x, y));
            let left = f64::from(frame.base.planes[3][index]) / f64::from(frame.base.one);
            let found = left.ln() / (1.0 - opacity).ln();
            worst = worst.max((found - exact).abs());
        }
        // Steps are up to the root of 3 sixteenths; one is lost or won at each end.
        case.outcome(precision.name(), worst, Some(2.0 * 3f64.sqrt() / 16.0));
    }
    Ok(case)
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    let mut cases = against_the_model(size)?;
    cases.push(thin_volumes()?);
    cases.push(homogeneous(size)?);
    Ok(cases)
}
