//! Configurations on one scene: errors once, speeds in turns.
//!
//! Configurations are taken in batches. The errors of a batch are gathered first, view by view; then its frames are
//! rendered in turns, round after round, each after a frame of the base configuration. A speed is that of the fastest; it
//! is also related to the base's, in the median of the rounds' ratios, so that rows of several runs and machines can stand
//! in one table, and how far that ratio scatters from round to round stands beside it.

use super::catalogue::Configuration;
use super::measure::{Bench, Measured, samples};
use super::rows::{Row, StageRow};
use slicecast_bench::spread::{median, spread};
use slicecast_compare::image::ImageFigures;
use slicecast_compare::stages::StageErrors;
use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::key::key;
use slicecast_engine::oriented::Turned;
use slicecast_engine::threads::on_threads;
use slicecast_model::Model;
use slicecast_scene::{Blend, Scene};

/// Configurations whose frames take turns.
pub const BATCH: usize = 8;

/// Why a sweep cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A parameter that does not exist, or a value that no configuration has.
    #[error("{0}")]
    Vary(String),
    /// The scene cannot be rendered.
    #[error("{0}")]
    Render(#[from] RenderError),
    /// A blend that configurations do not have.
    #[error("a sweep composites front to back; the scene's blend is another one")]
    Blend,
    /// Shards that do not belong together.
    #[error("{0}")]
    Merge(String),
    /// The vectors do not compute what the scalar definitions do.
    #[error("`{name}`: the frame that was timed has other bits than the one that was compared with the model")]
    Bits {
        /// The configuration.
        name: String,
    },
}

/// A scene seen from all sides: from its own, then in equal steps of a whole turn about the vertical axis.
pub fn views(scene: &Scene, count: u32) -> Vec<Scene> {
    let turned = |step| {
        let mut scene = scene.clone();
        scene.view = scene.view.turned(360.0 * f64::from(step) / f64::from(count));
        scene
    };
    (0..count).map(turned).collect()
}

/// How a sweep is measured.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Frames of each configuration; the fastest counts.
    pub rounds: u32,
    /// Threads that render the frames that are timed.
    pub timing_threads: usize,
}

/// What the comparisons of a configuration found, view by view.
#[derive(Default)]
struct Found {
    images: Vec<ImageFigures>,
    errors: StageErrors,
    /// Checksum of the first view's frame.
    bits: Option<u64>,
}

impl Found {
    fn add(&mut self, measured: Measured) {
        self.images.push(measured.image);
        self.errors.merge(&measured.errors);
        self.bits.get_or_insert(measured.bits);
    }
}

/// Runs configurations on views of a scene and hands over the rows of each finished batch. Frames are timed in the
/// first view, with its vectors. `progress` is told how many steps of how many are done.
///
/// # Errors
/// [`SweepError`], or what `finished` returns.
pub fn run<E: From<SweepError>>(
    views: &[Prepared<'_>],
    all: &[Configuration],
    chosen: &[usize],
    options: Options,
    progress: &(dyn Fn(usize, usize) + Sync),
    mut finished: impl FnMut(&[Row]) -> Result<(), E>,
) -> Result<(), E> {
    let Some(first) = views.first() else {
        return Ok(());
    };
    if first.scene.blend != Blend::FrontToBack {
        return Err(SweepError::Blend.into());
    }
    let models: Vec<_> = views.iter().map(|view| model(view, ModelPositions::Pipeline)).collect();
    // A comparison takes about as long as all rounds of a configuration, which is as good as an estimate needs.
    let total = (views.len() + 1) * chosen.len();
    let mut done = 0;
    for batch in chosen.chunks(BATCH) {
        let batch: Vec<_> = batch.iter().map(|index| (*index, &all[*index])).collect();
        let mut found: Vec<Found> = batch.iter().map(|_| Found::default()).collect();
        for (view, model) in views.iter().zip(&models) {
            let mut step = || {
                done += 1;
                progress(done, total);
            };
            gather((view, model), &batch, &mut found, &mut step)?;
        }
        let mut steps = |round: usize| progress(done + round * batch.len() / options.rounds.max(1) as usize, total);
        let times = timed((first, &models[0]), &batch, options, &mut steps)?;
        done += batch.len();
        let mut rows = Vec::new();
        for (((index, configuration), found), times) in batch.iter().zip(found).zip(times) {
            if found.bits != Some(times.bits) {
                let name = configuration.name.clone();
                return Err(SweepError::Bits { name }.into());
            }
            rows.push(row((*index, configuration), first, found, &times, options));
        }
        finished(&rows)?;
    }
    Ok(())
}

/// Compares a batch with the model in one view.
fn gather(
    (view, model): (&Prepared<'_>, &Model<'_>),
    batch: &[(usize, &Configuration)],
    found: &mut [Found],
    step: &mut dyn FnMut(),
) -> Result<(), SweepError> {
    let mut turned = Turned::new(view.volume, &view.setup.plan);
    let slices = &turned.slices().map_err(RenderError::from)?;
    for ((_, configuration), found) in batch.iter().zip(found) {
        let bench = Bench {
            prepared: &stepped(view, configuration),
            model,
            slices,
        };
        found.add(configuration.runner.compare(bench)?);
        step();
    }
    Ok(())
}

/// The scene with a configuration's step.
fn stepped<'a>(prepared: &Prepared<'a>, configuration: &Configuration) -> Prepared<'a> {
    let mut stepped = prepared.clone();
    stepped.setup.plan = stepped.setup.plan.with_step_bits(configuration.step_bits);
    stepped
}

