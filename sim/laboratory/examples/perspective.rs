//! Perspective in numbers: error against the f64 model, the bits that a ray's direction and its positions need, and speed beside a
//! parallel view.
//!
//! `cargo run --release -p slicecast-laboratory --example perspective`

use std::collections::BTreeSet;
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use slicecast_bench::samples;
use slicecast_bench::scenes::{Fog, cube, fog};
use slicecast_compare::image::{base_figures, model_figures};
use slicecast_compare::perspective::{compare, screen};
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::oriented::Turned;
use slicecast_engine::perspective::{InPerspective, samples as samples_in_perspective};
use slicecast_engine::simd::Simd;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_model::perspective::FromEye;
use slicecast_scene::clip::ClipUnit;
use slicecast_scene::file::built_in;
use slicecast_scene::perspective::{Eye, Perspective};
use slicecast_scene::{Borders, Classification, PrecisionName, Scene};
use slicecast_volume::Volume;
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

/// In perspective, of samples, in a picture of so many pixels.
fn scene_of(scene: Scene, pixels: u32) -> Scene {
    let mut scene = scene;
    scene.borders = Borders::Whole;
    scene.classification = Classification::Point;
    scene.image.size = Some([pixels; 2]);
    scene
}

fn seen(fov: f64, eye: Option<[f64; 3]>) -> Perspective {
    let unit = ClipUnit::Voxels;
    Perspective {
        fov,
        eye: eye.map(|at| Eye { at, unit }),
    }
}

/// The middle of the skull.
const WITHIN: [f64; 3] = [31.3, 28.6, 34.2];

fn main() -> Result<(), Box<dyn Error>> {
    let volume = load(None, Window::Auto)?.volume;
    errors(&volume)?;
    directions(&volume)?;
    positions(&volume)?;
    speeds()
}

fn errors(volume: &Volume) -> Result<(), Box<dyn Error>> {
    println!("## Base planes against the f64 model at exact positions, built-in head, 256 x 256 pixels\n");
    println!("| scene | field of view | eye | frames | precision | equal bytes, % | mean | largest, steps of 255 |");
    println!("|---|---|---|---|---|---|---|---|");
    for name in ["headsq", "ct-fog", "ct-bone"] {
        for (fov, eye) in [(20.0, None), (60.0, None), (60.0, Some(WITHIN)), (120.0, Some(WITHIN))] {
            for precision in PrecisionName::STAGED {
                let mut scene = scene_of(built_in(name)?, 256);
                scene.precision = precision;
                let perspective = seen(fov, eye);
                let prepared = InPerspective::new(&scene, &perspective, volume)?;
                let found = compare(&scene, volume, &prepared, &|_, _| ())?.image;
                println!(
                    "| {name} | {fov} | {} | {} | {} | {:.2} | {:.4} | {:.3} |",
                    if eye.is_some() { "within" } else { "outside" },
                    prepared.facets.len(),
                    precision.name(),
                    found.equal_percent,
                    found.mean_lsb8,
                    found.max_lsb8
                );
            }
        }
    }
    Ok(())
}

/// Squeeze, section 4.6: six bits of a direction do not tell 1024 rays across 60 degrees apart, twelve do.
fn directions(volume: &Volume) -> Result<(), Box<dyn Error>> {
    println!(
        "\n## Bits of a ray's direction: f64 throughout, slopes rounded; 60 degrees, built-in head, scene headsq\n"
    );
    println!(
        "| fraction bits | degrees between directions | directions of 1024 rays in a row | mean error | largest, steps of 255 |"
    );
    println!("|---|---|---|---|---|");
    let scene = scene_of(built_in("headsq")?, 1024);
    let prepared = InPerspective::new(&scene, &seen(60.0, None), volume)?;
    let screens: Vec<_> = prepared.facets.iter().filter_map(screen).collect();
    let exact: Vec<_> = (screens.iter())
        .map(|screen| FromEye::new(&scene, volume, *screen).render())
        .collect();
    for bits in [4, 6, 8, 9, 10, 11, 12, 13, 14, 16] {
        let one = f64::from(bits).exp2();
        // A row of the picture, as an angle from its middle.
        let row = (0..1024).map(|x| (f64::from(x) - 511.5) / 512.0 * 30f64.to_radians().tan());
        let told: BTreeSet<i64> = row.map(|slope| (slope * one).round() as i64).collect();
        let figures: Vec<_> = (screens.iter().zip(&exact))
            .map(|(screen, exact)| {
                let rounded = FromEye::new(&scene, volume, *screen).with_slope_bits(bits).render();
                model_figures(&rounded, exact)
            })
            .collect();
        let figures = slicecast_compare::image::ImageFigures::together(&figures);
        println!(
            "| {bits} | {:.4} | {} | {:.4} | {:.2} |",
            (1.0 / one).atan().to_degrees(),
            told.len(),
            figures.mean_lsb8,
            figures.max_lsb8
        );
    }
    Ok(())
}

