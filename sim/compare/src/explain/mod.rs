//! One ray, every sample, every stage: what the pipeline had, what the model has, and where the final error came from.

mod chain;
mod record;

use serde::Serialize;

use crate::lockstep::Scales;
use crate::stages::Stage;
use crate::{ModelPositions, model};
use record::{Recorded, Step, record};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::oriented::Turned;
use slicecast_model::{Model, ModelSample, Pixel};
use slicecast_scene::Blend;

/// What a stage had for one sample: the pipeline's value and the model's, component by component.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Values {
    /// The stage.
    pub stage: &'static str,
    /// The pipeline's.
    pub fixed: Vec<f64>,
    /// The model's, from exact positions on.
    pub exact: Vec<f64>,
    /// The largest difference, ulp of the stage's format.
    pub error_ulp: f64,
}

/// One sample of the ray.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sample {
    /// Number of the plane.
    pub plane: usize,
    /// Whether the pipeline folded it into the pixel.
    pub folded: bool,
    /// What every stage had, as far as both sides have it.
    pub stages: Vec<Values>,
}

/// What a stage added to the final error: the change of the pixel when its results, too, are the pipeline's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Share {
    /// The stage.
    pub stage: &'static str,
    /// Red, green, blue, steps of 1/255.
    pub lsb8: [f64; 3],
}

/// A ray explained.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// The ray: full-resolution pixel of the base plane.
    pub ray: [usize; 2],
    /// All samples inside the volume.
    pub samples: Vec<Sample>,
    /// The pipeline's pixel, 0 to 1: red, green, blue, transparency.
    pub fixed: [f64; 4],
    /// The model's.
    pub exact: [f64; 4],
    /// Where the difference came from; the shares add up to it.
    pub shares: Vec<Share>,
}