/// Seconds that the frames of a configuration, and those of the base beside them, took: one of each a round.
#[derive(Clone, Default)]
struct Times {
    own: Vec<f64>,
    base: Vec<f64>,
    /// Checksum of the configuration's frame.
    bits: u64,
}

impl Times {
    /// The fastest frame.
    fn fastest(times: &[f64]) -> f64 {
        times.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Speed over that of the base, round by round. What disturbs both frames of a round alike is not in it.
    fn ratios(&self) -> Vec<f64> {
        let rounds = self.base.iter().zip(&self.own);
        rounds.map(|(base, own)| base / own).collect()
    }
}

/// The frames of each configuration and of the base, in turns: each frame of a configuration follows one of the base.
fn timed(
    (view, model): (&Prepared<'_>, &Model<'_>),
    batch: &[(usize, &Configuration)],
    options: Options,
    steps: &mut (dyn FnMut(usize) + Send),
) -> Result<Vec<Times>, SweepError> {
    let stepped: Vec<_> = batch.iter().map(|(_, c)| (*c, stepped(view, c))).collect();
    let timed = on_threads(Some(options.timing_threads), || {
        let mut turned = Turned::new(view.volume, &view.setup.plan);
        let slices = &turned.slices()?;
        let mut all_times = vec![Times::default(); batch.len()];
        let frame = |configuration: &Configuration, prepared: &Prepared<'_>| {
            configuration.runner.time(Bench {
                prepared,
                model,
                slices,
            })
        };
        for round in 0..options.rounds {
            for (times, (configuration, prepared)) in all_times.iter_mut().zip(&stepped) {
                let before = frame(&configuration.base(), view)?;
                let own = frame(configuration, prepared)?;
                times.own.push(own.time.as_secs_f64());
                times.base.push(before.time.as_secs_f64());
                times.bits = own.bits;
            }
            steps(round as usize + 1);
        }
        Ok::<_, RenderError>(all_times)
    })??;
    Ok(timed)
}

