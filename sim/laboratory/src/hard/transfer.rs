//! Classification at its worst: checkerboards of 0 and 4095, combs, opaque walls one voxel thin.

use super::scenes::{compared, scene, volume};
use super::{Case, Size};
use slicecast_engine::error::RenderError;
use slicecast_scene::{Highlight, Light, Lighting, PrecisionName, View};

/// The largest error of three precisions on a scene.
fn three(
    mut case: Case,
    scene: &slicecast_scene::Scene,
    volume: &slicecast_volume::Volume,
    allowed: [Option<f64>; 3],
) -> Result<Case, RenderError> {
    for (precision, allowed) in PrecisionName::STAGED.into_iter().zip(allowed) {
        let comparison = compared(scene, volume, precision)?;
        case.outcome(precision.name(), comparison.image.max_lsb8, allowed);
    }
    Ok(case)
}

const OBLIQUE: View = View {
    azimuth: 33.0,
    elevation: 19.0,
    roll: 0.0,
};

/// Neighbours as different as they can be.
fn checkerboard(side: usize) -> Result<Case, RenderError> {
    let board = volume(
        [side; 3],
        [1.0; 3],
        |[x, y, z]| if (x + y + z) % 2 == 0 { 0.0 } else { 4095.0 },
    );
    let mut scene = scene(&[(0.0, 0.0), (4095.0, 0.2)]);
    scene.view = OBLIQUE;
    scene.lighting = Some(Lighting {
        highlight: Highlight::Reflection,
        lights: vec![Light::default(); 1],
        ..Lighting::default()
    });
    let mut case = Case::new(
        "checkerboard",
        format!("0 and 4095, {side}³, lit"),
        "largest error, steps of 1/255",
        0.0,
        "the same ray in f64, at the pipeline's positions",
    );
    case.note = Some(
        "limits: half a step and a tenth. Gradients of a checkerboard vanish between voxels, where the last bit of a \
         sample decides where a normal points; a sample there adds little"
            .into(),
    );
    three(case, &scene, &board, [None, Some(0.5), Some(0.1)])
}

/// A function that goes up and down every few codes, on a ramp.
fn comb(side: usize) -> Result<Case, RenderError> {
    let ramp = volume([side; 3], [1.0; 3], |[x, y, z]| {
        37.0 * x as f64 + 23.0 * y as f64 + 11.0 * z as f64 + 300.0
    });
    let teeth: Vec<(f64, f64)> = (0..512)
        .map(|n| (8.0 * f64::from(n), if n % 2 == 0 { 0.0 } else { 0.1 }))
        .collect();
    let mut scene = scene(&teeth);
    scene.view = OBLIQUE;
    let mut case = Case::new(
        "comb",
        "opacity 0 and 0.1 every 8 codes, on a ramp",
        "largest error, steps of 1/255",
        0.0,
        "the same ray in f64, at the pipeline's positions",
    );
    case.note =
        Some("limits: half a step and a tenth; the teeth end on table entries, so a linear look-up meets them".into());
    case.study =
        Some("spiky table, white noise, linear: 0.081 dithered in 1.15, 0.008 in 1.31, 36 in the paper's".into());
    three(case, &scene, &ramp, [None, Some(0.5), Some(0.1)])
}

/// One opaque slice, straight on and behind a long transparent run.
fn thin_wall(depth: usize) -> Result<Case, RenderError> {
    let wall = volume(
        [8, depth, 8],
        [1.0; 3],
        |[_, y, _]| if y == depth - 2 { 4095.0 } else { 0.0 },
    );
    let scene = scene(&[(2000.0, 0.0), (4000.0, 1.0)]);
    let mut case = Case::new(
        "thin wall",
        format!("one slice behind {} clear ones", depth - 2),
        "light that passes, steps of 1/255",
        0.0,
        "an opaque sample stops everything",
    );
    for precision in PrecisionName::STAGED {
        let frame = compared(&scene, &wall, precision)?.frame.base;
        let passed = frame.planes[3].iter().max().copied().unwrap_or(0);
        // A root of 16 bits cannot say 1: 2^-15 passes.
        case.outcome(
            precision.name(),
            255.0 * f64::from(passed) / f64::from(frame.one),
            Some(255.0 * 2f64.powi(-15) + 0.004),
        );
    }
    case.study = Some("q / 256 passes 2 steps; 65535 passes 0.008".into());
    case.note = Some("limit: 2^-15 of the light, and a unit of the pixel".into());
    Ok(case)
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    let (side, depth) = match size {
        Size::Full => (48, 2048),
        Size::Reduced => (20, 128),
    };
    Ok(vec![checkerboard(side)?, comb(side)?, thin_wall(depth)?])
}
