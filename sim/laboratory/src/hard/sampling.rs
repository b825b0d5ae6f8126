//! Supersampling: the same fog at 1 to 16 planes per voxel, with opacities corrected for the step.

use super::scenes::{compared, scene, volume};
use super::{Case, Size};
use slicecast_engine::error::RenderError;
use slicecast_scene::PrecisionName;

/// Homogeneous fog, straight on: every ray crosses `(D - 1) r + 1` planes of `1 - (1 - a)^(1 / r)`.
fn homogeneous(depth: usize, opacity: f64, rate: u32) -> Result<Case, RenderError> {
    let fog = volume([6, depth, 6], [1.0; 3], |_| 2000.0);
    let mut scene = scene(&[(2000.0, opacity)]);
    scene.sampling.planes_per_voxel = rate;
    let planes = (depth as f64 - 1.0) * f64::from(rate) + 1.0;
    let expected = -255.0 * ((-opacity).ln_1p() * planes / f64::from(rate)).exp_m1();
    let mut case = Case::new(
        "supersampling",
        format!("{depth} slices of {opacity} a voxel, planes per voxel: {rate}"),
        "colour, steps of 1/255",
        expected,
        "1 - (1 - a)^(planes / rate)",
    );
    // A root of 16 bits: α to 2^-15 √α at most twice over for a diffused entry, on every plane; then the pixel's own
    // (0.61 of a step dithered, measured by the study; N 2^-31 in 1.31).
    let alpha = -((-opacity).ln_1p() / f64::from(rate)).exp_m1();
    let table = 255.0 * planes * 2.0 * alpha.sqrt() * 2f64.powi(-16) * (1.0 - expected / 255.0);
    for (precision, allowed) in PrecisionName::STAGED
        .into_iter()
        .zip([None, Some(table + 0.61), Some(table + 0.01)])
    {
        let frame = compared(&scene, &fog, precision)?.frame.base;
        let value = 255.0 * f64::from(frame.planes[0][0]) / f64::from(frame.one);
        case.outcome(precision.name(), value, allowed);
    }
    Ok(case)
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    let (depth, rates): (usize, &[u32]) = match size {
        Size::Full => (512, &[1, 2, 4, 8, 16]),
        Size::Reduced => (64, &[1, 16]),
    };
    let mut cases = Vec::new();
    for opacity in [0.002, 0.02] {
        for rate in rates {
            cases.push(homogeneous(depth, opacity, *rate)?);
        }
    }
    Ok(cases)
}