/// The row of a configuration.
fn row(
    (index, configuration): (usize, &Configuration),
    first: &Prepared<'_>,
    found: Found,
    times: &Times,
    options: Options,
) -> Row {
    let stages = configuration.runner.report(&found.errors);
    let stages = stages.into_iter().map(|stage| StageRow {
        name: stage.name.to_owned(),
        format: stage.format,
        local_max_ulp: stage.local.max_ulp,
        local_mean_ulp: stage.local.mean_ulp,
        local_bits: stage.local.bits,
        carried_max_ulp: stage.carried.max_ulp,
        carried_mean_ulp: stage.carried.mean_ulp,
    });
    Row {
        key: key(first),
        index,
        name: configuration.name.clone(),
        parameters: configuration.parameters.clone(),
        pixel_bytes: configuration.pixel_bytes,
        table_bytes: configuration.table_bytes,
        image: ImageFigures::together(&found.images),
        views: found.images,
        stages: stages.collect(),
        samples_per_second: samples(&first.setup.plan) as f64 / Times::fastest(&times.own),
        relative_speed: median(&times.ratios()).unwrap_or(0.0),
        speed_spread: spread(&times.ratios()),
        rounds: options.rounds,
        threads: options.timing_threads,
        lanes: first.simd.name().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::catalogue;
    use super::super::shards::{merge, shard};
    use super::*;
    use slicecast_volume::mapping::Window;
    use slicecast_volume::open::load;

    /// A machine that becomes slower disturbs both frames of a round, and their ratio not at all; a frame of the base that
    /// was never undisturbed does not make the configuration faster than it is.
    #[test]
    fn speeds_are_compared_round_by_round() {
        let times = |base: [f64; 4]| Times {
            own: vec![1.0, 1.5, 2.0, 4.0],
            base: base.into(),
            bits: 0,
        };
        let told = |times: &Times| (median(&times.ratios()), spread(&times.ratios()));
        assert_eq!(told(&times([2.0, 3.0, 4.0, 8.0])), (Some(2.0), Some(0.0)));
        // Ratios of 2, 1.5, 2, 2.5: quartiles 1.875 and 2.125.
        assert_eq!(told(&times([2.0, 2.25, 4.0, 10.0])), (Some(2.0), Some(0.0625)));
        // Of the fastest frames it would be 3.
        let disturbed = times([8.0, 3.0, 4.0, 8.0]);
        assert_eq!(Times::fastest(&disturbed.base) / Times::fastest(&disturbed.own), 3.0);
        assert_eq!(median(&disturbed.ratios()), Some(2.0));
    }

    /// Two shards give the errors of the whole, and the named precisions are those of `compare`.
    #[test]
    fn errors_do_not_depend_on_the_shard() {
        let volume = load(None, Window::Auto).unwrap().volume;
        let mut scene = slicecast_scene::file::built_in(slicecast_scene::file::DEFAULT).unwrap();
        scene.sampling.planes_per_voxel = 1;
        scene.sampling.rays_per_voxel = 1;
        let scenes = views(&scene, 2);
        let views = scenes.iter().map(|scene| Prepared::new(scene, &volume).unwrap());
        let views: Vec<_> = views.collect();
        let all = catalogue::all();
        let named = |name: &str| all.iter().position(|c| c.name == name).unwrap();
        let chosen = [named("compact"), named("position-8"), named("pixel-8-truncated")];
        let options = Options {
            rounds: 1,
            timing_threads: 1,
        };
        let swept = |chosen: &[usize]| {
            let mut rows = Vec::new();
            run::<SweepError>(&views, &all, chosen, options, &|_, _| (), |batch| {
                rows.extend_from_slice(batch);
                Ok(())
            })
            .unwrap();
            rows
        };
        let whole = merge(swept(&chosen)).unwrap();
        let parts: Vec<Row> = (1..=2).flat_map(|number| swept(&shard(&chosen, number, 2))).collect();
        let errors = |rows: &[Row]| -> Vec<_> {
            rows.iter()
                .map(|r| (r.name.clone(), r.image, r.stages.clone()))
                .collect()
        };
        assert_eq!(errors(&merge(parts).unwrap()), errors(&whole));
        for (view, figures) in views.iter().zip(&whole[0].views) {
            let compared = slicecast_compare::compare(view, ModelPositions::Pipeline, &|_, _| ()).unwrap();
            assert_eq!(*figures, compared.image);
        }
        // Short steps and eight bits of pixel are far worse.
        assert!(whole[1].image.mean_lsb8 > 10.0 * whole[0].image.mean_lsb8);
        assert!(whole[2].image.mean_lsb8 > 10.0 * whole[0].image.mean_lsb8);
        assert!(
            whole
                .iter()
                .all(|row| row.samples_per_second > 0.0 && row.relative_speed > 0.0)
        );
    }
}