/// What is stored of a plane's start and step, and of what both grow by from plane to plane.
fn positions(volume: &Volume) -> Result<(), Box<dyn Error>> {
    println!(
        "\n## Bits of positions: `wide`, `Spread::with_step_bits`; 60 degrees, built-in head, scene headsq, four rays a voxel\n"
    );
    println!("| fraction bits | mean error | largest, steps of 255 |");
    println!("|---|---|---|");
    let mut scene = scene_of(built_in("headsq")?, 256);
    scene.precision = PrecisionName::Wide;
    scene.sampling.rays_per_voxel = 4;
    let perspective = seen(60.0, None);
    let prepared = InPerspective::new(&scene, &perspective, volume)?;
    let models: Vec<_> = (prepared.facets.iter().filter_map(screen))
        .map(|screen| FromEye::new(&scene, volume, screen).render())
        .collect();
    for bits in [10, 12, 14, 16, 18, 20, 22, 24, 28, 32, 44] {
        let mut rounded = prepared.clone();
        for facet in &mut rounded.facets {
            let setup = &mut facet.prepared.setup;
            setup.spread = setup.spread.map(|spread| spread.with_step_bits(bits));
        }
        let bases = rounded.bases(Layer::Tiles(TILE_ROWS), &|_, _| ())?;
        let figures: Vec<_> = (bases.iter().zip(&models))
            .map(|(base, model)| base_figures(base, model))
            .collect();
        let figures = slicecast_compare::image::ImageFigures::together(&figures);
        println!("| {bits} | {:.4} | {:.3} |", figures.mean_lsb8, figures.max_lsb8);
    }
    Ok(())
}

/// Frames of each.
const FRAMES: usize = 10;

fn speeds() -> Result<(), Box<dyn Error>> {
    println!(
        "\n## Speed: fog of 128^3, nothing skipped, one thread, base planes, shortest of {FRAMES} frames in turn, ns a sample\n"
    );
    println!("| light | precision | vectors | parallel | 40 degrees | 90 degrees | speed at 40 |");
    println!("|---|---|---|---|---|---|---|");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let volume = cube(128);
    for lights in [0, 1] {
        for precision in [PrecisionName::Compact, PrecisionName::Wide] {
            let own = Fog {
                lights,
                colourful: true,
            };
            let mut parallel = scene_of(fog(&volume, own), 256);
            parallel.precision = precision;
            let views = [40.0, 90.0].map(|fov| seen(fov, None));
            for simd in Simd::available() {
                let reference = Prepared::new(&parallel, &volume)?.with_simd(simd);
                let [narrow, broad] = views
                    .each_ref()
                    .map(|view| InPerspective::new(&parallel, view, &volume).map(|prepared| prepared.with_simd(simd)));
                let views = [narrow?, broad?];
                let mut best = [f64::INFINITY; 3];
                let timed = |best: &mut f64, samples: u64, start: Instant| {
                    *best = best.min(1e9 * start.elapsed().as_secs_f64() / samples as f64);
                };
                pool.install(|| -> Result<(), Box<dyn Error + Send + Sync>> {
                    let all = samples(&reference.setup.plan);
                    for _ in 0..FRAMES {
                        let mut turned = Turned::new(&volume, &reference.setup.plan);
                        let slices = turned.slices()?;
                        let mut rendering = reference.begun()?;
                        let start = Instant::now();
                        rendering.fold_rows(&slices, TILE_ROWS, simd, &|_, _| ());
                        timed(&mut best[0], all, start);
                        black_box(rendering.base());
                        for (view, best) in views.iter().zip(&mut best[1..]) {
                            let (mut spent, mut made) = (0.0, 0);
                            for facet in &view.facets {
                                let plan = &facet.prepared.setup.plan;
                                let mut turned = Turned::new(&volume, plan);
                                let slices = turned.slices()?;
                                let mut rendering = facet.prepared.begun()?;
                                let start = Instant::now();
                                rendering.fold_rows(&slices, TILE_ROWS, simd, &|_, _| ());
                                spent += start.elapsed().as_secs_f64();
                                made += facet.spread().map_or(0, |spread| samples_in_perspective(plan, spread));
                                black_box(rendering.base());
                            }
                            *best = best.min(1e9 * spent / made as f64);
                        }
                    }
                    Ok(())
                })
                .map_err(|error| error.to_string())?;
                println!(
                    "| {} | {} | {} | {:.2} | {:.2} | {:.2} | {:.2} |",
                    if lights > 0 { "lit" } else { "unlit" },
                    precision.name(),
                    simd.name(),
                    best[0],
                    best[1],
                    best[2],
                    best[0] / best[1]
                );
            }
        }
    }
    Ok(())
}
