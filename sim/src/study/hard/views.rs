//! Views: along the faces, at 45 degrees, and through a whole turn.

use super::scenes::{compared, scene, volume};
use super::{Case, Size};
use crate::engine::{Layer, Prepared, RenderError, Rgb};
use crate::scene::{PrecisionName, Scene, View};
use crate::volume::Volume;

/// A smooth blob off the middle.
fn blob(side: usize) -> Volume {
    let middle = (side as f64 - 1.0) / 2.0;
    volume([side; 3], [1.0; 3], |[x, y, z]| {
        let (x, y, z) = (x as f64 - middle - 2.0, y as f64 - middle + 1.0, z as f64 - middle);
        3600.0 * (-(x * x + 1.5 * y * y + z * z) / (0.08 * (side * side) as f64)).exp()
    })
}

/// At a precision, from this side.
fn seen_from(scene: &Scene, azimuth: f64, elevation: f64, precision: PrecisionName) -> Scene {
    let view = View {
        azimuth,
        elevation,
        roll: 0.0,
    };
    Scene {
        view,
        precision,
        ..scene.clone()
    }
}

/// Grazing and 45-degree views against the model.
fn extreme_angles(volume: &Volume, scene: &Scene) -> Result<Case, RenderError> {
    let mut case = Case::new(
        "views",
        "45, 44.999, 135 and 89.9 degrees, elevations to 89.9",
        "largest error, steps of 1/255",
        0.0,
        "the same rays in f64",
    );
    let views = [(45.0, 0.0), (44.999, 35.264), (135.0, 45.0), (89.9, 0.1), (10.0, 89.9)];
    for (precision, allowed) in PrecisionName::ALL.into_iter().zip([None, Some(0.25), Some(0.05)]) {
        let mut worst: f64 = 0.0;
        for (azimuth, elevation) in views {
            let scene = seen_from(scene, azimuth, elevation, precision);
            worst = worst.max(compared(&scene, volume, precision)?.image.max_lsb8);
        }
        case.outcome(precision.name(), worst, allowed);
    }
    case.note = Some("limits: a quarter of a step for a dithered pixel, a twentieth for 1.31".into());
    Ok(case)
}

/// The sum of a picture over its area: red, steps of 1/255 times voxel areas.
fn brightness(picture: &Rgb, scale: f64) -> f64 {
    let sum: f64 = picture.bytes.iter().step_by(3).map(|b| f64::from(*b)).sum();
    sum * scale * scale
}

/// All light of the picture through a whole turn.
///
/// In this thin fog the light is the opacity of the whole volume, which hardly depends on the view; what is left of a
/// change from one frame to the next is the sampling. A jump where the major axis changes would show between 45 - d and
/// 45 + d degrees.
fn whole_turn(volume: &Volume, scene: &Scene, step: f64) -> Result<[Case; 2], RenderError> {
    let mut jump = Case::new(
        "views",
        "brightness where the major axis changes",
        "largest change of the picture's light between 44.99 and 45.01 degrees, %",
        0.0,
        "nothing happens at 45 degrees but that planes are cut another way",
    );
    let mut turn = Case::new(
        "views",
        format!("brightness through a whole turn in steps of {step} degrees"),
        "largest difference from the model's light, %",
        0.0,
        "the f64 model's picture of the same frame",
    );
    let light = |azimuth: f64, precision: PrecisionName| -> Result<f64, RenderError> {
        let scene = seen_from(scene, azimuth, 20.0, precision);
        let prepared = Prepared::new(&scene, volume)?;
        let frame = prepared.render(Layer::Tiles(32), &|_, _| ())?;
        Ok(brightness(&frame.picture, 1.0))
    };
    for (precision, allowed) in PrecisionName::ALL.into_iter().zip([None, Some(0.5), Some(0.5)]) {
        let mut worst: f64 = 0.0;
        for corner in [45.0, 135.0, 225.0, 315.0] {
            let (before, after) = (light(corner - 0.01, precision)?, light(corner + 0.01, precision)?);
            worst = worst.max(100.0 * (after / before - 1.0).abs());
        }
        jump.outcome(precision.name(), worst, allowed);
    }
    jump.note = Some(
        "limit: half a percent. The trilinear sums across y and across x differ, in f64 too; the arithmetic adds nothing \
         to that (next case)"
            .into(),
    );
    // What 8-bit pictures can differ by where every byte is right to half a step but for a few.
    for (precision, allowed) in PrecisionName::ALL.into_iter().zip([None, Some(0.1), Some(0.1)]) {
        let mut worst: f64 = 0.0;
        let mut azimuth = 0.0;
        while azimuth < 360.0 {
            let scene = seen_from(scene, azimuth, 20.0, precision);
            let comparison = compared(&scene, volume, precision)?;
            let fixed = brightness(&comparison.frame.picture, 1.0);
            let exact = crate::compare::image::model_picture(&comparison.model_picture, scene.image.background);
            worst = worst.max(100.0 * (fixed / brightness(&exact, 1.0) - 1.0).abs());
            azimuth += step;
        }
        turn.outcome(precision.name(), worst, allowed);
    }
    turn.note = Some("limit: a tenth of a percent of the light".into());
    Ok([jump, turn])
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    let (side, step) = match size {
        Size::Full => (40, 5.0),
        Size::Reduced => (20, 45.0),
    };
    let volume = blob(side);
    let scene = scene(&[(0.0, 0.0), (4095.0, 0.3)]);
    let mut cases = vec![extreme_angles(&volume, &scene)?];
    cases.extend(whole_turn(&volume, &scene, step)?);
    Ok(cases)
}
