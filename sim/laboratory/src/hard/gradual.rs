//! What gradients and sums decide: modulation at the ends of the magnitude, sums of the longest rays, reflectance maps on a sphere.

use slicecast_compare::{ModelPositions, compare};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_scene::modulation::Modulation;
use slicecast_scene::reflectance::{Filter, Reflectance};
use slicecast_scene::{Blend, PrecisionName, Sampling, Scene};
use slicecast_volume::Volume;

use super::scenes::{lit, scene, volume};
use super::{Case, Size};

/// The largest error of a scene's base plane, and the least transparency of a pixel.
fn against_f64(scene: &Scene, volume: &Volume) -> Result<(f64, f64), RenderError> {
    let prepared = Prepared::new(scene, volume)?;
    let comparison = compare(&prepared, ModelPositions::Pipeline, &|_, _| ())?;
    let [.., transparency] = &comparison.frame.base.planes;
    let least = transparency.iter().min().copied().unwrap_or(0);
    let one = f64::from(comparison.frame.base.one);
    Ok((comparison.image.max_lsb8, f64::from(least) / one))
}

/// Ramps across the view from the flattest to the steepest that there are: one factor, whatever the place.
fn ramps() -> Result<Case, RenderError> {
    let mut case = Case::new(
        "modulation",
        "ramps of 8 to 512 codes a voxel, opacity 0.1 times 0.5 at that gradient and 0 at twice and half of it",
        "largest error of a ray's depth, in steps",
        0.0,
        "a ramp has one gradient: 9 samples leave (1 - 0.05)^9",
    );
    for precision in [PrecisionName::Compact, PrecisionName::Wide] {
        let mut worst: f64 = 0.0;
        for slope in [8.0, 16.0, 64.0, 256.0, 512.0] {
            let ramp = volume([8, 9, 7], [1.0; 3], |[x, ..]| 100.0 + slope * x as f64);
            let mut scene = scene(&[(0.0, 0.1)]);
            scene.precision = precision;
            scene.modulation = Some(Modulation {
                // Nodes lie at powers of 2 and half of them: the factor is one of a node.
                opacity: vec![
                    [slope / 2.0, 0.0],
                    [slope * 0.8, 0.5],
                    [slope * 1.25, 0.5],
                    [slope * 2.0, 0.0],
                ],
                ..Modulation::default()
            });
            let (_, left) = against_f64(&scene, &ramp)?;
            let steps = left.ln() / (1.0f64 - 0.05).ln();
            worst = worst.max((steps - 9.0).abs());
        }
        let allowed = if precision == PrecisionName::Wide { 0.005 } else { 0.02 };
        case.outcome(precision.name(), worst, Some(allowed));
    }
    case.note = Some("limit: the pixel's own format over nine steps, and a unit of 2^-15 of the factor".into());
    Ok(case)
}

/// Where nothing changes, a factor of 0 for no gradient leaves nothing.
fn flat() -> Result<Case, RenderError> {
    let mut case = Case::new(
        "modulation",
        "a constant volume, opacity 0.5, factor 0 without a gradient",
        "opacity, percent",
        0.0,
        "there is no gradient anywhere",
    );
    let block = volume([6, 5, 4], [1.0, 0.5, 2.0], |_| 3000.0);
    for precision in PrecisionName::STAGED {
        let mut scene = scene(&[(0.0, 0.5)]);
        scene.precision = precision;
        scene.modulation = Some(Modulation {
            opacity: vec![[0.0, 0.0], [1.0, 1.0]],
            ..Modulation::default()
        });
        let (_, left) = against_f64(&scene, &block)?;
        case.outcome(precision.name(), 100.0 * (1.0 - left), Some(0.0));
    }
    Ok(case)
}

/// The grey of a value is the value: codes are read off the picture.
fn grey(blend: Blend, precision: PrecisionName, planes: u32) -> Scene {
    let mut scene = scene(&[(0.0, 1.0)]);
    let point = |value, grey| slicecast_scene::Point {
        value,
        colour: [grey; 3],
        opacity: 1.0,
    };
    scene.transfer.points = vec![point(0.0, 0.0), point(4095.0, 1.0)];
    scene.blend = blend;
    scene.precision = precision;
    scene.sampling = Sampling {
        planes_per_voxel: planes,
        rays_per_voxel: 1,
    };
    scene
}

