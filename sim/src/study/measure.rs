//! Errors and speed of one configuration, by the pipeline itself.

use std::time::{Duration, Instant};

use rayon::prelude::*;
use slicecast::classify::{Classifier, Lookup};
use slicecast::composite::{Channel, FrontToBack};
use slicecast::locate::plane;
use slicecast::plan::Plan;
use slicecast::plane::{ChannelOf, Composite, Pipeline, clear, scratch_len};
use slicecast::precision::Precision;
use slicecast::shade::{Shader, Unlit};
use slicecast::slice::Slice;
use slicecast::tap::{NoTap, Tap};

use super::codes::Coded;
use super::pixels::Described;
use crate::camera::CameraError;
use crate::compare::Tiles;
use crate::compare::image::{ImageFigures, base_figures};
use crate::compare::lockstep::Lockstep;
use crate::compare::stages::{StageErrors, StageReport};
use crate::engine::{BaseImage, Prepared, RenderError, TILE_ROWS, Tile, fold_tile};
use crate::model::{Model, Pixel};
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

/// What a comparison of a configuration found.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Errors of the base-plane image.
    pub image: ImageFigures,
    /// Errors of every stage.
    pub stages: Vec<StageReport>,
    /// The base-plane image.
    pub base: BaseImage,
}

/// A tile of a configuration's image beside the model's.
struct Compared {
    tile: Tile,
    /// Red, green, blue and transparency, row after row.
    planes: [Vec<u32>; 4],
    errors: StageErrors,
    model: Vec<Pixel>,
}

