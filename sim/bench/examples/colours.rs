//! A volume of colours beside the same volume of one value a voxel, unlit and under one light: fog in which nothing can be skipped,
//! classified sample by sample, or voxel by voxel first and sampled linearly, or by splines. Frames take turns on one thread, base plane and picture included, and the shortest
//! of each counts.
//!
//! `cargo run --release -p slicecast-bench --example colours`

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use slicecast_bench::samples;
use slicecast_bench::scenes::{Fog, cube, fog};
use slicecast_colours::{Coloured, TurnedColours};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::Frame;
use slicecast_engine::oriented::{Oriented, Turned};
use slicecast_engine::simd::Simd;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_pyramid::read::of_scalars;
use slicecast_scene::{Interpolation, PrecisionName, Scene};
use slicecast_volume::decoded::Orientation;

/// Frames of each.
const FRAMES: usize = 20;

/// Voxels along a side.
const SIDE: usize = 128;

/// Nanoseconds a sample of one frame.
fn timed(samples: u64, frame: impl FnOnce() -> Result<Frame, RenderError>) -> Result<f64, RenderError> {
    let start = Instant::now();
    black_box(frame()?);
    Ok(1e9 * start.elapsed().as_secs_f64() / samples as f64)
}

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let volume = cube(SIDE);
    println!("fog {SIDE}^3, one thread, shortest of {FRAMES} frames, ns a sample");
    println!("| table | precision | vectors | values | colours | speed | splines |");
    println!("|---|---|---|---|---|---|---|");
    let kinds = [
        (true, 0, "many colours"),
        (false, 0, "one colour"),
        (true, 1, "many colours, lit"),
    ];
    for (colourful, lights, name) in kinds {
        let scene = fog(&volume, Fog { lights, colourful });
        let table: Vec<_> = (0..4096).map(|code| scene.transfer.evaluate(f64::from(code))).collect();
        let classified = of_scalars(&volume, &Orientation::Unknown, &table, 1.0, None).volume;
        for precision in [PrecisionName::Compact, PrecisionName::Wide] {
            let scene = Scene {
                precision,
                ..scene.clone()
            };
            for simd in Simd::available() {
                let values = Prepared::new(&scene, &volume)?.with_simd(simd);
                let colours = Coloured::new(&scene, &classified)?.with_simd(simd);
                let smooth = Scene {
                    interpolation: Interpolation::Quadratic,
                    ..scene.clone()
                };
                let splines = Coloured::new(&smooth, &classified)?.with_simd(simd);
                let (plan, samples) = (&values.setup.plan, samples(&values.setup.plan));
                let (mut turned, mut turned_colours) =
                    (Turned::new(&volume, plan), TurnedColours::new(&classified, plan));
                let (slices, colour_slices) = (turned.slices()?, turned_colours.slices()?);
                let oriented = Oriented::of(&slices);
                let layer = Layer::Tiles(TILE_ROWS);
                let mut best = [f64::INFINITY; 3];
                for _ in 0..FRAMES {
                    let of_values = timed(samples, || values.render_oriented(&oriented, layer, &|_, _| ()))?;
                    let of_colours = timed(samples, || colours.render_slices(&colour_slices, layer, &|_, _| ()))?;
                    let of_splines = timed(samples, || splines.render_slices(&colour_slices, layer, &|_, _| ()))?;
                    let found = [of_values, of_colours, of_splines];
                    best = [0, 1, 2].map(|way| best[way].min(found[way]));
                }
                let [of_values, of_colours, of_splines] = best;
                println!(
                    "| {name} | {} | {} | {of_values:.2} | {of_colours:.2} | {:.2} | {of_splines:.2} |",
                    precision.name(),
                    simd.name(),
                    of_values / of_colours
                );
            }
        }
    }
    Ok(())
}
