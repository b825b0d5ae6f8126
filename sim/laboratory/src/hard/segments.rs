//! Classified segments: thin shells against many planes of samples, and the arithmetic on jumps, combs and constant fields.
//!
//! Boxes whose edges lie half-way between two codes are what the integrals hold without error (docs/contract/integral.md);
//! what is left on them is the arithmetic.

use super::scenes::{scene, volume};
use super::{Case, Size};
use slicecast_compare::image::{ImageFigures, base_figures};
use slicecast_compare::{ModelPositions, compare, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_model::ModelImage;
use slicecast_scene::{Classification, PrecisionName, Sampling, Scene, View};
use slicecast_volume::Volume;

/// A view along no axis.
pub(super) const OBLIQUE: View = View {
    azimuth: 33.0,
    elevation: 19.0,
    roll: 0.0,
};

/// A sphere whose codes fall by 60 per voxel.
pub(super) fn sphere(side: usize) -> Volume {
    let middle = (side as f64 - 1.0) / 2.0;
    volume([side; 3], [1.0; 3], |place| {
        let square = |c: usize| (c as f64 - middle).powi(2);
        3800.0 - 60.0 * place.iter().map(|c| square(*c)).sum::<f64>().sqrt()
    })
}

/// Opaque between two codes, clear elsewhere.
fn shells(ranges: &[[f64; 2]], opacity: f64) -> Scene {
    let edges = |[low, high]: &[f64; 2]| [(*low, 0.0), (*low, opacity), (*high, opacity), (*high, 0.0)];
    Scene {
        view: OBLIQUE,
        classification: Classification::Integral,
        ..scene(&ranges.iter().flat_map(edges).collect::<Vec<_>>())
    }
}

/// The mean error against the converged integral.
pub(super) fn away(scene: &Scene, volume: &Volume, converged: &ModelImage) -> Result<f64, RenderError> {
    let frame = Prepared::new(scene, volume)?.render(Layer::Tiles(32), &|_, _| ())?;
    Ok(base_figures(&frame.base, converged).mean_lsb8)
}

/// Shells of some width, as opaque as segments can be, by samples of many planes and by segments of few.
fn thin(side: usize, width: f64) -> Result<Case, RenderError> {
    let ball = sphere(side);
    // Well inside: rays that enter by a side lose a part of a segment there.
    let shell = |share: f64| {
        let low = (3800.0 - 60.0 * share * side as f64).floor() - 0.5 - (width / 2.0).floor();
        [low, low + width]
    };
    let mut scene = shells(&[shell(0.4), shell(0.25)], 1.0 - (-16f64).exp());
    let converged = {
        let prepared = Prepared::new(&scene, &ball)?;
        model(&prepared, ModelPositions::Exact).render_integral()
    };
    let mut case = Case::new(
        "segments",
        format!("shells {width} codes wide on a sphere of {side}³"),
        "mean error, steps of 1/255",
        0.0,
        "the converged integral in f64",
    );
    scene.precision = PrecisionName::Wide;
    let mut bar = f64::INFINITY;
    for (classification, planes) in [
        (Classification::Point, 1),
        (Classification::Point, 4),
        (Classification::Point, 16),
        (Classification::Integral, 1),
        (Classification::Integral, 2),
        (Classification::Integral, 4),
    ] {
        scene.classification = classification;
        scene.sampling = Sampling {
            planes_per_voxel: planes,
            ..scene.sampling
        };
        let mean = away(&scene, &ball, &converged)?;
        let segments = classification == Classification::Integral;
        if !segments {
            bar = bar.min(mean);
        }
        let way = if segments { "segments" } else { "samples" };
        let planes = if planes == 1 {
            "1 plane".to_owned()
        } else {
            format!("{planes} planes")
        };
        case.outcome(format!("{way}, {planes}"), mean, segments.then_some(bar));
    }
    case.study = Some("means of 113, 65, 9.7 (samples of 1, 4, 16 planes) and 0.15 (segments), 3 codes wide".into());
    case.note = Some("limit of segments: the error of samples at 16 planes".into());
    Ok(case)
}

/// The arithmetic alone: against the same segments in f64, at the pipeline's positions.
pub(super) fn arithmetic(group: &'static str, name: &str, scene: &Scene, volume: &Volume) -> Result<Case, RenderError> {
    let mut case = Case::new(
        group,
        name,
        "mean error, steps of 1/255",
        0.0,
        "the same segments in f64",
    );
    for (precision, allowed) in PrecisionName::STAGED.into_iter().zip([None, Some(0.05), Some(0.02)]) {
        let scene = Scene {
            precision,
            ..scene.clone()
        };
        let prepared = Prepared::new(&scene, volume)?;
        let ImageFigures { mean_lsb8, .. } = compare(&prepared, ModelPositions::Pipeline, &|_, _| ())?.image;
        case.outcome(precision.name(), mean_lsb8, allowed);
    }
    case.note = Some("limits: the issue's bar for 1.31, and the noise of the dithered pixel".into());
    Ok(case)
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    let side = match size {
        Size::Full => 64,
        Size::Reduced => 24,
    };
    let (ball, box_side) = (sphere(side), side / 2);
    let jumps = volume(
        [box_side; 3],
        [1.0; 3],
        |[x, y, z]| if (x + y + z) % 2 == 0 { 0.0 } else { 4095.0 },
    );
    let still = volume([box_side; 3], [1.0; 3], |_| 2000.0);
    let comb: Vec<[f64; 2]> = (0..256)
        .map(|n| 16.0 * f64::from(n) + 3.5)
        .map(|low| [low, low + 5.0])
        .collect();
    Ok(vec![
        thin(side, 3.0)?,
        thin(side, 1.0)?,
        arithmetic(
            "segments",
            "shells 3 codes wide",
            &shells(&[[3199.5, 3202.5]], 0.999),
            &ball,
        )?,
        arithmetic("segments", "teeth of 5 codes every 16", &shells(&comb, 0.1), &ball)?,
        arithmetic(
            "segments",
            "teeth of 5 codes every 16, jumps of 4095",
            &shells(&comb, 0.1),
            &jumps,
        )?,
        arithmetic(
            "segments",
            "thin fog in a constant field",
            &shells(&[[1000.5, 3000.5]], 0.002),
            &still,
        )?,
        arithmetic(
            "segments",
            "thin fog over jumps of 4095",
            &shells(&[[-0.5, 4095.5]], 0.002),
            &jumps,
        )?,
    ])
}
