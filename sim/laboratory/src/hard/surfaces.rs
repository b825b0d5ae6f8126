//! Isosurfaces, alone and in a volume, and pieces of segments.

use super::scenes::{lit, scene, volume};
use super::segments::{OBLIQUE, arithmetic, away, sphere};
use super::{Case, Size};
use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_scene::{Classification, Face, Point, PrecisionName, Sampling, Scene, Surface};
use slicecast_volume::Volume;

/// Surfaces of some values and one opacity, coloured by turns, red within.
fn surfaces(values: impl Iterator<Item = f64>, opacity: f64) -> Vec<Surface> {
    let colours = [[1.0, 0.9, 0.8], [0.3, 0.8, 0.4], [0.2, 0.4, 1.0]];
    let surface = |(n, value): (usize, f64)| Surface {
        value,
        front: Face {
            colour: colours[n % 3],
            opacity,
        },
        back: Face {
            colour: [0.8, 0.1, 0.1],
            opacity,
        },
    };
    values.enumerate().map(surface).collect()
}

/// Surfaces alone.
fn alone(values: impl Iterator<Item = f64>, opacity: f64) -> Scene {
    Scene {
        classification: Classification::None,
        surfaces: surfaces(values, opacity),
        ..scene(&[(0.0, 0.0)])
    }
}

/// Every ray through a ramp crosses every surface once, several in a segment, some of them at samples: what is left of the light
/// is the product.
fn counted(count: u32) -> Result<Case, RenderError> {
    let ramp = volume([8, 60, 8], [1.0; 3], |[_, y, _]| 64.0 * y as f64);
    let first = alone((0..count).map(|n| 32.0 + 16.0 * f64::from(n)), 0.02);
    let left = 0.98f64.powi(count as i32);
    let mut case = Case::new(
        "surfaces",
        format!("{count} surfaces of opacity 0.02, crossed once each"),
        "transparency left, farthest of all rays",
        left,
        "0.98 to their number",
    );
    for (precision, allowed) in PrecisionName::STAGED.into_iter().zip([None, Some(2e-4), Some(1e-6)]) {
        let scene = Scene {
            precision,
            ..first.clone()
        };
        let base = Prepared::new(&scene, &ramp)?.render(Layer::Tiles(32), &|_, _| ())?.base;
        let values = base.planes[3].iter().map(|t| f64::from(*t) / f64::from(base.one));
        let farthest = values.fold(
            left,
            |far, t| if (t - left).abs() > (far - left).abs() { t } else { far },
        );
        case.outcome(precision.name(), farthest, allowed);
    }
    Ok(case)
}

/// An opaque lit surface of a ball, by few planes, against where the trilinear field has it.
fn converged(ball: &Volume, value: f64) -> Result<Case, RenderError> {
    let mut scene = Scene {
        view: OBLIQUE,
        lighting: lit(0.2, 4),
        precision: PrecisionName::Wide,
        ..alone([value].into_iter(), 1.0)
    };
    let exact = {
        let prepared = Prepared::new(&scene, ball)?;
        model(&prepared, ModelPositions::Exact).render_integral()
    };
    let mut case = Case::new(
        "surfaces",
        "a lit surface of a ball",
        "mean error, steps of 1/255",
        0.0,
        "the trilinear field's crossings and gradients in f64",
    );
    let mut bar = None;
    for planes in [1, 2, 4] {
        scene.sampling = Sampling {
            planes_per_voxel: planes,
            ..scene.sampling
        };
        let name = format!("{planes} {}", if planes == 1 { "plane" } else { "planes" });
        let mean = away(&scene, ball, &exact)?;
        case.outcome(name, mean, bar);
        bar = Some(mean);
    }
    case.note = Some("limit of 2 and of 4 planes: the error of half as many".into());
    Ok(case)
}

/// Strong colours within a segment, in 1, 2 and 4 pieces.
fn pieces(ball: &Volume) -> Result<Case, RenderError> {
    let mut scene = scene(&[(0.0, 0.0)]);
    let wheel = [[1.0, 0.1, 0.1], [0.1, 1.0, 0.1], [0.1, 0.1, 1.0]];
    // Well inside: rays that enter by a side lose a part of a segment there.
    let outermost = 3800.0 - 60.0 * 0.4 * ball.dims[0] as f64;
    let count = ((3700.0 - outermost) / 30.0) as usize;
    scene.transfer.points = (0..count)
        .map(|n| Point {
            value: outermost + 30.0 * n as f64,
            colour: wheel[n % 3],
            opacity: if n == 0 { 0.0 } else { 0.8 },
        })
        .collect();
    scene.view = OBLIQUE;
    scene.precision = PrecisionName::Wide;
    scene.classification = Classification::Integral;
    let exact = {
        let prepared = Prepared::new(&scene, ball)?;
        model(&prepared, ModelPositions::Exact).render_integral()
    };
    let mut case = Case::new(
        "surfaces",
        "colours that change every 30 codes, in pieces",
        "mean error, steps of 1/255",
        0.0,
        "the converged integral in f64",
    );
    let mut bar = None;
    for count in [1, 2, 4] {
        scene.pieces = count;
        let mean = away(&scene, ball, &exact)?;
        case.outcome(format!("pieces: {count}"), mean, bar);
        bar = Some(mean);
    }
    case.note = Some("limit of 2 and of 4 pieces: the error of half as many".into());
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
    let ball = sphere(side);
    let jumps = volume(
        [side / 2; 3],
        [1.0; 3],
        |[x, y, z]| if (x + y + z) % 2 == 0 { 0.0 } else { 4095.0 },
    );
    let in_volume = |surfaces, lighting| Scene {
        classification: Classification::Integral,
        view: OBLIQUE,
        lighting,
        surfaces,
        ..scene(&[(2500.0, 0.0), (3300.0, 0.2), (3800.0, 0.1)])
    };
    let three = || surfaces([3100.0, 3333.3, 3500.0].into_iter(), 0.3);
    let many = || surfaces((0..200).map(|n| 20.0 * f64::from(n)), 0.05);
    let ends = || surfaces([0.0, 1.0, 4094.0, 4095.0].into_iter(), 0.5);
    Ok(vec![
        counted(200)?,
        converged(&ball, 3300.0)?,
        arithmetic(
            "surfaces",
            "three lit surfaces of a ball",
            &Scene {
                classification: Classification::None,
                ..in_volume(three(), lit(0.2, 4))
            },
            &ball,
        )?,
        arithmetic(
            "surfaces",
            "the same in fog, lit",
            &in_volume(three(), lit(0.2, 4)),
            &ball,
        )?,
        arithmetic("surfaces", "the same in fog, unlit", &in_volume(three(), None), &ball)?,
        arithmetic(
            "surfaces",
            "200 surfaces over jumps of 4095",
            &in_volume(many(), None),
            &jumps,
        )?,
        arithmetic(
            "surfaces",
            "values 0, 1, 4094, 4095 over jumps of 4095",
            &in_volume(ends(), None),
            &jumps,
        )?,
        pieces(&ball)?,
    ])
}