/// Sums of the longest rays.
fn sums(size: Size) -> Result<Vec<Case>, RenderError> {
    let depth = match size {
        Size::Full => 2048,
        Size::Reduced => 256,
    };
    let mut deep = Case::new(
        "sums",
        format!(
            "average of {depth} slices at 16 planes a voxel, all of them 4095 and all of them alternating 0 and 4095"
        ),
        "largest error, steps of 1/255",
        0.0,
        "the mean is 4095, or half of it",
    );
    for (name, halved) in [("full", false), ("alternating", true)] {
        let code = |y: usize| if halved && y.is_multiple_of(2) { 0.0 } else { 4095.0 };
        let rows = volume([3, depth, 3], [1.0; 3], |[_, y, _]| code(y));
        for precision in [PrecisionName::Compact, PrecisionName::Wide] {
            let (most, _) = against_f64(&grey(Blend::Average, precision, 16), &rows)?;
            deep.outcome(format!("{}, {name}", precision.name()), most, Some(0.02));
        }
    }
    deep.note =
        Some("limit: a colour of 8 bits in the table, and the rounding of the mean to a code's fraction".into());
    let mut one = Case::new(
        "sums",
        "average and sum of one voxel of 4095 in a line of 256",
        "largest error, steps of 1/255",
        0.0,
        "in f64",
    );
    let single = volume([3, 256, 3], [1.0; 3], |[x, y, z]| {
        if [x, y, z] == [1, 100, 1] { 4095.0 } else { 0.0 }
    });
    for (name, blend) in [("average", Blend::Average), ("additive", Blend::Additive)] {
        for precision in [PrecisionName::Compact, PrecisionName::Wide] {
            let (most, _) = against_f64(&grey(blend, precision, 1), &single)?;
            one.outcome(format!("{}, {name}", precision.name()), most, Some(0.02));
        }
    }
    Ok(vec![deep, one])
}

/// A sphere under light from the viewer, by maps.
fn maps(size: Size) -> Result<Vec<Case>, RenderError> {
    let (side, sizes): (usize, &[u32]) = match size {
        Size::Full => (192, &[8, 16, 32, 64, 128]),
        Size::Reduced => (64, &[8, 32]),
    };
    let (middle, radius) = ((side as f64 - 1.0) / 2.0, 0.42 * side as f64);
    let ball = volume([side, side / 2, 6], [1.0; 3], |[x, y, z]| {
        let z = z as f64 - 2.5;
        let distance = ((x as f64 - middle).powi(2) + (y as f64 - middle).powi(2) + z * z).sqrt();
        2048.0 + (radius - distance) * 200.0
    });
    let mut cases = Vec::new();
    for (name, specular, limited) in [("diffuse light", 0.0, true), ("highlight of exponent 16", 0.9, false)] {
        let mut case = Case::new(
            "reflectance map",
            format!("{side}³ sphere, {name}, by nodes along an edge"),
            "largest error, steps of 1/255",
            0.0,
            "the same surface in f64, lit by Phong",
        );
        for nodes in sizes {
            for (filter, of) in [("nearest", Filter::Nearest), ("bilinear", Filter::Bilinear)] {
                let mut scene = scene(&[(2047.0, 0.0), (2049.0, 1.0)]);
                scene.lighting = lit(specular, 4);
                scene.reflectance = Some(Reflectance {
                    side: *nodes,
                    filter: of,
                });
                let (most, _) = against_f64(&scene, &ball)?;
                // Diffuse light changes by no more than the direction: half a node's distance on both axes, or between two nodes a
                // clamp at its middle, a quarter of their distance; and that of the pipeline without a map.
                let distance = 2.0 / f64::from(nodes - 1);
                let share = match of {
                    Filter::Nearest => std::f64::consts::FRAC_1_SQRT_2 * distance,
                    Filter::Bilinear => 0.25 * distance,
                };
                let allowed = limited.then_some(0.9 * 255.0 * share + 0.25);
                case.outcome(format!("compact, {nodes}, {filter}"), most, allowed);
            }
        }
        cases.push(case);
    }
    Ok(cases)
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    let mut cases = vec![ramps()?, flat()?];
    cases.extend(sums(size)?);
    cases.extend(maps(size)?);
    Ok(cases)
}