/// A pipeline whose type is forgotten. What is behind it is compiled once a configuration and lighting: one tile with a
/// tap and one without.
trait Bound: Sync {
    /// Name, 1.0 and shown bits of a channel.
    fn format(&self) -> (&'static str, u32, u32);
    /// Renders a tile and looks at nothing.
    fn render(&self, bench: Bench<'_>, tile: Tile);
    /// Renders a tile beside the model.
    fn compare(&self, bench: Bench<'_>, tile: Tile) -> Compared;
    /// The figures of what was gathered.
    fn report(&self, errors: &StageErrors) -> Vec<StageReport>;
}

impl<L: Pipeline<Element = ChannelOf<<L as Pipeline>::Precision>>> Bound for L
where
    <L::Precision as Precision>::Pixel: Described,
{
    fn format(&self) -> (&'static str, u32, u32) {
        let shown = <<L::Precision as Precision>::Pixel as Described>::SHOWN;
        (L::Element::NAME, L::Element::ONE.bits(), shown)
    }

    fn render(&self, bench: Bench<'_>, tile: Tile) {
        std::hint::black_box(fold(self, bench, tile, &mut NoTap));
    }

    fn compare(&self, bench: Bench<'_>, tile: Tile) -> Compared {
        let blend = bench.prepared.scene.blend;
        let mut lockstep = Lockstep::new::<L::Precision>(bench.model, &bench.prepared.setup, blend, tile);
        let data = fold(self, bench, tile, &mut lockstep);
        let (tile, errors, model) = lockstep.finish();
        let mut planes = [const { Vec::new() }; 4];
        let [width, _] = bench.prepared.setup.plan.base();
        for (run, elements) in data.chunks(width as usize).enumerate() {
            planes[run % 4].extend(elements.iter().map(|element| element.bits()));
        }
        Compared {
            tile,
            planes,
            errors,
            model,
        }
    }

    fn report(&self, errors: &StageErrors) -> Vec<StageReport> {
        errors.report::<L::Precision>()
    }
}

/// All planes of a tile.
fn fold<L: Pipeline, T: Tap>(pipeline: &L, bench: Bench<'_>, tile: Tile, tap: &mut T) -> Vec<L::Element> {
    let plan = &bench.prepared.setup.plan;
    let [width, _] = plan.base();
    let [slice_width, _, _] = plan.dims();
    let mut data = vec![L::empty(0); L::CHANNELS * width as usize * tile.rows as usize];
    clear::<L>(plan, &mut data);
    let mut scratch = vec![0; scratch_len::<L>(slice_width)];
    fold_tile(plan, pipeline, bench.slices, tile, &mut data, &mut scratch, tap);
    data
}

/// The tiles of a frame.
fn tiles(plan: &Plan) -> Vec<Tile> {
    let [_, height] = plan.base();
    let of_phase = |phase| {
        (0..height).step_by(TILE_ROWS).map(move |first| Tile {
            phase,
            first,
            rows: (TILE_ROWS as u32).min(height - first),
        })
    };
    (0..plan.phases()).flat_map(of_phase).collect()
}

/// Lends a configuration's pipeline.
type With = fn(&Prepared<'_>, &mut dyn FnMut(&dyn Bound)) -> Result<(), RenderError>;

/// What runs a configuration.
#[derive(Clone, Copy, Debug)]
pub struct Runner(With);

impl Runner {
    /// That of a pipeline type.
    pub fn of<P: Precision<Pixel: Described>, A: Coded, L: Lookup>() -> Self {
        Self(with_pipeline::<P, A, L>)
    }

    fn with<R>(&self, prepared: &Prepared<'_>, work: impl FnOnce(&dyn Bound) -> R) -> Result<R, RenderError> {
        let (mut work, mut result) = (Some(work), None);
        (self.0)(prepared, &mut |bound| result = work.take().map(|work| work(bound)))?;
        // What lends a pipeline without an error has called the function.
        Ok(result.expect("a pipeline was lent"))
    }

    /// Every error, against the model.
    ///
    /// # Errors
    /// [`RenderError`] if the scene does not fit the pipeline.
    pub fn compare(&self, bench: Bench<'_>) -> Result<Measured, RenderError> {
        let plan = &bench.prepared.setup.plan;
        let ((format, one, shown), stages, compared) = self.with(bench.prepared, |bound| {
            let tiles = tiles(plan);
            let compared: Vec<_> = tiles.into_par_iter().map(|tile| bound.compare(bench, tile)).collect();
            let mut errors = StageErrors::default();
            compared.iter().for_each(|tile| errors.merge(&tile.errors));
            (bound.format(), bound.report(&errors), compared)
        })?;
        let rays = plan.sampling().rays_per_voxel as usize;
        let [width, _] = plan.base();
        let size = bench.model.lattice().size;
        let mut model = Tiles::new(size, width as usize, rays);
        let mut planes = [(); 4].map(|()| vec![0; size[0] * size[1]]);
        for tile in compared {
            model.place(plan, tile.tile, &tile.model);
            let phase = plan.phase(tile.tile.phase);
            for (plane, bits) in planes.iter_mut().zip(&tile.planes) {
                for (index, bits) in bits.iter().enumerate() {
                    let u = index % width as usize * rays + phase.u as usize;
                    let v = (index / width as usize + tile.tile.first as usize) * rays + phase.v as usize;
                    plane[v * size[0] + u] = bits & shown;
                }
            }
        }
        let base = BaseImage {
            size,
            format,
            one,
            planes,
        };
        Ok(Measured {
            image: base_figures(&base, &model.image()),
            stages,
            base,
        })
    }

    /// How long one frame takes on rayon's current threads, from the first plane to the last: without filling the
    /// table, without the warp.
    ///
    /// # Errors
    /// As [`Runner::compare`].
    pub fn time(&self, bench: Bench<'_>) -> Result<Duration, RenderError> {
        let tiles = tiles(&bench.prepared.setup.plan);
        self.with(bench.prepared, |bound| {
            let start = Instant::now();
            tiles.into_par_iter().for_each(|tile| bound.render(bench, tile));
            start.elapsed()
        })
    }
}

/// Lends the pipeline of a type.
fn with_pipeline<P: Precision<Pixel: Described>, A: Coded, L: Lookup>(
    prepared: &Prepared<'_>,
    work: &mut dyn FnMut(&dyn Bound),
) -> Result<(), RenderError> {
    let (scene, setup) = (prepared.scene, &prepared.setup);
    let correction = Correction::Step(setup.step_length);
    let mapping = &prepared.volume.mapping;
    let filled = fill(&scene.transfer, mapping, correction, A::encode, A::decode);
    let table = A::classifier::<L>(&filled);
    match &setup.material {
        Some(material) => {
            let phong = material.phong::<P>().map_err(CameraError::from)?;
            work(&early(Composite::<P, _, _, FrontToBack>::new(table, phong), prepared));
        }
        None => work(&early(Composite::<P, _, _, FrontToBack>::new(table, Unlit), prepared)),
    }
    Ok(())
}

/// Ends rays early if the scene asks for it.
fn early<P: Precision, C: Classifier<P>, S: Shader<P>>(
    pipeline: Composite<P, C, S, FrontToBack>,
    prepared: &Prepared<'_>,
) -> Composite<P, C, S, FrontToBack> {
    match prepared.scene.early_termination {
        Some(bits) => pipeline.with_early_termination(bits),
        None => pipeline,
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
