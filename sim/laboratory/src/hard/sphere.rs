//! Highlights and rings: the middle layers of a 512³ sphere, lit from the viewer (Squeeze, figures 3 and 4).

use super::scenes::{lit, scene, volume};
use super::{Case, Size};
use crate::catalogue::{self, Configuration};
use crate::measure::{Bench, Measured};
use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::oriented::Turned;
use slicecast_scene::Scene;
use slicecast_volume::Volume;

/// Layers of a sphere of `side` voxels, its front half: x across, y in depth, z up.
fn sphere(side: usize) -> Volume {
    let (middle, radius) = ((side as f64 - 1.0) / 2.0, 0.42 * side as f64);
    volume([side, side / 2, 6], [1.0; 3], |[x, y, z]| {
        let z = z as f64 - 2.5;
        let distance = ((x as f64 - middle).powi(2) + (y as f64 - middle).powi(2) + z * z).sqrt();
        2048.0 + (radius - distance) * 200.0
    })
}

/// The scene on the sphere, by each configuration.
fn measured(
    scene: &Scene,
    volume: &Volume,
    all: &[Configuration],
    names: &[&str],
) -> Result<Vec<(String, Measured)>, RenderError> {
    let prepared = Prepared::new(scene, volume)?;
    let model = model(&prepared, ModelPositions::Pipeline);
    let mut turned = Turned::new(volume, &prepared.setup.plan);
    let bench = Bench {
        prepared: &prepared,
        model: &model,
        slices: &turned.slices()?,
    };
    let chosen = names.iter().filter_map(|name| all.iter().find(|c| c.name == *name));
    chosen.map(|c| Ok((c.name.clone(), c.runner.compare(bench)?))).collect()
}

/// The brightest pixel, percent of full scale.
fn peak(measured: &Measured) -> f64 {
    let brightest = measured.base.planes[0].iter().max().copied().unwrap_or(0);
    100.0 * f64::from(brightest) / f64::from(measured.base.one)
}

