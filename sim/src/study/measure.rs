//! Errors and speed of one configuration, by the pipeline itself.

use std::time::{Duration, Instant};

use slicecast::classify::Lookup;
use slicecast::composite::FrontToBack;
use slicecast::locate::plane;
use slicecast::plan::Plan;
use slicecast::plane::{Composite, Pipeline};
use slicecast::precision::Precision;
use slicecast::shade::{Shader, Unlit};
use slicecast::slice::Slice;
use slicecast::tap::NoTap;

use super::codes::Coded;
use crate::camera::CameraError;
use crate::compare::{Compare, Comparison};
use crate::engine::{Prepared, RenderError, TILE_ROWS, fold_tiles, new_image};
use crate::model::Model;
use crate::pipelines::Job;
use crate::table::{Correction, fill};

/// A scene that configurations are run on.
#[derive(Clone, Copy)]
pub struct Bench<'a> {
    /// The scene, its plan as the configuration has it.
    pub prepared: &'a Prepared<'a>,
    /// The f64 model, at the positions of the full step.
    pub model: &'a Model<'a>,
    /// The slices in the view's order.
    pub slices: &'a [Slice<'a>],
}

/// The functions of a configuration: one instantiation each.
#[derive(Clone, Copy, Debug)]
pub struct Runner {
    compare: fn(Bench<'_>) -> Result<Comparison, RenderError>,
    time: fn(Bench<'_>) -> Result<Duration, RenderError>,
}

impl Runner {
    /// Those of a pipeline type.
    pub fn of<P: Precision, A: Coded, L: Lookup>() -> Self {
        Self {
            compare: |bench| with_pipeline::<P, A, L, _>(bench.prepared, bench.comparison())?,
            time: |bench| with_pipeline::<P, A, L, _>(bench.prepared, Timing(bench))?,
        }
    }

    /// Every error, against the model.
    ///
    /// # Errors
    /// [`RenderError`] if the scene does not fit the pipeline.
    pub fn compare(&self, bench: Bench<'_>) -> Result<Comparison, RenderError> {
        (self.compare)(bench)
    }

    /// How long one frame takes on rayon's current threads, from the first plane to the last: without filling the
    /// table, without the warp.
    ///
    /// # Errors
    /// As [`Runner::compare`].
    pub fn time(&self, bench: Bench<'_>) -> Result<Duration, RenderError> {
        (self.time)(bench)
    }
}

impl<'a> Bench<'a> {
    fn comparison(self) -> Compare<'a> {
        Compare {
            prepared: self.prepared,
            model: self.model,
            slices: self.slices,
            progress: &|_, _| (),
        }
    }
}

/// Does a job with a configuration's pipeline.
fn with_pipeline<P: Precision, A: Coded, L: Lookup, J: Job>(
    prepared: &Prepared<'_>,
    job: J,
) -> Result<J::Output, RenderError> {
    let (scene, setup) = (prepared.scene, &prepared.setup);
    let correction = Correction::Step(setup.step_length);
    let mapping = &prepared.volume.mapping;
    let filled = fill(&scene.transfer, mapping, correction, A::encode, A::decode);
    let table = A::classifier::<L>(&filled);
    Ok(match &setup.material {
        Some(material) => {
            let phong = material.phong::<P>().map_err(CameraError::from)?;
            job.run(&early(Composite::<P, _, _, FrontToBack>::new(table, phong), prepared))
        }
        None => job.run(&early(Composite::<P, _, _, FrontToBack>::new(table, Unlit), prepared)),
    })
}

/// Ends rays early if the scene asks for it.
fn early<P: Precision, C: slicecast::classify::Classifier<P>, S: Shader<P>>(
    pipeline: Composite<P, C, S, FrontToBack>,
    prepared: &Prepared<'_>,
) -> Composite<P, C, S, FrontToBack> {
    match prepared.scene.early_termination {
        Some(bits) => pipeline.with_early_termination(bits),
        None => pipeline,
    }
}

struct Timing<'a>(Bench<'a>);

impl Job for Timing<'_> {
    type Output = Result<Duration, RenderError>;

    fn run<L: Pipeline>(self, pipeline: &L) -> Self::Output {
        let plan = &self.0.prepared.setup.plan;
        let mut image = new_image::<L>(plan)?;
        let start = Instant::now();
        fold_tiles(plan, pipeline, self.0.slices, &mut image, TILE_ROWS, &|_, _| (), |_| {
            NoTap
        });
        Ok(start.elapsed())
    }
}

/// The samples of a frame: those inside the volume, whether they are skipped or not.
pub fn samples(plan: &Plan) -> u64 {
    let [width, height, _] = plan.dims();
    let [base_width, base_height] = plan.base();
    // Pixels along one side whose samples lie between the first voxel and the last.
    let along = |start: i32, side: u32, pixels: u32| {
        let inside = |pixel: &u32| {
            let at = i64::from(start) + (i64::from(*pixel) << 16);
            (0..=i64::from(side - 1) << 16).contains(&at)
        };
        (0..pixels).filter(inside).count() as u64
    };
    let mut count = 0;
    for phase in 0..plan.phases() {
        for index in 0..plan.planes() {
            let at = plane(plan, plan.phase(phase), index);
            count += along(at.x.to_bits(), width, base_width) * along(at.y.to_bits(), height, base_height);
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast::format::Direction;
    use slicecast::plan::{Sampling, Spacing};
    use slicecast::view::View;

    #[test]
    fn samples_are_counted_inside_the_volume() {
        let plan = |x: i64, rays_per_voxel| {
            let view = View::new([Direction::from_bits(x), Direction::ZERO, Direction::from_bits(1 << 50)]).unwrap();
            let sampling = Sampling {
                planes_per_voxel: 2,
                rays_per_voxel,
            };
            Plan::new(view, [5, 4, 3], Spacing::CUBIC, sampling).unwrap()
        };
        assert_eq!(samples(&plan(0, 1)), 5 * 4 * 5);
        // A shear of one: the planes at half voxels have one column less.
        assert_eq!(samples(&plan(1 << 50, 1)), 4 * (5 + 4 + 5 + 4 + 5));
        // Two rays a voxel: columns at 0, 0.5 ... 4 are nine, rows seven.
        assert_eq!(samples(&plan(0, 2)), 9 * 7 * 5);
    }
}
