//! Gradients: differences of one unit, none at all, single voxels, voxels sixteen times as thick as wide.

use super::scenes::{compared, lit, scene, volume};
use super::{Case, Size};
use slicecast_compare::Comparison;
use slicecast_engine::error::RenderError;
use slicecast_scene::{PrecisionName, Scene, View};
use slicecast_volume::Volume;

/// The worst component of a normal, in units of 2^-15, against the model.
fn normal_error(comparison: &Comparison) -> f64 {
    let stage = comparison.stages.iter().find(|stage| stage.name == "gradient: normal");
    stage.map_or(f64::NAN, |stage| {
        let fraction: i32 = stage
            .format
            .split('.')
            .nth(1)
            .and_then(|f| f.parse().ok())
            .unwrap_or(15);
        stage.carried.max_ulp * 2f64.powi(15 - fraction)
    })
}

/// A case of three precisions.
fn three(
    mut case: Case,
    scene: &Scene,
    volume: &Volume,
    figure: fn(&Comparison) -> f64,
    allowed: [Option<f64>; 3],
) -> Result<Case, RenderError> {
    for (precision, allowed) in PrecisionName::STAGED.into_iter().zip(allowed) {
        let comparison = compared(scene, volume, precision)?;
        case.outcome(precision.name(), figure(&comparison), allowed);
    }
    Ok(case)
}

/// Fields whose neighbours differ by one code at most, seen obliquely.
fn low_contrast(size: Size) -> Result<Case, RenderError> {
    let side = if size == Size::Full { 40 } else { 20 };
    let field = volume([side; 3], [1.0; 3], |[x, y, z]| {
        // Every third to fifth voxel one code more, along each axis.
        1000.0 + (x as f64 / 3.0).floor() + (y as f64 / 4.0).floor() + (z as f64 / 5.0).floor()
    });
    let mut scene = scene(&[(990.0, 0.02), (1100.0, 0.02)]);
    scene.lighting = lit(0.3, 5);
    scene.view = View {
        azimuth: 33.0,
        elevation: 21.0,
        roll: 0.0,
    };
    let mut case = Case::new(
        "low contrast",
        "neighbours that differ by one code",
        "worst component of a normal, units of 2^-15",
        0.0,
        "the normal of the same voxels in f64",
    );
    case.note = Some(
        "limits: two samples err by 1.07 ulp of 12.12 (1.5 of 12.15); a gradient as short as a tenth of a code turns \
         by ten times as much, and the block adds 1.8 units"
            .into(),
    );
    let limit = |ulp: f64, bits: i32| Some(ulp * 2f64.powi(15 - bits) * 10.0 * 3f64.sqrt() + 1.8);
    three(
        case,
        &scene,
        &field,
        normal_error,
        [None, limit(1.07, 12), limit(1.5, 15)],
    )
}

/// The largest error of the base plane, steps of 1/255.
fn image_error(comparison: &Comparison) -> f64 {
    comparison.image.max_lsb8
}

/// A constant volume has no normals: nothing but ambient light.
fn no_gradient() -> Result<Case, RenderError> {
    let constant = volume([12, 9, 10], [1.0; 3], |_| 777.0);
    let mut scene = scene(&[(777.0, 1.0)]);
    scene.lighting = lit(0.3, 8);
    let mut case = Case::new(
        "no gradient",
        "opaque constant volume, ambient 0.1",
        "colour, steps of 1/255",
        25.5,
        "no normal, so ambient light only: 0.1 of white",
    );
    // Half an ulp of the ambient coefficient and half of the colour in 1.15, 2^-15 of light that passes a 16-bit root.
    for (precision, allowed) in PrecisionName::STAGED.into_iter().zip([0.02, 0.01, 0.001]) {
        let frame = compared(&scene, &constant, precision)?.frame.base;
        let centre = frame.planes[0][frame.planes[0].len() / 2];
        let value = 255.0 * f64::from(centre) / f64::from(frame.one);
        case.outcome(precision.name(), value, Some(allowed));
    }
    Ok(case)
}

/// One bright voxel in the dark.
fn single_voxel() -> Result<Case, RenderError> {
    let dot = volume([9, 9, 9], [1.0; 3], |at| if at == [4, 4, 4] { 4095.0 } else { 0.0 });
    let mut scene = scene(&[(0.0, 0.0), (4095.0, 0.8)]);
    scene.lighting = lit(0.4, 6);
    scene.sampling.planes_per_voxel = 4;
    scene.sampling.rays_per_voxel = 4;
    scene.view = View {
        azimuth: 27.0,
        elevation: 14.0,
        roll: 0.0,
    };
    let mut case = Case::new(
        "single voxel",
        "4095 among zeros, lit, 4 x 4 x 4 samples per voxel",
        "largest error, steps of 1/255",
        0.0,
        "the same ray in f64",
    );
    case.note = Some("limits: below half a step, compact's pixel over the nine planes of a ray; wide a tenth".into());
    three(case, &scene, &dot, image_error, [None, Some(0.25), Some(0.1)])
}

/// A linear field in voxels sixteen times as thick as wide.
fn anisotropy() -> Result<Case, RenderError> {
    let field = volume([24, 24, 8], [1.0, 1.0, 16.0], |[x, y, z]| {
        400.0 + 7.0 * x as f64 + 5.0 * y as f64 + 176.0 * z as f64
    });
    let mut scene = scene(&[(0.0, 1.0)]);
    scene.lighting = lit(0.0, 0);
    scene.view = View {
        azimuth: 20.0,
        elevation: -35.0,
        roll: 0.0,
    };
    // World gradient (7, 5, 11); the light stands where the viewer does.
    let length = (49.0f64 + 25.0 + 121.0).sqrt();
    let axes = scene.view.axes();
    let facing = [7.0, 5.0, 11.0]
        .iter()
        .zip(axes.forward)
        .map(|(g, f)| g * f)
        .sum::<f64>()
        / length;
    let expected = 255.0 * (0.1 + 0.9 * facing.max(0.0));
    let mut case = Case::new(
        "anisotropy",
        "1 : 16, linear field",
        "colour, steps of 1/255",
        expected,
        "0.1 + 0.9 N.L with the world's normal (7, 5, 11), every sample and the borders alike",
    );
    case.study = Some("8.8 millidegrees at 16 : 1".into());
    case.note = Some("limits: 8.8 millidegrees of the normal, and the colour's format".into());
    for (precision, allowed) in PrecisionName::STAGED.into_iter().zip([None, Some(0.05), Some(0.05)]) {
        let frame = compared(&scene, &field, precision)?.frame.base;
        // The worst of all pixels that are not clear.
        let one = f64::from(frame.one);
        let covered = frame.planes[0].iter().zip(&frame.planes[3]);
        let values = covered
            .filter(|(_, t)| **t == 0)
            .map(|(c, _)| 255.0 * f64::from(*c) / one);
        let worst = values.max_by(|a, b| (a - expected).abs().total_cmp(&(b - expected).abs()));
        case.outcome(precision.name(), worst.unwrap_or(f64::NAN), allowed);
    }
    Ok(case)
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    Ok(vec![
        low_contrast(size)?,
        no_gradient()?,
        single_voxel()?,
        anisotropy()?,
    ])
}
