//! Splatting: voxels at the borders of the image, volumes of one voxel and one slice, empty sheets, axes and diagonals; and homogeneous
//! fog, whose picture is known.

use super::scenes::{lit, scene, volume};
use super::{Case, Size};
use slicecast::splat::Layout;
use slicecast_compare::image::base_figures;
use slicecast_compare::splat::model;
use slicecast_engine::error::RenderError;
use slicecast_model::splat::Rounding;
use slicecast_scene::{PrecisionName, Scene, View};
use slicecast_splat::Splatted;
use slicecast_volume::Volume;

/// What the default record rounds.
pub(super) fn rounding() -> Rounding {
    let layout = Layout::FINE;
    Rounding {
        position: Some(layout.position_bits()),
        depth: Some(layout.depth_bits()),
        value: Some(layout.value_bits()),
    }
}

/// Along axes, edges and diagonals, and between them.
fn views() -> Vec<View> {
    let angles = [
        (0.0, 0.0, 0.0),
        (90.0, 0.0, 0.0),
        (0.0, 90.0, 0.0),
        (45.0, 0.0, 0.0),
        (45.0, 35.264_389_682_754_654, 0.0),
        (10.0, 1.0, 30.0),
        (200.0, -40.0, 13.0),
        (0.0, 0.0, 45.0),
    ];
    let view = |(azimuth, elevation, roll)| View {
        azimuth,
        elevation,
        roll,
    };
    angles.map(view).to_vec()
}

/// The largest error of views of a volume; NaN where nothing was seen in any.
fn worst(scene: &Scene, volume: &Volume, precision: PrecisionName) -> Result<f64, RenderError> {
    let (mut worst, mut values): (f64, u64) = (0.0, 0);
    for view in views() {
        let mut scene = scene.clone();
        (scene.view, scene.precision) = (view, precision);
        let splatted = Splatted::new(&scene, volume, Layout::FINE)?;
        let frame = splatted.render(&|_, _| ())?;
        let found = base_figures(&frame.base, &model(&scene, volume, &splatted, rounding()));
        worst = worst.max(found.max_lsb8);
        values += found.values;
    }
    Ok(if values > 0 { worst } else { f64::NAN })
}

/// A case of all precisions.
fn compared(name: String, scene: &Scene, volumes: &[Volume]) -> Result<Case, RenderError> {
    let mut case = Case::new(
        "splat",
        name,
        "largest error of images, steps of 1/255",
        0.0,
        "the same records in f64",
    );
    for precision in PrecisionName::STAGED {
        let mut most: f64 = 0.0;
        for volume in volumes {
            let found = worst(scene, volume, precision)?;
            // Not a number stays so.
            most = if found.is_nan() || found > most { found } else { most };
        }
        case.outcome(precision.name(), most, None);
    }
    case.note = Some("no limit: where weights add up to half, a sample exists on one side of a rounding".into());
    Ok(case)
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
    // Bright at the corners, which lie at the image's borders, and sheets without a visible sample between them.
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
            let name = format!("{what}, eight views, {how}");
            cases.push(compared(name, &scene, std::slice::from_ref(volume))?);
        }
    }
    Ok(cases)
}

/// A volume of one voxel has no sample; of two voxels, or one slice, it has.
fn thin_volumes() -> Result<Vec<Case>, RenderError> {
    let mut scene = scene(&[(0.0, 0.5)]);
    scene.lighting = lit(0.3, 5);
    let solid = |dims| volume(dims, [1.0; 3], |_| 3000.0);
    let some = [[2; 3], [9, 2, 9], [9, 9, 1]].map(solid);
    let mut clear = Case::new(
        "splat",
        "a volume of one voxel",
        "largest part of the light that is taken",
        0.0,
        "nowhere do weights add up to half of what they do within: 0.375 at most",
    );
    for precision in PrecisionName::STAGED {
        let mut most: f64 = 0.0;
        let volume = solid([1; 3]);
        for view in views() {
            let mut scene = scene.clone();
            (scene.view, scene.precision) = (view, precision);
            let base = Splatted::new(&scene, &volume, Layout::FINE)?.render(&|_, _| ())?.base;
            let taken = base.planes[3]
                .iter()
                .map(|left| f64::from(base.one - left) / f64::from(base.one));
            most = taken.fold(most, f64::max);
        }
        clear.outcome(precision.name(), most, Some(0.0));
    }
    Ok(vec![
        compared(
            "solid volumes of two voxels along an axis, eight views, lit".into(),
            &scene,
            &some,
        )?,
        clear,
    ])
}

/// Homogeneous fog along an axis: every sheet within takes the same.
fn homogeneous() -> Result<Case, RenderError> {
    let mut case = Case::new(
        "splat",
        "homogeneous fog of 32 voxels, 4 planes per voxel, along an axis",
        "what the middle pixel leaves, as a length, voxels",
        32.0,
        "samples are those of one value; a sheet at each end may be on either side of half",
    );
    let fog = volume([9, 32, 9], [1.0; 3], |_| 2000.0);
    let opacity: f64 = 0.02;
    let mut scene = scene(&[(0.0, opacity)]);
    scene.sampling.planes_per_voxel = 4;
    for precision in [PrecisionName::Compact, PrecisionName::Wide] {
        scene.precision = precision;
        (scene.view.azimuth, scene.view.elevation) = (0.0, 0.0);
        let base = Splatted::new(&scene, &fog, Layout::FINE)?.render(&|_, _| ())?.base;
        let middle = base.size[0] * (base.size[1] / 2) + base.size[0] / 2;
        let left = f64::from(base.planes[3][middle]) / f64::from(base.one);
        case.outcome(precision.name(), left.ln() / (1.0 - opacity).ln(), Some(0.5));
    }
    Ok(case)
}

/// All cases of splatting.
///
/// # Errors
/// [`RenderError`] if the machine cannot run one.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    let mut cases = against_the_model(size)?;
    cases.extend(thin_volumes()?);
    cases.push(homogeneous()?);
    Ok(cases)
}
