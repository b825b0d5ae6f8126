//! Frames against each other: the pipeline at every precision and width, the same in floats, and ray by ray.
//!
//! What is timed is the folding of all sample planes into a cleared base-plane image: no reading, no preparation, no
//! table, no final warp (those have figures of their own). All subjects take turns, frame by frame, in one process, and
//! each keeps its shortest time, so that a busy machine disturbs all of them alike; how far the others scatter is told.

pub mod opponent;
pub mod scenes;
pub mod spread;
pub mod ways;

use std::hint::black_box;
use std::time::{Duration, Instant};

use serde::Serialize;
use slicecast::locate::{cell, inside, plane};
use slicecast::plan::Plan;

use crate::opponent::Opponent;
use crate::spread::spread;
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::oriented::{Oriented, Turned};
use slicecast_engine::pipelines::compile;
use slicecast_engine::simd::Simd;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_rays as rays;
use slicecast_scene::{PrecisionName, Scene};
use slicecast_volume::Volume;

/// An engine that renders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// The pipeline.
    Fixed(PrecisionName),
    /// The opponent.
    Float,
    /// The pipeline's definitions, ray by ray.
    Rays(PrecisionName),
}

impl Engine {
    /// The name in reports.
    pub fn name(self) -> String {
        match self {
            Self::Fixed(precision) => precision.name().to_owned(),
            Self::Float => "f32".to_owned(),
            Self::Rays(precision) => format!("{}, ray by ray", precision.name()),
        }
    }
}

/// An engine with its vectors and threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subject {
    /// Who.
    pub engine: Engine,
    /// Vectors.
    pub simd: Simd,
    /// Whether on all threads, or on one.
    pub all_threads: bool,
}

/// A subject's result.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Who rendered.
    pub engine: String,
    /// Name of the vectors.
    pub width: &'static str,
    /// Number of threads.
    pub threads: usize,
    /// The shortest time of a frame.
    pub milliseconds: f64,
    /// Nanoseconds a sample.
    pub nanoseconds: f64,
    /// Samples a second.
    pub samples_per_second: f64,
    /// How far the times of the frames scatter: half the distance between their quartiles, as a share of the median;
    /// `None` of fewer than four frames.
    pub spread: Option<f64>,
    /// How many times as fast as `compact` of the same width and threads; `None` where that was not measured.
    pub against_compact: Option<f64>,
    /// The same against f32.
    pub against_f32: Option<f64>,
}

/// One thread, and all of them.
pub struct Threads {
    one: rayon::ThreadPool,
    all: rayon::ThreadPool,
}

impl Threads {
    /// Starts them; `None` is one a processor.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if they cannot be started.
    pub fn start(all: Option<usize>) -> Result<Self, RenderError> {
        let start = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        Ok(Self {
            one: start(1)?,
            all: start(all.unwrap_or(0))?,
        })
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.all.current_num_threads()
    }

    fn pool(&self, all: bool) -> &rayon::ThreadPool {
        if all { &self.all } else { &self.one }
    }
}

/// In-bounds samples of a frame, whether the scene lets them be skipped or not.
pub fn samples(plan: &Plan) -> u64 {
    let [width, height, _] = plan.dims();
    let [base_width, base_height] = plan.base();
    let planes = (0..plan.phases()).flat_map(|phase| (0..plan.planes()).map(move |index| (phase, index)));
    let of_plane = |(phase, index)| {
        let plane = plane(plan, plan.phase(phase), index);
        let across = inside(cell(plane.x), width, base_width).len() as u64;
        let down = inside(cell(plane.y), height, base_height).len() as u64;
        across * down
    };
    planes.map(of_plane).sum()
}

