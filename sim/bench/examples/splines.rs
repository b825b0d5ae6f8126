//! Samples and gradients by splines beside linear ones. Error: Marschner and Lobb's signal, of which the value and the gradient are known at
//! every place, from 12-bit voxels in f64, and frames against the f64 model. Cost: fog in which nothing can be skipped, whole frames that
//! take turns on one thread, the shortest of each.
//!
//! `cargo run --release -p slicecast-bench --example splines`

use std::error::Error;
use std::f64::consts::PI;
use std::hint::black_box;
use std::time::Instant;

use slicecast_bench::samples;
use slicecast_bench::scenes::{Fog, cube, fog};
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::oriented::{Oriented, Turned};
use slicecast_engine::simd::Simd;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_model::grid::Grid;
use slicecast_model::{Geometry, gradient, interpolate, spline};
use slicecast_scene::{Interpolation, PrecisionName, Sampling, Scene};
use slicecast_volume::{Mapping, Volume};

/// Frames of each.
const FRAMES: usize = 20;

/// Places along a side, at which errors are taken.
const PLACES: usize = 97;

/// A unit of the signal, codes.
const UNIT: f64 = 4095.0;

/// Marschner and Lobb's signal with f_M = 6 and alpha = 1/4, from -1 to 1 along each axis: its value and its gradient.
fn signal([x, y, z]: [f64; 3]) -> (f64, [f64; 3]) {
    let radius = x.hypot(y);
    let angle = 12.0 * PI * (PI * radius / 2.0).cos();
    let value = (1.0 - (PI * z / 2.0).sin() + 0.25 * (1.0 + angle.cos())) / 2.5;
    // d angle / d radius, over the radius, which is 0 at 0.
    let along = 12.0 * PI * -(PI / 2.0) * (PI * radius / 2.0).sin() / radius.max(1e-12);
    let rho = 0.25 * -angle.sin() * along / 2.5;
    (value, [rho * x, rho * y, -(PI / 2.0) * (PI * z / 2.0).cos() / 2.5])
}

/// The signal in voxels.
fn volume(side: usize) -> Volume {
    let place = |index: usize| 2.0 * index as f64 / (side as f64 - 1.0) - 1.0;
    let places = (0..side).flat_map(|z| (0..side).flat_map(move |y| (0..side).map(move |x| [x, y, z])));
    let code = |at: [usize; 3]| (UNIT * signal(at.map(place)).0).round() as u16;
    Volume {
        name: format!("Marschner-Lobb {side}^3"),
        dims: [side; 3],
        spacing: [1.0; 3],
        voxels: places.map(code).collect(),
        mapping: Mapping {
            scale: 1.0,
            offset: 0.0,
        },
    }
}

/// Root of the mean of squares, and the largest.
fn summed(errors: &[f64]) -> [f64; 2] {
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    let largest = errors.iter().copied().fold(0.0, f64::max);
    [(squares / errors.len() as f64).sqrt(), largest]
}

/// Degrees between two vectors.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|axis| a[axis] * b[axis]).sum::<f64>();
    (dot(a, b) / (dot(a, a) * dot(b, b)).sqrt())
        .clamp(-1.0, 1.0)
        .acos()
        .to_degrees()
}

/// Errors of samples and gradients between the voxels of the signal.
fn errors() {
    println!("Marschner-Lobb, f64 of 12-bit voxels, {PLACES}^3 places: root mean square and largest error\n");
    println!(
        "| voxels | value, linear | value, splines | normal, linear | normal, the spline's | normal, differences of splines |"
    );
    println!("|---|---|---|---|---|---|");
    for side in [41, 64, 128] {
        let volume = volume(side);
        let sampling = Sampling {
            planes_per_voxel: 1,
            rays_per_voxel: 1,
        };
        let geometry = Geometry::new([0.0, 0.0, 1.0], volume.dims, volume.spacing, sampling);
        let grid = Grid::new(&volume, &geometry);
        let mut found = [(); 5].map(|()| Vec::new());
        // Two voxels and more from the faces, which the signal does not have.
        let step = (side as f64 - 5.0) / (PLACES as f64 - 1.0);
        for at in (0..PLACES * PLACES * PLACES).map(|n| [n % PLACES, n / PLACES % PLACES, n / PLACES / PLACES]) {
            let at = at.map(|index| 2.0 + step * index as f64);
            let (value, slope) = signal(at.map(|c| 2.0 * c / (side as f64 - 1.0) - 1.0));
            let beside = |axis: usize, by: f64| {
                spline::value_at(&grid, [0, 1, 2].map(|a| at[a] + if a == axis { by } else { 0.0 }))
            };
            let differences = [0, 1, 2].map(|axis| beside(axis, 1.0) - beside(axis, -1.0));
            let errors = [
                (interpolate::value_at(&grid, at) / UNIT - value).abs(),
                (spline::value_at(&grid, at) / UNIT - value).abs(),
                angle(gradient::difference_at(&grid, at), slope),
                angle(spline::difference_at(&grid, at), slope),
                angle(differences, slope),
            ];
            found
                .iter_mut()
                .zip(errors)
                .for_each(|(found, error)| found.push(error));
        }
        let [linear, smooth, of_linear, of_spline, of_samples] = found.map(|errors| summed(&errors));
        let values = [linear, smooth].map(|[mean, largest]| format!("{mean:.4}, {largest:.4}"));
        let normals = [of_linear, of_spline, of_samples].map(|[mean, largest]| format!("{mean:.2}°, {largest:.1}°"));
        println!("| {side}³ | {} | {} |", values.join(" | "), normals.join(" | "));
    }
}

/// Nanoseconds a sample of frames.
fn cost() -> Result<(), Box<dyn Error>> {
    let volume = cube(128);
    println!("\nfog 128^3, one thread, shortest of {FRAMES} frames, ns a sample\n");
    println!("| table | precision | vectors | linear | splines | ratio |");
    println!("|---|---|---|---|---|---|");
    for (lights, name) in [(0, "unlit"), (1, "lit")] {
        let colourful = false;
        let scene = fog(&volume, Fog { lights, colourful });
        for precision in PrecisionName::STAGED {
            for simd in Simd::available() {
                let [linear, smooth] = [Interpolation::Linear, Interpolation::Quadratic].map(|interpolation| Scene {
                    precision,
                    interpolation,
                    ..scene.clone()
                });
                let ways = [Prepared::new(&linear, &volume)?, Prepared::new(&smooth, &volume)?];
                let ways = ways.map(|way| way.with_simd(simd));
                let plan = &ways[0].setup.plan;
                let mut turned = Turned::new(&volume, plan);
                let slices = turned.slices()?;
                let (oriented, count) = (Oriented::of(&slices), samples(plan));
                let mut best = [f64::INFINITY; 2];
                for _ in 0..FRAMES {
                    for (way, best) in ways.iter().zip(&mut best) {
                        let start = Instant::now();
                        black_box(way.render_oriented(&oriented, Layer::Tiles(TILE_ROWS), &|_, _| ())?);
                        *best = best.min(1e9 * start.elapsed().as_secs_f64() / count as f64);
                    }
                }
                let [linear, smooth] = best;
                println!(
                    "| {name} | {} | {} | {linear:.2} | {smooth:.2} | {:.2} |",
                    precision.name(),
                    simd.name(),
                    smooth / linear
                );
            }
        }
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    errors();
    cost()
}
