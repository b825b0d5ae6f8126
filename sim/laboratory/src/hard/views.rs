//! Views: along the faces, at 45 degrees, and through a whole turn.

use super::scenes::{compared, scene, volume};
use super::{Case, Size};
use slicecast_compare::image::model_picture;
use slicecast_engine::error::RenderError;
use slicecast_engine::image::Rgb;
use slicecast_scene::{PrecisionName, Scene, View};
use slicecast_volume::Volume;

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
    for (precision, allowed) in PrecisionName::STAGED.into_iter().zip([None, Some(0.25), Some(0.05)]) {
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

/// All light of a picture: its red, steps of 1/255.
fn brightness(picture: &Rgb) -> f64 {
    picture.bytes.iter().step_by(3).map(|b| f64::from(*b)).sum()
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
        "the f64 model's own change: at 45 degrees planes are cut another way",
    );
    let mut turn = Case::new(
        "views",
        format!("brightness through a whole turn in steps of {step} degrees"),
        "largest difference from the model's light, %",
        0.0,
        "the f64 model's picture of the same frame",
    );
    // The light at both sides of a corner: the pipeline's and the model's.
    let light = |azimuth: f64, precision: PrecisionName| -> Result<[f64; 2], RenderError> {
        let scene = seen_from(scene, azimuth, 20.0, precision);
        let comparison = compared(&scene, volume, precision)?;
        let exact = model_picture(&comparison.model_picture, scene.image.background);
        Ok([brightness(&comparison.frame.picture), brightness(&exact)])
    };
    for (precision, allowed) in PrecisionName::STAGED.into_iter().zip([None, Some(0.05), Some(0.05)]) {
        let mut worst = [0.0f64; 2];
        for corner in [45.0, 135.0, 225.0, 315.0] {
            let (before, after) = (light(corner - 0.01, precision)?, light(corner + 0.01, precision)?);
            for ((worst, before), after) in worst.iter_mut().zip(before).zip(after) {
                *worst = worst.max(100.0 * (after / before - 1.0).abs());
            }
        }
        let [fixed, exact] = worst;
        jump.expected = exact;
        jump.outcome(precision.name(), fixed, allowed);
    }
    jump.note = Some(
        "what changes at 45 degrees is the algorithm's: planes are cut the other way, so other points of the field are \
         sampled. Limit: a twentieth of a percent from the f64 model's own change"
            .into(),
    );
    // What 8-bit pictures can differ by where every byte is right to half a step but for a few.
    for (precision, allowed) in PrecisionName::STAGED.into_iter().zip([None, Some(0.1), Some(0.1)]) {
        let mut worst: f64 = 0.0;
        let mut azimuth = 0.0;
        while azimuth < 360.0 {
            let scene = seen_from(scene, azimuth, 20.0, precision);
            let comparison = compared(&scene, volume, precision)?;
            let exact = brightness(&model_picture(&comparison.model_picture, scene.image.background));
            worst = worst.max(100.0 * (brightness(&comparison.frame.picture) / exact - 1.0).abs());
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