/// Why a ray cannot be explained.
#[derive(Debug, thiserror::Error)]
pub enum ExplainError {
    /// It is not there.
    #[error("the base plane has {width} x {height} rays; there is none at {u},{v}")]
    Ray {
        /// The ray asked for.
        u: usize,
        /// See `u`.
        v: usize,
        /// Rays across.
        width: usize,
        /// Rays down.
        height: usize,
    },
    /// A picture pixel outside the picture.
    #[error("the picture has {width} x {height} pixels; there is none at {x},{y}")]
    Pixel {
        /// The pixel asked for.
        x: u32,
        /// See `x`.
        y: u32,
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// A picture pixel that no ray passes.
    #[error("no ray passes pixel {x},{y}: it shows the background")]
    Background {
        /// The pixel asked for.
        x: u32,
        /// See `x`.
        y: u32,
    },
    /// A blend whose samples are not folded one after the other from the front.
    #[error("rays are explained front to back; the scene's blend is another one")]
    Blend,
    /// The scene cannot be rendered.
    #[error("{0}")]
    Render(#[from] RenderError),
}

/// The ray nearest to a picture pixel.
///
/// # Errors
/// [`ExplainError`] if there is none.
pub fn ray_of(prepared: &Prepared<'_>, [x, y]: [u32; 2]) -> Result<[usize; 2], ExplainError> {
    let picture = &prepared.setup.picture;
    let [width, height] = picture.size;
    if x >= width || y >= height {
        return Err(ExplainError::Pixel { x, y, width, height });
    }
    let [origin, right, down] = picture.affine;
    let at = [0, 1].map(|a| (origin[a] + f64::from(x) * right[a] + f64::from(y) * down[a]).round());
    let rays = prepared.setup.plan.sampling().rays_per_voxel;
    let size = prepared.setup.plan.base().map(|side| f64::from(side * rays));
    if (0..2).all(|a| (0.0..size[a]).contains(&at[a])) {
        Ok(at.map(|c| c as usize))
    } else {
        Err(ExplainError::Background { x, y })
    }
}

/// Explains a ray.
///
/// # Errors
/// [`ExplainError`].
pub fn explain(prepared: &Prepared<'_>, ray: [usize; 2]) -> Result<Explanation, ExplainError> {
    if prepared.scene.blend != Blend::FrontToBack {
        return Err(ExplainError::Blend);
    }
    let plan = &prepared.setup.plan;
    let rays = plan.sampling().rays_per_voxel;
    let [width, height] = plan.base().map(|side| (side * rays) as usize);
    let [u, v] = ray;
    if u >= width || v >= height {
        return Err(ExplainError::Ray { u, v, width, height });
    }
    let mut turned = Turned::new(prepared.volume, plan);
    let slices = turned.slices().map_err(RenderError::from)?;
    let record = record(prepared, &slices, ray)?;
    let exact = model(prepared, ModelPositions::Exact);
    let rounded = model(prepared, ModelPositions::Pipeline);
    Ok(assemble(ray, record, &exact, &rounded))
}

/// Puts a ray and its models together.
fn assemble(ray: [usize; 2], record: Recorded, exact: &Model<'_>, rounded: &Model<'_>) -> Explanation {
    let [u, v] = ray;
    let mut samples = Vec::new();
    let mut so_far = Pixel::TRANSPARENT;
    for (index, step) in record.steps.iter().enumerate() {
        let Some(sample) = exact.sample(index, u, v) else {
            continue;
        };
        if sample.opacity > 0.0 {
            so_far = so_far.front_to_back(sample.shaded, sample.opacity);
        }
        samples.push(Sample {
            plane: index,
            folded: step.after.is_some() && step.opacity.is_some_and(|a| a > 0.0),
            stages: stages(step, &sample, so_far, &record.scales, exact.lights().is_some()),
        });
    }
    let (exact_pixel, shares) = chain::shares(&record, exact, rounded, ray);
    let whole = |pixel: Pixel| {
        let [r, g, b] = pixel.colour;
        [r, g, b, pixel.transparency]
    };
    Explanation {
        ray,
        samples,
        fixed: whole(record.pixel),
        exact: whole(exact_pixel),
        shares,
    }
}

/// The values of a sample's stages, as far as both sides have them.
fn stages(step: &Step, sample: &ModelSample, so_far: Pixel, scales: &Scales, lit: bool) -> Vec<Values> {
    let mut all = Vec::new();
    let mut add = |stage: Stage, fixed: &[f64], exact: &[f64]| {
        let away = fixed.iter().zip(exact).map(|(f, e)| (f - e).abs()).fold(0.0, f64::max);
        all.push(Values {
            stage: stage.name(),
            fixed: fixed.to_vec(),
            exact: exact.to_vec(),
            error_ulp: away * scales.per_unit[stage as usize],
        });
    };
    add(Stage::Location, &step.position, &sample.position);
    if let Some(value) = step.value {
        add(Stage::Interpolation, &[value], &[sample.value]);
    }
    if let Some(opacity) = step.opacity {
        add(Stage::Opacity, &[opacity], &[sample.opacity]);
    }
    if let Some(colour) = step.colour {
        add(Stage::Colour, &colour, &sample.colour);
    }
    if lit {
        if let Some(gradient) = step.gradient {
            add(Stage::Gradient, &gradient, &sample.gradient);
        }
        if let Some(normal) = step.normal {
            add(Stage::Normal, &normal, &sample.normal);
        }
        if let Some(shaded) = step.shaded {
            add(Stage::Shading, &shaded, &sample.shaded);
        }
    }
    if let Some(after) = step.after {
        add(Stage::Transparency, &[after.transparency], &[so_far.transparency]);
        add(Stage::Compositing, &after.colour, &so_far.colour);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare;
    use slicecast_scene::crop::Crop;
    use slicecast_scene::{Borders, PrecisionName};
    use slicecast_volume::mapping::Window;
    use slicecast_volume::open::load;

    #[test]
    fn shares_add_up_and_the_ray_is_the_frames_own() {
        let volume = load(None, Window::Auto).unwrap().volume;
        let mut scene = slicecast_scene::file::built_in(slicecast_scene::file::DEFAULT).unwrap();
        let crop = Crop::parse("10:50.3,4.5:,20.25:60").unwrap();
        let all = [
            (Borders::Whole, None),
            (Borders::Cells, Some(crop)),
            (Borders::Nodes, None),
        ];
        for (precision, (borders, crop)) in PrecisionName::STAGED.into_iter().zip(all) {
            (scene.precision, scene.borders, scene.crop) = (precision, borders, crop);
            let prepared = Prepared::new(&scene, &volume).unwrap();
            let comparison = compare(&prepared, ModelPositions::Exact, &|_, _| ()).unwrap();
            let base = &comparison.frame.base;
            let [width, height] = base.size;
            let mut seen = 0;
            for ray in [[width / 2, height / 2], [width / 3 + 1, height / 2 + 3], [0, 0]] {
                let explained = explain(&prepared, ray).unwrap();
                let index = ray[1] * width + ray[0];
                for c in 0..4 {
                    assert_eq!(
                        explained.fixed[c],
                        f64::from(base.planes[c][index]) / f64::from(base.one)
                    );
                }
                for c in 0..3 {
                    assert!((explained.exact[c] - comparison.model.rgb[c][index]).abs() < 1e-12);
                    let sum: f64 = explained.shares.iter().map(|share| share.lsb8[c]).sum();
                    let error = 255.0 * (explained.fixed[c] - explained.exact[c]);
                    assert!((sum - error).abs() < 1e-9, "{sum} {error}");
                }
                seen += explained.samples.iter().filter(|sample| sample.folded).count();
            }
            assert!(seen > 3, "{seen}");
        }
    }

    #[test]
    fn rays_that_are_not_there_are_refused() {
        let volume = load(None, Window::Auto).unwrap().volume;
        let mut scene = slicecast_scene::file::built_in(slicecast_scene::file::DEFAULT).unwrap();
        let prepared = Prepared::new(&scene, &volume).unwrap();
        assert!(matches!(
            explain(&prepared, [100_000, 0]),
            Err(ExplainError::Ray { .. })
        ));
        assert!(matches!(
            ray_of(&prepared, [100_000, 0]),
            Err(ExplainError::Pixel { .. })
        ));
        scene.image.zoom = 0.1;
        let small = Prepared::new(&scene, &volume).unwrap();
        assert!(matches!(ray_of(&small, [0, 0]), Err(ExplainError::Background { .. })));
        scene.blend = Blend::Maximum;
        let prepared = Prepared::new(&scene, &volume).unwrap();
        assert!(matches!(explain(&prepared, [0, 0]), Err(ExplainError::Blend)));
    }
}