/// Measures subjects on a scene and a volume: the shortest of `frames` frames each, taking turns. `progress` is told
/// how many rounds of how many are done.
///
/// # Errors
/// [`RenderError`] if the scene does not fit the pipeline.
pub fn measure(
    scene: &Scene,
    volume: &Volume,
    subjects: &[Subject],
    frames: usize,
    threads: &Threads,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<(u64, Vec<Row>), RenderError> {
    // 16-bit lanes do not know every scene, and are not timed at others.
    let scenes: Vec<Scene> = (PrecisionName::STAGED.into_iter().chain([PrecisionName::Fast]))
        .map(|precision| Scene {
            precision,
            ..scene.clone()
        })
        .filter(|scene| scene.precision != PrecisionName::Fast || scene.check().is_ok())
        .collect();
    let prepared: Vec<Prepared<'_>> = (scenes.iter())
        .map(|scene| Prepared::new(scene, volume))
        .collect::<Result<_, _>>()?;
    // The opponent has none.
    prepared[0].check_unclipped()?;
    let place = |precision| scenes.iter().position(|scene| scene.precision == precision);
    let of = |precision| &prepared[place(precision).unwrap_or(0)];
    let known = |subject: &&Subject| match subject.engine {
        Engine::Fixed(precision) | Engine::Rays(precision) => place(precision).is_some(),
        Engine::Float => true,
    };
    let subjects: &Vec<Subject> = &subjects.iter().filter(known).copied().collect();
    let plan = prepared[0].setup.plan;
    // Floats look tables up linearly and need all of an entry's bits: those of Compact.
    let opponent = Opponent::of(of(PrecisionName::Compact));
    let mut floats = Vec::new();
    let mut times = vec![Vec::with_capacity(frames); subjects.len()];
    let mut turned = Turned::new(volume, &plan);
    let slices = &turned.slices()?;
    let oriented = Oriented::of(slices);
    for round in 0..frames {
        for (subject, times) in subjects.iter().zip(&mut times) {
            let frame = || match subject.engine {
                Engine::Fixed(precision) => folded(of(precision), &oriented, subject.simd),
                Engine::Float => {
                    floats.resize(Opponent::image_len(&plan), 0.0);
                    Opponent::clear(&plan, &mut floats);
                    let start = Instant::now();
                    opponent.fold(&plan, &oriented, &mut floats, TILE_ROWS, subject.simd);
                    Ok(start.elapsed())
                }
                Engine::Rays(precision) => {
                    let start = Instant::now();
                    black_box(rays::follow(of(precision))?);
                    Ok(start.elapsed())
                }
            };
            times.push(threads.pool(subject.all_threads).install(frame)?.as_secs_f64());
        }
        progress(round + 1, frames);
    }
    let samples = samples(&plan);
    Ok((samples, rows(subjects, &times, samples, threads)))
}

/// The rows of subjects, from the seconds that each of their frames took.
fn rows(subjects: &[Subject], times: &[Vec<f64>], samples: u64, threads: &Threads) -> Vec<Row> {
    let shortest = |index: usize| times[index].iter().copied().fold(f64::INFINITY, f64::min);
    let row = |(index, subject): (usize, &Subject)| {
        let seconds = shortest(index);
        let against = |engine| {
            let other = Subject { engine, ..*subject };
            let place = subjects.iter().position(|subject| *subject == other)?;
            Some(shortest(place) / seconds)
        };
        Row {
            engine: subject.engine.name(),
            width: subject.simd.name(),
            threads: threads.pool(subject.all_threads).current_num_threads(),
            milliseconds: 1e3 * seconds,
            nanoseconds: 1e9 * seconds / samples as f64,
            samples_per_second: samples as f64 / seconds,
            spread: spread(&times[index]),
            against_compact: against(Engine::Fixed(PrecisionName::Compact)),
            against_f32: against(Engine::Float),
        }
    };
    subjects.iter().enumerate().map(row).collect()
}

/// Folds a frame; the time that it takes.
fn folded(prepared: &Prepared<'_>, volume: &Oriented<'_>, simd: Simd) -> Result<Duration, RenderError> {
    let mut rendering = prepared.begun()?;
    let start = Instant::now();
    rendering.fold(volume, TILE_ROWS, simd, &|_, _| ());
    Ok(start.elapsed())
}

/// What a frame costs beside its samples.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Beside {
    /// Folding all planes, milliseconds.
    pub fold_milliseconds: f64,
    /// The final warp.
    pub warp_milliseconds: f64,
    /// The warp's share of both.
    pub warp_share: f64,
    /// Compiling the transfer function to a table.
    pub table_milliseconds: f64,
    /// What the engine makes of a new table.
    pub table_decoded_milliseconds: f64,
    /// Finding the blocks that can be seen under it, or that they are too many to be worth it; part of every frame's time.
    pub sight_milliseconds: f64,
    /// Their share, 0 to 1.
    pub seen_share: f64,
    /// Measuring what the blocks hold, once per volume and axis.
    pub occupancy_milliseconds: f64,
    /// Bytes that it takes.
    pub occupancy_bytes: usize,
}