/// Grey levels along the middle row, of 255.
fn levels(measured: &Measured) -> f64 {
    let [width, height] = measured.base.size;
    let row = &measured.base.planes[0][(height / 2) * width..][..width];
    let byte = |c: &u32| (f64::from(*c) / f64::from(measured.base.one) * 255.0).round() as u32;
    let mut bytes: Vec<_> = row.iter().map(byte).collect();
    bytes.sort_unstable();
    bytes.dedup();
    bytes.len() as f64
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    let (side, exponents): (usize, &[u32]) = match size {
        Size::Full => (512, &[4, 6, 8]),
        Size::Reduced => (128, &[6]),
    };
    let all = catalogue::all();
    let ball = sphere(side);
    let mut scene = scene(&[(2047.0, 0.0), (2049.0, 1.0)]);
    let mut cases = Vec::new();

    for n in exponents {
        // Nothing but highlight: the hardest on powers and normals.
        scene.lighting = lit(0.9, *n);
        let names = [
            "paper",
            "compact",
            "wide",
            "normal-8",
            "normal-10",
            "normal-12",
            "normal-14",
            "normal-15-nearest",
            "power-truncated",
            "power-parabola",
        ];
        let exponent = 1 << n;
        let mut case = Case::new(
            "sphere",
            format!("{side}³, highlight of exponent {exponent}"),
            "largest error, steps of 1/255",
            0.0,
            "the same surface in f64",
        );
        for (name, measured) in measured(&scene, &ball, &all, &names)? {
            // The cosine of a normal that is 8.8 mdeg off at most, and the colour's and the pixel's format.
            let allowed = match name.as_str() {
                "compact" => Some(0.25),
                "wide" => Some(0.1),
                _ => None,
            };
            case.outcome(name, measured.image.max_lsb8, allowed);
        }
        case.study = match n {
            4 => Some("highlight alone: 0.03 deferred, 1.7 with 1.12 truncated".into()),
            6 => Some("highlight alone: 0.06 deferred, 6.7 with 1.12 truncated; parabola 16 to 37".into()),
            _ => Some("highlight alone: 0.11 deferred, 26 with 1.12 truncated".into()),
        };
        case.paper = (*n == 6).then(|| {
            "a truncated power errs by at most 0.0046 % (0.012 steps); the study finds 0.068 %, 0.17 steps".to_owned()
        });
        case.note =
            Some("limits: below half a step; the parabola is one of equal area, Knittel's own is not known".into());
        cases.push(case);
    }

    // The peak: a normal that is too short loses it.
    scene.lighting = lit(0.9, 6);
    let mut case = Case::new(
        "sphere",
        format!("{side}³, peak of the highlight, exponent 64"),
        "brightest pixel, %",
        0.0,
        "ambient 0.1 and highlight 0.9 where normal, light and eye coincide, by the model",
    );
    let names = [
        "paper",
        "compact",
        "wide",
        "normal-8",
        "normal-10",
        "normal-12",
        "normal-14",
    ];
    let prepared = Prepared::new(&scene, &ball)?;
    let exact = model(&prepared, ModelPositions::Pipeline).render();
    case.expected = 100.0 * exact.rgb[0].iter().copied().fold(0.0, f64::max);
    for (name, measured) in measured(&scene, &ball, &all, &names)? {
        let allowed = match name.as_str() {
            "compact" => Some(0.05),
            "wide" => Some(0.01),
            // One unit of the normal's last place in each of the factors of the power, and the pixel.
            "normal-8" => Some(100.0 * (1.0 - (1.0 - 2f64.powi(-8)).powi(128))),
            "normal-10" => Some(100.0 * (1.0 - (1.0 - 2f64.powi(-10)).powi(128))),
            "normal-12" => Some(100.0 * (1.0 - (1.0 - 2f64.powi(-12)).powi(128))),
            "normal-14" => Some(100.0 * (1.0 - (1.0 - 2f64.powi(-14)).powi(128))),
            _ => None,
        };
        case.outcome(name, peak(&measured), allowed);
    }
    case.paper = Some("a cosine one unit short loses 22, 6.1, 1.6, 0.4 % at 8, 10, 12, 14 bits (section 4.3.1)".into());
    case.note = Some(
        "the paper's figures are those of a length one unit short; an angle of one unit changes the cosine by 2^-2F-1. \
         The limit allows two units of length"
            .into(),
    );
    cases.push(case);

    // Rings: diffuse light has fewer levels than the model.
    scene.lighting = lit(0.0, 0);
    let mut case = Case::new(
        "sphere",
        format!("{side}³, grey levels across, diffuse"),
        "different 8-bit values in the middle row",
        0.0,
        "as many as the model has",
    );
    let prepared = Prepared::new(&scene, &ball)?;
    let exact = model(&prepared, ModelPositions::Pipeline).render();
    let [width, height] = exact.size;
    let mut bytes: Vec<u32> = exact.rgb[0][(height / 2) * width..][..width]
        .iter()
        .map(|c| (c * 255.0).round() as u32)
        .collect();
    bytes.sort_unstable();
    bytes.dedup();
    case.expected = bytes.len() as f64;
    let names = [
        "paper",
        "compact",
        "wide",
        "normal-4",
        "normal-6",
        "normal-8",
        "normal-10",
        "normal-12",
        "gradient-4",
        "gradient-6",
        "gradient-8",
    ];
    for (name, measured) in measured(&scene, &ball, &all, &names)? {
        // A value at the border between two bytes may fall to the other side.
        let allowed = match name.as_str() {
            "compact" | "wide" => Some(2.0),
            _ => None,
        };
        case.outcome(name, levels(&measured), allowed);
    }
    case.paper = Some("figure 4: rings at 4 bits, 8 bits are enough for diffuse light".into());
    cases.push(case);
    Ok(cases)
}
