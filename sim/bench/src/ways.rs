//! Ways to a picture against each other: rays and splats, parallel and in perspective, of one size.
//!
//! What is timed is a whole frame from the voxels: folding and warp of rays, whose slices and blocks are measured before; blocks, bins,
//! sheets and picture of splats. All take turns; each keeps its shortest time.

use std::hint::black_box;
use std::time::Instant;

use serde::Serialize;
use slicecast::splat::Layout;
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::oriented::{Oriented, Turned};
use slicecast_engine::perspective::{InPerspective, samples as samples_in_perspective};
use slicecast_engine::tile::TILE_ROWS;
use slicecast_scene::perspective::Perspective;
use slicecast_scene::{Borders, Classification, Scene};
use slicecast_splat::{BAND_ROWS, Splatted};
use slicecast_volume::Volume;

use crate::spread::spread;
use crate::{Threads, samples};

/// The field of view of frames in perspective, degrees, the whole volume within.
pub const FOV: f64 = 40.0;

/// Seconds from which on a frame of splats is timed once: of a large volume it takes a minute.
const PATIENCE: f64 = 2.0;

/// A way's result.
#[derive(Clone, Debug, Serialize)]
pub struct WayRow {
    /// How the picture is made.
    pub way: &'static str,
    /// Number of threads.
    pub threads: usize,
    /// The shortest time of a frame.
    pub milliseconds: f64,
    /// How far the times of the frames scatter, as in [`Row::spread`](crate::Row::spread).
    pub spread: Option<f64>,
    /// Samples of rays, or records of splats.
    pub count: u64,
    /// How many times as long as parallel rays.
    pub against_rays: f64,
}

/// Measures pictures of one size, `compact` with the widest vectors, in samples with whole borders: the shortest of `frames` frames
/// each, but for splats that take more than two seconds.
///
/// # Errors
/// [`RenderError`] if the scene does not fit a way.
pub fn measure_ways(
    scene: &Scene,
    volume: &Volume,
    frames: usize,
    (threads, all): (&Threads, bool),
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Vec<WayRow>, RenderError> {
    let mut parallel = Scene {
        borders: Borders::Whole,
        classification: Classification::Point,
        perspective: None,
        ..scene.clone()
    };
    let prepared = Prepared::new(&parallel, volume)?;
    let size = prepared.setup.picture.size;
    parallel.image.size = Some(size);
    let prepared = Prepared::new(&parallel, volume)?;
    let seen = Perspective { fov: FOV, eye: None };
    let spreading = Scene {
        perspective: Some(seen),
        ..parallel.clone()
    };
    let in_perspective = InPerspective::new(&spreading, &seen, volume)?;
    let splatted = [&parallel, &spreading].map(|scene| Splatted::new(scene, volume, Layout::FINE));
    let [splatted, splatted_in_perspective] = splatted;
    let splatted = [splatted?, splatted_in_perspective?];
    let mut turned = Turned::new(volume, &prepared.setup.plan);
    let slices = turned.slices()?;
    let oriented = Oriented::of(&slices);
    let facets = || in_perspective.facets.iter();
    let mut turned: Vec<Turned<'_>> = facets()
        .map(|facet| Turned::new(volume, &facet.prepared.setup.plan))
        .collect();
    let slices = turned.iter_mut().map(Turned::slices).collect::<Result<Vec<_>, _>>()?;
    let volumes: Vec<_> = slices.iter().map(|slices| Oriented::of(slices)).collect();
    let spread_samples = facets().filter_map(|facet| {
        let spread = facet.spread()?;
        Some(samples_in_perspective(&facet.prepared.setup.plan, spread))
    });
    let mut counts = [samples(&prepared.setup.plan), spread_samples.sum(), 0, 0];
    let mut times = [(); 4].map(|()| Vec::with_capacity(frames));
    let pool = threads.pool(all);
    for round in 0..frames {
        let start = Instant::now();
        black_box(pool.install(|| prepared.render_oriented(&oriented, Layer::Tiles(TILE_ROWS), &|_, _| ()))?);
        times[0].push(start.elapsed().as_secs_f64());
        let start = Instant::now();
        let bases = pool.install(|| {
            let base = |(facet, volume): (&slicecast_engine::perspective::Facet<'_>, &Oriented<'_>)| {
                let mut rendering = facet.prepared.begun()?;
                rendering.fold(volume, TILE_ROWS, facet.prepared.simd, &|_, _| ());
                Ok::<_, RenderError>(rendering.base())
            };
            let bases = facets().zip(&volumes).map(base).collect::<Result<Vec<_>, _>>()?;
            Ok::<_, RenderError>(in_perspective.frame(&bases))
        });
        black_box(bases?);
        times[1].push(start.elapsed().as_secs_f64());
        let ways = splatted.iter().zip(times.iter_mut().zip(&mut counts).skip(2));
        for (splatted, (times, count)) in ways {
            if times.first().is_some_and(|first| *first > PATIENCE) {
                continue;
            }
            let start = Instant::now();
            let (frame, records) = pool.install(|| {
                let records = splatted.records(true, BAND_ROWS)?;
                let base = splatted.image(&records, &|_, _| ())?;
                Ok::<_, RenderError>((splatted.frame(base), records.count()))
            })?;
            black_box(frame);
            times.push(start.elapsed().as_secs_f64());
            *count = records as u64;
        }
        progress(round + 1, frames);
    }
    let shortest = times
        .each_ref()
        .map(|times| times.iter().copied().fold(f64::INFINITY, f64::min));
    let names = [
        "rays, parallel",
        "rays, in perspective",
        "splats, parallel",
        "splats, in perspective",
    ];
    let row = |number: usize| WayRow {
        way: names[number],
        threads: pool.current_num_threads(),
        milliseconds: 1e3 * shortest[number],
        spread: spread(&times[number]),
        count: counts[number],
        against_rays: shortest[number] / shortest[0],
    };
    Ok([0, 1, 2, 3].map(row).to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::{Fog, cube, fog};

    /// All four ways see the fog, and each is measured once.
    #[test]
    fn all_ways_are_measured() {
        let volume = cube(16);
        for lights in [0, 1] {
            let own = Fog {
                lights,
                colourful: true,
            };
            let threads = Threads::start(Some(1)).unwrap();
            let rows = measure_ways(&fog(&volume, own), &volume, 2, (&threads, false), &|_, _| ()).unwrap();
            assert_eq!(rows.len(), 4);
            assert_eq!(rows[0].against_rays, 1.0);
            for row in rows {
                assert!(row.count > 1000, "{row:?}");
                assert!(row.milliseconds > 0.0 && row.threads == 1);
            }
        }
    }
}
