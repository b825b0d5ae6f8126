//! Splatting in perspective: eyes on a voxel plane, within and just before the volume, 120 degrees, voxels at the border of the image,
//! volumes of one voxel and one slice, empty sheets; and homogeneous fog, whose picture is known.

use super::scenes::{lit, scene, volume};
use super::splat::rounding;
use super::{Case, Size};
use slicecast::splat::Layout;
use slicecast_compare::image::base_figures;
use slicecast_compare::splat::model;
use slicecast_engine::error::RenderError;
use slicecast_scene::clip::ClipUnit;
use slicecast_scene::perspective::{Eye, Perspective};
use slicecast_scene::{PrecisionName, Scene, View};
use slicecast_splat::Splatted;
use slicecast_volume::Volume;

/// A field of view, an eye, and the view's azimuth and elevation.
type Eyes = Vec<(f64, [f64; 3], f64, f64)>;

/// Eyes about a volume and in it.
fn eyes(side: usize) -> Eyes {
    let side = side as f64;
    let middle = (side / 2.0).floor();
    vec![
        // On a voxel plane, and between two.
        (90.0, [middle; 3], 0.0, 0.0),
        (120.0, [middle + 0.5, 1.0, middle], 20.0, -11.0),
        // On the first voxel plane, and just before it.
        (100.0, [middle, 0.0, middle], 0.0, 0.0),
        (100.0, [middle, -0.001, middle], 0.0, 0.0),
        // Beside it: most voxels lie at the border of the image and beyond.
        (40.0, [-0.6 * side, -0.4 * side, middle], -20.0, 5.0),
        // From outside, and from afar.
        (60.0, [middle, -1.2 * side, middle], 0.0, 0.0),
        (5.0, [middle, -24.0 * side, middle], 0.0, 0.0),
    ]
}

/// A scene seen so.
fn seen(scene: &Scene, precision: PrecisionName, (fov, at, azimuth, elevation): (f64, [f64; 3], f64, f64)) -> Scene {
    let mut scene = scene.clone();
    scene.precision = precision;
    scene.view = View {
        azimuth,
        elevation,
        roll: 0.0,
    };
    let unit = ClipUnit::Voxels;
    scene.perspective = Some(Perspective {
        fov,
        eye: Some(Eye { at, unit }),
    });
    scene.image.size = Some([40; 2]);
    scene
}

/// Cases of all precisions: the largest error and the mean one.
fn compared(name: &str, scene: &Scene, volume: &Volume, eyes: &Eyes) -> Result<[Case; 2], RenderError> {
    let of = |quantity| Case::new("splat from an eye", name, quantity, 0.0, "the same records in f64");
    let mut cases = [
        of("largest error of images, steps of 1/255"),
        of("mean error of images, steps of 1/255"),
    ];
    for precision in PrecisionName::STAGED {
        let (mut most, mut mean, mut values): (f64, f64, u64) = (0.0, 0.0, 0);
        for eye in eyes {
            let scene = seen(scene, precision, *eye);
            let splatted = Splatted::new(&scene, volume, Layout::FINE)?;
            let frame = splatted.render(&|_, _| ())?;
            let found = base_figures(&frame.base, &model(&scene, volume, &splatted, rounding()));
            most = most.max(found.max_lsb8);
            if found.values > 0 {
                mean = mean.max(found.mean_lsb8);
            }
            values += found.values;
        }
        let [largest, average] = &mut cases;
        let seen = |figure: f64| if values > 0 { figure } else { f64::NAN };
        largest.outcome(precision.name(), seen(most), None);
        // Paper's pixels have 8 bits: half a step of each.
        let allowed = match precision {
            PrecisionName::Paper => 1.0,
            _ => 0.1,
        };
        average.outcome(precision.name(), seen(mean), Some(allowed));
    }
    cases[0].note = Some("no limit: where weights add up to half, a sample exists on one side of a rounding".into());
    Ok(cases)
}