/// Measures what a frame costs beside its samples, on all threads with the widest vectors.
///
/// # Errors
/// [`RenderError`] if the scene does not fit the pipeline.
pub fn beside(scene: &Scene, volume: &Volume, frames: usize, threads: &Threads) -> Result<Beside, RenderError> {
    let prepared = Prepared::new(scene, volume)?;
    let milliseconds = |time: Duration| 1e3 * time.as_secs_f64();
    let mut shortest = [Duration::MAX; 6];
    let (mut share, mut bytes) = (1.0, 0);
    let mut turned = Turned::new(volume, &prepared.setup.plan);
    let slices = &turned.slices()?;
    for _ in 0..frames {
        let start = Instant::now();
        let oriented = threads.pool(true).install(|| Oriented::of(slices));
        let measured = start.elapsed();
        bytes = oriented.occupancy().bytes();
        let frame = || folded_and_warped(&prepared, &oriented);
        let ([fold, warp, sight], seen) = threads.pool(true).install(frame)?;
        share = seen;
        let start = Instant::now();
        let table = black_box(compile(scene, &volume.mapping, prepared.setup.step_length));
        let compiled = start.elapsed();
        let start = Instant::now();
        black_box(table.expanded());
        let decoded = start.elapsed();
        let times = [fold, warp, compiled, decoded, sight, measured];
        for (shortest, time) in shortest.iter_mut().zip(times) {
            *shortest = (*shortest).min(time);
        }
    }
    let [fold, warp, compiled, decoded, sight, measured] = shortest.map(milliseconds);
    Ok(Beside {
        fold_milliseconds: fold,
        warp_milliseconds: warp,
        warp_share: warp / (fold + warp),
        table_milliseconds: compiled,
        table_decoded_milliseconds: decoded,
        sight_milliseconds: sight,
        seen_share: share,
        occupancy_milliseconds: measured,
        occupancy_bytes: bytes,
    })
}

/// Folds a frame and makes its picture; the times that both take, and finding the visible blocks; the share of these.
fn folded_and_warped(prepared: &Prepared<'_>, volume: &Oriented<'_>) -> Result<([Duration; 3], f64), RenderError> {
    let mut rendering = prepared.begun()?;
    let start = Instant::now();
    rendering.fold(volume, TILE_ROWS, prepared.simd, &|_, _| ());
    let fold = start.elapsed();
    let start = Instant::now();
    black_box(rendering.picture(&prepared.shown()));
    let warp = start.elapsed();
    let (looks, support, back_to_front) = (rendering.looks(), rendering.support(), rendering.back_to_front());
    let start = Instant::now();
    black_box(volume.sight(looks, support, back_to_front, prepared.simd));
    let found = start.elapsed();
    let share = support.map_or(1.0, |support| volume.occupancy().share(looks, support));
    Ok(([fold, warp, found], share))
}

#[cfg(test)]
mod tests;
