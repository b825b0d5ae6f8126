//! Frames of the `fast` precision and nothing else, for a profiler: fog in which nothing can be skipped, on one thread.
//!
//! `cargo build --profile profiling -p slicecast-bench --example fast`, then
//! `perf record -F 4000 -e cpu-clock -o fast.data target/profiling/examples/fast [LIGHTS [VECTORS [SIDE [FRAMES]]]]` and
//! `host-tests/peers/stages.py fast.data`. Without arguments: 1 light, the widest vectors, 256 voxels along a side, 60 frames.

use std::error::Error;

use slicecast_bench::scenes::{Fog, SIDES, cube, fog};
use slicecast_bench::{Engine, Subject, Threads, measure};
use slicecast_engine::simd::Simd;
use slicecast_scene::PrecisionName;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |place: usize, otherwise: usize| arguments.get(place).map_or(Ok(otherwise), |given| given.parse());
    let (lights, side, frames) = (number(0, 1)?, number(2, 256)?, number(3, 60)?);
    if lights > 8 || !SIDES.contains(&side) || frames == 0 {
        return Err("expected 0 to 8 lights, a side of 16 to 1024 voxels, and a frame".into());
    }
    let simd = match arguments.get(1) {
        None => Simd::widest(),
        Some(name) => (Simd::available().find(|simd| simd.name() == name)).ok_or("no such vectors here")?,
    };
    let volume = cube(side);
    let scene = fog(
        &volume,
        Fog {
            lights,
            colourful: false,
        },
    );
    let subject = Subject {
        engine: Engine::Fixed(PrecisionName::Fast),
        simd,
        all_threads: false,
    };
    let threads = Threads::start(Some(1))?;
    let (_, rows) = measure(&scene, &volume, &[subject], frames, &threads, &|_, _| ())?;
    for row in rows {
        println!(
            "fog {side}^3, {lights} light(s), {}: {:.3} ns a sample",
            row.width, row.nanoseconds
        );
    }
    Ok(())
}