fn against_the_model(size: Size) -> Result<Vec<Case>, RenderError> {
    let side = match size {
        Size::Full => 25,
        Size::Reduced => 13,
    };
    let middle = (side as f64 - 1.0) / 2.0;
    let blob = volume([side; 3], [1.0, 1.0, 1.2], |at| {
        let square: f64 = at.iter().map(|c| ((*c as f64 - middle) / side as f64).powi(2)).sum();
        3600.0 * (-12.0 * square).exp()
    });
    // Bright at the corners, with sheets between them that nothing is seen in.
    let corners = volume([side; 3], [1.0; 3], |at| {
        let ends = at.iter().all(|c| *c < 3 || *c + 3 >= side);
        if ends { 4000.0 } else { 0.0 }
    });
    let mut cases = Vec::new();
    for light in [false, true] {
        let mut scene = scene(&[(0.0, 0.0), (4095.0, 0.3)]);
        if light {
            scene.lighting = lit(0.3, 5);
        }
        let how = if light { "lit" } else { "unlit" };
        for (what, volume) in [("a blob", &blob), ("corners, empty between", &corners)] {
            let name = format!("{what}, seven eyes, {how}");
            cases.extend(compared(&name, &scene, volume, &eyes(side))?);
        }
    }
    let mut scene = scene(&[(0.0, 0.5)]);
    scene.lighting = lit(0.3, 5);
    let slice = volume([9, 1, 9], [1.0; 3], |_| 3000.0);
    let before = vec![(60.0, [4.0, -9.0, 4.0], 0.0, 0.0), (30.0, [3.0, -30.0, 5.0], 0.0, 3.0)];
    cases.extend(compared("a slice, two eyes, lit", &scene, &slice, &before)?);
    Ok(cases)
}

/// A volume of one voxel has no sample.
fn one_voxel() -> Result<Case, RenderError> {
    let mut case = Case::new(
        "splat from an eye",
        "a volume of one voxel",
        "largest part of the light that is taken",
        0.0,
        "nowhere do weights add up to half of what they do within: 0.375 at most",
    );
    let scene = scene(&[(0.0, 0.5)]);
    let volume = volume([1; 3], [1.0; 3], |_| 3000.0);
    for precision in PrecisionName::STAGED {
        let mut most: f64 = 0.0;
        for eye in [(40.0, [0.3, -12.0, 0.1], 0.0, 0.0), (120.0, [0.0, -3.0, 0.0], 0.0, 0.0)] {
            let scene = seen(&scene, precision, eye);
            let base = Splatted::new(&scene, &volume, Layout::FINE)?.render(&|_, _| ())?.base;
            let taken = base.planes[3]
                .iter()
                .map(|left| f64::from(base.one - left) / f64::from(base.one));
            most = taken.fold(most, f64::max);
        }
        case.outcome(precision.name(), most, Some(0.0));
    }
    Ok(case)
}

/// Homogeneous fog: a ray to the side is longer by what its slope says.
fn homogeneous() -> Result<Case, RenderError> {
    let mut case = Case::new(
        "splat from an eye",
        "homogeneous fog of 32 voxels, 4 planes per voxel, 45 degrees to the side",
        "length that a pixel there sees, to that of the middle",
        std::f64::consts::SQRT_2,
        "steps are longer by the secant; sheets at the ends may be on either side of half",
    );
    let fog = volume([161, 32, 9], [1.0; 3], |_| 2000.0);
    let opacity: f64 = 0.02;
    let mut scene = scene(&[(0.0, opacity)]);
    scene.sampling.planes_per_voxel = 4;
    for precision in [PrecisionName::Compact, PrecisionName::Wide] {
        let mut scene = seen(&scene, precision, (100.0, [80.0, -20.0, 4.0], 0.0, 0.0));
        scene.image.size = Some([201; 2]);
        let base = Splatted::new(&scene, &fog, Layout::FINE)?.render(&|_, _| ())?.base;
        let [width, height] = base.size;
        let length = |slope: f64| {
            let finer = width as f64 / 201.0;
            let distance = 201.0 * finer / 2.0 / 50f64.to_radians().tan();
            let column = ((width as f64 - 1.0) / 2.0 + slope * distance).round() as usize;
            let left = f64::from(base.planes[3][width * (height / 2) + column]) / f64::from(base.one);
            left.ln() / (1.0 - opacity).ln()
        };
        // A sheet more or less of 128, and half a pixel.
        case.outcome(precision.name(), length(1.0) / length(0.0), Some(0.03));
    }
    Ok(case)
}

/// All cases of splatting in perspective.
///
/// # Errors
/// [`RenderError`] if the machine cannot run one.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    let mut cases = against_the_model(size)?;
    cases.push(one_voxel()?);
    cases.push(homogeneous()?);
    Ok(cases)
}
